"""The true terrain: heights on a square grid, the obstacles standing on it, and how one is made
from a scenario's words.

Row index is y, column index is x; ``origin`` is the corner of cell [0, 0]; NaN is a hole without a
bottom. Between cells it is flat or relief, for plants, planners and log alike: what it is when it
is made it stays, whatever is edited. Kinds and their parameters are in ``generators.py``, files and
the elevation model in ``files.py``, how large a map is made in ``extent.py``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.geometry.paths import Box
from walking_console.planner.geometry.transforms import XY, Pose
from walking_console.planner.robot.model import Machine
from walking_console.planner.terrain.grid import HeightGrid, Window, common, is_relief, within
from walking_console.planner.terrain.map import EDGE
from walking_console.planner.terrain.mapping import Index
from walking_console.planner.types import Array

from .extent import CellRange, cells_for
from .files import FileGround, Smoothed, given_heights, read_elevation, read_heights
from .generators import (
    Dem,
    FileTerrain,
    Generated,
    GroundError,
    HeightsTerrain,
    MapTerrain,
    Obstacle,
    Site,
    Terrain,
)
from .wide_map import WHOLE_CELLS_MAX, WideMap

__all__ = ["Ground", "GroundError", "Obstacle", "make_ground"]

STAND = 3.0  # m about the start that the first window of a wide map reaches
CLEAR = 0.1  # m beyond the feet's reach that is kept fit to stand on at the start
HEIGHT_MAX = 100.0  # m above or below the origin; a course that climbs more is a mistake


@dataclass(frozen=True, eq=False)
class Ground(HeightGrid):
    """``heights`` (ny, nx) m, write-protected; ``cell`` m; ``origin`` x, y m. All the ground there
    is, or a window of a ``whole`` wide map about the machine.

    ``final``: the forbidden cells are exactly the holes, whatever the foot's radius (``holes`` and
    ``footholds`` ground).
    """

    heights: NDArray[np.float64]
    cell: float
    origin: tuple[float, float]
    kind: str = "flat"
    final: bool = False
    obstacles: tuple[Obstacle, ...] = ()
    note: str = ""  # what was understood of a height file, one line
    edge: float = EDGE  # m a foothold keeps from the bottomless
    # straight between the centres of cells; None: as its heights are (``is_relief``)
    relief: bool | None = None
    # the map this ground is a window of, and where in it cell [0, 0] is; None: this is all of it
    whole: WideMap | None = None
    corner: tuple[int, int] = (0, 0)  # row, column

    def __post_init__(self) -> None:
        if self.heights.ndim != 2 or 0 in self.heights.shape:
            raise GroundError(f"heights must be one (ny, nx) array, got shape {self.heights.shape}")
        # an array that nobody can write to need not be copied
        shared = self.heights.base is None and not self.heights.flags.writeable
        array = np.array(self.heights, dtype=np.float64, order="C", copy=None if shared else True)
        array.setflags(write=False)
        object.__setattr__(self, "heights", array)
        if self.relief is None:
            object.__setattr__(self, "relief", is_relief(array))

    @cached_property
    def level(self) -> float | None:
        """The one height all ground has, None when there are several or holes: level ground needs
        no lookups.
        """
        low, high = float(self.heights.min()), float(self.heights.max())
        return low if low == high else None

    @property
    def cells(self) -> Window:
        """Its own, numbered over the whole map."""
        row, column = self.corner
        return slice(row, row + self.rows), slice(column, column + self.columns)

    def window_on(self, cells: Window) -> Ground:
        """The same ground, seen through another window of its wide map."""
        if self.whole is None:
            raise AssertionError("this ground is all there is")
        rows, columns = cells
        return replace(
            self,
            heights=self.whole.read(rows, columns),
            origin=self.whole.corner(cells),
            corner=(rows.start, columns.start),
        )

    def with_heights(self, rows: Index, columns: Index, heights: Array) -> Ground:
        """New ground in which cells of the whole map have other heights, m; NaN is a hole without a
        bottom.
        """
        whole = self.whole
        if whole is not None:
            whole = whole.with_cells(rows, columns, heights)
            heights = heights.astype(np.float32).astype(np.float64)
        rows, columns = rows - self.corner[0], columns - self.corner[1]
        here = (rows >= 0) & (rows < self.rows) & (columns >= 0) & (columns < self.columns)
        new = self.heights
        if here.any():
            new = new.copy()
            new[rows[here], columns[here]] = heights[here]
            new.setflags(write=False)
        return replace(self, heights=new, whole=whole)

    def lowered(self, window: Window, by: float) -> Ground:
        """New ground in which a rectangle of the whole map lies ``by`` m lower."""
        whole = None if self.whole is None else self.whole.lowered(window, by)
        here = within(common(window, self.cells), self.cells)
        heights = self.heights.copy()
        heights[here] -= by
        if np.nanmax(np.abs(heights[here]), initial=0.0) > HEIGHT_MAX:
            raise GroundError(f"heights must be within {HEIGHT_MAX:g} m of 0")
        if whole is not None:
            heights[here] = heights[here].astype(np.float32)
        heights.setflags(write=False)
        return replace(self, heights=heights, whole=whole)

    def heights_of(self, rows: Index, columns: Index) -> Array:
        """Heights of cells of the whole map, m."""
        at_row, at_column = rows - self.corner[0], columns - self.corner[1]
        here = (at_row >= 0) & (at_row < self.rows) & (at_column >= 0) & (at_column < self.columns)
        if self.whole is not None and not here.all():
            return self.whole.at(rows, columns)
        return np.asarray(self.heights[at_row, at_column])

    @property
    def whole_shape(self) -> tuple[int, int]:
        """Rows and columns of the whole map."""
        return (self.rows, self.columns) if self.whole is None else self.whole.shape

    @property
    def whole_origin(self) -> XY:
        """x, y of the corner of cell [0, 0] of the whole map, m."""
        return self.origin if self.whole is None else self.whole.origin

    @property
    def whole_bounds(self) -> Box:
        """x_min, x_max, y_min, y_max of the whole map, m."""
        (x, y), (rows, columns) = self.whole_origin, self.whole_shape
        return x, x + columns * self.cell, y, y + rows * self.cell

    def edited(self, cells: Iterable[tuple[int, int, float]]) -> Ground:
        """New ground in which each (row, column) of the whole map has the given height; NaN digs a
        hole without a bottom.
        """
        changes = list(cells)
        rows = np.array([row for row, _, _ in changes], dtype=np.intp)
        columns = np.array([column for _, column, _ in changes], dtype=np.intp)
        heights = np.array([height for _, _, height in changes], dtype=np.float64)
        self._check(rows, columns, heights)
        return self.with_heights(rows, columns, heights)

    def _check(self, rows: Index, columns: Index, heights: Array) -> None:
        """Raises ``GroundError`` for the first of these cells that is not on the map, or that is
        no ground.
        """
        ny, nx = self.whole_shape
        outside = (rows < 0) | (rows >= ny) | (columns < 0) | (columns >= nx)
        for k in np.flatnonzero(outside)[:1].tolist():
            raise GroundError(
                f"cell ({rows[k]}, {columns[k]}) is outside the map of {ny} x {nx} cells"
            )
        for k in np.flatnonzero(np.abs(heights) > HEIGHT_MAX)[:1].tolist():
            raise GroundError(
                f"height of cell ({rows[k]}, {columns[k]}) must be within {HEIGHT_MAX:g} m of 0, "
                f"got {heights[k]:g}"
            )


def make_ground(
    terrain: Terrain,
    machine: Machine,
    start: Pose = (0.0, 0.0, 0.0),
    seed: int = 0,
    span: float | Box = 0.0,
    base: Path | None = None,
    stand: Sequence[XY] = (),
) -> Ground:
    """The ground a scenario names. Raises ``GroundError``.

    ``start`` is x, y, yaw of the body; ``span`` is how far the course may lead from there (a
    radius, or the course's own bounds: ``Scenario.span``); ``stand`` are the feet of the start
    posture, which must find ground; ``base`` is the folder relative files are looked up in.
    ``terrain.seed`` wins over ``seed``.
    """
    site_seed = seed if terrain.seed is None else terrain.seed
    if isinstance(terrain, FileTerrain | HeightsTerrain):
        at = start[0], start[1]
        if isinstance(terrain, FileTerrain):
            read = read_heights(terrain, base, at, stand)
        else:
            read = given_heights(terrain, at, stand)
        ground = _of_file(terrain, read, at)
    elif isinstance(terrain, Generated):
        at = start[0], start[1]
        ground = _generated(terrain, machine, at, site_seed, _course(at, span), stand)
    else:
        raise GroundError(f"no way to make {terrain.kind!r} ground")
    _check_start(ground, start, stand)
    return ground


def _of_file(terrain: MapTerrain, read: FileGround, start: XY) -> Ground:
    """The ground of a height file, wide where it has many cells."""
    heights = read.heights
    if read.parts > 1:
        fine = Smoothed(heights, read.parts)
        whole = WideMap(fine.shape, read.cell / read.parts, read.origin, fine)
        ground = window_at(whole, start, terrain.kind, terrain.final)
    elif heights.size <= WHOLE_CELLS_MAX:
        exact = heights.astype(np.float64, copy=False)
        ground = Ground(exact, read.cell, read.origin, terrain.kind, terrain.final)
    else:
        held = heights.astype(np.float32, copy=False)
        whole = WideMap(held.shape, read.cell, read.origin, lambda r, c: held[r, c])
        ground = window_at(whole, start, terrain.kind, terrain.final)
    return replace(ground, note=read.note, edge=terrain.edge)


def window_at(whole: WideMap, at: XY, kind: str, final: bool, relief: bool | None = None) -> Ground:
    """The ground about a place on a wide map, relief or not; None: as its heights are."""
    window = whole.window_about(whole.tile_under(*at), STAND)
    corner = window[0].start, window[1].start
    origin = whole.corner(window)
    heights = whole.read(*window)
    if relief is None:  # of the whole map, as a window of a hilly one may be level
        relief = is_relief(whole.samples())
    return Ground(
        heights, whole.cell, origin, kind, final, relief=relief, whole=whole, corner=corner
    )


def _generated(
    terrain: Generated,
    machine: Machine,
    start: XY,
    seed: int,
    course: Box,
    stand: Sequence[XY],
) -> Ground:
    cells = cells_for(terrain, start, course)
    site = _site(cells, start, machine, seed)
    origin = site.bounds[0], site.bounds[2]
    keeps_clear = terrain.clears_start and not (terrain.final and stand)
    shaped = _Shaped(terrain, site, keeps_clear)
    if cells.size <= WHOLE_CELLS_MAX:
        heights = shaped(slice(0, site.y.size), slice(0, site.x.size))
        ground = Ground(heights, cells.cell, origin, terrain.kind, terrain.final)
    else:
        whole = WideMap((site.y.size, site.x.size), cells.cell, origin, shaped)
        ground = window_at(whole, start, terrain.kind, terrain.final)
    ground = replace(ground, obstacles=terrain.obstacles(site), edge=terrain.edge)
    return _with_start(ground, stand) if terrain.final else ground


class _Shaped(NamedTuple):
    """The heights of a generated map wherever they are asked for."""

    terrain: Generated
    site: Site  # of the whole map
    keeps_clear: bool  # level ground about the start

    def __call__(self, rows: slice, columns: slice) -> Array:
        site = self.site._replace(x=self.site.x[:, columns], y=self.site.y[rows])
        terrain = self.terrain
        shape = read_elevation(terrain, site) if isinstance(terrain, Dem) else terrain.shape(site)
        heights = np.array(np.broadcast_to(shape, (site.y.size, site.x.size)), dtype=np.float64)
        if self.keeps_clear:
            x, y = site.start
            heights[np.hypot(site.x - x, site.y - y) <= site.clear] = 0.0
        return heights


def _with_start(ground: Ground, stand: Sequence[XY]) -> Ground:
    """The ground with something under the feet of the start posture, as far as they keep off."""
    sides = (-ground.edge, ground.edge) if ground.edge > 0.0 else (0.0,)
    under = (ground.cell_at(x + dx, y + dy) for x, y in stand for dx in sides for dy in sides)
    row, column = ground.corner
    return ground.edited((at[0] + row, at[1] + column, 0.0) for at in under if at is not None)


def _site(cells: CellRange, start: XY, machine: Machine, seed: int) -> Site:
    """The cells of a map as a shape wants them, with the clearing the machine starts in."""
    x = (np.arange(*cells.columns, dtype=np.float64) + 0.5) * cells.cell
    y = (np.arange(*cells.rows, dtype=np.float64) + 0.5) * cells.cell
    corners = [(bx, by) for box in machine.boxes for bx in box[:2] for by in box[2:]]
    clear = max(math.hypot(bx, by) for bx, by in corners) + CLEAR
    return Site(x[np.newaxis, :], y[:, np.newaxis], cells.cell, cells.bounds, start, clear, seed)


def _course(start: XY, span: float | Box) -> Box:
    if isinstance(span, int | float):
        return start[0] - span, start[0] + span, start[1] - span, start[1] + span
    return span


def _check_start(ground: Ground, start: Pose, stand: Sequence[XY]) -> None:
    x_min, x_max, y_min, y_max = ground.whole_bounds
    for x, y in ((start[0], start[1]), *stand):
        if ground.index(x, y) < 0:
            raise GroundError(
                f"the start reaches ({x:g}, {y:g}), outside the map x [{x_min:g}, {x_max:g}], "
                f"y [{y_min:g}, {y_max:g}]"
            )
    for leg, (x, y) in enumerate(stand, 1):
        if math.isnan(ground.height_at(x, y)):
            raise GroundError(
                f"foot {leg} of the start posture is over a hole at ({x:.3f}, {y:.3f}); "
                "move [start] or the terrain"
            )
