"""Where everything of the machine is."""

import numpy as np
import pytest

from tests.sim.kinematic.machines import made, standing
from walking_console.sim.kinematic.configuration import SOLE_GAP
from walking_console.sim.kinematic.rest_pose import (
    rotation,
    turned,
)


def test_the_monitors_say_where_the_feet_are():
    plant, rng = standing(ground=made("rough")), np.random.default_rng(2)
    for _ in range(400):
        plant.move([tuple(v) for v in rng.normal(0, 0.1, (4, 3)).tolist()])
        sensing = plant.sense()
        r = rotation(*sensing.body[3:])
        for foot, foot_b, sole in zip(plant.feet, sensing.feet_b, sensing.soles, strict=True):
            where = [b + t for b, t in zip(sensing.body, turned(r, *foot_b), strict=False)]
            assert where == pytest.approx(foot, abs=2 * SOLE_GAP if sole else 1e-9)
