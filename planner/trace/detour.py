"""K requirement 2, the selection of the trace from what the eye sees: where what lies across the
trace cannot be walked, the trace itself bends round it and comes back.

The trace keeps its samples and its yaw; every sample is moved sideways by an offset. Offsets are
chosen at layers along the trace by dynamic programming, slope and change of slope bounded, and
rounded by a cubic spline, so that the course stays smooth. What a place costs is read off the map:
the torso must clear it; legs without a foothold in reach, and tall ground in their reach, cost.
That is necessary, not sufficient: the search for states along the bent trace decides, and where
that stops, the place is shunned and another bend is tried. All of it is bounded by count.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.paths import SampledPath
from ..geometry.transforms import directions
from ..protocols import Weight
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Array, Gait, Stance
from .clearance import torso_clear
from .lane import Lane, across, body_heights

DETOUR = 1.25  # body lengths the trace may bend aside where nothing else is said
LAYER = 0.25  # m of s between two layers
PLACE = 0.1  # m between two places of a layer; also the finest slope: 0.1 in 0.25
SLOPE = 4  # places a way may shift from layer to layer: 59 degrees
TURN = 1  # places by which its shift may change: radii of 0.6 m and more
AHEAD = 4.0  # body lengths it looks for a way to come back in
BARE = 2.0  # m a metre costs for every leg that has no foothold within its rectangle
TALL = 0.5  # the same for every leg that has something tall there
OFF = 0.3  # m a metre costs a metre off the trace
BEND = 0.1  # m a change of slope costs
NOT_BACK = 2.0  # m a metre off the trace costs at the end of what is looked at
SAVED = 0.25  # m that a bend must be cheaper than the trace as it is
ROW_WEIGHT = 40  # of the ground beside at one offset, in postures looked at
SWAY = 0.1  # m; a body that sways may be as far beside its trace
SAME = 1e-3  # m; an offset as small is none
SHUNNED = 0.3  # m about where a search came to its end that the next bend keeps out of
LOOKED_MAX = 12  # points a side of a leg's rectangle that are looked at


class BentTrace(NamedTuple):
    """A trace that bends round something: the path that is walked, and its offset to the left of
    the trace that was given, m, at every sample.
    """

    path: SampledPath
    offsets: Array

    @property
    def aside(self) -> float:
        """The greatest offset, m; negative to the right."""
        return float(self.offsets[int(np.abs(self.offsets).argmax())])

    @property
    def extent(self) -> tuple[float, float]:
        """s at which it leaves the trace first, and at which it is back for good, m."""
        off = np.flatnonzero(np.abs(self.offsets) > SAME)
        if not len(off):
            return 0.0, 0.0
        return float(off[0]) * self.path.step, float(off[-1]) * self.path.step

    def offset_at(self, s: float) -> float:
        """The offset after s, m."""
        sample = min(max(round(s / self.path.step), 0), self.path.last)
        return float(self.offsets[sample])


class DeadEnd(NamedTuple):
    """Where a search along a bent trace came to its end."""

    s: float  # m
    offset: float


class GroundBeside:
    """What the map says of the places beside a window of the trace: layers along it, half layers
    between them, and offsets across.
    """

    def __init__(
        self,
        trace: SampledPath,
        now: int,
        width: float,
        terrain: TerrainMap,
        machine: Machine,
        gait: Gait,
    ) -> None:
        self.trace = trace
        self.now = now
        self.width = width
        self.step = max(2, 2 * round(LAYER / trace.step / 2))  # samples from layer to layer
        ahead = round(AHEAD * machine.torso[0] / trace.step)
        last = min(now + ahead, trace.last)
        self.layers = np.arange(now, last + 1, self.step)
        half = np.arange(now, int(self.layers[-1]) + 1, self.step // 2)
        self.places = math.floor(width / PLACE + 1e-9)  # to either side
        offsets = np.arange(-2 * self.places, 2 * self.places + 1) * (PLACE / 2)
        across_x, across_y, _ = across(trace.x, trace.y, trace.yaw)
        x = trace.x[half] + offsets[:, None] * across_x[half]
        y = trace.y[half] + offsets[:, None] * across_y[half]
        self._lane = Lane(x, y, trace.yaw[half], np.zeros(0))
        self._ground = terrain, machine, gait
        self._is_looked_at = False
        self._usual: float | None = None
        self.s = half * trace.step
        self.offsets = offsets
        self.cost = 1.0 + OFF * np.abs(offsets)[:, None] + np.zeros_like(x)

    def looking(self) -> Generator[Weight, None, None]:
        """Look at the ground, an offset after the other; pauses after each."""
        if self._is_looked_at:
            return
        self._is_looked_at = True
        terrain, machine, gait = self._ground
        for row, (x, y) in enumerate(zip(self._lane.x, self._lane.y, strict=True)):
            z = body_heights(x, y, terrain, machine, gait)
            lane = Lane(x[None, :], y[None, :], self._lane.yaw, z)
            if not terrain.is_level:
                self.cost[row, ~torso_clear(lane, terrain, machine)[0]] = math.inf
            self.cost[row] += _of_the_legs(lane, terrain, machine)
            yield ROW_WEIGHT

    def may_bar_the_torso(self, stance: Stance) -> bool:
        """True where something on the map is as tall as the underside of the torso is now."""
        terrain, machine, _ = self._ground
        return terrain.highest > stance.body[2] - machine.torso[2] / 2

    def bars_the_torso(self, bend: BentTrace | None, ahead: float) -> bool:
        """True when within so many metres the torso meets something at every place as near to the
        trace, as it is bent now, as a body may sway.
        """
        near = (self.s - self.s[0]) <= ahead
        samples = np.round(self.s[near] / self.trace.step).astype(np.intp)
        offsets = np.zeros(len(samples)) if bend is None else bend.offsets[samples]
        beside = np.abs(self.offsets[:, None] - offsets) <= SWAY
        free = (np.isfinite(self.cost[:, near]) & beside).any(axis=0)
        return not bool(free.all())

    def shun(self, stop: DeadEnd) -> None:
        """Keep out of the places about where a search came to its end."""
        along = np.abs(self.s - stop.s)[None, :]
        aside = np.abs(self.offsets - stop.offset)[:, None]
        self.cost[np.maximum(along, aside) <= SHUNNED] = math.inf

    def usual(self, offsets: Array) -> float:
        """What the trace costs as it is, with these offsets at its samples; of ground that nothing
        has been kept out of yet.
        """
        if self._usual is None:
            self._usual = self.cost_of(offsets[self.layers])
        return self._usual

    def cost_of(self, way: Array) -> float:
        """What it costs to be so far beside the trace at the first layer and at those after it, but
        for bends; inf where the torso meets something.
        """
        total = NOT_BACK * abs(float(way[-1]))
        for layer, (here, to) in enumerate(pairwise(way.tolist())):
            middle = self.cost[self._row((here + to) / 2.0), 2 * layer + 1]
            total += LAYER * float(middle + self.cost[self._row(to), 2 * layer + 2]) / 2.0
        return total

    def _row(self, offset: float) -> int:
        row = round(2.0 * offset / PLACE) + 2 * self.places
        return min(max(row, 0), len(self.offsets) - 1)

    def best(self, offset: float, shift: int) -> list[float] | None:
        """The cheapest offsets at the layers after the first. There the body is ``offset`` beside
        the trace, and has shifted so many places from the layer before. None where no way leads
        through.
        """
        shifts = range(-SLOPE, SLOPE + 1)
        count = 2 * self.places + 1
        at = np.arange(count) - self.places
        last = len(self.layers) - 1
        cost = np.repeat((NOT_BACK * PLACE * np.abs(at))[:, None], len(shifts), axis=1)
        cost[:, np.abs(np.asarray(shifts)) > TURN] = math.inf  # it goes straight on from there
        choices = []
        for layer in range(last - 1, -1, -1):
            onward = self._onward(layer, at, cost)
            choice = np.empty((count, len(shifts)), dtype=np.intp)
            best = np.empty((count, len(shifts)))
            for before in range(len(shifts)):
                changes = np.abs(np.arange(len(shifts)) - before)
                total = onward + np.where(changes <= TURN, BEND * changes, math.inf)
                choice[:, before] = total.argmin(axis=1)
                best[:, before] = total.min(axis=1)
            choices.append(choice)
            cost = best
        place = min(max(round(offset / PLACE), -self.places), self.places) + self.places
        direction = min(max(shift, -SLOPE), SLOPE) + SLOPE
        if not math.isfinite(cost[place, direction]):
            return None
        way = []
        for choice in reversed(choices):
            direction = int(choice[place, direction])
            place += direction - SLOPE
            way.append((place - self.places) * PLACE)
        return way

    def _onward(self, layer: int, at: NDArray[np.intp], cost: Array) -> Array:
        """(places, shifts): what it costs from a layer on, by the shift to the next one."""
        count = len(at)
        onward = np.full((count, 2 * SLOPE + 1), math.inf)
        middle = self.cost[:, 2 * layer + 1]
        end = self.cost[:, 2 * layer + 2]
        for k, shift in enumerate(range(-SLOPE, SLOPE + 1)):
            to = np.arange(count) + shift
            inside = (to >= 0) & (to < count)
            here = np.arange(count)[inside]
            to = to[inside]
            side = LAYER * (middle[here + to] + end[2 * to]) / 2
            onward[here, k] = side + cost[to, k]
        return onward


def _of_the_legs(lane: Lane, terrain: TerrainMap, machine: Machine) -> Array:
    """What the legs' ground costs at every sample of a lane of one row."""
    cost = np.zeros(lane.x.shape[1])
    c, s = directions(lane.yaw)
    for leg in machine.legs:
        looked = (
            np.linspace(low, high, min(math.ceil((high - low) / terrain.cell) + 1, LOOKED_MAX))
            for low, high in (leg.x, leg.y)
        )
        bx, by = (grid.ravel()[:, None] for grid in np.meshgrid(*looked))
        x = lane.x[0] + c * bx - s * by
        y = lane.y[0] + s * bx + c * by
        columns = np.floor((x - terrain.origin[0]) / terrain.cell).astype(np.intp)
        rows = np.floor((y - terrain.origin[1]) / terrain.cell).astype(np.intp)
        inside = (rows >= 0) & (rows < terrain.rows)
        inside &= (columns >= 0) & (columns < terrain.columns)
        rows = rows.clip(0, terrain.rows - 1)
        columns = columns.clip(0, terrain.columns - 1)
        tall = inside & (terrain.heights[rows, columns] > lane.z + leg.z[1] + machine.overreach[2])
        open_ground = inside & ~terrain.forbidden[rows, columns] & ~tall
        cost += BARE * ~open_ground.any(axis=0) + TALL * tall.any(axis=0)
    return cost


def bent(before: BentTrace | None, ground: GroundBeside) -> BentTrace | None:
    """The trace bent by the cheapest offsets over the ground beside it, joined to how it was bent
    before; None where no way leads through, or none that is better than the trace as it is.
    """
    trace = ground.trace
    now = ground.now
    offsets = np.zeros(trace.last + 1) if before is None else before.offsets
    step = ground.step
    here = float(offsets[now])
    came = here - float(offsets[max(now - step, 0)])
    way = ground.best(here, round(came / PLACE))
    if way is None or ground.cost_of(np.array([here, *way])) > ground.usual(offsets) - SAVED:
        return None
    # before its beginning the trace goes straight on
    behind = [float(offsets[max(now - k * step, 0)]) for k in (2, 1)]
    end = way[-1] if way else here
    rest = np.linspace(end, 0.0, 2 + round(abs(end) / PLACE))
    corners = np.array([*behind, here, *way, *rest[1:], *np.zeros(3)])
    ahead = np.zeros(trace.last - now)
    count = min(len(ahead), (len(corners) - 4) * step)
    ahead[:count] = _rounded(corners, 2.0 + np.arange(1, count + 1) / step)
    # the cubic passes the corners by a little; where the body is now it does not
    missing = here - float(_rounded(corners, np.array([2.0]))[0])
    join = min(count, 2 * step)
    part = np.arange(1, join + 1) / max(join, 1)
    ahead[:join] += missing * (1.0 - part * part * (3.0 - 2.0 * part))
    whole = np.concatenate([offsets[: now + 1], ahead])
    across_x, across_y, _ = across(trace.x, trace.y, trace.yaw)
    path = SampledPath(
        trace.step, trace.x + whole * across_x, trace.y + whole * across_y, trace.yaw.copy()
    )
    return BentTrace(path, whole)


def _rounded(corners: Array, at: Array) -> Array:
    """The uniform cubic B-spline over corners at places counted in them: it bends nowhere more than
    the corners do.
    """
    k = np.floor(at).astype(np.intp)
    t = at - k
    weights = (
        (1.0 - t) ** 3,
        3.0 * t**3 - 6.0 * t**2 + 4.0,
        -3.0 * t**3 + 3.0 * t**2 + 3.0 * t + 1.0,
        t**3,
    )
    last = len(corners) - 1
    parts = [w * corners[np.clip(k + n - 1, 0, last)] for n, w in enumerate(weights)]
    return np.asarray((parts[0] + parts[1] + parts[2] + parts[3]) / 6.0)
