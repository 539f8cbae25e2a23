"""Turning and moving points: against matrices, and there and back again."""

import math

import numpy as np
import pytest

from walking_console.planner.geometry import transforms as tf

ANGLES = [0.0, 0.3, -1.2, math.pi / 2, math.pi, 4.0]
POSE = (1.5, -0.7, 0.9)
BODY = (1.5, -0.7, 0.85, 0.9)
POINT = (0.4, -0.2, 0.1)


def about(axis: int, angle: float) -> np.ndarray:
    """The right-handed rotation about x, y or z."""
    c, s = math.cos(angle), math.sin(angle)
    matrix = np.eye(3)
    one, other = (axis + 1) % 3, (axis + 2) % 3
    matrix[one, one] = matrix[other, other] = c
    matrix[one, other], matrix[other, one] = -s, s
    return matrix


@pytest.mark.parametrize("angle", ANGLES)
def test_a_direction_is_the_unit_vector_along_an_angle(angle):
    assert tf.direction(angle) == (math.cos(angle), math.sin(angle))
    cosines, sines = tf.directions(np.array([[angle, 0.0]]))
    assert (cosines[0, 0], sines[0, 0]) == pytest.approx(tf.direction(angle))
    assert (cosines[0, 1], sines[0, 1]) == (1.0, 0.0)


@pytest.mark.parametrize("angle", ANGLES)
def test_turning_is_the_matrix_about_z_and_turning_back_undoes_it(angle):
    x, y = tf.turned(0.3, -0.8, angle)
    assert (x, y, 0.0) == pytest.approx(tuple(about(2, angle) @ (0.3, -0.8, 0.0)))
    assert tf.turned_back(x, y, angle) == pytest.approx((0.3, -0.8))


def test_a_quarter_turn_brings_what_is_ahead_to_the_left():
    assert tf.turned(1.0, 0.0, math.pi / 2) == pytest.approx((0.0, 1.0))


def test_what_is_placed_by_a_pose_is_seen_where_it_was():
    x, y = tf.placed(POSE, 0.4, -0.2)
    assert tf.seen(POSE, x, y) == pytest.approx((0.4, -0.2))
    assert tf.placed(POSE, 0.0, 0.0) == POSE[:2]


def test_points_keep_their_height_over_a_level_body():
    placed = tf.point_placed(BODY, POINT)
    assert placed[2] == pytest.approx(BODY[2] + POINT[2])
    assert tf.point_seen(BODY, placed) == pytest.approx(POINT)


@pytest.mark.parametrize("yaw", ANGLES)
@pytest.mark.parametrize("pitch", [0.0, -0.3])
@pytest.mark.parametrize("roll", [0.0, 0.2])
def test_a_rotation_is_roll_then_pitch_then_yaw(roll, pitch, yaw):
    matrix = tf.rotation(roll, pitch, yaw)
    assert np.allclose(matrix, about(2, yaw) @ about(1, pitch) @ about(0, roll), atol=1e-15)
    turned = tf.turned_by(matrix, POINT)
    assert turned == pytest.approx(tuple(np.array(matrix) @ POINT))
    assert tf.turned_back_by(matrix, turned) == pytest.approx(POINT)


@pytest.mark.parametrize("yaw", ANGLES)
def test_a_quaternion_turns_as_the_rotation_does(yaw):
    angles = (0.2, -0.3, yaw)
    w, x, y, z = tf.quaternion(*angles)
    assert w * w + x * x + y * y + z * z == pytest.approx(1.0)
    axis, vector = np.array([x, y, z]), np.array(POINT)
    turned = vector + 2.0 * np.cross(axis, np.cross(axis, vector) + w * vector)
    assert tuple(turned) == pytest.approx(tf.turned_by(tf.rotation(*angles), POINT))


def test_nose_down_and_left_side_up_are_positive():
    assert tf.turned_by(tf.rotation(0.0, 0.1, 0.0), (1.0, 0.0, 0.0))[2] < 0.0
    assert tf.turned_by(tf.rotation(0.1, 0.0, 0.0), (0.0, 1.0, 0.0))[2] > 0.0


@pytest.mark.parametrize("yaw", ANGLES)
def test_the_attitude_of_a_gradient_lays_the_floor_of_the_body_along_it(yaw):
    gradient = (0.2, -0.1)
    roll, pitch = tf.attitude_of(gradient, yaw)
    matrix = tf.rotation(roll, pitch, yaw)
    for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)):
        x, y, z = tf.turned_by(matrix, axis)
        assert z == pytest.approx(gradient[0] * x + gradient[1] * y)


def test_a_left_fold_adds_one_after_the_other():
    values = [1e16, 1.0, -1e16, 1.0]
    assert tf.left_fold_sum(values) == ((1e16 + 1.0) - 1e16) + 1.0 == 1.0
    assert math.fsum(values) == 2.0
    assert tf.left_fold_sum([]) == 0.0
