"""Encounters at one place are counted; another place or another course begins anew."""

from walking_console.planner.control.setbacks import Setbacks
from walking_console.planner.types import Command

AHEAD = Command(0.0, 0.1)


def noted(*places, command=AHEAD):
    setbacks = Setbacks(3)
    for x in places:
        setbacks.note((x, 0.0, 0.7), command)
    return setbacks


def test_enough_at_one_place_are_too_many():
    assert noted(1.0, 1.005).spent == 0
    assert noted(1.0, 1.005, 1.01).spent == 3


def test_a_walk_that_gets_on_may_meet_as_much_as_it_likes():
    assert noted(*(0.1 * k for k in range(50))).spent == 0


def test_going_to_and_fro_between_two_places_is_no_progress():
    assert noted(1.0, 1.2, 1.0, 1.2, 1.0).spent == 3


def test_another_course_is_another_attempt_and_a_trembling_stick_is_none():
    setbacks = noted(1.0, 1.0, 1.0)
    setbacks.heed(Command(0.02, 0.08))
    assert setbacks.spent == 3
    setbacks.heed(Command())
    assert setbacks.spent == 3
    setbacks.heed(Command(1.5, 0.1))
    assert setbacks.spent == 0


def test_turning_the_other_way_is_another_course():
    setbacks = noted(1.0, 1.0, 1.0, command=Command(0.0, 0.0, 0.2))
    setbacks.heed(Command(0.0, 0.0, 0.3))
    assert setbacks.spent == 3
    setbacks.heed(Command(0.0, 0.0, -0.3))
    assert setbacks.spent == 0
