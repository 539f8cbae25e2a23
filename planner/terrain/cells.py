"""Cells of a map as a search for footholds walks over them: which may be stepped on, and in what
order they lie around a place.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

from .map import TerrainMap


class FootholdMap(NamedTuple):
    """What landing asks of the map: one byte a cell, 1 where a foot must not land."""

    forbidden: bytes
    rows: int
    columns: int
    cell: float
    x: float  # corner of cell [0, 0]
    y: float

    def allows(self, ax: float, ay: float) -> bool:
        """True when the cell under an absolute point is on the map and not prohibited."""
        column = math.floor((ax - self.x) / self.cell)
        row = math.floor((ay - self.y) / self.cell)
        return (
            0 <= column < self.columns
            and 0 <= row < self.rows
            and not self.forbidden[row * self.columns + column]
        )


def foothold_map(terrain: TerrainMap) -> FootholdMap:
    """The landing view of a map."""
    return FootholdMap(
        terrain.forbidden_bytes,
        terrain.rows,
        terrain.columns,
        terrain.cell,
        terrain.origin[0],
        terrain.origin[1],
    )


def span_of(low: float, high: float, origin: float, cell: float, count: int) -> tuple[int, int]:
    """First and last cell whose centre lies in [low, high], cut to the map."""
    return max(0, math.ceil((low - origin) / cell - 0.5 - 1e-9)), min(
        count - 1, math.floor((high - origin) / cell - 0.5 + 1e-9)
    )


def outward(middle: int, low: int, high: int, first: int) -> Iterator[int]:
    """middle, then one to the ``first`` side, one to the other, two to the first ... as far as they
    are in [low, high].
    """
    if low <= middle <= high:
        yield middle
    step = 1
    while middle - step >= low or middle + step <= high:
        for place in (middle + first * step, middle - first * step):
            if low <= place <= high:
                yield place
        step += 1


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
