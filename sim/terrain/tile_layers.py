"""What is known of a wide map tile by tile: what follows from its heights for one machine, and what
has been found out where the machine has been.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.robot.model import Machine
from walking_console.planner.terrain.grid import Window, common, crests_of, grown, within
from walking_console.planner.terrain.mapping import Index
from walking_console.planner.terrain.traversability import classify, surroundings_of
from walking_console.planner.types import Array

from .wide_map import TILE, TileNumber, WideMap, cut_to, tiles_beside, tiles_in, tiles_of


class Layer:
    """One value a cell of a wide map, ``usual`` but where something else is kept: tile by tile, of
    the tiles beyond the window that is at hand.
    """

    def __init__(self, shape: tuple[int, int], usual: bool | float | np.uint8) -> None:
        self.shape = shape
        self.usual = usual
        self._tiles: dict[TileNumber, NDArray[Any]] = {}

    @property
    def is_usual(self) -> bool:
        """True when nothing else is kept of any tile."""
        return not self._tiles

    def moved(self, values: NDArray[Any], window: Window, to: Window) -> NDArray[Any]:
        """What another window of whole tiles holds, an array of the caller's own; ``values`` are
        those of this one, of which the tiles that are left behind are kept.
        """
        shared = common(window, to)
        rows, columns = (side.stop - side.start for side in to)
        there = np.full((rows, columns), self.usual, dtype=values.dtype)
        if self.is_usual and _is_all(values, self.usual):
            return there
        for place in tiles_beside(window, shared):
            tile = values[within(cut_to(place.window, self.shape), window)]
            if not _is_all(tile, self.usual):
                self._tiles[place] = tile.copy()
        there[within(shared, to)] = values[within(shared, window)]
        self.lay_over(there, to)
        for place in tiles_beside(to, shared):
            self._tiles.pop(place, None)
        return there

    def lay_over(self, values: NDArray[Any], window: Window) -> None:
        """Write what is kept into the values of a window."""
        for place in tiles_in(window) if self._tiles else ():
            tile = self._tiles.get(place)
            if tile is not None:
                shared = common(cut_to(place.window, self.shape), window)
                values[within(shared, window)] = tile[within(shared, place.window)]

    def set_cells(self, rows: Index, columns: Index, value: Any) -> None:
        """Give single cells that are kept another value."""
        for place, mine in tiles_of(rows, columns):
            side = cut_to(place.window, self.shape)
            tile = self._tiles.get(place)
            if tile is None:
                shape = tuple(s.stop - s.start for s in side)
                tile = np.full(shape, self.usual)
            tile[rows[mine] % TILE, columns[mine] % TILE] = value
            self._tiles[place] = tile


class Facts(NamedTuple):
    """What one tile holds for one machine; nothing and prohibited beyond the edges of the map."""

    heights: NDArray[np.float32]  # m
    forbidden: NDArray[np.bool_]
    crests: NDArray[np.float32]  # m, highest ground within a foot radius; −inf over holes


class TileFacts:
    """Where one machine must not step on a wide map, and what it must lift its feet over: worked
    out tile by tile when it is asked for, and kept near the machine.
    """

    def __init__(self, whole: WideMap, machine: Machine, final: bool) -> None:
        self.whole = whole
        self.machine = machine
        self.final = final
        self._foot = math.ceil(machine.foot_radius / whole.cell)
        # cells around a tile that decide what it holds
        self.reach = max(surroundings_of(machine, whole.cell), self._foot)
        self._found: dict[TileNumber, Facts] = {}

    def copy(self) -> TileFacts:
        """The same, to go on with: tiles that have been worked out are shared."""
        other = TileFacts(self.whole, self.machine, self.final)
        other._found = dict(self._found)
        return other

    def missing(self, window: Window) -> list[TileNumber]:
        """The tiles of a window that have not been worked out."""
        return [place for place in tiles_in(window) if place not in self._found]

    def work_out(self, place: TileNumber) -> Facts:
        """One tile, from its heights and those around it."""
        tile = cut_to(place.window, self.whole.shape)
        around = grown(tile, self.reach, self.whole.shape)
        inner = within(tile, around)
        heights = self.whole.read(*around)
        if self.final:
            forbidden = np.isnan(heights)
        else:
            forbidden = classify(heights, self.whole.cell, self.machine)
        crests = crests_of(heights, self._foot)
        found = self._found[place] = Facts(
            _whole_tile(heights[inner].astype(np.float32), math.nan),
            _whole_tile(forbidden[inner], True),
            _whole_tile(crests[inner].astype(np.float32), -math.inf),
        )
        return found

    def over(self, window: Window) -> tuple[Array, NDArray[np.bool_], Array]:
        """Heights, m, forbidden cells and crests, m, of a window of whole tiles."""
        rows, columns = (side.stop - side.start for side in window)
        tiles = tiles_in(window)
        found = [self._found.get(place) or self.work_out(place) for place in tiles]
        heights, forbidden, crests = zip(*found, strict=True)
        shape = rows, columns
        return (
            _side_by_side(heights, shape, np.float64),
            _side_by_side(forbidden, shape, np.bool_),
            _side_by_side(crests, shape, np.float64),
        )

    def prohibited(self, window: Window) -> NDArray[np.bool_]:
        """Where the machine must not step in any window, without keeping it."""
        around = grown(window, self.reach, self.whole.shape)
        heights = self.whole.read(*around)
        if self.final:
            return np.isnan(heights)[within(window, around)]
        return classify(heights, self.whole.cell, self.machine)[within(window, around)]

    def keep_only(self, window: Window) -> None:
        """Forget what is beyond a window."""
        self._found = {
            place: self._found[place] for place in tiles_in(window) if place in self._found
        }

    def after_change(self, whole: WideMap) -> list[TileNumber]:
        """Go on with the same map after some of its tiles have changed: what depends on them is
        forgotten, and which tiles those are is the answer.
        """
        before, self.whole = self.whole, whole
        stale = set(self._found) if whole.source is not before.source else set[TileNumber]()
        for place, tile in whole.changed.items():
            if before.changed.get(place) is not tile:
                stale.update(tiles_in(grown(place.window, self.reach, whole.shape)))
        return [place for place in sorted(stale) if self._found.pop(place, None)]


def _whole_tile(values: NDArray[Any], beyond: float) -> NDArray[Any]:
    """Values of a tile that the map may cut off."""
    rows, columns = values.shape
    if (rows, columns) == (TILE, TILE):
        return np.ascontiguousarray(values)
    return np.pad(values, ((0, TILE - rows), (0, TILE - columns)), constant_values=beyond)


def _side_by_side(
    tiles: Sequence[NDArray[Any]], shape: tuple[int, int], kind: type[Any]
) -> NDArray[Any]:
    """Tiles, row by row, as one array of its own of this shape, which the last may reach beyond."""
    rows, columns = shape
    down, across = -(-rows // TILE), -(-columns // TILE)
    there = np.empty((down * TILE, across * TILE), dtype=kind)
    grid = np.stack(tiles).reshape(down, across, TILE, TILE)
    there.reshape(down, TILE, across, TILE)[...] = grid.transpose(0, 2, 1, 3)
    return there if there.shape == shape else there[:rows, :columns].copy()


def _is_all(tile: NDArray[Any], value: Any) -> bool:
    same = tile == value
    if value != value:
        same = np.isnan(tile.astype(np.float64))
    return bool(same.all())
