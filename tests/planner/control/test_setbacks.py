"""Encounters and steps at one place are counted; another place or another course begins anew."""

from walking_console.planner.config import Contact
from walking_console.planner.control.setbacks import Setbacks
from walking_console.planner.robot.model import load_machine
from walking_console.planner.types import Command, Reason

AHEAD = Command(0.0, 0.1)
SETTINGS = Contact(setbacks_max=3, steps_max=2)


def noted(*places, command=AHEAD):
    setbacks = Setbacks(SETTINGS, load_machine("titan3"))
    for x in places:
        setbacks.note((x, 0.0, 0.7), command)
    return setbacks


def stepped(*places, command=AHEAD):
    setbacks = Setbacks(SETTINGS, load_machine("titan3"))
    for x, yaw in places:
        setbacks.note_step((x, 0.0, 0.7, yaw), command)
    return setbacks


def test_enough_encounters_at_one_place_are_too_many():
    assert noted(1.0, 1.005).why is None
    why = noted(1.0, 1.005, 1.01).why
    assert why is not None and why.reason is Reason.NO_PROGRESS and "3 times" in why.text


def test_a_step_whose_feet_could_meet_too_much_there_is_not_begun():
    for legs, too_many in ((2, False), (3, True)):
        setbacks = noted(1.0)
        setbacks.note_step((1.0, 0.0, 0.7, 0.0), AHEAD, legs)
        assert (setbacks.why is not None) is too_many
        setbacks = noted(1.0)
        setbacks.note_step((1.1, 0.0, 0.7, 0.0), AHEAD, legs)
        assert setbacks.why is None


def test_a_walk_that_gets_on_may_meet_as_much_as_it_likes():
    assert noted(*(0.1 * k for k in range(50))).why is None


def test_going_to_and_fro_between_two_places_is_no_progress():
    assert noted(1.0, 1.2, 1.0, 1.2, 1.0).why is not None


def test_two_steps_a_leg_that_take_the_body_nowhere_are_too_many():
    assert stepped(*[(1.0, 0.0)] * 7).why is None
    why = stepped(*[(1.0, 0.0)] * 8).why
    assert why is not None and why.reason is Reason.MARKING_TIME


def test_a_step_that_its_hand_cuts_short_is_none_of_these():
    setbacks = stepped()
    for _ in range(50):
        setbacks.note_step((1.0, 0.0, 0.7, 0.0), AHEAD)
        setbacks.let_go()
    assert setbacks.why is None


def test_steps_that_go_or_turn_are_none_of_these():
    assert stepped(*((0.06 * k, 0.0) for k in range(50))).why is None
    assert stepped(*((0.0, 0.1 * k) for k in range(50))).why is None


def test_another_course_is_another_attempt_and_a_trembling_stick_is_none():
    setbacks = noted(1.0, 1.0, 1.0)
    setbacks.heed(Command(0.02, 0.08))
    assert setbacks.why is not None
    setbacks.heed(Command())
    assert setbacks.why is not None
    setbacks.heed(Command(1.5, 0.1))
    assert setbacks.why is None


def test_turning_the_other_way_is_another_course():
    setbacks = noted(1.0, 1.0, 1.0, command=Command(0.0, 0.0, 0.2))
    setbacks.heed(Command(0.0, 0.0, 0.3))
    assert setbacks.why is not None
    setbacks.heed(Command(0.0, 0.0, -0.3))
    assert setbacks.why is None
