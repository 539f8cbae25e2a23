"""How the walker's map of the ground grows: what the eye returns, what the feet touch, what has
been learnt the hard way.

The planners know only ``TerrainMap``; ``ElevationMapper`` is where one comes from when the truth is
not given. It is changed in place by the console alone and publishes a new frozen map when told to:
what feet have shown at once, what has been seen as far as ``working_map`` has come with it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import XY, left_fold_sum
from ..robot.model import Machine
from ..types import Array, Point
from .grid import Window, grown, holds, joined, whole
from .map import EDGE, TerrainMap
from .traversability import sole_cells
from .working_map import Evidence, Prior, WorkingMap

Index = NDArray[np.intp]

LOOKS_MAX = 16  # looks averaged; more and a map hardly follows ground that changes
JUMP = 0.05  # m; a look this far off the mean is no noise: the newest is believed
REPLAN_THRESHOLD = 0.004  # m; heights that moved less are not worth a new map (and a new plan)
LEVEL_REPLAN_THRESHOLD = 0.01  # m; the same for the supposed level of unknown ground
AROUND = 1.5  # m about the feet in which unknown ground is supposed anew
SAME = 1e-6  # m; feet this near to where they were have not moved
TREATMENTS = ("flat", "forbidden")


class Sightings(NamedTuple):
    """What has been seen and felt of a rectangle of the ground, and how often, (ny, nx)."""

    evidence: Evidence
    looks: NDArray[np.uint8]


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
        relief: bool = False,
    ) -> None:
        if unknown not in TREATMENTS:
            raise ValueError(
                f"unknown treatment of unknown ground {unknown!r}; "
                f"there are: {', '.join(TREATMENTS)}"
            )
        self.machine = machine
        self.unknown = unknown
        self.final = final  # only the cell under the foot tip counts
        evidence = Evidence.none(shape)
        self.heights = evidence.heights
        self.known = evidence.known
        self.learnt = evidence.learnt
        self._looks = np.zeros(shape, dtype=np.uint8)
        # the one level unknown ground was last given; NaN while there are several
        self._level_given = level
        self._supposed: Window = whole(shape)  # where unknown ground is as it was last given
        refused = np.full(shape, unknown == "forbidden")
        blank = TerrainMap(
            np.full(shape, level),
            refused,
            cell,
            origin,
            machine.foot_radius,
            self.known.copy(),
            edge,
            relief,
        )
        self._working = WorkingMap(evidence, blank, machine, final, Prior(level))
        self._patches: list[Window] = []  # small, to be renewed before anything is published
        # around what feet have shown, where unknown ground is supposed anew
        self._supposed_anew: Window | None = None

    @property
    def map(self) -> TerrainMap:
        """The map that was last published."""
        return self._working.map

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
        news = self._write(rows, columns, new, count.astype(np.uint8))
        self._working.mark(rows[news], columns[news])

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
            looks = np.full(rows.shape, LOOKS_MAX, dtype=np.uint8)
            level = self._middle_of(at, (x, y, z))
            news = self._write(rows, columns, np.full(rows.shape, level), looks)
            self._patch(rows[news].tolist(), columns[news].tolist())

    def _middle_of(self, cell: tuple[int, int], foot: Point) -> float:
        """Height of the middle of the cell a foot stands in, m: of relief that is known around it
        not the foot's own.
        """
        x, y, z = foot
        if not self.map.relief or not self.known[cell]:
            return z
        return z + float(self.map.heights[cell]) - self.map.height_at(x, y)

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
        self._patch(at[:, 0].tolist(), at[:, 1].tolist())

    def forget(self, cells: Iterable[tuple[int, int]]) -> None:
        """Take back what was learnt, when the operator says so."""
        self._mark(cells, False)

    def set_prior(self, feet: Sequence[Point]) -> None:
        """Unknown ground is as high as the nearest foot stands (TITAN III took the height of P_u, H
        §10.3).
        """
        if _are_same(self._working.prior.feet, feet):
            return
        heights = [foot[2] for foot in feet]
        level = left_fold_sum(heights) / len(heights)
        uneven = max(heights) - min(heights) > LEVEL_REPLAN_THRESHOLD
        if uneven or not abs(level - self._level_given) <= LEVEL_REPLAN_THRESHOLD:
            self._level_given = math.nan if uneven else level
            self._working.prior = Prior(level, tuple(feet) if uneven else ())
        else:
            self._working.prior = Prior(self._working.prior.level)
            if holds(self._supposed, _around(feet, AROUND / 2, self.map)):
                return
        if not self.known.all():
            self._supposed = _around(feet, AROUND, self.map)
            self._supposed_anew = joined(self._supposed_anew, self._supposed)

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

    def work_on(self) -> None:
        """Bring one part of what has been seen into the map: the work of one tick."""
        self._working.work_on()

    def publish(self) -> TerrainMap:
        """The newest map; the same object as before when there is no news."""
        while self._working.work_on():
            pass
        return self.publish_worked()

    def publish_worked(self) -> TerrainMap:
        """The map with what feet have shown, and with what has been seen as far as it has been
        worked on.
        """
        for patch in self._patches:
            self._working.renew(patch)
        self._patches = []
        if self._supposed_anew is not None:
            reach = self._working.reach
            self._working.refill(grown(self._supposed_anew, reach, self.heights.shape))
            self._supposed_anew = None
        return self._working.publish()

    def move(self, sightings: Sightings, origin: XY, here: Window, there: Window) -> None:
        """Map another rectangle of the ground from now on, whose corner is at ``origin``: what lay
        ``here`` in the old one lies ``there`` in it. All that has been seen of it is given.
        """
        self.publish_worked()
        evidence, self._looks = sightings
        self.heights, self.known, self.learnt = evidence
        if self._supposed != whole(self.heights.shape):
            self._supposed = whole((0, 0))
        self._working.move(evidence, origin, here, there)

    @property
    def level(self) -> float:
        """Where ground far from the machine of which nothing is known is supposed to be, m."""
        return self._working.prior.level

    @property
    def sightings(self) -> Sightings:
        """All that has been seen and felt, to be kept; the arrays are changed in place."""
        return Sightings(Evidence(self.heights, self.known, self.learnt), self._looks)

    # bookkeeping

    def _write(
        self,
        rows: NDArray[np.intp],
        columns: NDArray[np.intp],
        heights: Array,
        looks: NDArray[np.uint8],
    ) -> NDArray[np.bool_]:
        """Which of these cells are news: unknown before, or of another height."""
        before = self._working.filled[rows, columns]
        was_known = self.known[rows, columns]
        same = (np.abs(heights - before) <= REPLAN_THRESHOLD) | (
            np.isnan(heights) & np.isnan(before)
        )
        self.heights[rows, columns] = heights
        self.known[rows, columns] = True
        self._looks[rows, columns] = looks
        return np.asarray(~(was_known & same))

    def _mark(self, cells: Iterable[tuple[int, int]], learnt: bool) -> None:
        changed = []
        for row, column in cells:
            self.map.need_cell(row, column)
            if self.learnt[row, column] != learnt:
                self.learnt[row, column] = learnt
                changed.append((row, column))
        self._patch([row for row, _ in changed], [column for _, column in changed])

    def _patch(self, rows: list[int], columns: list[int]) -> None:
        """These few cells, side by side, have changed."""
        if rows:
            changed = slice(min(rows), max(rows) + 1), slice(min(columns), max(columns) + 1)
            self._patches.append(grown(changed, self._working.reach, self.heights.shape))
            self._supposed_anew = joined(self._supposed_anew, changed)


def _are_same(one: Sequence[Point], other: Sequence[Point]) -> bool:
    return len(one) == len(other) and all(
        math.dist(a, b) <= SAME for a, b in zip(one, other, strict=True)
    )


def _around(feet: Sequence[Point], far: float, terrain: TerrainMap) -> Window:
    """The cells of a map as far as that from feet, m."""
    xs = [foot[0] for foot in feet]
    ys = [foot[1] for foot in feet]
    return terrain.window(min(xs) - far, max(xs) + far, min(ys) - far, max(ys) + far)
