"""The walk without search domains that H §5.3 warns of."""

import math

import numpy as np
import pytest

from tests.planner.crab.crab_walks import TITAN, Blocked, command, gait, holes, random_stance
from walking_console.planner.crab.baseline import longest_step, plan_step
from walking_console.planner.crab.gait import nominal_gait, posture_of, standard_stance
from walking_console.planner.crab.leg_selection import shift_of
from walking_console.planner.crab.steps import Shift, StepRequest
from walking_console.planner.initial_stance import Placement
from walking_console.planner.motion.leg_order import SUCCESSOR

FLAT = holes()


def naive_walk(stance, steps, terrain=FLAT):
    plans = []
    for _ in range(steps):
        plan = plan_step(StepRequest(stance, command(), terrain, TITAN, gait()))
        plans.append(plan)
        if isinstance(plan, Blocked):
            break
        stance = plan.end
    return plans


def test_from_the_standard_posture_it_walks_the_standard_sequence():
    stance = standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), FLAT.height_at))
    plans = naive_walk(stance, 8)
    assert not isinstance(plans[-1], Blocked)
    legs = [plan.swing[0] for plan in plans]
    assert all(SUCCESSOR[a] == b for a, b in zip(legs, legs[1:], strict=False))


def test_from_odd_postures_it_comes_to_a_standstill_on_level_ground():
    rng = np.random.default_rng(2)
    ends = [naive_walk(random_stance(rng), 40)[-1] for _ in range(20)]
    assert sum(isinstance(end, Blocked) for end in ends) > 5


@pytest.mark.parametrize("degrees", [0, 30, -40])
def test_the_foot_goes_straight_on_to_the_edge_of_its_reach(degrees):
    nominal = nominal_gait(TITAN, gait(), math.radians(degrees))
    rng = np.random.default_rng(degrees % 7)
    ux, uy, _ = nominal.path
    straight = 0
    for _ in range(40):
        posture = posture_of(nominal, random_stance(rng))
        shift = shift_of(posture, 0)
        if not isinstance(shift, Shift):
            continue
        step = longest_step(posture, shift)
        x, y = step.landing.x - shift.g * ux, step.landing.y - shift.g * uy
        x1, x2, y1, y2 = nominal.boxes[0]
        assert min(abs(x - x1), abs(x - x2), abs(y - y1), abs(y - y2)) < 1e-9
        fx, fy = posture.feet[0]
        if not (x1 <= fx - shift.g * ux <= x2 and y1 <= fy - shift.g * uy <= y2):
            continue  # it would leave its reach before: then from the edge on
        straight += 1
        assert abs(ux * (step.landing.y - fy) - uy * (step.landing.x - fx)) < 1e-9
    assert straight > 5


def test_a_prohibited_cell_under_its_one_foothold_blocks_it():
    stance = standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), FLAT.height_at))
    end = naive_walk(stance, 1, holes(1.0))[-1]
    assert isinstance(end, Blocked) and "prohibited cell" in end.text and end.leg == 2
