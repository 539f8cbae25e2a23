"""The machine as shapes: legs that join hip, knee and foot, for every leg count."""

import math

import numpy as np
import pytest

from walking_console.planner.robot.model import Machine, as_data, load_machine, machine_from
from walking_console.web.scene.robot_shapes import Figure, attitude, quaternions


def eight_legged() -> Machine:
    xs = [(0.9, 1.5), (0.3, 0.8), (-0.8, -0.3), (-1.5, -0.9)]
    legs = [
        {"name": f"left {i}", "x": list(x), "y": [0.4, 0.8], "z": [-0.8, -0.4]}
        for i, x in enumerate(xs)
    ]
    legs += [
        {"name": f"right {i}", "x": list(x), "y": [-0.8, -0.4], "z": [-0.8, -0.4]}
        for i, x in enumerate(xs[::-1])
    ]
    titan = as_data(load_machine("titan3"))
    plain = {**titan, "name": "spider", "torso": [2.4, 0.6, 0.2], "height": 0.6, "legs": legs}
    return machine_from(plain)


MACHINES = [load_machine("titan3"), load_machine("hexapod"), eight_legged()]


def turned(quaternion: np.ndarray, vector: tuple[float, float, float]) -> np.ndarray:
    w, axis = quaternion[0], quaternion[1:]
    v = np.array(vector)
    return v + 2 * np.cross(axis, np.cross(axis, v) + w * v)


@pytest.mark.parametrize("machine", MACHINES, ids=lambda machine: machine.name)
def test_thigh_and_shin_keep_their_lengths_wherever_the_foot_is(machine: Machine) -> None:
    figure, rng = Figure(machine), np.random.default_rng(2)
    for _ in range(50):
        feet = np.array(
            [
                [rng.uniform(*leg.x), rng.uniform(*leg.y), rng.uniform(*leg.z)]
                for leg in machine.legs
            ]
        )
        hips, knees, thighs, shins = figure.legs(np.zeros(3), np.eye(3), feet)
        ankles = feet + (0.0, 0.0, 0.6 * figure.foot)
        assert np.linalg.norm(knees - hips, axis=1) == pytest.approx(figure.thigh)
        assert np.linalg.norm(ankles - knees, axis=1) == pytest.approx(figure.shin)
        for hip, knee, ankle, thigh, shin in zip(hips, knees, ankles, thighs, shins, strict=True):
            assert turned(thigh, (0, 0, figure.thigh)) == pytest.approx(knee - hip)
            assert turned(shin, (0, 0, figure.shin)) == pytest.approx(ankle - knee)


@pytest.mark.parametrize("machine", MACHINES, ids=lambda machine: machine.name)
def test_knees_point_outwards_and_stay_above_the_ground(machine: Machine) -> None:
    figure = Figure(machine)
    feet = np.array([[*leg.centre, -machine.height] for leg in machine.legs])
    hips, knees, _, _ = figure.legs(np.zeros(3), np.eye(3), feet)
    assert np.all(np.abs(knees[:, 1]) > np.abs(hips[:, 1]))
    assert np.all(knees[:, 2] > -machine.height + 0.2)


@pytest.mark.parametrize("machine", MACHINES, ids=lambda machine: machine.name)
def test_every_part_is_a_file_the_page_can_read(machine: Machine) -> None:
    figure = Figure(machine)
    for part in (figure.torso(), figure.thigh_shape(), figure.shin_shape()):
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
        turn = attitude(roll, pitch, yaw)
        quaternion = quaternions(turn[None])[0]
        for axis in np.eye(3):
            assert turned(quaternion, tuple(axis)) == pytest.approx(turn @ axis, abs=1e-9)


def test_positive_pitch_is_nose_down_and_positive_roll_is_left_side_up() -> None:
    assert (attitude(0.0, 0.1, 0.0) @ (1.0, 0.0, 0.0))[2] < 0.0
    assert (attitude(0.1, 0.0, 0.0) @ (0.0, 1.0, 0.0))[2] > 0.0
