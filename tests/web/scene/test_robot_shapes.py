"""The machine as shapes: legs that join hip, knee and foot, for every leg count."""

import math

import numpy as np
import pytest

from tests.web.scene.snapshots import eight_legged
from walking_console.planner.geometry.transforms import rotation
from walking_console.planner.robot.model import Machine, load_machine
from walking_console.web.scene.robot_shapes import ANKLE, RobotShapes, bend, quaternions

MACHINES = [load_machine("titan3"), load_machine("hexapod"), eight_legged()]


def turned(quaternion: np.ndarray, vector: tuple[float, float, float]) -> np.ndarray:
    w, axis = quaternion[0], quaternion[1:]
    v = np.array(vector)
    return v + 2 * np.cross(axis, np.cross(axis, v) + w * v)


@pytest.mark.parametrize("machine", MACHINES, ids=lambda machine: machine.name)
def test_thigh_and_shin_keep_their_lengths_wherever_the_foot_is(machine: Machine) -> None:
    shapes = RobotShapes(machine)
    rng = np.random.default_rng(2)
    for _ in range(50):
        feet = np.array(
            [
                [rng.uniform(*leg.x), rng.uniform(*leg.y), rng.uniform(*leg.z)]
                for leg in machine.legs
            ]
        )
        hips, knees, thighs, shins = shapes.legs(np.zeros(3), np.eye(3), feet)
        ankles = feet + (0.0, 0.0, ANKLE * shapes.foot)
        assert np.linalg.norm(knees - hips, axis=1) == pytest.approx(shapes.thigh)
        assert np.linalg.norm(ankles - knees, axis=1) == pytest.approx(shapes.shin)
        for hip, knee, ankle, thigh, shin in zip(hips, knees, ankles, thighs, shins, strict=True):
            assert turned(thigh, (0, 0, shapes.thigh)) == pytest.approx(knee - hip)
            assert turned(shin, (0, 0, shapes.shin)) == pytest.approx(ankle - knee)


@pytest.mark.parametrize("machine", MACHINES, ids=lambda machine: machine.name)
def test_knees_point_outwards_and_stay_above_the_ground(machine: Machine) -> None:
    shapes = RobotShapes(machine)
    feet = np.array([[*leg.centre, -machine.height] for leg in machine.legs])
    hips, knees, _, _ = shapes.legs(np.zeros(3), np.eye(3), feet)
    assert np.all(np.abs(knees[:, 1]) > np.abs(hips[:, 1]))
    assert np.all(knees[:, 2] > -machine.height + 0.2)


@pytest.mark.parametrize("machine", MACHINES, ids=lambda machine: machine.name)
def test_every_part_is_a_file_the_page_can_read(machine: Machine) -> None:
    shapes = RobotShapes(machine)
    for part in (shapes.torso(), shapes.thigh_shape(), shapes.shin_shape()):
        assert part.startswith(b"glTF")
        assert len(part) < 100_000


def test_quaternions_are_right_for_every_half_turn_too() -> None:
    rng = np.random.default_rng(7)
    angles = [
        (0.0, 0.0, math.pi),
        (math.pi, 0.0, 0.0),
        (0.0, math.pi, 0.0),
        *rng.uniform(-3, 3, (50, 3)),
    ]
    for roll, pitch, yaw in angles:
        turn = np.array(rotation(roll, pitch, yaw))
        quaternion = quaternions(turn[None])[0]
        for axis in np.eye(3):
            assert turned(quaternion, tuple(axis)) == pytest.approx(turn @ axis, abs=1e-9)


def test_a_foot_out_of_reach_gets_a_straight_leg() -> None:
    hip = np.zeros((1, 3))
    foot = np.array([(0.0, 3.0, -4.0)])
    knee = bend(hip, foot, np.array([(0.0, 0.0, 1.0)]), 0.4, 0.6)
    assert knee[0] == pytest.approx((0.0, 0.24, -0.32), abs=2e-3)
