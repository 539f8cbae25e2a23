"""Who may drive: one lease, a stop for everybody, a dead-man, and no old command after a
black-out.
"""

import random
from typing import Literal

import pytest

from tests.server.stopwatch import Watch
from walking_console.planner.types import Command, Mode
from walking_console.server.control_lease import ControlLease
from walking_console.server.lease_reasons import TEXTS, LeaseReason, LeaseRefusal
from walking_console.server.realtime_loop import RealtimeLoop
from walking_console.server.schemas import (
    DriveFrame,
    PostureFrame,
    RearmFrame,
    ReleaseFrame,
    StopFrame,
    TakeFrame,
)
from walking_console.server.sessions import (
    DEAD_MAN,
    LEASE_IDLE,
    SIT_AFTER,
    Session,
    TooFast,
)

TAKE, RELEASE = TakeFrame(type="take"), ReleaseFrame(type="release")
STOP, REARM = StopFrame(type="stop"), RearmFrame(type="rearm")
CENTRE_FIRST = TEXTS[LeaseReason.CENTRE_FIRST]
STOPPED = TEXTS[LeaseReason.STOPPED]
REST_FIRST = TEXTS[LeaseReason.REST_FIRST]
TAKE_FIRST = TEXTS[LeaseReason.TAKE_FIRST]


def text_of(why: LeaseRefusal | None) -> str:
    """What people read of a refusal; '' for none."""
    return "" if why is None else why.text


class Stage:
    """A lease, its loop and its time, and a stick to press."""

    def __init__(self, loop: RealtimeLoop, watch: Watch) -> None:
        self.loop = loop
        self.watch = watch
        self.lease = ControlLease(loop)

    def press(
        self,
        session: Session,
        speed: float = 0.08,
        echo: int | None = None,
        seq: int | None = None,
        by_hand: bool = True,
    ) -> str:
        echo = self.loop.newest.tick if echo is None else echo
        seq = session.sequence + 1 if seq is None else seq
        self.lease.count(session)
        frame = DriveFrame(
            seq=seq,
            echo_tick=echo,
            crab_angle_rad=0.0,
            speed_m_s=speed,
            turn_rate_rad_s=0.0,
            by_hand=by_hand,
        )
        return text_of(self.lease.handle(session, frame))

    def ask(
        self,
        session: Session,
        posture: Literal["sit", "stand", "standard"],
        echo: int | None = None,
        seq: int | None = None,
    ) -> str:
        echo = self.loop.newest.tick if echo is None else echo
        seq = session.sequence + 1 if seq is None else seq
        self.lease.count(session)
        frame = PostureFrame(type="posture", seq=seq, echo_tick=echo, posture=posture)
        return text_of(self.lease.handle(session, frame))

    @property
    def mode(self) -> Mode:
        return self.loop.newest.mode

    def walk(self, seconds: float = 0.02) -> Command:
        """Let so much time go by, tick by tick; answers what is commanded then."""
        for _ in range(round(seconds / 0.02)):
            self.watch.wait(0.02)
            self.loop.tick()
        return self.loop.newest.command


@pytest.fixture
def stage(loop: RealtimeLoop, watch: Watch) -> Stage:
    return Stage(loop, watch)


def test_a_drive_frame_takes_a_free_lease_and_moves_the_machine(stage: Stage) -> None:
    session = stage.lease.open("a")
    assert stage.press(session) == ""
    assert stage.lease.holder == "a"
    assert stage.walk().speed == 0.08


def test_a_second_socket_is_refused_by_name_and_changes_nothing(stage: Stage) -> None:
    one, two = stage.lease.open("a"), stage.lease.open("b")
    stage.press(one)
    assert stage.press(two, speed=0.05) == "a is driving"
    assert stage.walk().speed == 0.08


def test_closing_the_socket_holds_within_one_tick(stage: Stage) -> None:
    session = stage.lease.open("a")
    stage.press(session)
    assert not stage.walk().holds
    stage.lease.close(session)
    assert stage.walk().holds and stage.lease.holder is None


def test_a_viewer_that_leaves_stops_nobody(stage: Stage) -> None:
    one, two = stage.lease.open("a"), stage.lease.open("b")
    stage.press(one)
    stage.lease.close(two)
    assert not stage.walk().holds


def test_letting_go_holds_within_one_tick(stage: Stage) -> None:
    session = stage.lease.open("a")
    stage.press(session)
    stage.walk()
    stage.lease.handle(session, RELEASE)
    assert stage.walk().holds and stage.lease.holder is None


@pytest.mark.parametrize("rate", [0.25, 1, 8])
def test_without_fresh_frames_the_machine_holds_at_the_dead_man(stage: Stage, rate: float) -> None:
    stage.loop.set_rate(rate)
    session = stage.lease.open("a")
    stage.press(session)
    assert not stage.walk(DEAD_MAN - 0.02).holds
    assert stage.walk(0.02 + 0.02 / min(rate, 1.0)).holds


def test_after_the_dead_man_the_stick_must_be_let_go_first(stage: Stage) -> None:
    session = stage.lease.open("a")
    stage.press(session)
    stage.walk(0.6)
    assert stage.press(session) == CENTRE_FIRST
    assert stage.walk().holds
    assert stage.press(session, speed=0.0) == ""
    assert stage.press(session) == ""
    assert not stage.walk().holds


def test_a_page_that_holds_by_itself_has_not_seen_the_hand_let_go(stage: Stage) -> None:
    session = stage.lease.open("a")
    stage.press(session)
    assert stage.press(session, speed=0.0, by_hand=False) == ""
    assert stage.walk().holds
    assert stage.press(session) == CENTRE_FIRST
    stage.press(session, speed=0.0, by_hand=False)
    assert stage.press(session) == CENTRE_FIRST
    stage.press(session, speed=0.0)
    assert stage.press(session) == "" and stage.walk().speed == 0.08


def test_a_short_stall_is_no_stop(stage: Stage) -> None:
    session = stage.lease.open("a")
    stage.press(session)
    assert not stage.walk(0.2).holds
    assert stage.press(session) == ""
    assert not stage.walk(0.4).holds


def test_none_of_the_old_frames_that_arrive_in_a_burst_after_a_black_out_is_obeyed(
    stage: Stage,
) -> None:
    session = stage.lease.open("a")
    stage.press(session)
    seen = stage.loop.newest.tick
    stage.walk(2.0)
    answers = [stage.press(session, echo=seen + number // 10) for number in range(142)]
    assert all(answers) and sum(answer.startswith("stale") for answer in answers) == 142
    assert stage.walk().holds
    assert stage.press(session) == CENTRE_FIRST, "motion needs a fresh press"


def test_a_frozen_picture_makes_commands_stale(stage: Stage) -> None:
    session = stage.lease.open("a")
    stage.walk()
    frozen = stage.loop.newest.tick
    for _ in range(28):
        stage.press(session, echo=frozen)
        stage.walk()
    assert stage.loop.newest.command.holds


def test_who_sees_old_pictures_drives_slower_and_never_past_the_dead_man(stage: Stage) -> None:
    session = stage.lease.open("a")
    stage.walk()
    old = stage.loop.newest.tick
    speeds = []
    for _ in range(24):
        stage.walk()
        stage.press(session, echo=old)
        speeds.append(stage.walk().speed)
        old += 1
    assert speeds[0] == 0.08 and speeds == sorted(speeds, reverse=True)
    assert 0.0 < speeds[-1] < 0.02, "a picture that is older each time"
    assert stage.press(session) == "" and stage.walk().speed == 0.08


def test_a_tick_nobody_has_shown_is_refused(stage: Stage) -> None:
    session = stage.lease.open("a")
    assert "not been shown" in stage.press(session, echo=10_000)
    assert stage.walk().holds


@pytest.mark.parametrize("seed", range(5))
def test_frames_out_of_order_and_twice_are_refused(stage: Stage, seed: int) -> None:
    session = stage.lease.open("a")
    numbers = list(range(50)) * 2
    random.Random(seed).shuffle(numbers)
    highest = -1
    for number in numbers:
        stage.watch.wait(0.02)
        why = stage.press(session, speed=0.0, seq=number)
        assert (why == "") == (number > highest), why
        highest = max(highest, number)


def test_taking_over_holds_first_and_refuses_the_old_holder(stage: Stage) -> None:
    one, two = stage.lease.open("a"), stage.lease.open("b")
    stage.press(one)
    stage.walk()
    assert stage.lease.handle(two, TAKE) is None
    assert stage.walk().holds
    assert stage.press(one) == "b is driving"
    assert stage.walk().holds
    assert stage.press(two, speed=0.05) == ""
    assert stage.walk().speed == 0.05


def test_a_stick_held_while_another_drives_moves_nothing_after_a_take_over(stage: Stage) -> None:
    one, two = stage.lease.open("a"), stage.lease.open("b")
    stage.press(one)
    stage.press(two)
    stage.lease.handle(two, TAKE)
    assert stage.press(two) == CENTRE_FIRST
    assert stage.walk().holds


def test_anybody_stops_and_the_stop_stays(stage: Stage) -> None:
    one, two = stage.lease.open("a"), stage.lease.open("b")
    stage.press(one)
    stage.walk()
    assert stage.lease.handle(two, STOP) is None
    assert stage.walk().holds
    assert stage.press(one) == STOPPED
    assert text_of(stage.lease.handle(one, REARM)) == CENTRE_FIRST
    assert stage.press(one, speed=0.0) == ""
    assert text_of(stage.lease.handle(two, REARM)) == "a is driving"
    assert stage.lease.handle(one, REARM) is None
    assert stage.walk().holds, "a stop that has ended moves nothing by itself"
    assert stage.press(one) == ""
    assert not stage.walk().holds


def test_a_stop_is_ended_by_the_holder_only(stage: Stage) -> None:
    session = stage.lease.open("a")
    stage.lease.handle(session, STOP)
    assert text_of(stage.lease.handle(session, REARM)) == TAKE_FIRST
    stage.lease.handle(session, TAKE)
    assert stage.lease.handle(session, REARM) is None


def test_a_silent_holder_loses_the_lease(stage: Stage) -> None:
    one, two = stage.lease.open("a"), stage.lease.open("b")
    stage.press(one)
    stage.walk(LEASE_IDLE - 1.0)
    assert stage.lease.holder == "a"
    stage.walk(1.1)
    assert stage.lease.holder is None
    assert stage.press(two) == ""
    assert stage.press(one) == "b is driving"


def test_the_last_frames_of_who_drove_before_leave_a_timeline_walking(stage: Stage) -> None:
    session = stage.lease.open("a")
    stage.press(session)
    stage.walk(0.5)
    stage.press(session, speed=0.0)
    stage.walk(0.1)
    stage.lease.hold()
    stage.loop.play()
    for _ in range(3):
        assert stage.press(session, speed=0.0) == ""
        stage.walk(0.04)
    assert stage.loop.playing
    stage.lease.handle(session, RELEASE)
    stage.walk(3.0)
    assert stage.loop.playing and stage.lease.holder is None
    assert stage.loop.newest.distance > 0.0
    assert stage.press(session) == ""
    stage.walk()
    assert not stage.loop.playing, "a pressed stick takes over"


def test_a_holder_that_falls_silent_leaves_a_timeline_walking(stage: Stage) -> None:
    session = stage.lease.open("a")
    stage.press(session, speed=0.0)
    stage.lease.hold()
    stage.loop.play()
    stage.walk(LEASE_IDLE + 1.0)
    assert stage.lease.holder is None and stage.loop.playing


def test_a_stop_ends_a_timeline_even_before_it_has_begun(stage: Stage) -> None:
    stage.loop.play()
    stage.lease.stop()
    stage.walk(1.0)
    assert not stage.loop.playing and stage.loop.newest.distance == 0.0
    stage.lease.latch.set(False)
    stage.loop.play()
    stage.walk(1.0)
    assert stage.loop.newest.distance > 0.0
    stage.lease.stop()
    assert stage.walk().holds and not stage.loop.playing


def test_rest_drives_only_while_nobody_holds_the_lease(stage: Stage) -> None:
    session = stage.lease.open("a")
    assert stage.lease.command(Command(0.0, 0.05, 0.0), 0.5) is None
    assert stage.walk().speed == 0.05
    assert stage.press(session) == "a program is driving"
    assert stage.walk(0.6).holds
    assert stage.press(session, speed=0.0) == "" and stage.press(session) == ""
    assert text_of(stage.lease.command(Command(0.0, 0.05, 0.0), 0.5)) == "a is driving"


def test_who_drives_is_told_again_when_a_program_begins_and_when_it_ends(stage: Stage) -> None:
    revision = stage.lease.revision
    stage.lease.command(Command(0.0, 0.05, 0.0), 0.5)
    assert stage.lease.revision == revision + 1 and stage.lease.holder_title == "a program"
    stage.lease.command(Command(0.0, 0.05, 0.0), 0.5)
    assert stage.lease.revision == revision + 1
    stage.walk(0.6)
    assert stage.lease.holder is None and stage.lease.revision == revision + 2


def test_only_who_drives_changes_the_world_while_a_page_drives(stage: Stage) -> None:
    one = stage.lease.open("a", "a phone")
    assert stage.lease.keeps_from_changing("") is None
    stage.press(one)
    assert stage.lease.keeps_from_changing("a") is None
    assert text_of(stage.lease.keeps_from_changing("b")) == "a phone is driving"
    assert text_of(stage.lease.keeps_from_changing("")) == "a phone is driving"


def test_rest_neither_drives_through_a_stop_nor_ends_the_stop_of_a_holder(stage: Stage) -> None:
    session = stage.lease.open("a")
    stage.lease.handle(session, TAKE)
    stage.lease.stop()
    assert text_of(stage.lease.rearm()) == "a is driving"
    stage.lease.close(session)
    assert text_of(stage.lease.command(Command(0.0, 0.05, 0.0), 0.5)).startswith("stopped")
    assert text_of(stage.lease.rearm()) == REST_FIRST, "and not without a stick at rest"
    assert stage.lease.command(Command(), 0.5) is None
    assert stage.lease.rearm() is None
    assert stage.lease.command(Command(0.0, 0.05, 0.0), 0.5) is None


def test_rest_rearms_only_while_its_command_to_rest_is_the_newest_and_lives(stage: Stage) -> None:
    stage.lease.stop()
    stage.lease.command(Command(), 0.5)
    stage.walk(0.6)
    assert text_of(stage.lease.rearm()) == REST_FIRST
    stage.lease.command(Command(), 0.5)
    stage.lease.command(Command(0.0, 0.05, 0.0), 0.5)  # refused, but a stick that is pressed
    assert text_of(stage.lease.rearm()) == REST_FIRST
    assert stage.lease.stopped


def test_by_its_name_the_page_that_drives_rearms_with_its_stick_at_rest(stage: Stage) -> None:
    session = stage.lease.open("a")
    stage.lease.handle(session, TAKE)
    stage.lease.stop()
    stage.press(session)
    assert text_of(stage.lease.rearm("a")) == CENTRE_FIRST
    stage.press(session, speed=0.0)
    assert text_of(stage.lease.rearm("b")) == "a is driving"
    assert stage.lease.rearm("a") is None and not stage.lease.stopped


def test_a_flood_is_cut_after_its_burst_and_a_stick_at_30_a_second_never_is(stage: Stage) -> None:
    calm = stage.lease.open("a")
    for _ in range(300):
        stage.watch.wait(1 / 30)
        stage.lease.count(calm)
    wild = stage.lease.open("b")
    with pytest.raises(TooFast):
        for _ in range(60):
            stage.lease.count(wild)


def test_a_stall_for_ever_holds_then_sits_down_and_then_frees_the_lease(
    stage: Stage,
) -> None:
    session = stage.lease.open("a")
    stage.press(session)
    assert not stage.walk(DEAD_MAN - 0.02).holds
    assert stage.walk(0.04).holds
    stage.walk(SIT_AFTER - DEAD_MAN - 0.1)
    assert stage.mode is Mode.STAND
    stage.walk(0.2)
    assert stage.mode is Mode.SIT_DOWN
    stage.walk(2.0)
    assert stage.mode is Mode.SIT and stage.lease.holder == "a"
    stage.walk(LEASE_IDLE - SIT_AFTER - 2.0)
    assert stage.lease.holder is None
    stage.walk(60.0)
    assert stage.mode is Mode.SIT


def test_a_stick_at_rest_on_a_live_link_is_never_sat_down_however_long_it_is_silent(
    stage: Stage,
) -> None:
    session = stage.lease.open("a")
    stage.press(session)
    stage.walk(0.2)
    stage.press(session, speed=0.0)
    stage.walk(SIT_AFTER + 20.0)
    assert stage.mode is Mode.STAND


def test_a_stick_held_against_a_refusal_is_a_live_link(stage: Stage) -> None:
    session = stage.lease.open("a")
    stage.press(session)
    stage.walk(1.0)
    for _ in range(300):
        assert stage.press(session) == CENTRE_FIRST
        stage.walk(0.04)
    assert stage.mode is Mode.STAND


def test_an_operator_cut_off_with_the_stick_pressed_is_waited_for_and_then_it_sits_down(
    stage: Stage,
) -> None:
    session = stage.lease.open("a")
    stage.press(session)
    stage.walk(0.3)
    stage.lease.close(session)
    stage.walk(SIT_AFTER - 0.5)
    assert stage.mode is Mode.STAND
    stage.walk(2.5)
    assert stage.mode is Mode.SIT


@pytest.mark.parametrize("somebody", ("press", "take", "stop", "rest", "release", "pose"))
def test_whoever_is_heard_before_keeps_the_machine_on_its_feet(stage: Stage, somebody: str) -> None:
    session, other = stage.lease.open("a"), stage.lease.open("b")
    stage.press(session)
    stage.walk(0.3)
    stage.lease.close(session) if somebody in ("rest", "press", "pose") else None
    stage.walk(5.0)
    if somebody == "press":
        stage.press(other, speed=0.0)
    elif somebody == "pose":
        assert stage.ask(other, "stand") == ""
    elif somebody == "rest":
        assert stage.lease.command(Command(), 0.5) is None
    else:
        stage.lease.handle(
            session if somebody == "release" else other,
            {"take": TAKE, "stop": STOP, "release": RELEASE}[somebody],
        )
    stage.walk(SIT_AFTER + 5.0)
    assert stage.mode is Mode.STAND


@pytest.mark.parametrize(("sit_after", "sits"), [(0.0, False), (2.0, True)])
def test_when_it_sits_down_is_a_setting_and_nought_is_never(
    stage: Stage, sit_after: float, sits: bool
) -> None:
    stage.lease = ControlLease(stage.loop, sit_after)
    stage.press(stage.lease.open("a"))
    stage.walk(4.0)
    assert (stage.mode is Mode.SIT) == sits
    stage.walk(15.0)
    assert (stage.mode is Mode.SIT) == sits


def test_a_paused_machine_waits_with_sitting_down(stage: Stage) -> None:
    stage.press(stage.lease.open("a"))
    stage.walk(1.0)
    stage.loop.pause()
    stage.walk(SIT_AFTER + 5.0)
    assert stage.mode is Mode.STAND
    stage.loop.resume()
    stage.walk(2.0)
    assert stage.mode is Mode.SIT


def test_the_holder_takes_a_posture_and_a_pressed_stick_must_be_let_go_first(stage: Stage) -> None:
    session, other = stage.lease.open("a"), stage.lease.open("b")
    stage.press(session)
    stage.walk(1.0 - DEAD_MAN)
    assert stage.ask(other, "sit") == "a is driving"
    assert stage.ask(session, "sit") == ""
    assert stage.press(session) == CENTRE_FIRST
    stage.walk(4.0)
    assert stage.mode is Mode.SIT
    stage.press(session, speed=0.0)
    assert stage.mode is Mode.SIT, "a stick at rest is no order to stop sitting"
    stage.press(session)
    stage.walk(0.1)
    assert stage.mode is Mode.STAND_UP


@pytest.mark.parametrize("ended_by", ("stop", "release", "close", "take", "rest hold"))
def test_a_posture_being_taken_stops_at_once_with_the_operator(stage: Stage, ended_by: str) -> None:
    session, other = stage.lease.open("a"), stage.lease.open("b")
    if ended_by == "rest hold":
        assert stage.lease.take_posture("sit") is None
    else:
        assert stage.ask(session, "sit") == ""
    stage.walk(0.5)
    assert stage.mode is Mode.SIT_DOWN
    if ended_by == "close":
        stage.lease.close(session)
    elif ended_by == "rest hold":
        assert stage.lease.command(Command(), 0.5) is None
    else:
        stage.lease.handle(
            session if ended_by == "release" else other,
            {"stop": STOP, "release": RELEASE, "take": TAKE}[ended_by],
        )
    height = stage.loop.newest.body[2]
    stage.walk(0.02)
    assert stage.loop.newest.body[2] == pytest.approx(height, abs=1e-9)
    stage.walk(2.0)
    assert stage.loop.newest.body[2] == pytest.approx(height, abs=1e-9) and stage.mode is Mode.STAND


def test_no_posture_is_taken_through_a_stop_or_by_an_old_frame(stage: Stage) -> None:
    session = stage.lease.open("a")
    stage.walk(2.0)
    assert stage.ask(session, "sit", echo=0).startswith("stale")
    assert stage.ask(session, "sit", seq=0).startswith("out of order")
    assert "not been shown" in stage.ask(session, "sit", echo=10_000)
    stage.lease.handle(session, STOP)
    assert stage.ask(session, "sit") == STOPPED
    assert text_of(stage.lease.take_posture("sit")).startswith("stopped")
    stage.walk(1.0)
    assert stage.mode is Mode.STAND


@pytest.mark.parametrize("seed", range(20))
def test_whatever_happens_one_drives_at_most_and_nothing_moves_through_a_stop(
    stage: Stage, seed: int
) -> None:
    chance = random.Random(seed)
    sessions = [stage.lease.open(name) for name in "abc"]
    for _ in range(400):
        session, action = (
            chance.choice(sessions),
            chance.choice(
                ("press", "press", "centre", "take", "release", "stop", "rearm", "wait", "old")
            ),
        )
        if action == "press":
            stage.press(session)
        elif action == "centre":
            stage.press(session, speed=0.0)
        elif action == "old" and session.sequence >= 0:
            assert stage.press(session, seq=session.sequence) != ""
        elif action == "wait":
            stage.walk(chance.choice((0.02, 0.1, 0.7)))
        elif action != "old":
            stage.lease.handle(
                session, {"take": TAKE, "release": RELEASE, "stop": STOP, "rearm": REARM}[action]
            )
        stage.walk()
        assert sum(stage.lease.holds(one) for one in sessions) <= 1
        command = stage.loop.newest.command
        assert command.holds or (not stage.lease.stopped and stage.lease.holder in ("a", "b", "c"))
