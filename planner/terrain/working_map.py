"""The walker's map as it is being worked out from what is known, one rectangle after the other.

A look changes cells everywhere in view. They are not looked at all at once: the map is divided into
blocks, those near a change are *stale*, and whoever has a tick to keep renews them one by one. What
is published is the map as far as it has been renewed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import XY
from ..robot.model import Machine
from ..types import Array, Point
from .grid import Window, grown, renew_crests, within
from .map import TerrainMap, with_crests
from .traversability import RISE_WINDOW, Kind, kinds_within

# cells along the side of a block. More: see ticks come late; less: see ground far away come late
BLOCK = 40


class Evidence(NamedTuple):
    """What is known of every cell, (ny, nx); whoever gathers it changes the arrays in place."""

    heights: Array  # m, NaN: unknown, or known to be a hole
    known: NDArray[np.bool_]
    learnt: NDArray[np.bool_]  # prohibited by experience: stays so whatever the eye says

    @classmethod
    def none(cls, shape: tuple[int, int]) -> Evidence:
        """Nothing is known of a map of this shape."""
        nowhere = np.zeros(shape, dtype=bool)
        return cls(np.full(shape, math.nan), nowhere, nowhere.copy())


@dataclass(frozen=True)
class Prior:
    """Where unknown ground is supposed to be: at one ``level``, m, or as high as the nearest of
    these ``feet`` stands.
    """

    level: float
    feet: tuple[Point, ...] = ()

    def heights(self, window: Window, terrain: TerrainMap) -> Array | float:
        """Supposed heights of the cells in a window of a map, m."""
        if not self.feet:
            return self.level
        ox, oy = terrain.origin
        x = ox + (np.arange(window[1].start, window[1].stop) + 0.5) * terrain.cell
        y = oy + (np.arange(window[0].start, window[0].stop) + 0.5) * terrain.cell
        nearest = np.full((len(y), len(x)), np.inf)
        heights = np.zeros(nearest.shape)
        for foot_x, foot_y, foot_z in self.feet:
            far = np.add.outer((y - foot_y) ** 2, (x - foot_x) ** 2)
            heights[far < nearest] = foot_z
            np.minimum(nearest, far, out=nearest)
        return heights


class Layers:
    """The arrays of a map that is worked on, (ny, nx). What has been given away is copied before it
    is written to, one array at a time where there is time.
    """

    def __init__(self, blank: TerrainMap, known: NDArray[np.bool_]) -> None:
        self.filled = blank.heights.copy()  # m, what is supposed of unknown ground with it
        self.forbidden = blank.forbidden.copy()
        self.known = known.copy()
        self.crests = blank.crests.copy()  # m
        # lowest and highest ground of every row, m; inf and -inf where it has none
        self.low = np.fmin.reduce(self.filled, axis=1, initial=np.inf)
        self.high = np.fmax.reduce(self.filled, axis=1, initial=-np.inf)
        self._given: list[str] = []

    def take_over(self, old: Layers, here: Window, there: Window, reach: int) -> None:
        """What lies ``here`` in other layers comes ``there`` into these, which are level; a foot is
        ``reach`` cells wide to either side.
        """
        self.filled[there] = old.filled[here]
        self.forbidden[there] = old.forbidden[here]
        self.known[there] = old.known[here]
        self.crests[there] = old.crests[here]
        for line in _sides_of(there):
            renew_crests(self.crests, self.filled, line, reach)
        self.low = np.fmin.reduce(self.filled, axis=1, initial=np.inf)
        self.high = np.fmax.reduce(self.filled, axis=1, initial=-np.inf)

    def take_back_one(self) -> bool:
        """Copy one array that has been given away; False when there is none."""
        if not self._given:
            return False
        name = self._given.pop()
        setattr(self, name, getattr(self, name).copy())
        return True

    def take_back(self) -> None:
        """Copy all that has been given away: it may be written to."""
        while self.take_back_one():
            pass

    def given_to(self, terrain: TerrainMap) -> TerrainMap:
        """A map of these arrays, otherwise like ``terrain``."""
        self._given = ["filled", "forbidden", "known", "crests"]
        span = float(self.low.min()), float(self.high.max())
        return terrain.replaced(self.filled, self.forbidden, self.known, self.crests, span)

    def fill(self, window: Window, heights: Array, reach: int) -> None:
        """New heights in one rectangle, m; a foot is ``reach`` cells wide to either side."""
        self.filled[window] = heights
        renew_crests(self.crests, self.filled, window, reach)
        rows = self.filled[window[0]]
        self.low[window[0]] = np.fmin.reduce(rows, axis=1, initial=np.inf)
        self.high[window[0]] = np.fmax.reduce(rows, axis=1, initial=-np.inf)


class WorkingMap:
    """What follows from the ``evidence`` for one machine, brought up to date a part at a time.

    Unknown ground is forbidden where it is in the ``blank`` map; ``final``: only the cell under the
    foot tip counts. ``map`` is the last that was published.
    """

    def __init__(
        self, evidence: Evidence, blank: TerrainMap, machine: Machine, final: bool, prior: Prior
    ) -> None:
        self.evidence = evidence
        self.machine = machine
        self.final = final
        self.prior = prior
        self.map = blank
        self.closed = bool(blank.forbidden.any())
        self.layers = Layers(blank, evidence.known)
        # cells a change reaches: the square that counts as the ground around, or a foot's rim
        self.reach = math.ceil(max(RISE_WINDOW / 2, machine.foot_radius) / blank.cell) + 1
        self._side = max(BLOCK, self.reach)
        self._shape = blank.heights.shape
        self._stale = self._no_blocks()
        self._next = 0  # the block to look at next, row by row
        self._has_news = False

    def _no_blocks(self) -> NDArray[np.bool_]:
        """Of no block of the map it is true that it is stale."""
        rows, columns = (math.ceil(size / self._side) for size in self._shape)
        return np.zeros((rows, columns), dtype=bool)

    @property
    def filled(self) -> Array:
        """Heights as they have been worked out, m."""
        return self.layers.filled

    # one part after the other

    def mark(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> None:
        """What is known of these cells has changed: the blocks they reach into are stale."""
        last_row, last_column = self._shape[0] - 1, self._shape[1] - 1
        for row in (np.maximum(rows - self.reach, 0), np.minimum(rows + self.reach, last_row)):
            for column in (
                np.maximum(columns - self.reach, 0),
                np.minimum(columns + self.reach, last_column),
            ):
                self._stale[row // self._side, column // self._side] = True

    def work_on(self) -> bool:
        """One part of what there is to do: to copy an array that was given away, or to renew the
        next block that is stale. False when there is nothing.
        """
        if self.layers.take_back_one():
            return True
        stale = self._stale.ravel()
        waiting = stale.nonzero()[0]
        if not waiting.size:
            return False
        at = int(np.searchsorted(waiting, self._next)) % waiting.size
        number = int(waiting[at])
        stale[number] = False
        self._next = number + 1
        first_row, first_column = (self._side * n for n in divmod(number, self._stale.shape[1]))
        self.renew(
            (
                slice(first_row, min(first_row + self._side, self._shape[0])),
                slice(first_column, min(first_column + self._side, self._shape[1])),
            )
        )
        return True

    def move(self, evidence: Evidence, origin: XY, here: Window, there: Window) -> None:
        """Go on with another rectangle of the ground, of which nothing has been worked out but what
        lies ``here`` in the old one and ``there`` in it.
        """
        shape = evidence.known.shape
        level = np.full(shape, self.prior.level)
        nothing = np.zeros(shape, dtype=bool)
        closed = np.full(shape, self.closed)
        blank = replace(self.map, heights=level, forbidden=closed, known=nothing, origin=origin)
        blank = with_crests(blank, level)
        old, blocks = self.layers, np.argwhere(self._stale) * self._side
        self.evidence = evidence
        self.map = blank
        self.layers = Layers(blank, nothing)
        self.layers.take_over(old, here, there, math.ceil(self.machine.foot_radius / blank.cell))
        self._shape = shape
        self._stale = self._no_blocks()
        self._next = 0
        self._has_news = True
        # what was waiting, what was known before, and what was worked out at the edge
        blocks += [now.start - before.start for now, before in zip(there, here, strict=True)]
        for corner in ((0, 0), (0, self._side - 1), (self._side - 1, 0), (self._side - 1,) * 2):
            rows, columns = (blocks + corner).T
            on = (rows >= 0) & (rows < self._shape[0]) & (columns >= 0) & (columns < self._shape[1])
            self._stale[rows[on] // self._side, columns[on] // self._side] = True
        fresh = evidence.known.copy()
        fresh[_shrunk(there, self.reach)] = False
        self.mark(*np.nonzero(fresh))

    def renew(self, window: Window) -> None:
        """Work out the cells of one rectangle anew: what they are, and how high."""
        evidence = self.evidence
        known = evidence.known[window]
        found = kinds_within(
            window, evidence.heights, evidence.known, self.map.cell, self.machine, self.final
        )
        forbidden = (found != Kind.O) | evidence.learnt[window]
        if self.closed:
            forbidden |= ~known
        self.layers.take_back()
        self.layers.forbidden[window] = forbidden
        self.layers.known[window] = known
        self.refill(window)

    def refill(self, window: Window) -> None:
        """Only how high the ground of one rectangle is known or supposed to be."""
        self.layers.take_back()
        foot = math.ceil(self.machine.foot_radius / self.map.cell)
        self.layers.fill(window, self._heights_in(window), foot)
        self._has_news = True

    def _heights_in(self, window: Window) -> Array:
        """Heights with the gaps filled: by the known ground around, else as supposed."""
        evidence = self.evidence
        if evidence.known[window].all():
            return evidence.heights[window]
        outer = grown(window, 2, self._shape)
        inner = within(window, outer)
        heights = evidence.heights[outer]
        solid = evidence.known[outer] & ~np.isnan(heights)
        supposed = self.prior.heights(window, self.map)
        if solid.any():
            ground = np.where(solid, (heights, np.ones_like(heights)), 0.0)
            total, count = _sums_around(ground)[:, *inner]
            supposed = np.where(count > 0.0, total / np.maximum(count, 1.0), supposed)
        return np.asarray(np.where(evidence.known[window], evidence.heights[window], supposed))

    # what goes out

    def publish(self) -> TerrainMap:
        """The map as far as it has been worked out; the same object as before without news."""
        if self._has_news:
            self._has_news = False
            self.map = self.layers.given_to(self.map)
        return self.map


def _sides_of(window: Window) -> list[Window]:
    """The outermost rows and columns of a rectangle; none of an empty one."""
    rows, columns = window
    if rows.start >= rows.stop or columns.start >= columns.stop:
        return []
    return [
        (slice(rows.start, rows.start + 1), columns),
        (slice(rows.stop - 1, rows.stop), columns),
        (rows, slice(columns.start, columns.start + 1)),
        (rows, slice(columns.stop - 1, columns.stop)),
    ]


def _shrunk(window: Window, by: int) -> Window:
    """The rectangle with ``by`` cells fewer on every side; none where it is no larger."""
    rows, columns = (slice(s.start + by, max(s.start + by, s.stop - by)) for s in window)
    return rows, columns


def _sums_around(values: Array) -> Array:
    """Each cell with its two neighbours on either side, along rows and columns, the last two
    axes.
    """
    down = values.copy()
    for shift in (1, 2):
        down[:, shift:] += values[:, :-shift]
        down[:, :-shift] += values[:, shift:]
    across = down.copy()
    for shift in (1, 2):
        across[:, :, shift:] += down[:, :, :-shift]
        across[:, :, :-shift] += down[:, :, shift:]
    return across
