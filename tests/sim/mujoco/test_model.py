"""The machine as MuJoCo's bodies."""

import copy

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install mujoco-core")

from walking_console.planner.robot.kinematics import forward, jacobian
from walking_console.planner.robot.model import Machine, as_data, load_machine, machine_from
from walking_console.planner.types import Stance
from walking_console.sim.mujoco.bodies import Bodies
from walking_console.sim.mujoco.model import leg_drive, standard_joints
from walking_console.sim.mujoco.plant import PhysicsPlant
from walking_console.sim.mujoco.settings import Physics, ServoSettings
from walking_console.sim.terrain.ground import Ground

LEVEL = Ground(np.zeros((80, 80)), 0.05, (-2.0, -2.0))


def dog() -> Machine:
    """A quadruped on mammal legs, fitted to titan3's size."""
    data = copy.deepcopy(as_data(load_machine("titan3")))
    del data["masses"]
    data["height"] = 0.8
    for leg in data["legs"]:
        side = 1.0 if leg["y"][1] > 0.0 else -1.0
        ahead = 1.0 if leg["x"][1] > 0.0 else -1.0
        leg["hip"] = [0.45 * ahead, 0.3 * side, 0.0]
        leg["x"] = sorted([0.3 * ahead, 0.6 * ahead])
        leg["y"] = sorted([0.35 * side, 0.55 * side])
        leg["z"] = [-0.9, -0.6]
        leg["chain"] = {
            "kind": "mammal",
            "links": [0.1, 0.6, 0.6],
            "limits": [[-1.0, 1.0], [-1.5, 1.5], [0.1, 2.8]],
            "speed": [6.0, 6.0, 6.0],
            "torque": [400.0, 400.0, 400.0],
        }
    return machine_from(data)


@pytest.mark.parametrize("name", ["titan3", "hexapod", "phantomx"])
def test_feet_are_where_the_kinematics_have_them_and_the_machine_weighs_what_the_card_says(name):
    machine = load_machine(name)
    bodies = Bodies(machine, LEVEL, Physics())
    joints = [standard_joints(machine, leg) for leg in range(len(machine.legs))]
    bodies.place((0.3, -0.2, 1.0, 0.7), joints)
    assert bodies.built.model.body_mass.sum() == pytest.approx(machine.mass)
    for leg, chain in enumerate(machine.chains):
        ball = bodies.data.geom(f"foot {leg}").xpos
        x, y, z = forward(chain, joints[leg])
        c, s = np.cos(0.7), np.sin(0.7)
        tip = np.array([0.3 + c * x - s * y, -0.2 + s * x + c * y, 1.0 + z])
        assert np.linalg.norm(ball - tip) == pytest.approx(Physics().tip, abs=1e-9)


def test_a_foot_gives_by_its_sag_whatever_the_kind_of_leg():
    for name in ("titan3", "phantomx"):
        machine = load_machine(name)
        drive = leg_drive(machine, 0, Physics(ServoSettings(sag=0.004)))
        rows = np.array(jacobian(machine.chains[0], standard_joints(machine, 0)))
        give = rows @ np.diag(1.0 / np.array(drive.stiffness)) @ rows.T
        share = machine.mass * 9.81 / len(machine.legs)
        assert give[2, 2] * share == pytest.approx(0.004)


def test_a_machine_on_mammal_legs_stands_and_walks_a_little():
    machine = dog()
    feet = tuple((*leg.centre, 0.0) for leg in machine.legs)
    plant = PhysicsPlant(machine, LEVEL, Stance((0.0, 0.0, machine.height, 0.0), feet))
    for _ in range(50):
        plant.move([(-0.05, 0.0, 0.0)] * 4)
    assert plant.state == "standing"
    assert plant.body[0] == pytest.approx(0.05, abs=5e-3)
    assert plant.body[2] == pytest.approx(machine.height, abs=5e-3)
