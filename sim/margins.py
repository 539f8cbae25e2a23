"""How far a machine is from tipping: every margin of one moment."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from walking_console.planner import stability
from walking_console.planner.geometry.transforms import (
    Point,
    direction,
    left_fold_sum,
    rotation,
    turned_back_by,
    turned_by,
)
from walking_console.planner.robot.model import Machine
from walking_console.planner.statics import centre_of_gravity

Place = Sequence[float]


class Margins(NamedTuple):
    """Of the feet meant to carry, m. ``longitudinal`` is that of the body's origin along its course
    (H §2.4), ``polygon`` that of the body's origin, which planners go by, and ``capture`` that of
    the true centre of gravity, legs included.
    """

    longitudinal: float
    polygon: float
    capture: float  # distance from the polygon's edge less what a dead stop needs


def true_centre(machine: Machine, body: Place, feet: Sequence[Place]) -> Point:
    """The centre of gravity of torso and legs, absolute, m."""
    x, y, z, roll, pitch, yaw = body
    turn = rotation(roll, pitch, yaw)
    feet_b = [turned_back_by(turn, (fx - x, fy - y, fz - z)) for fx, fy, fz in feet]
    cx, cy, cz = turned_by(turn, centre_of_gravity(machine, feet_b))
    return x + cx, y + cy, z + cz


def margins_of(
    machine: Machine,
    body: Place,
    feet: Sequence[Place],
    on: Sequence[Place],
    heading: float,
    velocity: tuple[float, float],
) -> Margins:
    """Margins of a machine that stands on the feet ``on`` and moves at ``velocity``, m/s, its
    course towards ``heading``, rad.
    """
    polygon = stability.support_polygon(on)
    along = direction(heading)
    longitudinal = stability.longitudinal_margin(polygon, body[0], body[1], *along)
    x, y, z = true_centre(machine, body, feet)
    height = z - left_fold_sum(foot[2] for foot in on) / len(on) if on else 0.0
    return Margins(
        longitudinal,
        stability.polygon_margin(polygon, body[0], body[1]),
        stability.capture_margin(polygon, x, y, velocity, height),
    )
