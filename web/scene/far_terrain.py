"""The ground of a wide map beyond the window that is drawn in full: rings of eight sheets, each
ring three times as wide as the one inside it and as many quads, so that what is sent is bounded
however large the map.

A ring lies on a grid of its own steps: while the window moves within it, only the innermost ring is
drawn anew.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from walking_console.sim.snapshot import WholeMap

from .terrain import TerrainMesh
from .types import Floats

QUADS = 40  # a side of a sheet at most; more: a joining page waits longer
GROWTH = 3  # times the side of the ring inside
SAMPLES = 128  # a side, of what a whole map is looked at with
CellSpan = tuple[int, int]  # first cell, one past the last


@dataclass(frozen=True, slots=True)
class Sheet:
    """One sheet: every ``step``-th cell of some rows and columns of the whole map."""

    name: str
    rows: CellSpan
    columns: CellSpan
    step: int


def sheets_around(window: tuple[CellSpan, CellSpan], shape: tuple[int, int]) -> Iterator[Sheet]:
    """The sheets around a window of a map of this shape, from the inner ones on, until they reach
    its edges.
    """
    inner = window
    ring = 0
    while any(span != (0, size) for span, size in zip(inner, shape, strict=True)):
        width = max(b - a for a, b in inner)
        step = 2 ** math.ceil(math.log2(max(1.0, width / QUADS)))
        outer = tuple(
            _grown(span, width, QUADS // 2 * step, size)
            for span, size in zip(inner, shape, strict=True)
        )
        yield from _ring(ring, inner, (outer[0], outer[1]), step)
        inner = outer[0], outer[1]
        ring += 1


def _grown(span: CellSpan, by: int, lattice: int, size: int) -> CellSpan:
    """A span with at least so many cells more at both ends, which lie on a lattice or at the edges
    of the map.
    """
    first = max(0, (span[0] - by) // lattice * lattice)
    return first, min(size, -(-(span[1] + by) // lattice) * lattice)


def _ring(
    ring: int, inner: tuple[CellSpan, CellSpan], outer: tuple[CellSpan, CellSpan], step: int
) -> Iterator[Sheet]:
    """Up to eight sheets that fill what lies between two rectangles."""
    rows, columns = (((b[0], a[0]), a, (a[1], b[1])) for a, b in zip(inner, outer, strict=True))
    for j, tall in enumerate(rows):
        for i, wide in enumerate(columns):
            if (j, i) != (1, 1) and tall[0] < tall[1] and wide[0] < wide[1]:
                yield Sheet(f"far_{ring}_{j}{i}", tall, wide, step)


def mesh_of(sheet: Sheet, whole: WholeMap, cell: float, relief: tuple[float, float]) -> TerrainMesh:
    """A sheet of the true ground; holes are hollows, and what is forbidden is not shown so far
    away.
    """
    step = sheet.step
    middle = step // 2
    rows, columns = (
        slice(min(first + middle, last - 1), last, step)
        for first, last in (sheet.rows, sheet.columns)
    )
    heights = whole.read(rows, columns)
    heights = np.where(np.isnan(heights), relief[0], heights)
    x, y = whole.origin
    origin = x + sheet.columns[0] * cell, y + sheet.rows[0] * cell
    nothing = np.zeros(heights.shape, dtype=bool)
    return TerrainMesh(heights, nothing, cell * step, origin, relief, stepped=False, is_part=True)


def look_over(whole: WholeMap) -> Floats:
    """Heights all over a wide map, some in every row and column."""
    rows, columns = (slice(0, size, -(-size // SAMPLES)) for size in whole.shape)
    return whole.read(rows, columns)
