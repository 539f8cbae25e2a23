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
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..geometry.polygons import Polygon
from ..geometry.transforms import XY, Body, direction, point_seen, turned
from ..robot.model import Machine
from ..stability import GRAVITY, polygon_margin, support_polygon
from ..statics import centre_of_gravity
from ..types import Gait, Phase, Point, Stance, StepPlan
from .body_path import (
    OFFSET_MAX,
    Key,
    Knot,
    SupportPhase,
    at,
    largest_acceleration,
    lateral_bounds,
    meeting,
    monotone_rates,
    nearest_edge_normal,
    through_gates,
)
from .step_builder import changed

SPARE = 0.002  # m more than the wanted margin: rounding and what a cubic bends between gates
ROUNDS = 4  # of giving the step more time; after them it is taken as it is
SOONEST = 0.02  # s; a leg that lifts within this of another's landing lifts at once
IN_TIME = 1.002  # a step that should be longer by less is taken as it is
FOREVER = 3.0  # a step is made longer by this factor at most, round by round
BRAKING = 0.8  # of the acceleration a body may have, for slowing down ahead of a slow stretch
STILL = 1e-9  # m; a reference that goes no farther stands


class Bounds(NamedTuple):
    """What a body may do on its way."""

    margin: float  # m, of the polygon
    acceleration: float  # m/s²


def bounds_of(stance: Stance, gait: Gait) -> Bounds:
    """The wanted margin, and the acceleration at which it is just kept: g·m/h."""
    if gait.acceleration > 0.0:
        return Bounds(gait.margin, gait.acceleration)
    ground = min(foot[2] for foot in stance.feet)
    height = max(stance.body[2] - ground, 0.05)
    return Bounds(gait.margin, GRAVITY * max(gait.margin, 0.005) / height)


def swayed(
    plan: StepPlan, stance: Stance, ahead: Sequence[SupportPhase], gait: Gait, machine: Machine
) -> StepPlan:
    """The plan with the body on its smooth way from where ``stance`` has it.

    ``ahead`` are the supports expected after the step, times counted from its end. A plan that
    leans is left as it is.
    """
    if not gait.sways or plan.lean is not None or plan.end.lean != (0.0, 0.0):
        return plan
    bounds = bounds_of(stance, gait)
    course = _Course.of(plan, stance, machine)
    table = _Table.of(plan, course, stance, bounds)
    for _ in range(ROUNDS):
        way = _Way.through(table, course, stance, ahead, bounds, machine)
        hurry = way.hurry(bounds)
        feet = way.foot_hurry(machine)
        if max(hurry, feet) <= IN_TIME:
            break
        on_all_feet = hurry > feet and way.hurries_on_all_feet
        table = table.slower(min(max(hurry, feet), FOREVER), on_all_feet)
    return way.plan(plan)


class _Course:
    """The reference of a step as a polyline, and what carries the machine on its way."""

    def __init__(
        self,
        reference: list[Body],
        crab_angle: float,
        polygons: tuple[Polygon, Polygon],
        centres: tuple[XY, XY],
    ) -> None:
        self.reference = reference
        self.crab_angle = crab_angle
        self.before, self.after = polygons  # of the feet that carry before, and after, a leg lifts
        self.lengths = _lengths(reference)
        # of the centre of gravity from the body when a leg lifts, and at the end, absolute axes
        self.centre_at_lift, self.centre_at_end = centres
        self.aside = math.pi / 2  # rad, from the course to the direction in which the body sways

    @classmethod
    def of(cls, plan: StepPlan, stance: Stance, machine: Machine) -> _Course:
        """That of a plan as it was decided."""
        legs = range(len(stance.feet))
        standing = support_polygon(stance.feet[leg] for leg in legs if leg not in stance.lifted)
        swinging = (
            ()
            if _first_swing(plan) is None
            else support_polygon(stance.feet[leg] for leg in legs if leg not in plan.swing)
        )
        reference = [(b[0], b[1], b[2], b[3]) for b in plan.body.tolist()]
        feet = plan.feet.tolist()
        lift = _first_swing(plan) or 0
        centres = (
            _centre(machine, reference[lift], feet[lift]),
            _centre(machine, reference[-1], feet[-1]),
        )
        return cls(reference, plan.crab_angle, (standing, swinging), centres)

    @property
    def length(self) -> float:
        """Of the whole reference, m."""
        return self.lengths[-1]

    def at(self, length: float) -> Body:
        """The reference after a length of it."""
        k = self._stretch(length)
        a, b = self.reference[k], self.reference[k + 1]
        share = (length - self.lengths[k]) / max(self.lengths[k + 1] - self.lengths[k], STILL)
        share = min(max(share, 0.0), 1.0)
        x, y, z, yaw = (p + share * (q - p) for p, q in zip(a, b, strict=True))
        return x, y, z, yaw

    def heading(self, length: float) -> float:
        """Absolute direction of the course there, rad."""
        return self.at(length)[3] + self.crab_angle

    def per_metre(self, length: float) -> XY:
        """Yaw and climb of the reference per metre of its length, about there."""
        k = self._stretch(length)
        way = self.lengths[k + 1] - self.lengths[k]
        if way <= STILL:
            return 0.0, 0.0
        a, b = self.reference[k], self.reference[k + 1]
        return (b[3] - a[3]) / way, (b[2] - a[2]) / way

    def side(self, length: float) -> XY:
        """Direction in which the body sways there, absolute frame: to the left of its course."""
        return direction(self.heading(length) + self.aside)

    def bounds_at(self, length: float, polygon: Polygon, margin: float) -> XY:
        """The offsets at which the body keeps a margin in a polygon."""
        x, y = self.weight_at(length)
        return lateral_bounds(polygon, x, y, self.side(length), margin)

    def weight_at(self, length: float) -> XY:
        """Where the centre of gravity is above, with the body on the reference there."""
        x, y, _, _ = self.at(length)
        ends = length >= self.length - STILL
        dx, dy = self.centre_at_end if ends else self.centre_at_lift
        return x + dx, y + dy

    def turn_to_safety(self, length: float, margin: float) -> None:
        """Where no offset across the course keeps the margin when a leg lifts, sway away from the
        nearest edge instead, if that is better.
        """
        kept = self._best(length)
        if not self.after or kept >= margin:
            return
        x, y = self.weight_at(length)
        across = self.aside
        nx, ny = nearest_edge_normal(self.after, x, y)
        self.aside = math.atan2(ny, nx) - self.heading(length)
        if self._best(length) <= kept:
            self.aside = across

    def _best(self, length: float) -> float:
        """The most margin an offset leaves when a leg lifts, m."""
        low, high = self.bounds_at(length, self.after, OFFSET_MAX)
        x, y = self.weight_at(length)
        c, s = self.side(length)
        return max(
            (polygon_margin(self.after, x + d * c, y + d * s) for d in (low, high)), default=0.0
        )

    def _stretch(self, length: float) -> int:
        last = len(self.lengths) - 2
        return min(max(bisect_right(self.lengths, length) - 1, 0), last)


def _centre(machine: Machine, body: Body, feet: Sequence[Sequence[float]]) -> XY:
    """The centre of gravity of body and legs from the body's own place, absolute axes."""
    seen = [point_seen(body, (foot[0], foot[1], foot[2])) for foot in feet]
    x, y, _ = centre_of_gravity(machine, seen)
    return turned(x, y, body[3])


def _first_swing(plan: StepPlan) -> int | None:
    """The first stretch in which a leg is in the air on its way."""
    for k, phase in enumerate(plan.phases):
        if phase is not Phase.SUPPORT and phase is not Phase.SHIFT:
            return k
    return None


@dataclass(frozen=True, slots=True)
class _Table:
    """The knots of a step in time: feet and phases, and how far the body is when a leg lifts."""

    times: list[float]
    feet: list[list[Point]]
    phases: tuple[Phase, ...]
    lift: int  # the knot at which a leg lifts; the last where none does
    lift_length: float  # of the reference, m

    @classmethod
    def of(cls, plan: StepPlan, course: _Course, stance: Stance, bounds: Bounds) -> _Table:
        """A plan's knots; before a leg that lifts at once, time on all feet where the body is not
        over its support yet.
        """
        times: list[float] = plan.times.tolist()
        feet: list[list[Point]] = [[(f[0], f[1], f[2]) for f in row] for row in plan.feet.tolist()]
        first = _first_swing(plan)
        lift = len(plan.phases) if first is None else first
        table = cls(times, feet, plan.phases, lift, course.lengths[lift])
        course.turn_to_safety(table.lift_length, bounds.margin)
        if times[lift] > SOONEST:
            return table
        c, s = course.side(0.0)
        aside = c * stance.sway[0] + s * stance.sway[1]
        low, high = course.bounds_at(0.0, course.after, bounds.margin)
        missing = max(low - aside, aside - high)
        if missing <= SPARE:
            return table
        seconds = math.sqrt(6.0 * missing / bounds.acceleration)
        speed = math.hypot(*stance.velocity)
        onward = min(0.5 * speed * seconds, 0.5 * course.length)
        return table.after_a_wait(seconds, onward)

    def slower(self, factor: float, on_all_feet: bool) -> _Table:
        """More time: for what is done on all feet only, or for the whole step."""
        if not on_all_feet or self.lift == 0:
            return replace(self, times=[t * factor for t in self.times])
        more = self.times[self.lift] * (factor - 1.0)
        times = [t * factor if k <= self.lift else t + more for k, t in enumerate(self.times)]
        return replace(self, times=times)

    def after_a_wait(self, seconds: float, onward: float) -> _Table:
        """The same after some time on all feet, in which the body gets so far on."""
        return _Table(
            [0.0, *(t + seconds for t in self.times)],
            [self.feet[0], *self.feet],
            (Phase.SUPPORT, *self.phases),
            self.lift + 1,
            max(onward, self.lift_length),
        )


@dataclass(frozen=True, slots=True)
class _Way:
    """A body's way through a step: progress along the reference, offsets along and across it."""

    table: _Table
    course: _Course
    progress: list[Knot]  # m of the reference's length
    along: list[Knot]
    across: list[Knot]
    machine: Machine

    @classmethod
    def through(
        cls,
        table: _Table,
        course: _Course,
        stance: Stance,
        ahead: Sequence[SupportPhase],
        bounds: Bounds,
        machine: Machine,
    ) -> _Way:
        """The way through the gates of this step and the next ones."""
        side = course.side(0.0)
        onward = direction(course.heading(0.0))
        gates = _gates(table, course, ahead, bounds.margin + SPARE)
        speed = _dot(stance.velocity, onward)
        progress = _progress(table, course, speed, ahead, BRAKING * bounds.acceleration)
        gone = progress[0].rate
        rest = stance.velocity[0] - gone * onward[0], stance.velocity[1] - gone * onward[1]
        across = through_gates(Knot(0.0, _dot(stance.sway, side), _dot(rest, side)), gates)
        forward = side[1], -side[0]
        along = [
            Knot(0.0, _dot(stance.sway, forward), _dot(rest, forward)),
            Knot(table.times[-1], 0.0, 0.0),
        ]
        return cls(table, course, progress, along, across, machine)

    def velocity(self, k: int) -> Body:
        """Of the body at knot k: m/s along absolute x, y and z, and rad/s."""
        t = self.table.times[k]
        progress = at(self.progress, t)
        along = at(self.along, t)
        aside = at(self.across, t)
        c, s = direction(self.course.heading(progress.value))
        sx, sy = self.course.side(progress.value)
        turn, climb = self.course.per_metre(progress.value)
        flat = math.sqrt(max(0.0, 1.0 - turn * turn - climb * climb))
        # the offsets turn with the course
        spin = turn * progress.rate
        ox = sx * aside.value + sy * along.value
        oy = sy * aside.value - sx * along.value
        return (
            c * flat * progress.rate + sx * aside.rate + sy * along.rate - spin * oy,
            s * flat * progress.rate + sy * aside.rate - sx * along.rate + spin * ox,
            climb * progress.rate,
            spin,
        )

    def place(self, k: int) -> Body:
        """Of the body at knot k."""
        t = self.table.times[k]
        length = at(self.progress, t).value
        x, y, z, yaw = self.course.at(length)
        sx, sy = self.course.side(length)
        along = at(self.along, t).value
        aside = at(self.across, t).value
        return x + sx * aside + sy * along, y + sy * aside - sx * along, z, yaw

    def hurry(self, bounds: Bounds) -> float:
        """By which factor the step should be longer for the body's acceleration; 1: it is well."""
        most = self._acceleration(0.0, self.table.times[-1])
        return math.sqrt(most / bounds.acceleration)

    @property
    def hurries_on_all_feet(self) -> bool:
        """True when it is before a leg lifts that the body is in a hurry."""
        lift = self.table.times[self.table.lift]
        return self._acceleration(0.0, lift) >= self._acceleration(lift, self.table.times[-1])

    def _acceleration(self, start: float, end: float) -> float:
        progress, along, across = (
            largest_acceleration(knots, start, end)
            for knots in (self.progress, self.along, self.across)
        )
        return math.hypot(across, progress + along)

    def foot_hurry(self, machine: Machine) -> float:
        """Speed of the fastest foot against the body, over its limit."""
        times = self.table.times
        most = 0.0
        for k in range(len(times) - 1):
            seconds = times[k + 1] - times[k]
            if seconds > 0.0:
                feet = self.table.feet[k], self.table.feet[k + 1]
                for knot in (k, k + 1):
                    motion = self.place(knot), self.velocity(knot)
                    most = max(most, _fastest_foot(feet, seconds, motion, machine))
        return most

    def plan(self, plan: StepPlan) -> StepPlan:
        """The step on this way."""
        count = len(self.table.times)
        body = [self.place(k) for k in range(count)]
        rates = [self.velocity(k) for k in range(count)]
        x, y, _, _ = plan.end.body
        end = replace(
            plan.end, sway=(body[-1][0] - x, body[-1][1] - y), velocity=(rates[-1][0], rates[-1][1])
        )
        return changed(
            plan,
            times=np.array(self.table.times),
            body=np.array(body),
            feet=np.array(self.table.feet),
            phases=self.table.phases,
            rates=np.array(rates),
            end=end,
            polygon_margin_min=self._margin(body),
        )

    def _margin(self, body: Sequence[Body]) -> float:
        """Least polygon margin at the knots."""
        least = math.inf
        for k, place in enumerate(body):
            dx, dy = _centre(self.machine, place, self.table.feet[k])
            x, y = place[0] + dx, place[1] + dy
            if k <= self.table.lift:
                least = min(least, polygon_margin(self.course.before, x, y))
            if k >= self.table.lift and self.course.after:
                least = min(least, polygon_margin(self.course.after, x, y))
        return least


def _fastest_foot(
    feet: tuple[Sequence[Point], Sequence[Point]],
    seconds: float,
    motion: tuple[Body, Body],
    machine: Machine,
) -> float:
    """Speed of the fastest of feet that go straight for some seconds, seen from a body in motion,
    over its limit.
    """
    (x, y, _, yaw), (vx, vy, vz, turn) = motion
    c, s = direction(yaw)
    most = 0.0
    for a, b in zip(*feet, strict=True):
        wx = (b[0] - a[0]) / seconds - vx + turn * (a[1] - y)
        wy = (b[1] - a[1]) / seconds - vy - turn * (a[0] - x)
        wz = (b[2] - a[2]) / seconds - vz
        most = max(
            most,
            abs(c * wx + s * wy) / machine.speed[0],
            abs(c * wy - s * wx) / machine.speed[1],
            abs(wz) / machine.speed[2],
        )
    return most


def _dot(vector: XY, along: XY) -> float:
    """A vector's part along a direction."""
    return vector[0] * along[0] + vector[1] * along[1]


def _lengths(body: Sequence[Body]) -> list[float]:
    """How far the reference has come at every knot, m; a turn on the spot and a climb count too."""
    out = [0.0]
    for a, b in zip(body, body[1:], strict=False):
        out.append(out[-1] + math.hypot(*(q - p for p, q in zip(a, b, strict=True))))
    return out


def _gates(
    table: _Table, course: _Course, ahead: Sequence[SupportPhase], margin: float
) -> list[Key]:
    """The gates of the step and of what is expected after it."""
    last = table.times[-1]
    keys: list[Key] = []
    if course.after:
        lift = table.times[table.lift]
        if lift > SOONEST:
            for polygon in (course.before, course.after):
                _add(keys, lift, course.bounds_at(table.lift_length, polygon, margin))
        _add(keys, last, course.bounds_at(course.length, course.after, margin))
    elif ahead:
        keys.append(Key(last, -OFFSET_MAX, OFFSET_MAX))
    side = course.side(course.length)
    for support in ahead:
        places = ((support.lift, support.at_lift), (support.land, support.at_land))
        dx, dy = course.centre_at_end
        for time, (x, y) in places:
            bounds = lateral_bounds(support.polygon, x + dx, y + dy, side, margin)
            _add(keys, last + time, bounds)
    return keys or [Key(last, 0.0, 0.0)]


def _add(keys: list[Key], time: float, bounds: XY) -> None:
    """Add what is open at an instant; gates of one instant become one."""
    if keys and abs(keys[-1].time - time) < SOONEST:
        keys[-1] = Key(keys[-1].time, *meeting(bounds, (keys[-1].low, keys[-1].high)))
    else:
        keys.append(Key(time, *bounds))


def _progress(
    table: _Table, course: _Course, speed: float, ahead: Sequence[SupportPhase], acceleration: float
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
    if not SOONEST < time < seconds - SOONEST:
        return None
    return Knot(time, speed * time - acceleration * time * time / 2.0, speed - acceleration * time)
