"""The render loop: the newest snapshot, and a scene that may fail."""

import pytest

from walking_console.server.realtime_loop import RealtimeLoop
from walking_console.server.render_loop import RenderLoop
from walking_console.sim.snapshot import Snapshot


def test_rendering_takes_the_newest_and_survives_a_failing_scene(
    loop: RealtimeLoop, capsys: pytest.CaptureFixture[str]
) -> None:
    drawn: list[int] = []

    def draw(snapshot: Snapshot) -> None:
        if snapshot.tick == 1:
            raise RuntimeError("no such handle")
        drawn.append(snapshot.tick)

    rendering = RenderLoop(loop, draw, lambda: True)
    loop.tick()
    rendering.show(loop.newest)
    assert "no such handle" in rendering.fault
    loop.tick()
    rendering.show(loop.newest)
    assert drawn == [2] and rendering.fault == ""
