"""How the walker's map of the ground grows: what the eye returns, what the feet touch, what has
been learnt the hard way.

The planners know only ``TerrainMap``; ``ElevationMapper`` is where one comes from when the truth is
not given. It is changed in place by the console alone and publishes a new frozen map when told to,
working out only the patch that has changed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import left_fold_sum
from ..robot.model import Machine
from ..types import Array, Point
from .grid import Window, grown, within
from .map import EDGE, TerrainMap
from .traversability import RISE_WINDOW, Kind, kinds, sole_cells

Index = NDArray[np.intp]

LOOKS_MAX = 16  # looks averaged; more and a map hardly follows ground that changes
JUMP = 0.05  # m; a look this far off the mean is no noise: the newest is believed
REPLAN_THRESHOLD = 0.004  # m; heights that moved less are not worth a new map (and a new plan)
LEVEL_REPLAN_THRESHOLD = 0.01  # m; the same for the supposed level of unknown ground
AROUND = 1.5  # m about the feet in which unknown ground is supposed anew
TREATMENTS = ("flat", "forbidden")


class ElevationMapper:
    """The map as the walker knows it. ``unknown`` ground is taken to be flat (touch decides, H) or
    forbidden (K).
    """

    def __init__(
        self,
        shape: tuple[int, int],
        cell: float,
        origin: tuple[float, float],
        machine: Machine,
        *,
        unknown: str = "flat",
        final: bool = False,
        level: float = 0.0,
        edge: float = EDGE,
    ) -> None:
        if unknown not in TREATMENTS:
            raise ValueError(
                f"unknown treatment of unknown ground {unknown!r}; "
                f"there are: {', '.join(TREATMENTS)}"
            )
        self.machine = machine
        self.unknown = unknown
        self.final = final  # only the cell under the foot tip counts
        self.level = level  # m, where unknown ground is supposed to be
        self.heights: Array = np.full(shape, math.nan)  # NaN: unknown, or known to be a hole
        self.known = np.zeros(shape, dtype=bool)
        self.kinds = np.zeros(shape, dtype=np.uint8)
        # prohibited by experience: stays so whatever the eye says
        self.learnt = np.zeros(shape, dtype=bool)
        self._looks = np.zeros(shape, dtype=np.uint8)
        self._changed: list[int] = []  # first row, last row, first column, last column
        self._feet: tuple[Point, ...] = ()  # where unknown ground has more than one supposed level
        # the one level unknown ground was last given; NaN while there are several
        self._level_given = level
        refused = np.full(shape, unknown == "forbidden")
        self.map = TerrainMap(
            np.full(shape, level),
            refused,
            cell,
            origin,
            machine.foot_radius,
            self.known.copy(),
            edge,
        )

    # what comes in

    def see(
        self,
        rows: NDArray[np.intp],
        columns: NDArray[np.intp],
        heights: Array,
        sides: NDArray[np.bool_] | None = None,
    ) -> None:
        """Returns of one look, no cell twice. NaN is a hole; of ``sides`` only "at least this high"
        is known.
        """
        if rows.size == 0:
            return
        known = self.known[rows, columns]
        old = self.heights[rows, columns]
        looks = self._looks[rows, columns]
        side = np.zeros(rows.shape, dtype=bool) if sides is None else sides
        agrees = known & (looks > 0) & (np.abs(heights - old) <= JUMP)
        mean = np.where(agrees, old + (heights - old) / (looks + 1.0), heights)
        # nothing new: it is known to be that high
        idle = side & known & ((old >= heights) | agrees)
        new = np.where(idle, old, np.where(side, heights, mean))
        count = np.where(
            side, np.where(idle, looks, 0), np.where(agrees, np.minimum(looks + 1, LOOKS_MAX), 1)
        )
        self._write(rows, columns, new, count.astype(np.uint8))

    def touch(self, points: Iterable[Point]) -> None:
        """Feet stand here: the cells under the soles have this height, for certain."""
        reach = 0 if self.final else sole_cells(self.machine, self.map.cell)
        for x, y, z in points:
            at = self.map.cell_at(x, y)
            if at is None:
                continue
            rows, columns = np.mgrid[
                at[0] - reach : at[0] + reach + 1, at[1] - reach : at[1] + reach + 1
            ].reshape(2, -1)
            here = (
                (rows >= 0) & (rows < self.map.rows) & (columns >= 0) & (columns < self.map.columns)
            )
            rows = rows[here]
            columns = columns[here]
            # the rim of the sole adds, never overrides
            wanted = (rows == at[0]) & (columns == at[1]) | ~self.known[rows, columns]
            rows = rows[wanted]
            columns = columns[wanted]
            self._write(
                rows,
                columns,
                np.full(rows.shape, z),
                np.full(rows.shape, LOOKS_MAX, dtype=np.uint8),
            )

    def learn(self, cells: Iterable[tuple[int, int]]) -> None:
        """No foot may land here again: touch has shown it."""
        self._mark(cells, True)

    def feel(self, heights: Mapping[tuple[int, int], float]) -> None:
        """Cells are at least so high, m, or holes (NaN): touch has shown it."""
        if not heights:
            return
        at = np.array(list(heights), dtype=np.intp)
        values = np.array(list(heights.values()), dtype=np.float64)
        self.see(at[:, 0], at[:, 1], values, ~np.isnan(values))

    def forget(self, cells: Iterable[tuple[int, int]]) -> None:
        """Take back what was learnt, when the operator says so."""
        self._mark(cells, False)

    def set_prior(self, feet: Sequence[Point]) -> None:
        """Unknown ground is as high as the nearest foot stands (TITAN III took the height of P_u, H
        §10.3).
        """
        heights = [foot[2] for foot in feet]
        level = left_fold_sum(heights) / len(heights)
        uneven = max(heights) - min(heights) > LEVEL_REPLAN_THRESHOLD
        if not uneven and abs(level - self._level_given) <= LEVEL_REPLAN_THRESHOLD:
            self._feet = ()
            return
        self.level = level
        self._level_given = math.nan if uneven else level
        self._feet = tuple(feet) if uneven else ()
        if self.known.all():
            return
        xs = [foot[0] for foot in feet]
        ys = [foot[1] for foot in feet]
        rows, columns = self.map.window(
            min(xs) - AROUND, max(xs) + AROUND, min(ys) - AROUND, max(ys) + AROUND
        )
        self._note(rows.start, rows.stop - 1, columns.start, columns.stop - 1)

    def observe(
        self,
        rows: NDArray[np.intp],
        columns: NDArray[np.intp],
        heights: Array,
        sides: NDArray[np.bool_] | None = None,
    ) -> TerrainMap:
        """See and publish."""
        self.see(rows, columns, heights, sides)
        return self.publish()

    # what goes out

    def publish(self) -> TerrainMap:
        """The newest map; the same object as before when there is no news."""
        if not self._changed:
            return self.map
        r0, r1, c0, c1 = self._changed
        self._changed = []
        reach = math.ceil(max(RISE_WINDOW / 2, self.machine.foot_radius) / self.map.cell) + 1
        shape = self.heights.shape
        inner = grown((slice(r0, r1 + 1), slice(c0, c1 + 1)), reach, shape)
        outer = grown(inner, reach, shape)
        found = kinds(
            self.heights[outer], self.known[outer], self.map.cell, self.machine, self.final
        )[within(inner, outer)]
        self.kinds[inner] = found
        known = self.known[inner]
        forbidden = (found != Kind.O) | self.learnt[inner]
        if self.unknown == "forbidden":
            forbidden |= ~known
        self.map = self.map.patched(inner, self._filled(inner, outer), forbidden, known)
        return self.map

    def _filled(self, inner: Window, outer: Window) -> Array:
        """Heights with the gaps filled: by the known ground around, else the level of the feet."""
        heights = self.heights[outer]
        known = self.known[outer]
        if known.all():
            return self.heights[inner]
        solid = known & ~np.isnan(heights)
        total = np.where(solid, heights, 0.0)
        count = solid.astype(np.float64)
        for axis in (0, 1):
            total = _sum_of_five(total, axis)
            count = _sum_of_five(count, axis)
        guess = np.where(count > 0.0, total / np.maximum(count, 1.0), self._level_in(outer))
        return np.asarray(np.where(known, heights, guess)[within(inner, outer)])

    def _level_in(self, window: Window) -> Array | float:
        """The supposed level: one for all, or that of the nearest foot."""
        if not self._feet:
            return self.level
        ox, oy = self.map.origin
        x = ox + (np.arange(window[1].start, window[1].stop) + 0.5) * self.map.cell
        y = oy + (np.arange(window[0].start, window[0].stop) + 0.5) * self.map.cell
        far = np.array(
            [np.add.outer((y - foot[1]) ** 2, (x - foot[0]) ** 2) for foot in self._feet]
        )
        return np.asarray(np.array([foot[2] for foot in self._feet])[far.argmin(axis=0)])

    # bookkeeping

    def _write(
        self,
        rows: NDArray[np.intp],
        columns: NDArray[np.intp],
        heights: Array,
        looks: NDArray[np.uint8],
    ) -> None:
        before = self.map.heights[rows, columns]
        was_known = self.known[rows, columns]
        same = (np.abs(heights - before) <= REPLAN_THRESHOLD) | (
            np.isnan(heights) & np.isnan(before)
        )
        self.heights[rows, columns] = heights
        self.known[rows, columns] = True
        self._looks[rows, columns] = looks
        news = ~(was_known & same)
        if news.any():
            rows = rows[news]
            columns = columns[news]
            self._note(int(rows.min()), int(rows.max()), int(columns.min()), int(columns.max()))

    def _mark(self, cells: Iterable[tuple[int, int]], learnt: bool) -> None:
        for row, column in cells:
            self.map.need_cell(row, column)
            if self.learnt[row, column] != learnt:
                self.learnt[row, column] = learnt
                self._note(row, row, column, column)

    def _note(self, r0: int, r1: int, c0: int, c1: int) -> None:
        if self._changed:
            a, b, c, d = self._changed
            r0 = min(a, r0)
            r1 = max(b, r1)
            c0 = min(c, c0)
            c1 = max(d, c1)
        self._changed = [r0, r1, c0, c1]


def _sum_of_five(values: Array, axis: int) -> Array:
    """Each cell with its two neighbours on either side along one axis."""
    lines = np.moveaxis(values, axis, 0)
    total = lines.copy()
    for shift in (1, 2):
        total[shift:] += lines[:-shift]
        total[:-shift] += lines[shift:]
    return np.asarray(np.moveaxis(total, 0, axis))
