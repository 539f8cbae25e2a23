"""The boxes of the ground that feet and torso may meet in the next tick, in a pool of shapes.

MuJoCo works out the pose of every shape in every step, near or far: 20,000 boxes take 2 ms a tick.
So a model holds a few dozen shapes, which before each tick become the boxes about every foot, and
those about the torso that are as tall. Which they are follows from where feet and torso are and not
from what was before; they keep the order they have on the whole map, and what is farther away meets
nothing: a walk on the pool is the walk on all of them, to the last bit.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.geometry.transforms import Point

from ..terrain.ground import Ground
from .terrain import GROUND, THICK, MergedCells, merged

# m that a foot or the torso goes in a tick at most. Less: see what falls fast fall through
REACH = 0.1
SHARE = 32  # shapes a pool grows by

_Floats = NDArray[np.float64]
_Cell = tuple[int, int]


class NearGround:
    """All boxes of a ground, by number, and which of them are near.

    ``foot`` and ``torso`` are how far a foot's ball and the torso reach from their middles, m.
    """

    def __init__(self, ground: Ground, foot: float, torso: float) -> None:
        boxes = merged(ground.heights)
        self.places, self.sizes = _shapes(ground, boxes)
        self.tops = boxes.height
        self.top = float(self.tops.max(initial=-math.inf))
        self._number = boxes.number
        self._corner = ground.origin
        self._cell = ground.cell
        self._about_foot = math.ceil((foot + REACH) / ground.cell)
        self._about_torso = math.ceil((torso + REACH) / ground.cell)
        self._last: dict[_Cell, frozenset[int]] = {}
        self._torso: tuple[_Cell, int] | None = None
        self._about: frozenset[int] = frozenset()

    def numbers(self, feet: Iterable[Sequence[float]], torso: Point) -> list[int]:
        """Numbers of the boxes near these feet, and near a torso whose lowest point is the z of
        ``torso``, in order; all absolute, m.
        """
        last = self._last
        cells = [self._cell_of(foot[0], foot[1]) for foot in feet]
        self._last = {cell: last.get(cell) or self._around(cell) for cell in cells}
        near = frozenset().union(*self._last.values(), self._around_torso(torso))
        return sorted(near)

    def _cell_of(self, x: float, y: float) -> _Cell:
        """Row and column, beyond the map too."""
        x0, y0 = self._corner
        return math.floor((y - y0) / self._cell), math.floor((x - x0) / self._cell)

    def _around(self, cell: _Cell) -> frozenset[int]:
        return frozenset(self._within(cell, self._about_foot).tolist())

    def _around_torso(self, torso: Point) -> frozenset[int]:
        """The boxes about the torso that stand as high as it may be in a tick."""
        x, y, low = torso
        if low > self.top + REACH:
            return frozenset()
        level = math.floor(low / REACH) - 1
        now = self._cell_of(x, y), level
        if now != self._torso:
            self._torso = now
            near = self._within(now[0], self._about_torso)
            self._about = frozenset(near[self.tops[near] >= level * REACH].tolist())
        return self._about

    def _within(self, cell: _Cell, reach: int) -> NDArray[np.intp]:
        """Numbers of the boxes in the square of ``reach`` cells around one, each once."""
        row, column = cell
        part = self._number[
            max(0, row - reach) : max(0, row + reach + 1),
            max(0, column - reach) : max(0, column + reach + 1),
        ]
        found = np.unique(part)
        return found[found >= 0]


def shares(count: int) -> int:
    """How many shapes a pool for so many boxes has."""
    return SHARE * max(1, math.ceil(count / SHARE))


def lay(model: Any, pool: int, ground: NearGround, numbers: Sequence[int]) -> None:
    """Make the first shapes of a pool these boxes, and let the rest meet nothing."""
    count = len(numbers)
    sizes = ground.sizes[numbers]
    model.geom_pos[:count] = ground.places[numbers]
    model.geom_size[:count] = sizes
    model.geom_aabb[:count, 3:] = sizes
    model.geom_rbound[:count] = np.sqrt((sizes * sizes).sum(axis=1))
    model.geom_contype[:count] = GROUND
    model.geom_contype[count:pool] = 0


def _shapes(ground: Ground, boxes: MergedCells) -> tuple[_Floats, _Floats]:
    """Middles and half sizes of boxes, (n, 3), m."""
    r0, r1, c0, c1, height, _ = boxes
    x, y = ground.origin
    cell = ground.cell
    bottom = height.min(initial=math.inf) - THICK
    size = np.column_stack([(c1 - c0) * cell, (r1 - r0) * cell, height - bottom]) / 2
    return np.column_stack(
        [x + c0 * cell, y + r0 * cell, np.full_like(height, bottom)]
    ) + size, size
