"""The true ground as MuJoCo's shapes: a height field where it is relief, else boxes.

Boxes are exact: cells of one height are merged into rectangles, a bottomless cell has nothing; a
model holds those that are near (``near_ground``). A height field is exact too: a node at every
cell's centre and straight between them, in the triangles that ``Ground.height_at`` has. A hole dug
in one is a pit that begins half a cell too early.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..terrain.ground import Ground
from .library import mujoco

THICK = 0.5  # m of a box below the lowest level
PIT = 1.0  # m, depth of a hole in a height field
AWAY = 1e4  # m below, where a shape of a pool is before it is a box
GROUND = 1  # contact bit


class MergedCells(NamedTuple):
    """Cells of one height: rows r0 <= r < r1, columns c0 <= c < c1."""

    r0: int
    r1: int
    c0: int
    c1: int
    height: float


def merged(heights: NDArray[np.float64]) -> list[MergedCells]:
    """Cells of equal height as rectangles: runs along each row, joined with equal runs below."""
    done: list[MergedCells] = []
    current: dict[tuple[int, int, float], int] = {}
    for row in range(heights.shape[0]):
        runs = dict.fromkeys(_runs(heights[row]), row)
        for run, begun in current.items():
            if run in runs:
                runs[run] = begun
            else:
                done.append(MergedCells(begun, row, *run))
        current = runs
    rows = heights.shape[0]
    done += [MergedCells(begun, rows, *run) for run, begun in current.items()]
    return sorted(done)


def _runs(row: NDArray[np.float64]) -> Iterator[tuple[int, int, float]]:
    """Columns from, to, and height of each stretch of equal cells; holes are left out."""
    marked = np.where(np.isnan(row), np.inf, row)
    ends = [0, *(np.nonzero(marked[1:] != marked[:-1])[0] + 1).tolist(), len(row)]
    for c0, c1 in zip(ends, ends[1:], strict=False):
        if np.isfinite(marked[c0]):
            yield c0, c1, float(row[c0])


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


def _add_field(spec: Any, ground: Ground, contact: dict[str, Any]) -> None:
    low = np.fmin.reduce(ground.heights, axis=None)
    heights = np.where(np.isnan(ground.heights), low - PIT, ground.heights)
    base = float(heights.min())
    tall = max(float(heights.max()) - base, 1e-3)
    rows, columns = heights.shape
    half_x = max((columns - 1) * ground.cell / 2, 1e-3)
    half_y = max((rows - 1) * ground.cell / 2, 1e-3)
    spec.add_hfield(
        name="relief",
        nrow=rows,
        ncol=columns,
        size=[half_x, half_y, tall, THICK],
        userdata=((heights - base) / tall).astype(np.float32).ravel(),
    )
    x, y = ground.origin
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_HFIELD,
        hfieldname="relief",
        pos=[x + ground.cell / 2 + half_x, y + ground.cell / 2 + half_y, base],
        **contact,
    )
