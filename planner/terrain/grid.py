"""Square grids of heights: which cell a point is in, and rectangles of cells.

Row index is y, column index is x; ``origin`` is the corner of cell [0, 0]. NaN is a hole without a
bottom. What the walker believes (``TerrainMap``) and what is there (the ground of the simulation)
are such grids. Between cells the ground is one of two kinds (``is_relief``): *cells* are flat to
their borders, as steps, walls and holes are; *relief* goes straight from cell centre to cell
centre, in triangles.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Window = tuple[slice, slice]  # rows and columns of a rectangle of cells

LEVELS_MAX = 12  # heights that are steps; with fewer, see slopes of a few cells taken for stairs
# of neighbours in a row or column, how many differ at least in relief. More: see a hill in a plain
# become terraces; less: see the risers of long stairs become ramps
UNEVEN = 0.25


def is_relief(heights: NDArray[np.float64]) -> bool:
    """Whether these heights (ny, nx) are samples of one surface: many of them, everywhere others,
    and no holes. Else they are cells, flat to their borders.
    """
    if np.isnan(heights).any():
        return False
    sides = (heights[1:] != heights[:-1], heights[:, 1:] != heights[:, :-1])
    share = max(float(side.mean()) if side.size else 0.0 for side in sides)
    return share > UNEVEN and int(np.unique(heights).size) > LEVELS_MAX


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


def whole(shape: tuple[int, ...]) -> Window:
    """All cells of a map, (ny, nx)."""
    rows, columns = shape
    return slice(0, rows), slice(0, columns)


def holds(outer: Window, inner: Window) -> bool:
    """True when all cells of ``inner`` lie in ``outer``."""
    return all(a.start <= b.start and b.stop <= a.stop for a, b in zip(outer, inner, strict=True))


def common(one: Window, other: Window) -> Window:
    """The cells that two rectangles have in common; none where they do not meet."""
    rows, columns = (
        slice(max(a.start, b.start), max(a.start, b.start, min(a.stop, b.stop)))
        for a, b in zip(one, other, strict=True)
    )
    return rows, columns


def around_cells(rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Window:
    """The least rectangle that holds some cells, of which there is at least one."""
    return slice(int(rows.min()), int(rows.max()) + 1), slice(
        int(columns.min()), int(columns.max()) + 1
    )


class HeightGrid:
    """Heights on square cells: ``heights`` (ny, nx) m, ``cell`` m, ``origin`` x, y m.

    ``relief``: straight between the centres of cells; else flat in every cell. Whoever inherits
    gives the four as attributes and never changes them. Scalar look-ups for planning loops and
    ticks: numpy scalars cost three times as much.
    """

    heights: NDArray[np.float64]
    cell: float
    origin: tuple[float, float]
    relief: bool | None = False

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
    def _look_up(self) -> tuple[float, float, float, int, int, memoryview, bool]:
        """Origin x, y, cell, rows, columns, heights, relief: what a look at a place needs."""
        x, y = self.origin
        relief = bool(self.relief)
        return x, y, self.cell, self.rows, self.columns, self.height_view, relief

    def index(self, x: float, y: float) -> int:
        """Flat index of the cell under (x, y), −1 outside the grid."""
        x0, y0, cell, rows, columns, _, _ = self._look_up
        column = math.floor((x - x0) / cell)
        row = math.floor((y - y0) / cell)
        return row * columns + column if 0 <= column < columns and 0 <= row < rows else -1

    def height_at(self, x: float, y: float) -> float:
        """Height of the ground at a point, m; NaN over a hole and outside the grid.

        That of the cell under it; of relief, that of the triangle of cell centres around it, but
        beside a hole and at the rim of the map.
        """
        x0, y0, cell, rows, columns, heights, relief = self._look_up
        column = math.floor((x - x0) / cell)
        row = math.floor((y - y0) / cell)
        if 0 <= column < columns and 0 <= row < rows:
            if relief:
                place = (x - x0) / cell - 0.5, (y - y0) / cell - 0.5
                between = _between(place, rows, columns, heights)
                if between == between:
                    return between
            return heights[row * columns + column]
        return math.nan

    def heights_at(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """``height_at`` of many points (n,), m; beyond the grid that of the nearest cell."""
        u = (x - self.origin[0]) / self.cell
        v = (y - self.origin[1]) / self.cell
        columns = np.floor(u).astype(np.intp).clip(0, self.columns - 1)
        rows = np.floor(v).astype(np.intp).clip(0, self.rows - 1)
        heights = np.asarray(self.heights[rows, columns], dtype=np.float64)
        if self.relief:
            between = _all_between(u - 0.5, v - 0.5, self.heights)
            heights = np.where(np.isnan(between), heights, between)
        return heights

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


def _between(place: tuple[float, float], rows: int, columns: int, heights: memoryview) -> float:
    """Height at a place, in cells from the centre of cell [0, 0], on the triangle of the cell
    centres around it: every square of four is cut from its first corner to its last. NaN where the
    grid has no such triangle.
    """
    u, v = place
    column = math.floor(u)
    row = math.floor(v)
    if column < 0 or row < 0 or column + 1 >= columns or row + 1 >= rows:
        return math.nan
    ahead = u - column
    aside = v - row
    at = row * columns + column
    first = heights[at]
    last = heights[at + columns + 1]
    if ahead >= aside:
        right = heights[at + 1]
        return float(first + ahead * (right - first) + aside * (last - right))
    above = heights[at + columns]
    return float(first + aside * (above - first) + ahead * (last - above))


def _all_between(
    u: NDArray[np.float64], v: NDArray[np.float64], heights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """``_between`` of many places (n,)."""
    rows, columns = heights.shape
    inside = (u >= 0.0) & (v >= 0.0) & (u < columns - 1) & (v < rows - 1)
    column = np.where(inside, np.floor(u), 0.0).astype(np.intp)
    row = np.where(inside, np.floor(v), 0.0).astype(np.intp)
    ahead = u - column
    aside = v - row
    right, above = (np.minimum(side + 1, n - 1) for side, n in ((column, columns), (row, rows)))
    first = heights[row, column]
    last = heights[above, right]
    lower = first + ahead * (heights[row, right] - first) + aside * (last - heights[row, right])
    upper = (
        first + aside * (heights[above, column] - first) + ahead * (last - heights[above, column])
    )
    return np.where(inside, np.where(ahead >= aside, lower, upper), math.nan)


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
