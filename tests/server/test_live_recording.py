"""What is walked live is kept for minutes, within bounds, over resets and worlds."""

from __future__ import annotations

from dataclasses import replace

import pytest

from walking_console.planner.types import TICK
from walking_console.server import live_recording
from walking_console.server.live_recording import EVERY, LiveRecording
from walking_console.sim.simulation import Simulation
from walking_console.sim.snapshot import Snapshot, TerrainView
from walking_console.sim.world import World


@pytest.fixture
def newest(flat: World) -> Snapshot:
    return Simulation(flat).snapshot()


def at(snapshot: Snapshot, tick: int, ground: TerrainView | None = None) -> Snapshot:
    ground = ground or snapshot.terrain
    return replace(snapshot, tick=tick, time=tick * TICK, terrain=ground)


def seen_ground(snapshot: Snapshot, revision: int) -> TerrainView:
    """The same ground as an eye sees it a moment later."""
    return replace(snapshot.terrain, revision=revision, heights=snapshot.terrain.heights.copy())


def test_every_third_tick_is_kept_and_a_standing_clock_adds_nothing(newest: Snapshot) -> None:
    recording = LiveRecording()
    for tick in (0, 0, 1, 2, 3, 3, 4, 5, 6):
        recording.note(at(newest, tick))
    assert [each.tick for each in recording.last(60.0)] == [0, 3, 6]
    assert recording.seconds == pytest.approx(3 * EVERY * TICK)


def test_the_last_seconds_are_the_newest_and_reach_over_a_reset(newest: Snapshot) -> None:
    recording = LiveRecording()
    for tick in [*range(0, 300, EVERY), *range(0, 60, EVERY)]:
        recording.note(at(newest, tick))
    ticks = [each.tick for each in recording.last(3.0)]
    assert len(ticks) == 50 and ticks[-1] == 57 and ticks[0] == 300 - 30 * EVERY


def test_no_more_than_the_newest_minutes_are_kept(
    newest: Snapshot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live_recording, "KEPT_MAX", 10)
    recording = LiveRecording()
    for tick in range(0, 300, EVERY):
        recording.note(at(newest, tick))
    assert [each.tick for each in recording.last(600.0)] == list(range(270, 300, EVERY))


def test_an_eye_that_sees_more_with_every_look_fills_no_memory(newest: Snapshot) -> None:
    recording = LiveRecording()
    for tick in range(0, 500, EVERY):
        recording.note(at(newest, tick, seen_ground(newest, tick)))
    grounds = {id(each.terrain) for each in recording.last(600.0)}
    assert 10 <= len(grounds) <= 11, "one a second"


def test_the_oldest_go_when_their_grounds_take_too_much(
    newest: Snapshot, monkeypatch: pytest.MonkeyPatch
) -> None:
    size = newest.terrain.heights.nbytes + newest.terrain.forbidden.nbytes
    monkeypatch.setattr(live_recording, "GROUND_BYTES_MAX", 3 * size)
    recording = LiveRecording()
    for tick in range(0, 500, EVERY):
        recording.note(at(newest, tick, seen_ground(newest, tick)))
    kept = recording.last(600.0)
    assert len({id(each.terrain) for each in kept}) == 3
    assert kept[-1].tick == 498 and kept[0].tick >= 350
