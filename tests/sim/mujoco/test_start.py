"""A machine put down on its ground neither drops nor sinks when it is let go."""

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install mujoco-core")

from walking_console.planner.robot.kinematics import forward
from walking_console.planner.robot.model import load_machine
from walking_console.planner.types import Stance
from walking_console.sim.mujoco.bodies import Bodies
from walking_console.sim.mujoco.contacts import FootContacts
from walking_console.sim.mujoco.settings import Physics
from walking_console.sim.mujoco.start import set_down
from walking_console.sim.terrain.ground import Ground

TITAN = load_machine("titan3")
LEVEL = Ground(np.zeros((80, 80)), 0.05, (-2.0, -2.0))
FEET = tuple((*leg.centre, 0.0) for leg in TITAN.legs)


def put(stance: Stance):
    contact, bodies = FootContacts(TITAN, LEVEL), Bodies(TITAN, LEVEL, Physics())
    return set_down(bodies, LEVEL, stance, contact), contact, bodies


def test_servos_aim_below_the_ground_by_what_their_legs_give():
    joints, contact, bodies = put(Stance((0.0, 0.0, TITAN.height, 0.0), FEET))
    assert contact.soles == [True] * 4
    assert sum(contact.loads) == pytest.approx(80.0 * 9.81)
    for chain, values in zip(TITAN.chains, joints, strict=True):
        # a quarter of the weight less the leg itself, which the ground carries too
        give = 0.005 * (1.0 - 0.12)
        assert forward(chain, values)[2] == pytest.approx(-TITAN.height - give, abs=1e-9)
    assert np.allclose([foot[2] for foot in bodies.joints()], -TITAN.height)


def test_a_lifted_foot_carries_nothing_and_hangs_by_its_own_weight():
    feet = ((FEET[0][0], FEET[0][1], 0.1), *FEET[1:])
    body = (-0.1, -0.1, TITAN.height, 0.0)
    joints, contact, _ = put(Stance(body, feet, lifted=(0,)))
    assert contact.soles == [False, True, True, True]
    assert contact.loads[0] == 0.0
    assert forward(TITAN.chains[0], joints[0])[2] > 0.1 - TITAN.height


def test_a_stance_out_of_reach_is_refused_with_leg_and_place():
    with pytest.raises(ValueError, match=r"leg 1 cannot reach \(.*\) of its start stance"):
        put(Stance((-2.0, 0.0, TITAN.height, 0.0), FEET))
