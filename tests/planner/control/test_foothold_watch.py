"""A foothold that gives way is told from load and slip (case 3 of H §9)."""

from dataclasses import replace

import pytest

from tests.planner.control.plans import FEET, Scripted, flat, now, sensed, state_with, swing_plan
from walking_console.planner.config import Contact, Tolerances
from walking_console.planner.control.activities import Activity, Event
from walking_console.planner.control.contact_reflexes import ContactReflexes
from walking_console.planner.control.encounter import FootState
from walking_console.planner.control.foothold_watch import FootholdWatch
from walking_console.planner.types import Reason

OFF = (True, False, True, True)
WAY = Contact().gives_way


def feet_with(leg, dx=0.0, dz=0.0):
    feet = list(FEET)
    x, y, z = feet[leg]
    feet[leg] = (x + dx, y, z + dz)
    return tuple(feet)


def walker(t=0.1):
    state = state_with(Scripted(None))
    state.run.play(swing_plan())
    state.happens(Event.STEP_READY)
    state.run.t = t
    return state


@pytest.mark.parametrize(("dz", "gone"), [(-0.9 * WAY, None), (-1.1 * WAY, 1)])
def test_a_foot_that_lost_its_load_has_lost_its_hold_once_it_is_so_far_below_where_it_did(dz, gone):
    watch = FootholdWatch(walker().run)
    assert watch.gone(sensed(soles=OFF)) is None
    assert watch.gone(sensed(feet=feet_with(1, dz=dz), soles=OFF)) == gone
    assert watch.gone(sensed(feet=feet_with(1, dz=dz))) is None  # it carries


def test_a_foot_that_comes_down_from_where_it_hung_has_lost_none():
    watch = FootholdWatch(walker().run)
    assert watch.gone(sensed(soles=OFF)) is None
    assert watch.gone(sensed(feet=feet_with(1, dz=0.1), soles=OFF)) is None
    assert watch.gone(sensed(feet=feet_with(1, dz=0.05), soles=OFF)) is None


@pytest.mark.parametrize(("dx", "gone"), [(0.9 * WAY, None), (1.1 * WAY, 1)])
def test_a_foot_that_slips_has_lost_its_hold_once_it_is_so_far_beside_where_it_stood(dx, gone):
    watch = FootholdWatch(walker().run)
    feet = feet_with(1, dx=dx)
    slips = sensed(feet=feet)._replace(slipping=(False, True, False, False))
    assert watch.gone(slips) == gone
    assert watch.gone(sensed(feet=feet)) is None
    assert watch.gone(slips._replace(slipping=(True, True, False, False))) is None  # it is pushed


def test_a_body_that_errs_about_its_height_has_lost_no_foothold():
    watch = FootholdWatch(walker().run)
    watch.gone(sensed(soles=OFF))
    feet = tuple((x, y, z - 2.0 * WAY) for x, y, z in FEET)
    assert watch.gone(sensed(feet=feet, soles=OFF)) is None


def test_a_foot_that_swings_or_is_lifted_on_purpose_has_no_hold_to_lose():
    off = (False, True, True, True)
    for state, gone in ((walker(t=0.6), None), (walker(), 0), (walker(), None)):
        if gone is None:
            state.run.stance = replace(state.run.stance, lifted=(0,) if state.run.t < 0.5 else ())
        watch = FootholdWatch(state.run)
        watch.gone(sensed(soles=off))
        assert watch.gone(sensed(feet=feet_with(0, dz=-0.3), soles=off)) == gone


def test_sensors_that_scatter_are_given_six_times_as_much_room():
    state = walker()
    state.run.tolerances = Tolerances(position_noise=0.01)
    watch = FootholdWatch(state.run)
    watch.gone(sensed(soles=OFF))
    assert watch.gone(sensed(feet=feet_with(1, dz=-0.059), soles=OFF)) is None
    assert watch.gone(sensed(feet=feet_with(1, dz=-0.061), soles=OFF)) == 1


def test_a_leg_may_be_drawn_off_only_where_the_others_carry():
    watch = FootholdWatch(walker().run)
    ahead = sensed(body=(0.1, 0.1, 0.85, 0.0, 0.0, 0.0))
    assert watch.may_rise(2, ahead) and not watch.may_rise(0, ahead)
    assert not watch.may_rise(2, ahead._replace(soles=OFF))


def sunk(body, terrain=None):
    state = walker()
    contacts = ContactReflexes(state)
    ground = terrain or flat()
    assert not contacts.is_surprised(now(terrain=ground, body=body, soles=OFF))
    tick = now(terrain=ground, body=body, feet=feet_with(1, dz=-0.02), soles=OFF)
    assert contacts.is_surprised(tick)
    return state, contacts, tick


def test_where_the_others_carry_the_foot_is_drawn_off_and_its_cells_are_marked():
    state, contacts, tick = sunk((0.1, -0.1, 0.85, 0.0, 0.0, 0.0))
    assert state.activity is Activity.REFLEX and contacts.counts == {"gave way": 1}
    assert contacts.encounter is not None and contacts.encounter.leg == 1
    assert contacts.encounter.state is FootState.WITHDRAW
    x, y, _ = FEET[1]
    assert tick.terrain.cell_at(x, y) in contacts.take_felt().prohibited


def test_where_the_leg_is_needed_it_goes_down_after_its_ground():
    _, contacts, _ = sunk((-0.2, 0.2, 0.85, 0.0, 0.0, 0.0))
    assert contacts.encounter is not None and contacts.encounter.state is FootState.DESCEND
    assert contacts.counts == {"sank": 1}


def test_without_another_foothold_the_reason_is_that_the_ground_gave_way():
    state, contacts, tick = sunk((0.1, -0.1, 0.85, 0.0, 0.0, 0.0), flat(holes=True))
    state.run.t = state.run.tracker.duration
    contacts.react(tick)
    assert state.activity is Activity.HOVER and state.blocked is not None
    assert (state.blocked.reason, state.blocked.leg) == (Reason.GAVE_WAY, 1)


def test_a_leg_in_the_air_is_put_down_before_the_foothold_is_seen_to_and_straight_if_needed():
    state = walker(t=0.6)
    contacts = ContactReflexes(state)
    x, y, z, yaw = state.run.tracker.body_at(0.6)
    feet = list(feet_with(1, dz=-0.02))
    feet[0] = state.run.tracker.foot_at(0, 0.6)
    off = (False, False, True, True)
    body = (x, y - 0.1, z, 0.0, 0.0, yaw)
    assert not contacts.is_surprised(now(body=body, feet=(feet[0], *FEET[1:]), soles=off))
    tick = now(body=body, feet=tuple(feet), soles=off)
    assert contacts.is_surprised(tick)
    assert contacts.encounter is not None and contacts.encounter.leg == 0
    assert contacts.encounter.state is FootState.DESCEND and contacts.counts == {}
    state.run.reflexes = state.run.reflexes._replace(landed=(True, False, False, False))
    state.run.t = state.run.tracker.duration
    contacts.react(replace(tick, sensing=tick.sensing._replace(soles=OFF)))
    assert contacts.encounter is not None and contacts.encounter.leg == 1
    assert sum(contacts.counts.values()) == 1
