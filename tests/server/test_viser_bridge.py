"""The canvas bridge: a contract with the pinned viser, and the door in front of it."""

import asyncio
import re
from pathlib import Path

import msgspec
import psutil
import pytest
import viser
import websockets.asyncio.server
from fastapi.testclient import TestClient
from starlette.testclient import WebSocketDenialResponse
from starlette.websockets import WebSocketDisconnect

from walking_console.server.limits import CANVAS_BURST, CANVAS_FRAME_MAX
from walking_console.server.viser_bridge import (
    SUBPROTOCOL,
    ViserBridge,
    clean_query,
    client_page,
    may_pass,
    viser_without_socket,
)

HERE = "http://127.0.0.1:8000"
OWN = {"origin": HERE}
AT = "ws://127.0.0.1:8000"
PACK = msgspec.msgpack.encode

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [1.0, 2.0, 3.0],
    "fov": 0.8,
    "near": 0.1,
    "far": 100.0,
    "image_height": 600,
    "image_width": 800,
    "look_at": [0.0, 0.0, 0.0],
    "up_direction": [0.0, 0.0, 1.0],
}


# the contract with viser


def test_viser_starts_without_a_socket_and_leaves_the_library_as_it_was(
    capsys: pytest.CaptureFixture[str],
) -> None:
    opener = websockets.asyncio.server.serve
    before = {
        (c.laddr, c.status)
        for c in psutil.Process().net_connections()
        if c.status == psutil.CONN_LISTEN
    }
    server, handler = viser_without_socket()
    try:
        after = {
            (c.laddr, c.status)
            for c in psutil.Process().net_connections()
            if c.status == psutil.CONN_LISTEN
        }
        assert after == before
        assert websockets.asyncio.server.serve is opener
        assert asyncio.iscoroutinefunction(handler)
        assert capsys.readouterr().out == "", "the banner would be a second address"
    finally:
        server.stop()


def test_the_client_is_the_one_file_we_know_and_takes_our_nonce(bridge: ViserBridge) -> None:
    assert viser.__version__.startswith("1.1.")
    assert bridge.nonced, (
        "the loader of viser's client has changed: read it again, then change LOADER_MARK"
    )
    page = bridge.page.decode()
    assert len(page) > len(client_page())
    scripts = re.findall(r"<script[^>]{0,200}", page)
    assert len(scripts) == 2 and all(f'nonce="{bridge.nonce}"' in script for script in scripts)


def test_the_client_decides_by_focus_whether_to_reconnect() -> None:
    source = Path(viser.__file__).parent / "client" / "src" / "WebsocketInterface.tsx"
    assert "document.hasFocus()" in source.read_text("utf-8"), "the injected script leans on this"


def test_the_stream_carries_viser_s_frames_down_and_a_camera_up(
    viewing: TestClient, bridge: ViserBridge
) -> None:
    bridge.server.scene.add_frame("/here")
    joined: list[int] = []
    bridge.server.on_client_connect(lambda client: joined.append(client.client_id))
    with viewing.websocket_connect(
        f"{AT}/view", subprotocols=[SUBPROTOCOL], headers=dict(OWN)
    ) as socket:
        assert socket.accepted_subprotocol == SUBPROTOCOL
        frame = socket.receive_bytes()
        assert int.from_bytes(frame[:8], "little") > 0 and bridge.clients == 1
        socket.send_bytes(PACK(CAMERA))
        bridge.server.scene.add_frame("/there")
        bridge.server.flush()
        while not joined:
            socket.receive_bytes()
            bridge.server.flush()
            bridge.server.scene.add_frame(f"/{len(joined)}")
    assert bridge.server.get_event_loop().is_running()


def test_a_closed_page_leaves_nothing_behind(viewing: TestClient, bridge: ViserBridge) -> None:
    for _ in range(5):
        with viewing.websocket_connect(
            f"{AT}/view/", subprotocols=[SUBPROTOCOL], headers=dict(OWN)
        ) as socket:
            socket.receive_bytes()
    assert bridge.clients == 0
    loop, left = bridge.server.get_event_loop(), bridge.server._websock_server._client_state_from_id
    for _ in range(1000):  # viser's own thread clears up a few turns of its loop later
        asyncio.run_coroutine_threadsafe(asyncio.sleep(0.001 if left else 0.0), loop).result(5.0)
    assert not left


# the door


@pytest.mark.parametrize("protocols", [[], ["viser-v0.0.1"], ["chat"]])
def test_another_protocol_is_refused(viewing: TestClient, protocols: list[str]) -> None:
    with pytest.raises(WebSocketDenialResponse) as caught:
        viewing.websocket_connect(
            f"{AT}/view", subprotocols=protocols, headers=dict(OWN)
        ).__enter__()
    assert caught.value.status_code == 400


HARMLESS = [
    CAMERA,
    {"type": "GuiUpdateMessage", "uuid": "a", "updates": {"value": True}},
    {
        "type": "SceneNodeClickMessage", "name": "/ground", "instance_index": None,
        "ray_origin": [0.0, 0.0, 1.0],
        "ray_direction": [0.0, 0.0, -1.0], "screen_pos": [0.5, 0.5], "modifier": None, "owner": "",
    },
]  # fmt: skip
HARMFUL = [
    {"type": "ShareUrlRequest"},
    {"type": "ShareUrlDisconnect"},
    {"type": "GuiUpdateMessage", "uuid": "a", "updates": {"value": 1, "removed": True}},
    {"type": "GuiUpdateMessage", "uuid": "a", "updates": {"update_cb": []}},
    {"type": "GuiUpdateMessage", "uuid": "a", "updates": {}},
    {"type": "GuiUpdateMessage", "uuid": ["a"], "updates": {"value": 1}},
    {"type": "GuiUpdateMessage", "uuid": "a", "updates": ["value"]},
    {"type": "FileTransferStartUpload", "source_component_uuid": "a", "transfer_uuid": "b",
     "filename": "c", "mime_type": "d", "part_count": 1, "size_bytes": 10**9},
    {"type": "RunJavascriptMessage", "source": "alert(1)"},
    {"type": "GuiFormSubmitMessage", "uuid": "a"},
    {"type": "NoSuchMessage"},
    {"type": "ViewerCameraMessage"},
    {**CAMERA, "fov": "wide"},
    {"no": "type"},
    [1, 2, 3],
]  # fmt: skip


@pytest.mark.parametrize("message", HARMLESS, ids=lambda message: message["type"])
def test_what_a_viewer_says_passes(message: object) -> None:
    assert may_pass(PACK(message))


def test_of_one_that_only_watches_its_camera_and_its_own_switches_pass() -> None:
    passed = [message["type"] for message in HARMLESS if may_pass(PACK(message), watches=True)]
    assert set(passed) == {"ViewerCameraMessage", "GuiUpdateMessage"}


@pytest.mark.parametrize("message", HARMFUL, ids=lambda message: str(message)[:50])
def test_what_no_viewer_says_does_not(message: object) -> None:
    assert not may_pass(PACK(message))


@pytest.mark.parametrize(
    "frame",
    [
        b"",
        b"\xc1",
        b"\x91" * 20_000,
        b"\x91" * 10_000,
        b"\xff" * 100,
        b"x" * (CANVAS_FRAME_MAX + 1),
    ],
)
def test_what_is_no_message_does_not(frame: bytes) -> None:
    assert not may_pass(frame)


def test_a_share_request_never_reaches_viser(
    viewing: TestClient, bridge: ViserBridge, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[object] = []
    monkeypatch.setattr(bridge.server, "request_share_url", lambda: asked.append(1))
    before = bridge.dropped
    with viewing.websocket_connect(
        f"{AT}/view", subprotocols=[SUBPROTOCOL], headers=dict(OWN)
    ) as socket:
        socket.send_bytes(PACK({"type": "ShareUrlRequest"}))
        socket.send_bytes(PACK(CAMERA))
        socket.receive_bytes()
    assert bridge.dropped == before + 1 and not asked


@pytest.mark.parametrize("flood", [True, False])
def test_a_flood_and_a_text_frame_close_the_canvas(viewing: TestClient, flood: bool) -> None:
    with viewing.websocket_connect(
        f"{AT}/view", subprotocols=[SUBPROTOCOL], headers=dict(OWN)
    ) as socket:
        if flood:
            for _ in range(int(CANVAS_BURST * 2)):
                socket.send_bytes(b"\xc1")
        else:
            socket.send_text("hello")
        with pytest.raises(WebSocketDisconnect) as caught:
            while True:
                socket.receive_bytes()
    assert caught.value.code == (1008 if flood else 1003)


@pytest.mark.parametrize(
    ("query", "cleaned"),
    [
        ("", None),
        ("darkMode", None),
        ("websocket=ws://evil", ""),
        ("darkMode=1&websocket=ws://evil&playbackPath=x", "darkMode=1"),
        ("%77ebsocket=ws://evil", ""),
        ("anything=1", ""),
    ],
)
def test_query_keys_that_could_run_a_foreign_script_are_taken_away(
    query: str, cleaned: str | None
) -> None:
    assert clean_query(query) == cleaned
