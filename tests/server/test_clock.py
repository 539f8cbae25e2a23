"""The walking clock: beats, orders that lapse, pause and advance, faults, lateness."""

import threading
from collections.abc import Iterator

import pytest

from tests.server.stopwatch import Watch
from walking_console.planner.types import Command
from walking_console.server.realtime_loop import ADVANCE_PER_BEAT, Drawing, WalkingClock
from walking_console.sim.simulation import Simulation
from walking_console.sim.snapshot import Snapshot
from walking_console.sim.world import World

AHEAD = Command(0.0, 0.08, 0.0)


def test_a_beat_is_one_tick_at_life_speed_and_rate_ticks_above_it(clock: WalkingClock) -> None:
    clock.beat()
    assert clock.newest.tick == 1
    clock.set_rate(8)
    clock.beat()
    assert clock.newest.tick == 9
    assert clock.newest.rate == 8.0


@pytest.mark.parametrize("rate", [0, 9, -1])
def test_a_rate_beyond_its_range_is_refused(clock: WalkingClock, rate: int) -> None:
    with pytest.raises(ValueError, match="1 to 8"):
        clock.set_rate(rate)


def test_the_newest_order_wins(clock: WalkingClock) -> None:
    clock.order(AHEAD)
    clock.order(Command(1.0, 0.05, 0.0))
    clock.beat()
    assert clock.newest.command == Command(1.0, 0.05, 0.0)


@pytest.mark.parametrize("rate", [1, 4, 8])
def test_an_order_lapses_after_its_wall_time_at_every_rate(
    clock: WalkingClock, watch: Watch, rate: int
) -> None:
    clock.set_rate(rate)
    clock.order(AHEAD, 0.5)
    for _ in range(25):
        clock.beat()
        watch.wait(0.02)
        assert clock.newest.command == AHEAD
    clock.beat()
    assert clock.newest.command.holds


def test_an_order_lapses_although_the_whole_process_stood_still(
    clock: WalkingClock, watch: Watch
) -> None:
    clock.order(AHEAD, 0.5)
    clock.beat()
    watch.wait(3.0)
    clock.beat()
    assert clock.newest.command.holds


def test_a_lower_rate_does_not_lengthen_an_order_that_was_counted_at_a_higher_one(
    clock: WalkingClock,
) -> None:
    clock.set_rate(8)
    clock.order(AHEAD, 0.5)
    clock.beat()
    clock.set_rate(1)
    clock.beat()
    assert clock.newest.command.holds


def test_a_paused_world_stands_still_and_advances_by_exactly_what_is_asked(
    clock: WalkingClock,
) -> None:
    clock.pause()
    clock.beat()
    before = clock.newest.tick
    clock.beat()
    assert clock.newest.tick == before and clock.newest.paused
    clock.advance(ADVANCE_PER_BEAT + 30)
    clock.beat()
    assert clock.owed == 30
    clock.beat()
    assert clock.owed == 0 and clock.newest.tick == before + ADVANCE_PER_BEAT + 30


def test_a_reset_shows_while_paused(clock: WalkingClock) -> None:
    for _ in range(5):
        clock.beat()
    clock.pause()
    clock.reset()
    clock.beat()
    assert clock.newest.tick == 0


def test_what_remains_of_an_advance_is_dropped_on_resume(clock: WalkingClock) -> None:
    clock.pause()
    clock.advance(1000)
    clock.resume()
    clock.beat()
    assert clock.owed == 0 and clock.newest.tick == 1


class Broken(Simulation):
    """A console with a planner that fails once."""

    failing = True

    def step(self) -> None:
        if self.failing:
            raise ArithmeticError("the planner divided by nothing")
        super().step()


def test_a_tick_that_fails_is_held_and_said_until_a_reset(
    flat: World, capsys: pytest.CaptureFixture[str]
) -> None:
    console = Broken(flat)
    clock = WalkingClock(console)
    clock.beat()
    assert "the planner divided by nothing" in clock.fault
    assert "the walk stands still" in capsys.readouterr().err
    console.failing = False
    clock.beat()
    assert clock.newest.tick == 0, "a fault stays until somebody resets"
    clock.reset()
    clock.beat()
    assert clock.fault == "" and clock.newest.tick == 1


def test_the_picture_grows_old_only_while_newer_ones_are_out(
    clock: WalkingClock, watch: Watch
) -> None:
    clock.beat()
    seen = clock.newest.tick
    watch.wait(5.0)
    assert clock.age_of(seen) == 0.0, "nothing newer has been shown"
    clock.beat()
    watch.wait(0.3)
    assert clock.age_of(seen) == pytest.approx(0.3)
    assert clock.age_of(seen + 2) is None, "nobody can have seen this yet"


def test_a_tick_from_before_the_remembered_past_is_as_old_as_can_be(
    clock: WalkingClock, watch: Watch
) -> None:
    for _ in range(400):
        clock.beat()
        watch.wait(0.02)
    age = clock.age_of(3)
    assert age is not None and age > 0.5


def test_after_the_end_has_begun_no_order_moves_anything(clock: WalkingClock) -> None:
    clock.hold_for_good()
    clock.order(AHEAD)
    clock.beat()
    assert clock.newest.command.holds


@pytest.fixture
def walking(flat: World) -> Iterator[WalkingClock]:
    clock = WalkingClock(Simulation(flat))
    yield clock
    clock.stop()


def test_its_own_thread_walks_and_tells_of_every_snapshot(walking: WalkingClock) -> None:
    ten = threading.Semaphore(0)
    walking.on_publish = ten.release
    walking.start()
    for _ in range(10):
        assert ten.acquire(timeout=5.0)
    assert walking.newest.tick >= 9
    walking.stop()
    assert not walking.running


def test_a_late_beat_is_skipped_and_said_not_caught_up(flat: World) -> None:
    released, entered = threading.Event(), threading.Event()

    class Slow(Simulation):
        def step(self) -> None:
            super().step()
            if self.tick_count == 3:
                entered.set()
                released.wait(5.0)

    clock = WalkingClock(Slow(flat))
    told = threading.Semaphore(0)
    clock.start()
    assert entered.wait(5.0)
    threading.Event().wait(0.1)  # five beats go by
    released.set()
    clock.on_publish = told.release
    for _ in range(3):
        assert told.acquire(timeout=5.0)
    clock.stop()
    assert clock.skipped >= 4 and clock.worst >= 0.06
    assert clock.newest.tick < clock.beats + 2


def test_drawing_takes_the_newest_and_survives_a_failing_scene(
    clock: WalkingClock, capsys: pytest.CaptureFixture[str]
) -> None:
    drawn: list[int] = []

    def draw(snapshot: Snapshot) -> None:
        if snapshot.tick == 1:
            raise RuntimeError("no such handle")
        drawn.append(snapshot.tick)

    drawing = Drawing(clock, draw, lambda: True)
    clock.beat()
    drawing.show(clock.newest)
    assert "no such handle" in drawing.fault
    clock.beat()
    drawing.show(clock.newest)
    assert drawn == [2] and drawing.fault == ""
