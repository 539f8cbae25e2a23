"""Leg transfers (K "local prediction"): how high a foot is carried, where it waits in the air, and
what its way must clear.

In body axes a foot goes straight from where it leaves the ground to where it comes down, inside its
own reach rectangle; rectangles of different legs do not overlap, so it passes no other leg nearer
than its two ends do.
"""

from __future__ import annotations

import math

from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Gait, Point

CLEARANCE = 0.02  # m, air under a foot that is carried over the highest ground on its way

Pose = tuple[float, float, float, float]  # x, y, z, yaw


def seen_from(pose: Pose, point: Point) -> Point:
    """An absolute point in body axes."""
    c, d = math.cos(pose[3]), math.sin(pose[3])
    x, y = point[0] - pose[0], point[1] - pose[1]
    return c * x + d * y, c * y - d * x, point[2] - pose[2]


def placed_by(pose: Pose, point_b: Point) -> Point:
    """A point in body axes where it is in the absolute frame."""
    c, d = math.cos(pose[3]), math.sin(pose[3])
    return (
        pose[0] + c * point_b[0] - d * point_b[1],
        pose[1] + d * point_b[0] + c * point_b[1],
        pose[2] + point_b[2],
    )


def waiting_place(machine: Machine, leg: int, gait: Gait, terrain: TerrainMap) -> Point:
    """Where a leg that stays lifted is carried, in body axes: over the middle of its rectangle;
    drawn right up where ground may rise.
    """
    x, y = machine.legs[leg].centre
    top = machine.legs[leg].z[1] + machine.overreach[2]
    return x, y, min(-gait.height + gait.lift_up, top) if terrain.is_level else top


def carry_height(start: Point, end: Point, terrain: TerrainMap, gait: Gait) -> float:
    """Absolute height of the way over the ground: h_up above both ends and clear of everything
    between.
    """
    top = max(start[2], end[2]) + gait.lift_up
    if terrain.is_level:
        return top
    return max(top, terrain.crest_between(start[0], start[1], end[0], end[1]) + CLEARANCE)


def aim_of(landing: Point, body_z: float, leg: int, machine: Machine, gait: Gait) -> Point:
    """What a foot coming down aims at: h_up below the ground it expects, so that touch decides (H
    §4.5).
    """
    bottom = body_z + machine.legs[leg].z[0] - machine.overreach[2]
    return landing[0], landing[1], min(landing[2], max(landing[2] - gait.lift_up, bottom))
