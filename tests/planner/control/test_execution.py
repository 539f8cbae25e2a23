"""The plan that runs, and where the machine really is beside it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.planner.control.plans import (
    FEET,
    HEIGHT,
    STANCE,
    TITAN,
    execution,
    sensed,
    swing_plan,
    swinging_at,
)
from walking_console.planner.config import Tolerances
from walking_console.planner.control.execution import came_as_planned, feet_absolute
from walking_console.planner.geometry.transforms import placed, seen
from walking_console.planner.types import Phase


def test_a_machine_that_stands_as_expected_is_the_expected_stance_itself():
    run = execution()
    assert run.actual(sensed(), STANCE) is STANCE


@pytest.mark.parametrize(("off", "itself"), [(1e-4, True), (1e-2, False)])
def test_how_near_that_is_is_the_plants_to_say(off, itself):
    run = execution(plant=Tolerances(same_place=1e-3))
    moved = sensed(body=(off, 0.0, HEIGHT, 0.0, 0.0, 0.0))
    assert (run.actual(moved, STANCE) is STANCE) is itself


def test_a_machine_that_stands_otherwise_is_where_its_sensors_have_it():
    feet = ((FEET[0][0] + 0.05, *FEET[0][1:]), *FEET[1:])
    stance = execution().actual(sensed(feet=feet), STANCE)
    assert stance.feet[0] == pytest.approx(feet[0]) and stance.body == STANCE.body


SCATTERING = Tolerances(same_place=0.005, position_noise=0.005)


@pytest.mark.parametrize("off", [0.004, 0.012])
def test_sensors_that_scatter_move_a_stance_as_a_whole_to_where_the_body_is(off):
    turn = 0.02 if off > 0.005 else 0.0
    places = [placed((off, 0.0, turn), x, y) for x, y, _ in FEET]
    scattered = tuple((x + (-1) ** leg * 0.003, y, 0.0) for leg, (x, y) in enumerate(places))
    reading = sensed(body=(off, 0.0, HEIGHT + 0.002, 0.0, 0.0, turn), feet=scattered)
    stance = execution(plant=SCATTERING).actual(reading, STANCE)
    if off <= SCATTERING.same_place:
        assert stance is STANCE
        return
    assert stance.body == (off, 0.0, HEIGHT, turn)
    for foot, before in zip(stance.feet, FEET, strict=True):
        assert seen((off, 0.0, turn), *foot[:2]) == pytest.approx(before[:2])
        assert foot[2] == before[2]
    assert execution().actual(reading, STANCE).feet == feet_absolute(reading)


@pytest.mark.parametrize("axis", [0, 2])
def test_a_foot_that_is_off_by_more_than_they_scatter_is_where_they_have_it(axis):
    foot = [*FEET[0]]
    foot[axis] += 0.02
    reading = sensed(feet=(tuple(foot), *FEET[1:]))
    stance = execution(plant=SCATTERING).actual(reading, STANCE)
    assert stance.feet[0] == pytest.approx(foot)


def test_a_plan_that_has_not_begun_to_lift_its_legs_has_none_in_the_air():
    run = execution()
    plan = swing_plan()
    at_once = replace(plan, phases=(Phase.UP, *plan.phases[1:]))
    run.play(at_once)
    assert run.in_the_air() == []
    run.t = 0.01
    assert run.in_the_air() == [0]


def test_feet_are_placed_by_the_whole_posture():
    body = (0.3, -0.2, HEIGHT, 0.0, 0.0, 1.1)
    assert feet_absolute(sensed(body=body))[2] == pytest.approx(FEET[2])


def test_a_tick_goes_on_by_its_pace_and_leaves_over_what_lies_beyond_the_end():
    run = execution()
    run.play(swing_plan())
    run.pace = 0.5
    assert run.time_ahead()[0] == pytest.approx(0.01)
    run.t = 0.995
    t_next, left = run.time_ahead()
    assert run.is_over(t_next) and left == pytest.approx((t_next - 1.0) / 0.5)
    assert not run.is_over(0.9)


@pytest.mark.parametrize(("t", "carrying"), [(0.1, True), (0.6, False)])
def test_a_leg_carries_until_it_swings(t, carrying):
    state, _ = swinging_at(t)
    assert state.run.carrying(standing=False) == (carrying, True, True, True)
    assert state.run.in_the_air() == ([] if carrying else [0])


def test_a_leg_that_has_landed_carries_again():
    state, _ = swinging_at(0.9)
    state.run.reflexes = state.run.reflexes._replace(landed=(True, False, False, False))
    assert state.run.carrying(standing=False) == (True,) * 4 and not state.run.in_the_air()
    assert not state.run.misses_ground(lifts=False)


def test_legs_that_stay_lifted_across_the_switch_miss_no_ground():
    run = execution()
    plan = swing_plan()
    run.play(replace(plan, end=replace(plan.end, lifted=(0,))))
    assert run.misses_ground(lifts=False) and not run.misses_ground(lifts=True)


def test_the_planned_end_is_reached_when_all_went_as_planned():
    state, stance = swinging_at(0.98)
    at = (*stance.body[:3], 0.0, 0.0, stance.body[3])
    landed = (*state.run.plan.end.feet[:1], *stance.feet[1:])
    assert state.run.arrived(sensed(body=at, feet=landed)) is state.run.plan.end
    aside = (at[0], at[1] + 0.02, *at[2:])
    assert state.run.arrived(sensed(body=aside, feet=landed)).body[1] == pytest.approx(0.02)


def test_a_leg_that_stays_lifted_is_expected_where_the_last_tick_of_its_way_begins():
    run = execution()
    end = replace(STANCE, body=(0.1, 0.0, HEIGHT, 0.0), lifted=(0,))
    end = replace(end, feet=((FEET[0][0] + 0.2, FEET[0][1], 0.1), *FEET[1:]))
    plan = swing_plan()
    feet = plan.feet.copy()
    feet[:, 0] = np.linspace((FEET[0][0], FEET[0][1], 0.1), end.feet[0], 5)
    run.play(replace(plan, feet=feet, phases=(Phase.RETURN,) * 4, end=end))
    run.t = 0.98
    x, y, z, yaw = run.tracker.body_at(run.t)
    there = tuple(run.tracker.foot_at(leg, run.t) for leg in range(4))
    assert run.arrived(sensed(body=(x, y, z, 0.0, 0.0, yaw), feet=there)) is end
    late = ((there[0][0] - 0.01, *there[0][1:]), *there[1:])
    assert run.arrived(sensed(body=(x, y, z, 0.0, 0.0, yaw), feet=late)) is not end


def test_who_swung_is_remembered_only_when_its_foot_came_down_where_it_was_to():
    state, stance = swinging_at(0.6)
    run = state.run
    landing = run.plan.end.feet[0]
    step = replace(run.plan, landing=landing, end=replace(run.plan.end, last_swing=0))
    there = sensed(feet=(landing, *stance.feet[1:]))
    assert run.remembered(there, step).last_swing == 0
    short = sensed(feet=((landing[0] - 0.1, *landing[1:]), *stance.feet[1:]))
    assert run.remembered(short, step).last_swing == STANCE.last_swing
    assert run.remembered(there, None) is run.stance


def test_the_way_walked_in_a_step_cut_short_counts_by_how_far_the_body_got():
    state, stance = swinging_at(0.5)
    run = state.run
    step = replace(run.plan, landing=FEET[0], end=replace(run.plan.end, course=0.1))
    body = (0.05, 0.0, HEIGHT, 0.0, 0.0, 0.0)
    remembered = run.remembered(sensed(body=body, feet=stance.feet), step)
    assert remembered.course == pytest.approx(0.05)


def test_a_plan_came_out_as_planned_within_what_the_plant_errs_by():
    run = execution()
    assert came_as_planned(STANCE, STANCE, run.tolerances)
    near = replace(STANCE, body=(0.001, 0.0, HEIGHT, 0.0))
    far = replace(STANCE, body=(0.01, 0.0, HEIGHT, 0.0))
    assert came_as_planned(near, STANCE, run.tolerances)
    assert not came_as_planned(far, STANCE, run.tolerances)


def test_standing_it_plays_a_plan_that_moves_nothing():
    run = execution()
    velocities = run.velocities_to(0.0, sensed())
    assert all(math.hypot(*velocity) < 1e-12 for velocity in velocities)
    assert len(velocities) == len(TITAN.legs)
