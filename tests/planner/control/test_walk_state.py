"""How what the walker is at ends, is broken off and held."""

from dataclasses import replace

import pytest

from tests.planner.control.plans import (
    FEET,
    HEIGHT,
    STANCE,
    Scripted,
    flat,
    now,
    sensed,
    state_with,
    swing_plan,
)
from walking_console.planner.control.activities import Activity, Event
from walking_console.planner.control.walk_state import Now
from walking_console.planner.types import Command, Reason

ON_THREE = dict(feet=((FEET[0][0], FEET[0][1], 0.1), *FEET[1:]), soles=(False, True, True, True))


def swinging():
    """In a step whose leg 0 is in the air."""
    state = state_with(Scripted(None))
    state.run.play(swing_plan())
    state.happens(Event.STEP_READY)
    state.run.t = 0.5
    return state


def test_it_stands_at_first_and_an_event_without_a_row_raises():
    state = state_with()
    assert state.stands and not state.steps and state.crab_angle == 0.3
    with pytest.raises(RuntimeError, match="NO_PLACE cannot happen at STAND"):
        state.happens(Event.NO_PLACE)


def test_a_body_that_stops_with_a_foot_in_the_air_sets_it_down():
    state = swinging()
    state.stop(now(**ON_THREE))
    assert state.activity is Activity.SETTLE and state.run.plan.swing == (0,)
    assert state.run.interrupted is not None and state.blocked is None


def test_one_whose_sole_is_on_stands_where_it_is():
    state = swinging()
    state.stop(now())
    assert state.activity is Activity.STAND and state.run.interrupted is None


def test_where_there_is_no_ground_for_it_the_foot_is_held_and_the_reason_said():
    state = swinging()
    state.stop(now(terrain=flat(holes=True), **ON_THREE))
    assert state.activity is Activity.HOVER and state.hovered is Activity.STEP
    assert state.blocked is not None and state.blocked.reason in (
        Reason.NO_PLACE,
        Reason.NO_PLACE_FOR_ANY,
    )


def test_a_body_that_stops_on_all_its_feet_stands_where_it_is():
    state = swinging()
    state.run.t = 0.1
    state.stop(now(body=(0.01, 0.0, HEIGHT, 0.0, 0.0, 0.0)))
    assert state.stands and state.run.stance.body[0] == pytest.approx(0.01)
    assert state.run.plan.swing == () and state.executed is None


def test_a_step_cut_short_has_come_to_its_end_when_its_foot_stands():
    state = swinging()
    state.stop(now(**ON_THREE))
    state.rest(STANCE)
    assert state.executed is not None and state.executed.end is STANCE
    assert state.run.interrupted is None and state.stands


def test_what_is_refused_is_the_same_command_on_the_same_map():
    state = state_with()
    terrain = flat()
    asked = Now(sensed(), Command(0.0, 0.1), terrain, False)
    state.job.refused = (asked.command, terrain)
    assert not state.is_refused(asked)
    state.blocked = object()
    assert state.is_refused(asked)
    assert not state.is_refused(replace(asked, command=Command(0.5, 0.1)))
