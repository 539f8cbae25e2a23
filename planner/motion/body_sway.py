"""A planned step with the body on a smooth way, swayed into its supports.

The step's decisions stay: who swings, how far the body gets, where feet land. What changes is the
body's way between switching points. Along the course its progress goes through the same places at
the same times with continuous speed; across it the body is led through the gates that this support
and the next ones leave open (``body_path``). Where that asks for more acceleration than the body
may have, or a foot would exceed its speed, the step is given more time, first of all while no leg
swings. Metres, seconds, absolute frame.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Collection, Generator, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..geometry.transforms import (
    XY,
    Body,
    direction,
    point_seen,
    tilt_of,
    turned_back,
    turned_back_by,
)
from ..protocols import Announced, Answer
from ..robot.model import Machine
from ..stability import least_polygon_margin, polygon_margin
from ..terrain.map import TerrainMap
from ..types import Gait, Phase, Point, Stance, StepPlan
from .body_bounds import Bounds, bounds_of, room_ahead
from .body_course import FLAT_MIN, STILL, Course, centre_over, first_swing
from .body_path import (
    OFFSET_MAX,
    Key,
    Knot,
    SupportPhase,
    at,
    lateral_bounds,
    meeting,
    monotone_rates,
    sampled,
    through_gates,
)
from .body_tilt import LEVEL, Lean
from .step_builder import as_feet, as_table, changed
from .swing import between
from .swing_profile import (
    SwingTable,
    as_planned,
    cubic_between,
    legs_on_known_ground,
    smooth_swing,
)

LACK = 0.002  # m of margin that a wait on all feet is taken for, if it brings as much
SPARE = 0.002  # m more than the wanted margin: rounding and what a cubic bends between gates
PATIENCE = 2  # rounds that take the acceleration to go with the square of the time
ROUNDS = 8  # of giving the step more time; after them it is taken as it is
SOONEST = 0.02  # s; a leg that lifts within this of another's landing lifts at once
IN_TIME = 1.002  # a step that should be longer by less is taken as it is
FOREVER = 3.0  # a step is made longer by this factor at most, round by round
BRAKING = 0.8  # of the acceleration a body may have, for slowing down ahead of a slow stretch
UNHURRIED = 0.3  # s on all feet in which the body gets back to where it should lift a leg
STILL_FOOT = (0.0, 0.0, 0.0)  # m/s
BETWEEN = tuple(k / 8 for k in range(1, 8))  # of a stretch, where its reach is looked at
NEAR = 0.025  # m aside of the reference, to which a way is led that leads a leg into something
# what the pieces of the work weigh, in postures looked at: what comes before the first way, and
# each way on open ground and among tall things, and what it meets there
BEGINNING, WAY, WAY_AMONG_TALL, MEETINGS = 20, 20, 50, 75
STOPPED_BY = 0.6  # of a step's time; an offset that cannot be stopped by then is led back at once

_Slices = Generator[Announced, object, Answer]


class Motion(NamedTuple):
    """Where a body is, and how it moves, leans and leans over."""

    body: Body
    rate: Body  # m/s and rad/s
    lean: Lean = LEVEL
    leaning: Lean = LEVEL  # m per m and second


class Stop(NamedTuple):
    """How a body that is thrown off its course is stopped first."""

    onward: float  # m of its reference a second that it keeps, where its way allows
    acceleration: float  # m/s², by which the rest of its motion is stopped

    def seconds(self, rate: XY) -> float:
        """How long a motion takes to be over, s."""
        return math.hypot(*rate) / self.acceleration


def swaying(
    plan: StepPlan,
    stance: Stance,
    ahead: Sequence[SupportPhase],
    gait: Gait,
    machine: Machine,
    terrain: TerrainMap | None = None,
) -> _Slices[StepPlan]:
    """The plan with the body on its smooth way from where ``stance`` has it: a job that pauses
    before each piece of its work.

    ``ahead`` are the supports expected after the step, times counted from its end. On a ``terrain``
    legs come down gently only where it is known, and the body sways into nothing tall. A body that
    leans sways along its floor.
    """
    if not gait.sways:
        return plan
    yield Announced(BEGINNING)
    bounds = bounds_of(stance, gait)
    course = Course.of(plan, stance, machine, terrain)
    known: Collection[int] = () if terrain is None else legs_on_known_ground(plan, terrain)
    swing = smooth_swing(plan, machine, known) if gait.smooth else as_planned(plan)
    yield _weight_of_a_way(course)
    table = _Table.of(swing, course, stance, bounds)
    task = _Task(course, stance, ahead, bounds, machine, _expected(course, ahead, bounds))
    way = yield from _within_reach(task, table)
    if table.lift == 0 and course.after and way.margin(machine) < bounds.margin - LACK:
        seconds = math.hypot(*stance.velocity) / bounds.acceleration
        wait = table.after_a_wait(max(seconds, UNHURRIED) + SOONEST, 0.0)
        waited = yield from _within_reach(task, wait)
        if waited.margin(machine) > way.margin(machine) + LACK:
            way = waited
    clear = yield from _clear_of_tall(task, table, way)
    return clear.plan(plan, gait.smooth, machine)


class _Task(NamedTuple):
    """What a way is to be found for."""

    course: Course
    stance: Stance
    ahead: Sequence[SupportPhase]
    bounds: Bounds
    machine: Machine
    gates: Sequence[Key]  # from the end of the step on, times from there
    stop: Stop | None = None

    @property
    def weight(self) -> Announced:
        """What working out one way weighs."""
        return _weight_of_a_way(self.course)


def _weight_of_a_way(course: Course) -> Announced:
    return Announced(WAY_AMONG_TALL if course.is_among_tall else WAY)


def _within_reach(task: _Task, table: _Table) -> _Slices[_Way]:
    """The way through a step that leads no standing foot beyond its leg's reach: where a body is
    thrown too far off its course, that is stopped first, as soon as its margin allows.
    """
    best = yield from _in_time(task, table)
    least = best.beyond_reach()
    if least <= 0.0:
        return best
    for stop in _stops(task):
        seconds = stop.seconds(task.stance.velocity) + UNHURRIED
        stopping = task._replace(stop=stop)
        way = yield from _in_time(stopping, table.on_all_feet_for(seconds))
        beyond = way.beyond_reach()
        if beyond < least:
            best = way
            least = beyond
        if beyond <= 0.0:
            break
    return best


def _clear_of_tall(task: _Task, table: _Table, way: _Way) -> _Slices[_Way]:
    """The way, or where a leg is led into something tall on it one nearer to the reference, which
    keeps the margin as well; at last without heed of the supports to come.
    """
    least = 0
    if task.course.is_among_tall:
        yield Announced(MEETINGS)
        least = _meetings(way)
    kept = min(way.margin(task.machine), task.bounds.margin) - SPARE
    for aside, ahead in ((NEAR, task.ahead), (0.0, task.ahead), (0.0, ())) if least else ():
        bounds = task.bounds._replace(aside=aside)
        gates = _expected(task.course, ahead, bounds)
        nearer = task._replace(bounds=bounds, ahead=ahead, gates=gates)
        near = yield from _within_reach(nearer, table)
        yield Announced(MEETINGS)
        meetings = _meetings(near)
        if meetings < least and near.margin(task.machine) >= kept:
            way = near
            least = meetings
    return way


def _stops(task: _Task) -> Iterator[Stop]:
    """Ways to stop a body that is thrown off its course, the gentlest first: what throws it aside,
    then all of its motion.
    """
    course = task.course
    stance = task.stance
    bounds = task.bounds
    side = course.sway.side(0.0)
    along = _dot(stance.sway, (side[1], -side[0]))
    place = course.weight_at(course.lifting(0.0), _dot(stance.sway, side), along)
    rooms = []
    for speed_onward in dict.fromkeys((max(_speed_onward(course, stance), 0.0), 0.0)):
        thrown = _thrown(course, stance, speed_onward)
        speed = math.hypot(*thrown)
        if speed >= STILL:
            ahead = (thrown[0] / speed, thrown[1] / speed)
            rooms.append((speed_onward, room_ahead(course.before, place, ahead)))
    most = bounds.steepest(min((room for _, room in rooms), default=0.0))
    for speed_onward, _ in rooms:
        for acceleration in sorted({min(2.0 * bounds.acceleration, most), most}):
            yield Stop(speed_onward, acceleration)


def _in_time(task: _Task, table: _Table) -> _Slices[_Way]:
    """The way through a step that takes as long as body and feet need."""
    even = None
    for k in range(ROUNDS):
        yield task.weight
        way = even or _Way.through(task, table)
        before, after = way.hurries(task.bounds, task.machine)
        hurry = max(before, after)
        hurry = hurry if k > PATIENCE else math.sqrt(hurry)
        feet = way.foot_hurry(task.machine)
        if max(hurry, feet) <= IN_TIME:
            break
        on_all_feet = hurry > feet and before >= after
        even = None
        if on_all_feet and task.stop is None:
            yield task.weight
            even = _evened(task, way)
        if even is None:
            table = table.slower(min(max(hurry, feet), FOREVER), on_all_feet)
        else:
            table = even.table
    return way


def _evened(task: _Task, way: _Way) -> _Way | None:
    """The way with no more time on all feet than the body's speed needs to go over evenly to that
    of the rest of the step, where that is all it needs: given more, it would have to brake.
    """
    seconds = way.evenly
    if not SOONEST < seconds < way.table.times[way.table.lift] - SOONEST:
        return None
    sooner = _Way.through(task, way.table.on_all_feet_until(seconds))
    return sooner if max(sooner.hurries(task.bounds, task.machine)) <= IN_TIME else None


@dataclass(frozen=True, slots=True)
class _Table:
    """The knots of a step in time: feet and phases, and how far the body is when a leg lifts."""

    times: list[float]
    feet: list[list[Point]]
    foot_rates: list[list[Point]]  # m/s
    phases: tuple[Phase, ...]
    lift: int  # the knot at which a leg lifts; the last where none does
    lift_length: float  # of the reference, m

    @classmethod
    def of(cls, swing: SwingTable, course: Course, stance: Stance, bounds: Bounds) -> _Table:
        """A plan's knots; before a leg that lifts at once, time on all feet where the body is not
        over its support yet.
        """
        times, feet, rates, phases = swing
        first = first_swing(phases)
        lift = len(phases) if first is None else first
        table = cls(times, feet, rates, tuple(phases), lift, course.lift_length)
        course.turn_to_safety(bounds.margin)
        if times[lift] > SOONEST:
            return table
        missing = _missing(course, stance.sway, bounds.margin)
        if missing <= SPARE:
            return table
        seconds = math.sqrt(6.0 * missing / bounds.acceleration)
        speed = math.hypot(*stance.velocity)
        onward = course.within_reach(min(0.5 * speed * seconds, 0.5 * course.length))
        return table.after_a_wait(seconds, onward)

    def with_times(self, times: Sequence[float]) -> _Table:
        """The same with knots at these times too, where there are none within ``SOONEST``."""
        table = self
        for time in times:
            k = bisect_right(table.times, time)
            near = table.times[max(k - 1, 0) : k + 1]
            if 0 < k < len(table.times) and min(abs(time - t) for t in near) > SOONEST / 2:
                table = table._with_knot(k, time)
        return table

    def _with_knot(self, k: int, time: float) -> _Table:
        """The same with one more knot before knot k."""
        begin, end = self.times[k - 1 : k + 1]
        share = (time - begin) / (end - begin)
        ends = zip(
            self.feet[k - 1], self.feet[k], self.foot_rates[k - 1], self.foot_rates[k], strict=True
        )
        places = [
            (a, first)
            if a == b and first == last == STILL_FOOT
            else cubic_between(a, b, first, last, end - begin, share)
            for a, b, first, last in ends
        ]
        return _Table(
            [*self.times[:k], time, *self.times[k:]],
            [*self.feet[:k], [place for place, _ in places], *self.feet[k:]],
            [*self.foot_rates[:k], [rate for _, rate in places], *self.foot_rates[k:]],
            (*self.phases[:k], *self.phases[k - 1 :]),
            self.lift + (k <= self.lift),
            self.lift_length,
        )

    def slower(self, factor: float, on_all_feet: bool) -> _Table:
        """More time: for what is done on all feet only, or for the whole step."""
        last = self.lift if on_all_feet and self.lift > 0 else len(self.times) - 1
        more = self.times[last] * (factor - 1.0)
        times = [t * factor if k <= last else t + more for k, t in enumerate(self.times)]
        rates = [
            [(x / factor, y / factor, z / factor) for x, y, z in row] if k <= last else row
            for k, row in enumerate(self.foot_rates)
        ]
        return replace(self, times=times, foot_rates=rates)

    def on_all_feet_until(self, seconds: float) -> _Table:
        """The same with a leg that lifts so many seconds after the beginning."""
        return self.slower(seconds / self.times[self.lift], on_all_feet=True)

    def on_all_feet_for(self, seconds: float) -> _Table:
        """The same with so much time on all feet at least before a leg lifts."""
        missing = seconds - self.times[self.lift]
        return self if missing <= 0.0 else self.after_a_wait(missing + SOONEST, self.lift_length)

    def after_a_wait(self, seconds: float, onward: float) -> _Table:
        """The same after some time on all feet, in which the body gets so far on."""
        return _Table(
            [0.0, *(t + seconds for t in self.times)],
            [self.feet[0], *self.feet],
            [self.foot_rates[0], *self.foot_rates],
            (Phase.SUPPORT, *self.phases),
            self.lift + 1,
            max(onward, self.lift_length),
        )


class _Way:
    """A body's way through a step: progress along the reference, offsets along and across it."""

    __slots__ = (
        "table",
        "course",
        "progress",
        "along",
        "across",
        "thrown",
        "rows",
        "bends",
        "_weights",
        "_least",
    )

    def __init__(
        self,
        table: _Table,
        course: Course,
        progress: list[Knot],
        along: list[Knot],
        across: list[Knot],
        thrown: float = 0.0,
    ) -> None:
        self.course = course
        self.thrown = thrown  # s until what throws the body off its course is stopped
        self.progress = progress  # m of the reference's length
        self.along = along
        self.across = across
        self.table = table.with_times(self.times_within(table.times[-1]))
        self.rows = self.motions(self.table.times)
        self.bends = [
            _accelerations(*ends, after - before) if after > before else (0.0, 0.0)
            for ends, (before, after) in zip(
                pairwise(self.rows), pairwise(self.table.times), strict=True
            )
        ]  # m/s², at both ends of every stretch of the table
        self._weights: dict[int, XY] = {}  # the centre of gravity at knots asked for, m
        self._least: float | None = None  # of its margins, m, when they have been worked out

    @classmethod
    def through(cls, task: _Task, table: _Table) -> _Way:
        """The way through the gates of this step and the next ones."""
        course, stance, ahead, bounds, _, _, stop = task
        side = course.sway.side(0.0)
        forward = side[1], -side[0]
        braking = BRAKING * bounds.acceleration
        speed = _speed_onward(course, stance) if stop is None else stop.onward
        progress = _progress(table, course, speed, ahead, braking)
        rest = _thrown(course, stance, progress[0].rate)
        start = Knot(0.0, _dot(stance.sway, forward), _dot(rest, forward))
        beside = Knot(0.0, _dot(stance.sway, side), _dot(rest, side))
        lift = table.times[table.lift]
        back = lift if lift > UNHURRIED else table.times[-1]
        if stop is None:
            seconds = 0.0
            along = _coming_back(start, back, braking)
            gates = _near(_gates(task, table, along), bounds.aside)
            across = through_gates(beside, gates)
            inner = _gate_between(task, table, (progress, along, across))
            if inner is not None:
                across = through_gates(beside, sorted([*gates, inner]))
        else:
            seconds = stop.seconds(rest)
            along = [start, _stopped(start, seconds), Knot(back, 0.0, 0.0)]
            gates = _gates(task, table, along)
            across = [beside, *through_gates(_stopped(beside, seconds), gates)]
        return cls(table, course, progress, along, across, seconds)

    def times_within(self, end: float) -> list[float]:
        """Of its knots within the step, s; nearer ones than ``SOONEST`` are one."""
        out = [0.0]
        for time in sorted(knot.time for knot in (*self.progress, *self.along, *self.across)):
            if out[-1] + SOONEST < time < end - SOONEST:
                out.append(time)
        return [*out, end]

    def motions(self, times: Sequence[float]) -> list[Motion]:
        """Where the body is at times in order and how it moves: m/s along absolute x, y and z, and
        rad/s.
        """
        ways = (sampled(way, times) for way in (self.progress, self.along, self.across))
        course = self.course
        sway = course.sway
        turning = sway.turning
        sx, sy = sway.side(0.0)
        out = []
        for (length, rate), (along, along_rate), (aside, aside_rate) in zip(*ways, strict=True):
            (x, y, z, yaw), (onward, left, climb, turn) = course.motion(length)
            if turning != 0.0:
                sx, sy = sway.side(length)
            ox = sx * aside + sy * along
            oy = sy * aside - sx * along
            spin = turning * rate  # the offsets turn with the course
            motion = Motion(
                (x + sx * aside + sy * along, y + sy * aside - sx * along, z, yaw),
                (
                    onward * rate + sx * aside_rate + sy * along_rate - spin * oy,
                    left * rate + sy * aside_rate - sx * along_rate + spin * ox,
                    climb * rate,
                    turn * rate,
                ),
            )
            out.append(motion)
        return self._along_the_floor(times, out) if course.leaning else out

    def _along_the_floor(self, times: Sequence[float], rows: Sequence[Motion]) -> list[Motion]:
        """The same of a body that leans: its offsets go along its floor."""
        course = self.course
        last = self.table.times[-1]
        (bx, by), _, (ex, ey) = course.leans
        leaning = (ex - bx) / last, (ey - by) / last
        out = []
        ways = sampled(self.progress, times), rows
        for time, (length, rate), ((x, y, z, yaw), (vx, vy, vz, turn), *_) in zip(
            times, *ways, strict=True
        ):
            lean = course.lean_at(time / last)
            (rx, ry, _, _), (onward, left, _, _) = course.motion(length)
            off = x - rx, y - ry
            drift = vx - onward * rate, vy - left * rate
            body = x, y, z + _dot(lean, off), yaw
            climb = vz + _dot(lean, drift) + _dot(leaning, off)
            out.append(Motion(body, (vx, vy, climb, turn), lean, leaning))
        return out

    def hurries(self, bounds: Bounds, machine: Machine) -> XY:
        """The most by which the body speeds up or slows down, over what it may where it is then:
        before a leg lifts, and after. More than 1: the step should be longer.

        It is looked at where the cubics from one knot of the table to the next begin and end:
        between them it is less, and the body no nearer to an edge than at one of them.
        """
        times = self.table.times
        lift = self.table.lift
        limit = bounds.acceleration
        most = [0.0, 0.0]
        start = self.thrown + SOONEST / 2
        for k, bends in enumerate(self.bends):
            end = times[k + 1]
            if end <= start or end - times[k] < STILL:
                continue
            lifted = k >= lift
            for knot, acceleration in enumerate(bends, k):
                share = acceleration / limit
                if share <= most[lifted]:
                    continue
                if share > 1.0:
                    margin = self._margin_at(knot, lifted, machine)
                    share = max(most[lifted], acceleration / bounds.brisk(margin))
                most[lifted] = share
        return most[0], most[1]

    @property
    def evenly(self) -> float:
        """How long the body should take on all feet so that its speed goes evenly over from what it
        has to that of the rest of the step, s; 0 where no leg lifts.
        """
        table = self.table
        lift = table.times[table.lift]
        swinging = table.times[-1] - lift
        if table.lift == 0 or swinging < SOONEST:
            return 0.0
        later = (self.course.length - table.lift_length) / swinging
        return 2.0 * table.lift_length / max(self.progress[0].rate + later, STILL)

    def _margin_at(self, knot: int, lifted: bool, machine: Machine) -> float:
        """The polygon margin at a knot of the table with the leg lifted or not yet, m."""
        polygon = self.course.after if lifted and self.course.after else self.course.before
        return polygon_margin(polygon, *self._weight_at(knot, machine))

    def _weight_at(self, knot: int, machine: Machine) -> XY:
        """Where the centre of gravity is at a knot of the table, absolute axes, m."""
        weight = self._weights.get(knot)
        if weight is None:
            body, _, lean, _ = self.rows[knot]
            dx, dy = centre_over(machine, body, self.table.feet[knot], lean)
            self._weights[knot] = weight = (body[0] + dx, body[1] + dy)
        return weight

    def foot_hurry(self, machine: Machine) -> float:
        """Speed of the fastest foot against the body, over its limit."""
        return _fastest_foot(self.table, self.rows, machine)

    def beyond_reach(self) -> float:
        """How far the body is led beyond what the standing legs reach, m; not positive where it is
        within.
        """
        if _is_well_within_reach(self):
            return 0.0
        most = -math.inf
        table = self.table
        beyond = self.course.beyond
        knots = zip(table.times, self.rows, strict=True)
        first = beyond(self.rows[0].body, table.lift == 0, self.rows[0].lean)
        for k, ((a, before), (b, after)) in enumerate(pairwise(knots)):
            lifted = k >= table.lift
            if k == table.lift:
                first = beyond(before.body, lifted, before.lean)
            last = beyond(after.body, lifted, after.lean)
            farther = max(first, last)
            first = last
            most = max(most, farther)
            if farther + max(self.bends[k]) * (b - a) ** 2 / 8.0 <= 0.0:
                continue
            inner = (_between(before, after, b - a, share) for share in BETWEEN)
            most = max(most, *(beyond(body, lifted, after.lean) for body in inner))
        return most

    def plan(self, plan: StepPlan, curved: bool, machine: Machine) -> StepPlan:
        """The step on this way; feet go straight between knots unless they are ``curved``."""
        table = self.table
        rows = self.rows
        x, y, _, _ = plan.end.body
        place, rate, _, _ = rows[-1]
        end = replace(plan.end, sway=(place[0] - x, place[1] - y), velocity=rate[:2])
        return changed(
            plan,
            times=np.array(table.times),
            body=as_table([row.body for row in rows]),
            feet=as_feet(table.feet),
            foot_rates=as_feet(table.foot_rates) if curved else None,
            phases=table.phases,
            rates=as_table([row.rate for row in rows]),
            end=end,
            polygon_margin_min=self.margin(machine),
        )

    def margin(self, machine: Machine) -> float:
        """Least polygon margin at the knots, m."""
        if self._least is None:
            lift = self.table.lift
            course = self.course
            last = len(self.rows) - 1 if course.after else min(lift, len(self.rows) - 1)
            weights = [self._weight_at(knot, machine) for knot in range(last + 1)]
            least = least_polygon_margin(course.before, weights[: lift + 1])
            if course.after:
                least = min(least, least_polygon_margin(course.after, weights[lift:]))
            self._least = least
        return self._least


def _is_well_within_reach(way: _Way) -> bool:
    """True where a level body that does not turn is surely led to where all standing legs reach: at
    every knot, and by as much as its cubics bend between them.
    """
    times, lift, course = way.table.times, way.table.lift, way.course
    if course.leaning or course.turns:
        return False
    stretches = zip(pairwise(times), way.bends, strict=True)
    spare = max([max(ends) * (b - a) ** 2 / 8.0 for (a, b), ends in stretches]) + STILL
    bodies = [row.body for row in way.rows]
    if lift and not course.keeps_within(bodies[: lift + 1], lifted=False, spare=spare):
        return False
    return lift >= len(bodies) - 1 or course.keeps_within(bodies[lift:], lifted=True, spare=spare)


def _meetings(way: _Way) -> int:
    """At how many of a way's knots, and places between them, a leg is in something tall."""
    bodies = [row.body for row in way.rows]
    feet = list(way.table.feet)
    rows = zip(pairwise(way.table.times), pairwise(way.rows), pairwise(way.table.feet), strict=True)
    for (begin, end), (before, after), (first, last) in rows:
        bodies.append(_between(before, after, end - begin, 0.5))
        feet.append([between(a, b, 0.5) for a, b in zip(first, last, strict=True)])
    return sum(way.course.is_met(body, tips) for body, tips in zip(bodies, feet, strict=True))


def _between(before: Motion, after: Motion, seconds: float, share: float) -> Body:
    """The body after a share of the cubic from one motion to another."""
    left = 1.0 - share
    first = left * left * (1.0 + 2.0 * share)
    last = share * share * (1.0 + 2.0 * left)
    out = share * left * left * seconds
    back = -share * share * left * seconds
    x, y, z, yaw = (
        first * p + last * q + out * a + back * b
        for p, q, a, b in zip(before.body, after.body, before.rate, after.rate, strict=True)
    )
    return x, y, z, yaw


def _accelerations(before: Motion, after: Motion, seconds: float) -> XY:
    """Those over the ground at both ends of the cubic between two motions, m/s²."""
    (x, y, _, _), (begin_x, begin_y, _, _), _, _ = before
    (to_x, to_y, _, _), (end_x, end_y, _, _), _, _ = after
    mean_x = 3.0 * ((to_x - x) / seconds)
    mean_y = 3.0 * ((to_y - y) / seconds)
    first = math.hypot(
        2.0 * (mean_x - 2.0 * begin_x - end_x) / seconds,
        2.0 * (mean_y - 2.0 * begin_y - end_y) / seconds,
    )
    last = math.hypot(
        2.0 * (begin_x + 2.0 * end_x - mean_x) / seconds,
        2.0 * (begin_y + 2.0 * end_y - mean_y) / seconds,
    )
    return first, last


def _missing(course: Course, sway: XY, margin: float) -> float:
    """How far the body is from keeping a margin over its next support, m, at the beginning."""
    side = course.sway.side(0.0)
    along = _dot(sway, (side[1], -side[0]))
    aside = _dot(sway, side)
    now = course.lifting(0.0)
    low, high = course.bounds_at(now, course.after, margin, along)
    missing = max(low - aside, aside - high)
    if low == high and course.margin_at(now, low, along) < margin - SPARE:
        return max(missing, abs(along))
    return missing


def _fastest_foot(table: _Table, rows: Sequence[Motion], machine: Machine) -> float:
    """Speed of the fastest foot of a table, seen from a body that moves so, over its limit."""
    limit_x, limit_y, limit_z = machine.speed
    most = 0.0
    faces: float | None = None
    c = s = 0.0
    for feet, rates, motion in zip(table.feet, table.foot_rates, rows, strict=True):
        (_, _, _, yaw), (vx, vy, vz, turn), lean, leaning = motion
        if turn != 0.0 or lean != LEVEL or leaning != LEVEL:
            most = max(most, _fastest_from_turning(feet, rates, motion, machine))
            continue
        if yaw != faces:
            faces = yaw
            c, s = direction(yaw)
        for ux, uy, uz in {*rates}:  # all that stand are equally fast
            wx = ux - vx
            wy = uy - vy
            ahead = abs(c * wx + s * wy) / limit_x
            aside = abs(c * wy - s * wx) / limit_y
            up = abs(uz - vz) / limit_z
            if ahead > most:
                most = ahead
            if aside > most:
                most = aside
            if up > most:
                most = up
    return most


def _fastest_from_turning(
    feet: Sequence[Point], rates: Sequence[Point], motion: Motion, machine: Machine
) -> float:
    """The same of feet with these velocities, seen from a body that turns or leans."""
    (x, y, _, yaw), (vx, vy, vz, turn), lean, leaning = motion
    c, s = direction(yaw)
    leans = lean != LEVEL or leaning != LEVEL
    most = 0.0
    for foot, rate in zip(feet, rates, strict=True):
        wx = rate[0] - vx + turn * (foot[1] - y)
        wy = rate[1] - vy - turn * (foot[0] - x)
        velocity = c * wx + s * wy, c * wy - s * wx, rate[2] - vz
        if leans:
            velocity = _seen_leaning(motion, foot, velocity)
        most = max(most, *map(_share, velocity, machine.speed))
    return most


def _share(speed: float, limit: float) -> float:
    """Of a limit, that a speed makes up."""
    return abs(speed) / limit


def _seen_leaning(motion: Motion, foot: Point, velocity: Point) -> Point:
    """The velocity of a foot in the axes of a body that leans and leans over, from that in those
    of a level one; first order in how fast it leans over.
    """
    yaw = motion.body[3]
    px, py, pz = point_seen(motion.body, foot)
    climb, roll = turned_back(*motion.leaning, yaw)
    ahead, aside, up = velocity
    seen = ahead + climb * pz, aside + roll * pz, up - roll * py - climb * px
    return turned_back_by(tilt_of(motion.lean, yaw), seen)


def _dot(vector: XY, along: XY) -> float:
    """A vector's part along a direction."""
    return vector[0] * along[0] + vector[1] * along[1]


def _speed_onward(course: Course, stance: Stance) -> float:
    """How fast the body goes along its reference at the beginning, m of its length a second."""
    onward, flat = course.sets_out
    return _dot(stance.velocity, onward) / flat if flat > FLAT_MIN else 0.0


def _thrown(course: Course, stance: Stance, gone: float) -> XY:
    """The velocity that is left of the body's when it goes along its reference so fast, m/s."""
    onward, flat = course.sets_out
    spin = course.sway.turning * gone
    return (
        stance.velocity[0] - gone * flat * onward[0] + spin * stance.sway[1],
        stance.velocity[1] - gone * flat * onward[1] - spin * stance.sway[0],
    )


def _stopped(start: Knot, seconds: float) -> Knot:
    """Where an offset is that is stopped evenly in so many seconds."""
    return Knot(seconds, start.value + start.rate * seconds / 2.0, 0.0)


def _coming_back(start: Knot, end: float, acceleration: float) -> list[Knot]:
    """The way of an offset back to 0 by a time, s: it is stopped first where there is time."""
    knots = [start]
    stopped = abs(start.rate) / acceleration
    if SOONEST < stopped < STOPPED_BY * end:
        knots.append(_stopped(start, stopped))
    return [*knots, Knot(end, 0.0, 0.0)]


def _expected(course: Course, ahead: Sequence[SupportPhase], bounds: Bounds) -> list[Key]:
    """The gates at the end of a step and of what is expected after it; times from its end."""
    margin = bounds.margin + SPARE
    keys: list[Key] = []
    if course.after:
        keys.append(Key(0.0, *course.bounds_at(course.landing, course.after, margin)))
    elif ahead:
        keys.append(Key(0.0, *course.in_reach(course.shifted)))
    side = course.sway.leverage(course.length)
    dx, dy = course.landing.centre
    for support in ahead:
        places = ((support.lift, support.at_lift), (support.land, support.at_land))
        for time, (x, y) in places:
            bounds_then = lateral_bounds(support.polygon, x + dx, y + dy, side, margin)
            keys.append(Key(time, *bounds_then))
    return keys


def _gates(task: _Task, table: _Table, along: Sequence[Knot]) -> list[Key]:
    """The gates of the step and of what is expected after it."""
    course = task.course
    last = table.times[-1]
    keys: list[Key] = []
    lift = table.times[table.lift]
    if course.after and lift > SOONEST:
        off = at(along, lift).value
        when = course.lifting(table.lift_length)
        margin = task.bounds.margin + SPARE
        both = course.all_bounds_at(when, (course.before, course.after), margin, off)
        keys.append(Key(lift, *meeting(*both)))
    for time, low, high in task.gates:
        _add(keys, last + time, (low, high))
    return keys or [Key(last, 0.0, 0.0)]


def _near(gates: list[Key], aside: float) -> list[Key]:
    """The gates with what is nearer to the reference left open, where anything is."""
    if aside >= OFFSET_MAX:
        return gates
    return [Key(time, *meeting((low, high), (-aside, aside))) for time, low, high in gates]


def _gate_between(
    task: _Task, table: _Table, ways: tuple[Sequence[Knot], Sequence[Knot], Sequence[Knot]]
) -> Key | None:
    """The gate halfway between a leg's lift and its landing, where the way found without it leaves
    less than the margin; None where it keeps that, or no leg lifts.
    """
    course = task.course
    begin = table.times[table.lift]
    seconds = (begin + table.times[-1]) / 2.0
    if not course.after or seconds - begin <= SOONEST:
        return None
    length, along, aside = (at(way, seconds).value for way in ways)
    when = course.halfway(length)
    if course.margin_at(when, aside, along) >= task.bounds.margin:
        return None
    return Key(seconds, *course.bounds_at(when, course.after, task.bounds.margin + SPARE, along))


def _add(keys: list[Key], time: float, bounds: XY) -> None:
    """Add what is open at an instant; gates of one instant become one."""
    if keys and abs(keys[-1].time - time) < SOONEST:
        keys[-1] = Key(keys[-1].time, *meeting((keys[-1].low, keys[-1].high), bounds))
    else:
        keys.append(Key(time, *bounds))


def _progress(
    table: _Table, course: Course, speed: float, ahead: Sequence[SupportPhase], acceleration: float
) -> list[Knot]:
    """Length of the reference behind the body, through the places where a leg lifts and lands."""
    times = [0.0, table.times[-1]]
    values = [0.0, course.length]
    if 0 < table.lift < len(table.times) - 1:
        times.insert(1, table.times[table.lift])
        values.insert(1, table.lift_length)
    final = (values[-1] - values[-2]) / max(times[-1] - times[-2], SOONEST)
    if ahead:
        onward = math.dist(course.reference[-1][:2], ahead[0].at_land) / max(ahead[0].land, SOONEST)
        final = 2.0 * final * onward / max(final + onward, STILL)
    braking = _braking(max(speed, 0.0), values[1], times[1], acceleration)
    if braking is not None:
        times.insert(1, braking.time)
        values.insert(1, braking.value)
    slope = (values[1] - values[0]) / max(times[1] - times[0], SOONEST)
    rates = monotone_rates(times, values, min(max(speed, 0.0), 3.0 * slope), final)
    if braking is not None:
        rates[1] = braking.rate
    return [Knot(*knot) for knot in zip(times, values, rates, strict=True)]


def _braking(speed: float, length: float, seconds: float, acceleration: float) -> Knot | None:
    """Where a body that is too fast for its next stretch has slowed down to an even speed over the
    rest of it; None where it need not, or cannot.
    """
    excess = speed * seconds - length
    within = seconds * seconds - 2.0 * excess / acceleration
    if excess <= 0.0 or within <= 0.0:
        return None
    time = seconds - math.sqrt(within)
    if not SOONEST < time < seconds - SOONEST or time * acceleration > speed:
        return None
    return Knot(time, speed * time - acceleration * time * time / 2.0, speed - acceleration * time)
