"""How a body that walks comes to rest: on along its planned way, ever slower.

A body with mass cannot stop dead: on a margin m ahead its centre of gravity may slow down by g·m/h
and no faster. It takes what it has at every tick: in the middle of a support several times what its
way is planned with. The planned way keeps the margin at every place, so the body stays on it while
it slows down, and goes straight on where the plan ends before it stands. A body that is too fast
for the edge ahead waits for its foot to land. Metres, seconds, absolute frame.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple, Protocol

import numpy as np

from ..geometry.transforms import XY, Body
from ..types import TICK, Phase, Point, Stance, StepPlan
from .body_bounds import STEEPEST, CarryingFeet
from .step_builder import changed
from .swing import between
from .swing_profile import cubic_between

STANDS = 2e-3  # m/s; a body slower than this, or a foot it turns with, stands
LEAST_SHARE = 0.3  # of the acceleration of a way, for slowing down where nothing is left of it
SAME_TIME = 1e-6  # s
STILL = (0.0, 0.0, 0.0)
TICKS_MAX = 500  # of slowing down


class Played(Protocol):
    """A plan made ready to be evaluated."""

    duration: float

    def body_at(self, t: float) -> Body: ...

    def velocity_at(self, t: float) -> Body: ...

    def bending_at(self, t: float) -> XY: ...


class Braking(NamedTuple):
    """A body's way to rest, tick by tick: where it is and its velocity, the last of them 0."""

    body: Sequence[Body]
    rates: Sequence[Body]
    safe: bool = True  # its zero-moment point stays inside of what carries it

    @property
    def seconds(self) -> float:
        """s until it stands."""
        return TICK * (len(self.body) - 1)

    def moved(self, dx: float, dy: float, dz: float = 0.0) -> Braking:
        """The same from somewhere else, m."""
        return Braking(
            [(x + dx, y + dy, z + dz, yaw) for x, y, z, yaw in self.body], self.rates, self.safe
        )

    def rest_of(self, stance: Stance) -> Stance:
        """The stance with its body where it will stand."""
        return replace(stance.at_rest(), body=self.body[-1])

    def onto(self, plan: StepPlan) -> StepPlan:
        """A plan whose body stands where this leads to, with the body on its way there."""
        end = max(float(plan.times[-1]), self.seconds + TICK)
        times = _apart({*plan.times.tolist(), *(TICK * k for k in range(len(self.body))), end})
        feet = [_feet_at(plan, t) for t in times]
        speeds = np.array([[speed for _, speed in row] for row in feet])
        return changed(
            plan,
            times=np.array(times),
            body=np.array([self._at(t, self.body) for t in times]),
            feet=np.array([[place for place, _ in row] for row in feet]),
            foot_rates=None if plan.foot_rates is None else speeds,
            phases=tuple(
                _phase_at(plan, (a + b) / 2) for a, b in zip(times, times[1:], strict=False)
            ),
            rates=np.array([self._at(t, self.rates) for t in times]),
        )

    def _at(self, t: float, rows: Sequence[Body]) -> Body:
        k = min(int(t / TICK + 1e-9), len(rows) - 1)
        after = rows[min(k + 1, len(rows) - 1)]
        share = min(max(t / TICK - k, 0.0), 1.0)
        x, y, z, yaw = (a + share * (b - a) for a, b in zip(rows[k], after, strict=True))
        return x, y, z, yaw


def _apart(times: set[float]) -> list[float]:
    """Times in order, nearly equal ones once."""
    out: list[float] = []
    for t in sorted(times):
        if not out or t - out[-1] > SAME_TIME:
            out.append(t)
    return out


def _feet_at(plan: StepPlan, t: float) -> list[tuple[Point, Point]]:
    """Where the plan has the feet at a time, and their velocities."""
    times = plan.times.tolist()
    k = min(max(bisect_right(times, t) - 1, 0), len(times) - 2)
    seconds = max(times[k + 1] - times[k], SAME_TIME)
    share = min((t - times[k]) / seconds, 1.0)
    ends = zip(plan.feet[k].tolist(), plan.feet[k + 1].tolist(), strict=True)
    if plan.foot_rates is None:
        return [(between(a, b, share), STILL) for a, b in ends]
    rates = zip(plan.foot_rates[k].tolist(), plan.foot_rates[k + 1].tolist(), strict=True)
    return [
        cubic_between(a, b, first, last, seconds, share)
        for (a, b), (first, last) in zip(ends, rates, strict=True)
    ]


def _phase_at(plan: StepPlan, t: float) -> Phase:
    times = plan.times.tolist()
    return plan.phases[min(max(bisect_right(times, t) - 1, 0), len(plan.phases) - 1)]


def braking(
    plan: Played, t: float, pace: float, carrying: CarryingFeet, yaw_length: float
) -> Braking | None:
    """From ``t`` of a plan that is played at ``pace`` to rest, slowing down as fast as the
    ``carrying`` feet allow at every tick; None for a body that stands.

    One too fast to stop so slows down harder, that it may at least come to rest over its feet.
    """
    acceleration = carrying.bounds.acceleration
    steepest = max(acceleration, STEEPEST)
    harder = (LEAST_SHARE * acceleration, acceleration, (acceleration + steepest) / 2.0, steepest)
    for least in harder:
        way = _braking(plan, t, pace, carrying, (least, yaw_length))
        if way is None or _holds(way, carrying):
            break
    return way


def _holds(way: Braking, carrying: CarryingFeet) -> bool:
    """True of a body that comes to rest over the feet that carry it; of one whose acceleration is
    given they are not asked.
    """
    if way.safe and carrying.bounds.height <= 0.0:
        return True
    return carrying.margin(way.body[-1][:2]) >= 0.0


def _braking(
    plan: Played, t: float, pace: float, carrying: CarryingFeet, given: tuple[float, float]
) -> Braking | None:
    """That with an acceleration, m/s², that it slows down by at ``least`` whatever carries it."""
    least, yaw_length = given
    rates = [_scaled(plan.velocity_at(t), pace)]
    if pace <= 0.0 or _speed(rates[0], yaw_length) <= STANDS:
        return None
    body = [plan.body_at(t)]
    safe = True
    for _ in range(TICKS_MAX):
        if pace <= 0.0:
            break
        velocity = plan.velocity_at(t)
        speed = max(_speed(velocity, yaw_length), STANDS)
        bends = plan.bending_at(t)
        square = pace * pace
        ahead = (velocity[0] / speed, velocity[1] / speed)
        most = carrying.slowing(body[-1][:2], ahead, (square * bends[0], square * bends[1]))
        safe = safe and most >= LEAST_SHARE * carrying.bounds.acceleration
        slower = max(0.0, pace - max(most, least) * TICK / speed)
        t += TICK * (pace + slower) / 2.0
        if t > plan.duration:
            break
        pace = slower
        body.append(plan.body_at(t))
        rates.append(_scaled(plan.velocity_at(t), pace))
    return _straight_on(Braking(body, rates, safe), carrying, given)


def _straight_on(way: Braking, carrying: CarryingFeet, given: tuple[float, float]) -> Braking:
    """The way gone on with straight until the body stands."""
    body = list(way.body)
    rates = list(way.rates)
    safe = way.safe
    least, yaw_length = given
    speed = _speed(rates[-1], yaw_length)
    for _ in range(TICKS_MAX):
        if speed <= 0.0:
            break
        ahead = (rates[-1][0] / speed, rates[-1][1] / speed)
        most = carrying.slowing(body[-1][:2], ahead)
        safe = safe and most >= LEAST_SHARE * carrying.bounds.acceleration
        slower = max(0.0, speed - max(most, least) * TICK)
        now = _scaled(rates[-1], slower / speed)
        x, y, z, yaw = (
            place + TICK * (a + b) / 2.0
            for place, a, b in zip(body[-1], rates[-1], now, strict=True)
        )
        body.append((x, y, z, yaw))
        rates.append(now)
        speed = slower
    rates[-1] = (0.0, 0.0, 0.0, 0.0)
    return Braking(body, rates, safe)


def _speed(rate: Body, yaw_length: float) -> float:
    return math.hypot(rate[0], rate[1], yaw_length * rate[3])


def _scaled(rate: Body, factor: float) -> Body:
    return rate[0] * factor, rate[1] * factor, rate[2] * factor, rate[3] * factor
