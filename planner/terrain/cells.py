"""Cells of a map as a search for footholds walks over them: which may be stepped on, and in what
order they lie around a place.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple, TypeVar

from ..geometry.paths import Box
from ..geometry.transforms import XY
from .map import TerrainMap

T = TypeVar("T")

SLACK = 1e-8  # a point this little outside a half plane is still looked at
HalfPlane = tuple[float, float, float]  # a, b, c: where a·x + b·y + c >= 0


class FootholdMap(NamedTuple):
    """What landing asks of the map: one byte a cell, 1 where a foot must not land."""

    forbidden: bytes
    rows: int
    columns: int
    cell: float
    x: float  # corner of cell [0, 0]
    y: float
    keeps_off_holes: Callable[[float, float], bool]

    def allows(self, ax: float, ay: float) -> bool:
        """True when the cell under an absolute point is on the map and not prohibited, and no
        bottomless cell is too near.
        """
        column = math.floor((ax - self.x) / self.cell)
        row = math.floor((ay - self.y) / self.cell)
        return (
            0 <= column < self.columns
            and 0 <= row < self.rows
            and not self.forbidden[row * self.columns + column]
            and self.keeps_off_holes(ax, ay)
        )


@lru_cache(maxsize=1)
def foothold_map(terrain: TerrainMap) -> FootholdMap:
    """The landing view of a map; steps in a row are planned on the same one."""
    return FootholdMap(
        terrain.forbidden_bytes,
        terrain.rows,
        terrain.columns,
        terrain.cell,
        terrain.origin[0],
        terrain.origin[1],
        terrain.keeps_off_holes,
    )


def span_of(low: float, high: float, origin: float, cell: float, count: int) -> tuple[int, int]:
    """First and last cell whose centre lies in [low, high], cut to the map."""
    return max(0, math.ceil((low - origin) / cell - 0.5 - 1e-9)), min(
        count - 1, math.floor((high - origin) / cell - 0.5 + 1e-9)
    )


@lru_cache(maxsize=1024)
def outward(middle: int, count: int, first: int) -> tuple[int, ...]:
    """The numbers from 0 below ``count`` from ``middle`` on: it, one to the ``first`` side, one to
    the other, two to the first ...

    Kept, as searches of one step after the other ask for the same few.
    """
    return tuple(sorted(range(count), key=lambda place: (abs(place - middle), -first * place)))


@lru_cache(maxsize=16)
def disc_of(cell: float, radius: float) -> tuple[tuple[int, int, float], ...]:
    """Columns and rows away from a cell, and how far, of all cells within ``radius`` m, from the
    nearest on.
    """
    count = math.floor(radius / cell)
    steps = [
        (c, r, math.hypot(c, r) * cell)
        for c in range(-count, count + 1)
        for r in range(-count, count + 1)
    ]
    near = (step for step in steps if step[2] <= radius)
    return tuple(sorted(near, key=lambda step: (step[2], step)))


def cells_across(
    cells: FootholdMap,
    area: Box,
    start: XY,
    course: XY,
    every: bool = False,
    within: Sequence[HalfPlane] = (),
) -> Iterator[tuple[float, float, bool]]:
    """Centres of the free cells of an area (or ``every`` one, with whether it is free) in rows
    across a course, from ``start`` on (H §5.5).

    Sideways from the start first; then the rows behind and ahead in turn, each from the cell on the
    line along the course. The map's axis nearest to the course plays the part of "ahead". Cells
    that are not ``within`` all of some half planes are passed over.
    """
    forbidden, rows, columns, cell, ox, oy, _ = cells
    ahead = span_of(area[0], area[1], ox, cell, columns)
    beside = span_of(area[2], area[3], oy, cell, rows)
    # the start in cells, along the axis and across it
    a0 = (start[0] - ox) / cell
    b0 = (start[1] - oy) / cell
    along, across = course
    lengthwise = abs(along) >= abs(across)
    if not lengthwise:
        ahead, beside, a0, b0, along, across = beside, ahead, b0, a0, across, along
    if ahead[0] > ahead[1] or beside[0] > beside[1]:
        return
    slope = across / along
    first = math.floor(a0)
    front, last = ahead
    bounds = _bounds_in_rows(cells, within, lengthwise)
    for onward in outward(first - front, last - front + 1, -1 if along > 0.0 else 1):
        row = front + onward
        side, end = _places_in(row, beside, *bounds)
        middle = math.floor(b0 if row == first else b0 + slope * (row + 0.5 - a0))
        for sideways in outward(middle - side, end - side + 1, 1) if side <= end else ():
            place = side + sideways
            column, line = (row, place) if lengthwise else (place, row)
            free = not forbidden[line * columns + column]
            if free or every:
                yield ox + (column + 0.5) * cell, oy + (line + 0.5) * cell, free


def _places_in(
    row: int, places: tuple[int, int], lows: Sequence[XY], highs: Sequence[XY]
) -> tuple[int, int]:
    """The first and the last of a row's places within bounds."""
    side, end = places
    for base, rise in lows:
        side = max(side, math.ceil(base + rise * row))
    for base, rise in highs:
        end = min(end, math.floor(base + rise * row))
    return side, end


def _bounds_in_rows(
    cells: FootholdMap, within: Sequence[HalfPlane], lengthwise: bool
) -> tuple[list[XY], list[XY]]:
    """The least and the largest places in a row that are in half planes: straight lines, each as
    its place in row 0 and how it changes from row to row.
    """
    cell = cells.cell
    middle_x = cells.x + 0.5 * cell
    middle_y = cells.y + 0.5 * cell
    lows: list[XY] = []
    highs: list[XY] = []
    for a, b, c in within:
        depth = a * middle_x + b * middle_y + c + SLACK  # of the middle of cell [0, 0]
        by_row, by_place = (a, b) if lengthwise else (b, a)
        if abs(by_place) < SLACK:
            continue  # along the rows: nothing is gained
        line = -depth / (by_place * cell), -by_row / by_place
        (lows if by_place > 0.0 else highs).append(line)
    return lows, highs


def one_of_each_block(
    cells: FootholdMap, area: Box, spacing: float, wanted: Callable[[float, float], T | None]
) -> Iterator[T]:
    """What is first ``wanted`` of the free cells in each block of about ``spacing`` m square."""
    block = max(1, round(spacing / cells.cell))
    side = block * cells.cell
    first_column = math.floor((area[0] - cells.x) / side)
    last_column = math.floor((area[1] - cells.x) / side)
    first_row = math.floor((area[2] - cells.y) / side)
    last_row = math.floor((area[3] - cells.y) / side)
    for row in range(first_row, last_row + 1):
        lines = range(max(0, row * block), min(cells.rows, (row + 1) * block))
        for column in range(first_column, last_column + 1):
            places = range(max(0, column * block), min(cells.columns, (column + 1) * block))
            found = _first_wanted(cells, lines, places, wanted)
            if found is not None:
                yield found


def _first_wanted(
    cells: FootholdMap, lines: range, places: range, wanted: Callable[[float, float], T | None]
) -> T | None:
    forbidden, _, columns, cell, ox, oy, _ = cells
    for line in lines:
        for place in places:
            if not forbidden[line * columns + place]:
                found = wanted(ox + (place + 0.5) * cell, oy + (line + 0.5) * cell)
                if found is not None:
                    return found
    return None


def cells_around(
    cells: FootholdMap, place: XY, radius: float, every: bool = False
) -> Iterator[tuple[float, float, float]]:
    """Centres of the free cells (or ``every`` one) around a place from the nearest on, and how far
    away they are, m.
    """
    forbidden, rows, columns, cell, ox, oy, _ = cells
    column = math.floor((place[0] - ox) / cell)
    row = math.floor((place[1] - oy) / cell)
    for dc, dr, away in disc_of(cell, radius):
        i, j = column + dc, row + dr
        if 0 <= i < columns and 0 <= j < rows and (every or not forbidden[j * columns + i]):
            yield ox + (i + 0.5) * cell, oy + (j + 0.5) * cell, away
