"""Level B1: the route ahead (H §3, §4.4, fig. 14). Checks the commanded course against the map and goes round what cannot be crossed.

H leaves the method to its ref. 11, which is not at hand. Ours is a shortest path over places of the body (its yaw does
not change in a crab walk, so a place is a point): layers every 0.25 m along the commanded line, places every 0.1 m
across it, two body lengths ahead. A place is *fit* when the body can stand there:

- every leg has ground to step on within its reach rectangle. As the body moves on, a foothold stays in the rectangle for
  up to the stroke λ*, so "fit all along" is exactly "no gap in any leg's lane is longer than the stroke allows";
- the legs can reach the ground under them together, with a level body;
- the torso clears the ground; and nothing bars a leg's whole lane that the leg cannot be lifted over.

Bends cost, so the shortest way round is H's trapezoid: out, along, back to the commanded line. Scarce footholds and the
crab angle at which the margin vanishes cost too. Unknown ground counts as fit (it will be looked at before it is trodden
on) but is approached slowly. It is a necessary test, not a sufficient one: B2 may still find no step; then
``refused`` names the direction and the next best is taken.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..course import Box
from ..machine import Machine
from ..terrain import TerrainMap
from ..vocabulary import Blocked, Command, Stance
from .height import CLEARANCE
from .standard import critical_angle

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]

LAYER = 0.25  # m along the line between two layers
ACROSS = 0.1  # m across the line between two places
WIDTH = 2.0  # m to either side of the line; obstacles wider than twice this are not gone round
BODIES_AHEAD = 2.0  # body lengths looked ahead
SAMPLE = 0.05  # m, at which the map is read

ON_LINE = 0.02  # m; nearer than this the command is walked as it came
GENTLE = 1.0  # m; a small offset from the line is taken back over this length
SAME = math.radians(2.0)  # a better course this near to the present one is not worth leaving a converged gait
BEND, BEND_PER_RAD = 0.1, 0.2  # m; more and the way round has fewer corners and longer sides
OFF_LINE = 0.15  # m per m²; less and it strays, more and it cuts corners steeply
SCARCE, SCARCE_COST = 0.5, 3.0  # of the usual density of footholds; what a place without any would cost, m per m
SCARCE_BELOW = 0.3  # density that is never scarce
NEAR_CRITICAL, NEAR_CRITICAL_COST = math.radians(4.0), 1.5  # the margin vanishes at α_c
STEPS_ACROSS = (0, 1, -1, 2, -2, 4, -4)  # places a way may shift from layer to layer: 0, 22, 39 and 58 degrees
REFUSED = math.radians(8.0)  # directions this near to a refused one are refused with it

RISE_SHARE = 0.8  # of z*; legs whose ground differs by more on average cannot stand together and still step
BARRED = 0.9  # of a lane's width; a leg finds its way past what covers less
LOW_RELIEF = 0.05  # m; ground this even needs no survey of heights
KNOWN_ENOUGH = 0.2  # of a leg's rectangle seen: enough to plan by
SLOWEST = 0.25  # of the commanded speed, over ground just ahead that is unknown
NO_WAY = 0.5  # m; a dead end nearer than this stops the walk

FIT, STEEP, TORSO, WALL = 0, 100, 101, 102  # what a place is; 1..n: leg without a foothold


@dataclass(frozen=True, slots=True)
class RouteState:
    """What Level B1 remembers from step to step: the commanded line, and the way it is going round."""

    asked: tuple[float, float] | None = None  # crab angle and turn rate the line was drawn for
    line: tuple[float, float, float] = (0.0, 0.0, 0.0)  # x, y of a point on the commanded line, and its heading
    offset: float = 0.0  # rad, course walked against the line
    off_line: float = 0.0  # m, where the body is, to the left of the line
    speed_limit: float = math.inf  # m/s, for ground not seen yet
    way: tuple[tuple[float, float], ...] = ()  # corners of the way ahead, absolute; () when it is the commanded line

    @property
    def detours(self) -> bool:
        """True while the walk is off the commanded course on purpose."""
        return self.offset != 0.0 or abs(self.off_line) > ON_LINE


def plan_route(
    state: RouteState,
    command: Command,
    stance: Stance,
    terrain: TerrainMap,
    machine: Machine,
    refused: Sequence[float] = (),
    cautious: bool = True,
) -> tuple[Command, RouteState, Blocked | None]:
    """The command to plan the next step with, what to remember, and why nothing works if so.

    ``refused`` are courses against the line (``RouteState.offset``) for which Level B2 has just found no step from this
    very stance. ``cautious``: slow down before unknown ground (no use to a walker without an eye). A command that turns is
    passed on as it is: there is no line to come back to.
    """
    if command.holds or command.turn_rate != 0.0:
        return command, RouteState(), None
    state = _drawn(state, command, stance)
    x0, y0, heading = state.line
    x, y, _, yaw = stance.body
    off = math.cos(heading) * (y - y0) - math.sin(heading) * (x - x0)
    state = replace(state, off_line=off, speed_limit=math.inf, way=())
    course = heading - yaw
    region = Region.of(course, off, machine)
    if not refused and _is_plain(region, stance, terrain):
        return _steered(command, replace(state, offset=_homing(off)), course)
    survey = Survey(region, stance, terrain, machine)
    if not refused and abs(off) <= ON_LINE and survey.straight_is_good():
        return _steered(command, replace(state, offset=0.0), course, survey if cautious else None)
    way = survey.shortest(state.offset, refused, sideways=False) or survey.shortest(state.offset, refused, sideways=True)
    if way is None:
        return command, replace(state, offset=0.0), Blocked(survey.why())
    offset = way.course
    if way.ends_on_line and abs(off) <= ON_LINE and abs(offset) < SAME:
        offset = 0.0
    elif abs(offset - state.offset) < SAME and state.offset != 0.0:
        offset = state.offset
    corners = tuple(region.place(stance, s, d) for s, d in way.corners)
    return _steered(command, replace(state, offset=offset, way=corners), course, survey if cautious else None, way)


def _drawn(state: RouteState, command: Command, stance: Stance) -> RouteState:
    """The commanded line goes through where the course was last commanded; a change of speed is no new course."""
    asked = (command.crab_angle, command.turn_rate)
    if state.asked == asked:
        return state
    return RouteState(asked, (stance.body[0], stance.body[1], stance.body[3] + command.crab_angle))


def _steered(
    command: Command, state: RouteState, course: float, survey: Survey | None = None, way: Way | None = None
) -> tuple[Command, RouteState, Blocked | None]:
    """The command turned by the offset; not touched at all when there is nothing to change."""
    angle = command.crab_angle
    if state.offset != 0.0 or abs(math.remainder(course - angle, 2 * math.pi)) > 1e-6:
        angle = math.remainder(course + state.offset, 2 * math.pi)
    speed = command.speed
    if survey is not None:
        speed *= min(1.0, max(SLOWEST, survey.known_ahead(way) / survey.region.body_length))
    limit = speed if speed < command.speed else math.inf
    return replace(command, crab_angle=angle, speed=speed), replace(state, speed_limit=limit), None


def _homing(off: float) -> float:
    """Course back to the line over ground where nothing is in the way."""
    return 0.0 if abs(off) <= ON_LINE else math.atan2(-off, max(GENTLE, abs(off) * LAYER / ACROSS))


class Region(NamedTuple):
    """The places a route may go through, in the line's own axes: s ahead of the body, d to the left of the line."""

    course: float  # rad, of the line in body axes
    off: float  # m, where the body is
    layers: int
    first: int  # number of the rightmost place; places are at multiples of ACROSS
    places: int
    body_length: float  # m
    reach: Box  # all legs' reach

    @classmethod
    def of(cls, course: float, off: float, machine: Machine) -> Region:
        reach = (
            min(box[0] for box in machine.boxes),
            max(box[1] for box in machine.boxes),
            min(box[2] for box in machine.boxes),
            max(box[3] for box in machine.boxes),
        )
        length = reach[1] - reach[0]
        low, high = math.floor((min(0.0, off) - WIDTH) / ACROSS), math.ceil((max(0.0, off) + WIDTH) / ACROSS)
        return cls(course, off, math.ceil(BODIES_AHEAD * length / LAYER), low, high - low + 1, length, reach)

    @property
    def extent(self) -> Box:
        """The ground it takes, legs included, in body axes from where the body is now."""
        c, s = math.cos(self.course), math.sin(self.course)
        corners = [
            (along * c - across * s, along * s + across * c)
            for along in (0.0, self.layers * LAYER)
            for across in (self.first * ACROSS - self.off, (self.first + self.places - 1) * ACROSS - self.off)
        ]
        xs, ys = zip(*corners, strict=True)
        return min(xs) + self.reach[0], max(xs) + self.reach[1], min(ys) + self.reach[2], max(ys) + self.reach[3]

    def place(self, stance: Stance, s: float, d: float) -> tuple[float, float]:
        """A place in the absolute frame."""
        heading = self.course + stance.body[3]
        c, n, across = math.cos(heading), math.sin(heading), d - self.off
        return stance.body[0] + s * c - across * n, stance.body[1] + s * n + across * c


class Way(NamedTuple):
    """A way through the region: its corners (s, d) after the body's own place, and the course of its first side."""

    course: float  # rad against the line
    corners: tuple[tuple[float, float], ...]
    ends_on_line: bool


def _is_plain(region: Region, stance: Stance, terrain: TerrainMap) -> bool:
    """Nothing unknown, forbidden or high anywhere near: no need to survey."""
    x_min, x_max, y_min, y_max = region.extent
    x, y, _, yaw = stance.body
    reach = max(math.hypot(px, py) for px in (x_min, x_max) for py in (y_min, y_max)) if yaw % (math.pi / 2) else 0.0
    c, s = math.cos(yaw), math.sin(yaw)
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
    cut = (slice(r0, r1 + 1), slice(c0, c1 + 1))
    if terrain.forbidden[cut].any() or (terrain.known is not None and not terrain.known[cut].all()):
        return False
    heights = terrain.heights[cut]
    return bool(heights.max() - heights.min() <= LOW_RELIEF)


class Survey:
    """The map around one stance, turned into body axes, and what it says of every place of the body."""

    def __init__(self, region: Region, stance: Stance, terrain: TerrainMap, machine: Machine) -> None:
        self.region, self.machine = region, machine
        self.step = max(SAMPLE, terrain.cell)
        x_min, x_max, y_min, y_max = region.extent
        pad = 2 * self.step
        self.x = np.arange(x_min - pad, x_max + pad + self.step, self.step)
        self.y = np.arange(y_min - pad, y_max + pad + self.step, self.step)
        self._read(stance, terrain)
        self.verdict, self.density, self.seen = self._judge(stance)
        self.cost = self._cost()

    def _read(self, stance: Stance, terrain: TerrainMap) -> None:
        x, y, _, yaw = stance.body
        c, s = math.cos(yaw), math.sin(yaw)
        px, py = x + c * self.x[None, :] - s * self.y[:, None], y + s * self.x[None, :] + c * self.y[:, None]
        columns = np.floor((px - terrain.origin[0]) / terrain.cell).astype(np.intp)
        rows = np.floor((py - terrain.origin[1]) / terrain.cell).astype(np.intp)
        inside = (columns >= 0) & (columns < terrain.columns) & (rows >= 0) & (rows < terrain.rows)
        flat = np.where(inside, rows * terrain.columns + columns, 0)
        self.known: Bools = inside if terrain.known is None else inside & terrain.known.ravel()[flat]
        known_or_off_map = self.known | ~inside
        self.heights: Array = np.where(inside, terrain.heights.ravel()[flat], np.nan)
        refused = np.where(inside, terrain.forbidden.ravel()[flat], True)
        self.allowed: Bools = (~refused & ~np.isnan(self.heights)) | ~known_or_off_map
        self.all_known = bool(known_or_off_map.all())

    # places of the body

    def _judge(self, stance: Stance) -> tuple[NDArray[np.uint8], Array, Array]:
        """For the body at every sample point: fit or why not, least density of footholds, least share of ground seen."""
        solid = self.allowed & ~np.isnan(self.heights)
        footholds = _Sums(self.allowed.astype(np.float64))
        ground, weight = _Sums(np.where(solid, self.heights, 0.0)), _Sums(solid.astype(np.float64))
        known = None if self.all_known else _Sums(self.known.astype(np.float64))
        verdict = np.zeros(self.allowed.shape, dtype=np.uint8)
        density, seen = np.full(verdict.shape, np.inf), np.ones(verdict.shape)
        low, high = np.full(verdict.shape, np.inf), np.full(verdict.shape, -np.inf)
        walls = self._walls(solid)
        for leg, box in enumerate(self.machine.boxes):
            window = self._window(box)
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
        _, _, z_low, z_high = self.machine.boxes[0]
        legs_low, legs_high = self.machine.z_range
        verdict[(verdict == FIT) & (high - low > RISE_SHARE * (legs_high - legs_low))] = STEEP
        verdict[(verdict == FIT) & self._touches(low - legs_low)] = TORSO
        return verdict, density, seen

    def _window(self, box: Box) -> tuple[int, int, int, int]:
        """A rectangle in body axes as sample offsets, first and one past last, in x and y."""
        x1, x2, y1, y2 = (v / self.step for v in box)
        return math.ceil(x1 - 0.01), math.floor(x2 + 0.01) + 1, math.ceil(y1 - 0.01), math.floor(y2 + 0.01) + 1

    def _walls(self, solid: Bools) -> Bools | None:
        """Ground a leg cannot be lifted over from the lowest ground around; None when there is none."""
        known = np.where(np.isnan(self.heights) | ~self.known, np.inf, self.heights)
        limit = self.machine.height + self.machine.z_range[1] + self.machine.overreach[2] - CLEARANCE
        finite = known[np.isfinite(known)]
        if finite.size == 0 or finite.max() - finite.min() <= limit:
            return None
        around = max(1, round((self.machine.boxes[0][3] - self.machine.boxes[0][2]) / self.step))
        rise = known - _least_around(known, around)
        with np.errstate(invalid="ignore"):
            return np.asarray((rise > limit) & np.isfinite(known))

    def _barred(self, walls: Bools, window: tuple[int, int, int, int]) -> Bools:
        """Where such ground covers a leg's lane from side to side, across the course."""
        along_x = abs(math.cos(self.region.course)) >= abs(math.sin(self.region.course))
        x1, x2, y1, y2 = window
        depth, width = ((x1, x2, 0, 1), (0, 1, y1, y2)) if along_x else ((0, 1, y1, y2), (x1, x2, 0, 1))
        covered = _Sums(walls.astype(np.float64)).of(depth) > 0.5
        share = _Sums(covered.astype(np.float64)).of(width) / ((y2 - y1) if along_x else (x2 - x1))
        return np.asarray(share >= BARRED)

    def _touches(self, highest_body: Array) -> Bools:
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
        enough = min(SCARCE * usual, SCARCE_BELOW)
        scarce = np.clip((enough - self.density) / max(enough, 1e-9), 0.0, 1.0)
        return np.where(fit, 1.0 + SCARCE_COST * scarce * scarce, np.inf)

    def _at(self, s: Array, d: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Row and column of the sample nearest to places (s, d)."""
        c, n, across = math.cos(self.region.course), math.sin(self.region.course), d - self.region.off
        columns = np.rint((s * c - across * n - self.x[0]) / self.step).astype(np.intp)
        rows = np.rint((s * n + across * c - self.y[0]) / self.step).astype(np.intp)
        return np.clip(rows, 0, self.y.size - 1), np.clip(columns, 0, self.x.size - 1)

    # ways

    def straight_is_good(self) -> bool:
        """The commanded line itself is fit all along, and footholds are not scarce on it."""
        s = np.arange(1, self.region.layers * 4 + 1) * (LAYER / 4)
        cost = self.cost[self._at(s, np.zeros(s.size))]
        return bool(np.isfinite(cost).all() and cost.mean() <= 1.0 + 0.1 * SCARCE_COST)

    def shortest(self, offset: float, refused: Sequence[float], sideways: bool) -> Way | None:
        """The cheapest way through all layers from the body's place; None when there is none."""
        return _Search(self, offset, refused, sideways).way()

    def known_ahead(self, way: Way | None) -> float:
        """How far the body may go along a way (the line, if none) before ground it has not seen comes under a leg, m."""
        if self.all_known:
            return math.inf
        corners = [(0.0, self.region.off), *(way.corners if way is not None else ((self.region.layers * LAYER, 0.0),))]
        walked = 0.0
        for (s1, d1), (s2, d2) in zip(corners, corners[1:], strict=False):
            length = math.hypot(s2 - s1, d2 - d1)
            part = np.linspace(0.0, 1.0, max(2, math.ceil(length / self.step)))
            unseen = self.seen[self._at(s1 + part * (s2 - s1), d1 + part * (d2 - d1))] < KNOWN_ENOUGH
            if unseen.any():
                return walked + float(part[int(unseen.argmax())]) * length
            walked += length
        return math.inf

    def why(self) -> str:
        """What bars the commanded line first."""
        s = np.arange(1, self.region.layers * 4 + 1) * (LAYER / 4)
        verdicts = self.verdict[self._at(s, np.full(s.size, self.region.off))]
        bars = np.flatnonzero(verdicts != FIT)
        if bars.size == 0:
            return "no step can be planned in any direction near the course"
        distance, verdict = float(s[bars[0]]), int(verdicts[bars[0]])
        reason = {
            STEEP: "the ground is too steep for the legs to reach together",
            TORSO: "the torso would touch the ground",
            WALL: "a leg cannot be lifted over what bars its lane",
        }.get(verdict, f"leg {verdict} would find no foothold")
        return f"no way round within {WIDTH:g} m to either side: {distance:.1f} m ahead {reason}"


class _Search:
    """Dynamic programming from layer to layer over (place, direction of the last side); bends cost."""

    def __init__(self, survey: Survey, offset: float, refused: Sequence[float], sideways: bool) -> None:
        self.survey, self.region, self.sideways = survey, survey.region, sideways
        self.refused, self.offset = refused, offset
        self.across = (self.region.first + np.arange(self.region.places)) * ACROSS
        turns = [math.atan2(k * ACROSS, LAYER) for k in STEPS_ACROSS]
        self.angles = np.array([*turns, math.pi / 2, -math.pi / 2] if sideways else turns)
        difference = np.abs(self.angles[:, None] - self.angles[None, :])
        self.bend = np.where(difference < 1e-9, 0.0, BEND + BEND_PER_RAD * difference)  # [from, to]
        self.weight = self._critical()

    def _critical(self) -> Array:
        """Directions near the crab angle at which the margin vanishes cost more."""
        critical = critical_angle(self.survey.machine)
        weight = np.ones(self.angles.size)
        for m, angle in enumerate(self.angles):
            crab = abs(math.remainder(self.region.course + float(angle), 2 * math.pi))
            if min(abs(crab - critical), abs(math.pi - crab - critical)) < NEAR_CRITICAL:
                weight[m] = NEAR_CRITICAL_COST
        return weight

    def _side(self, s1: float, d1: Array, s2: float, d2: Array) -> Array:
        """Cost of straight sides between places."""
        length = np.hypot(s2 - s1, d2 - d1)
        part = np.array([0.25, 0.5, 0.75, 1.0])
        s = np.broadcast_to(s1 + part * (s2 - s1), (*d1.shape, 4))
        d = d1[..., None] + part * (d2 - d1)[..., None]
        return np.asarray(length * self.survey.cost[self.survey._at(s, d)].mean(axis=-1) + OFF_LINE * (s2 - s1) * np.abs(d2))

    def way(self) -> Way | None:
        """Forward through the layers, then back along what was cheapest."""
        best, trail = self._first()
        trails = [trail]
        for layer in range(1, self.region.layers):
            best, trail = self._next(best, layer)
            trails.append(trail)
            if not np.isfinite(best).any():
                break
        if not np.isfinite(best).any():
            return None
        end = int(best.argmin())
        return self._told(trails, *divmod(end, best.shape[1]))

    def _first(self) -> tuple[Array, NDArray[np.intp]]:
        """From the body's own place, which is between places, to the first layer: (place, direction)."""
        off, count = np.full(self.region.places, self.region.off), self.angles.size
        angle = np.arctan2(self.across - self.region.off, LAYER)
        cost = self._side(0.0, off, LAYER, self.across)
        turn = np.abs(angle - self.offset)
        cost = cost + np.where(turn < SAME, 0.0, BEND + BEND_PER_RAD * turn)
        cost[np.abs(angle) > math.radians(60.0)] = np.inf
        for course in self.refused:
            cost[np.abs(angle - course) < REFUSED] = np.inf
        best = np.full((self.region.places, count), np.inf)
        nearest = np.abs(angle[:, None] - self.angles[None, : len(STEPS_ACROSS)]).argmin(axis=1)
        best[np.arange(self.region.places), nearest] = cost
        trail = np.full(best.shape, -1, dtype=np.intp)
        if self.sideways:
            self._slide_from_body(best, trail)
        return best, trail

    def _slide_from_body(self, best: Array, trail: NDArray[np.intp]) -> None:
        """Sideways from where the body stands, before the first layer, then straight on into it."""
        off = self.region.off
        for sign, m in ((1, len(STEPS_ACROSS)), (-1, len(STEPS_ACROSS) + 1)):
            if any(abs(float(self.angles[m]) - course) < REFUSED for course in self.refused):
                continue
            turn = abs(float(self.angles[m]) - self.offset)
            walked = (BEND + BEND_PER_RAD * turn) if turn > SAME else 0.0
            place = off
            order = np.flatnonzero((self.across - off) * sign > 1e-9)
            for k in order if sign > 0 else order[::-1]:
                walked += float(self._side(0.0, np.array([place]), 0.0, self.across[k : k + 1])[0]) * self.weight[m]
                place = float(self.across[k])
                if not math.isfinite(walked):
                    break
                onward = float(self._side(0.0, np.array([place]), LAYER, self.across[k : k + 1])[0])
                total = walked + float(self.bend[m, 0]) + onward
                if total < best[k, 0]:
                    best[k, 0], trail[k, 0] = total, -2 - m

    def _next(self, best: Array, layer: int) -> tuple[Array, NDArray[np.intp]]:
        """One layer on: cheapest cost and where it came from, as place * directions + direction."""
        s1, s2, count, places = layer * LAYER, (layer + 1) * LAYER, self.angles.size, self.region.places
        if self.sideways:
            best, slid = self._slid(best, s1)
        onto, trail = np.full((places, count), np.inf), np.full((places, count), -1, dtype=np.intp)
        for m, shift in enumerate(STEPS_ACROSS):
            arrived = best + self.bend[:, m]
            came = arrived.argmin(axis=1)
            least = arrived[np.arange(places), came]
            source = np.arange(max(0, -shift), min(places, places - shift))
            target = source + shift
            side = self._side(s1, self.across[source], s2, self.across[target]) * self.weight[m]
            onto[target, m] = least[source] + side
            trail[target, m] = source * count + came[source]
        if self.sideways:
            self._slides[layer] = slid
        return onto, trail

    @property
    def _slides(self) -> dict[int, NDArray[np.intp]]:
        found: dict[int, NDArray[np.intp]] = self.__dict__.setdefault("_slides_made", {})
        return found

    def _slid(self, best: Array, s: float) -> tuple[Array, NDArray[np.intp]]:
        """Sideways moves within a layer, one place at a time to the left and to the right."""
        best, places, count = best.copy(), self.region.places, self.angles.size
        slid = np.full((places, 2), -1, dtype=np.intp)
        for sign, m in ((1, len(STEPS_ACROSS)), (-1, len(STEPS_ACROSS) + 1)):
            order = range(places) if sign > 0 else range(places - 1, -1, -1)
            here = np.asarray(list(order)[:-1])
            sides = self._side(s, self.across[here], s, self.across[here + sign]) * self.weight[m]
            for side, k in zip(sides, here, strict=True):
                arrived = best[k] + self.bend[:, m]
                came = int(arrived.argmin())
                cost = arrived[came] + side
                if cost < best[k + sign, m]:
                    best[k + sign, m] = cost
                    slid[k + sign, 0 if sign > 0 else 1] = k * count + came
        return best, slid

    def _told(self, trails: list[NDArray[np.intp]], place: int, m: int) -> Way:
        """The corners from the body on, sides of one direction joined."""
        count, points = self.angles.size, list[tuple[float, float]]()
        for layer in range(len(trails), 0, -1):
            s = layer * LAYER
            points.append((s, float(self.across[place])))
            came = int(trails[layer - 1][place, m])
            if came <= -2:
                points.append((0.0, float(self.across[place])))
            elif came >= 0:
                place, m = divmod(came, count)
                while self.sideways and m >= len(STEPS_ACROSS):
                    points.append((s - LAYER, float(self.across[place])))
                    place, m = divmod(int(self._slides[layer - 1][place, m - len(STEPS_ACROSS)]), count)
        points.reverse()
        corners = _corners((0.0, self.region.off), points)
        first = next((c for c in corners if math.hypot(c[0], c[1] - self.region.off) > ACROSS), corners[-1])
        course = math.atan2(first[1] - self.region.off, first[0])
        if len(corners) == 1 and abs(corners[0][1]) < 1e-9:
            course = _homing(self.region.off)
        return Way(course, corners, all(abs(d) < 1e-9 for _, d in corners))


def _corners(start: tuple[float, float], points: list[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Points of a way without those on a straight side."""
    corners: list[tuple[float, float]] = []
    before = start
    for at, after in zip(points, [*points[1:], None], strict=True):
        if after is not None:
            cross = (at[0] - before[0]) * (after[1] - at[1]) - (at[1] - before[1]) * (after[0] - at[0])
            if abs(cross) < 1e-9 and at != before:
                continue
        if at != before:
            corners.append(at)
            before = at
    return tuple(corners) or (points[-1],)


class _Sums:
    """Sums over rectangles of a grid around every point of it; what lies outside counts as 0."""

    def __init__(self, values: Array) -> None:
        self.shape = values.shape
        self.summed = np.zeros((values.shape[0] + 1, values.shape[1] + 1))
        values.cumsum(axis=0).cumsum(axis=1, out=self.summed[1:, 1:])

    def of(self, window: tuple[int, int, int, int]) -> Array:
        """Sum over columns x1..x2-1 and rows y1..y2-1 from each point."""
        x1, x2, y1, y2 = window
        rows, columns = np.arange(self.shape[0]), np.arange(self.shape[1])
        low, high = (np.clip(rows + v, 0, self.shape[0]) for v in (y1, y2))
        left, right = (np.clip(columns + v, 0, self.shape[1]) for v in (x1, x2))
        above, below = self.summed[high], self.summed[low]
        return np.asarray(above[:, right] - above[:, left] - below[:, right] + below[:, left])


def _most_in(values: Array, window: tuple[int, int, int, int]) -> Array:
    """Largest value over columns x1..x2-1 and rows y1..y2-1 from each point; -inf outside."""
    x1, x2, y1, y2 = window
    out = values
    for axis, first, last in ((1, x1, x2), (0, y1, y2)):
        lines = np.moveaxis(out, axis, 0)
        size = lines.shape[0]
        before, behind = max(0, -first), max(0, last - 1)
        padded = np.pad(lines, ((before, behind), (0, 0)), constant_values=-np.inf)
        most = padded[before + first : before + first + size].copy()
        for shift in range(first + 1, last):
            np.maximum(most, padded[before + shift : before + shift + size], out=most)
        out = np.moveaxis(most, 0, axis)
    return out


def _least_around(values: Array, reach: int) -> Array:
    """Smallest value within ``reach`` samples in rows and columns."""
    return -_most_in(-values, (-reach, reach + 1, -reach, reach + 1))
