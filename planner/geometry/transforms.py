"""Turning and moving points between body axes and the absolute frame: the one place that does.

Angles are radians, right-handed: yaw about +z (to the left), pitch about +y (nose down), roll about
+x (left side up). A *pose* is x, y, yaw on the ground plane; a *body* is x, y, z, yaw. Plain floats
throughout: most of this runs every tick, where numpy on three numbers costs seven times as much.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ..types import Point as Point

XY = tuple[float, float]
Pose = tuple[float, float, float]  # x m, y m, yaw rad
Body = tuple[float, float, float, float]  # x m, y m, z m, yaw rad
Matrix = tuple[Point, Point, Point]  # rows of a rotation matrix


def direction(angle: float) -> XY:
    """Cosine and sine of an angle: the unit vector that points along it."""
    return math.cos(angle), math.sin(angle)


def directions(angles: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Cosines and sines of angles of any shape, for many at once."""
    return np.cos(angles), np.sin(angles)


def turned(x: float, y: float, angle: float) -> XY:
    """A vector turned by an angle, m to m: body axes to absolute axes when the angle is the yaw."""
    c, s = math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y


def turned_back(x: float, y: float, angle: float) -> XY:
    """A vector turned by minus an angle: absolute axes to body axes when the angle is the yaw."""
    c, s = math.cos(angle), math.sin(angle)
    return c * x + s * y, c * y - s * x


def placed(pose: Pose, x: float, y: float) -> XY:
    """A point at (x, y) in body axes where it is in the absolute frame, m."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return pose[0] + c * x - s * y, pose[1] + s * x + c * y


def seen(pose: Pose, x: float, y: float) -> XY:
    """A point at (x, y) of the absolute frame in the axes of a body at ``pose``, m."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    x = x - pose[0]
    y = y - pose[1]
    return c * x + s * y, c * y - s * x


def point_placed(body: Body, point_b: Point) -> Point:
    """A point in level body axes where it is in the absolute frame, m."""
    x, y = placed((body[0], body[1], body[3]), point_b[0], point_b[1])
    return x, y, body[2] + point_b[2]


def point_seen(body: Body, point: Point) -> Point:
    """A point of the absolute frame in the axes of a level body, m."""
    x, y = seen((body[0], body[1], body[3]), point[0], point[1])
    return x, y, point[2] - body[2]


def rotation(roll: float, pitch: float, yaw: float) -> Matrix:
    """Body axes to absolute axes: roll first, then pitch, then yaw (rows of the matrix)."""
    cr, sr = math.cos(roll), math.sin(roll)
    cp, sp = math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def quaternion(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    """The turn of ``rotation`` as a unit quaternion w, x, y, z."""
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def turned_by(matrix: Matrix, vector: Point) -> Point:
    """A vector of body axes in absolute axes, by the rows of a rotation matrix."""
    a, b, c = matrix
    x, y, z = vector
    return (
        a[0] * x + a[1] * y + a[2] * z,
        b[0] * x + b[1] * y + b[2] * z,
        c[0] * x + c[1] * y + c[2] * z,
    )


def turned_back_by(matrix: Matrix, vector: Point) -> Point:
    """A vector of absolute axes in body axes, by the rows of a rotation matrix."""
    a, b, c = matrix
    x, y, z = vector
    return (
        a[0] * x + b[0] * y + c[0] * z,
        a[1] * x + b[1] * y + c[1] * z,
        a[2] * x + b[2] * y + c[2] * z,
    )


def tilted(tilt: Matrix | None, seen: Point) -> Point:
    """A vector in the axes of a level body in those of one that is tilted so."""
    return seen if tilt is None else turned_back_by(tilt, seen)


def attitude_of(gradient: XY, yaw: float) -> XY:
    """Roll and pitch, rad, of a body at ``yaw`` whose floor has this gradient along absolute x and
    y, m per m.
    """
    ahead, left = turned_back(gradient[0], gradient[1], yaw)
    return math.asin(left / math.sqrt(1.0 + ahead * ahead + left * left)), -math.atan(ahead)


def tilt_of(gradient: XY, yaw: float) -> Matrix:
    """Axes of a body with such a floor in those of a level one with the same yaw."""
    return rotation(*attitude_of(gradient, yaw), 0.0)


def left_fold_sum(values: Iterable[float]) -> float:
    """Sum of floats, added one after the other from the left.

    The built-in ``sum`` compensates its rounding from Python 3.12 on, so that it answers otherwise
    than 3.11 in the last bit, and a walk would depend on the Python it is planned by.
    """
    total = 0.0
    for value in values:
        total += value
    return total
