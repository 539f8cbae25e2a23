"""The true terrain: heights on a square grid, the obstacles standing on it, and how one is made
from a scenario's words.

The ground is the height of the cell that contains the point, for simulation and log alike. Row
index is y, column index is x; ``origin`` is the corner of cell [0, 0]; NaN is a hole without a
bottom. Kinds and their parameters are in ``sim/terrains.py``, files and the elevation model in
``sim/imports.py``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.robot.model import Machine
from walking_console.planner.terrain.grid import HeightGrid

from .files import read_elevation, read_heights
from .generators import Box, Dem, FileTerrain, Flat, Generated, GroundError, Obstacle, Site, Terrain

__all__ = ["Ground", "GroundError", "Obstacle", "make_ground"]

BEYOND = 2.5  # m of ground beyond the course; the contract asks for 2
AROUND = 6.0  # m around the start, for driving by hand; given up when the map would be too large
AROUND_FLAT = 12.0  # m, the contract's for flat ground
CLEAR = 0.1  # m beyond the feet's reach that is kept fit to stand on at the start
MAP_CELLS_MAX = 4_000_000  # 32 MB of heights: a diagonal course of 70 m at 0.025 m
FLAT_CELLS_MAX = 1_000_000
HEIGHT_MAX = 100.0  # m above or below the origin; a course that climbs more is a mistake


@dataclass(frozen=True, eq=False)
class Ground(HeightGrid):
    """``heights`` (ny, nx) m, write-protected; ``cell`` m; ``origin`` x, y m.

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

    def __post_init__(self) -> None:
        if self.heights.ndim != 2 or 0 in self.heights.shape:
            raise GroundError(f"heights must be one (ny, nx) array, got shape {self.heights.shape}")
        array = np.array(self.heights, dtype=np.float64, order="C")
        array.setflags(write=False)
        object.__setattr__(self, "heights", array)

    @cached_property
    def level(self) -> float | None:
        """The one height all ground has, None when there are several or holes: level ground needs
        no lookups.
        """
        low, high = float(self.heights.min()), float(self.heights.max())
        return low if low == high else None

    def edited(self, cells: Iterable[tuple[int, int, float]]) -> Ground:
        """New ground in which each (row, column) has the given height; NaN digs a hole without a
        bottom.
        """
        heights = self.heights.copy()
        for row, column, height in cells:
            if not (0 <= row < self.rows and 0 <= column < self.columns):
                raise GroundError(
                    f"cell ({row}, {column}) is outside the map of {self.rows} x {self.columns} cells"
                )
            if math.isinf(height) or abs(height) > HEIGHT_MAX:
                raise GroundError(
                    f"height of cell ({row}, {column}) must be within {HEIGHT_MAX:g} m of 0, got {height:g}"
                )
            heights[row, column] = height
        return replace(self, heights=heights)


def make_ground(
    terrain: Terrain,
    machine: Machine,
    start: tuple[float, float, float] = (0.0, 0.0, 0.0),
    seed: int = 0,
    span: float | Box = 0.0,
    base: Path | None = None,
    stand: Sequence[tuple[float, float]] = (),
) -> Ground:
    """The ground a scenario names. Raises ``GroundError``.

    ``start`` is x, y, yaw of the body; ``span`` is how far the course may lead from there (a
    radius, or the course's own bounds: ``Scenario.span``); ``stand`` are the feet of the start
    posture, which must find ground; ``base`` is the folder relative files are looked up in.
    ``terrain.seed`` wins over ``seed``.
    """
    site_seed = seed if terrain.seed is None else terrain.seed
    if isinstance(terrain, FileTerrain):
        read = read_heights(terrain, base, (start[0], start[1]))
        ground = Ground(
            read.heights, read.cell, read.origin, terrain.kind, terrain.final, note=read.note
        )
    elif isinstance(terrain, Generated):
        ground = _generated(terrain, machine, start, site_seed, _course(start, span), stand)
    else:
        raise GroundError(f"no way to make {terrain.kind!r} ground")
    _check_start(ground, start, stand)
    return ground


def _generated(
    terrain: Generated,
    machine: Machine,
    start: tuple[float, float, float],
    seed: int,
    course: Box,
    stand: Sequence[tuple[float, float]],
) -> Ground:
    cell, (c0, c1, r0, r1) = _extent(terrain, start, course)
    x = ((np.arange(c0, c1, dtype=np.float64) + 0.5) * cell)[np.newaxis, :]
    y = ((np.arange(r0, r1, dtype=np.float64) + 0.5) * cell)[:, np.newaxis]
    clear = (
        max(math.hypot(bx, by) for box in machine.boxes for bx in box[:2] for by in box[2:]) + CLEAR
    )
    bounds = (c0 * cell, c1 * cell, r0 * cell, r1 * cell)
    site = Site(x, y, cell, bounds, (start[0], start[1]), clear, seed)
    shape = read_elevation(terrain, site) if isinstance(terrain, Dem) else terrain.shape(site)
    heights = np.array(np.broadcast_to(shape, (r1 - r0, c1 - c0)), dtype=np.float64)
    if terrain.clears_start and not (terrain.final and stand):
        heights[np.hypot(x - start[0], y - start[1]) <= clear] = 0.0
    ground = Ground(
        heights, cell, (bounds[0], bounds[2]), terrain.kind, terrain.final, terrain.obstacles(site)
    )
    if terrain.final:
        ground = ground.edited(
            (*at, 0.0) for at in (ground.cell_at(*foot) for foot in stand) if at is not None
        )
    return ground


def _course(start: tuple[float, float, float], span: float | Box) -> Box:
    if isinstance(span, int | float):
        return start[0] - span, start[0] + span, start[1] - span, start[1] + span
    return span


def _extent(
    terrain: Generated, start: tuple[float, float, float], course: Box
) -> tuple[float, tuple[int, int, int, int]]:
    """Cell size and the range of columns and rows: cells sit on multiples of ``cell``, whatever the
    map's size.
    """
    flat = isinstance(terrain, Flat)
    around = AROUND_FLAT if flat else AROUND
    need = _whole_cells(
        _union(_grown(course, BEYOND), _grown((start[0], start[0], start[1], start[1]), BEYOND)),
        terrain.cell,
    )
    wish = _whole_cells(
        _union(_grown(course, BEYOND), _grown((start[0], start[0], start[1], start[1]), around)),
        terrain.cell,
    )
    if flat:  # level ground is exact in cells of any size
        cell = terrain.cell
        while _count(wish) > FLAT_CELLS_MAX:
            cell *= 2
            wish = _whole_cells(
                _union(
                    _grown(course, BEYOND), _grown((start[0], start[0], start[1], start[1]), around)
                ),
                cell,
            )
        return cell, wish
    for cells in (wish, need):
        if _count(cells) <= MAP_CELLS_MAX:
            return terrain.cell, cells
    width, depth = ((high - low) * terrain.cell for low, high in (need[:2], need[2:]))
    raise GroundError(
        f"the course needs {width:.0f} x {depth:.0f} m of {terrain.kind} ground, {_count(need)} cells of {terrain.cell:g} m; "
        f"at most {MAP_CELLS_MAX}: shorten [end] or drive along x or y"
    )


def _grown(box: Box, by: float) -> Box:
    return box[0] - by, box[1] + by, box[2] - by, box[3] + by


def _union(a: Box, b: Box) -> Box:
    return min(a[0], b[0]), max(a[1], b[1]), min(a[2], b[2]), max(a[3], b[3])


def _whole_cells(box: Box, cell: float) -> tuple[int, int, int, int]:
    return (
        math.floor(box[0] / cell),
        math.ceil(box[1] / cell),
        math.floor(box[2] / cell),
        math.ceil(box[3] / cell),
    )


def _count(cells: tuple[int, int, int, int]) -> int:
    return (cells[1] - cells[0]) * (cells[3] - cells[2])


def _check_start(
    ground: Ground, start: tuple[float, float, float], stand: Sequence[tuple[float, float]]
) -> None:
    x_min, x_max, y_min, y_max = ground.bounds
    for x, y in ((start[0], start[1]), *stand):
        if ground.index(x, y) < 0:
            raise GroundError(
                f"the start reaches ({x:g}, {y:g}), outside the map x [{x_min:g}, {x_max:g}], y [{y_min:g}, {y_max:g}]"
            )
    for leg, (x, y) in enumerate(stand, 1):
        if math.isnan(ground.height_at(x, y)):
            raise GroundError(
                f"foot {leg} of the start posture is over a hole at ({x:.3f}, {y:.3f}); move [start] or the terrain"
            )
