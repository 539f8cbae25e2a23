"""Who may drive: one lease, a stop for everybody, a dead-man, and no old command after a black-out."""

import random

import pytest
from stopwatch import Watch

from planner.vocabulary import Command
from server.clock import WalkingClock
from server.messages import DriveFrame, RearmFrame, ReleaseFrame, StopFrame, TakeFrame
from server.operator import CENTRE_FIRST, DEAD_MAN, LEASE_IDLE, STOPPED, TAKE_FIRST, Operator, Seat, TooFast

TAKE, RELEASE = TakeFrame(type="take"), ReleaseFrame(type="release")
STOP, REARM = StopFrame(type="stop"), RearmFrame(type="rearm")


class Stage:
    """An operator, its clock and its time, and a stick to press."""

    def __init__(self, clock: WalkingClock, watch: Watch) -> None:
        self.clock, self.watch, self.operator = clock, watch, Operator(clock)

    def press(self, seat: Seat, speed: float = 0.08, echo: int | None = None, seq: int | None = None) -> str:
        echo = self.clock.newest.tick if echo is None else echo
        seq = seat.sequence + 1 if seq is None else seq
        self.operator.count(seat)
        frame = DriveFrame(seq=seq, echo_tick=echo, crab_angle_rad=0.0, speed_m_s=speed, turn_rate_rad_s=0.0)
        return self.operator.hear(seat, frame)

    def walk(self, seconds: float = 0.02) -> Command:
        """Let so much time go by, beat by beat; answers what is commanded then."""
        for _ in range(round(seconds / 0.02)):
            self.watch.wait(0.02)
            self.clock.beat()
        return self.clock.newest.command


@pytest.fixture
def stage(clock: WalkingClock, watch: Watch) -> Stage:
    return Stage(clock, watch)


def test_a_drive_frame_takes_a_free_lease_and_moves_the_machine(stage: Stage) -> None:
    seat = stage.operator.sit("a")
    assert stage.press(seat) == ""
    assert stage.operator.holder == "a"
    assert stage.walk().speed == 0.08


def test_a_second_socket_is_refused_by_name_and_changes_nothing(stage: Stage) -> None:
    one, two = stage.operator.sit("a"), stage.operator.sit("b")
    stage.press(one)
    assert stage.press(two, speed=0.05) == "a is driving"
    assert stage.walk().speed == 0.08


def test_closing_the_socket_holds_within_one_beat(stage: Stage) -> None:
    seat = stage.operator.sit("a")
    stage.press(seat)
    assert not stage.walk().holds
    stage.operator.leave(seat)
    assert stage.walk().holds and stage.operator.holder is None


def test_a_viewer_that_leaves_stops_nobody(stage: Stage) -> None:
    one, two = stage.operator.sit("a"), stage.operator.sit("b")
    stage.press(one)
    stage.operator.leave(two)
    assert not stage.walk().holds


def test_letting_go_holds_within_one_beat(stage: Stage) -> None:
    seat = stage.operator.sit("a")
    stage.press(seat)
    stage.walk()
    stage.operator.hear(seat, RELEASE)
    assert stage.walk().holds and stage.operator.holder is None


@pytest.mark.parametrize("rate", [1, 8])
def test_without_fresh_frames_the_machine_holds_at_the_dead_man(stage: Stage, rate: int) -> None:
    stage.clock.set_rate(rate)
    seat = stage.operator.sit("a")
    stage.press(seat)
    assert not stage.walk(DEAD_MAN - 0.02).holds
    assert stage.walk(0.04).holds


def test_after_the_dead_man_the_stick_must_be_let_go_first(stage: Stage) -> None:
    seat = stage.operator.sit("a")
    stage.press(seat)
    stage.walk(0.6)
    assert stage.press(seat) == CENTRE_FIRST
    assert stage.walk().holds
    assert stage.press(seat, speed=0.0) == ""
    assert stage.press(seat) == ""
    assert not stage.walk().holds


def test_a_short_stall_is_no_stop(stage: Stage) -> None:
    seat = stage.operator.sit("a")
    stage.press(seat)
    assert not stage.walk(0.2).holds
    assert stage.press(seat) == ""
    assert not stage.walk(0.4).holds


def test_none_of_the_old_frames_that_arrive_in_a_burst_after_a_black_out_is_obeyed(stage: Stage) -> None:
    seat = stage.operator.sit("a")
    stage.press(seat)
    seen = stage.clock.newest.tick
    stage.walk(2.0)
    answers = [stage.press(seat, echo=seen + number // 10) for number in range(142)]
    assert all(answers) and sum(answer.startswith("stale") for answer in answers) == 142
    assert stage.walk().holds
    assert stage.press(seat) == CENTRE_FIRST, "motion needs a fresh press"


def test_a_frozen_picture_makes_commands_stale(stage: Stage) -> None:
    seat = stage.operator.sit("a")
    stage.walk()
    frozen = stage.clock.newest.tick
    for _ in range(28):
        stage.press(seat, echo=frozen)
        stage.walk()
    assert stage.clock.newest.command.holds


def test_a_tick_nobody_has_shown_is_refused(stage: Stage) -> None:
    seat = stage.operator.sit("a")
    assert "not been shown" in stage.press(seat, echo=10_000)
    assert stage.walk().holds


@pytest.mark.parametrize("seed", range(5))
def test_frames_out_of_order_and_twice_are_refused(stage: Stage, seed: int) -> None:
    seat = stage.operator.sit("a")
    numbers = list(range(50)) * 2
    random.Random(seed).shuffle(numbers)
    highest = -1
    for number in numbers:
        stage.watch.wait(0.02)
        why = stage.press(seat, speed=0.0, seq=number)
        assert (why == "") == (number > highest), why
        highest = max(highest, number)


def test_taking_over_holds_first_and_refuses_the_old_holder(stage: Stage) -> None:
    one, two = stage.operator.sit("a"), stage.operator.sit("b")
    stage.press(one)
    stage.walk()
    assert stage.operator.hear(two, TAKE) == ""
    assert stage.walk().holds
    assert stage.press(one) == "b is driving"
    assert stage.walk().holds
    assert stage.press(two, speed=0.05) == ""
    assert stage.walk().speed == 0.05


def test_a_stick_held_while_another_drives_moves_nothing_after_a_take_over(stage: Stage) -> None:
    one, two = stage.operator.sit("a"), stage.operator.sit("b")
    stage.press(one)
    stage.press(two)
    stage.operator.hear(two, TAKE)
    assert stage.press(two) == CENTRE_FIRST
    assert stage.walk().holds


def test_anybody_stops_and_the_stop_stays(stage: Stage) -> None:
    one, two = stage.operator.sit("a"), stage.operator.sit("b")
    stage.press(one)
    stage.walk()
    assert stage.operator.hear(two, STOP) == ""
    assert stage.walk().holds
    assert stage.press(one) == STOPPED
    assert stage.operator.hear(one, REARM) == CENTRE_FIRST
    assert stage.press(one, speed=0.0) == ""
    assert stage.operator.hear(two, REARM) == "a is driving"
    assert stage.operator.hear(one, REARM) == ""
    assert stage.walk().holds, "a stop that has ended moves nothing by itself"
    assert stage.press(one) == ""
    assert not stage.walk().holds


def test_a_stop_is_ended_by_the_holder_only(stage: Stage) -> None:
    seat = stage.operator.sit("a")
    stage.operator.hear(seat, STOP)
    assert stage.operator.hear(seat, REARM) == TAKE_FIRST
    stage.operator.hear(seat, TAKE)
    assert stage.operator.hear(seat, REARM) == ""


def test_a_silent_holder_loses_the_lease(stage: Stage) -> None:
    one, two = stage.operator.sit("a"), stage.operator.sit("b")
    stage.press(one)
    stage.walk(LEASE_IDLE - 1.0)
    assert stage.operator.holder == "a"
    stage.walk(1.1)
    assert stage.operator.holder is None
    assert stage.press(two) == ""
    assert stage.press(one) == "b is driving"


def test_rest_drives_only_while_nobody_holds_the_lease(stage: Stage) -> None:
    seat = stage.operator.sit("a")
    assert stage.operator.command(Command(0.0, 0.05, 0.0), 0.5) == ""
    assert stage.walk().speed == 0.05
    assert stage.press(seat) == "rest is driving"
    assert stage.walk(0.6).holds
    assert stage.press(seat, speed=0.0) == "" and stage.press(seat) == ""
    assert stage.operator.command(Command(0.0, 0.05, 0.0), 0.5) == "a is driving"


def test_rest_neither_drives_through_a_stop_nor_ends_the_stop_of_a_holder(stage: Stage) -> None:
    seat = stage.operator.sit("a")
    stage.operator.hear(seat, TAKE)
    stage.operator.stop()
    assert stage.operator.rearm() == "a is driving"
    stage.operator.leave(seat)
    assert stage.operator.command(Command(0.0, 0.05, 0.0), 0.5).startswith("stopped")
    assert stage.operator.rearm() == ""
    assert stage.operator.command(Command(0.0, 0.05, 0.0), 0.5) == ""


def test_a_flood_is_cut_after_its_burst_and_a_stick_at_30_a_second_never_is(stage: Stage) -> None:
    calm = stage.operator.sit("a")
    for _ in range(300):
        stage.watch.wait(1 / 30)
        stage.operator.count(calm)
    wild = stage.operator.sit("b")
    with pytest.raises(TooFast):
        for _ in range(60):
            stage.operator.count(wild)


@pytest.mark.parametrize("seed", range(20))
def test_whatever_happens_one_drives_at_most_and_nothing_moves_through_a_stop(stage: Stage, seed: int) -> None:
    chance = random.Random(seed)
    seats = [stage.operator.sit(name) for name in "abc"]
    for _ in range(400):
        seat, action = chance.choice(seats), chance.choice(("press", "press", "centre", "take", "release", "stop", "rearm", "wait", "old"))
        if action == "press":
            stage.press(seat)
        elif action == "centre":
            stage.press(seat, speed=0.0)
        elif action == "old" and seat.sequence >= 0:
            assert stage.press(seat, seq=seat.sequence) != ""
        elif action == "wait":
            stage.walk(chance.choice((0.02, 0.1, 0.7)))
        elif action != "old":
            stage.operator.hear(seat, {"take": TAKE, "release": RELEASE, "stop": STOP, "rearm": REARM}[action])
        stage.walk()
        assert sum(stage.operator.holds(one) for one in seats) <= 1
        command = stage.clock.newest.command
        assert command.holds or (not stage.operator.stopped and stage.operator.holder in ("a", "b", "c"))
