"""Postures to begin a walk in: every foot in the middle of its reach, or where one wants them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from .geometry.transforms import XY, Pose, left_fold_sum, placed
from .protocols import Capabilities
from .robot.model import Machine
from .stability import polygon_margin, support_polygon
from .types import Gait, Point, Stance

HeightAt = Callable[[float, float], float]  # m at x, y; NaN over a hole


@dataclass(frozen=True, slots=True)
class Placement:
    """Where a machine is set down, and for which course."""

    pose: Pose
    height_at: HeightAt
    crab_angle: float = 0.0  # rad, of the first course


# for a planner that declares this
StanceMaker = Callable[[Machine, Gait, Placement, Capabilities], Stance]


def square_stance(machine: Machine, gait: Gait, place: Placement, _: object = None) -> Stance:
    """Every foot in the middle of its reach, the body H above their mean; over a hole a foot hangs
    at NaN.
    """
    x, y, yaw = place.pose
    feet: list[Point] = []
    for leg in machine.legs:
        fx, fy = placed(place.pose, *leg.centre)
        feet.append((fx, fy, place.height_at(fx, fy)))
    level = [z for _, _, z in feet if z == z] or [0.0]
    return Stance((x, y, left_fold_sum(level) / len(level) + gait.height, yaw), tuple(feet))


def stance_on(
    machine: Machine,
    gait: Gait,
    feet: Sequence[Sequence[float]],
    x: float,
    y: float,
    yaw: float,
    height_at: HeightAt,
) -> Stance:
    """Feet (x, y in body axes, leg order) on the ground and the body H above their mean; raises
    ``ValueError`` when it cannot stand so.
    """
    if len(feet) != len(machine.legs):
        raise ValueError(f"{machine.name} has {len(machine.legs)} legs, got {len(feet)} feet")
    for number, ((fx, fy), (x1, x2, y1, y2)) in enumerate(zip(feet, machine.boxes, strict=True), 1):
        if not (x1 <= fx <= x2 and y1 <= fy <= y2):
            raise ValueError(
                f"foot {number} must be within x [{x1:g}, {x2:g}], y [{y1:g}, {y2:g}] "
                f"of the body, got ({fx:g}, {fy:g})"
            )
    margin = polygon_margin(support_polygon([(fx, fy) for fx, fy in feet]), 0.0, 0.0)
    if margin < 0.0:
        raise ValueError(f"the centre of gravity is {-margin:.3f} m outside the feet")
    places = [placed((x, y, yaw), fx, fy) for fx, fy in feet]
    if any(math.isnan(height_at(px, py)) for px, py in places):
        raise ValueError("a foot is over a hole")
    return standing(machine, gait, (x, y, yaw), places, height_at)


def standing(
    machine: Machine, gait: Gait, pose: Pose, places: Sequence[XY], height_at: HeightAt
) -> Stance:
    """Feet at absolute places on the ground, over a hole at the mean of the others, and the body H
    above their mean as far as the legs reach.
    """
    heights = [height_at(px, py) for px, py in places]
    solid = [z for z in heights if z == z]
    ground = left_fold_sum(solid) / len(solid) if solid else 0.0
    feet = tuple(
        (px, py, z if z == z else ground) for (px, py), z in zip(places, heights, strict=True)
    )
    low, high = machine.z_range
    highest = min(foot[2] for foot in feet) - low
    z = min(max(ground + gait.height, max(foot[2] for foot in feet) - high), highest)
    x, y, yaw = pose
    return Stance((x, y, z, yaw), feet)
