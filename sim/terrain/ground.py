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

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.geometry.paths import Box
from walking_console.planner.geometry.transforms import XY, Pose
from walking_console.planner.robot.model import Machine
from walking_console.planner.terrain.grid import HeightGrid, is_relief
from walking_console.planner.terrain.map import EDGE

from .extent import CellRange, cells_for
from .files import given_heights, read_elevation, read_heights
from .generators import (
    Dem,
    FileTerrain,
    Generated,
    GroundError,
    HeightsTerrain,
    Obstacle,
    Site,
    Terrain,
)

__all__ = ["Ground", "GroundError", "Obstacle", "make_ground"]

CLEAR = 0.1  # m beyond the feet's reach that is kept fit to stand on at the start
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
    edge: float = EDGE  # m a foothold keeps from the bottomless
    # straight between the centres of cells; None: as its heights are (``is_relief``)
    relief: bool | None = None

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

    def edited(self, cells: Iterable[tuple[int, int, float]]) -> Ground:
        """New ground in which each (row, column) has the given height; NaN digs a hole without a
        bottom.
        """
        heights = self.heights.copy()
        for row, column, height in cells:
            if not (0 <= row < self.rows and 0 <= column < self.columns):
                raise GroundError(
                    f"cell ({row}, {column}) is outside the map of {self.rows} x {self.columns} "
                    "cells"
                )
            if math.isinf(height) or abs(height) > HEIGHT_MAX:
                raise GroundError(
                    f"height of cell ({row}, {column}) must be within {HEIGHT_MAX:g} m of 0, "
                    f"got {height:g}"
                )
            heights[row, column] = height
        return replace(self, heights=heights)


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
        ground = Ground(
            read.heights,
            read.cell,
            read.origin,
            terrain.kind,
            terrain.final,
            note=read.note,
            edge=terrain.edge,
        )
    elif isinstance(terrain, Generated):
        at = start[0], start[1]
        ground = _generated(terrain, machine, at, site_seed, _course(at, span), stand)
    else:
        raise GroundError(f"no way to make {terrain.kind!r} ground")
    _check_start(ground, start, stand)
    return ground


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
    shape = read_elevation(terrain, site) if isinstance(terrain, Dem) else terrain.shape(site)
    heights = np.array(np.broadcast_to(shape, (site.y.size, site.x.size)), dtype=np.float64)
    if terrain.clears_start and not (terrain.final and stand):
        heights[np.hypot(site.x - start[0], site.y - start[1]) <= site.clear] = 0.0
    origin = site.bounds[0], site.bounds[2]
    obstacles = terrain.obstacles(site)
    ground = Ground(
        heights, cells.cell, origin, terrain.kind, terrain.final, obstacles, edge=terrain.edge
    )
    return _with_start(ground, stand) if terrain.final else ground


def _with_start(ground: Ground, stand: Sequence[XY]) -> Ground:
    """The ground with something under the feet of the start posture, as far as they keep off."""
    sides = (-ground.edge, ground.edge) if ground.edge > 0.0 else (0.0,)
    under = (ground.cell_at(x + dx, y + dy) for x, y in stand for dx in sides for dy in sides)
    return ground.edited((*at, 0.0) for at in under if at is not None)


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
    x_min, x_max, y_min, y_max = ground.bounds
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
