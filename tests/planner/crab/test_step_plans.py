"""Plans of a step Level B2 decided on: how fast they are, and the way of body and foot."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.planner.crab.crab_walks import TITAN, command, gait, walk
from walking_console.planner.crab.step_plans import cruise_speed
from walking_console.planner.types import Phase

FRONT_STEP = (0.625, 0.0, 0.0), (1.0, 0.0, 0.0)


def test_v_max_of_the_standard_walk():
    assert cruise_speed(TITAN, gait(smooth=False), 0.0) == pytest.approx(0.135, abs=5e-4)
    assert cruise_speed(TITAN, gait(), 0.0) == pytest.approx(0.108, abs=5e-4)
    assert cruise_speed(TITAN, gait(), math.pi / 2) == pytest.approx(0.091, abs=5e-4)
    slow = replace(TITAN, speed=(0.3, 0.3, 0.3))
    assert cruise_speed(slow, gait(smooth=False), 0.0) == pytest.approx(0.044, abs=5e-4)


def test_a_plan_walks_the_commanded_speed_but_no_faster_than_v_max():
    assert walk(command(0, 0.08), 1)[0].speed == 0.08
    fast = walk(command(0, 5.0), 4)
    assert fast[1].speed == fast[1].speed_max == pytest.approx(0.108, abs=5e-4)
    assert fast[1].times[-1] == pytest.approx(0.125 / fast[1].speed)
    at_will = walk(command(0, 0.0), 2)
    assert at_will[1].speed == at_will[1].speed_max


def test_the_body_keeps_one_speed_and_the_foot_rises_and_falls_vertically():
    plan = walk(command(28, 0.07), 1)[0]
    (leg,) = plan.swing
    speeds = np.hypot(*np.diff(plan.body[:, :2], axis=0).T) / np.diff(plan.times)
    np.testing.assert_allclose(speeds, 0.07, rtol=1e-9)
    order = [plan.phases[0]] + [
        b for a, b in zip(plan.phases, plan.phases[1:], strict=False) if a is not b
    ]
    assert order == [Phase.SUPPORT, Phase.UP, Phase.RETURN, Phase.DOWN]
    path = plan.feet[:, leg]
    assert path[:, 2].max() == pytest.approx(TITAN.lift_up)
    assert path[-1, 2] == pytest.approx(TITAN.lift_up - TITAN.lift_down), (
        "the aim is not h_up below the ground"
    )
    # (32)
    assert plan.times[list(plan.phases).index(Phase.UP)] == pytest.approx(plan.support_shift / 0.07)


def test_constant_profile_has_the_papers_five_knots():
    plan = walk(command(0, 0.05), 1, settings=gait(smooth=False))[0]
    assert plan.phases == (Phase.SUPPORT, Phase.UP, Phase.RETURN, Phase.DOWN)
