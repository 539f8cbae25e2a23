"""The machine as a tilted body has it: boxes that are mirrored about the centre of gravity in the
sheared frame, and what tilting takes of speed and overreach.

Both papers plan with one box mirrored to four quadrants; a leaning leg reaches a sheared one. Leans
are gradients of the body's floor in body axes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from ..geometry.paths import Box
from ..robot.model import Leg, Machine
from ..robot.quadrants import SIDES, mirrored_part, ordered
from ..types import Gait
from .body_tilt import LEVEL, Lean, reaches

# H a second of every leg's speed kept for the lean itself, per m/m that changes in a step; 0: see
# feet land aside
TURNING = 3.5


def whole_reach(machine: Machine, gait: Gait, leans: Sequence[Lean]) -> Machine | None:
    """The machine with all of its boxes that it has with these leans, whatever the slope; None when
    they are not mirrored anywhere.
    """
    if all(lean == LEVEL for lean in leans):
        return machine
    cosine, boxes = reaches(machine, leans, *machine.z_range)
    box = mirrored_part(boxes)
    if box is None:
        return None
    x1, x2, y1, y2 = box
    whole = x1, x1 + (x2 - x1), y1, y1 + (y2 - y1)  # as lengths are added when only a part fits
    return with_box(machine, gait, leans, whole, machine.z_range, cosine)


def change_of(leans: Sequence[Lean]) -> float:
    """How much the lean changes from the beginning of a step to its end; 0 for leans that are
    alternatives.
    """
    return math.dist(leans[0], leans[1]) if len(leans) == 2 else 0.0


def with_box(
    machine: Machine,
    gait: Gait,
    leans: Sequence[Lean],
    box: Box,
    heights: tuple[float, float],
    cosine: float,
) -> Machine:
    """The machine with this box in every quadrant, in the sheared frame; what leaning takes of its
    speeds and its overreach is taken.
    """
    x1, x2, y1, y2 = box
    z = heights[0] / cosine, heights[1] / cosine
    legs = tuple(
        Leg(leg.name, ordered(sx * x1, sx * x2), ordered(sy * y1, sy * y2), z)
        for leg, (sx, sy) in zip(machine.legs, SIDES, strict=True)
    )
    tilt = max(math.hypot(*lean) for lean in leans)
    if tilt == 0.0:
        return replace(machine, legs=legs)
    turning = TURNING * gait.height * change_of(leans)
    vx, vy, vz = (v - turning for v in machine.speed)
    dx, dy, dz = machine.overreach
    low, high = machine.z_range
    cut = tilt * gait.lift_up
    kept = min(heights[0] - low, high - heights[1])
    return replace(
        machine,
        legs=legs,
        speed=(vx * cosine - vz * tilt, vy * cosine - vz * tilt, vz),
        overreach=(max(0.0, dx - cut), max(0.0, dy - cut), dz + kept),
    )
