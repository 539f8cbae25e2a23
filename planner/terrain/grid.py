"""Square grids of heights: which cell a point is in, and rectangles of cells.

Row index is y, column index is x; ``origin`` is the corner of cell [0, 0]; the ground is the height
of the cell that contains the point. NaN is a hole without a bottom. What the walker believes
(``TerrainMap``) and what is there (the ground of the simulation) are such grids.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Window = tuple[slice, slice]  # rows and columns of a rectangle of cells


def grown(window: Window, by: int, shape: tuple[int, ...]) -> Window:
    """The rectangle with ``by`` more cells on every side, as far as the map goes."""
    rows, columns = (
        slice(max(0, side.start - by), min(size, side.stop + by))
        for side, size in zip(window, shape, strict=True)
    )
    return rows, columns


def within(inner: Window, outer: Window) -> Window:
    """Where a rectangle of the map lies in an array cut out by a larger one."""
    rows, columns = (
        slice(a.start - b.start, a.stop - b.start) for a, b in zip(inner, outer, strict=True)
    )
    return rows, columns


def placed_in(inner: Window, outer: Window) -> Window:
    """Where in the map a rectangle of an array lies that is cut out by a larger one."""
    rows, columns = (
        slice(a.start + b.start, a.stop + b.start) for a, b in zip(inner, outer, strict=True)
    )
    return rows, columns


def joined(one: Window | None, other: Window) -> Window:
    """The least rectangle that holds both."""
    if one is None:
        return other
    rows, columns = (
        slice(min(a.start, b.start), max(a.stop, b.stop)) for a, b in zip(one, other, strict=True)
    )
    return rows, columns


def around_cells(rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Window:
    """The least rectangle that holds some cells, of which there is at least one."""
    return slice(int(rows.min()), int(rows.max()) + 1), slice(
        int(columns.min()), int(columns.max()) + 1
    )


class HeightGrid:
    """Heights on square cells: ``heights`` (ny, nx) m, ``cell`` m, ``origin`` x, y m.

    Whoever inherits gives the three as attributes and never changes them. Scalar look-ups for
    planning loops and ticks: numpy scalars cost three times as much.
    """

    heights: NDArray[np.float64]
    cell: float
    origin: tuple[float, float]

    @cached_property
    def rows(self) -> int:
        """Cells along y."""
        return int(self.heights.shape[0])

    @cached_property
    def columns(self) -> int:
        """Cells along x."""
        return int(self.heights.shape[1])

    @cached_property
    def height_view(self) -> memoryview:
        """Heights row by row as plain floats, m."""
        return self.heights.astype(np.float64, copy=False).ravel().data

    @cached_property
    def bounds(self) -> tuple[float, float, float, float]:
        """x_min, x_max, y_min, y_max of the grid, m."""
        x, y = self.origin
        return x, x + self.columns * self.cell, y, y + self.rows * self.cell

    @cached_property
    def _look_up(self) -> tuple[float, float, float, int, int, memoryview]:
        """Origin x, y, cell, rows, columns, heights: all a look at one cell needs, in one."""
        x, y = self.origin
        return x, y, self.cell, self.rows, self.columns, self.height_view

    def index(self, x: float, y: float) -> int:
        """Flat index of the cell under (x, y), −1 outside the grid."""
        x0, y0, cell, rows, columns, _ = self._look_up
        column = math.floor((x - x0) / cell)
        row = math.floor((y - y0) / cell)
        return row * columns + column if 0 <= column < columns and 0 <= row < rows else -1

    def height_at(self, x: float, y: float) -> float:
        """Height of the cell that contains the point, m; NaN over a hole and outside the grid."""
        x0, y0, cell, rows, columns, heights = self._look_up
        column = math.floor((x - x0) / cell)
        row = math.floor((y - y0) / cell)
        if 0 <= column < columns and 0 <= row < rows:
            return heights[row * columns + column]
        return math.nan

    def cell_at(self, x: float, y: float) -> tuple[int, int] | None:
        """(row, column) of the cell under (x, y), None outside the grid."""
        flat = self.index(x, y)
        return None if flat < 0 else divmod(flat, self.columns)

    def centre(self, row: int, column: int) -> tuple[float, float]:
        """x, y of a cell's centre, m."""
        return self.origin[0] + (column + 0.5) * self.cell, self.origin[1] + (row + 0.5) * self.cell

    def has_cell(self, row: int, column: int) -> bool:
        """True when the grid has such a cell."""
        return 0 <= row < self.rows and 0 <= column < self.columns

    def need_cell(self, row: int, column: int) -> None:
        """Raises ``ValueError`` for a cell that the grid does not have."""
        if not self.has_cell(row, column):
            raise ValueError(
                f"cell ({row}, {column}) is outside the map of {self.rows} x {self.columns} cells"
            )

    def window(self, x_min: float, x_max: float, y_min: float, y_max: float) -> Window:
        """The cells that an axis-aligned rectangle touches, as far as the grid goes; or none."""
        rows = _span(y_min, y_max, self.origin[1], self.cell, self.rows)
        return rows, _span(x_min, x_max, self.origin[0], self.cell, self.columns)


def _span(low: float, high: float, origin: float, cell: float, count: int) -> slice:
    first = math.floor((low - origin) / cell)
    last = math.floor((high - origin) / cell)
    return slice(min(max(first, 0), count), min(max(last + 1, 0), count))


def solid_heights(heights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Heights with −inf over holes, so that a maximum passes them over."""
    return np.where(np.isnan(heights), -np.inf, heights)


def spread_max(values: NDArray[np.float64], reach: int) -> NDArray[np.float64]:
    """Largest value within ``reach`` cells in rows and columns, the last two axes.

    Largest of two cells, of four and so on: of as many as twice fit into all that are in reach.
    """
    *_, rows, columns = values.shape
    side = 2 * reach + 1
    out = np.full((*values.shape[:-2], rows + 2 * reach, columns + 2 * reach), -np.inf)
    out[..., reach : reach + rows, reach : reach + columns] = values
    span = 1
    while 2 * span <= side:
        out = np.maximum(out[..., :-span, :], out[..., span:, :])
        out = np.maximum(out[..., :-span], out[..., span:])
        span *= 2
    rest = side - span
    if rest:
        out = np.maximum(out[..., :-rest, :], out[..., rest:, :])
        out = np.maximum(out[..., :-rest], out[..., rest:])
    return out


def crests_of(heights: NDArray[np.float64], reach: int) -> NDArray[np.float64]:
    """Highest ground within ``reach`` cells of each cell; −inf where there is none."""
    return spread_max(solid_heights(heights), reach)


def renew_crests(
    crests: NDArray[np.float64], heights: NDArray[np.float64], changed: Window, reach: int
) -> None:
    """Bring the crests of ``heights`` up to date, in place, after one rectangle has changed."""
    inner = grown(changed, reach, heights.shape)
    outer = grown(inner, reach, heights.shape)
    crests[inner] = crests_of(heights[outer], reach)[within(inner, outer)]
