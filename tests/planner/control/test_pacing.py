"""How fast a plan is played: at once as printed, and no faster than a body with mass can."""

from dataclasses import replace

import numpy as np
import pytest

from tests.planner.control.plans import AHEAD, execution, sensed, swing_plan
from tests.planner.motion.test_body_sway import GAIT, walked
from walking_console.planner.control.pacing import (
    braking_from,
    braking_now,
    lands_first,
    pace_for,
)
from walking_console.planner.motion.step_builder import changed, holding_plan
from walking_console.planner.types import TICK, Command


def test_it_goes_as_fast_as_commanded_within_what_the_step_was_planned_for():
    run = execution()
    run.play(replace(swing_plan(), speed=0.1, speed_max=0.15))
    assert pace_for(run, AHEAD) == 1.0
    assert pace_for(run, Command(0.0, 0.05)) == pytest.approx(0.5)
    assert pace_for(run, Command(0.0, 9.0)) == pytest.approx(1.5)
    run.play(replace(swing_plan(), speed=0.0))
    assert pace_for(run, Command(0.0, 9.0)) == 1.0


def swaying():
    stance, _, plan = walked(0, 4)[3]
    run = execution()
    run.gait = GAIT
    run.stance = stance
    run.play(plan)
    run.pace = 1.0
    run.t = 0.3 * run.tracker.duration
    return run


def test_a_swaying_body_changes_its_pace_no_faster_than_its_acceleration_allows():
    run = swaying()
    speed = abs(complex(*run.tracker.velocity_at(run.t)[:2]))
    slower = pace_for(run, Command(0.0, 0.02))
    assert 0.0 < (1.0 - slower) * speed <= run.acceleration * TICK * (1 + 1e-9)
    for _ in range(200):
        run.pace = pace_for(run, Command(0.0, 0.02))
    assert run.pace == pytest.approx(0.02 / run.plan.speed)


def test_a_step_that_the_sway_has_made_slow_is_not_made_slower_by_what_it_keeps_anyway():
    run = swaying()
    asked = replace(run.plan, speed=2.0 * run.plan.mean_speed, speed_max=1.0)
    run.play(asked)
    run.pace = 1.0
    assert pace_for(run, Command(0.0, 1.01 * asked.mean_speed)) == 1.0
    for _ in range(200):
        run.pace = pace_for(run, Command(0.0, 0.5 * asked.mean_speed))
    assert run.pace == pytest.approx(0.5)


def test_a_straight_body_stops_dead_and_a_swaying_one_has_a_way_to_rest():
    run = swaying()
    x, y, z, yaw = run.tracker.body_at(run.t)
    there = sensed(body=(x, y, z, 0.0, 0.0, yaw))
    way = braking_now(run, there)
    assert way is not None and way.body[0][:2] == pytest.approx((x, y))
    moved = braking_from(run, replace(run.stance, body=(x + 0.003, y, z, yaw), sway=(0.0, 0.0)))
    assert moved is not None and moved.body[0][0] == pytest.approx(x + 0.003)
    run.gait = replace(GAIT, sways=False)
    assert braking_now(run, there) is None


def test_a_body_that_is_held_back_has_stopped_already():
    run = swaying()
    x, y, z, yaw = run.tracker.body_at(run.t)
    assert braking_now(run, sensed(body=(x - 0.05, y, z, 0.0, 0.0, yaw))) is None


def test_a_foot_that_lands_soon_is_waited_for_where_the_body_stops_sooner_on_it_or_cannot_before():
    run = swaying()
    x, y, z, yaw = run.tracker.body_at(run.t)
    way = braking_now(run, sensed(body=(x, y, z, 0.0, 0.0, yaw)))
    assert way is not None and way.safe
    unsafe = way._replace(safe=False)
    assert not lands_first(run, unsafe)  # it lands in a second or two
    run.t = run.tracker.duration - 0.2
    assert lands_first(run, unsafe) and not lands_first(run, None)
    assert not lands_first(run, way)
    assert lands_first(run, way._replace(body=[way.body[0]] * 40))


def test_a_stick_let_go_keeps_the_pace_of_a_swaying_step_whose_foot_lands_first():
    run = swaying()
    assert pace_for(run, Command()) == run.pace == 1.0


def test_a_plan_with_a_body_at_rest_comes_back_to_its_pace_at_once():
    run = swaying()
    still = changed(holding_plan(run.stance), times=np.array((0.0, 2.0)), speed=0.002)
    run.play(replace(still, rates=np.zeros((2, 4))))
    run.t = 1.0
    run.pace = 50.0
    assert pace_for(run, Command(0.0, 0.002)) == 1.0
