"""The eye: a range sensor on the body. What it sees of the true ground from here, and what the
ground itself hides.

The ground is one height a cell, so a ray of a given bearing runs over one profile of heights, and
whether a place is seen is whether it stands higher, as an angle, than everything nearer. One look
is one (bearings, distances) array: its cost is bounded by the settings, whatever the map. It may be
worked out a stripe of bearings at a time, all of them from the pose in which it began.

Approximations: noise is in the height alone, bearing and place are exact; legs and torso do not
stand in the way; beyond cell / ``resolution_deg`` (1.4 m for 0.025 m and 1 degree) the fan misses
cells between two rays; every look turns it by a random part of that, so that they are filled in.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from functools import cached_property
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from walking_console.planner.geometry.transforms import directions, placed, turned, turned_back
from walking_console.planner.protocols import run_to_completion
from walking_console.planner.robot.model import Machine
from walking_console.planner.terrain.mapping import Index
from walking_console.planner.types import Array, Point

from .tables import Table
from .terrain.ground import Ground

GLIMPSE = 0.02  # m; a ray that gets this far below the rim of a hole has looked into it
SURFACE = 1e-6  # m; rounding of ray against ground
PROFILE_CELLS_MAX = 400  # samples along one ray: bounds a look on very fine maps
STRIPE = 24  # bearings looked along at once. More: see ticks come late

RayAngle = Annotated[float, Field(ge=0.25, le=10.0)]
MountCoordinate = Annotated[float, Field(ge=-5.0, le=5.0)]


class EyeSettings(Table):
    """The ``[eye]`` table of a scenario. Lengths in metres, angles in degrees, the body frame for
    the position.
    """

    position: Annotated[list[MountCoordinate], Field(min_length=3, max_length=3)] = Field(
        default=[0.2, 0.0, 0.5], description="m from the centre of gravity: a mast on the torso"
    )
    pitch_deg: float = Field(
        default=32.0, ge=-90.0, le=90.0, description="how far the middle of the view looks down"
    )
    pans: bool = Field(
        default=True, description="turns to where the course leads; false: looks along the torso"
    )
    range: float = Field(default=4.0, gt=0.1, le=20.0, description="m")
    width_deg: float = Field(
        default=120.0, gt=0.0, le=360.0, description="field of view, side to side"
    )
    height_deg: float = Field(
        default=56.0, gt=0.0, le=180.0, description="field of view, up and down"
    )
    resolution_deg: Annotated[list[RayAngle], Field(min_length=2, max_length=2)] = Field(
        default=[1.0, 0.5], description="between two rays, side to side and up and down"
    )
    noise: float = Field(
        default=0.003, ge=0.0, le=0.5, description="m, standard deviation of a height"
    )
    dropout: float = Field(
        default=0.02, ge=0.0, le=1.0, description="share of the cells seen that a look loses"
    )
    every: int = Field(default=15, ge=1, le=1000, description="ticks from one look to the next")


class Scan(NamedTuple):
    """What one scan has found: one entry a cell, no cell twice.

    ``heights`` are NaN where the look went into a hole without finding ground. ``sides`` marks
    cells of which only a side was seen: their ground is at least as high.
    """

    rows: Index
    columns: Index
    heights: Array
    sides: NDArray[np.bool_]


class Returns(NamedTuple):
    """What some rays meet, as flat cell indices, cells more than once: ground from above, holes
    looked into, and ground from the side with the height of the highest ray that came in, m.
    """

    tops: Index
    holes: Index
    sides: Index
    came_in: Array


class RangeSensor:
    """One machine's eye over one ground. ``rng`` is the source of noise, dropouts and the turn of
    the fan.
    """

    def __init__(
        self,
        machine: Machine,
        ground: Ground,
        rng: np.random.Generator,
        settings: EyeSettings | None = None,
    ) -> None:
        self.settings = settings or EyeSettings()
        self.machine = machine
        self.rng = rng
        self.replace_ground(ground)

    def replace_ground(self, ground: Ground) -> None:
        """The world has changed; what was seen before is not the eye's business."""
        self.ground = ground
        self._heights = ground.heights.ravel()

    @cached_property
    def distances(self) -> Array:
        """Where a ray is held against the ground, m from the eye seen from above: about one sample
        a cell.
        """
        step = max(self.ground.cell, self.settings.range / PROFILE_CELLS_MAX)
        return np.asarray(np.arange(1, math.floor(self.settings.range / step) + 1) * step)

    @cached_property
    def bearings(self) -> Array:
        """The fan of rays seen from above, rad from where the eye looks."""
        settings = self.settings
        apart = settings.resolution_deg[0]
        count = max(1, math.floor(settings.width_deg / apart))
        return np.asarray((np.arange(count) - (count - 1) / 2) * math.radians(apart))

    def place(self, body: Sequence[float]) -> Point:
        """Where the eye is when the body is at x, y, z, roll, pitch, yaw."""
        x, y, z, roll, pitch, yaw = body
        px, py, pz = self.settings.position
        py, pz = turned(py, pz, roll)
        px, pz = turned_back(px, pz, pitch)
        return *placed((x, y, yaw), px, py), z + pz

    def scan(self, body: Sequence[float], direction: float = 0.0) -> Scan:
        """One scan from the body's pose (x, y, z, roll, pitch, yaw); ``direction`` is the course in
        body axes, rad.
        """
        return run_to_completion(self.scanning(body, direction))

    @property
    def pauses(self) -> int:
        """How many times ``scanning`` pauses."""
        return math.ceil(self.bearings.size / STRIPE) + 1

    def scanning(
        self, body: Sequence[float], direction: float = 0.0
    ) -> Generator[None, None, Scan]:
        """The same scan from this pose, a few bearings at a time."""
        settings = self.settings
        across = math.radians(settings.resolution_deg[0])
        bearings = self.bearings + float(self.rng.uniform(-0.5, 0.5)) * across
        if settings.pans:
            bearings = bearings + direction
        place = self.place(body)
        lowest = self._lowest(body, bearings)
        stripes = []
        for first in range(0, bearings.size, STRIPE):
            some = slice(first, first + STRIPE)
            stripes.append(self._returns(place, bearings[some] + body[5], lowest[some]))
            yield
        flat, heights, sides = self._each_cell_once(stripes)
        yield
        kept = self.rng.random(flat.size) >= settings.dropout
        flat, heights, sides = flat[kept], heights[kept], sides[kept]
        if settings.noise > 0.0:
            heights = heights + self.rng.normal(0.0, settings.noise, flat.size)
        rows, columns = np.divmod(flat, self.ground.columns)
        return Scan(rows, columns, heights, sides)

    def _lowest(self, body: Sequence[float], bearings: Array) -> Array:
        """Elevation of the lowest ray of every bearing, rad, on the tilted body (small tilts)."""
        settings = self.settings
        (_, _, _, roll, pitch, _) = body
        ahead, left = directions(bearings)
        middle = -math.radians(settings.pitch_deg) - pitch * ahead + roll * left
        return np.asarray(middle - math.radians(settings.height_deg) / 2)

    def _returns(self, place: Point, bearings: Array, lowest: Array) -> Returns:
        """What the rays of some bearings meet."""
        settings = self.settings
        resolution = math.radians(settings.resolution_deg[1])
        rays = math.floor(settings.height_deg / settings.resolution_deg[1]) + 1
        flat, heights, bottomless = self._profiles(place, bearings)
        fan = _Fan(self.distances, place[2], lowest, resolution, rays)
        topped, sided, came_in, into = fan.hits(heights, bottomless, settings.range)
        cells = flat.ravel()
        return Returns(cells[topped], cells[into], cells[sided], came_in)

    def _each_cell_once(self, stripes: list[Returns]) -> tuple[Index, Array, NDArray[np.bool_]]:
        """(flat cell index, height, only a side) of every cell seen, no cell twice, in a fixed
        order.
        """
        topped, into, sided, came_in = (np.concatenate(part) for part in zip(*stripes, strict=True))
        tops = _sorted_once(topped)
        holes = _sorted_once(into)
        side_cells, least = _highest_of_each(sided, came_in)
        if tops.size and side_cells.size:
            at = np.minimum(np.searchsorted(tops, side_cells), tops.size - 1)
            only = tops[at] != side_cells
            side_cells, least = side_cells[only], least[only]
        cells = np.concatenate([tops, holes, side_cells])
        found = np.concatenate([self._heights[tops], np.full(holes.size, np.nan), least])
        is_side = np.zeros(cells.size, dtype=bool)
        is_side[tops.size + holes.size :] = True
        return cells, found, is_side

    def _profiles(
        self, place: Point, bearings: Array
    ) -> tuple[Index, Array, NDArray[np.bool_] | None]:
        """The ground under every ray: flat cell index, height (−inf where there is none) and
        whether it is a hole, each (bearings, distances); None where there is no hole at all.
        """
        ground = self.ground
        d = self.distances
        x, y, _ = place
        along_x, along_y = directions(bearings)
        columns = _cells(x - ground.origin[0] + along_x[:, None] * d, ground.cell)
        rows = _cells(y - ground.origin[1] + along_y[:, None] * d, ground.cell)
        flat = rows * ground.columns + columns
        inside = None
        if not (_all_within(columns, ground.columns) and _all_within(rows, ground.rows)):
            inside = (columns >= 0) & (columns < ground.columns)
            inside &= (rows >= 0) & (rows < ground.rows)
            flat = np.where(inside, flat, 0)
        heights = self._heights[flat]
        bottomless = np.isnan(heights)
        if inside is not None:
            bottomless &= inside
            heights = np.where(inside, heights, -np.inf)
        if not bottomless.any():
            return flat, heights, None
        return flat, np.where(bottomless, -np.inf, heights), bottomless


class _Fan(NamedTuple):
    """The rays of one scan over their profiles: ``lowest`` rad, one a bearing, ``rays`` of them one
    above the other, ``resolution`` rad apart.
    """

    distances: Array  # m
    height: float  # m, of the sensor
    lowest: Array
    resolution: float
    rays: int

    def hits(
        self, heights: Array, bottomless: NDArray[np.bool_] | None, reach: float
    ) -> tuple[Index, Index, Array, Index]:
        """Which samples of the profiles (bearings, distances) are met from above, which from the
        side and at what height the highest ray came in there, and which holes are looked into:
        flat indices.
        """
        d = self.distances
        z = self.height
        skyline = np.maximum.accumulate(np.arctan2(heights - z, d), axis=1)
        # rays that end no farther than here
        ended = np.floor((skyline - self.lowest[:, None]) / self.resolution) + 1.0
        stopped = np.clip(ended, 0.0, self.rays)
        hit = np.empty(stopped.shape, dtype=bool)
        np.greater(stopped[:, 0], 0.0, out=hit[:, 0])
        np.greater(stopped[:, 1:], stopped[:, :-1], out=hit[:, 1:])
        # what few samples are met are looked at alone
        at = np.flatnonzero(hit)
        bearing, sample = divmod(at, d.size)
        ground = heights.ravel()[at]
        near = np.hypot(d[sample], ground - z) <= reach
        if not near.all():
            at, bearing, sample, ground = at[near], bearing[near], sample[near], ground[near]
        # the highest ray that ends here, one sample before
        before = d[sample] - float(d[0])
        came_in = z + before * self._slope(bearing, stopped.ravel()[at] - 1.0)
        topped = came_in >= ground - SURFACE
        into = at[:0] if bottomless is None else self._into(bottomless, stopped, heights, reach)
        return at[topped], at[~topped], came_in[~topped], into

    def _into(
        self, bottomless: NDArray[np.bool_], stopped: Array, heights: Array, reach: float
    ) -> Index:
        """Samples over holes that the lowest ray that goes on from there looks into."""
        at = np.flatnonzero(bottomless & (stopped < self.rays))
        bearing, sample = divmod(at, self.distances.size)
        d = self.distances[sample]
        flying = self.height + d * self._slope(bearing, stopped.ravel()[at])
        deep = flying < _rim(heights).ravel()[at] - GLIMPSE
        return at[deep & (np.hypot(d, flying - self.height) <= reach)]

    def _slope(self, bearing: Index, ray: Array) -> Array:
        """How a ray of a bearing rises: metres up for each metre on."""
        return np.asarray(np.tan(self.lowest[bearing] + ray * self.resolution))


def _all_within(cells: Index, count: int) -> bool:
    """True when no ray leaves the map: along a ray columns and rows only rise or only fall."""
    ends = cells[:, :: max(cells.shape[1] - 1, 1)]
    return bool(ends.min() >= 0 and ends.max() < count)


def _sorted_once(cells: Index) -> Index:
    """Cells in order, none twice."""
    ordered = np.sort(cells)
    return ordered[_firsts(ordered)]


def _highest_of_each(cells: Index, heights: Array) -> tuple[Index, Array]:
    """Cells in order, none twice, with the largest of the heights given for each."""
    if not cells.size:
        return cells, heights
    order = np.argsort(cells, kind="stable")
    ordered = cells[order]
    first = np.flatnonzero(_firsts(ordered))
    return ordered[first], np.maximum.reduceat(heights[order], first)


def _firsts(ordered: Index) -> NDArray[np.bool_]:
    """Where in a sorted array a value comes for the first time."""
    first = np.ones(ordered.size, dtype=bool)
    np.not_equal(ordered[1:], ordered[:-1], out=first[1:])
    return first


def _cells(offsets: Array, cell: float) -> Index:
    """Columns or rows at distances from the corner of the map."""
    return np.floor(offsets / cell).astype(np.intp)


def _rim(heights: Array) -> Array:
    """Height of the last ground before each sample of a profile, −inf when there was none."""
    solid = np.where(np.isfinite(heights), np.arange(heights.shape[1]), -1)
    last = np.maximum.accumulate(solid, axis=1)
    return np.where(last >= 0, np.take_along_axis(heights, np.maximum(last, 0), axis=1), -np.inf)
