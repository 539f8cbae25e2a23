"""Level B1: the route ahead (H §3, §4.4, fig. 14). Checks the commanded course against the map and
goes round what cannot be crossed.

H leaves the method to its ref. 11, which is not at hand. Ours is a shortest path over places of the
body: layers every 0.25 m along the commanded line, places every 0.1 m across it, two body lengths
ahead; ``costmap`` says which places are fit. Bends cost, so the shortest way round is H's
trapezoid: out, along, back to the commanded line. Scarce footholds and the crab angle at which the
margin vanishes cost too. Unknown ground is approached slowly.

The test of a place is necessary, not sufficient: Level B2 may still find no step there. Then
``refused`` names the direction and the next best is taken.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..config import DEFAULT, Navigation
from ..geometry.transforms import Body, seen
from ..protocols import PlanFunction, PlanningJob, SlicedJob, run_to_completion
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Array, Blocked, Command, Point, Reason, Stance, StepPlan
from .costmap import ACROSS, LAYER, Costmap, Region, is_clear, is_plain, weight_of

Corners = tuple[tuple[float, float], ...]

ON_LINE = 0.02  # m; nearer than this the command is walked as it came
GOT_ON = 0.05  # m; a body that gets on by less stays where it is
STAYS_MAX = 4  # steps on one course before another is offered. More: see it mark time
REACHED = 0.12  # m; a corner this near is passed in the next step
NEAR_CRITICAL = math.radians(4.0)  # the margin vanishes at α_c
# places a way may shift from layer to layer: 0, 22, 39 and 58 degrees
SHIFTS = (0, 1, -1, 2, -2, 4, -4)
STEEPEST = math.radians(60.0)  # of a first side; beyond it the body slides sideways
GENTLE = math.radians(22.0)  # back to the line where nothing is in the way
BACK_OVER = 0.75  # m; a way back is never begun shorter than this
REFUSED = math.radians(8.0)  # directions this near to a refused one are refused with it
# m a layer not reached costs: any way through is better, and of dead ends the longest
DEAD_END = 100.0
STOP = -1

_TURNS = [math.atan2(shift * ACROSS, LAYER) for shift in SHIFTS]
# directions a place may be entered in: the shifts, and sideways
_INTO = np.array([*_TURNS, math.pi / 2, -math.pi / 2])
_LEFT = len(SHIFTS)
_RIGHT = len(SHIFTS) + 1


@dataclass(frozen=True, slots=True)
class Stays:
    """Where the body has been since it last got on: for how many steps, and the courses against the
    line that have not led away from there.
    """

    place: tuple[float, float] = (math.inf, math.inf)
    steps: int = 0
    courses: tuple[float, ...] = ()
    body: Body | None = None  # of the stance that was planned from last
    feet: tuple[Point, ...] = ()

    def after(self, stance: Stance, offset: float, got_on: float) -> Stays:
        """The same one step on, the last of them on course ``offset``; a step that is planned anew
        from one stance, for a hand that trembles, is none, and on the line itself none counts.
        """
        if (stance.body, stance.feet) == (self.body, self.feet):
            return self
        x, y = stance.body[:2]
        if math.dist(self.place, (x, y)) > got_on:
            return Stays((x, y), body=stance.body, feet=stance.feet)
        steps = self.steps + (offset != 0.0)
        leads_nowhere = steps > self.steps and steps % STAYS_MAX == 0
        courses = (*self.courses, offset) if leads_nowhere else self.courses
        return Stays(self.place, steps, courses, stance.body, stance.feet)


@dataclass(frozen=True, slots=True)
class RouteState:
    """What Level B1 remembers from step to step: the commanded line, and the corner of the way
    round it is making for.
    """

    asked: tuple[float, float] | None = None  # crab angle and turn rate the line was drawn for
    # x, y where the line begins, and its heading
    line: tuple[float, float, float] = (0.0, 0.0, 0.0)
    aim: tuple[float, float] | None = None  # absolute; None: along the line
    offset: float = 0.0  # rad, course walked against the line
    off_line: float = 0.0  # m, where the body is, to the left of the line
    speed_limit: float = math.inf  # m/s, for ground not seen yet
    way: Corners = ()  # corners of the way ahead, absolute; () when it is the commanded line
    stays: Stays = Stays()  # since when the body has not got on

    @property
    def detours(self) -> bool:
        """True while the walk is off the commanded course on purpose."""
        return self.offset != 0.0 or abs(self.off_line) > ON_LINE


class LocalPlanner:
    """Level B1 between the command and a planner of steps: it asks for the step on a course of its
    own, and for another where there is none.

    ``cautious``: it slows down before unknown ground. ``stretches``: the walker can stretch its
    legs beyond their control reach. Without ``detours`` the command is walked as it comes.
    """

    def __init__(
        self,
        cautious: bool = False,
        stretches: bool = False,
        detours: bool = True,
        settings: Navigation = DEFAULT.navigation,
    ) -> None:
        self.settings = settings
        self.detours = detours
        self.cautious = cautious
        self.stretches = stretches
        self.route = RouteState()
        self._commanded: Command | None = None
        self._heeded = self.route, Command()  # what was answered, and on which route

    def heed(self, command: Command) -> Command:
        """Note the command of this tick; the same, slowed down where the ground ahead is unknown.

        A command that holds ends the line that was walked along.
        """
        if command is self._commanded and self.route is self._heeded[0]:
            return self._heeded[1]  # as in most ticks
        self._commanded = given = command
        if command.holds:
            self.route = RouteState()
        elif self.route.speed_limit < command.speed:
            given = replace(command, speed=self.route.speed_limit)
        self._heeded = self.route, given
        return given

    def plan(
        self,
        steps: PlanFunction,
        machine: Machine,
        stance: Stance,
        command: Command,
        terrain: TerrainMap,
    ) -> PlanningJob:
        """The step on the best course that has one; else the answer for the first course."""
        if not self.detours:
            return steps(stance, command, terrain)
        return self._plan_round(steps, machine, stance, command, terrain)

    def _plan_round(
        self,
        steps: PlanFunction,
        machine: Machine,
        stance: Stance,
        command: Command,
        terrain: TerrainMap,
    ) -> PlanningJob:
        if self._commanded is not None and self._commanded.speed != command.speed:
            command = replace(command, speed=self._commanded.speed)
        refused = self._led_nowhere(stance, machine)
        first: tuple[RouteState, StepPlan | Blocked] | None = None
        for _ in range(max(1, self.settings.courses_max)):
            steered, route, why = yield from routing(
                self.route,
                command,
                stance,
                terrain,
                machine,
                refused,
                self.cautious,
                self.stretches,
                self.settings,
            )
            answer = why or (yield from steps(stance, steered, terrain))
            first = first or (route, answer)
            if isinstance(answer, StepPlan):
                self.route = route
                return answer
            if why is not None or command.turn_rate != 0.0:
                break
            refused.append(route.offset)
        assert first is not None
        self.route = replace(first[0], speed_limit=math.inf)
        if isinstance(first[1], StepPlan) or command.turn_rate != 0.0:
            return first[1]
        return (yield from self._naming_the_bar(first[1], machine, stance, terrain))

    def _led_nowhere(self, stance: Stance, machine: Machine) -> list[float]:
        """Courses against the line on which the body has not got on from where it is."""
        stays = self.route.stays.after(stance, self.route.offset, GOT_ON * machine.size)
        self.route = replace(self.route, stays=stays)
        return list(stays.courses)

    def _naming_the_bar(
        self, answer: Blocked, machine: Machine, stance: Stance, terrain: TerrainMap
    ) -> SlicedJob[Blocked]:
        """A reason for which no leg can step, with what bars the line ahead as the map has it."""
        if answer.reason not in (Reason.NO_WAY_ON, Reason.NO_LEG):
            return answer
        x, y, _, yaw = stance.body
        line = self.route.line
        region = Region.of(line[2] - yaw, *_on_the_line(line, x, y), machine, self.settings)
        costmap = Costmap(region, stance, terrain, machine, self.settings)
        yield weight_of(region, terrain)
        bar = costmap.why()
        if bar.reason is not Reason.NO_WAY_ROUND:
            return answer
        ahead = f"; {bar.facts['distance']:.1f} m ahead {bar.facts['because']}"
        facts = {**answer.facts, "because": f"{answer.facts['because']}{ahead}"}
        return replace(answer, facts=facts)


Routed = tuple[Command, RouteState, Blocked | None]


def plan_route(
    state: RouteState,
    command: Command,
    stance: Stance,
    terrain: TerrainMap,
    machine: Machine,
    refused: Sequence[float] = (),
    cautious: bool = True,
    stretches: bool = True,
    settings: Navigation = DEFAULT.navigation,
) -> Routed:
    """The command to plan the next step with, what to remember, and why nothing works if so.

    ``refused`` are courses against the line (``RouteState.offset``) for which Level B2 has just
    found no step from this very stance. ``cautious``: slow down before unknown ground (no use to a
    walker without an eye). ``stretches``: the walker can stretch its legs beyond their control
    reach (mode ``predictive``). A command that turns is passed on as it is: there is no line to
    come back to.
    """
    known = refused, cautious, stretches, settings
    return run_to_completion(routing(state, command, stance, terrain, machine, *known))


def routing(
    state: RouteState,
    command: Command,
    stance: Stance,
    terrain: TerrainMap,
    machine: Machine,
    refused: Sequence[float],
    cautious: bool,
    stretches: bool,
    settings: Navigation,
) -> SlicedJob[Routed]:
    """``plan_route`` as a job that pauses after each costmap."""
    if command.holds or command.turn_rate != 0.0:
        return command, RouteState(), None
    state = _drawn(state, command, stance)
    along, off = _on_the_line(state.line, stance.body[0], stance.body[1])
    state = replace(state, off_line=off, speed_limit=math.inf)
    course = state.line[2] - stance.body[3]
    region = Region.of(course, along, off, machine, settings)
    if not refused and is_plain(region, stance, terrain):
        return _steered(command, state, stance, region, _homing(off, region, state))
    costmap = None
    way = None
    if not refused:
        toward = 0.0 if state.aim is None else region.seen_from(stance, *state.aim)[1]
        narrow = Region.of(course, along, off, machine, settings, toward)
        if _goes_straight_on(state, off) and is_clear(narrow, stance, terrain, machine):
            yield weight_of(narrow, terrain)
            return _steered(command, state, stance, region, _homing(off, region, state))
        costmap = yield from _looked_at(narrow, stance, terrain, machine, settings)
        way = _as_before(state, stance, region, costmap)
    if costmap is None or way is None:
        costmap = yield from _looked_at(region, stance, terrain, machine, settings)
        way = DetourSearch(costmap).best(state.offset, refused)
    if way.reach < settings.no_way:
        why = costmap.why()
        # no way for legs in their control reach, nor round it: what do they reach at the most?
        if stretches:
            costmap = yield from _looked_at(region, stance, terrain, machine, settings, True)
            way = DetourSearch(costmap).best(state.offset, refused)
        if way.reach < settings.no_way:
            return command, replace(state, aim=None, offset=0.0, way=()), why
    return _steered(command, state, stance, region, way, costmap if cautious else None)


def _goes_straight_on(state: RouteState, off: float) -> bool:
    """True of a body on its line that makes for no corner beside it."""
    return state.aim is None and abs(off) <= ON_LINE


def _looked_at(
    region: Region,
    stance: Stance,
    terrain: TerrainMap,
    machine: Machine,
    settings: Navigation,
    stretched: bool = False,
) -> SlicedJob[Costmap]:
    """The costmap of a region; pauses after it."""
    costmap = Costmap(region, stance, terrain, machine, settings, stretched)
    yield weight_of(region, terrain)
    return costmap


def _drawn(state: RouteState, command: Command, stance: Stance) -> RouteState:
    """The commanded line goes through where the course was last commanded; a change of speed is no
    new course.
    """
    asked = (command.crab_angle, command.turn_rate)
    if state.asked == asked:
        return state
    return RouteState(asked, (stance.body[0], stance.body[1], stance.body[3] + command.crab_angle))


def _on_the_line(line: tuple[float, float, float], x: float, y: float) -> tuple[float, float]:
    """A point as distance along the line and to its left."""
    return seen(line, x, y)


def _as_before(
    state: RouteState, stance: Stance, region: Region, costmap: Costmap
) -> Detour | None:
    """Straight on along the line, or on to the corner made for, as long as nothing has come in
    between.
    """
    if state.aim is None:
        good = abs(region.off) <= ON_LINE and costmap.straight_is_fit()
        return Detour(((region.length, 0.0),), math.inf) if good else None
    s, d = region.seen_from(stance, *state.aim)
    if (
        math.hypot(s, d - region.off) <= REACHED
        or s < -REACHED
        or not np.isfinite(costmap.along(s, d)).all()
    ):
        return None
    return Detour(
        ((s, d), *(region.seen_from(stance, *corner) for corner in state.way[1:])), math.inf
    )


def _homing(off: float, region: Region, state: RouteState) -> Detour:
    """Straight back to the line where nothing is in the way, at the course begun if that is one."""
    if abs(off) <= ON_LINE:
        return Detour(((region.length, 0.0),), math.inf)
    # positive: the course walked leads back already
    begun = -state.offset if off > 0.0 else state.offset
    over = abs(off) / math.tan(begun if math.radians(4.0) < begun <= STEEPEST else GENTLE)
    return Detour(((over if begun > 0.0 else max(over, BACK_OVER), 0.0),), math.inf)


def _steered(
    command: Command,
    state: RouteState,
    stance: Stance,
    region: Region,
    way: Detour,
    costmap: Costmap | None = None,
) -> tuple[Command, RouteState, None]:
    """The command turned to the way's first corner and slowed where little is seen ahead; as it
    came when nothing changes.
    """
    s, d = way.corners[0]
    on_line = abs(region.off) <= ON_LINE and abs(d) < 1e-9
    offset = 0.0 if on_line else math.atan2(d - region.off, s)
    corners = () if on_line else tuple(region.place(stance, *corner) for corner in way.corners)
    state = replace(state, offset=offset, aim=corners[0] if corners else None, way=corners)
    if offset != 0.0 or abs(math.remainder(region.course - command.crab_angle, 2 * math.pi)) > 1e-6:
        command = replace(command, crab_angle=math.remainder(region.course + offset, 2 * math.pi))
    seen = (
        math.inf if costmap is None else costmap.known_ahead(way.corners[:1]) / region.body_length
    )
    if costmap is not None and seen < 1.0:
        slowest = costmap.settings.slowest
        command = replace(command, speed=command.speed * max(slowest, seen))
        state = replace(state, speed_limit=command.speed)
    return command, state, None


class Detour(NamedTuple):
    """A way through the region: its corners after the body's own place, and how far it leads."""

    corners: Corners  # (s, d)
    reach: float  # m along the line to a dead end; inf when it leads through


class DetourSearch:
    """Every way through the region, from its far end back: what it costs from each place, entered
    in each direction.
    """

    def __init__(self, costmap: Costmap) -> None:
        self.costmap = costmap
        self.settings = costmap.settings
        self.region = costmap.region
        self.across: Array = np.asarray(
            (self.region.first + np.arange(self.region.places)) * ACROSS
        )
        self.weight = _critical(
            self.region.course, costmap.machine, self.settings.near_critical_cost
        )
        # [direction in, direction out]
        self.bends = self._bend(_INTO[:, None], np.array(_TURNS)[None, :])
        self._work_back()

    def _bend(self, a: Array, b: Array) -> Array:
        """What a corner between two directions costs."""
        turn = np.abs(a - b)
        cost = self.settings.bend + self.settings.bend_per_rad * turn
        return np.where(turn < math.radians(2.0), 0.0, cost)

    def _work_back(self) -> None:
        """Dynamic programming over (layer, place, direction in); a way may also end anywhere, at a
        price.
        """
        last = self.region.layers - 1
        places = self.region.places
        sides = self._sides()
        self.cost = np.empty((last + 1, places, _INTO.size))
        off = np.abs(self.across)
        ends = np.where(off < 1e-9, 0.0, self.settings.not_back + off)
        self.cost[last] = ends[:, None]
        self.choice = np.full((last, places, _INTO.size), STOP, dtype=np.intp)
        for layer in range(last - 1, -1, -1):
            onward = np.full((places, len(SHIFTS)), np.inf)
            for m, shift in enumerate(SHIFTS):
                here = slice(max(0, -shift), min(places, places - shift))
                there = slice(max(0, shift), min(places, places + shift))
                onward[here, m] = sides[layer, m, here] + self.cost[layer + 1, there, m]
            total = onward[:, None, :] + self.bends[None, :, :]
            best = total.argmin(axis=2)
            least = np.take_along_axis(total, best[:, :, None], axis=2)[:, :, 0]
            dead = DEAD_END * (last - layer)
            self.cost[layer] = np.minimum(least, dead)
            self.choice[layer] = np.where(least < dead, best, STOP)

    def _sides(self) -> Array:
        """(layer, direction, place): cost of the side that leaves a place in a direction."""
        layers = self.region.lead + np.arange(self.region.layers - 1) * LAYER
        s, shift, d = np.meshgrid(layers, np.array(SHIFTS) * ACROSS, self.across, indexing="ij")
        return np.asarray(self._side(s, d, LAYER, shift) * self.weight[: len(SHIFTS), None])

    def _side(self, s: Array, d: Array, along: float, across: Array) -> Array:
        """Cost of straight sides from places (s, d)."""
        part = np.array([0.25, 0.5, 0.75, 1.0])
        cost = self.costmap.cost[
            self.costmap.at(s[..., None] + part * along, d[..., None] + part * across[..., None])
        ]
        return np.asarray(
            np.hypot(along, across) * cost.mean(axis=-1)
            + self.settings.off_line * along * np.abs(d + 0.5 * across)
        )

    def best(self, offset: float, refused: Sequence[float]) -> Detour:
        """The cheapest way from the body's own place, walked so far in direction ``offset``."""
        direct, into, slid = (
            self._direct(offset, refused),
            self._into(),
            self._slid(offset, refused),
        )
        a, b = int(direct.argmin()), int(slid.argmin())
        least = min(float(direct[a]), float(slid[b]))
        lead = self.region.lead
        if least == math.inf:
            return Detour((), 0.0)
        if direct[a] <= slid[b]:
            points, reach = self._on_from(a, int(into[a]))
            return Detour(self._straightened(points, offset, refused), reach)
        points, reach = self._on_from(b, 0)
        d = float(self.across[b])
        return Detour(
            _corners([(0.0, self.region.off), (0.0, d), (lead, d), *points[1:]])[1:], reach
        )

    def _angles(self) -> Array:
        return np.arctan2(self.across - self.region.off, self.region.lead)

    def _into(self) -> NDArray[np.intp]:
        """The direction nearest to the first side's, for every place of the first layer."""
        return np.asarray(np.abs(self._angles()[:, None] - np.array(_TURNS)).argmin(axis=1))

    def _direct(self, offset: float, refused: Sequence[float]) -> Array:
        """By a straight first side to each place of the first layer."""
        off = np.full(self.region.places, self.region.off)
        angles = self._angles()
        into = self._into()
        cost = (
            self._side(np.zeros(off.size), off, self.region.lead, self.across - off)
            * self.weight[into]
        )
        cost += self._bend(angles, np.array(offset)) + self.cost[0, np.arange(off.size), into]
        cost[np.abs(angles) > STEEPEST] = np.inf
        for course in refused:
            cost[np.abs(angles - course) < REFUSED] = np.inf
        return cost

    def _slid(self, offset: float, refused: Sequence[float]) -> Array:
        """First sideways from where the body stands to each place across the line, then straight on
        to the first layer.
        """
        off = self.region.off
        total = np.full(self.region.places, np.inf)
        onward = (
            self._side(
                np.zeros(self.across.size),
                self.across,
                self.region.lead,
                np.zeros(self.across.size),
            )
            + self.cost[0, :, 0]
        )
        for into, beyond in (
            (_LEFT, np.flatnonzero(self.across > off + 1e-9)),
            (_RIGHT, np.flatnonzero(self.across < off - 1e-9)[::-1]),
        ):
            if (
                any(abs(float(_INTO[into]) - course) < REFUSED for course in refused)
                or beyond.size == 0
            ):
                continue
            places = self.across[beyond]
            before = np.concatenate([[off], places[:-1]])
            walked = (
                np.cumsum(self._side(np.zeros(before.size), before, 0.0, places - before))
                * self.weight[into]
            )
            total[beyond] = (
                walked
                + float(self._bend(_INTO[into], np.array(offset)))
                + self.bends[into, 0]
                + onward[beyond]
            )
        return total

    def _on_from(self, place: int, into: int) -> tuple[list[tuple[float, float]], float]:
        """The places from one of the first layer on, and how far along the line they lead."""
        layer = 0
        points = [(self.region.lead, float(self.across[place]))]
        while (
            layer < self.region.layers - 1 and (out := int(self.choice[layer, place, into])) != STOP
        ):
            layer, place, into = layer + 1, place + SHIFTS[out], out
            points.append((self.region.lead + layer * LAYER, float(self.across[place])))
        return points, math.inf if layer == self.region.layers - 1 else points[-1][0]

    def _straightened(
        self, points: list[tuple[float, float]], offset: float, refused: Sequence[float]
    ) -> Corners:
        """The way's corners, the first ones left out as long as the straight way is as good."""
        corners = _corners([(0.0, self.region.off), *points])[1:]
        walked = 0.0
        before = (0.0, self.region.off)
        direction = offset
        first = 0
        for index, (s, d) in enumerate(corners):
            walked += self._straight(before, (s, d), direction)
            before, direction = (s, d), math.atan2(d - before[1], s - before[0])
            course = math.atan2(d - self.region.off, s)
            clear = (
                all(abs(course - other) >= REFUSED for other in refused) and abs(course) <= STEEPEST
            )
            straight = self._straight((0.0, self.region.off), (s, d), offset)
            if clear and straight <= walked + self.settings.worth:
                first = index
        return corners[first:]

    def _straight(
        self, start: tuple[float, float], end: tuple[float, float], direction: float
    ) -> float:
        """Cost of one straight side and of the bend into it."""
        (s1, d1), (s2, d2) = start, end
        length, angle = math.hypot(s2 - s1, d2 - d1), math.atan2(d2 - d1, s2 - s1)
        part = np.arange(1, math.ceil(length / self.costmap.step) + 1) / math.ceil(
            length / self.costmap.step
        )
        d = d1 + part * (d2 - d1)
        cost = float(self.costmap.cost[self.costmap.at(s1 + part * (s2 - s1), d)].mean())
        weight = float(self.weight[int(np.abs(_INTO - angle).argmin())])
        return (
            length * cost * weight
            + self.settings.off_line * (s2 - s1) * float(np.abs(d).mean())
            + float(self._bend(np.array(angle), np.array(direction)))
        )


def _critical(course: float, machine: Machine, cost: float) -> Array:
    """Directions near the crab angle at which the margin vanishes cost more."""
    critical = machine.critical_angle
    weight = np.ones(_INTO.size)
    for m, angle in enumerate(_INTO):
        crab = abs(math.remainder(course + float(angle), 2 * math.pi))
        if min(abs(crab - critical), abs(math.pi - crab - critical)) < NEAR_CRITICAL:
            weight[m] = cost
    return weight


def _corners(points: list[tuple[float, float]]) -> Corners:
    """Points of a way, its two ends included, without those on a straight side."""
    kept = [points[0]]
    for at, after in zip(points[1:], points[2:], strict=False):
        before = kept[-1]
        if (
            abs((at[0] - before[0]) * (after[1] - at[1]) - (at[1] - before[1]) * (after[0] - at[0]))
            > 1e-9
        ):
            kept.append(at)
    return (*kept, points[-1])
