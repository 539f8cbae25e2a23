"""Maps too large to be held whole: heights that are read where they are wanted, and the tiles in
which they have been changed.

Where such a map comes from a generator nothing of it is kept but what has been changed; where it
comes from a file, its heights are, 4 bytes a cell. A machine walks in a *window* of it, a
``Ground`` like any other, that moves along with it (``sim/surroundings.py``). Cells are numbered
over the whole map. Heights are rounded to single precision, so that a run can keep them to the
last bit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.geometry.transforms import XY
from walking_console.planner.terrain.grid import Window, common, within
from walking_console.planner.terrain.mapping import Index
from walking_console.planner.types import Array

TileHeights = NDArray[np.float32]  # m

TILE = 32  # cells a side of what is changed, worked out and moved at once
SAMPLES = 12  # tiles a side that are looked at to tell what ground a map is
WHOLE_CELLS_MAX = 4_000_000  # of a map that is held whole: 32 MB of heights
WIDE_CELLS_MAX = 8192 * 8192  # of a wide map: 204 x 204 m of 0.025 m, 268 MB where they are held


class HeightSource(Protocol):
    """Heights of rows and columns of a map, m, (rows, columns); NaN is a hole."""

    def __call__(self, rows: slice, columns: slice) -> NDArray[np.floating[Any]]:
        """Every slice has a start and a stop on the map; with a step, every so many cells."""


class TileNumber(NamedTuple):
    """A tile by its number along y and x."""

    row: int
    column: int

    @property
    def window(self) -> Window:
        """Its cells, as if the map did not end."""
        row, column = self.row * TILE, self.column * TILE
        return slice(row, row + TILE), slice(column, column + TILE)


@dataclass(frozen=True, eq=False)
class WideMap:
    """``shape`` (rows, columns) cells of ``cell`` m; ``origin`` x, y of the corner of cell [0, 0],
    m. ``changed`` are the tiles that are not as the ``source`` has them. Frozen.
    """

    shape: tuple[int, int]
    cell: float
    origin: XY
    source: HeightSource
    changed: Mapping[TileNumber, TileHeights] = field(default_factory=dict)

    def read(self, rows: slice, columns: slice) -> Array:
        """Heights of rows and columns on the map, m, every so many where the slices have a step; an
        array of the caller's own.
        """
        heights = np.array(self.source(rows, columns), dtype=np.float32)
        for place in self._changed_in(rows, columns):
            tile = self.changed[place]
            here = [
                _common(wanted, side)
                for wanted, side in zip((rows, columns), place.window, strict=True)
            ]
            if all(there.size for there, _ in here):
                (to_rows, from_rows), (to_columns, from_columns) = here
                heights[np.ix_(to_rows, to_columns)] = tile[np.ix_(from_rows, from_columns)]
        return heights.astype(np.float64)

    def _changed_in(self, rows: slice, columns: slice) -> list[TileNumber]:
        """The changed tiles that may have cells in a rectangle."""
        if not self.changed:
            return []
        across = [len(range(side.start // TILE, -(-side.stop // TILE))) for side in (rows, columns)]
        if across[0] * across[1] > len(self.changed):
            return list(self.changed)
        there = slice(rows.start, rows.stop), slice(columns.start, columns.stop)
        return [place for place in tiles_in(there) if place in self.changed]

    def samples(self) -> Array:
        """Heights of tiles from all over the map side by side, m: enough to tell what ground it
        is.
        """
        rows, columns = (
            np.unique(np.linspace(0, max(0, size // TILE - 1), SAMPLES).astype(int)).tolist()
            for size in self.shape
        )
        return np.block(
            [
                [self.read(*cut_to(TileNumber(r, c).window, self.shape)) for c in columns]
                for r in rows
            ]
        )

    def at(self, rows: Index, columns: Index) -> Array:
        """Heights of single cells, m."""
        found = np.empty(rows.shape)
        for place, mine in tiles_of(rows, columns):
            tile = self._tile(place)
            found[mine] = tile[rows[mine] % TILE, columns[mine] % TILE]
        return found

    def with_cells(self, rows: Index, columns: Index, heights: Array) -> WideMap:
        """The same map with other heights in some cells, m."""
        changed = dict(self.changed)
        for place, mine in tiles_of(rows, columns):
            tile = self._tile(place).copy()
            tile[rows[mine] % TILE, columns[mine] % TILE] = heights[mine]
            changed[place] = tile
        return replace(self, changed=changed)

    def lowered(self, window: Window, by: float) -> WideMap:
        """The same map with a rectangle of it ``by`` m lower."""
        changed = {}
        for place, before in self.changed.items():
            tile = before.astype(np.float64)
            tile[within(common(window, place.window), place.window)] -= by
            changed[place] = tile.astype(np.float32)
        return replace(self, source=_Lowered(self.source, window, by), changed=changed)

    def _tile(self, place: TileNumber) -> TileHeights:
        """The heights of one tile; NaN beyond the edges of the map."""
        if place in self.changed:
            return self.changed[place]
        tile = np.full((TILE, TILE), np.nan, dtype=np.float32)
        rows, columns = cut_to(place.window, self.shape)
        tile[: rows.stop - rows.start, : columns.stop - columns.start] = self.source(rows, columns)
        return tile

    def tile_under(self, x: float, y: float) -> TileNumber:
        """The tile that contains a point; off the map the nearest in its row and column."""
        side = TILE * self.cell
        row = math.floor((y - self.origin[1]) / side)
        column = math.floor((x - self.origin[0]) / side)
        last_row, last_column = ((size - 1) // TILE for size in self.shape)
        return TileNumber(min(max(row, 0), last_row), min(max(column, 0), last_column))

    def window_about(self, centre: TileNumber, reach: float) -> Window:
        """The cells a machine near this tile is given: whole tiles, and ``reach`` m to every side
        even when it has gone on to the next tile.
        """
        tiles = math.ceil(reach / (TILE * self.cell)) + 1
        row, column = (number * TILE for number in centre)
        wide = tiles * TILE
        window = (
            slice(row - wide, row + TILE + wide),
            slice(column - wide, column + TILE + wide),
        )
        return cut_to(window, self.shape)

    def corner(self, window: Window) -> XY:
        """x, y of the corner of a window, m."""
        return (
            self.origin[0] + window[1].start * self.cell,
            self.origin[1] + window[0].start * self.cell,
        )


@dataclass(frozen=True)
class _Lowered:
    """The heights of another source, lower in a rectangle."""

    source: HeightSource
    window: Window
    by: float

    def __call__(self, rows: slice, columns: slice) -> NDArray[np.floating[Any]]:
        heights = self.source(rows, columns).astype(np.float64)
        on_row, on_column = (
            (places >= side.start) & (places < side.stop)
            for places, side in (
                (np.arange(rows.start, rows.stop, rows.step), self.window[0]),
                (np.arange(columns.start, columns.stop, columns.step), self.window[1]),
            )
        )
        heights[np.ix_(on_row, on_column)] -= self.by
        return heights


def cut_to(window: Window, shape: tuple[int, int]) -> Window:
    """What a map of this shape has of a window."""
    rows, columns = (
        slice(min(max(0, side.start), size), min(max(0, side.stop), size))
        for side, size in zip(window, shape, strict=True)
    )
    return rows, columns


def tiles_in(window: Window) -> list[TileNumber]:
    """The tiles that have cells in a window, row by row."""
    rows, columns = _numbers(window)
    return [TileNumber(row, column) for row in rows for column in columns]


def tiles_beside(window: Window, other: Window) -> list[TileNumber]:
    """The tiles of a window of whole tiles that are not in another one."""
    rows, columns = _numbers(window)
    other_rows, other_columns = _numbers(other)
    aside = [column for column in columns if column not in other_columns]
    return [
        TileNumber(row, column)
        for row in rows
        for column in (aside if row in other_rows else columns)
    ]


def _numbers(window: Window) -> tuple[range, range]:
    """Rows and columns of the tiles that have cells in a window."""
    rows, columns = (range(side.start // TILE, -(-side.stop // TILE)) for side in window)
    return rows, columns


def tiles_of(rows: Index, columns: Index) -> list[tuple[TileNumber, Index]]:
    """The tiles that some cells lie in, and which of the cells those are."""
    if not rows.size:
        return []
    across = int(columns.max()) // TILE + 1
    numbers, which = np.unique(rows // TILE * across + columns // TILE, return_inverse=True)
    ends = np.cumsum(np.bincount(which))[:-1]
    parts = np.split(np.argsort(which, kind="stable"), ends)
    places = (TileNumber(*divmod(number, across)) for number in numbers.tolist())
    return list(zip(places, parts, strict=True))


def _common(wanted: slice, side: slice) -> tuple[Index, Index]:
    """Where what is wanted lies in a side of a tile: its numbers among the wanted, and in the
    tile.
    """
    step = wanted.step or 1
    first = max(0, -(-(side.start - wanted.start) // step))
    last = -(-(min(side.stop, wanted.stop) - wanted.start) // step)
    there = np.arange(first, max(first, last))
    return there, wanted.start + there * step - side.start
