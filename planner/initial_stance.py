"""A posture of one's own choosing to begin in, instead of the standard one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from .robot.model import Machine
from .stability import polygon_margin, support_polygon
from .types import Gait, Point, Stance


def stance_on(
    machine: Machine,
    gait: Gait,
    feet: Sequence[Sequence[float]],
    x: float,
    y: float,
    yaw: float,
    height_at: Callable[[float, float], float],
) -> Stance:
    """Feet (x, y in body axes, leg order) on the ground and the body H above their mean; raises
    ``ValueError`` when it cannot stand so.
    """
    if len(feet) != len(machine.legs):
        raise ValueError(f"{machine.name} has {len(machine.legs)} legs, got {len(feet)} feet")
    for number, ((fx, fy), (x1, x2, y1, y2)) in enumerate(zip(feet, machine.boxes, strict=True), 1):
        if not (x1 <= fx <= x2 and y1 <= fy <= y2):
            raise ValueError(
                f"foot {number} must be within x [{x1:g}, {x2:g}], y [{y1:g}, {y2:g}] of the body, got ({fx:g}, {fy:g})"
            )
    margin = polygon_margin(support_polygon([(fx, fy) for fx, fy in feet]), 0.0, 0.0)
    if margin < 0.0:
        raise ValueError(f"the centre of gravity is {-margin:.3f} m outside the feet")
    c, s = math.cos(yaw), math.sin(yaw)
    places = [(x + c * fx - s * fy, y + s * fx + c * fy) for fx, fy in feet]
    heights = [height_at(px, py) for px, py in places]
    if any(h != h for h in heights):
        raise ValueError("a foot is over a hole")
    tips: tuple[Point, ...] = tuple(
        (px, py, h) for (px, py), h in zip(places, heights, strict=True)
    )
    low, high = machine.z_range
    z = min(max(sum(heights) / len(heights) + gait.height, max(heights) - high), min(heights) - low)
    return Stance((x, y, z, yaw), tips)
