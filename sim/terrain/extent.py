"""How large a map a course needs: cells sit on multiples of ``cell``, whatever the map's size, so
that a longer course finds the same ground.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from walking_console.planner.geometry.paths import Box
from walking_console.planner.geometry.transforms import XY

from .generators import Flat, Generated, GroundError
from .wide_map import WHOLE_CELLS_MAX, WIDE_CELLS_MAX

BEYOND = 2.5  # m of ground beyond the course; the contract asks for 2
# m around the start, for driving by hand; given up where the map can be held whole without
AROUND = 6.0
AROUND_FLAT = 12.0  # m, the contract's for flat ground
FLAT_CELLS_MAX = 1_000_000


class CellRange(NamedTuple):
    """Columns and rows of a map, the last of each not included, counted from the origin."""

    columns: tuple[int, int]
    rows: tuple[int, int]
    cell: float  # m

    @property
    def size(self) -> int:
        """How many cells there are."""
        return (self.columns[1] - self.columns[0]) * (self.rows[1] - self.rows[0])

    @property
    def bounds(self) -> Box:
        """x_min, x_max, y_min, y_max, m."""
        cell = self.cell
        west, east = self.columns
        south, north = self.rows
        return west * cell, east * cell, south * cell, north * cell


def cells_for(terrain: Generated, start: XY, course: Box) -> CellRange:
    """The map for a course (x_min, x_max, y_min, y_max) begun at ``start``; raises
    ``GroundError`` when it would be too large.
    """
    if terrain.map_size is not None:
        return _checked(terrain, _of_size(terrain.map_size, start, course, terrain.cell))
    if isinstance(terrain, Flat):
        return _of_flat_ground(terrain, start, course)
    for around in (AROUND, BEYOND):
        cells = _cells(start, course, around, terrain.cell)
        if cells.size <= WHOLE_CELLS_MAX:
            return cells
    return _checked(terrain, _cells(start, course, AROUND, terrain.cell))


def _checked(terrain: Generated, cells: CellRange) -> CellRange:
    """The same cells, unless they are too many."""
    if cells.size <= WIDE_CELLS_MAX:
        return cells
    x_min, x_max, y_min, y_max = cells.bounds
    raise GroundError(
        f"the course needs {x_max - x_min:.0f} x {y_max - y_min:.0f} m of {terrain.kind} ground, "
        f"{cells.size} cells of {terrain.cell:g} m; "
        f"at most {WIDE_CELLS_MAX}: shorten [end] or drive along x or y"
    )


def _of_size(size: Sequence[float], start: XY, course: Box, cell: float) -> CellRange:
    """A map of at least this size about the start, that reaches ``BEYOND`` the course too."""
    x, y = start
    half_x, half_y = (side / 2.0 for side in size)
    x_min, x_max, y_min, y_max = course
    within = (
        min(x_min, x - half_x + BEYOND),
        max(x_max, x + half_x - BEYOND),
        min(y_min, y - half_y + BEYOND),
        max(y_max, y + half_y - BEYOND),
    )
    return _cells(start, within, BEYOND, cell)


def _of_flat_ground(terrain: Flat, start: XY, course: Box) -> CellRange:
    """Level ground is exact in cells of any size: they grow with the course."""
    cells = _cells(start, course, AROUND_FLAT, terrain.cell)
    while cells.size > FLAT_CELLS_MAX:
        cells = _cells(start, course, AROUND_FLAT, cells.cell * 2)
    return cells


def _cells(start: XY, course: Box, around: float, cell: float) -> CellRange:
    """Whole cells that reach ``BEYOND`` the course and ``around`` the start."""
    x, y = start
    x_min, x_max, y_min, y_max = course
    return CellRange(
        (
            math.floor(min(x_min - BEYOND, x - around) / cell),
            math.ceil(max(x_max + BEYOND, x + around) / cell),
        ),
        (
            math.floor(min(y_min - BEYOND, y - around) / cell),
            math.ceil(max(y_max + BEYOND, y + around) / cell),
        ),
        cell,
    )
