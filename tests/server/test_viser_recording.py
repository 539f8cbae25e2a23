"""What the player of viser reads, held against what viser itself would have written."""

import base64
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec.msgpack
import numpy as np
import pytest
import zstandard

from walking_console.server.viser_bridge import ViserBridge
from walking_console.server.viser_recording import GRID, StreamedRecording, on_grid


@pytest.fixture
def bridge() -> Iterator[ViserBridge]:
    made = ViserBridge()
    yield made
    made.stop()


def unpacked(data: bytes) -> dict[str, Any]:
    """A recording as its player takes it apart: arrays in the places of their indices."""
    inner = zstandard.ZstdDecompressor().decompressobj().decompress(data[8:])
    assert len(inner) == int.from_bytes(data[:8], "little")
    length = int.from_bytes(inner[:8], "little")
    told: dict[str, Any] = msgspec.msgpack.decode(inner[8 : 8 + length])
    place = 8 + length
    arrays = []
    for size in told.pop("binaryBufferLengths"):
        place += -place % 8
        arrays.append(inner[place : place + size])
        place += size
    assert place == len(inner)
    return {"arrays": arrays, **told, "messages": resolved(told["messages"], arrays)}


def resolved(value: Any, arrays: list[bytes]) -> Any:
    if isinstance(value, dict):
        if "__binary_index" in value:
            return [arrays[value["__binary_index"]], value["dtype"]]
        return {key: resolved(item, arrays) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [resolved(item, arrays) for item in value]
    return value


def written(recording: StreamedRecording, path: Path) -> dict[str, Any]:
    recording.write_html(path)
    page = path.read_text("utf-8")
    found = re.search(r'__VISER_EMBED_DATA__="([A-Za-z0-9+/=]*)"', page)
    assert found is not None and page.count("<head") == 1
    return unpacked(base64.b64decode(found[1], validate=True))


def draw(bridge: ViserBridge, step: int) -> None:
    scene = bridge.server.scene
    scene.add_frame("/body", position=(step / 8, 0.0, 0.25), show_axes=False)
    points = np.arange(9 + 3 * step, dtype=np.float32).reshape(-1, 3)
    scene.add_point_cloud("/trail", points, colors=(255, 0, 0), point_size=0.0625)


def test_the_player_reads_what_viser_would_have_written(
    bridge: ViserBridge, tmp_path: Path
) -> None:
    draw(bridge, 0)
    theirs = bridge.server.get_scene_serializer()
    with StreamedRecording(bridge.server) as ours:
        for step in range(1, 5):
            theirs.insert_sleep(0.5)
            ours.wait(0.5)
            draw(bridge, step)
        found = written(ours, tmp_path / "page.html")
    expected = unpacked(theirs.serialize())
    moved = [[time, on_grid(told) if time else told] for time, told in expected["messages"]]
    assert found["messages"] == moved and len(found["messages"]) > 10
    assert found["durationSeconds"] == expected["durationSeconds"] == 2.0
    assert found["viserVersion"] == expected["viserVersion"]


def test_an_array_that_comes_again_is_kept_once(bridge: ViserBridge, tmp_path: Path) -> None:
    with StreamedRecording(bridge.server) as recording:
        for _ in range(5):
            recording.wait(0.1)
            draw(bridge, 40)
        arrays = written(recording, tmp_path / "page.html")["arrays"]
    assert len(set(arrays)) == len(arrays) < 5


def test_a_page_is_whole_whatever_its_last_bytes(bridge: ViserBridge, tmp_path: Path) -> None:
    """Arrays are followed by as many spare bytes as they need, and base64 comes in threes."""
    with StreamedRecording(bridge.server) as recording:
        for step in range(1, 8):
            recording.wait(0.1)
            draw(bridge, step)
            bridge.server.scene.add_label("/label", "x" * step)
        messages = written(recording, tmp_path / "page.html")["messages"]
    labels = [told["props"]["text"] for _, told in messages if told["type"] == "LabelMessage"]
    assert labels == ["x" * step for step in range(1, 8)]


def test_numbers_that_move_lie_on_a_grid_finer_than_anybody_sees() -> None:
    told = {"position": (0.1, -2.34567, 1e9), "name": "/body", "visible": True, "count": 3}
    found = on_grid(told)
    assert found["position"] == pytest.approx([0.1, -2.34567, 1e9], abs=0.5 / GRID)
    assert found["position"][0] * GRID == round(0.1 * GRID)
    assert (found["name"], found["visible"], found["count"]) == ("/body", True, 3)
    assert found["visible"] is True


def test_nothing_is_recorded_after_the_page_is_written(bridge: ViserBridge, tmp_path: Path) -> None:
    with StreamedRecording(bridge.server) as recording:
        written(recording, tmp_path / "page.html")
        before = recording._messages.count
        draw(bridge, 1)
        assert recording._messages.count == before
