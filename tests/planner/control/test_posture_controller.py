"""Postures on command: asked for, planned, played, dropped."""

import pytest

from tests.planner.control.plans import AHEAD, HEIGHT, STANCE, Scripted, flat, now, state_with
from walking_console.planner.config import configured
from walking_console.planner.control.activities import Activity, Event
from walking_console.planner.control.posture_controller import PostureController
from walking_console.planner.types import Command, Reason

GROUND = flat()
HOLD = Command()


def controller(config=None):
    state = state_with(Scripted(None), config)
    return state, PostureController(state, lambda place: STANCE)


def test_an_unknown_posture_is_refused_with_those_there_are():
    _, postures = controller()
    assert "there are: sit, stand, standard" in postures.ask("dance")
    assert not postures.is_busy


def test_with_a_foot_in_the_air_over_nothing_it_refuses():
    state, postures = controller()
    for event in (Event.STEP_READY, Event.NO_PLACE):
        state.happens(event)
    assert "a foot is in the air" in postures.ask("sit") and postures.wanted == ""


def test_sitting_down_is_planned_at_once_and_the_body_is_low_from_then_on():
    state, postures = controller()
    assert postures.ask("sit") == "" and postures.is_busy
    postures.take(now(HOLD, GROUND))
    assert state.activity is Activity.POSTURE and state.posture == "sit" and postures.low
    assert state.run.plan.end.body[2] < HEIGHT


def played(state, postures):
    """The running plan comes to its end as planned."""
    end = state.run.plan.end
    state.run.t = state.run.tracker.duration
    x, y, z, yaw = end.body
    return postures.next_plan(now(HOLD, GROUND, body=(x, y, z, 0.0, 0.0, yaw), feet=end.feet), 0.01)


def test_when_its_last_plan_is_over_the_posture_is_taken():
    state, postures = controller()
    postures.ask("sit")
    postures.take(now(HOLD, GROUND))
    played(state, postures)
    assert state.stands and postures.wanted == "" and postures.low and state.posture == "sit"


def test_a_command_to_move_drops_what_was_asked_for():
    _, postures = controller()
    postures.ask("standard")
    postures.listen(now(AHEAD, GROUND))
    assert not postures.is_busy


def test_a_machine_that_has_sunk_rises_first_and_stays_down_when_told_to_hold():
    state, postures = controller()
    postures.ask("sit")
    postures.take(now(HOLD, GROUND))
    played(state, postures)
    postures.listen(now(AHEAD, GROUND))
    assert postures.wanted == "stand"
    postures.listen(now(HOLD, GROUND))
    assert postures.wanted == ""


def test_too_many_tries_are_given_up_with_a_reason():
    state, postures = controller(configured({"tracking": {"posture_tries": 0}}))
    postures.ask("sit")
    postures.take(now(HOLD, GROUND))
    assert state.blocked is not None and state.blocked.reason is Reason.POSTURE_KEPT_FROM
    assert not postures.is_busy


@pytest.mark.parametrize("wanted", ["", "stand"])
def test_a_posture_no_longer_wanted_is_broken_off(wanted):
    state, postures = controller()
    postures.ask("sit")
    postures.take(now(HOLD, GROUND))
    assert postures.is_still_wanted
    if wanted:
        postures.ask(wanted)
    else:
        postures.halt()
    assert not postures.is_still_wanted
    postures.break_off(now(HOLD, GROUND))
    assert state.stands and state.posture == "stand"
