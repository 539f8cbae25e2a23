"""The real-time loop: ticks, commands that lapse, pause and advance, faults, lateness."""

import threading
from collections.abc import Iterator

import pytest

from tests.server.stopwatch import Watch
from walking_console.planner.types import Command
from walking_console.server.pacing import ADVANCE_PER_TICK
from walking_console.server.realtime_loop import RealtimeLoop
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import World

AHEAD = Command(0.0, 0.08, 0.0)


def test_a_tick_walks_one_simulated_tick_at_life_speed_and_rate_of_them_above_it(
    loop: RealtimeLoop,
) -> None:
    loop.tick()
    assert loop.newest.tick == 1
    loop.set_rate(8)
    loop.tick()
    assert loop.newest.tick == 9
    assert loop.newest.rate == 8.0


@pytest.mark.parametrize("rate", [0, 9, -1])
def test_a_rate_beyond_its_range_is_refused(loop: RealtimeLoop, rate: int) -> None:
    with pytest.raises(ValueError, match="1 to 8"):
        loop.set_rate(rate)


def test_the_newest_order_wins(loop: RealtimeLoop) -> None:
    loop.order(AHEAD)
    loop.order(Command(1.0, 0.05, 0.0))
    loop.tick()
    assert loop.newest.command == Command(1.0, 0.05, 0.0)


@pytest.mark.parametrize("rate", [1, 4, 8])
def test_an_order_lapses_after_its_wall_time_at_every_rate(
    loop: RealtimeLoop, watch: Watch, rate: int
) -> None:
    loop.set_rate(rate)
    loop.order(AHEAD, 0.5)
    for _ in range(25):
        loop.tick()
        watch.wait(0.02)
        assert loop.newest.command == AHEAD
    loop.tick()
    assert loop.newest.command.holds


def test_an_order_lapses_although_the_whole_process_stood_still(
    loop: RealtimeLoop, watch: Watch
) -> None:
    loop.order(AHEAD, 0.5)
    loop.tick()
    watch.wait(3.0)
    loop.tick()
    assert loop.newest.command.holds


def test_a_lower_rate_does_not_lengthen_an_order_that_was_counted_at_a_higher_one(
    loop: RealtimeLoop,
) -> None:
    loop.set_rate(8)
    loop.order(AHEAD, 0.5)
    loop.tick()
    loop.set_rate(1)
    loop.tick()
    assert loop.newest.command.holds


def test_a_paused_world_stands_still_and_advances_by_exactly_what_is_asked(
    loop: RealtimeLoop,
) -> None:
    loop.pause()
    loop.tick()
    before = loop.newest.tick
    loop.tick()
    assert loop.newest.tick == before and loop.newest.paused
    loop.pace.advance(ADVANCE_PER_TICK + 30)
    loop.tick()
    assert loop.pace.owed == 30
    loop.tick()
    assert loop.pace.owed == 0 and loop.newest.tick == before + ADVANCE_PER_TICK + 30


def test_a_reset_shows_while_paused(loop: RealtimeLoop) -> None:
    for _ in range(5):
        loop.tick()
    loop.pause()
    loop.reset()
    loop.tick()
    assert loop.newest.tick == 0


def test_what_remains_of_an_advance_is_dropped_on_resume(loop: RealtimeLoop) -> None:
    loop.pause()
    loop.pace.advance(1000)
    loop.resume()
    loop.tick()
    assert loop.pace.owed == 0 and loop.newest.tick == 1


class Broken(Simulation):
    """A console with a planner that fails once."""

    failing = True

    def step(self) -> None:
        if self.failing:
            raise ArithmeticError("the planner divided by nothing")
        super().step()


def test_a_tick_that_fails_is_held_and_said_until_a_reset(
    flat: World, caplog: pytest.LogCaptureFixture
) -> None:
    console = Broken(flat)
    loop = RealtimeLoop(console)
    loop.tick()
    assert "the planner divided by nothing" in loop.fault
    assert "the walk stands still" in caplog.text
    console.failing = False
    loop.tick()
    assert loop.newest.tick == 0, "a fault stays until somebody resets"
    loop.reset()
    loop.tick()
    assert loop.fault == "" and loop.newest.tick == 1


def test_the_picture_grows_old_only_while_newer_ones_are_out(
    loop: RealtimeLoop, watch: Watch
) -> None:
    loop.tick()
    seen = loop.newest.tick
    watch.wait(5.0)
    assert loop.age_of(seen) == 0.0, "nothing newer has been shown"
    loop.tick()
    watch.wait(0.3)
    assert loop.age_of(seen) == pytest.approx(0.3)
    assert loop.age_of(seen + 2) is None, "nobody can have seen this yet"


def test_a_tick_from_before_the_remembered_past_is_as_old_as_can_be(
    loop: RealtimeLoop, watch: Watch
) -> None:
    for _ in range(400):
        loop.tick()
        watch.wait(0.02)
    age = loop.age_of(3)
    assert age is not None and age > 0.5


def test_after_the_end_has_begun_no_order_moves_anything(loop: RealtimeLoop) -> None:
    loop.hold_for_good()
    loop.order(AHEAD)
    loop.tick()
    assert loop.newest.command.holds


@pytest.fixture
def walking(flat: World) -> Iterator[RealtimeLoop]:
    loop = RealtimeLoop(Simulation(flat))
    yield loop
    loop.stop()


def test_its_own_thread_walks_and_tells_of_every_snapshot(walking: RealtimeLoop) -> None:
    ten = threading.Semaphore(0)
    walking.on_publish = ten.release
    walking.start()
    for _ in range(10):
        assert ten.acquire(timeout=5.0)
    assert walking.newest.tick >= 9
    walking.stop()
    assert not walking.running


def test_a_late_tick_is_skipped_and_said_not_caught_up(flat: World) -> None:
    released, entered = threading.Event(), threading.Event()

    class Slow(Simulation):
        def step(self) -> None:
            super().step()
            if self.tick_count == 3:
                entered.set()
                released.wait(5.0)

    loop = RealtimeLoop(Slow(flat))
    told = threading.Semaphore(0)
    loop.start()
    assert entered.wait(5.0)
    threading.Event().wait(0.1)  # five ticks go by
    released.set()
    loop.on_publish = told.release
    for _ in range(3):
        assert told.acquire(timeout=5.0)
    loop.stop()
    assert loop.lateness.skipped >= 4 and loop.lateness.worst >= 0.06
    assert loop.newest.tick < loop.ticks_run + 2


def test_while_paused_a_command_waits_for_single_ticks_however_long(
    loop: RealtimeLoop, watch: Watch
) -> None:
    loop.pause()
    loop.order(AHEAD, 0.5)
    loop.tick()
    watch.wait(30.0)
    loop.pace.advance(10)
    loop.tick()
    assert loop.newest.command == AHEAD
    loop.resume()
    loop.tick()
    assert loop.newest.command.holds, "wall time counts again"


def test_a_timeline_is_played_from_the_start_until_somebody_drives(loop: RealtimeLoop) -> None:
    loop.order(AHEAD)
    for _ in range(50):
        loop.tick()
    loop.play()
    for _ in range(100):
        loop.tick()
    assert loop.playing and loop.newest.tick <= 101
    assert loop.newest.command.speed > 0.0 and loop.newest.distance > 0.0
    loop.order(Command())
    loop.tick()
    loop.tick()
    assert not loop.playing and loop.newest.command.holds


def test_a_timeline_walks_on_at_another_rate_and_after_a_pause(loop: RealtimeLoop) -> None:
    loop.play()
    loop.set_rate(2)
    loop.tick()
    loop.set_rate(4)
    loop.tick()
    loop.pause()
    loop.tick()
    paused = loop.newest.tick
    loop.resume()
    for _ in range(20):
        loop.tick()
    assert loop.playing and loop.newest.tick == paused + 80
    assert loop.newest.command.speed > 0.0


def test_a_timeline_that_has_ended_holds_and_says_what_came_of_the_expected(
    loop: RealtimeLoop,
) -> None:
    loop.play()
    loop.set_rate(8)
    while loop.player is None or loop.player.ending is None:
        loop.tick()
    loop.tick()
    assert not loop.playing and loop.newest.command.holds
    assert loop.player.ending[0] == "completed"
    assert all(entry["pass"] for entry in loop.player.expectations().values())
