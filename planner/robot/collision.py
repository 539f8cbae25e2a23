"""Whether the legs of a standing or moving machine run through something: poles and rocks beside
its feet.

K's third truncation ("non-touching the surface") for what stands taller than a step. A leg is the
straight line from hip to foot tip; that is the lowest a real leg, knee outward and up, can be, so
this errs on the careful side.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..geometry.transforms import placed
from ..terrain.map import TerrainMap
from ..types import Point
from .model import Machine

# m over the lowest foot; lower things pass under every leg's line but for its last centimetres
TALL = 0.35
# m of the line nearest the foot that is not looked at: the foothold itself is checked elsewhere
NEAR_FOOT = 0.06
BEYOND = 0.3  # m beyond the reach of the legs that is looked at for something tall: a stride


def something_tall(
    terrain: TerrainMap, machine: Machine, x: float, y: float, lowest: float
) -> bool:
    """True when anything within reach of a body at (x, y) is tall enough to meet a leg; cheap, and
    mostly False.
    """
    if terrain.highest - lowest <= TALL:
        return False
    reach = BEYOND + max(
        math.hypot(max(map(abs, leg.x)), max(map(abs, leg.y))) for leg in machine.legs
    )
    return terrain.crest_in(x - reach, x + reach, y - reach, y + reach) - lowest > TALL


def leg_in_the_way(
    terrain: TerrainMap,
    machine: Machine,
    body: tuple[float, float, float, float],
    feet: Sequence[Point | None],
) -> int | None:
    """The first leg whose line meets ground, the ``body`` at x, y, z, yaw; None when none does.

    ``feet`` are absolute, one for each leg; a leg whose foot is None is not looked at.
    """
    x, y, z, yaw = body
    for leg, foot in enumerate(feet):
        if foot is not None:
            hip_x, hip_y = placed((x, y, yaw), *machine.hips[leg])
            if _meets_ground(terrain, (hip_x, hip_y, z), foot):
                return leg
    return None


def _meets_ground(terrain: TerrainMap, hip: Point, foot: Point) -> bool:
    """True when the straight line from hip to foot is below the ground somewhere, but for its last
    centimetres.
    """
    length = math.hypot(foot[0] - hip[0], foot[1] - hip[1])
    if length <= NEAR_FOOT:
        return False
    cell = terrain.cell
    columns = terrain.columns
    rows = terrain.rows
    heights = terrain.height_view
    samples = math.ceil((length - NEAR_FOOT) / cell)
    share = (length - NEAR_FOOT) / length / samples
    gx = (hip[0] - terrain.origin[0]) / cell
    gy = (hip[1] - terrain.origin[1]) / cell
    gz = hip[2]
    dx = share * (foot[0] - hip[0]) / cell
    dy = share * (foot[1] - hip[1]) / cell
    dz = share * (foot[2] - hip[2])
    for _ in range(samples + 1):
        column = int(gx)
        row = int(gy)
        if 0 <= column < columns and 0 <= row < rows and heights[row * columns + column] > gz:
            return True
        gx += dx
        gy += dy
        gz += dz
    return False
