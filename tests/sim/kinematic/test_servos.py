"""Servos follow their speed up to the limits of the machine."""

import math

import numpy as np
import pytest

from tests.sim.kinematic.machines import TITAN, one_leg, run, standing
from walking_console.planner.types import TICK
from walking_console.sim.kinematic.servos import Servos


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


def test_legs_given_one_velocity_go_one_way_but_for_one_at_the_end_of_its_reach():
    servos = Servos(TITAN)
    tips = [
        [(low + high) / 2 for low, high in zip(box[::2], box[1::2], strict=True)]
        for box in servos.reach
    ]
    tips[2][0] = servos.reach[2][1] - 0.001
    shared = (0.5, -0.25, 0.125)
    first, second, at_the_end, last = servos.motions([shared] * 4, tips)
    assert first == (0.5 * TICK, -0.25 * TICK, 0.125 * TICK)
    assert first is second is last
    assert at_the_end == (pytest.approx(0.001), *first[1:])
