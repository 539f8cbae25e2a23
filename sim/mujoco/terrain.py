"""The true ground as MuJoCo's shapes: a height field where it is relief, else boxes.

Boxes are exact: cells of one height are merged into rectangles, a bottomless cell has nothing; a
model holds those that are near (``near_ground``). A height field is exact too: a node at every
cell's centre and straight between them, in the triangles that ``Ground.height_at`` has. A hole dug
in one is a pit that begins half a cell too early.
"""

from __future__ import annotations

import math
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
FIELD = 0  # a field is the first of a model's shapes

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
    holes = np.isnan(ground.heights)
    if not holes.any():
        return ground.heights
    low = np.fmin.reduce(ground.heights, axis=None)
    return np.where(holes, low - PIT, ground.heights)


def _base_and_rise(heights: Array) -> tuple[float, float]:
    """The lowest height of a field, m, and how far its highest is above it."""
    base = float(heights.min())
    return base, max(float(heights.max()) - base, RISE_MIN)


def _size_and_place(ground: Ground, base: float, tall: float) -> tuple[list[float], list[float]]:
    """Half the sides of a field, its rise and its thickness, and where its middle is, m."""
    rows, columns = ground.heights.shape
    half_x = max((columns - 1) * ground.cell / 2, 1e-3)
    half_y = max((rows - 1) * ground.cell / 2, 1e-3)
    x, y = ground.origin
    place = [x + ground.cell / 2 + half_x, y + ground.cell / 2 + half_y, base]
    return [half_x, half_y, tall, THICK], place


def holds_field(model: Any, ground: Ground) -> bool:
    """True when a compiled model has a field of as many rows and columns as this ground."""
    if not ground.relief or model.nhfield == 0:
        return False
    return (int(model.hfield_nrow[0]), int(model.hfield_ncol[0])) == ground.heights.shape


def fill_field(model: Any, ground: Ground) -> None:
    """Give the field of a compiled model the heights of this ground, from 0 to 1, its size and its
    place: a fraction of the time it takes to hand them over one by one, or to compile anew.
    """
    heights = _solid(ground)
    base, tall = _base_and_rise(heights)
    shares = ((heights - base) / tall).astype(np.float32).ravel()
    highest = shares.max()
    model.hfield_data[:] = shares / highest if 0.0 < highest < 1.0 else shares
    size, place = _size_and_place(ground, base, tall)
    half_x, half_y = size[:2]
    model.hfield_size[0] = size
    model.geom_pos[FIELD] = place
    # what the compiler makes of the size: an ellipsoid, a sphere and a box around the field
    model.geom_size[FIELD] = half_x, half_y, 0.25 * tall + 0.5 * THICK
    far = max(tall, THICK)
    model.geom_rbound[FIELD] = math.sqrt(half_x * half_x + half_y * half_y + far * far)
    middle, half = (tall - THICK) / 2, (tall + THICK) / 2
    model.geom_aabb[FIELD] = 0.0, 0.0, middle, half_x, half_y, half
    model.bvh_aabb[FIELD] = place[0], place[1], base + middle, half_x, half_y, half


def _add_field(spec: Any, ground: Ground, contact: dict[str, Any]) -> None:
    rows, columns = ground.heights.shape
    size, place = _size_and_place(ground, *_base_and_rise(_solid(ground)))
    spec.add_hfield(
        name="relief",
        nrow=rows,
        ncol=columns,
        size=size,
        userdata=[0.0] * ground.heights.size,  # ``fill_field``
    )
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_HFIELD, hfieldname="relief", pos=place, **contact
    )
