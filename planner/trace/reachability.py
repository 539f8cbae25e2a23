"""Footholds and their existence segments (K "calculation of footholds"), on a window of a sampled
course.

A foothold of a leg exists on the samples over which it stays inside the leg's reach box in one go.
A set of standing feet exists where all its footholds do and the centre of gravity is at least the
margin inside their polygon. Both are kept as integers with one bit a sample (bit 0 = first sample
of the window): intersections, first and last samples are then single operations on integers, and a
whole search costs a few milliseconds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.paths import EDGE, Box
from ..motion.swing import CLEARANCE
from ..robot.model import Machine
from ..stability import MARGIN_SLACK
from ..terrain.map import TerrainMap
from ..types import Array, Point

MARGIN = 0.01  # m, least stability margin planned for
CHUNK = 64  # samples looked at together: wider wastes work on footholds far away
DENSE = 16  # footholds a leg's rectangle may hold before the ground is thinned out
# samples whose room over the ground is looked at together; more refuses ground beside tall things
STRIDE = 4
AIR = -1  # in a tuple of feet: this leg is in the air

Feet = tuple[int, ...]  # a foothold's number for every leg, AIR where there is none


class Foothold(NamedTuple):
    """A point a leg can stand on. ``last`` is K's S2 on the trace itself: the last sample of the
    window in reach.
    """

    leg: int
    x: float
    y: float
    z: float
    last: int


class Lane(NamedTuple):
    """The body's poses over the window: row r is the trace moved sideways by offset r; row 0 is the
    trace itself.
    """

    x: Array  # (rows, count)
    y: Array
    yaw: Array  # (count,), the same in every row
    z: Array  # (count,), height of the centre of gravity


class Field:
    """All footholds within reach of a lane, and which sets of them carry the machine where.

    Sample ``k`` of row ``r`` is bit ``r * width + k``; the bit after each row stays empty, so runs
    never cross rows.
    """

    def __init__(
        self,
        lane: Lane,
        terrain: TerrainMap,
        machine: Machine,
        *,
        thin: int = 1,
        margin: float = MARGIN,
    ) -> None:
        self.lane, self.terrain, self.machine, self.margin = lane, terrain, machine, margin
        self.rows, self.count = lane.x.shape
        self.width = self.count + 1
        self.turns = bool(np.ptp(lane.yaw) > 1e-9)
        self.everywhere: int = sum(
            ((1 << self.count) - 1) << (r * self.width) for r in range(self.rows)
        )
        self.holds: list[Foothold] = []
        self.reach: list[int] = []  # existence segments as bits
        self.by_leg: list[list[int]] = [[] for _ in machine.legs]
        pad = ((0, 0), (0, 1))
        self._x, self._y = np.pad(lane.x, pad).ravel(), np.pad(lane.y, pad).ravel()
        self._row = (1 << self.width) - 1
        self._edges: dict[tuple[int, int], int] = {}
        # edges the machine is nearer to than the margin where it stands now
        self._least: dict[tuple[int, int], float] = {}
        self._stable: dict[Feet, int] = {}
        self._valid: dict[Feet, int] = {}
        self._cells = allowed_cells(lane, terrain, machine, thin)
        self._crossed: dict[tuple[int, int], bool] = {}
        self._free: dict[int, int] = {}
        self._over_air: dict[Feet, int] = {}
        # something here is too tall for a foot to be lifted over; the torso would meet it
        self.tall, self.grazed = False, False
        if not terrain.is_level:
            self._look_for_tall_things()

    # finding footholds

    def find_all(self) -> Field:
        """Find every leg's footholds at once; a caller with a tick to keep calls ``find`` leg by
        leg.
        """
        for leg in range(len(self.machine.legs)):
            self.find(leg)
        return self

    def find(self, leg: int) -> None:
        """Find a leg's footholds and their existence segments."""
        px, py, pz = self._cells
        if not len(px):
            return
        exists = self._exists(px, py, pz, self.machine.legs[leg].box, self.machine.legs[leg].z)
        usable = np.nonzero(exists.any(axis=(1, 2)))[0]
        if not len(usable):
            return
        packed = np.packbits(
            np.pad(exists[usable], ((0, 0), (0, 0), (0, 1))).reshape(len(usable), -1),
            axis=1,
            bitorder="little",
        )
        for p, bits in zip(usable.tolist(), packed, strict=True):
            self._add(
                leg,
                (float(px[p]), float(py[p]), float(pz[p])),
                int.from_bytes(bits.tobytes(), "little"),
            )

    def _exists(
        self, px: Array, py: Array, pz: Array, box: Box, z: tuple[float, float]
    ) -> NDArray[np.bool_]:
        """(points, rows, samples): where each point is inside a leg's reach box."""
        exists = np.zeros((len(px), self.rows, self.count), dtype=bool)
        for begin in range(0, self.count, CHUNK):
            part = slice(begin, min(begin + CHUNK, self.count))
            near = self._near(px, py, box, part)
            if len(near):
                exists[near, :, part] = self._inside(px[near], py[near], box, part)
        if not self.terrain.is_level:
            depth = pz[:, None] - self.lane.z
            exists &= ((depth >= z[0] - EDGE) & (depth <= z[1] + EDGE))[:, None, :]
        return exists

    def _inside(self, px: Array, py: Array, box: Box, part: slice) -> NDArray[np.bool_]:
        yaw = self.lane.yaw[part]
        dx, dy = px[:, None, None] - self.lane.x[:, part], py[:, None, None] - self.lane.y[:, part]
        if self.turns or yaw[0] != 0.0:
            c, d = (
                (np.cos(yaw), np.sin(yaw)) if self.turns else (math.cos(yaw[0]), math.sin(yaw[0]))
            )
            dx, dy = c * dx + d * dy, c * dy - d * dx
        within = (
            (dx >= box[0] - EDGE)
            & (dx <= box[1] + EDGE)
            & (dy >= box[2] - EDGE)
            & (dy <= box[3] + EDGE)
        )
        return np.asarray(within)

    def _near(self, px: Array, py: Array, box: Box, part: slice) -> NDArray[np.int64]:
        """Points that some sample of the part could bring into the rectangle."""
        x, y = self.lane.x[:, part], self.lane.y[:, part]
        low_x, high_x, low_y, high_y = box
        if self.turns or self.lane.yaw[0] != 0.0:
            high_x = high_y = max(math.hypot(bx, by) for bx in box[:2] for by in box[2:])
            low_x = low_y = -high_x
        inside = (px >= x.min() + low_x - EDGE) & (px <= x.max() + high_x + EDGE)
        inside &= (py >= y.min() + low_y - EDGE) & (py <= y.max() + high_y + EDGE)
        return np.nonzero(inside)[0]

    def _add(self, leg: int, point: Point, mask: int) -> int:
        number = len(self.holds)
        on_trace = mask & self._row
        self.holds.append(Foothold(leg, *point, on_trace.bit_length() - 1))
        self.by_leg[leg].append(number)
        self.reach.append(mask)
        return number

    def stand(self, leg: int, foot: Point, sample: int) -> int:
        """The foothold a leg stands on now, as a numbered one; a foot out of reach can only stand
        where it is.
        """
        for number in self.by_leg[leg]:
            hold = self.holds[number]
            if (
                abs(hold.x - foot[0]) < 1e-9
                and abs(hold.y - foot[1]) < 1e-9
                and self.reach[number] >> sample & 1
            ):
                return number
        box, z = self._stretched(leg, foot, sample)
        x, y, height = (np.array([v]) for v in foot)
        exists = self._exists(x, y, height, box, z)
        mask = _bits(np.pad(exists[0], ((0, 0), (0, 1))).ravel())
        return self._add(leg, foot, mask | 1 << sample)

    def _stretched(self, leg: int, foot: Point, sample: int) -> tuple[Box, tuple[float, float]]:
        """A leg's reach box, stretched to where its foot is now: a foot out of reach may come
        nearer, never go farther out.
        """
        row, k = divmod(sample, self.width)
        yaw, description = float(self.lane.yaw[k]), self.machine.legs[leg]
        dx, dy, dz = (
            foot[0] - float(self.lane.x[row, k]),
            foot[1] - float(self.lane.y[row, k]),
            foot[2] - float(self.lane.z[k]),
        )
        bx, by = math.cos(yaw) * dx + math.sin(yaw) * dy, math.cos(yaw) * dy - math.sin(yaw) * dx
        (x0, x1), (y0, y1), (z0, z1) = description.x, description.y, description.z
        return (min(x0, bx), max(x1, bx), min(y0, by), max(y1, by)), (min(z0, dz), max(z1, dz))

    def accept(self, feet: Feet, sample: int) -> bool:
        """Take the machine as it stands: where it is less stable than the margin asks it may become
        more so, never less.

        (A stop in mid-step sets feet down wherever there is ground.) False when it does not stand
        at all.
        """
        corners = self._hull(feet)
        if len(corners) < 3:
            return False
        x, y = float(self._x[sample]), float(self._y[sample])
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            p, q = self.holds[a], self.holds[b]
            inside = ((q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x)) / math.hypot(
                q.x - p.x, q.y - p.y
            )
            if inside < -MARGIN_SLACK:
                return False
            if inside < self.margin:
                self._least[a, b] = inside
        self.everywhere |= 1 << sample
        if self.tall:
            for leg, f in enumerate(feet):
                if f < 0:
                    self._free[leg] = self.free(leg) | 1 << sample
        return bool(self.valid(feet) >> sample & 1)

    # what stands too tall (K's third truncation, "non-touching the surface"); on most ground
    # nothing does, and this costs nothing

    def _look_for_tall_things(self) -> None:
        machine, low = self.machine, float(self.lane.z.min())
        room = min(self._ceiling(leg) for leg in range(len(machine.legs)))
        under = -machine.torso[2] / 2
        if self.terrain.highest <= low + min(room, under):
            return
        r0, r1, c0, c1 = _patch(self.lane, self.terrain, machine)
        heights = self.terrain.heights[r0:r1, c0:c1]
        highest = float(np.where(np.isnan(heights), -np.inf, heights).max(initial=-np.inf))
        self.tall = highest > low + room
        if highest > low + under:
            clear = _bits(
                np.pad(_torso_clear(self.lane, self.terrain, machine), ((0, 0), (0, 1))).ravel()
            )
            self.grazed = clear != self.everywhere
            self.everywhere = clear

    def _ceiling(self, leg: int) -> float:
        """Height over the centre of gravity of the tallest ground a leg can carry its foot over."""
        return self.machine.legs[leg].z[1] + self.machine.overreach[2] - CLEARANCE

    def crosses(self, f: int, g: int) -> bool:
        """True when a foot can be carried over the ground between two footholds, as low as the body
        may be on the way.
        """
        able = self._crossed.get((f, g))
        if able is None:
            a, b = self.holds[f], self.holds[g]
            both = (self.reach[f] | self.reach[g]) & self._row
            z = self.lane.z[first_bit(both) : both.bit_length()] if both else self.lane.z
            able = self.terrain.crest_between(a.x, a.y, b.x, b.y) <= float(z.min()) + self._ceiling(
                a.leg
            )
            self._crossed[f, g] = self._crossed[g, f] = able
        return able

    def free(self, leg: int) -> int:
        """Samples at which a foot in the air may be anywhere over its leg's rectangle: nothing
        there is too tall for it.
        """
        mask = self._free.get(leg)
        if mask is None:
            mask = self._free[leg] = self._freedom(leg)
        return mask

    def _freedom(self, leg: int) -> int:
        lane, description = self.lane, self.machine.legs[leg]
        aside = (
            float(np.hypot(lane.x - lane.x[0], lane.y - lane.y[0]).max()) + self.machine.foot_radius
        )
        flags = np.zeros(self.count, dtype=bool)
        for begin in range(0, self.count, STRIDE):
            part = slice(begin, begin + STRIDE)
            x, y, c, d = (
                lane.x[0, part],
                lane.y[0, part],
                np.cos(lane.yaw[part]),
                np.sin(lane.yaw[part]),
            )
            px = [x + c * bx - d * by for bx in description.x for by in description.y]
            py = [y + d * bx + c * by for bx in description.x for by in description.y]
            top = self.terrain.crest_in(
                float(np.min(px)) - aside,
                float(np.max(px)) + aside,
                float(np.min(py)) - aside,
                float(np.max(py)) + aside,
            )
            flags[part] = top <= float(lane.z[part].min()) + self._ceiling(leg)
        row = _bits(flags)
        return sum(row << (r * self.width) for r in range(self.rows))

    # which sets of feet carry where

    def stable(self, feet: Feet) -> int:
        """Samples at which the centre of gravity is the margin inside the polygon of the standing
        feet.
        """
        mask = self._stable.get(feet)
        if mask is None:
            mask = self._stable[feet] = self._stability(feet)
        return mask

    def _stability(self, feet: Feet) -> int:
        mask = self.everywhere
        edges = self._edges
        corners = self._hull(feet)
        if len(corners) < 3:
            return 0
        a = corners[-1]
        for b in corners:
            edge = edges.get((a, b))
            if edge is None:
                edge = edges[a, b] = self._edge(a, b)
            mask &= edge
            if not mask:
                return 0
            a = b
        return mask

    def _hull(self, feet: Feet) -> list[int]:
        """Footholds at the corners of the polygon of the standing feet, counter-clockwise."""
        holds = self.holds
        corners = sorted([(holds[f].x, holds[f].y, f) for f in feet if f >= 0])
        if len(corners) < 3:
            return []
        hull: list[int] = []
        for side in (corners, corners[::-1]):
            chain: list[tuple[float, float, int]] = []
            for corner in side:
                x, y = corner[0], corner[1]
                while len(chain) > 1:
                    ax, ay, _ = chain[-2]
                    bx, by, _ = chain[-1]
                    if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
                        break
                    chain.pop()
                chain.append(corner)
            hull += [corner[2] for corner in chain[:-1]]
        return hull

    def _edge(self, a: int, b: int) -> int:
        """Samples at which the centre of gravity is the margin to the left of the line from
        foothold a to b.
        """
        p, q = self.holds[a], self.holds[b]
        ex, ey = q.x - p.x, q.y - p.y
        length = math.sqrt(ex * ex + ey * ey)
        if length < EDGE:
            return 0
        distance = (ex / length) * self._y
        distance -= (ey / length) * self._x
        least = self._least.get((a, b), self.margin)
        return _bits(distance >= least - EDGE + (ex * p.y - ey * p.x) / length)

    def valid(self, feet: Feet) -> int:
        """Existence segments of a state: where its feet carry, and its legs in the air have room to
        wait.
        """
        if not self.tall or AIR not in feet:
            return self.carries(feet)
        mask = self._over_air.get(feet)
        if mask is None:
            mask = self.carries(feet)
            for leg, f in enumerate(feet):
                if f < 0:
                    mask &= self.free(leg)
            self._over_air[feet] = mask
        return mask

    def carries(self, feet: Feet) -> int:
        """Samples at which every standing foot is in reach and the machine is stable."""
        mask = self._valid.get(feet)
        if mask is None:
            mask = self.stable(feet)
            if mask:
                reach = self.reach
                for f in feet:
                    if f >= 0:
                        mask &= reach[f]
            self._valid[feet] = mask
        return mask

    def between(self, feet: Feet, after: Feet) -> int:
        """Samples the body may pass while the feet that differ are in the air; none when one cannot
        be carried across.
        """
        rest = tuple(f if f == g else AIR for f, g in zip(feet, after, strict=True))
        mask = self.carries(rest)
        if self.tall:
            for leg, (f, g) in enumerate(zip(feet, after, strict=True)):
                if f < 0 or g < 0:
                    mask &= self.free(leg)
                elif f != g and not self.crosses(f, g):
                    return 0
        return mask

    # places: unbroken parts of a mask

    def place(self, mask: int, sample: int) -> int:
        """The unbroken part of ``mask`` that contains ``sample``: runs along rows, joined where two
        rows have a sample in common.

        (The body may go straight from one row to another at the same sample: what is valid at both
        ends is so between.)
        """
        run = span(run_start(mask, sample), run_end(mask, sample))
        if self.rows == 1:
            return run
        found, fresh = run, run
        while fresh:
            beside = 0
            for shift in range(self.width, self.rows * self.width, self.width):
                beside |= fresh << shift | fresh >> shift
            beside &= mask & ~found
            fresh = 0
            while beside:
                at = first_bit(beside)
                run = span(run_start(mask, at), run_end(mask, at))
                fresh |= run
                beside &= ~run
            found |= fresh
        return found

    def farthest(self, place: int) -> int:
        """The last sample of the trace a place reaches, in any row."""
        if self.rows == 1:
            return place.bit_length() - 1
        most = -1
        while place:
            most = max(most, (place & self._row).bit_length() - 1)
            place >>= self.width
        return most

    def nearest(self, place: int, sample: int) -> int:
        """Where in a place to be, coming from ``sample``: onward rather than back, near rather than
        far, near the trace.
        """
        if self.rows == 1:
            ahead = place >> sample
            return sample + first_bit(ahead) if ahead else place.bit_length() - 1
        k = sample % self.width
        best, least = -1, math.inf
        for r in range(self.rows):
            row = place >> (r * self.width) & self._row
            if row:
                ahead = row >> k
                at = k + first_bit(ahead) if ahead else row.bit_length() - 1
                cost = (at - k if at >= k else 10 * (k - at)) + 5 * ((r + 1) // 2)
                if cost < least:
                    best, least = r * self.width + at, cost
        return best


def _bits(flags: NDArray[np.bool_]) -> int:
    return int.from_bytes(np.packbits(flags, bitorder="little").tobytes(), "little")


def first_bit(mask: int) -> int:
    """Lowest sample in a non-empty mask."""
    return (mask & -mask).bit_length() - 1


def run_end(mask: int, sample: int) -> int:
    """Last sample of the unbroken run of ``mask`` that contains ``sample``."""
    rest = ~(mask >> sample)
    return sample + (rest & -rest).bit_length() - 2


def run_start(mask: int, sample: int) -> int:
    """First sample of the unbroken run of ``mask`` that contains ``sample``."""
    gaps = ~mask & ((1 << sample) - 1)
    return gaps.bit_length()


def span(first: int, last: int) -> int:
    """A mask of samples first..last; empty when last < first."""
    return ((1 << (last - first + 1)) - 1) << first if last >= first else 0


def _patch(lane: Lane, terrain: TerrainMap, machine: Machine) -> tuple[int, int, int, int]:
    """Rows and columns of the map within reach of the lane: r0, r1, c0, c1."""
    radius = max(math.hypot(x, y) for leg in machine.legs for x in leg.x for y in leg.y)
    c0, c1 = _cells(
        float(lane.x.min()) - radius,
        float(lane.x.max()) + radius,
        terrain.origin[0],
        terrain.cell,
        terrain.columns,
    )
    r0, r1 = _cells(
        float(lane.y.min()) - radius,
        float(lane.y.max()) + radius,
        terrain.origin[1],
        terrain.cell,
        terrain.rows,
    )
    return r0, r1, c0, c1


def _torso_clear(lane: Lane, terrain: TerrainMap, machine: Machine) -> NDArray[np.bool_]:
    """(rows, samples): where the torso's box touches no ground."""
    length, width, height = machine.torso
    # a crest tells of all the cells this near
    apart = (2 * math.ceil(terrain.foot_radius / terrain.cell) + 1) * terrain.cell
    crests = np.asarray(terrain.crest_view).reshape(terrain.rows, terrain.columns)
    c, d, low = np.cos(lane.yaw), np.sin(lane.yaw), lane.z - height / 2
    clear = np.ones(lane.x.shape, dtype=bool)
    for bx in np.linspace(-length / 2, length / 2, math.ceil(length / apart) + 1):
        for by in np.linspace(-width / 2, width / 2, math.ceil(width / apart) + 1):
            columns = np.floor(
                (lane.x + c * bx - d * by - terrain.origin[0]) / terrain.cell
            ).astype(np.intp)
            rows = np.floor((lane.y + d * bx + c * by - terrain.origin[1]) / terrain.cell).astype(
                np.intp
            )
            inside = (
                (rows >= 0) & (rows < terrain.rows) & (columns >= 0) & (columns < terrain.columns)
            )
            top = crests[rows.clip(0, terrain.rows - 1), columns.clip(0, terrain.columns - 1)]
            clear &= ~inside | (top <= low)
    return clear


def _cells(low: float, high: float, origin: float, cell: float, count: int) -> tuple[int, int]:
    return min(max(math.floor((low - origin) / cell), 0), count), min(
        max(math.floor((high - origin) / cell) + 1, 0), count
    )


def allowed_cells(
    lane: Lane, terrain: TerrainMap, machine: Machine, thin: int
) -> tuple[Array, Array, Array]:
    """Centres and heights of the cells a foot may land on within reach of the lane; one of thin x
    thin when thinned.
    """
    r0, r1, c0, c1 = _patch(lane, terrain, machine)
    rows, columns = np.nonzero(~terrain.forbidden[r0:r1, c0:c1])
    rows, columns = rows + r0, columns + c0
    if thin > 1 and len(rows):
        _, kept = np.unique((rows // thin) * terrain.columns + columns // thin, return_index=True)
        rows, columns = rows[kept], columns[kept]
    px = np.asarray(terrain.origin[0] + (columns + 0.5) * terrain.cell, dtype=np.float64)
    py = np.asarray(terrain.origin[1] + (rows + 0.5) * terrain.cell, dtype=np.float64)
    return px, py, np.asarray(terrain.heights[rows, columns], dtype=np.float64)


def thinning(lane: Lane, terrain: TerrainMap, machine: Machine) -> int:
    """How coarsely dense ground may be sampled so that a leg's rectangle still offers about DENSE
    footholds.
    """
    r0, r1, c0, c1 = _patch(lane, terrain, machine)
    patch = terrain.forbidden[r0:r1, c0:c1]
    if not patch.size:
        return 1
    allowed = 1.0 - float(np.count_nonzero(patch)) / patch.size
    area = max((leg.x[1] - leg.x[0]) * (leg.y[1] - leg.y[0]) for leg in machine.legs)
    return max(1, math.floor(math.sqrt(allowed * area / terrain.cell**2 / DENSE) + 0.5))


def legs_clear(holds: Sequence[Foothold], feet: Feet, hold: Foothold, radius: float) -> bool:
    """K's second truncation: a foot set down here stands clear of every other standing foot."""
    apart = (2 * radius) ** 2 - EDGE
    for f in feet:
        if f >= 0:
            other = holds[f]
            if other.leg != hold.leg and (other.x - hold.x) ** 2 + (other.y - hold.y) ** 2 < apart:
                return False
    return True
