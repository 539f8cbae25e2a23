"""Falling over: a stiff machine turning about an edge of its support like an inverted pendulum."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from walking_console.planner.geometry.transforms import left_fold_sum
from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import GRAVITY, support_polygon

FALL_TILT = 0.6  # rad; leaning further than this is lying
DROP_MAX = 2.0  # m; falling further with nothing below is lying at the bottom of a hole


class Edge(NamedTuple):
    """What the machine turns about: the legs that stand there, a point, a unit axis, and the
    horizontal way out.
    """

    legs: tuple[int, ...]
    point: tuple[float, float, float]
    axis: tuple[float, float, float]
    out: tuple[float, float]


@dataclass
class Fall:
    """A fall in progress. ``edge`` is None while nothing touches the ground."""

    edge: Edge | None
    rate: float = 0.0  # rad/s about the edge, positive outwards
    sink: float = 0.0  # m/s downwards while nothing touches
    dropped: float = 0.0  # m


def edge_of(feet: Mapping[int, Sequence[float]], x: float, y: float) -> Edge | None:
    """The edge of the feet's polygon that (x, y) is furthest beyond; a line or a point when that is
    all there is.
    """
    corner = {(foot[0], foot[1]): leg for leg, foot in feet.items()}
    polygon = support_polygon(feet.values())
    if not polygon:
        return None
    if len(polygon) == 1:
        leg = corner[polygon[0]]
        return _about_point(leg, feet[leg], x, y)
    # of two feet: their line, there and back
    pairs = list(zip(polygon, (*polygon[1:], polygon[0]), strict=True))
    beyond = [
        ((by - ay) * (x - ax) - (bx - ax) * (y - ay)) / math.hypot(bx - ax, by - ay)
        for (ax, ay), (bx, by) in pairs
    ]
    a, b = pairs[beyond.index(max(beyond))]
    return _about_line(corner[a], corner[b], feet[corner[a]], feet[corner[b]])


def _about_line(i: int, j: int, a: Sequence[float], b: Sequence[float]) -> Edge:
    ex, ey, ez = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    long, flat = math.sqrt(ex * ex + ey * ey + ez * ez), math.hypot(ex, ey)
    return Edge(
        (i, j), (a[0], a[1], a[2]), (ex / long, ey / long, ez / long), (ey / flat, -ex / flat)
    )


def _about_point(leg: int, foot: Sequence[float], x: float, y: float) -> Edge:
    ox, oy = x - foot[0], y - foot[1]
    far = math.hypot(ox, oy)
    ox, oy = (ox / far, oy / far) if far > 0.0 else (1.0, 0.0)
    return Edge((leg,), (foot[0], foot[1], foot[2]), (-oy, ox, 0.0), (ox, oy))


def passed_on(old: Edge | None, new: Edge | None, rate: float) -> float:
    """The rate of turning about a new edge: the part of the old turning that is about it; the
    landing foot takes the rest.
    """
    if old is None or new is None:
        return 0.0
    return max(0.0, rate * left_fold_sum(a * b for a, b in zip(old.axis, new.axis, strict=True)))


def carried_over(
    machine: Machine,
    edge: Edge,
    rate: float,
    feet: Mapping[int, Sequence[float]],
    body: Sequence[float],
) -> Fall | None:
    """The fall that goes on when a foot has come down too late: its swing lifts the body over
    another edge. None if caught.
    """
    corner = {(foot[0], foot[1]): leg for leg, foot in feet.items()}
    polygon = support_polygon(feet.values())
    for a, b in zip(polygon, (*polygon[1:], polygon[0]), strict=True):
        new = _about_line(corner[a], corner[b], feet[corner[a]], feet[corner[b]])
        kept = passed_on(edge, new, rate) if new.legs != edge.legs else 0.0
        arm, lever = _arm(machine, new, body)
        rise = math.sqrt(lever * lever + (body[2] - new.point[2]) ** 2) - (body[2] - new.point[2])
        if kept > 0.0 and 0.5 * arm * kept * kept > GRAVITY * rise:
            return Fall(new, kept)
    return None


def angular_acceleration(
    machine: Machine, edge: Edge, body: Sequence[float], push: tuple[float, float]
) -> float:
    """Of a stiff body about an edge, rad/s², under its weight and a horizontal push at its centre
    of gravity.
    """
    arm, lever = _arm(machine, edge, body)
    pushed = (
        (push[0] * edge.out[0] + push[1] * edge.out[1]) * (body[2] - edge.point[2]) / machine.mass
    )
    return (GRAVITY * lever + pushed) / arm


def _arm(machine: Machine, edge: Edge, body: Sequence[float]) -> tuple[float, float]:
    """Moment of inertia about an edge over the mass, m², and how far the centre of gravity is
    beyond it, m.
    """
    rx, ry, rz = body[0] - edge.point[0], body[1] - edge.point[1], body[2] - edge.point[2]
    along = rx * edge.axis[0] + ry * edge.axis[1] + rz * edge.axis[2]
    length, width, height = machine.torso
    gyration = (min(length, width) ** 2 + height**2) / 12.0  # about the weaker horizontal axis
    return rx * rx + ry * ry + rz * rz - along * along + gyration, rx * edge.out[0] + ry * edge.out[
        1
    ]
