"""What the map says of the places the body may go to (Level B1): where it can stand, and how well.

The yaw does not change in a crab walk, so a place of the body is a point and everything below is
sums over rectangles of the map turned into body axes. A place is *fit* when

- every leg has ground to step on within its reach rectangle. As the body moves on, a foothold stays
  in the rectangle for up to the stroke λ*, so "fit all along" is exactly "no gap in any leg's lane
  is longer than the stroke allows"; a ``stretched`` costmap takes the rectangles of legs stretched
  to the mechanical limit, for where there is no other way;
- the legs can reach the ground under them together, with a level body;
- the torso clears the ground; and nothing bars a leg's whole lane that the leg cannot be lifted
  over.

Unknown ground counts as fit: it will be looked at before it is trodden on.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..config import DEFAULT, Navigation
from ..geometry.paths import Box, box_around
from ..geometry.transforms import direction, placed
from ..motion.strides import kept
from ..motion.swing import CLEARANCE
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Array, Blocked, Reason, Stance

Places = NDArray[np.floating[Any]]  # s or d of several places, m
Cover = NDArray[np.bool_]

LAYER = 0.25  # m along the line between two layers of places
ACROSS = 0.1  # m across the line between two places
LEAD_MIN = 0.1  # m; a nearer first layer would be reached in the next step
SAMPLE = 0.05  # m, at which the map is read
# of a sample, by which rectangles are widened: rather try a gap as long as the stroke than go round
# it
RIM = 0.6

WAY_OUT = 0.35  # m about a body that stands where it should not
# of z*; legs whose ground differs by more on average cannot stand together and still step
RISE_SHARE = 0.96
BARRED = 0.9  # of a lane's width; a leg finds its way past what covers less
SAMPLES_A_POSTURE = 30  # of a costmap that are made in the time one posture is looked at in
LOW_RELIEF = 0.05  # m; ground this even needs no costmap of heights
SURELY = 1e-6  # m; rounding in sums of heights is less

FIT, STEEP, TORSO, WALL = 0, 100, 101, 102  # what a place is; 1..n: leg without a foothold
BARRED_BY = {
    STEEP: "the ground is too steep for the legs to reach together",
    TORSO: "the torso would touch the ground",
    WALL: "a leg cannot be lifted over what bars its lane",
}


class Region(NamedTuple):
    """The places a route may go through, in the line's own axes: s ahead of the body, d to the left
    of the line.
    """

    course: float  # rad, of the line in body axes
    off: float  # m, where the body is
    lead: float  # m to the first layer; layers lie at multiples of LAYER from where the line begins
    layers: int
    first: int  # number of the rightmost place; places are at multiples of ACROSS
    places: int
    body_length: float  # m
    reach: Box  # all legs' reach

    @classmethod
    def of(
        cls,
        course: float,
        along: float,
        off: float,
        machine: Machine,
        settings: Navigation = DEFAULT.navigation,
        toward: float | None = None,
    ) -> Region:
        """About a body at (along, off) on a line of this course, to either side of the body and the
        line; only as far as ``toward`` where that is given.
        """
        width = settings.width if toward is None else 0.0
        aside = toward or 0.0
        reach = (
            min(box[0] for box in machine.boxes),
            max(box[1] for box in machine.boxes),
            min(box[2] for box in machine.boxes),
            max(box[3] for box in machine.boxes),
        )
        length = reach[1] - reach[0]
        lead = math.ceil((along + LEAD_MIN) / LAYER) * LAYER - along
        low, high = (
            math.floor((min(0.0, off, aside) - width) / ACROSS),
            math.ceil((max(0.0, off, aside) + width) / ACROSS),
        )
        return cls(
            course,
            off,
            lead,
            max(2, math.ceil(settings.bodies_ahead * length / LAYER)),
            low,
            high - low + 1,
            length,
            reach,
        )

    @property
    def length(self) -> float:
        """How far the region leads along the line, m."""
        return self.lead + (self.layers - 1) * LAYER

    @property
    def extent(self) -> Box:
        """The ground it takes, legs included, in body axes from where the body is now."""
        c, s = direction(self.course)
        corners = [
            (along * c - across * s, along * s + across * c)
            for along in (0.0, self.length)
            for across in (
                self.first * ACROSS - self.off,
                (self.first + self.places - 1) * ACROSS - self.off,
            )
        ]
        xs, ys = zip(*corners, strict=True)
        return (
            min(xs) + self.reach[0],
            max(xs) + self.reach[1],
            min(ys) + self.reach[2],
            max(ys) + self.reach[3],
        )

    def place(self, stance: Stance, s: float, d: float) -> tuple[float, float]:
        """A place in the absolute frame."""
        heading = self.course + stance.body[3]
        c, n = direction(heading)
        across = d - self.off
        return stance.body[0] + s * c - across * n, stance.body[1] + s * n + across * c

    def seen_from(self, stance: Stance, x: float, y: float) -> tuple[float, float]:
        """A point of the absolute frame as a place (s, d)."""
        heading = self.course + stance.body[3]
        c, n = direction(heading)
        dx, dy = x - stance.body[0], y - stance.body[1]
        return c * dx + n * dy, self.off + c * dy - n * dx


def is_plain(region: Region, stance: Stance, terrain: TerrainMap) -> bool:
    """Nothing unknown, forbidden or high anywhere near: no need of a costmap."""
    x_min, x_max, y_min, y_max = region.extent
    x, y, _, yaw = stance.body
    reach = (
        max(math.hypot(px, py) for px in (x_min, x_max) for py in (y_min, y_max))
        if yaw % (math.pi / 2)
        else 0.0
    )
    c, s = direction(yaw)
    if reach:
        low_x, high_x, low_y, high_y = x - reach, x + reach, y - reach, y + reach
    else:
        xs = [x + c * px - s * py for px in (x_min, x_max) for py in (y_min, y_max)]
        ys = [y + s * px + c * py for px in (x_min, x_max) for py in (y_min, y_max)]
        low_x, high_x, low_y, high_y = min(xs), max(xs), min(ys), max(ys)
    c0, c1 = (math.floor((v - terrain.origin[0]) / terrain.cell) for v in (low_x, high_x))
    r0, r1 = (math.floor((v - terrain.origin[1]) / terrain.cell) for v in (low_y, high_y))
    if c0 < 0 or r0 < 0 or c1 >= terrain.columns or r1 >= terrain.rows:
        return False
    if terrain.is_plain:
        return True
    cut = (slice(r0, r1 + 1), slice(c0, c1 + 1))
    if terrain.forbidden[cut].any() or (terrain.known is not None and not terrain.known[cut].all()):
        return False
    heights = terrain.heights[cut]
    return bool(heights.max() - heights.min() <= LOW_RELIEF)


def is_clear(region: Region, stance: Stance, terrain: TerrainMap, machine: Machine) -> bool:
    """True where every place on the line is fit for certain, which is far sooner found than by a
    costmap: all ground about it is known, free to step on and as even as legs and torso need.
    """
    rim = 4 * _step(terrain)  # a costmap reads no farther
    x1, x2, y1, y2 = region.extent
    x, y, _, yaw = stance.body
    middle = placed((x, y, yaw), (x1 + x2) / 2, (y1 + y2) / 2)
    box = (x1 - rim, x2 + rim, y1 - rim, y2 + rim)
    low_x, high_x, low_y, high_y = box_around(box, *middle, *direction(yaw))
    x_min, x_max, y_min, y_max = terrain.bounds
    if not (x_min < low_x and high_x < x_max and y_min < low_y and high_y < y_max):
        return False
    cut = terrain.window(low_x, high_x, low_y, high_y)
    if terrain.forbidden[cut].any() or (terrain.known is not None and not terrain.known[cut].all()):
        return False
    heights = terrain.heights[cut]
    return bool(heights.max() - heights.min() <= _evenness(machine))


def _evenness(machine: Machine) -> float:
    """How much ground may differ in height, m, before a place on it can be steep, bar a leg's lane
    or touch the torso.
    """
    low, high = machine.z_range
    under_torso = -low - machine.torso[2] / 2 - CLEARANCE
    return min(RISE_SHARE * (high - low), _lifted_over(machine), under_torso) - SURELY


def _lifted_over(machine: Machine) -> float:
    """How tall ground may be above the lowest around for a leg to be lifted over it, m."""
    return machine.height + machine.z_range[1] + machine.overreach[2] - CLEARANCE


def _step(terrain: TerrainMap) -> float:
    """m between two samples of a map."""
    return max(SAMPLE, terrain.cell)


def _samples(region: Region, step: float) -> tuple[Array, Array]:
    """x and y in body axes at which a map is read, m."""
    x_min, x_max, y_min, y_max = region.extent
    pad = 2 * step
    x = np.arange(x_min - pad, x_max + pad + step, step)
    return x, np.arange(y_min - pad, y_max + pad + step, step)


def weight_of(region: Region, terrain: TerrainMap) -> int:
    """What making a costmap weighs, in postures looked at."""
    x, y = _samples(region, _step(terrain))
    return x.size * y.size // SAMPLES_A_POSTURE


def stretched_boxes(machine: Machine) -> tuple[Box, ...]:
    """Every leg's reach rectangle where it stretches to the mechanical limit (``escape``)."""
    dx, dy = (-less for less in kept(machine, stretched=True))
    return tuple((x1 - dx, x2 + dx, y1 - dy, y2 + dy) for x1, x2, y1, y2 in machine.boxes)


class Costmap:
    """The map around one stance, turned into body axes, and what it says of every place of the
    body.
    """

    def __init__(
        self,
        region: Region,
        stance: Stance,
        terrain: TerrainMap,
        machine: Machine,
        settings: Navigation = DEFAULT.navigation,
        stretched: bool = False,
    ) -> None:
        self.settings = settings
        self.region = region
        self.machine = machine
        self.boxes = stretched_boxes(machine) if stretched else machine.boxes
        self.step = _step(terrain)
        self.x, self.y = _samples(region, self.step)
        self._read(stance, terrain)
        self.verdict, self.density, self.seen = self._judge(stance)
        self.cost = self._cost()
        self._let_out()

    def _read(self, stance: Stance, terrain: TerrainMap) -> None:
        """The map at every sample point; where cells are smaller, a foothold in any quarter of the
        sample will do.
        """
        flat, inside = self._cells(stance, terrain, 0.0, 0.0)
        self.known: Cover = (
            inside if terrain.known is None else inside & terrain.known.ravel()[flat]
        )
        self.all_known = bool((self.known | ~inside).all())
        self.heights: Array = np.where(inside, terrain.heights.ravel()[flat], np.nan)
        quarter = self.step / 4
        shifts = (
            [(0.0, 0.0)]
            if terrain.cell >= self.step
            else [(dx, dy) for dx in (-quarter, quarter) for dy in (-quarter, quarter)]
        )
        forbidden = terrain.forbidden.ravel()
        self.allowed: Cover = ~self.known & inside
        for dx, dy in shifts:
            moved = dx != 0.0 or dy != 0.0
            cells, on_map = self._cells(stance, terrain, dx, dy) if moved else (flat, inside)
            self.allowed |= on_map & ~forbidden[cells]

    def _cells(
        self, stance: Stance, terrain: TerrainMap, dx: float, dy: float
    ) -> tuple[NDArray[np.intp], Cover]:
        """Flat index of the cell at every sample point moved by (dx, dy), and whether it is on the
        map.
        """
        x, y, _, yaw = stance.body
        c, s = direction(yaw)
        bx, by = (self.x + dx)[None, :], (self.y + dy)[:, None]
        columns = np.floor((x - terrain.origin[0] + c * bx - s * by) / terrain.cell).astype(np.intp)
        rows = np.floor((y - terrain.origin[1] + s * bx + c * by) / terrain.cell).astype(np.intp)
        inside = (columns >= 0) & (columns < terrain.columns) & (rows >= 0) & (rows < terrain.rows)
        return np.where(inside, rows * terrain.columns + columns, 0), inside

    # places of the body

    def _judge(self, stance: Stance) -> tuple[NDArray[np.uint8], Array, Array]:
        """For the body at every sample point: fit or why not, least density of footholds, least
        share of ground seen.
        """
        solid = self.allowed & ~np.isnan(self.heights)
        windows = [self._window(box) for box in self.boxes]
        reach = max(abs(side) for window in windows for side in window)
        footholds = Sums(self.allowed, reach)
        ground = Sums(np.where(solid, self.heights, 0.0), reach)
        weight = Sums(solid, reach)
        known = None if self.all_known else Sums(self.known, reach)
        verdict = np.zeros(self.allowed.shape, dtype=np.uint8)
        density = np.full(verdict.shape, np.inf)
        seen = np.ones(verdict.shape)
        low, high = np.full(verdict.shape, np.inf), np.full(verdict.shape, -np.inf)
        walls = self._walls(solid)
        for leg, window in enumerate(windows):
            area = (window[1] - window[0]) * (window[3] - window[2])
            count = footholds.of(window)
            np.minimum(density, count / area, out=density)
            if known is not None:
                np.minimum(seen, known.of(window) / area, out=seen)
            stands = weight.of(window)
            mean = np.where(stands > 0.5, ground.of(window) / np.maximum(stands, 1.0), np.nan)
            low, high = np.fmin(low, mean), np.fmax(high, mean)
            if walls is not None:
                verdict[(verdict == FIT) & self._barred(walls, window)] = WALL
            verdict[(verdict == FIT) & (count < 0.5)] = leg + 1
        legs_low, legs_high = self.machine.z_range
        verdict[(verdict == FIT) & (high - low > RISE_SHARE * (legs_high - legs_low))] = STEEP
        verdict[(verdict == FIT) & self._touches(low - legs_low)] = TORSO
        return verdict, density, seen

    def _window(self, box: Box) -> tuple[int, int, int, int]:
        """A rectangle in body axes as sample offsets, first and one past last, in x and y."""
        x1, x2, y1, y2 = (v / self.step for v in box)
        return (
            math.ceil(x1 - RIM),
            math.floor(x2 + RIM) + 1,
            math.ceil(y1 - RIM),
            math.floor(y2 + RIM) + 1,
        )

    def _walls(self, solid: Cover) -> Cover | None:
        """Ground a leg cannot be lifted over from the lowest ground around, seen or supposed, and a
        foot's radius about it; None when there is none.
        """
        ground = np.where(np.isnan(self.heights), np.inf, self.heights)
        known = np.where(self.known, ground, np.inf)
        limit = _lifted_over(self.machine)
        finite = known[np.isfinite(known)]
        if finite.size == 0 or finite.max() - ground.min() <= limit:
            return None
        around = max(1, round((self.machine.boxes[0][3] - self.machine.boxes[0][2]) / self.step))
        with np.errstate(invalid="ignore"):  # nothing but holes around: inf less inf
            walls = (known - _least_around(ground, around) > limit) & np.isfinite(known)
        about = math.ceil(self.machine.foot_radius / self.step)
        window = (-about, about + 1, -about, about + 1)
        return np.asarray(_most_in(walls.astype(np.float64), window) > 0.5)

    def _barred(self, walls: Cover, window: tuple[int, int, int, int]) -> Cover:
        """Where such ground covers a leg's lane from side to side, across the course."""
        ux, uy = direction(self.region.course)
        along_x = abs(ux) >= abs(uy)
        x1, x2, y1, y2 = window
        depth, width = (
            ((x1, x2, 0, 1), (0, 1, y1, y2)) if along_x else ((0, 1, y1, y2), (x1, x2, 0, 1))
        )
        reach = max(abs(side) for side in window)
        covered = Sums(walls, reach).of(depth) > 0.5
        share = Sums(covered, reach).of(width) / ((y2 - y1) if along_x else (x2 - x1))
        return np.asarray(share >= BARRED)

    def _touches(self, highest_body: Array) -> Cover:
        """Where the torso would be in the ground even with the legs stretched."""
        length, width, height = self.machine.torso
        tops = np.where(np.isnan(self.heights) | ~self.known, -np.inf, self.heights)
        belly = highest_body - height / 2 - CLEARANCE
        floor = np.nanmin(belly) if np.isfinite(belly).any() else math.inf
        if not (tops > floor).any():
            return np.zeros(tops.shape, dtype=bool)
        window = self._window((-length / 2, length / 2, -width / 2, width / 2))
        with np.errstate(invalid="ignore"):
            return np.asarray(_most_in(tops, window) > belly)

    def _cost(self) -> Array:
        """Metres a metre of way costs at every place; infinite where it is not fit."""
        fit = self.verdict == FIT
        usual = float(np.median(self.density[fit])) if fit.any() else 1.0
        enough = min(self.settings.scarce * usual, self.settings.scarce_below)
        scarce = np.clip((enough - self.density) / max(enough, 1e-9), 0.0, 1.0)
        return np.where(fit, 1.0 + self.settings.scarce_cost * scarce * scarce, np.inf)

    def _let_out(self) -> None:
        """The body stands where it stands: a place that should not be fit may be left, at a
        price.
        """
        if self.verdict[self.at(np.zeros(1), np.full(1, self.region.off))][0] == FIT:
            return
        near = np.hypot(self.x[None, :], self.y[:, None]) <= WAY_OUT
        self.cost[near & ~np.isfinite(self.cost)] = self.settings.unfit_cost

    def at(self, s: Places, d: Places) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Row and column of the sample nearest to places (s, d)."""
        c, n = direction(self.region.course)
        across = d - self.region.off
        columns = np.rint((s * c - across * n - self.x[0]) / self.step).astype(np.intp)
        rows = np.rint((s * n + across * c - self.y[0]) / self.step).astype(np.intp)
        return np.clip(rows, 0, self.y.size - 1), np.clip(columns, 0, self.x.size - 1)

    # lines

    def along(self, s: float, d: float) -> Array:
        """Cost a metre at samples of the straight way from the body to a place."""
        length = math.hypot(s, d - self.region.off)
        part = np.arange(1, max(1, math.ceil(length / self.step)) + 1) / max(
            1, math.ceil(length / self.step)
        )
        return self.cost[self.at(part * s, self.region.off + part * (d - self.region.off))]

    def straight_is_fit(self) -> bool:
        """The commanded line itself is fit all along: it is not left only because footholds are
        scarce on it.
        """
        return bool(np.isfinite(self.along(self.region.length, 0.0)).all())

    def known_ahead(self, corners: tuple[tuple[float, float], ...]) -> float:
        """How far the body may go by these corners (s, d) before ground it has not seen comes under
        a leg, m.
        """
        if self.all_known:
            return math.inf
        walked = 0.0
        s1 = 0.0
        d1 = self.region.off
        for s2, d2 in corners:
            length = math.hypot(s2 - s1, d2 - d1)
            part = np.arange(math.ceil(length / self.step) + 1) * min(
                1.0, self.step / max(length, 1e-9)
            )
            seen = self.seen[self.at(s1 + part * (s2 - s1), d1 + part * (d2 - d1))]
            unseen = seen < self.settings.known_enough
            if unseen.any():
                return walked + float(part[int(unseen.argmax())]) * length
            walked, s1, d1 = walked + length, s2, d2
        return math.inf

    def why(self) -> Blocked:
        """What bars the commanded line first."""
        s = np.arange(1, math.ceil(self.region.length / self.step) + 1) * self.step
        verdicts = self.verdict[self.at(s, np.full(s.size, self.region.off))]
        bars = np.flatnonzero(verdicts != FIT)
        if bars.size == 0:
            return Blocked(Reason.NO_DIRECTION)
        verdict = int(verdicts[bars[0]])
        because = BARRED_BY.get(verdict, f"leg {verdict} would find no foothold")
        facts: dict[str, float | str] = {
            "width": self.settings.width,
            "distance": float(s[bars[0]]),
            "because": because,
        }
        return Blocked(Reason.NO_WAY_ROUND, facts=facts)


class Sums:
    """Sums over rectangles of a grid around every point of it, which reach ``reach`` points from it
    at most; what lies outside counts as 0.
    """

    def __init__(self, values: Array | Cover, reach: int) -> None:
        rows, columns = values.shape
        self.shape = rows, columns
        self.reach = reach
        self.summed = np.zeros((rows + 1 + 2 * reach, columns + 1 + 2 * reach))
        end_row, end_column = reach + 1 + rows, reach + 1 + columns
        inner = self.summed[reach + 1 : end_row, reach + 1 : end_column]
        values.cumsum(axis=0, dtype=np.float64).cumsum(axis=1, out=inner)
        self.summed[reach + 1 : end_row, end_column:] = inner[:, -1:]
        self.summed[end_row:] = self.summed[end_row - 1]

    def of(self, window: tuple[int, int, int, int]) -> Array:
        """Sum over columns x1..x2-1 and rows y1..y2-1 from each point."""
        x1, x2, y1, y2 = (side + self.reach for side in window)
        rows, columns = self.shape
        above = self.summed[y2 : y2 + rows]
        below = self.summed[y1 : y1 + rows]
        left = slice(x1, x1 + columns)
        right = slice(x2, x2 + columns)
        return np.asarray(above[:, right] - above[:, left] - below[:, right] + below[:, left])


def _most_in(values: Array, window: tuple[int, int, int, int]) -> Array:
    """Largest value over columns x1..x2-1 and rows y1..y2-1 from each point; -inf outside."""
    x1, x2, y1, y2 = window
    out = values
    for axis, first, last in ((1, x1, x2), (0, y1, y2)):
        lines = np.moveaxis(out, axis, 0)
        size = lines.shape[0]
        before = max(0, -first)
        behind = max(0, last - 1)
        padded = np.pad(lines, ((before, behind), (0, 0)), constant_values=-np.inf)
        most = padded[before + first : before + first + size].copy()
        for shift in range(first + 1, last):
            np.maximum(most, padded[before + shift : before + shift + size], out=most)
        out = np.moveaxis(most, 0, axis)
    return out


def _least_around(values: Array, reach: int) -> Array:
    """Smallest value within ``reach`` samples in rows and columns."""
    return -_most_in(-values, (-reach, reach + 1, -reach, reach + 1))
