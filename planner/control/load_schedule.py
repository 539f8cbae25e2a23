"""What every leg is to carry while a plan runs: statics of the planned body on its planned feet,
with what its speeding up and slowing down shifts from foot to foot.

Loads are worked out once a plan, at its knots and between, and interpolated. They are continuous
over touch-down and lift-off: a foot takes its load up over ``statics.RAMP`` after it has come down
and gives it away before it rises.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping

from ..geometry.transforms import attitude_of, rotation, turned_back_by, turned_by
from ..robot.model import Machine
from ..stability import GRAVITY
from ..statics import RAMP, centre_of_gravity, load_share, planned_loads, pushed_at
from ..types import Phase, Point, StepPlan
from .tracking import TrajectoryTracker

# s after a knot: a body's acceleration jumps there, and a leg that rises belongs to what follows
SOON = 1e-6
SAMPLE = 0.1  # s between loads that are worked out. Longer: see them off where the body speeds up


def body_frame_feet(tracker: TrajectoryTracker, t: float) -> list[Point]:
    """Where the plan has the feet at ``t`` in the axes of its body, m."""
    x, y, z, yaw = tracker.body_at(t)
    roll, pitch = attitude_of(tracker.lean_at(t), yaw) if tracker.leans else (0.0, 0.0)
    turn = rotation(roll, pitch, yaw)
    legs = range(len(tracker.plan.end.feet))
    spots = (tracker.foot_at(leg, t) for leg in legs)
    return [turned_back_by(turn, (fx - x, fy - y, fz - z)) for fx, fy, fz in spots]


class LoadSchedule:
    """Loads over the time of one plan. ``since`` says how long before its beginning legs came down,
    s; those it does not name have always stood.
    """

    def __init__(
        self,
        tracker: TrajectoryTracker,
        machine: Machine,
        since: Mapping[int, float] | None = None,
    ) -> None:
        fresh = since or {}
        self._tracker = tracker
        self._machine = machine
        self._leaving: dict[int, float] = {}  # when legs rise that the next plan begins with
        self._stances = [_stance_of(tracker, leg, fresh) for leg in range(len(machine.legs))]
        self._begin()

    def _begin(self) -> None:
        self._times = self._sampled()
        self._rows: list[tuple[float, ...] | None] = [None] * len(self._times)

    def foresee(self, following: StepPlan) -> None:
        """Legs that rise as soon as the plan ``following`` this one begins give their loads away in
        time.
        """
        lifted = self._tracker.plan.end.lifted
        rising = [leg for leg in following.swing if leg not in lifted]
        first = TrajectoryTracker(following, lifted).stretches[0]
        for leg in rising:
            if leg in first.air:
                self._leaving[leg] = self._tracker.duration
        self._begin()

    def _sampled(self) -> list[float]:
        duration = self._tracker.duration
        times = {*self._tracker.plan.times.tolist(), 0.0, duration}
        times |= {SAMPLE * k for k in range(math.ceil(duration / SAMPLE))}
        for stance in self._stances:
            for edge in (*stance, *self._leaving.values()):
                times |= {edge + part * RAMP for part in (-1.0, -0.5, 0.0, 0.5, 1.0)}
        return sorted(t for t in times if 0.0 <= t <= duration)

    def since_landing(self) -> dict[int, float]:
        """How long before the end of the plan its swing legs came down, s."""
        end = self._tracker.duration
        return {
            leg: max(0.0, end - down)
            for leg, (_, down, _) in enumerate(self._stances)
            if down < math.inf
        }

    def at(self, t: float) -> tuple[float, ...]:
        """What every leg is to carry at ``t``, N."""
        times = self._times
        k = min(max(bisect_right(times, t) - 1, 0), len(times) - 1)
        low = self._row(k)
        if k + 1 == len(times) or t <= times[k]:
            return low
        high = self._row(k + 1)
        share = (t - times[k]) / (times[k + 1] - times[k])
        return tuple(a + share * (b - a) for a, b in zip(low, high, strict=True))

    def resting(self, t: float) -> tuple[float, ...]:
        """The same if the body did not speed up or slow down at ``t``."""
        return self._worked_out(t, speeding=False)

    def _row(self, k: int) -> tuple[float, ...]:
        row = self._rows[k]
        if row is None:
            row = self._rows[k] = self._worked_out(self._times[k])
        return row

    def _worked_out(self, t: float, *, speeding: bool = True) -> tuple[float, ...]:
        machine = self._machine
        tracker = self._tracker
        feet = [tracker.foot_at(leg, t) for leg in range(len(machine.legs))]
        shares = [self._share(leg, t) for leg in range(len(machine.legs))]
        change = tracker.bending_at(t + SOON) if speeding else (0.0, 0.0)
        place = pushed_at(self._centre(t), change, feet, shares)
        return planned_loads(machine.mass * GRAVITY, place, feet, shares).newtons

    def _centre(self, t: float) -> Point:
        """Of gravity, absolute, m."""
        tracker = self._tracker
        x, y, z, yaw = tracker.body_at(t)
        roll, pitch = attitude_of(tracker.lean_at(t), yaw) if tracker.leans else (0.0, 0.0)
        cx, cy, cz = turned_by(
            rotation(roll, pitch, yaw),
            centre_of_gravity(self._machine, body_frame_feet(tracker, t)),
        )
        return x + cx, y + cy, z + cz

    def _share(self, leg: int, t: float) -> float:
        """How much a leg counts as carrying, 0 to 1."""
        rise, down, begin = self._stances[leg]
        until = self._leaving.get(leg, math.inf) - t
        return max(load_share(t - begin, min(rise - t, until)), load_share(t - down, until))


def _stance_of(
    tracker: TrajectoryTracker, leg: int, fresh: Mapping[int, float]
) -> tuple[float, float, float]:
    """When a leg rises, comes down, and began to stand: s into the plan, infinite for never."""
    plan = tracker.plan
    begin = -fresh.get(leg, math.inf)
    if leg not in plan.swing:
        return -math.inf if leg in plan.end.lifted else math.inf, math.inf, begin
    return *_flight(tracker, leg, plan), begin


def _flight(tracker: TrajectoryTracker, leg: int, plan: StepPlan) -> tuple[float, float]:
    """When a swing leg rises and when it comes down, by the plan."""
    rise = math.inf
    down = math.inf
    floor = plan.end.feet[leg][2]
    for stretch, end in zip(tracker.stretches, plan.times[1:].tolist(), strict=True):
        if leg not in stretch.air:
            continue
        rise = min(rise, stretch.start)
        if stretch.down and leg not in plan.end.lifted:
            down = _met(tracker, leg, (stretch.start, end), floor)
            if down < math.inf:
                break
    landed = leg not in plan.end.lifted and plan.phases[-1] is not Phase.RETURN
    return rise, min(down, tracker.duration) if landed else math.inf


def _met(tracker: TrajectoryTracker, leg: int, span: tuple[float, float], floor: float) -> float:
    """When a falling foot is at its floor, within a stretch; infinite when it is not."""
    begin, end = span
    high = tracker.foot_at(leg, begin)[2]
    low = tracker.foot_at(leg, end)[2]
    if low > floor or high <= low:
        return math.inf
    return begin + (end - begin) * min(1.0, max(0.0, (high - floor) / (high - low)))
