"""The common walking tick: the body moves, carrying feet do not."""

import math

import numpy as np
import pytest

from tests.sim.kinematic.machines import TITAN, all_legs, feet_of, standing
from walking_console.planner.types import TICK


def test_carrying_feet_stay_where_they_are_to_the_last_bit():
    plant, rng = standing(), np.random.default_rng(1)
    stood = feet_of(plant)
    for _ in range(2000):
        x, y, z = (plant.body[0], plant.body[1], plant.body[2] - TITAN.height)
        vx, vy, vz = (float(v) for v in rng.normal(0, 0.2, 3) + 3.0 * np.array([x, y, z]))
        plant.move(all_legs(vx, vy, vz))
    assert feet_of(plant) == stood
    assert plant.soles == [True] * 4
    assert not any(plant.q.slipping)


def test_a_turn_leaves_them_there_too():
    plant = standing()
    stood = feet_of(plant)
    for k in range(200):
        c, s = math.cos(0.002), math.sin(0.002) * (1 if k < 100 else -1)
        plant.move(
            [
                ((c * x + s * y - x) / TICK, (c * y - s * x - y) / TICK, 0.0)
                for x, y, _ in plant.sense().feet_b
            ]
        )
        if k == 99:
            assert plant.body[5] == pytest.approx(0.2)
    assert feet_of(plant) == stood
    assert plant.body == pytest.approx([0.0, 0.0, TITAN.height, 0.0, 0.0, 0.0], abs=1e-9)
