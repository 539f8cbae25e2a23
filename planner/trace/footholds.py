"""Footholds of a trace walk and where they may be (K "calculation of footholds")."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.paths import EDGE
from ..robot.model import Machine
from ..terrain.grid import Window, spread_max
from ..terrain.map import TerrainMap
from ..types import Array
from .lane import Lane

DENSE = 16  # footholds a leg's rectangle may hold before the ground is thinned out
COARSE = 1.25  # times the pitch that DENSE footholds have; cells of open ground beyond are divided
PLENTY = 0.5  # of the ground; with less a rigid gait seldom finds its footholds
AIR = -1  # in a footing: this leg is in the air

Footing = tuple[int, ...]  # a foothold's number for every leg, AIR where there is none


class Foothold(NamedTuple):
    """A point a leg can stand on, absolute, m. ``last`` is K's S2 on the trace itself: the last
    sample of the window in reach.
    """

    leg: int
    x: float
    y: float
    z: float
    last: int


def within_reach(lane: Lane, terrain: TerrainMap, machine: Machine) -> Window:
    """The cells of the map within reach of the lane."""
    radius = max(math.hypot(x, y) for leg in machine.legs for x in leg.x for y in leg.y)
    return terrain.window(
        float(lane.x.min()) - radius,
        float(lane.x.max()) + radius,
        float(lane.y.min()) - radius,
        float(lane.y.max()) + radius,
    )


def allowed_cells(
    lane: Lane, terrain: TerrainMap, machine: Machine, thin: int
) -> tuple[Array, Array, Array]:
    """x, y and z (n,) of the centres of cells a foot may land on within reach of the lane, m; one
    of ``thin`` x ``thin`` cells when thinned, and all that lie on a bank.
    """
    window = within_reach(lane, terrain, machine)
    parts = _parts(terrain, machine)
    if parts > 1:
        return _divided(terrain, window, parts)
    rows, columns = np.nonzero(~terrain.forbidden[window])
    rows = rows + window[0].start
    columns = columns + window[1].start
    if thin > 1 and len(rows):
        kept = _thinned(rows, columns, terrain, window, thin)
        rows = rows[kept]
        columns = columns[kept]
    px = np.asarray(terrain.origin[0] + (columns + 0.5) * terrain.cell, dtype=np.float64)
    py = np.asarray(terrain.origin[1] + (rows + 0.5) * terrain.cell, dtype=np.float64)
    return px, py, np.asarray(terrain.heights[rows, columns], dtype=np.float64)


def _thinned(
    rows: NDArray[np.intp],
    columns: NDArray[np.intp],
    terrain: TerrainMap,
    window: Window,
    thin: int,
) -> NDArray[np.intp]:
    """Which of the cells (row, column) stay: one of every ``thin`` x ``thin``, and one of those
    among them that lie beside a forbidden cell.
    """
    block = (rows // thin) * terrain.columns + columns // thin
    _, kept = np.unique(block, return_index=True)
    beside = spread_max(terrain.forbidden[window].astype(np.float64), 1) > 0.0
    bank = np.flatnonzero(beside[rows - window[0].start, columns - window[1].start])
    _, first = np.unique(block[bank], return_index=True)
    return np.asarray(np.union1d(kept, bank[first]), dtype=np.intp)


def is_plenty(lane: Lane, terrain: TerrainMap, machine: Machine) -> bool:
    """Whether most of the ground within reach of the lane may be stepped on. Where most of it is
    only supposed, as by touch, one forbidden cell tells of more: it must be open and level.
    """
    window = within_reach(lane, terrain, machine)
    patch = terrain.forbidden[window]
    barred = int(np.count_nonzero(patch))
    known = patch.size if terrain.known is None else int(np.count_nonzero(terrain.known[window]))
    if known < PLENTY * patch.size:
        return terrain.is_level and not barred
    return patch.size > 0 and barred <= (1.0 - PLENTY) * patch.size


def is_open(lane: Lane, terrain: TerrainMap, machine: Machine) -> bool:
    """Whether nothing within reach of the lane is forbidden."""
    return not terrain.forbidden[within_reach(lane, terrain, machine)].any()


def _parts(terrain: TerrainMap, machine: Machine) -> int:
    """Into how many parts a cell is divided each way. Level ground is one surface: how coarse its
    map is does not say where a foot may stand. 1 anywhere else.
    """
    if not terrain.is_level:
        return 1
    area = max((leg.x[1] - leg.x[0]) * (leg.y[1] - leg.y[0]) for leg in machine.legs)
    pitch = math.sqrt(area / DENSE)
    return math.ceil(terrain.cell / pitch) if terrain.cell > COARSE * pitch else 1


def _divided(terrain: TerrainMap, window: Window, parts: int) -> tuple[Array, Array, Array]:
    """The centres of the parts of every cell of a window that may be stepped on; of a cell beside a
    forbidden one its centre alone, where no sole reaches over the edge.
    """
    (row, end_row), (column, end_column) = ((part.start, part.stop) for part in window)
    part = terrain.cell / parts
    x = terrain.origin[0] + (np.arange(column * parts, end_column * parts) + 0.5) * part
    y = terrain.origin[1] + (np.arange(row * parts, end_row * parts) + 0.5) * part
    allowed = ~terrain.forbidden[window]
    inner = allowed & ~_beside(terrain.forbidden, window)
    whole = np.repeat(np.repeat(inner, parts, axis=0), parts, axis=1).ravel()
    px, py = (grid.ravel()[whole] for grid in np.meshgrid(x, y))
    rows, columns = np.nonzero(allowed & ~inner)
    px = np.append(px, terrain.origin[0] + (columns + column + 0.5) * terrain.cell)
    py = np.append(py, terrain.origin[1] + (rows + row + 0.5) * terrain.cell)
    level = terrain.highest if len(px) else 0.0
    return px, py, np.full(len(px), level)


def _beside(forbidden: NDArray[np.bool_], window: Window) -> NDArray[np.bool_]:
    """True of the cells of a window that touch a forbidden one, if only at a corner."""
    rows, columns = window
    whole = np.pad(forbidden, 1)[rows.start : rows.stop + 2, columns.start : columns.stop + 2]
    return np.asarray(np.lib.stride_tricks.sliding_window_view(whole, (3, 3)).any(axis=(2, 3)))


def thinning(lane: Lane, terrain: TerrainMap, machine: Machine) -> int:
    """How coarsely dense ground may be sampled so that a leg's rectangle still offers about DENSE
    footholds.
    """
    patch = terrain.forbidden[within_reach(lane, terrain, machine)]
    if not patch.size:
        return 1
    allowed = 1.0 - float(np.count_nonzero(patch)) / patch.size
    area = max((leg.x[1] - leg.x[0]) * (leg.y[1] - leg.y[0]) for leg in machine.legs)
    return max(1, math.floor(math.sqrt(allowed * area / terrain.cell**2 / DENSE) + 0.5))


def legs_clear(footholds: Sequence[Foothold], feet: Footing, hold: Foothold, radius: float) -> bool:
    """K's second truncation: a foot of this radius, m, set down at ``hold`` stands clear of every
    other standing foot.
    """
    apart = (2 * radius) ** 2 - EDGE
    for f in feet:
        if f >= 0:
            other = footholds[f]
            if other.leg != hold.leg and (other.x - hold.x) ** 2 + (other.y - hold.y) ** 2 < apart:
                return False
    return True
