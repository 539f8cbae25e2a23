"""Servos follow their speed up to the limits of the machine."""

import math

import numpy as np

from tests.sim.kinematic.machines import TITAN, one_leg, run, standing
from walking_console.planner.types import TICK


def test_no_foot_moves_faster_than_its_limit_nor_beyond_its_mechanical_reach():
    plant, rng = standing(up={0: 0.2}, x=-0.1, y=-0.1), np.random.default_rng(3)
    (dx, dy, dz), leg = TITAN.overreach, TITAN.legs[0]
    before = plant.sense().feet_b[0]
    for _ in range(500):
        plant.move(one_leg(0, tuple(float(v) for v in rng.normal(0, 3, 3))))
        now = plant.sense().feet_b[0]
        assert all(
            abs(a - b) <= limit * TICK + 1e-12
            for a, b, limit in zip(now, before, TITAN.speed, strict=True)
        )
        for value, (low, high), slack in zip(now, (leg.x, leg.y, leg.z), (dx, dy, dz), strict=True):
            assert low - slack - 1e-9 <= value <= high + slack + 1e-9
        before = now


def test_a_velocity_that_is_no_number_moves_nothing():
    plant = run(standing(), [(math.nan, math.inf, -math.inf)] * 4, 1)
    assert plant.body[0] == 0.0
    assert all(math.isfinite(value) for value in plant.body)
