"""What stands too tall on the way of a trace walk (K's third truncation, "non-touching the
surface"). On most ground nothing does, and this costs nothing.
"""

from __future__ import annotations

import math
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import directions
from ..motion.swing import CLEARANCE
from ..robot.model import Machine
from ..terrain.grid import Window, joined
from ..terrain.map import TerrainMap
from ..types import Array
from .footholds import Foothold, within_reach
from .lane import Lane
from .samples import SampleGrid, bits_of, first_bit

# samples whose room over the ground is looked at together; more refuses ground beside tall things
STRIDE = 4


class Clearance:
    """Where feet in the air have room, and where the torso has."""

    def __init__(
        self, lane: Lane, samples: SampleGrid, terrain: TerrainMap, machine: Machine
    ) -> None:
        self.lane = lane
        self.samples = samples
        self.terrain = terrain
        self.machine = machine
        self.has_tall = False  # something here is too tall for a foot to be lifted over
        self.torso_room = samples.all  # samples at which the torso touches no ground
        self.torso_grazes = False  # there are others
        self._crossed: dict[tuple[int, int], bool] = {}
        self._room: dict[int, int] = {}
        if not terrain.is_level:
            self._look_for_tall_things()

    def _look_for_tall_things(self) -> None:
        machine = self.machine
        low = float(self.lane.z.min())
        room = min(self._ceiling(leg) for leg in range(len(machine.legs)))
        under = -machine.torso[2] / 2
        if self.terrain.highest <= low + min(room, under):
            return
        heights = self.terrain.heights[within_reach(self.lane, self.terrain, machine)]
        highest = float(np.where(np.isnan(heights), -np.inf, heights).max(initial=-np.inf))
        self.has_tall = highest > low + room
        if highest > low + under:
            self.torso_room = self.samples.pack(torso_clear(self.lane, self.terrain, machine))
            self.torso_grazes = self.torso_room != self.samples.all

    def _ceiling(self, leg: int) -> float:
        """Height over the centre of gravity of the tallest ground a leg can carry its foot over."""
        return self.machine.legs[leg].z[1] + self.machine.overreach[2] - CLEARANCE

    def crosses(self, f: int, g: int, holds: tuple[Foothold, Foothold], either: int) -> bool:
        """True when a foot can be carried over the ground between footholds number f and g, as low
        as the body may be on the way; ``either`` are the samples at which one of them is in reach.
        """
        able = self._crossed.get((f, g))
        if able is None:
            a, b = holds
            on_trace = either & self.samples.row_mask
            z = self.lane.z
            if on_trace:
                z = z[first_bit(on_trace) : on_trace.bit_length()]
            crest = self.terrain.crest_between(a.x, a.y, b.x, b.y)
            able = crest <= float(z.min()) + self._ceiling(a.leg)
            self._crossed[f, g] = self._crossed[g, f] = able
        return able

    def room(self, leg: int) -> int:
        """Samples at which a foot in the air may be anywhere over its leg's rectangle: nothing
        there is too tall for it.
        """
        mask = self._room.get(leg)
        if mask is None:
            mask = self._room[leg] = self._room_over_rectangle(leg)
        return mask

    def leads_to(self, sample: int) -> int:
        """The last sample of the trace that the torso gets to from this one and touches nothing."""
        room = self.torso_room | 1 << sample
        return self.samples.farthest(self.samples.unbroken(room, sample))

    def accept(self, legs: list[int], sample: int) -> None:
        """Take the machine as it is: its torso and these legs in the air have room at a sample."""
        self.torso_room |= 1 << sample
        if self.has_tall:
            for leg in legs:
                self._room[leg] = self.room(leg) | 1 << sample

    def _room_over_rectangle(self, leg: int) -> int:
        lane = self.lane
        rectangle = self.machine.legs[leg]
        aside = float(np.hypot(lane.x - lane.x[0], lane.y - lane.y[0]).max())
        aside += self.machine.foot_radius
        x, y = lane.x[0], lane.y[0]
        c, d = directions(lane.yaw)
        px = np.array([x + c * bx - d * by for bx in rectangle.x for by in rectangle.y])
        py = np.array([y + d * bx + c * by for bx in rectangle.x for by in rectangle.y])
        parts = np.arange(0, self.samples.count, STRIDE)
        low, high = (
            [bound.reduceat(bound.reduce(p, axis=0), parts).tolist() for p in (px, py)]
            for bound in (np.minimum, np.maximum)
        )
        windows = [
            self.terrain.window(x0 - aside, x1 + aside, y0 - aside, y1 + aside)
            for x0, x1, y0, y1 in zip(low[0], high[0], low[1], high[1], strict=True)
        ]
        limits = np.minimum.reduceat(lane.z, parts) + self._ceiling(leg)
        free = ~self._has_above(windows, limits)
        return self.samples.in_all_rows(bits_of(np.repeat(free, STRIDE)[: self.samples.count]))

    def _has_above(self, windows: list[Window], limits: Array) -> NDArray[np.bool_]:
        """Which of some windows of the map have ground above their limit, m."""
        around = reduce(joined, windows)
        heights = self.terrain.heights[around]
        rows, columns = np.nonzero(heights > limits.min())
        heights = heights[rows, columns]
        rows += around[0].start
        columns += around[1].start
        first_row, end_row, first_column, end_column = (
            np.array(bounds)[:, None]
            for bounds in zip(
                *((r.start, r.stop, c.start, c.stop) for r, c in windows), strict=True
            )
        )
        inside = (rows >= first_row) & (rows < end_row)
        inside &= (columns >= first_column) & (columns < end_column)
        return np.asarray((inside & (heights > limits[:, None])).any(axis=1))


def torso_clear(lane: Lane, terrain: TerrainMap, machine: Machine) -> NDArray[np.bool_]:
    """(rows, samples): where the torso's box touches no ground."""
    length, width, height = machine.torso
    # a crest tells of all the cells this near
    apart = (2 * math.ceil(terrain.foot_radius / terrain.cell) + 1) * terrain.cell
    crests = np.asarray(terrain.crest_view).reshape(terrain.rows, terrain.columns)
    c, d = directions(lane.yaw)
    low = lane.z - height / 2
    clear = np.ones(lane.x.shape, dtype=bool)
    for bx in np.linspace(-length / 2, length / 2, math.ceil(length / apart) + 1):
        for by in np.linspace(-width / 2, width / 2, math.ceil(width / apart) + 1):
            x = lane.x + c * bx - d * by
            y = lane.y + d * bx + c * by
            columns = np.floor((x - terrain.origin[0]) / terrain.cell).astype(np.intp)
            rows = np.floor((y - terrain.origin[1]) / terrain.cell).astype(np.intp)
            inside = (rows >= 0) & (rows < terrain.rows)
            inside &= (columns >= 0) & (columns < terrain.columns)
            top = crests[rows.clip(0, terrain.rows - 1), columns.clip(0, terrain.columns - 1)]
            clear &= ~inside | (top <= low)
    return clear
