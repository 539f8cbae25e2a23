"""Whether the legs of a standing or moving machine run through something: poles and rocks beside
its feet.

K's third truncation ("non-touching the surface") for what stands taller than a step. A leg is the
straight line from hip to foot tip; that is the lowest a real leg, knee outward and up, can be, so
this errs on the careful side.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from ..geometry.transforms import XY, Body, placed
from ..terrain.map import TerrainMap
from ..types import Point
from .model import Machine

# m over the lowest foot; lower things pass under every leg's line but for its last centimetres
TALL = 0.35
# m of the line nearest the foot that is not looked at: the foothold itself is checked elsewhere
NEAR_FOOT = 0.06
BEYOND = 0.3  # m beyond the reach of the legs that is looked at for something tall: a stride
# shares of a swing at which the leg that swings is looked at; coarser and a pole slips between
SWEPT = (0.0, 0.25, 0.5, 0.75)
# shares of a step at which the legs that stand are; 6 cm apart at most
LEG_CHECKS = (0.25, 0.5, 0.75, 1.0)


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


class SteppingLegs:
    """The legs of a machine that takes a step from where it stands, among tall things.

    ``feet`` are where it stands, absolute; ``body_at`` is its body after so many metres of the way,
    at a height.
    """

    def __init__(
        self,
        terrain: TerrainMap,
        machine: Machine,
        feet: Sequence[Point],
        body_at: Callable[[float, float], Body],
    ) -> None:
        self.terrain = terrain
        self.machine = machine
        self.feet = feet
        self.body_at = body_at
        self._standing: dict[tuple[int, float], bool] = {}

    def meet(self, way: float, z: float, feet: Mapping[int, Point]) -> bool:
        """True when one of these legs, by the number of the leg, meets ground with the body so far
        along its way, at height z.
        """
        tips = [feet.get(leg) for leg in range(len(self.feet))]
        return leg_in_the_way(self.terrain, self.machine, self.body_at(way, z), tips) is not None

    def standing_meet(self, swung: int, way: float, z: float) -> bool:
        """True when a leg that stands while leg ``swung`` swings meets ground somewhere on the way;
        asked for every foothold, so remembered.
        """
        if (swung, way) not in self._standing:
            feet = {leg: foot for leg, foot in enumerate(self.feet) if leg != swung}
            met = any(self.meet(share * way, z, feet) for share in LEG_CHECKS)
            self._standing[swung, way] = met
        return self._standing[swung, way]

    def swinging_meets(
        self, leg: int, landing: XY, ways: tuple[float, float], z: float, lifted: float
    ) -> bool:
        """True when a leg sweeps through ground on its way to a landing point, its foot at height
        ``lifted`` while the body goes from the one to the other of ``ways``.
        """
        from_x, from_y, from_z = self.feet[leg]
        begin, end = ways
        for share in SWEPT:
            x = from_x + share * (landing[0] - from_x)
            y = from_y + share * (landing[1] - from_y)
            foot = (x, y, lifted if share else from_z)
            if self.meet(begin + share * (end - begin), z, {leg: foot}):
                return True
        return False


def _meets_ground(terrain: TerrainMap, hip: Point, foot: Point) -> bool:
    """True when the straight line from hip to foot is below the ground somewhere, but for its last
    centimetres.
    """
    length = math.hypot(foot[0] - hip[0], foot[1] - hip[1])
    if length <= NEAR_FOOT:
        return False
    cell = terrain.cell
    samples = math.ceil((length - NEAR_FOOT) / cell)
    share = (length - NEAR_FOOT) / length / samples
    at = ((hip[0] - terrain.origin[0]) / cell, (hip[1] - terrain.origin[1]) / cell, hip[2])
    dx = share * (foot[0] - hip[0]) / cell
    dy = share * (foot[1] - hip[1]) / cell
    return _line_meets(terrain, at, (dx, dy, share * (foot[2] - hip[2])), samples)


def _line_meets(terrain: TerrainMap, at: Point, ways: Point, samples: int) -> bool:
    """The same of a line from ``at`` that goes so many ``ways`` on, seen from above in cells; a way
    is a cell at most.
    """
    gx, gy, gz = at
    dx, dy, dz = ways
    columns = terrain.columns
    rows = terrain.rows
    heights = terrain.height_view
    column_before = int(gx)
    row_before = int(gy)
    for _ in range(samples + 1):
        column = int(gx)
        row = int(gy)
        if 0 <= column < columns and 0 <= row < rows and heights[row * columns + column] > gz:
            return True
        if column != column_before:
            if row != row_before:
                cells = (column_before, row_before), (column, row)
                aside, across = _corner(*cells, (gx, gy), (dx, dy))
                on_map = 0 <= aside < columns and 0 <= across < rows
                if on_map and heights[across * columns + aside] > gz - dz / 2.0:
                    return True
            column_before = column
        row_before = row
        gx += dx
        gy += dy
        gz += dz
    return False


def _corner(before: tuple[int, int], now: tuple[int, int], at: XY, ways: XY) -> tuple[int, int]:
    """The third cell (column, row) that a line goes through between two that touch at a corner;
    ``at`` is where it has come to, in cells, ``ways`` what it goes in between.
    """
    past_x = (at[0] - max(now[0], before[0])) * ways[1]
    past_y = (at[1] - max(now[1], before[1])) * ways[0]
    return (now[0], before[1]) if abs(past_x) > abs(past_y) else (before[0], now[1])
