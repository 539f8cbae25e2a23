"""Whether the legs of a standing or moving machine run through something: poles and rocks beside
its feet.

K's third truncation ("non-touching the surface") for what stands taller than a step. A leg is the
straight line from hip to foot tip; that is the lowest a real leg, knee outward and up, can be, so
this errs on the careful side.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..terrain.map import TerrainMap
from ..types import Point
from .model import Machine

# m over the lowest foot; lower things pass under every leg's line but for its last centimetres
TALL = 0.35
# m of the line nearest the foot that is not looked at: the foothold itself is checked elsewhere
NEAR_FOOT = 0.06


def something_tall(
    terrain: TerrainMap, machine: Machine, x: float, y: float, lowest: float
) -> bool:
    """True when anything within reach of a body at (x, y) is tall enough to meet a leg; cheap, and
    mostly False.
    """
    if terrain.highest - lowest <= TALL:
        return False
    reach = (
        max(math.hypot(max(map(abs, leg.x)), max(map(abs, leg.y))) for leg in machine.legs) + 0.3
    )
    return terrain.crest_in(x - reach, x + reach, y - reach, y + reach) - lowest > TALL


def leg_in_the_way(
    terrain: TerrainMap,
    machine: Machine,
    body: tuple[float, float, float, float],
    feet: Sequence[Point | None],
) -> int | None:
    """The first leg whose line meets ground, with the body at x, y, z, yaw; a leg whose foot is
    None is not looked at.
    """
    x, y, z, yaw = body
    c, s = math.cos(yaw), math.sin(yaw)
    cell, columns, rows, heights = terrain.cell, terrain.columns, terrain.rows, terrain.height_view
    for leg, foot in enumerate(feet):
        if foot is None:
            continue
        hip_x, hip_y = machine.hips[leg]
        hx, hy = x + c * hip_x - s * hip_y, y + s * hip_x + c * hip_y
        length = math.hypot(foot[0] - hx, foot[1] - hy)
        if length <= NEAR_FOOT:
            continue
        samples = math.ceil((length - NEAR_FOOT) / cell)
        share = (length - NEAR_FOOT) / length / samples
        gx, gy, gz = (hx - terrain.origin[0]) / cell, (hy - terrain.origin[1]) / cell, z
        dx, dy, dz = (
            share * (foot[0] - hx) / cell,
            share * (foot[1] - hy) / cell,
            share * (foot[2] - z),
        )
        for _ in range(samples + 1):
            column, row = int(gx), int(gy)
            if 0 <= column < columns and 0 <= row < rows and heights[row * columns + column] > gz:
                return leg
            gx, gy, gz = gx + dx, gy + dy, gz + dz
    return None
