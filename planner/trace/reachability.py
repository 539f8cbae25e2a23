"""Which feet carry the machine where on a trace (K "calculation of footholds", "of states").

A foothold of a leg exists on the samples over which it stays inside the leg's reach box in one go.
A set of standing feet exists where all its footholds do and the centre of gravity is at least the
margin inside their polygon. Both are kept as sets of samples (``samples``).
"""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.paths import EDGE, Box
from ..geometry.transforms import direction, directions, point_seen
from ..protocols import Weight, run_to_completion
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Array, Point
from .clearance import Clearance
from .footholds import AIR, Foothold, Footing, allowed_cells
from .lane import Lane
from .leg_clearance import LegClearance
from .samples import SampleGrid
from .stability_table import MARGIN, StabilityTable

CHUNK = 64  # samples looked at together: wider wastes work on footholds far away
LOOKED_AT = 16  # footholds whose legs are held against tall things between two yields
# samples of footholds that are looked at, all at once, in the time one posture is looked at in
SAMPLES_A_POSTURE = 1000
# footholds kept between two yields, and what that weighs, in postures looked at
ADDED, ADDED_WEIGHT = 50, 10
MOST = 0.5  # of the ground in front of a leg; where it reaches less its height is what stops it
SAME = 1e-9  # m; points this near are one


class OutOfHeight(NamedTuple):
    """A leg whose joints cannot follow the ground beneath it."""

    leg: int
    share: float  # of the cells in its rectangle, that are at a height it reaches
    ground: tuple[float, float]  # m, lowest and highest of them, seen from the body

    def said(self, machine: Machine) -> str:
        """The same in words."""
        low, high = machine.legs[self.leg].z
        return (
            f"leg {self.leg + 1} reaches {-1e3 * high:.0f} to {-1e3 * low:.0f} mm below the body, "
            f"which stays level; the ground in front of it lies {-1e3 * self.ground[1]:.0f} to "
            f"{-1e3 * self.ground[0]:.0f} mm below, {100.0 * self.share:.0f} % of it in reach"
        )


class Reachability:
    """All footholds within reach of a lane, and which sets of them carry the machine where."""

    def __init__(
        self,
        lane: Lane,
        terrain: TerrainMap,
        machine: Machine,
        *,
        thin: int = 1,
        margin: float = MARGIN,
    ) -> None:
        """No foothold is known until ``find`` has been called for its leg."""
        self.lane = lane
        self.terrain = terrain
        self.machine = machine
        self.samples = SampleGrid(*lane.x.shape)
        self.turns = bool(np.ptp(lane.yaw) > 1e-9)
        self.footholds: list[Foothold] = []
        self.existence: list[int] = []  # of each foothold: its existence segment, K
        self.by_leg: list[list[int]] = [[] for _ in machine.legs]
        self.stability = StabilityTable(lane, self.samples, self.footholds, margin)
        self.clearance = Clearance(lane, self.samples, terrain, machine)
        self.legs = LegClearance(lane, terrain, machine)
        self._cells = allowed_cells(lane, terrain, machine, thin)
        self._carries: dict[Footing, int] = {}
        self._valid: dict[Footing, int] = {}

    def find_all(self) -> Reachability:
        """Find every leg's footholds at once; a caller with a tick to keep calls ``find`` leg by
        leg.
        """
        for leg in range(len(self.machine.legs)):
            self.find(leg)
        return self

    def find(self, leg: int) -> None:
        """Find a leg's footholds and their existence segments."""
        run_to_completion(self.finding(leg))

    def finding(self, leg: int) -> Generator[Weight, None, None]:
        """The same a little at a time."""
        px, py, pz = self._cells
        if not len(px):
            return
        description = self.machine.legs[leg]
        exists = yield from self._existing(px, py, pz, description.box, description.z)
        usable = np.nonzero(exists.any(axis=(1, 2)))[0]
        if not len(usable):
            return
        if self.legs.matters:
            for count, p in enumerate(usable.tolist(), 1):
                if self.legs.is_near(float(px[p]), float(py[p])):
                    foot = float(px[p]), float(py[p]), float(pz[p])
                    exists[p] = self.legs.clear(leg, foot, exists[p])
                if count % LOOKED_AT == 0:
                    yield None
            usable = usable[exists[usable].any(axis=(1, 2))]
            if not len(usable):
                return
        for begin in range(0, len(usable), ADDED):
            some = usable[begin : begin + ADDED]
            masks = self.samples.pack_each(exists[some])
            for p, mask in zip(some.tolist(), masks, strict=True):
                self._add(leg, (float(px[p]), float(py[p]), float(pz[p])), mask)
            yield ADDED_WEIGHT

    def _add(self, leg: int, point: Point, mask: int) -> int:
        number = len(self.footholds)
        on_trace = mask & self.samples.row_mask
        self.footholds.append(Foothold(leg, *point, on_trace.bit_length() - 1))
        self.by_leg[leg].append(number)
        self.existence.append(mask)
        return number

    def foothold_of(self, leg: int, foot: Point, sample: int) -> int:
        """The number of the foothold a leg stands on now; a foot out of reach can only stand where
        it is.
        """
        for number in self.by_leg[leg]:
            hold = self.footholds[number]
            near = abs(hold.x - foot[0]) < SAME and abs(hold.y - foot[1]) < SAME
            if near and self.existence[number] >> sample & 1:
                return number
        box, z = self._stretched(leg, foot, sample)
        x, y, height = (np.array([v]) for v in foot)
        exists = self._exists(x, y, height, box, z)
        return self._add(leg, foot, self.samples.pack(exists[0]) | 1 << sample)

    def accept(self, feet: Footing, sample: int) -> bool:
        """Take the machine as it stands, less stable than the margin or with too little room; False
        when it does not stand at all.
        """
        if not self.stability.accept(feet, sample):
            return False
        self.clearance.accept([leg for leg, f in enumerate(feet) if f < 0], sample)
        return bool(self.valid(feet) >> sample & 1)

    # where points are in reach

    def _exists(
        self, px: Array, py: Array, pz: Array, box: Box, z: tuple[float, float]
    ) -> NDArray[np.bool_]:
        """(points, rows, samples): where each point is inside a leg's reach box."""
        return run_to_completion(self._existing(px, py, pz, box, z))

    def _existing(
        self, px: Array, py: Array, pz: Array, box: Box, z: tuple[float, float]
    ) -> Generator[Weight, None, NDArray[np.bool_]]:
        """The same a part of the lane at a time."""
        exists = np.zeros((len(px), *self.lane.x.shape), dtype=bool)
        for begin in range(0, self.samples.count, CHUNK):
            part = slice(begin, min(begin + CHUNK, self.samples.count))
            near = self._near(px, py, box, part)
            if len(near):
                exists[near, :, part] = self._inside(px[near], py[near], box, part)
            looked_at = len(px) + len(near) * self.lane.x.shape[0] * (part.stop - part.start)
            yield looked_at // SAMPLES_A_POSTURE
        if not self.terrain.is_level:
            near = np.nonzero(exists.any(axis=(1, 2)))[0]
            depth = pz[near, None] - self.lane.z
            exists[near] &= ((depth >= z[0] - EDGE) & (depth <= z[1] + EDGE))[:, None, :]
        return exists

    def _inside(self, px: Array, py: Array, box: Box, part: slice) -> NDArray[np.bool_]:
        yaw = self.lane.yaw[part]
        dx = px[:, None, None] - self.lane.x[:, part]
        dy = py[:, None, None] - self.lane.y[:, part]
        if self.turns:
            c, d = directions(yaw)
            dx, dy = c * dx + d * dy, c * dy - d * dx
        elif yaw[0] != 0.0:
            cosine, sine = direction(yaw[0])
            dx, dy = cosine * dx + sine * dy, cosine * dy - sine * dx
        within = (dx >= box[0] - EDGE) & (dx <= box[1] + EDGE)
        within &= (dy >= box[2] - EDGE) & (dy <= box[3] + EDGE)
        return np.asarray(within)

    def _near(self, px: Array, py: Array, box: Box, part: slice) -> NDArray[np.int64]:
        """Points that some sample of the part could bring into the rectangle."""
        x = self.lane.x[:, part]
        y = self.lane.y[:, part]
        low_x, high_x, low_y, high_y = box
        if self.turns or self.lane.yaw[0] != 0.0:
            high_x = high_y = max(math.hypot(bx, by) for bx in box[:2] for by in box[2:])
            low_x = low_y = -high_x
        inside = (px >= x.min() + low_x - EDGE) & (px <= x.max() + high_x + EDGE)
        inside &= (py >= y.min() + low_y - EDGE) & (py <= y.max() + high_y + EDGE)
        return np.nonzero(inside)[0]

    def _stretched(self, leg: int, foot: Point, sample: int) -> tuple[Box, tuple[float, float]]:
        """A leg's reach box, stretched to where its foot is now: a foot out of reach may come
        nearer, never go farther out.
        """
        row, k = divmod(sample, self.samples.width)
        lane = self.lane
        body = float(lane.x[row, k]), float(lane.y[row, k]), float(lane.z[k]), float(lane.yaw[k])
        bx, by, dz = point_seen(body, foot)
        (x0, x1) = self.machine.legs[leg].x
        (y0, y1) = self.machine.legs[leg].y
        z0, z1 = self.machine.legs[leg].z
        return (min(x0, bx), max(x1, bx), min(y0, by), max(y1, by)), (min(z0, dz), max(z1, dz))

    def out_of_height(self, sample: int) -> OutOfHeight | None:
        """The leg that reaches the least share of the ground in its rectangle, by its height alone,
        with the body at a sample of the trace; None where every leg reaches most of it.
        """
        if self.terrain.is_level:
            return None
        found = (self._height_of(leg, sample) for leg in range(len(self.machine.legs)))
        least = min(found, key=lambda each: each.share)
        return least if least.share < MOST else None

    def _height_of(self, leg: int, sample: int) -> OutOfHeight:
        px, py, pz = self._cells
        description = self.machine.legs[leg]
        inside = self._inside(px, py, description.box, slice(sample, sample + 1))[:, 0, 0]
        depth = pz[inside] - self.lane.z[sample]
        if not len(depth):
            return OutOfHeight(leg, 1.0, (0.0, 0.0))
        low, high = description.z
        reached = (depth >= low - EDGE) & (depth <= high + EDGE)
        return OutOfHeight(leg, float(reached.mean()), (float(depth.min()), float(depth.max())))

    def ban(self, leg: int, foot: Point, radius: float) -> None:
        """No foothold of this leg is within ``radius`` m of here any more."""
        for number in self.by_leg[leg]:
            hold = self.footholds[number]
            if math.hypot(hold.x - foot[0], hold.y - foot[1]) <= radius:
                self.existence[number] = 0
        self._carries.clear()
        self._valid.clear()

    # which sets of feet carry where

    def valid(self, feet: Footing) -> int:
        """Existence segments of a state: where its feet carry, and its legs in the air have room to
        wait.
        """
        if not self.clearance.has_tall or AIR not in feet:
            return self.carries(feet)
        mask = self._valid.get(feet)
        if mask is None:
            mask = self.carries(feet)
            for leg, f in enumerate(feet):
                if f < 0:
                    mask &= self.clearance.room(leg)
            self._valid[feet] = mask
        return mask

    def carries(self, feet: Footing) -> int:
        """Samples at which every standing foot is in reach, the machine is stable and its torso has
        room.
        """
        mask = self._carries.get(feet)
        if mask is None:
            mask = self.stability.stable(feet) & self.clearance.torso_room
            if mask:
                existence = self.existence
                for f in feet:
                    if f >= 0:
                        mask &= existence[f]
            self._carries[feet] = mask
        return mask

    def between(self, feet: Footing, after: Footing) -> int:
        """Samples the body may pass while the feet that differ are in the air; none when one cannot
        be carried across.
        """
        rest = tuple(f if f == g else AIR for f, g in zip(feet, after, strict=True))
        mask = self.carries(rest)
        if self.clearance.has_tall:
            for leg, (f, g) in enumerate(zip(feet, after, strict=True)):
                if f < 0 or g < 0:
                    mask &= self.clearance.room(leg)
                elif f != g and not self.crosses(f, g):
                    return 0
        return mask

    def crosses(self, f: int, g: int) -> bool:
        """True when a foot can be carried over the ground between two footholds."""
        holds = self.footholds[f], self.footholds[g]
        return self.clearance.crosses(f, g, holds, self.existence[f] | self.existence[g])
