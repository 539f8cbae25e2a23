"""From a contact to what the foot does next and what the map is told."""

from dataclasses import replace

import pytest

from tests.planner.control.plans import FEET, Scripted, flat, now, state_with, swing_plan
from walking_console.planner.config import Contact
from walking_console.planner.control.activities import Activity, Event
from walking_console.planner.control.contact_reflexes import (
    ContactReflexes,
    cell_of,
    cells_near,
    edge_cells,
)
from walking_console.planner.control.encounter import FootState
from walking_console.planner.control.plan_job import WANTED

GROUND = flat()


def swinging(t):
    state = state_with(Scripted(None))
    state.run.play(swing_plan())
    state.happens(Event.STEP_READY)
    state.run.t = t
    return state, ContactReflexes(state)


def felt(t, terrain=GROUND, **more):
    state, contacts = swinging(t)
    tracker = state.run.tracker
    x, y, z, yaw = tracker.body_at(t)
    feet = tuple(tracker.foot_at(leg, t) for leg in range(4))
    tick = now(terrain=terrain, body=(x, y, z, 0.0, 0.0, yaw), feet=feet)
    return state, contacts, replace(tick, sensing=tick.sensing._replace(**more))


def test_a_hit_stops_the_body_and_draws_the_foot_back():
    state, contacts, tick = felt(0.6, whiskers=(1, 0, 0, 0))
    assert contacts.is_surprised(tick)
    assert state.activity is Activity.REFLEX and state.job.flags == WANTED
    assert contacts.encounter is not None and contacts.encounter.state is FootState.RETRACE
    assert contacts.counts == {"hit": 1} and state.run.interrupted is not None


def test_without_anything_felt_the_step_goes_on():
    state, contacts, tick = felt(0.6)
    assert not contacts.is_surprised(tick) and state.steps and contacts.encounter is None


def test_without_ground_at_the_end_the_foot_goes_on_down():
    state, contacts, tick = felt(1.0, soles=(False, True, True, True))
    assert contacts.find_no_ground(tick) == 0.0 and state.run.pace == 1.0
    assert contacts.encounter is not None and contacts.encounter.state is FootState.DESCEND
    assert contacts.counts == {"no ground": 1} and contacts.take_learnt() == set()


def test_a_foot_that_finds_none_there_either_teaches_the_map_and_searches():
    state, contacts, tick = felt(1.0, soles=(False, True, True, True))
    contacts.find_no_ground(tick)
    state.run.t = state.run.tracker.duration
    contacts.react(tick)
    assert contacts.encounter is not None and contacts.encounter.state is FootState.PLACE
    learnt = contacts.take_learnt()
    assert learnt and contacts.take_learnt() == set()


def test_where_no_place_is_left_it_hovers_until_ordered_on():
    nowhere = flat(holes=True)
    state, contacts, tick = felt(1.0, terrain=nowhere, soles=(False, True, True, True))
    contacts.find_no_ground(tick)
    state.run.t = state.run.tracker.duration
    contacts.react(tick)
    assert state.activity is Activity.HOVER and state.hovered is Activity.REFLEX
    assert contacts.encounter is not None and contacts.encounter.state is FootState.STRANDED
    state.happens(Event.REFLEX_RESUMED)
    contacts.go_on(replace(tick, terrain=GROUND))
    assert state.activity is Activity.REFLEX and contacts.encounter.state is FootState.PLACE


def test_a_foot_that_stands_ends_the_encounter_and_the_walk_rests():
    state, contacts, tick = felt(1.0, soles=(False, True, True, True))
    contacts.find_no_ground(tick)
    state.run.reflexes = state.run.reflexes._replace(landed=(True, False, False, False))
    contacts.react(now(terrain=GROUND))
    assert contacts.encounter is None and state.stands and state.executed is not None


@pytest.mark.parametrize("bearing", [0.0, 1.0, -2.5])
def test_an_edge_is_marked_along_and_beyond_it_but_not_behind(bearing):
    foot, settings = FEET[0], Contact()
    cells = edge_cells(foot, bearing, GROUND, settings)
    reach = settings.edge_length / 2 + settings.edge_depth + GROUND.cell
    assert cells == edge_cells(foot, bearing, GROUND, settings)
    for row, column in cells:
        x, y = GROUND.centre(row, column)
        assert max(abs(x - foot[0]), abs(y - foot[1])) <= reach
    assert cell_of(foot, GROUND) <= cells


def test_cells_near_are_those_whose_centre_is_and_a_foot_off_the_map_has_none():
    near = cells_near(FEET[0], 0.11, GROUND)
    assert cell_of(FEET[0], GROUND) <= near and 9 <= len(near) <= 25
    assert cells_near((99.0, 0.0, 0.0), 0.11, GROUND) == cell_of((99.0, 0.0, 0.0), GROUND) == set()
