"""A step plan made ready to be followed: where it has the body and every foot at any time.

Plain floats and flat code: this is evaluated every tick.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Collection, Sequence
from typing import NamedTuple

from ..geometry.transforms import Body, attitude_of, direction, left_fold_sum
from ..motion.body_tilt import speed_leaning
from ..robot.model import Machine
from ..types import Command, Phase, Point, StepPlan

REST_TO_REST = 1.5  # highest speed of a cubic from rest to rest over its mean
LEVEL_LEAN = (0.0, 0.0)  # gradient of the body's floor


Four = tuple[float, float, float, float]
FootRow = tuple[float, float, float, float, float, float]  # x, y, z and their rates
Bend = tuple[Four, Four]  # factors of s² and s³ in the body's x, y, z, yaw
Rise = tuple[float, tuple[int, ...], tuple[int, ...]]  # s, legs that rise, legs that carry then
# of s² and s³ in x, y, z of every foot; None for one that goes straight
Curves = tuple[tuple[float, float, float, float, float, float] | None, ...]


class PlanStretch(NamedTuple):
    """One stretch between knots, as plain floats: straight, but for the ``bend`` of a body."""

    start: float  # s
    body: Body  # x, y, z, yaw at its start
    rate: tuple[float, float, float, float]  # per second
    air: tuple[int, ...]  # legs in the air
    stand: tuple[int, ...]  # legs that carry
    down: bool  # the legs in the air are coming down: a touch is a landing
    # x, y, z and their rates, one row per leg
    feet: tuple[FootRow, ...]
    ground: float  # mean z of the carrying feet, m
    bend: Bend | None = None  # of a body that does not go straight
    curves: Curves | None = None  # of feet that do not


class TrajectoryTracker:
    """A ``StepPlan`` made ready to be evaluated tick by tick; ``lifted`` are the legs that are in
    the air when it begins.
    """

    __slots__ = (
        "plan",
        "duration",
        "leans",
        "asked",
        "stretches",
        "rises",
        "rises_until",
        "here",
        "_times",
        "_last",
        "_paces",
        "wanted",
    )

    def __init__(self, plan: StepPlan, lifted: Collection[int] = ()) -> None:
        times = plan.times.tolist()
        body = plan.body.tolist()
        feet = plan.feet.tolist()
        self.plan = plan
        self.duration: float = times[-1]
        self._times: list[float] = times
        rates = None if plan.rates is None else [_four(row) for row in plan.rates.tolist()]
        speeds = None if plan.foot_rates is None else plan.foot_rates.tolist()
        knots = _Knots(times, body, feet, rates, speeds)
        self.stretches = [_stretch(plan, k, knots, lifted) for k in range(len(times) - 1)]
        self.rises = _rises(self.stretches)
        # when the last of them is, s into the plan
        self.rises_until = max((time for time, _, _ in self.rises), default=-math.inf)
        # when it was last evaluated, and where the body was then
        self.here: tuple[float, Body] = (math.nan, (0.0, 0.0, 0.0, 0.0))
        self._last = 0
        self._paces: list[float] | None = None
        # how fast to play it for a command, once that has been worked out (``pacing``)
        self.wanted: tuple[Command | None, float] = (None, 1.0)
        after = plan.end.lean
        before = after if plan.lean is None else plan.lean
        self.leans = before != LEVEL_LEAN or after != LEVEL_LEAN
        # roll and pitch Level C last asked for
        self.asked = attitude_of(before, body[0][3]) if self.leans else LEVEL_LEAN

    def stretch(self, t: float) -> int:
        """Index of the stretch between knots that contains t; a knot belongs to the stretch that
        ends there.
        """
        times = self._times
        k = self._last
        if not times[k] < t <= times[k + 1]:
            k = min(max(bisect_right(times, t) - 1, 0), len(times) - 2)
            if k > 0 and times[k] == t:
                k -= 1
            self._last = k
        return k

    def phase(self, t: float) -> Phase:
        """What the swing legs do at t."""
        return self.plan.phases[self.stretch(t)]

    def body_at(self, t: float) -> Body:
        """Where the plan has the body at t: x, y, z, yaw."""
        when, here = self.here
        if when == t:
            return here
        stretch = self.stretches[self.stretch(t)]
        s = min(max(t, 0.0), self.duration) - stretch.start
        x, y, z, yaw = stretch.body
        vx, vy, vz, turn = stretch.rate
        if stretch.bend is not None:
            vx, vy, vz, turn = bent(stretch.rate, stretch.bend, s)
        return x + vx * s, y + vy * s, z + vz * s, yaw + turn * s

    def velocity_at(self, t: float) -> Body:
        """How the plan has the body move at t: m/s, and rad/s."""
        stretch = self.stretches[self.stretch(t)]
        if stretch.bend is None:
            return stretch.rate
        s = min(max(t, 0.0), self.duration) - stretch.start
        (a, b, c, d), (e, f, g, h) = stretch.bend
        vx, vy, vz, turn = stretch.rate
        return (
            vx + s * (2.0 * a + 3.0 * s * e),
            vy + s * (2.0 * b + 3.0 * s * f),
            vz + s * (2.0 * c + 3.0 * s * g),
            turn + s * (2.0 * d + 3.0 * s * h),
        )

    def bending_at(self, t: float) -> tuple[float, float]:
        """How the plan has the body's velocity over the ground change at t, m/s²."""
        stretch = self.stretches[self.stretch(t)]
        return _bending(stretch, min(max(t, 0.0), self.duration) - stretch.start)

    def acceleration_at(self, t: float) -> float:
        """Of the body over the ground, m/s²."""
        return math.hypot(*self.bending_at(t))

    @property
    def rests_from(self) -> float:
        """The time from which on the body stands, s."""
        for k in range(len(self.stretches) - 1, -1, -1):
            stretch = self.stretches[k]
            if stretch.bend is not None or stretch.rate != (0.0, 0.0, 0.0, 0.0):
                return self._times[k + 1]
        return 0.0

    def body_moves(self, t: float) -> bool:
        """True when the plan has the body go or turn at t."""
        stretch = self.stretches[self.stretch(t)]
        vx, vy, _, turn = stretch.rate
        return stretch.bend is not None or vx != 0.0 or vy != 0.0 or turn != 0.0

    def foot_at(self, leg: int, t: float) -> Point:
        """Where the plan has one foot tip at t."""
        stretch = self.stretches[self.stretch(t)]
        s = min(max(t, 0.0), self.duration) - stretch.start
        x, y, z, vx, vy, vz = stretch.feet[leg]
        curve = None if stretch.curves is None else stretch.curves[leg]
        if curve is not None:
            vx, vy, vz = curved(vx, vy, vz, curve, s)
        return x + vx * s, y + vy * s, z + vz * s

    def lean_at(self, t: float) -> tuple[float, float]:
        """How the plan has the body lean at t."""
        after = self.plan.end.lean
        before = self.plan.lean
        if before is None or before == after or t >= self.duration:
            return after
        share = max(t, 0.0) / self.duration
        return before[0] + share * (after[0] - before[0]), before[1] + share * (
            after[1] - before[1]
        )

    def pace_max(self, t: float, machine: Machine) -> float:
        """How many times faster than planned the stretch at t may be played before a foot exceeds
        its limit.
        """
        return self._paces_of(machine)[self.stretch(t)]

    def pace_ahead(self, t: float, machine: Machine, acceleration: float) -> float:
        """The same for one who slows down in time for every stretch to come, and for the next plan,
        which begins with the velocity that this one ends with; the body speeds up and slows down by
        no more than ``acceleration``, m/s².
        """
        times = self._times
        allowed = math.inf
        fastest = 0.0
        for k in range(self.stretch(t), len(self.stretches)):
            stretch = self.stretches[k]
            seconds = times[k + 1] - times[k]
            fastest = max(fastest, _fastest(stretch, seconds))
            ends = _acceleration(stretch, 0.0), _acceleration(stretch, seconds)
            bends = max(*ends, 1e-9)
            here = max(1.0, min(self._paces_of(machine)[k], math.sqrt(acceleration / bends)))
            before = max(0.0, times[k] - t)
            slowing = 2.0 * acceleration / max(fastest, 1e-6) * before
            allowed = min(allowed, math.sqrt(here * here + slowing))
        slowing = 2.0 * acceleration / max(fastest, 1e-6) * max(0.0, self.duration - t)
        return min(allowed, math.sqrt(1.0 + slowing))

    def _paces_of(self, machine: Machine) -> list[float]:
        if self._paces is None:
            limits = speed_leaning(machine, (self.lean_at(0.0), self.plan.end.lean))
            self._paces = [
                _pace(stretch, end, limits)
                for stretch, end in zip(self.stretches, self._times[1:], strict=True)
            ]
        return self._paces

    def onward(
        self, t: float, seconds: float, pace: float, machine: Machine
    ) -> tuple[float, float]:
        """Where playing from t at ``pace`` times the plan's speed gets in so many seconds, and the
        seconds left at its end.

        No stretch is played faster than its feet allow: the foot of a creeping body comes down no
        faster than ever.
        """
        times = self._times
        paces = self._paces_of(machine)
        for k in range(max(bisect_right(times, t) - 1, 0), len(paces)):
            allowed = min(pace, max(1.0, paces[k]))
            needed = (times[k + 1] - t) / allowed
            if needed > seconds:
                return t + allowed * seconds, 0.0
            t, seconds = times[k + 1], seconds - needed
        return t, seconds


class _Knots(NamedTuple):
    """The knots of a plan as plain floats."""

    times: list[float]
    body: list[list[float]]
    feet: list[list[list[float]]]
    rates: list[Four] | None  # of the body; None where it goes straight
    speeds: list[list[list[float]]] | None  # of the feet, likewise


def _stretch(plan: StepPlan, k: int, knots: _Knots, lifted: Collection[int]) -> PlanStretch:
    times, body, feet, rates, speeds = knots
    here = feet[k]
    there = feet[k + 1]
    phase = plan.phases[k]
    air = plan.swing
    # a supporting foot does not move in the absolute frame; one that waits in the air may
    if phase is Phase.SUPPORT:
        air = tuple([leg for leg in air if leg in lifted or here[leg] != there[leg]])
    stand = tuple([leg for leg in range(len(here)) if leg not in air])
    duration = times[k + 1] - times[k]
    per_second = 1.0 / duration if duration > 0.0 else 0.0
    x, y, z, yaw = body[k]
    rate = _mean_rate(body[k], body[k + 1], per_second)
    rows = [
        (a[0], a[1], a[2], 0.0, 0.0, 0.0) if a == b else _row(a, b, per_second)
        for a, b in zip(here, there, strict=True)
    ]
    ground = left_fold_sum([here[leg][2] for leg in stand]) / len(stand) if stand else 0.0
    bend: Bend | None = None
    if rates is not None and duration > 0.0 and not rates[k] == rate == rates[k + 1]:
        bend = _bend(rate, duration, rates[k], rates[k + 1])
        rate = rates[k]
    curves: Curves | None = None
    if speeds is not None and duration > 0.0 and air:
        curves = _curves(rows, air, duration, (speeds[k], speeds[k + 1]))
    down = phase is Phase.DOWN
    return PlanStretch(
        times[k], (x, y, z, yaw), rate, air, stand, down, tuple(rows), ground, bend, curves
    )


def _rises(stretches: Sequence[PlanStretch]) -> list[Rise]:
    """When legs leave the ground, or are off it from the beginning."""
    rises = []
    before: tuple[int, ...] = ()
    for stretch in stretches:
        legs = tuple(leg for leg in stretch.air if leg not in before)
        if legs:
            rises.append((stretch.start, legs, stretch.stand))
        before = stretch.air
    return rises


def _bend(mean: Four, seconds: float, begin: Four, end: Four) -> Bend:
    """What makes a cubic of a stretch whose body has these rates at its ends (Hermite's form)."""
    square = seconds * seconds
    a, b, c, d = mean
    e, f, g, h = begin
    i, j, k, m = end
    squares = (
        (3.0 * a - 2.0 * e - i) / seconds,
        (3.0 * b - 2.0 * f - j) / seconds,
        (3.0 * c - 2.0 * g - k) / seconds,
        (3.0 * d - 2.0 * h - m) / seconds,
    )
    cubes = (
        (e + i - 2.0 * a) / square,
        (f + j - 2.0 * b) / square,
        (g + k - 2.0 * c) / square,
        (h + m - 2.0 * d) / square,
    )
    return squares, cubes


def _curves(
    rows: list[FootRow],
    air: Sequence[int],
    seconds: float,
    speeds: tuple[list[list[float]], list[list[float]]],
) -> Curves:
    """The same of feet in the air that have these velocities at the ends; ``rows`` then begin with
    the first.
    """
    begin, end = speeds
    curves: list[tuple[float, float, float, float, float, float] | None] = [None] * len(rows)
    square = seconds * seconds
    for leg in air:
        x, y, z, a, b, c = rows[leg]
        vx, vy, vz = begin[leg]
        ux, uy, uz = end[leg]
        rows[leg] = (x, y, z, vx, vy, vz)
        curves[leg] = (
            (3.0 * a - 2.0 * vx - ux) / seconds,
            (3.0 * b - 2.0 * vy - uy) / seconds,
            (3.0 * c - 2.0 * vz - uz) / seconds,
            (vx + ux - 2.0 * a) / square,
            (vy + uy - 2.0 * b) / square,
            (vz + uz - 2.0 * c) / square,
        )
    return tuple(curves)


def curved(
    vx: float,
    vy: float,
    vz: float,
    curve: tuple[float, float, float, float, float, float],
    s: float,
) -> Point:
    """Mean velocity of a cubic from the beginning of its stretch up to s."""
    a, b, c, d, e, f = curve
    return vx + s * (a + s * d), vy + s * (b + s * e), vz + s * (c + s * f)


def _four(values: Sequence[float]) -> Four:
    return values[0], values[1], values[2], values[3]


def bent(rate: Four, bend: Bend, s: float) -> Four:
    """Mean rate of a cubic from the beginning of its stretch up to s."""
    (a, b, c, d), (e, f, g, h) = bend
    return (
        rate[0] + s * (a + s * e),
        rate[1] + s * (b + s * f),
        rate[2] + s * (c + s * g),
        rate[3] + s * (d + s * h),
    )


def _bending(stretch: PlanStretch, s: float) -> tuple[float, float]:
    """How the body's velocity over the ground changes ``s`` seconds into a stretch, m/s²."""
    if stretch.bend is None:
        return 0.0, 0.0
    (a, b, _, _), (e, f, _, _) = stretch.bend
    return 2.0 * a + 6.0 * s * e, 2.0 * b + 6.0 * s * f


def _acceleration(stretch: PlanStretch, s: float) -> float:
    """Of the body over the ground ``s`` seconds into a stretch, m/s²."""
    return math.hypot(*_bending(stretch, s))


def _fastest(stretch: PlanStretch, seconds: float) -> float:
    """About the highest speed of the body over the ground in a stretch, m/s: at its beginning, or
    the one of a cubic from rest to rest.
    """
    first = math.hypot(stretch.rate[0], stretch.rate[1])
    if stretch.bend is None:
        return first
    x, y, _, _ = bent(stretch.rate, stretch.bend, seconds)
    return max(first, REST_TO_REST * math.hypot(x, y))


def _mean_rate(begin: list[float], end: list[float], per_second: float) -> Four:
    """Of a body between two knots."""
    x, y, z, yaw = begin
    u, v, w, turned = end
    return (
        (u - x) * per_second,
        (v - y) * per_second,
        (w - z) * per_second,
        (turned - yaw) * per_second,
    )


def _row(a: list[float], b: list[float], per_second: float) -> FootRow:
    """Where a foot that moves begins, and its velocity."""
    return (
        a[0],
        a[1],
        a[2],
        (b[0] - a[0]) * per_second,
        (b[1] - a[1]) * per_second,
        (b[2] - a[2]) * per_second,
    )


def _pace(stretch: PlanStretch, end: float, limits: tuple[float, float, float]) -> float:
    """Limit over speed of the fastest foot axis of one stretch, body axes; infinite when nothing
    moves.
    """
    share = 0.0
    duration = end - stretch.start
    # a turning body, or feet on curves: three looks, good to a percent
    many = stretch.rate[3] or stretch.curves is not None
    for s in (0.0, duration / 2, duration) if many else (0.0,):
        x, y, _, yaw = (
            value + rate * s for value, rate in zip(stretch.body, stretch.rate, strict=True)
        )
        c, d = direction(yaw)
        turn = stretch.rate[3]
        for leg, (fx, fy, _, vx, vy, _) in enumerate(stretch.feet):
            ux, uy, uz = _foot_velocity(stretch, leg, s)
            # seen from the turning body, absolute axes
            wx = ux - stretch.rate[0] + turn * (fy + vy * s - y)
            wy = uy - stretch.rate[1] - turn * (fx + vx * s - x)
            axes = (c * wx + d * wy, c * wy - d * wx, uz - stretch.rate[2])
            share = max(share, *(abs(v) / limit for v, limit in zip(axes, limits, strict=True)))
    return 1.0 / share if share > 0.0 else math.inf


def _foot_velocity(stretch: PlanStretch, leg: int, s: float) -> Point:
    """Of a foot so long after the beginning of a stretch, m/s."""
    _, _, _, vx, vy, vz = stretch.feet[leg]
    curve = None if stretch.curves is None else stretch.curves[leg]
    if curve is None:
        return vx, vy, vz
    a, b, c, d, e, f = curve
    return (
        vx + s * (2.0 * a + 3.0 * s * d),
        vy + s * (2.0 * b + 3.0 * s * e),
        vz + s * (2.0 * c + 3.0 * s * f),
    )
