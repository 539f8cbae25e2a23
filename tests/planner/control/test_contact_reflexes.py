"""From a contact to what the foot does next and what the map is told."""

import math
from dataclasses import replace

import pytest

from tests.planner.control.plans import Scripted, flat, now, state_with, swing_plan
from walking_console.planner.config import Contact
from walking_console.planner.control.activities import Activity, Event
from walking_console.planner.control.contact_reflexes import (
    ContactReflexes,
)
from walking_console.planner.control.encounter import FootState
from walking_console.planner.control.execution import feet_absolute
from walking_console.planner.control.handshake import WANTED
from walking_console.planner.types import Reason

GROUND = flat()


def swinging(t):
    state = state_with(Scripted(None))
    state.run.play(swing_plan())
    state.happens(Event.STEP_READY)
    state.run.t = t
    return state, ContactReflexes(state)


def two_swinging():
    state = state_with(Scripted(None))
    plan = swing_plan()
    state.run.play(replace(plan, swing=(0, 2)))
    state.happens(Event.STEP_READY)
    state.run.t = 1.0
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
    assert contacts.counts == {"no ground": 1} and not contacts.take_felt()


def test_a_foot_that_finds_none_there_either_teaches_the_map_and_searches():
    state, contacts, tick = felt(1.0, soles=(False, True, True, True))
    contacts.find_no_ground(tick)
    state.run.t = state.run.tracker.duration
    contacts.react(tick)
    assert contacts.encounter is not None and contacts.encounter.state is FootState.PLACE
    told = contacts.take_felt()
    assert told.prohibited and not contacts.take_felt()
    assert set(told.heights) == told.prohibited
    assert all(math.isnan(height) for height in told.heights.values())


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


def test_a_leg_that_waits_in_the_air_is_seen_to_when_the_foot_before_it_stands():
    state, contacts = two_swinging()
    tick = now(terrain=GROUND, feet=state.run.plan.end.feet, soles=(False, True, False, True))
    contacts.find_no_ground(tick)
    assert contacts.encounter is not None and contacts.encounter.leg == 0
    assert state.run.plan.end.lifted == (2,) and 2 in state.run.plan.swing
    state.run.reflexes = state.run.reflexes._replace(landed=(True, False, False, False))
    contacts.react(tick)
    assert contacts.encounter is not None and contacts.encounter.leg == 2
    assert contacts.encounter.state is FootState.DESCEND and not state.stands
    state.run.reflexes = state.run.reflexes._replace(landed=(False, False, True, False))
    contacts.react(now(terrain=GROUND))
    assert contacts.encounter is None and state.stands and state.run.stance.lifted == ()


def test_a_leg_without_ground_stays_lifted_where_the_planner_walks_on_fewer():
    nowhere = flat(holes=True)
    state, _ = swinging(1.0)
    contacts = ContactReflexes(state, standing_min=3)
    tick = now(terrain=nowhere, soles=(False, True, True, True))
    contacts.find_no_ground(tick)
    state.run.t = state.run.tracker.duration
    contacts.react(tick)
    assert state.stands and state.blocked is None
    assert state.run.stance.lifted == (0,) and state.run.carrying(True)[0] is False


def test_a_hit_raises_the_map_beside_the_foot_to_the_height_of_the_foot():
    _, contacts, tick = felt(0.6, whiskers=(1, 0, 0, 0))
    foot = feet_absolute(tick.sensing)[0]
    contacts.is_surprised(tick)
    told = contacts.take_felt()
    (cell,) = told.heights
    assert told.heights[cell] == pytest.approx(foot[2]) and not told.prohibited
    x, y = GROUND.centre(*cell)
    assert x > foot[0] and abs(y - foot[1]) <= GROUND.cell


def test_a_foot_that_drags_over_ground_on_its_way_has_hit_it():
    _, contacts, tick = felt(0.6, soles=(False, True, True, True))
    assert not contacts.is_surprised(tick)
    on = replace(tick, sensing=tick.sensing._replace(soles=(True,) * 4))
    assert contacts.is_surprised(on) and contacts.counts == {"hit": 1}


def test_too_many_encounters_at_one_place_are_told():
    state, contacts, tick = felt(0.6, whiskers=(1, 0, 0, 0))
    for _ in range(Contact().setbacks_max):
        assert state.setbacks.why is None
        contacts.let_down([0], tick)
    assert state.setbacks.why is not None
    assert state.setbacks.why.reason is Reason.NO_PROGRESS
