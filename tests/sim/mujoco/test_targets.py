"""Where the servos are to be."""

import math

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install mujoco-core")

from walking_console.planner.geometry.transforms import rotation
from walking_console.planner.robot.kinematics import inverse
from walking_console.planner.robot.model import load_machine
from walking_console.planner.types import TICK
from walking_console.sim.mujoco.targets import Targets, pressing

STILL = (0.0, 0.0, 0.0)
LEVEL = rotation(0.0, 0.0, 0.0)


def standing(name: str):
    machine = load_machine(name)
    feet = [(*leg.centre, -machine.height) for leg in machine.legs]
    joints = [inverse(chain, foot) for chain, foot in zip(machine.chains, feet, strict=True)]
    return machine, joints, Targets(machine, joints, 0.05)


def test_a_foot_goes_as_far_as_its_speed_says():
    _, _, targets = standing("titan3")
    before = list(targets.feet)
    targets.drive([(0.3, -0.2, 0.1), STILL, STILL, STILL], before)
    gone = [b - a for a, b in zip(before[0], targets.feet[0], strict=True)]
    assert gone == pytest.approx([0.3 * TICK, -0.2 * TICK, 0.1 * TICK])
    assert targets.feet[1:] == before[1:]


def test_no_faster_than_the_machine_no_further_than_it_reaches_and_not_at_nothing():
    machine, _, targets = standing("titan3")
    before = list(targets.feet)
    targets.drive([(50.0, math.nan, 0.0), STILL, STILL, STILL], before)
    assert targets.feet[0][0] - before[0][0] == pytest.approx(machine.speed[0] * TICK)
    assert targets.feet[0][1] == before[0][1]
    for _ in range(100):
        targets.drive([(50.0, 0.0, 0.0), STILL, STILL, STILL], targets.feet)
    assert targets.feet[0][0] == pytest.approx(machine.legs[0].x[1] + machine.overreach[0])


def test_a_target_does_not_run_away_from_a_foot_that_is_held():
    _, _, targets = standing("titan3")
    held = list(targets.feet)
    for _ in range(100):
        targets.drive([(0.5, 0.0, 0.0), STILL, STILL, STILL], held)
    assert targets.feet[0][0] - held[0][0] == pytest.approx(0.05)


def test_joints_are_not_driven_faster_than_their_drives():
    machine, joints, targets = standing("phantomx")
    there = list(targets.feet)
    there[0] = (there[0][0] + 0.05, there[0][1] - 0.04, there[0][2] + 0.03)
    targets.follow(there)
    for old, new in zip(joints[0], targets.joints[0], strict=True):
        assert abs(new - old) <= 5.65 * TICK + 1e-9
    for _ in range(10):
        targets.follow(there)
    assert targets.feet[0] == pytest.approx(there[0], abs=1e-9)


def test_a_target_out_of_reach_is_not_taken():
    _, _, targets = standing("phantomx")
    before = targets.feet[0]
    targets.follow([(5.0, 5.0, 5.0), *targets.feet[1:]])
    assert targets.feet[0] == before


def test_slides_press_down_with_their_load_less_the_leg_that_hangs_on_them():
    machine, joints, _ = standing("titan3")
    forces = pressing(machine, joints, [200.0, 0.0, 0.0, 0.0], LEVEL).reshape(4, 3)
    weight = 2.4 * 9.81
    assert forces[0] == pytest.approx([0.0, 0.0, -200.0 + weight], abs=1e-9)
    assert forces[1] == pytest.approx([0.0, 0.0, weight], abs=1e-9)


def test_a_leaning_body_presses_straight_down():
    machine, joints, _ = standing("titan3")
    forces = pressing(machine, joints, [200.0] * 4, rotation(0.0, 0.2, 0.0)).reshape(4, 3)
    down = 200.0 - 2.4 * 9.81
    wanted = [down * math.sin(0.2), 0.0, -down * math.cos(0.2)]
    assert np.allclose(forces, wanted)
