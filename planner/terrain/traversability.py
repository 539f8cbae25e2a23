"""Where a machine can tread: from heights to forbidden cells, the step from G-type to HP-type
terrain (H §2.3).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import IntFlag
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..robot.model import Machine
from .grid import Window, grown, placed_in, spread_max, whole, within

SLOPE_MAX = math.radians(35.0)  # steeper ground is H: see feet slide off (titan3 default)
RELIEF_MAX = 0.03  # m under one foot; more is H: see feet land on edges
SLOPING = 1.1  # times what an even slope gives a foot of relief; more is no slope
RISE_MAX = 0.30  # m above the ground around; taller is P: see legs hit what they cannot step on
NEARLY = 1.0 - 1e-9  # of a limit: rounding cannot make more of what is less
RISE_WINDOW = 1.0  # m, side of the square that counts as "the ground around"


class Kind(IntFlag):
    """What a cell is to one machine (H §2.3): the classes of HP-type ground."""

    O = 0  # noqa: E741  the paper's letter: walkable
    H = 1  # no ground, ground too steep, or no flat patch of foot size
    P = 2  # taller than it can step on
    HP = 3  # both: the rim of something tall


def kinds(
    heights: NDArray[np.float64],
    known: NDArray[np.bool_],
    cell: float,
    machine: Machine,
    final: bool = False,
) -> NDArray[np.uint8]:
    """G-type heights to the ``Kind`` of every cell, from the known cells alone; unknown ones are O
    and hide nothing.

    Where all is known this is ``classify``, told by kind. ``final``: only the cell under the foot
    tip counts, H are the holes.
    """
    return kinds_within(whole(heights.shape), heights, known, cell, machine, final)


def kinds_within(
    window: Window,
    heights: NDArray[np.float64],
    known: NDArray[np.bool_],
    cell: float,
    machine: Machine,
    final: bool = False,
) -> NDArray[np.uint8]:
    """``kinds`` of the cells in one rectangle of a map; only its surroundings are read."""
    here = known[window]
    holes = here & np.isnan(heights[window])
    if final:
        return holes.astype(np.uint8)
    solid = here & ~holes
    low = holes | (solid & _is_rough_or_steep(window, heights, known, cell, machine))
    tall = solid & _is_tall(window, heights, known, cell)
    return np.asarray(low * np.uint8(Kind.H) + tall * np.uint8(Kind.P), dtype=np.uint8)


def _is_rough_or_steep(
    window: Window,
    heights: NDArray[np.float64],
    known: NDArray[np.bool_],
    cell: float,
    machine: Machine,
) -> NDArray[np.bool_]:
    """Where a foot would find too much relief, the rim of a hole or too steep a slope.

    What little relief alone rules out is not worked out.
    """
    reach = sole_cells(machine, cell)
    near = grown(window, max(reach, 1), heights.shape)
    inner = within(window, near)
    ground = heights[near]
    holes = known[near] & np.isnan(ground)
    solid = known[near] & ~holes
    high, depth = spread_max(np.where(solid, (ground, -ground), -np.inf), max(reach, 1))
    low = -depth
    difference = high - low
    relief = float(difference.max(initial=0.0))  # m, the most there is under any foot
    found = np.zeros(ground.shape, dtype=bool)
    if relief > RELIEF_MAX and reach:
        box = _box_around(difference > RELIEF_MAX)
        allowed = _relief_allowed(np.where(solid[box], ground[box], np.nan), reach)
        found[box] = difference[box] > allowed
    if reach and holes.any():
        found |= spread_max(holes.astype(np.float64), reach) > 0.0
    gentle = math.tan(SLOPE_MAX) * cell / math.sqrt(2.0)  # m; with less relief nothing is too steep
    if relief > gentle:
        box = _box_around(difference > gentle * NEARLY)
        found[box] |= _slope(ground[box], solid[box], cell) > math.tan(SLOPE_MAX)
    return np.asarray(found[inner])


def _box_around(cells: NDArray[np.bool_]) -> Window:
    """The least rectangle that holds some cells and their neighbours."""
    rows, columns = (np.flatnonzero(cells.any(axis=axis)) for axis in (1, 0))
    box = slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)
    return grown(box, 1, cells.shape)


def _is_tall(
    window: Window, heights: NDArray[np.float64], known: NDArray[np.bool_], cell: float
) -> NDArray[np.bool_]:
    """Where the ground stands more than ``RISE_MAX`` above the mean of what is known around it."""
    around = max(1, round(RISE_WINDOW / cell / 2))
    wide = grown(window, around, heights.shape)
    ground = np.where(known[wide], heights[wide], np.nan)
    here = ground[within(window, wide)]
    found = np.zeros(here.shape, dtype=bool)
    # nothing else can be that far above any mean
    high = here - np.fmin.reduce(ground, axis=None, initial=np.inf) > RISE_MAX * NEARLY
    if high.any():
        box = _box_around(high)
        inner = placed_in(box, within(window, wide))
        found[box] = here[box] - _mean_around(ground, around, inner) > RISE_MAX
    return found


def _relief_allowed(heights: NDArray[np.float64], reach: int) -> NDArray[np.float64]:
    """Relief a foot may stand on at every cell, m: ``RELIEF_MAX``, or what an even slope has under
    it.

    The slope is the lesser of before and behind, so that the riser of a step is none; nor is what
    goes up or down both ways.
    """
    even = np.zeros(heights.shape)
    for h, total in ((heights, even), (heights.T, even.T)):
        if len(h) < 3:
            continue
        rise = h[1:] - h[:-1]
        before, behind = rise[1:], rise[:-1]
        lesser = np.minimum(np.abs(before), np.abs(behind))
        total[1:-1] += np.where(before * behind > 0.0, lesser, 0.0)
    return np.maximum(RELIEF_MAX, SLOPING * 2 * reach * even)


def _slope(
    heights: NDArray[np.float64], solid: NDArray[np.bool_], cell: float
) -> NDArray[np.float64]:
    """Steepness between known neighbours: central where both are known, one-sided where one is,
    else 0.
    """
    filled = np.where(solid, heights, 0.0)
    along_y = _mean_rise(filled, solid) / cell
    along_x = _mean_rise(filled.T, solid.T).T / cell
    return np.asarray(np.hypot(along_y, along_x))


def _mean_rise(lines: NDArray[np.float64], stands: NDArray[np.bool_]) -> NDArray[np.float64]:
    """How much each line of cells rises from the one before and to the next: the mean of both where
    ground stands in all three.
    """
    both = stands[1:] & stands[:-1]
    rise = np.where(both, lines[1:] - lines[:-1], 0.0)
    total = np.zeros_like(lines)
    total[1:] = rise
    total[:-1] += rise
    # where there are two
    total[1:-1][both[1:] & both[:-1]] /= 2.0
    return total


def classify(heights: NDArray[np.float64], cell: float, machine: Machine) -> NDArray[np.bool_]:
    """Where ``machine`` must not land, from heights alone: the step from G-type to HP-type terrain
    (H §2.3).

    H: no ground, slope over 35 degrees, or more than 0.03 m of relief under the foot that is no
    even slope; P: over 0.30 m above the ground around.
    """
    rows, columns = heights.shape
    holes = np.isnan(heights)
    if holes.all():
        return np.ones(heights.shape, dtype=bool)
    solid = heights[~holes]
    if solid.max() == solid.min():
        return spread_max(holes.astype(np.float64), sole_cells(machine, cell)) > 0.0
    reach = sole_cells(machine, cell)
    high = spread_max(np.where(holes, -np.inf, heights), reach)
    # a hole under the foot's rim makes relief infinite
    low = -spread_max(np.where(holes, np.inf, -heights), reach)
    with np.errstate(invalid="ignore"):  # nothing but holes under the foot: −inf less −inf
        rough = ~(high - low <= _relief_allowed(heights, reach))
    filled = np.where(holes, np.nanmean(heights), heights)
    slope_y, slope_x = (
        np.gradient(filled, cell, axis=axis) if filled.shape[axis] > 1 else np.zeros_like(filled)
        for axis in (0, 1)
    )
    steep = np.hypot(slope_x, slope_y) > math.tan(SLOPE_MAX)
    around = max(1, round(RISE_WINDOW / cell / 2))
    tall = filled - _mean_around(heights, around, np.s_[:rows, :columns]) > RISE_MAX
    return np.asarray(holes | rough | steep | tall, dtype=bool)


def classify_again(
    heights: NDArray[np.float64],
    forbidden: NDArray[np.bool_],
    cell: float,
    machine: Machine,
    cells: Sequence[tuple[int, int]],
) -> NDArray[np.bool_]:
    """``forbidden`` brought up to date after the heights of some (row, column) cells have changed:
    only their surroundings are read.
    """
    near = surroundings_of(machine, cell)
    rows = [row for row, _ in cells]
    columns = [column for _, column in cells]
    changed = slice(min(rows), max(rows) + 1), slice(min(columns), max(columns) + 1)
    inner = grown(changed, near, heights.shape)
    outer = grown(inner, near, heights.shape)
    again = forbidden.copy()
    again[inner] = classify(heights[outer], cell, machine)[within(inner, outer)]
    return again


def surroundings_of(machine: Machine, cell: float) -> int:
    """How many cells away a height may decide whether a cell is prohibited."""
    return max(sole_cells(machine, cell) + 1, round(RISE_WINDOW / cell / 2) + 1)


def sole_cells(machine: Machine, cell: float) -> int:
    """How many whole cells the sole's rim reaches beyond the cell under its tip."""
    return math.floor(machine.foot_radius / cell + 1e-9)


def _mean_around(heights: NDArray[np.float64], reach: int, inner: Window) -> NDArray[np.float64]:
    """Mean of the ground that exists in the square of ``reach`` cells around each cell of a
    rectangle of them.
    """
    exists = ~np.isnan(heights)
    total = _box_sum(np.where(exists, heights, 0.0), reach, inner)
    count = _box_sum(exists.astype(np.int32), reach, inner)
    return np.asarray(total / np.maximum(count, 1))


def _box_sum(values: NDArray[Any], reach: int, inner: Window) -> NDArray[Any]:
    """Sums over the square of ``reach`` cells around each cell of a rectangle of them."""
    side = 2 * reach + 1
    rows, columns = values.shape
    padded = np.zeros((rows + side, columns + side), dtype=values.dtype)
    padded[reach + 1 : reach + 1 + rows, reach + 1 : reach + 1 + columns] = values
    (top, bottom), (left, right) = ((part.start or 0, part.stop) for part in inner)
    down = padded[: bottom + side, : right + side].cumsum(axis=0, dtype=values.dtype)
    below = down[top:bottom].cumsum(axis=1, dtype=values.dtype)
    above = down[top + side :].cumsum(axis=1, dtype=values.dtype)
    before = slice(left, right)
    after = slice(left + side, None)
    return np.asarray(above[:, after] - below[:, after] - above[:, before] + below[:, before])
