"""CellList of the ground under a circle or a rectangle."""

from __future__ import annotations

import math

import numpy as np

from walking_console.planner.terrain.mapping import Index
from walking_console.sim.snapshot import TerrainView

CellList = tuple[tuple[int, int], ...]  # (row, column)


def cells_in_rectangle(
    terrain: TerrainView, low: tuple[float, float], high: tuple[float, float]
) -> CellList:
    """Every cell of the whole map that the rectangle from ``low`` to ``high`` (x, y, m) touches."""
    rows, columns = _touched(terrain, low, high)
    return _pairs(rows.ravel(), columns.ravel())


def cells_in_circle(terrain: TerrainView, x: float, y: float, radius: float) -> CellList:
    """The cells of the whole map whose centres are within ``radius`` (m) of a point."""
    rows, columns = _touched(terrain, (x - radius, y - radius), (x + radius, y + radius))
    ox, oy = terrain.whole_origin
    dx = ox + (columns + 0.5) * terrain.cell - x
    dy = oy + (rows + 0.5) * terrain.cell - y
    inside = dx * dx + dy * dy <= radius**2
    return _pairs(rows[inside], columns[inside])


def _touched(
    terrain: TerrainView, low: tuple[float, float], high: tuple[float, float]
) -> tuple[Index, Index]:
    """Rows and columns of the cells that a rectangle touches, each (rows, columns)."""
    ny, nx = terrain.whole_shape
    x, y = terrain.whole_origin
    columns = _span(low[0], high[0], x, terrain.cell, nx)
    rows = _span(low[1], high[1], y, terrain.cell, ny)
    in_rows, in_columns = np.meshgrid(rows, columns, indexing="ij")
    return in_rows, in_columns


def _span(low: float, high: float, origin: float, cell: float, count: int) -> Index:
    """Index along one axis, those on the map."""
    first = max(0, math.floor((low - origin) / cell))
    last = min(count - 1, math.floor((high - origin) / cell))
    return np.arange(first, last + 1)


def _pairs(rows: Index, columns: Index) -> CellList:
    return tuple(zip(rows.tolist(), columns.tolist(), strict=True))
