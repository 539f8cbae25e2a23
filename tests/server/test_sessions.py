"""One socket's part in driving: frames in order, a stick, an allowance."""

import pytest

from walking_console.planner.types import Command
from walking_console.server.lease_reasons import LeaseReason, LeaseRefusal
from walking_console.server.limits import DRIVE_BURST, DRIVE_BURST_AFTER_SILENCE
from walking_console.server.schemas import PostureFrame
from walking_console.server.sessions import (
    DEAD_MAN,
    FULL_SPEED_AGE,
    Session,
    TooFast,
    slowed,
)


def frames_until_too_fast(session: Session, now: float) -> int:
    for sent in range(10_000):
        try:
            session.count(now)
        except TooFast:
            return sent
    raise AssertionError("never too fast")


def test_a_flood_is_cut_after_its_burst() -> None:
    assert frames_until_too_fast(Session("a"), now=0.0) == DRIVE_BURST


def test_a_stick_at_thirty_a_second_is_never_cut() -> None:
    session = Session("a")
    for frame in range(3000):
        session.count(frame / 30)
    assert session.allowance > 0.0


@pytest.mark.parametrize("silence", [1.0, 5.0, 3600.0])
def test_after_a_silence_what_was_held_back_may_come_at_once(silence: float) -> None:
    allowed = frames_until_too_fast(Session("a"), now=silence)
    assert allowed == min(max(DRIVE_BURST, silence * 100.0), DRIVE_BURST_AFTER_SILENCE)


def picture(seq: int) -> PostureFrame:
    return PostureFrame(type="posture", seq=seq, echo_tick=7, posture="sit")


def test_an_old_picture_moves_the_machine_less_and_one_of_a_good_link_as_far_as_asked() -> None:
    asked = Command(0.3, 0.08, -0.2)
    assert slowed(asked, 0.0) == slowed(asked, FULL_SPEED_AGE) == asked
    half = slowed(asked, (FULL_SPEED_AGE + DEAD_MAN) / 2)
    assert (half.crab_angle, half.speed, half.turn_rate) == pytest.approx((0.3, 0.04, -0.1))
    assert slowed(asked, DEAD_MAN).holds and slowed(asked, 99.0).holds


def test_a_number_that_is_not_higher_is_out_of_order() -> None:
    session = Session("a")
    assert session.age_of_picture(picture(3), lambda tick: 0.25) == 0.25
    for seq in (3, 2):
        why = session.age_of_picture(picture(seq), lambda tick: 0.0)
        assert isinstance(why, LeaseRefusal) and why.reason is LeaseReason.OUT_OF_ORDER


def test_a_tick_nobody_was_shown_is_none_of_this_moment() -> None:
    why = Session("a").age_of_picture(picture(1), lambda tick: None)
    assert isinstance(why, LeaseRefusal) and why.reason is LeaseReason.NOT_SHOWN


def test_a_stick_left_pressed_must_be_seen_at_rest_and_one_at_rest_need_not() -> None:
    pressed, resting = Session("a", centred=False, moving=True), Session("b")
    for session in (pressed, resting):
        session.freeze()
    assert pressed.must_centre and not resting.must_centre and not pressed.moving
    pressed.let_go()
    assert not pressed.must_centre and pressed.centred
