"""The time table of a swing: every stretch smooth in acceleration, the foot slow where it lands.

One for both planners. A decided step says which corners the foot goes through and when it is in the
air; here every stretch is run through from rest to rest with an acceleration that has no jumps. On
ground that is known the foot comes down fast above and at ``TOUCH_SPEED`` near it, and aims only a
little below; where it is not, it goes on down to the aim it has, so that touch decides (H §4.5).
What lifting and landing take longer is taken from the return, as far as the leg is fast enough.
Metres, seconds, absolute frame.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from functools import lru_cache
from itertools import groupby, pairwise
from typing import NamedTuple

import numpy as np

from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Array, Phase, Point, StepPlan
from .body_tilt import speed_leaning
from .step_builder import changed, feet_of
from .swing import between

TOUCH_SPEED = 0.13  # m/s at which a foot meets known ground; more: see it take twice its load
ABOVE = 0.012  # m over known ground at which the foot is that slow; less: see it thump on relief
BELOW = 0.01  # m below known ground that it aims at; less: see it stop over relief
JERKY = 16.0  # m/s², most a foot is sped up or slowed down by going up and down
VERTICAL_SHARE = 0.9  # of V_z for the foot; the rest is for the body's own climb
RETURN_SHARE = 0.95  # of V for a return that is made shorter
SETTLED = 0.04  # s in which a foot that has met nothing stops at its aim
PIECES = 8  # of a return that is not straight
STAYS = 1e-9  # m
REST: Point = (0.0, 0.0, 0.0)  # m/s

IN_THE_AIR = (Phase.UP, Phase.RETURN, Phase.DOWN)


class Ramp(NamedTuple):
    """A stretch of time with a speed at either end, and the way gone in it, m and m/s."""

    seconds: float
    first: float
    last: float

    @property
    def way(self) -> float:
        """m."""
        seconds, first, last = self
        return seconds * (first + last) / 2.0

    def at(self, t: float) -> tuple[float, float]:
        """Way and speed so long after its beginning: acceleration rises and falls evenly."""
        seconds, first, last = self
        if seconds <= 0.0:
            return 0.0, last
        u = t / seconds
        gain = last - first
        if u <= 0.5:
            return first * t + gain * seconds * 2.0 * u**3 / 3.0, first + 2.0 * gain * u * u
        left = 1.0 - u
        speed = last - 2.0 * gain * left * left
        behind = last * (seconds - t) - gain * seconds * 2.0 * left**3 / 3.0
        return self.way - behind, speed


class Ramps:
    """Ramps one after the other."""

    __slots__ = ("ramps", "seconds", "way", "_laid")

    def __init__(self, ramps: Iterable[Ramp]) -> None:
        self.ramps = tuple(ramp for ramp in ramps if ramp.seconds > 0.0)
        self._laid: list[tuple[float, float, Ramp]] = []  # s, and m gone before every ramp
        seconds = 0.0
        way = 0.0
        for ramp in self.ramps:
            self._laid.append((seconds, way, ramp))
            seconds += ramp.seconds
            way += ramp.way
        self.seconds = seconds
        self.way = way

    def at(self, t: float) -> tuple[float, float]:
        """Way and speed at a time."""
        for begin, done, ramp in self._laid:
            gone = t - begin
            if gone <= ramp[0]:
                way, speed = ramp.at(gone)
                return done + way, speed
        return self.way, self.ramps[-1].last if self.ramps else 0.0

    def knots(self) -> Iterator[float]:
        """Times of its ends and of the middles of its ramps, after the first: between them way is
        a cubic of time.
        """
        for begin, _, (seconds, first, last) in self._laid:
            if first != last:
                yield begin + seconds / 2.0
            yield begin + seconds


def rest_to_rest(way: float, seconds: float) -> Ramps:
    """From rest to rest, a fifth of the time speeding up and a fifth slowing down."""
    speed = 1.25 * way / seconds
    ramp = 0.2 * seconds
    return Ramps(
        (Ramp(ramp, 0.0, speed), Ramp(0.6 * seconds, speed, speed), Ramp(ramp, speed, 0.0))
    )


@lru_cache(maxsize=64)
def quickest(way: float, speed: float, acceleration: float, last: float = 0.0) -> Ramps:
    """From rest to ``last``, m/s, in the least time; the mean acceleration of a ramp is half of the
    most.
    """
    mean = acceleration / 2.0
    top = min(speed, math.sqrt(max(way * mean + last * last / 2.0, last * last)))
    up = Ramp(top / mean, 0.0, top)
    down = Ramp((top - last) / mean, top, last)
    even = max(way - up.way - down.way, 0.0)
    return Ramps((up, Ramp(even / top if top > 0.0 else 0.0, top, top), down))


@lru_cache(maxsize=64)
def landing(drop: float, speed: float) -> Ramps:
    """Down from so far over known ground, and ``BELOW`` it where there is none."""
    slow = min(ABOVE, drop)
    fast = drop - slow
    if fast <= STAYS:
        before: tuple[Ramp, ...] = (Ramp(SETTLED, 0.0, TOUCH_SPEED),)
        slow = max(drop - before[0].way, 0.0)
    else:
        before = quickest(fast, max(speed, TOUCH_SPEED), JERKY, TOUCH_SPEED).ramps
    stop = Ramp(SETTLED, TOUCH_SPEED, 0.0)
    even = max(slow + BELOW - stop.way, 0.0) / TOUCH_SPEED
    return Ramps((*before, Ramp(even, TOUCH_SPEED, TOUCH_SPEED), stop))


def legs_on_known_ground(plan: StepPlan, terrain: TerrainMap) -> frozenset[int]:
    """The legs that a plan sets down where the ground has been seen or touched."""
    return frozenset(
        leg
        for leg in plan.swing
        if leg not in plan.end.lifted and terrain.is_known(*plan.end.feet[leg][:2])
    )


class SwingTable(NamedTuple):
    """Knots of a step: times, feet and how fast they are at them, m/s, and the phases between."""

    times: list[float]
    feet: list[list[Point]]
    rates: list[list[Point]]
    phases: list[Phase]


def smooth_swing(plan: StepPlan, machine: Machine, known: Collection[int]) -> SwingTable:
    """The knots of a decided step with smooth swings; ``known`` are legs that land on known
    ground.
    """
    return _Smoothing(plan, machine, known).table()


def as_planned(plan: StepPlan) -> SwingTable:
    """The knots of a step as they are, feet at their mean speed between them."""
    times: list[float] = plan.times.tolist()
    feet = feet_of(plan)
    rates = [[(0.0, 0.0, 0.0)] * len(feet[0])]
    for k in range(1, len(times)):
        seconds = max(times[k] - times[k - 1], STAYS)
        ends = zip(feet[k - 1], feet[k], strict=True)
        rates.append([_mean(a, b, seconds) for a, b in ends])
    return SwingTable(times, feet, rates, list(plan.phases))


def _mean(a: Point, b: Point, seconds: float) -> Point:
    return (b[0] - a[0]) / seconds, (b[1] - a[1]) / seconds, (b[2] - a[2]) / seconds


def cubic_between(
    a: Point, b: Point, first: Point, last: Point, seconds: float, share: float
) -> tuple[Point, Point]:
    """Place and velocity at a share of the cubic from a to b with these velocities at its ends."""
    out = [_cubic(*axis, seconds, share) for axis in zip(a, b, first, last, strict=True)]
    (x, vx), (y, vy), (z, vz) = out
    return (x, y, z), (vx, vy, vz)


def _cubic(
    a: float, b: float, first: float, last: float, seconds: float, u: float
) -> tuple[float, float]:
    slope = (b - a) / seconds
    square = 3.0 * slope - 2.0 * first - last
    cube = first + last - 2.0 * slope
    value = a + seconds * u * (first + u * (square + u * cube))
    return value, first + u * (2.0 * square + 3.0 * u * cube)


def gentle(plan: StepPlan, machine: Machine, known: Collection[int], most: float) -> StepPlan:
    """A plan of a posture, or of feet that are set down, with smooth swings; a body that shifts on
    all its feet begins and ends at rest and speeds up by no more than ``most``, m/s².

    What moves body and feet at once is left as it is.
    """
    if plan.rates is not None:
        return plan
    if (plan.body == plan.body[0]).all():
        return _with_smooth_swing(plan, machine, known) if plan.swing else plan
    if any(phase in IN_THE_AIR for phase in plan.phases):
        return plan
    return _shifted_gently(plan, most)


def _with_smooth_swing(plan: StepPlan, machine: Machine, known: Collection[int]) -> StepPlan:
    table = smooth_swing(plan, machine, known)
    if len(table.times) < 2:
        return plan
    return changed(
        plan,
        times=np.array(table.times),
        body=np.repeat(plan.body[:1], len(table.times), axis=0),
        feet=np.array(table.feet),
        foot_rates=np.array(table.rates),
        phases=tuple(table.phases),
    )


def _shifted_gently(plan: StepPlan, most: float) -> StepPlan:
    """Every straight line of a body's way as a cubic from rest to rest."""
    corners = _corners(plan.body)
    times = [0.0]
    for a, b in zip(corners, corners[1:], strict=False):
        way = math.dist(plan.body[a, :2], plan.body[b, :2])
        planned = float(plan.times[b] - plan.times[a])
        times.append(times[-1] + max(planned, math.sqrt(6.0 * way / most)))
    return changed(
        plan,
        times=np.array(times),
        body=plan.body[corners],
        rates=np.zeros((len(corners), 4)),
        feet=plan.feet[corners],
        phases=(plan.phases[0],) * (len(corners) - 1),
    )


def _corners(body: Array) -> list[int]:
    """Rows of a body's way at which it changes its direction, the first and the last."""
    out = [0]
    for k in range(1, len(body) - 1):
        before = body[k] - body[out[-1]]
        after = body[k + 1] - body[k]
        sizes = float(np.linalg.norm(before) * np.linalg.norm(after))
        if sizes > STAYS * STAYS and float(before @ after) < (1.0 - 1e-9) * sizes:
            out.append(k)
    return [*out, len(body) - 1]


class _Run(NamedTuple):
    """Stretches of one phase in a row: knots from ``first`` to ``last``."""

    phase: Phase
    first: int
    last: int


class _Smoothing:
    """One step's knots on their way to smooth ones."""

    def __init__(self, plan: StepPlan, machine: Machine, known: Collection[int]) -> None:
        self.times: list[float] = plan.times.tolist()
        self.feet = feet_of(plan)
        self.swing = [leg for leg in plan.swing if leg not in plan.end.lifted]
        ways = zip(*self.feet, strict=True)
        moving = {leg for leg, way in enumerate(ways) if way.count(way[0]) < len(way)}
        self.others_stand = moving <= {*self.swing}  # no foot moves but those that swing
        self.ends = plan.end.feet
        self.known = known
        self.speed = speed_leaning(machine, (plan.lean or plan.end.lean, plan.end.lean))
        self.runs = list(_runs(plan.phases))

    def table(self) -> SwingTable:
        """All of it."""
        still = [REST] * len(self.ends)
        out = SwingTable([0.0], [self.feet[0]], [still], [])
        seconds = self._seconds()
        for run, lasts in zip(self.runs, seconds, strict=True):
            if run.phase in IN_THE_AIR and lasts > STAYS:
                self._add_smooth(out, run, lasts)
            else:
                self._add_as_planned(out, run)
        return out

    def _seconds(self) -> list[float]:
        """How long each run takes."""
        planned = [self.times[run.last] - self.times[run.first] for run in self.runs]
        out = list(planned)
        for k, run in enumerate(self.runs):
            if run.phase is Phase.UP:
                out[k] = max(planned[k], self._longest(run, self._raised))
            elif run.phase is Phase.DOWN:
                least = 0.0 if self._all_known(run) else planned[k]
                out[k] = max(least, self._longest(run, self._lowered)) or planned[k]
        longer = math.fsum(out) - math.fsum(planned)
        for k, run in enumerate(self.runs):
            if run.phase is Phase.RETURN and longer > 0.0:
                least = min(planned[k], self._least_return(run))
                shorter = min(longer, planned[k] - least)
                out[k] = planned[k] - shorter
                longer -= shorter
        return out

    def _longest(self, run: _Run, profile: Callable[[_Run, int], Ramps]) -> float:
        return max([profile(run, leg).seconds for leg in self._moving(run)], default=0.0)

    def _moving(self, run: _Run) -> list[int]:
        return [leg for leg in self.swing if self._length(run, leg) > STAYS]

    def _all_known(self, run: _Run) -> bool:
        return all(leg in self.known for leg in self._moving(run))

    def _length(self, run: _Run, leg: int) -> float:
        return math.dist(self.feet[run.first][leg], self.feet[run.last][leg])

    def _raised(self, run: _Run, leg: int) -> Ramps:
        return quickest(self._length(run, leg), VERTICAL_SHARE * self.speed[2], JERKY)

    def _lowered(self, run: _Run, leg: int) -> Ramps:
        if leg not in self.known:
            return self._raised(run, leg)
        drop = max(self.feet[run.first][leg][2] - self.ends[leg][2], 0.0)
        return landing(drop, VERTICAL_SHARE * self.speed[2])

    def _least_return(self, run: _Run) -> float:
        """How short a return may be made."""
        least = 0.0
        for leg in self._moving(run):
            way = zip(self.feet[run.first][leg], self.feet[run.last][leg], self.speed, strict=True)
            most = max(abs(b - a) / limit for a, b, limit in way)
            least = max(least, 1.25 * most / RETURN_SHARE)
        return least

    def _add_as_planned(self, out: SwingTable, run: _Run) -> None:
        start = out.times[-1] - self.times[run.first]
        seconds = max(self.times[run.last] - self.times[run.first], STAYS)
        drift = self._drift(run, seconds)
        for k in range(run.first + 1, run.last + 1):
            _add(out, start + self.times[k], self.feet[k], drift, run.phase)

    def _add_smooth(self, out: SwingTable, run: _Run, seconds: float) -> None:
        ways = {leg: self._way(run, leg, seconds) for leg in self.swing}
        start = out.times[-1]
        bent = any(len(way.path) > 2 for way in ways.values())
        drift = self._drift(run, seconds)
        stand = self.others_stand or self._others_stand_in(run)
        for t in _merged([*ways.values()], seconds, PIECES if bent else 1):
            share = min(t / seconds, 1.0)
            feet = list(self.feet[run.first]) if stand else self._carried(run, share)
            rates = list(drift)
            for leg, way in ways.items():
                feet[leg], rates[leg] = way.at(t)
            _add(out, start + t, feet, rates, run.phase)

    def _way(self, run: _Run, leg: int, seconds: float) -> _Way:
        """That of a swinging foot through a run."""
        path = self._path(run, leg)
        length = math.fsum(math.dist(a, b) for a, b in pairwise(path))
        if length <= STAYS or run.phase is not Phase.DOWN or leg not in self.known:
            return _Way(path, rest_to_rest(length, seconds))
        profile = self._lowered(run, leg)
        wait = Ramp(max(seconds - profile.seconds, 0.0), 0.0, 0.0)
        return _Way(path, Ramps((wait, *profile.ramps)))

    def _path(self, run: _Run, leg: int) -> list[Point]:
        """The corners of a leg's way in a run, from the first to the last that differ."""
        rows = self.feet[run.first : run.last + 1]
        path = [rows[0][leg]]
        if run.phase is Phase.DOWN and leg in self.known and self._length(run, leg) > STAYS:
            x, y, z = self.feet[run.last][leg]
            return [path[0], (x, y, min(max(self.ends[leg][2] - BELOW, z), path[0][2]))]
        for row in rows[1:]:
            if math.dist(row[leg], path[-1]) > STAYS:
                path.append(row[leg])
        return [path[0], path[-1]] if _is_straight(path) else path

    def _others_stand_in(self, run: _Run) -> bool:
        """True when no foot but those that swing moves in a run."""
        begin, *rows = self.feet[run.first : run.last + 1]
        others = [leg for leg in range(len(begin)) if leg not in self.swing]
        return all(row[leg] == begin[leg] for row in rows for leg in others)

    def _carried(self, run: _Run, share: float) -> list[Point]:
        """Feet that stand, and feet that stay in the air, at a share of a run's time."""
        begin, end = self.times[run.first], self.times[run.last]
        t = begin + share * (end - begin)
        k = min(max(bisect_right(self.times, t) - 1, run.first), run.last - 1)
        part = (t - self.times[k]) / max(self.times[k + 1] - self.times[k], STAYS)
        part = min(max(part, 0.0), 1.0)
        rows = zip(self.feet[k], self.feet[k + 1], strict=True)
        return [a if a == b else between(a, b, part) for a, b in rows]

    def _drift(self, run: _Run, seconds: float) -> list[Point]:
        """Mean speed of every foot: of one that stays in the air, what it goes on by."""
        ends = zip(self.feet[run.first], self.feet[run.last], strict=True)
        return [REST if a == b else _mean(a, b, seconds) for a, b in ends]


class _Way:
    """A foot's way along corners in the time of a profile."""

    def __init__(self, path: Sequence[Point], profile: Ramps) -> None:
        self.path = path
        self.profile = profile
        self._marks = [0.0]
        self._lines: list[tuple[float, Point, Point]] = []  # length, beginning, way to the end
        for a, b in pairwise(path):
            mark = self._marks[-1] + math.dist(a, b)
            (x, y, z), (ex, ey, ez) = a, b
            self._lines.append((mark - self._marks[-1], a, (ex - x, ey - y, ez - z)))
            self._marks.append(mark)

    def at(self, t: float) -> tuple[Point, Point]:
        """Place and velocity at a time."""
        lines = self._lines
        if not lines:
            return self.path[0], REST
        way, speed = self.profile.at(t)
        if way >= self._marks[-1]:
            return self.path[-1], REST
        k = 0
        if len(lines) > 1:
            k = min(max(bisect_right(self._marks, way) - 1, 0), len(lines) - 1)
        length, (x, y, z), (dx, dy, dz) = lines[k]
        share = min((way - self._marks[k]) / length, 1.0)
        place = x + share * dx, y + share * dy, z + share * dz
        return place, (speed * dx / length, speed * dy / length, speed * dz / length)


def _runs(phases: Sequence[Phase]) -> Iterator[_Run]:
    k = 0
    for phase, members in groupby(phases):
        count = len(list(members))
        yield _Run(phase, k, k + count)
        k += count


def _merged(ways: Sequence[_Way], seconds: float, pieces: int) -> list[float]:
    """Times of the knots of all ways, and of even pieces; the last is the end."""
    times = {seconds * k / pieces for k in range(1, pieces)}
    for way in ways:
        times.update(way.profile.knots())
    out: list[float] = []
    for t in sorted(times):
        if t < seconds - 1e-3 and t - (out[-1] if out else 0.0) > 1e-3:
            out.append(t)
    return [*out, seconds]


def _is_straight(path: Sequence[Point]) -> bool:
    """True when no corner is off the line between the ends."""
    a, b = path[0], path[-1]
    length = math.dist(a, b)
    if length <= STAYS:
        return True
    for p in path[1:-1]:
        share = math.dist(a, p) / length
        if math.dist(between(a, b, share), p) > 1e-6:
            return False
    return True


def _add(out: SwingTable, time: float, feet: list[Point], rates: list[Point], phase: Phase) -> None:
    out.times.append(time)
    out.feet.append(feet)
    out.rates.append(rates)
    out.phases.append(phase)
