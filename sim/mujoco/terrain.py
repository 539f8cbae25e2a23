"""The true ground as MuJoCo's shapes: a height field where it is relief, else boxes.

Boxes are exact: cells of one height are merged into rectangles, a bottomless cell has nothing; a
model holds those that are near (``near_ground``). A height field is exact too: a node at every
cell's centre and straight between them, in the triangles that ``Ground.height_at`` has. A hole dug
in one is a pit that begins half a cell too early.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.types import Array

from ..terrain.ground import Ground
from .library import mujoco

THICK = 0.5  # m of a box below the lowest level
RISE_MIN = 1e-3  # m from the lowest to the highest of a height field
PIT = 1.0  # m, depth of a hole in a height field
AWAY = 1e4  # m below, where a shape of a pool is before it is a box
GROUND = 1  # contact bit

_Numbers = NDArray[np.intp]


class MergedCells(NamedTuple):
    """Cells of one height: boxes of rows r0 <= r < r1 and columns c0 <= c < c1, all (n,), and
    ``number`` (ny, nx), which box a cell is in, −1 over a hole.
    """

    r0: _Numbers
    r1: _Numbers
    c0: _Numbers
    c1: _Numbers
    height: NDArray[np.float64]
    number: _Numbers


def merged(heights: NDArray[np.float64]) -> MergedCells:
    """Cells of equal height as rectangles: runs along each row, joined with equal runs below."""
    solid = ~np.isnan(heights)
    first = solid.copy()
    first[:, 1:] &= heights[:, 1:] != heights[:, :-1]
    run = np.cumsum(first.ravel())[solid.ravel()] - 1  # of every solid cell
    row, c0 = np.nonzero(first)
    c1 = c0 + np.bincount(run, minlength=len(row))
    height = heights[first]
    # runs that are alike one after the other, from above: each that does not go on begins a box
    order = np.lexsort((row, height, c1, c0))
    alike = np.ones(max(0, len(order) - 1), dtype=bool)
    for key, far in ((c0, 0), (c1, 0), (height, 0), (row, 1)):
        alike &= key[order[1:]] == key[order[:-1]] + far
    begins = np.flatnonzero(np.append(True, ~alike)[: len(order)])
    tops = order[begins]
    ends = order[np.append(begins[1:], len(order)) - 1] if len(order) else tops
    boxes = (row[tops], row[ends] + 1, c0[tops], c1[tops], height[tops])
    ranked = np.lexsort(boxes[::-1])
    rank = np.empty(len(ranked), dtype=np.intp)
    rank[ranked] = np.arange(len(ranked))
    of_run = np.empty(len(order), dtype=np.intp)
    of_run[order] = np.repeat(rank, np.diff(np.append(begins, len(order))))
    number = np.full(heights.shape, -1, dtype=np.intp)
    number[solid] = of_run[run]
    r0, r1, c0, c1 = (side[ranked] for side in boxes[:4])
    return MergedCells(r0, r1, c0, c1, boxes[4][ranked], number)


def add_ground(spec: Any, ground: Ground, pool: int, contact: dict[str, Any]) -> None:
    """Put the ground into a model: its field, or a ``pool`` of so many shapes that are no boxes of
    it yet (``near_ground``). ``contact`` is what its surface is like.
    """
    if ground.relief:
        _add_field(spec, ground, contact)
        return
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_MIDPHASE  # shapes are moved about
    away = {"pos": [0.0, 0.0, -AWAY], "size": [0.1, 0.1, 0.1]}
    for _ in range(pool):
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, **away, **contact)


def _solid(ground: Ground) -> Array:
    """Heights with a pit in place of every hole, m."""
    low = np.fmin.reduce(ground.heights, axis=None)
    return np.where(np.isnan(ground.heights), low - PIT, ground.heights)


def _base_and_rise(heights: Array) -> tuple[float, float]:
    """The lowest height of a field, m, and how far its highest is above it."""
    base = float(heights.min())
    return base, max(float(heights.max()) - base, RISE_MIN)


def fill_field(model: Any, ground: Ground) -> None:
    """Give the field of a compiled model its heights, from 0 to 1: a third of the time it takes to
    hand them over one by one.
    """
    heights = _solid(ground)
    base, tall = _base_and_rise(heights)
    shares = ((heights - base) / tall).astype(np.float32).ravel()
    highest = shares.max()
    model.hfield_data[:] = shares / highest if highest > 0.0 else shares


def _add_field(spec: Any, ground: Ground, contact: dict[str, Any]) -> None:
    heights = _solid(ground)
    base, tall = _base_and_rise(heights)
    rows, columns = heights.shape
    half_x = max((columns - 1) * ground.cell / 2, 1e-3)
    half_y = max((rows - 1) * ground.cell / 2, 1e-3)
    spec.add_hfield(
        name="relief",
        nrow=rows,
        ncol=columns,
        size=[half_x, half_y, tall, THICK],
        userdata=[0.0] * heights.size,  # ``fill_field``
    )
    x, y = ground.origin
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_HFIELD,
        hfieldname="relief",
        pos=[x + ground.cell / 2 + half_x, y + ground.cell / 2 + half_y, base],
        **contact,
    )
