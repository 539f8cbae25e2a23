"""The /drive WebSocket in process: lease, refusals, snapshots, and what a hostile client may
send.
"""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from fastapi.testclient import TestClient
from starlette.testclient import WebSocketDenialResponse, WebSocketTestSession
from starlette.websockets import WebSocketDisconnect

from walking_console.planner.robot.model import load_machine
from walking_console.server import show_pace
from walking_console.server.api import drive_socket
from walking_console.server.limits import DRIVE_FRAME_MAX, DRIVERS_MAX
from walking_console.server.realtime_loop import RealtimeLoop
from walking_console.server.show_pace import ShowPace
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.world import prepare
from walking_console.web.scene.palette import style_of

HERE = {"origin": "http://127.0.0.1:8000"}


AT = "ws://127.0.0.1:8000"  # the test client ignores its base URL for WebSockets


class Page:
    """One page: its socket, its name, and what it was told."""

    def __init__(self, socket: WebSocketTestSession) -> None:
        self.socket = socket
        self.hello = socket.receive_json()
        self.seq = 0

    @property
    def name(self) -> str:
        return str(self.hello["lease_id"])

    def told(self, kind: str) -> dict[str, Any]:
        """The next frame of this kind; others are passed over."""
        while True:
            frame: dict[str, Any] = self.socket.receive_json()
            if frame["type"] == kind:
                return frame

    def press(self, speed: float = 0.08, echo: int = 0, **keys: Any) -> None:
        self.seq += 1
        stick = {"crab_angle_rad": 0.0, "speed_m_s": speed, "turn_rate_rad_s": 0.0}
        self.socket.send_json(
            {"type": "drive", "seq": self.seq, "echo_tick": echo, **stick, **keys}
        )

    def refusal(self) -> str:
        return str(self.told("refused")["reason"])


@contextmanager
def page(client: TestClient) -> Iterator[Page]:
    with client.websocket_connect(f"{AT}/drive", headers=dict(HERE)) as socket:
        yield Page(socket)


def ended(socket: WebSocketTestSession) -> int:
    """The close code, whatever came before it."""
    with pytest.raises(WebSocketDisconnect) as caught:
        while True:
            socket.receive_json()
    return caught.value.code


def test_a_ping_is_answered_with_what_it_said_and_how_long_it_was_kept(client: TestClient) -> None:
    with page(client) as one:
        one.socket.send_json({"type": "ping", "sent_ms": 8120.5})
        pong = one.told("pong")
        assert pong["sent_ms"] == 8120.5 and 0.0 <= pong["kept_ms"] < 5000.0


def test_a_page_is_greeted_told_who_drives_and_shown_the_world(client: TestClient) -> None:
    with page(client) as one:
        assert one.hello["dead_man_s"] == 0.5 and one.hello["tick_s"] == 0.02
        assert one.told("lease") == {
            "type": "lease",
            "held": False,
            "holder": None,
            "holder_title": None,
            "stopped": False,
        }
        assert one.told("snapshot") == client.get("/api/v1/console").json()


def test_pressing_the_stick_takes_the_lease_and_moves_the_machine(
    client: TestClient, loop: RealtimeLoop
) -> None:
    with page(client) as one:
        one.told("snapshot")
        one.press()
        lease = one.told("lease")
        assert lease["held"] and lease["holder"] == one.name
        loop.tick()
        assert one.told("snapshot")["speed_m_s"] == 0.08


def test_the_type_of_a_drive_frame_may_be_left_out(client: TestClient, loop: RealtimeLoop) -> None:
    with page(client) as one:
        frame = {
            "seq": 1,
            "echo_tick": 0,
            "crab_angle_rad": 0.0,
            "speed_m_s": 0.05,
            "turn_rate_rad_s": 0.0,
        }
        one.told("lease")
        one.socket.send_json(frame)
        assert one.told("lease")["held"]
        loop.tick()
        assert loop.newest.command.speed == 0.05


def test_a_posture_frame_takes_the_lease_and_the_posture(
    client: TestClient, loop: RealtimeLoop
) -> None:
    with page(client) as one, page(client) as two:
        one.told("snapshot")
        one.socket.send_json({"type": "posture", "seq": 1, "echo_tick": 0, "posture": "sit"})
        assert one.told("lease")["held"]
        for _ in range(20):
            loop.tick()
        assert loop.newest.mode.name == "SIT_DOWN"
        two.socket.send_json(
            {"type": "posture", "seq": 1, "echo_tick": loop.newest.tick, "posture": "stand"}
        )
        assert two.refusal() == "another page is driving"
        two.socket.send_json(
            {"type": "posture", "seq": 2, "echo_tick": loop.newest.tick, "posture": "lie"}
        )
        assert "posture" in two.refusal()
        for _ in range(60):
            loop.tick()
        assert loop.newest.mode.name == "SIT"


def test_a_second_page_views_and_is_told_who_drives(client: TestClient) -> None:
    with page(client) as one, page(client) as two:
        assert two.told("lease")["holder"] is None
        one.press()
        assert two.told("lease") == {
            "type": "lease",
            "held": False,
            "holder": one.name,
            "holder_title": "another page",
            "stopped": False,
        }
        two.press()
        assert two.refusal() == "another page is driving"


def test_closing_the_page_holds(client: TestClient, loop: RealtimeLoop) -> None:
    with page(client) as watching:
        with page(client) as one:
            one.press()
            while watching.told("lease")["holder"] != one.name:
                pass
            loop.tick()
            assert not loop.newest.command.holds
        while watching.told("lease")["holder"] is not None:
            pass
        loop.tick()
        assert loop.newest.command.holds


def test_a_stop_from_a_viewer_is_said_to_everybody_and_stays(
    client: TestClient, loop: RealtimeLoop
) -> None:
    with page(client) as one, page(client) as two:
        one.press()
        one.told("lease")
        two.socket.send_json({"type": "stop"})
        while not one.told("lease")["stopped"]:
            pass
        loop.tick()
        assert loop.newest.command.holds
        one.press()
        assert "stopped" in one.refusal()
        one.press(speed=0.0)
        one.socket.send_json({"type": "rearm"})
        while one.told("lease")["stopped"]:
            pass


STICK = '{"seq": 5, "echo_tick": 0, "crab_angle_rad": 0.0, "speed_m_s": %s, "turn_rate_rad_s": 0.0}'


BAD: list[tuple[str, str]] = [
    ('{"seq": 1', "not a JSON object"),
    ("[]", "not a JSON object"),
    ('"stop"', "not a JSON object"),
    ("[" * 4000, "not a JSON object"),
    ('{"type": "fly"}', "unknown type"),
    ('{"type": ["stop"]}', "unknown type"),
    ('{"type": "stop", "really": true}', "really"),
    ('{"type": "stop", "type": "stop"}', "twice"),
]
BAD += [
    (STICK % word, "speed_m_s")
    for word in ("1e400", "true", '"0.1"', "null", "9.0", "-0.1", "[0.1]", '{"a": 1}')
]
BAD += [(STICK % word, "not a number") for word in ("NaN", "Infinity", "-Infinity")]
BAD += [
    (
        (STICK % "0.0").replace('"seq": 5', '"seq": 1.5'),
        "seq",
    )
]
BAD += [
    ('{"seq": 1, "crab_angle_rad": 0.0, "speed_m_s": 0.1, "turn_rate_rad_s": 0.0}', "echo_tick")
]


@pytest.mark.parametrize(("text", "reason"), BAD, ids=lambda text: str(text)[:40])
def test_what_is_no_frame_is_refused_with_a_reason_and_moves_nothing(
    client: TestClient, loop: RealtimeLoop, text: str, reason: str
) -> None:
    with page(client) as one:
        one.socket.send_text(text)
        assert reason in one.refusal()
        loop.tick()
        assert loop.newest.command.holds and client.get("/api/v1/health").json()["holder"] is None


def test_a_bad_frame_does_not_extend_the_command_before_it(
    client: TestClient, loop: RealtimeLoop
) -> None:
    with page(client) as one:
        one.press()
        one.told("lease")
        for _ in range(24):
            loop.tick()
        one.socket.send_text(STICK % "NaN")
        one.refusal()
        for _ in range(2):
            loop.tick()
        assert loop.newest.command.holds


def test_a_refusal_names_the_frame_it_refuses(client: TestClient) -> None:
    with page(client) as one:
        one.press(speed=9.0)
        assert one.told("refused")["seq"] == 1


@pytest.mark.parametrize(("frame", "code"), [(b"\x00\x01", 1003), (b"{}", 1003)])
def test_binary_frames_close_the_socket(client: TestClient, frame: bytes, code: int) -> None:
    with page(client) as one:
        one.socket.send_bytes(frame)
        assert ended(one.socket) == code


def test_a_frame_beyond_its_limit_closes_the_socket(client: TestClient) -> None:
    with page(client) as one:
        one.socket.send_text(json.dumps({"type": "stop", "x": "x" * DRIVE_FRAME_MAX}))
        assert ended(one.socket) == 1009


def test_a_flood_closes_its_own_socket_only(client: TestClient, loop: RealtimeLoop) -> None:
    with page(client) as calm, page(client) as wild:
        for _ in range(60):
            wild.socket.send_text("{}")
        assert ended(wild.socket) == 1008
        calm.press()
        while not calm.told("lease")["held"]:
            pass
        loop.tick()
        assert not loop.newest.command.holds


def test_a_flooding_holder_is_held(client: TestClient, loop: RealtimeLoop) -> None:
    with page(client) as wild:
        for _ in range(60):
            wild.press()
        assert ended(wild.socket) == 1008
        loop.tick()
        assert loop.newest.command.holds


def test_there_is_room_for_so_many_pages_and_no_more(client: TestClient) -> None:
    state = client.app.state.console  # type: ignore[attr-defined]
    state.drivers.update(str(number) for number in range(DRIVERS_MAX))
    with pytest.raises(WebSocketDenialResponse) as caught, page(client):
        pass
    assert caught.value.status_code == 503


def test_the_first_frame_says_what_the_machine_is_drawn_with(client: TestClient) -> None:
    with page(client) as one:
        style = one.hello["style"]
    assert style == client.get("/api/v1/console/style").json()
    assert style == {"type": "style"} | json.loads(json.dumps(style_of(load_machine("titan3"))))
    assert style["leg_names"] == ["FL", "RL", "RR", "FR"]


def test_another_machine_s_style_comes_before_its_first_snapshot(
    client: TestClient, loop: RealtimeLoop
) -> None:
    with page(client) as one:
        one.told("snapshot")
        loop.load(prepare(load_scenario("k-curve")))
        loop.tick()
        while (frame := one.socket.receive_json())["type"] != "style":
            assert frame["type"] != "snapshot" or frame["robot"] == "titan3"
        assert len(frame["leg_names"]) == len(one.told("snapshot")["feet"]) == 6


def test_what_a_hand_has_done_shows_at_once_and_so_does_what_comes_of_it(
    client: TestClient, loop: RealtimeLoop, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Pictures come once in a hundred seconds here; only what is urgent comes sooner."""
    monkeypatch.setattr(show_pace, "SHOW_RATE", 0.01)
    monkeypatch.setattr(drive_socket, "EAGER_TIME", 100.0)
    with page(client) as one:
        one.told("snapshot")
        one.press()
        one.told("lease")
        for tick in (1, 2, 3):
            loop.tick()
            shown = one.told("snapshot")
            assert (shown["tick"], shown["speed_m_s"]) == (tick, 0.08)


def test_what_a_page_shows_is_weighed_by_its_age(
    client: TestClient, loop: RealtimeLoop, monkeypatch: pytest.MonkeyPatch
) -> None:
    ages: list[float | None] = []
    monkeypatch.setattr(ShowPace, "note", lambda pace, age, now: ages.append(age))
    with page(client) as one:
        one.told("snapshot")
        loop.tick()
        one.socket.send_json({"type": "ping", "sent_ms": 1.0, "echo_tick": loop.newest.tick})
        one.told("pong")
        one.socket.send_json({"type": "ping", "sent_ms": 2.0, "echo_tick": 10**6})
        one.told("pong")
        one.socket.send_json({"type": "ping", "sent_ms": 3.0})
        one.told("pong")
        one.press()
        one.told("lease")
    assert ages == [0.0, None, 0.0]


def test_a_refusal_shows_at_once(client: TestClient, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(show_pace, "SHOW_RATE", 0.01)
    with page(client) as one:
        one.told("snapshot")
        one.socket.send_text("no frame")
        assert "JSON" in one.refusal()
