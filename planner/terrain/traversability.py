"""Where a machine can tread: from heights to forbidden cells, the step from G-type to HP-type
terrain (H §2.3).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import IntFlag

import numpy as np
from numpy.typing import NDArray

from ..robot.model import Machine
from .grid import Window, grown, spread_max, within

SLOPE_MAX = math.radians(35.0)  # steeper ground is H: see feet slide off (titan3 default)
RELIEF_MAX = 0.03  # m under one foot; more is H: see feet land on edges
SLOPING = 1.1  # times what an even slope gives a foot of relief; more is no slope
RISE_MAX = 0.30  # m above the ground around; taller is P: see legs hit what they cannot step on
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
    rows, columns = heights.shape
    return kinds_within((slice(0, rows), slice(0, columns)), heights, known, cell, machine, final)


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
    high = spread_max(np.where(solid, ground, -np.inf), max(reach, 1))
    low = -spread_max(np.where(solid, -ground, -np.inf), max(reach, 1))
    relief = float((high - low).max(initial=0.0))  # m, the most there is under any foot
    found = np.zeros(ground.shape, dtype=bool)
    if relief > RELIEF_MAX and reach:
        found |= high - low > _relief_allowed(np.where(solid, ground, np.nan), reach)
    if reach and holes.any():
        found |= spread_max(holes.astype(np.float64), reach) > 0.0
    if math.sqrt(2.0) * relief > math.tan(SLOPE_MAX) * cell:
        found |= _slope(ground, solid, cell) > math.tan(SLOPE_MAX)
    return np.asarray(found[inner])


def _is_tall(
    window: Window, heights: NDArray[np.float64], known: NDArray[np.bool_], cell: float
) -> NDArray[np.bool_]:
    """Where the ground stands more than ``RISE_MAX`` above the mean of what is known around it."""
    around = max(1, round(RISE_WINDOW / cell / 2))
    wide = grown(window, around, heights.shape)
    ground = np.where(known[wide], heights[wide], np.nan)
    low = np.fmin.reduce(ground, axis=None, initial=np.inf)
    high = np.fmax.reduce(ground, axis=None, initial=-np.inf)
    here = heights[window]
    if not high - low > RISE_MAX:  # nothing can be that far above any mean
        return np.zeros(here.shape, dtype=bool)
    return np.asarray(here - _mean_around(ground, around)[within(window, wide)] > RISE_MAX)


def _relief_allowed(heights: NDArray[np.float64], reach: int) -> NDArray[np.float64]:
    """Relief a foot may stand on at every cell, m: ``RELIEF_MAX``, or what an even slope has under
    it.

    The slope is the lesser of before and behind, so that the riser of a step is none; nor is what
    goes up or down both ways.
    """
    even = np.zeros(heights.shape)
    for axis in (0, 1):
        if heights.shape[axis] < 3:
            continue
        h = np.moveaxis(heights, axis, 0)
        total = np.moveaxis(even, axis, 0)
        before = h[2:] - h[1:-1]
        behind = h[1:-1] - h[:-2]
        total[1:-1] += np.where(
            before * behind > 0.0, np.minimum(np.abs(before), np.abs(behind)), 0.0
        )
    return np.maximum(RELIEF_MAX, SLOPING * 2 * reach * even)


def _slope(
    heights: NDArray[np.float64], solid: NDArray[np.bool_], cell: float
) -> NDArray[np.float64]:
    """Steepness between known neighbours: central where both are known, one-sided where one is,
    else 0.
    """
    steepness = np.zeros(heights.shape)
    filled = np.where(solid, heights, 0.0)
    for axis in (0, 1):
        h = np.moveaxis(filled, axis, 0)
        stands = np.moveaxis(solid, axis, 0)
        both = stands[1:] & stands[:-1]
        rise = np.where(both, h[1:] - h[:-1], 0.0)
        total = np.zeros(h.shape)
        count = np.zeros(h.shape)
        for side in (slice(1, None), slice(None, -1)):
            total[side] += rise
            count[side] += both
        steepness = np.hypot(steepness, np.moveaxis(total / np.maximum(count, 1.0) / cell, 0, axis))
    return steepness


def classify(heights: NDArray[np.float64], cell: float, machine: Machine) -> NDArray[np.bool_]:
    """Where ``machine`` must not land, from heights alone: the step from G-type to HP-type terrain
    (H §2.3).

    H: no ground, slope over 35 degrees, or more than 0.03 m of relief under the foot that is no
    even slope; P: over 0.30 m above the ground around.
    """
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
    tall = filled - _mean_around(heights, max(1, round(RISE_WINDOW / cell / 2))) > RISE_MAX
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
    near = max(sole_cells(machine, cell) + 1, round(RISE_WINDOW / cell / 2) + 1)
    rows = [row for row, _ in cells]
    columns = [column for _, column in cells]
    changed = slice(min(rows), max(rows) + 1), slice(min(columns), max(columns) + 1)
    inner = grown(changed, near, heights.shape)
    outer = grown(inner, near, heights.shape)
    again = forbidden.copy()
    again[inner] = classify(heights[outer], cell, machine)[within(inner, outer)]
    return again


def sole_cells(machine: Machine, cell: float) -> int:
    """How many whole cells the sole's rim reaches beyond the cell under its tip."""
    return math.floor(machine.foot_radius / cell + 1e-9)


def _mean_around(heights: NDArray[np.float64], reach: int) -> NDArray[np.float64]:
    """Mean of the ground that exists in the square of ``reach`` cells around each cell."""
    exists = ~np.isnan(heights)
    total = _box_sum(np.where(exists, heights, 0.0), reach)
    count = _box_sum(exists.astype(np.float64), reach)
    return np.asarray(total / np.maximum(count, 1.0))


def _box_sum(values: NDArray[np.float64], reach: int) -> NDArray[np.float64]:
    padded = np.pad(values, ((reach + 1, reach), (reach + 1, reach)))
    summed = padded.cumsum(axis=0).cumsum(axis=1)
    side = 2 * reach + 1
    return np.asarray(
        summed[side:, side:]
        - summed[:-side, side:]
        - summed[side:, :-side]
        + summed[:-side, :-side]
    )
