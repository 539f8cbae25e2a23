"""Who may drive: one lease, a stop for everybody, a dead-man, and no old command after a black-out."""

import random
from typing import Literal

import pytest

from tests.server.stopwatch import Watch
from walking_console.planner.types import Command, Mode
from walking_console.server.control_lease import (
    CENTRE_FIRST,
    DEAD_MAN,
    LEASE_IDLE,
    SIT_AFTER,
    STOPPED,
    TAKE_FIRST,
    Operator,
    Seat,
    TooFast,
)
from walking_console.server.realtime_loop import WalkingClock
from walking_console.server.schemas import (
    DriveFrame,
    PostureFrame,
    RearmFrame,
    ReleaseFrame,
    StopFrame,
    TakeFrame,
)

TAKE, RELEASE = TakeFrame(type="take"), ReleaseFrame(type="release")
STOP, REARM = StopFrame(type="stop"), RearmFrame(type="rearm")


class Stage:
    """An operator, its clock and its time, and a stick to press."""

    def __init__(self, clock: WalkingClock, watch: Watch) -> None:
        self.clock, self.watch, self.operator = clock, watch, Operator(clock)

    def press(
        self, seat: Seat, speed: float = 0.08, echo: int | None = None, seq: int | None = None
    ) -> str:
        echo = self.clock.newest.tick if echo is None else echo
        seq = seat.sequence + 1 if seq is None else seq
        self.operator.count(seat)
        frame = DriveFrame(
            seq=seq, echo_tick=echo, crab_angle_rad=0.0, speed_m_s=speed, turn_rate_rad_s=0.0
        )
        return self.operator.hear(seat, frame)

    def ask(
        self,
        seat: Seat,
        posture: Literal["sit", "stand", "standard"],
        echo: int | None = None,
        seq: int | None = None,
    ) -> str:
        echo = self.clock.newest.tick if echo is None else echo
        seq = seat.sequence + 1 if seq is None else seq
        self.operator.count(seat)
        return self.operator.hear(
            seat, PostureFrame(type="posture", seq=seq, echo_tick=echo, posture=posture)
        )

    @property
    def mode(self) -> Mode:
        return self.clock.newest.mode

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


def test_none_of_the_old_frames_that_arrive_in_a_burst_after_a_black_out_is_obeyed(
    stage: Stage,
) -> None:
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


def test_a_stall_for_ever_holds_at_the_dead_man_sits_down_after_ten_seconds_and_frees_the_lease_after_fifteen(
    stage: Stage,
) -> None:
    seat = stage.operator.sit("a")
    stage.press(seat)
    assert not stage.walk(DEAD_MAN - 0.02).holds
    assert stage.walk(0.04).holds
    stage.walk(SIT_AFTER - DEAD_MAN - 0.1)
    assert stage.mode is Mode.STAND
    stage.walk(0.2)
    assert stage.mode is Mode.SIT_DOWN
    stage.walk(2.0)
    assert stage.mode is Mode.SIT and stage.operator.holder == "a"
    stage.walk(LEASE_IDLE - SIT_AFTER - 2.0)
    assert stage.operator.holder is None
    stage.walk(60.0)
    assert stage.mode is Mode.SIT


def test_a_stick_at_rest_on_a_live_link_is_never_sat_down_however_long_it_is_silent(
    stage: Stage,
) -> None:
    seat = stage.operator.sit("a")
    stage.press(seat)
    stage.walk(0.2)
    stage.press(seat, speed=0.0)
    stage.walk(SIT_AFTER + 20.0)
    assert stage.mode is Mode.STAND


def test_a_stick_held_against_a_refusal_is_a_live_link(stage: Stage) -> None:
    seat = stage.operator.sit("a")
    stage.press(seat)
    stage.walk(1.0)
    for _ in range(300):
        assert stage.press(seat) == CENTRE_FIRST
        stage.walk(0.04)
    assert stage.mode is Mode.STAND


def test_an_operator_who_is_cut_off_with_the_stick_pressed_is_waited_for_and_then_the_machine_sits_down(
    stage: Stage,
) -> None:
    seat = stage.operator.sit("a")
    stage.press(seat)
    stage.walk(0.3)
    stage.operator.leave(seat)
    stage.walk(SIT_AFTER - 0.5)
    assert stage.mode is Mode.STAND
    stage.walk(2.5)
    assert stage.mode is Mode.SIT


@pytest.mark.parametrize("somebody", ("press", "take", "stop", "rest", "release", "pose"))
def test_whoever_is_heard_before_keeps_the_machine_on_its_feet(stage: Stage, somebody: str) -> None:
    seat, other = stage.operator.sit("a"), stage.operator.sit("b")
    stage.press(seat)
    stage.walk(0.3)
    stage.operator.leave(seat) if somebody in ("rest", "press", "pose") else None
    stage.walk(5.0)
    if somebody == "press":
        stage.press(other, speed=0.0)
    elif somebody == "pose":
        assert stage.ask(other, "stand") == ""
    elif somebody == "rest":
        assert stage.operator.command(Command(), 0.5) == ""
    else:
        stage.operator.hear(
            seat if somebody == "release" else other,
            {"take": TAKE, "stop": STOP, "release": RELEASE}[somebody],
        )
    stage.walk(SIT_AFTER + 5.0)
    assert stage.mode is Mode.STAND


@pytest.mark.parametrize(("sit_after", "sits"), [(0.0, False), (2.0, True)])
def test_when_it_sits_down_is_a_setting_and_nought_is_never(
    stage: Stage, sit_after: float, sits: bool
) -> None:
    stage.operator = Operator(stage.clock, sit_after)
    stage.press(stage.operator.sit("a"))
    stage.walk(4.0)
    assert (stage.mode is Mode.SIT) == sits
    stage.walk(15.0)
    assert (stage.mode is Mode.SIT) == sits


def test_a_paused_machine_waits_with_sitting_down(stage: Stage) -> None:
    stage.press(stage.operator.sit("a"))
    stage.walk(1.0)
    stage.clock.pause()
    stage.walk(SIT_AFTER + 5.0)
    assert stage.mode is Mode.STAND
    stage.clock.resume()
    stage.walk(2.0)
    assert stage.mode is Mode.SIT


def test_the_holder_takes_a_posture_and_a_pressed_stick_must_be_let_go_first(stage: Stage) -> None:
    seat, other = stage.operator.sit("a"), stage.operator.sit("b")
    stage.press(seat)
    stage.walk(1.0 - DEAD_MAN)
    assert stage.ask(other, "sit") == "a is driving"
    assert stage.ask(seat, "sit") == ""
    assert stage.press(seat) == CENTRE_FIRST
    stage.walk(4.0)
    assert stage.mode is Mode.SIT
    stage.press(seat, speed=0.0)
    assert stage.mode is Mode.SIT, "a stick at rest is no order to stop sitting"
    stage.press(seat)
    stage.walk(0.1)
    assert stage.mode is Mode.STAND_UP


@pytest.mark.parametrize("ended_by", ("stop", "release", "close", "take", "rest hold"))
def test_a_posture_being_taken_stops_at_once_with_the_operator(stage: Stage, ended_by: str) -> None:
    seat, other = stage.operator.sit("a"), stage.operator.sit("b")
    if ended_by == "rest hold":
        assert stage.operator.pose("sit") == ""
    else:
        assert stage.ask(seat, "sit") == ""
    stage.walk(0.5)
    assert stage.mode is Mode.SIT_DOWN
    if ended_by == "close":
        stage.operator.leave(seat)
    elif ended_by == "rest hold":
        assert stage.operator.command(Command(), 0.5) == ""
    else:
        stage.operator.hear(
            seat if ended_by == "release" else other,
            {"stop": STOP, "release": RELEASE, "take": TAKE}[ended_by],
        )
    height = stage.clock.newest.body[2]
    stage.walk(0.02)
    assert stage.clock.newest.body[2] == pytest.approx(height, abs=1e-9)
    stage.walk(2.0)
    assert (
        stage.clock.newest.body[2] == pytest.approx(height, abs=1e-9) and stage.mode is Mode.STAND
    )


def test_no_posture_is_taken_through_a_stop_or_by_an_old_frame(stage: Stage) -> None:
    seat = stage.operator.sit("a")
    stage.walk(2.0)
    assert stage.ask(seat, "sit", echo=0).startswith("stale")
    assert stage.ask(seat, "sit", seq=0).startswith("out of order")
    assert "not been shown" in stage.ask(seat, "sit", echo=10_000)
    stage.operator.hear(seat, STOP)
    assert stage.ask(seat, "sit") == STOPPED
    assert stage.operator.pose("sit").startswith("stopped")
    stage.walk(1.0)
    assert stage.mode is Mode.STAND


@pytest.mark.parametrize("seed", range(20))
def test_whatever_happens_one_drives_at_most_and_nothing_moves_through_a_stop(
    stage: Stage, seed: int
) -> None:
    chance = random.Random(seed)
    seats = [stage.operator.sit(name) for name in "abc"]
    for _ in range(400):
        seat, action = (
            chance.choice(seats),
            chance.choice(
                ("press", "press", "centre", "take", "release", "stop", "rearm", "wait", "old")
            ),
        )
        if action == "press":
            stage.press(seat)
        elif action == "centre":
            stage.press(seat, speed=0.0)
        elif action == "old" and seat.sequence >= 0:
            assert stage.press(seat, seq=seat.sequence) != ""
        elif action == "wait":
            stage.walk(chance.choice((0.02, 0.1, 0.7)))
        elif action != "old":
            stage.operator.hear(
                seat, {"take": TAKE, "release": RELEASE, "stop": STOP, "rearm": REARM}[action]
            )
        stage.walk()
        assert sum(stage.operator.holds(one) for one in seats) <= 1
        command = stage.clock.newest.command
        assert command.holds or (
            not stage.operator.stopped and stage.operator.holder in ("a", "b", "c")
        )
