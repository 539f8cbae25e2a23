"""Emergent motions: the table, and the motion of each state."""

import pytest

from tests.planner.control.plans import FEET, GAIT, STANCE, TITAN, flat
from walking_console.planner.config import Contact
from walking_console.planner.control.encounter import (
    TABLE,
    ContactEvent,
    Encounter,
    FootState,
    Situation,
    at_top,
    ceiling,
    floor,
    motion,
)
from walking_console.planner.types import Blocked, Phase, StepPlan

GOAL = (FEET[0][0] + 0.2, FEET[0][1], 0.0)


def situation(bearing=None, terrain=None):
    feet = ((FEET[0][0], FEET[0][1], 0.1), *FEET[1:])
    here = STANCE.__class__(STANCE.body, feet)
    return Situation(here, bearing, terrain or flat(), TITAN, GAIT, Contact())


def moved(state, **more):
    return motion(Encounter(state, 0, GOAL), situation(**more))


def test_every_state_is_reached_and_left_and_every_event_known():
    assert set(TABLE.values()) == {state for state, _ in TABLE} == set(FootState)
    assert {event for _, event in TABLE} == set(ContactEvent)


def test_hits_and_misses_are_counted_as_they_happen():
    met = Encounter(FootState.NORMAL, 0, GOAL).after(ContactEvent.HIT).after(ContactEvent.HIT)
    assert met.state is FootState.CLIMB and met.hits == 2 and met.misses == 0
    down = Encounter(FootState.DESCEND, 0, GOAL).after(ContactEvent.NO_GROUND)
    assert down.state is FootState.SEARCH and down.misses == 1


def test_what_a_state_does_not_know_raises():
    with pytest.raises(KeyError):
        Encounter(FootState.NORMAL, 0, GOAL).after(ContactEvent.CLEAR)


@pytest.mark.parametrize("state", [FootState.RETRACE, FootState.CLIMB])
def test_after_a_hit_the_foot_goes_back_and_up(state):
    plan = moved(state, bearing=0.0)
    assert isinstance(plan, StepPlan) and set(plan.phases) == {Phase.RETURN, Phase.UP}
    x, _, z = plan.feet[-1, 0]
    assert x < FEET[0][0] and z == pytest.approx(0.1 + Contact().lift_step)


def test_it_goes_again_over_the_landing_point_and_down():
    plan = moved(FootState.RETRY)
    assert tuple(plan.feet[-1, 0][:2]) == pytest.approx(GOAL[:2]) and plan.feet[-1, 0, 2] < 0.1


def test_without_ground_it_goes_straight_down_to_the_bottom_of_its_reach():
    plan = moved(FootState.DESCEND)
    assert plan.feet[-1, 0, 2] == pytest.approx(floor(STANCE, 0, TITAN))
    assert tuple(plan.feet[-1, 0][:2]) == pytest.approx(FEET[0][:2])


def test_off_an_edge_it_goes_straight_up_but_no_higher_than_the_leg_draws_it():
    plan = moved(FootState.WITHDRAW)
    assert plan.feet[-1, 0, 2] <= ceiling(STANCE, 0, TITAN) and set(plan.phases) == {Phase.UP}
    assert not at_top(STANCE, 0, TITAN)


def test_a_new_place_is_found_where_there_is_ground_and_refused_where_there_is_none():
    assert isinstance(moved(FootState.PLACE), StepPlan)
    assert isinstance(moved(FootState.PLACE, terrain=flat(holes=True)), Blocked)


def test_only_the_foot_moves():
    for state in (FootState.RETRACE, FootState.RETRY, FootState.DESCEND, FootState.WITHDRAW):
        plan = moved(state)
        assert (plan.feet[:, 1:] == plan.feet[0, 1:]).all() and (plan.body == plan.body[0]).all()
