"""The body's way between switching points: a smooth curve that stays inside every support.

The papers lead the centre of gravity along the reference (H: the straight line L_G, K: the trace).
On that line the polygon margin falls to a millimetre (H at 45°: L_G runs along the diagonal), which
no machine with mass can stand on. The same footholds carry safely when the body is swayed a few
centimetres aside of the reference into each support. Here the sway is found as a function of time:

* At every *key* (a leg lifts, a foot lands) the lateral offset must lie between two bounds, so that
  the centre of gravity keeps the wanted margin in the polygons on both sides of that instant.
* The shortest way through these gates is a polyline (a taut string); rates at the keys by
  Fritsch & Carlson 1980 make it a monotone cubic, continuous in velocity, that stays between them.

Progress along the reference is left as it was planned. Lengths in metres, times in seconds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from ..geometry.polygons import Polygon
from ..geometry.transforms import XY

OFFSET_MAX = 0.05  # m aside of the reference at most; more: see legs leave their reach
SWEEPS = 40  # of the taut string through its gates; fewer: see it cut corners by millimetres
TAUT = 1e-7  # m; a string that moves by less in a sweep is taut
ROUNDING = 1e-9  # s
SHORTEST = 0.02  # s; keys nearer than this count as this far apart


class Key(NamedTuple):
    """An instant at which a leg lifts or a foot lands, and how far aside the body may be then."""

    time: float  # s from the step-switching point
    low: float  # m, least lateral offset (positive to the left of the course)
    high: float  # m, largest; below ``low`` when no offset keeps the margin


class SupportPhase(NamedTuple):
    """Legs in the air for a while, and what the others leave of the ground plane meanwhile."""

    lift: float  # s from the step-switching point
    land: float
    polygon: Polygon  # of the feet that carry
    at_lift: XY  # the reference then, absolute frame
    at_land: XY


class Knot(NamedTuple):
    """Value and rate of a smooth function at a time."""

    time: float
    value: float
    rate: float


def lateral_bounds(
    polygon: Polygon, x: float, y: float, across: tuple[float, float], margin: float
) -> tuple[float, float]:
    """Offsets along the unit vector ``across`` at which (x, y) keeps ``margin`` inside the polygon.

    Bounds are cut to ``OFFSET_MAX``. Where no offset keeps the margin both are the offset that
    keeps most of it. ``polygon`` is convex and counter-clockwise; (0, 0) without one.
    """
    if len(polygon) < 3:
        return 0.0, 0.0
    low = -OFFSET_MAX
    high = OFFSET_MAX
    lines = edges_across(polygon, x, y, across)
    for depth, rate in lines:
        if rate > 1e-9:
            low = max(low, (margin - depth) / rate)
        elif rate < -1e-9:
            high = min(high, (margin - depth) / rate)
    if low <= high:
        return low, high
    best = _deepest(lines)
    return best, best


def nearest_edge_normal(polygon: Polygon, x: float, y: float) -> XY:
    """The unit vector into the polygon, square to the edge that (x, y) is nearest to, or farthest
    outside of.
    """
    best = (0.0, 1.0)
    least = math.inf
    ax, ay = polygon[-1]
    for bx, by in polygon:
        length = math.hypot(bx - ax, by - ay)
        nx, ny = (ay - by) / length, (bx - ax) / length
        depth = nx * (x - ax) + ny * (y - ay)
        if depth < least:
            least = depth
            best = (nx, ny)
        ax, ay = bx, by
    return best


def edges_across(
    polygon: Polygon, x: float, y: float, across: tuple[float, float]
) -> list[tuple[float, float]]:
    """Of every edge: how deep (x, y) lies inside it, m, and how that changes along ``across``."""
    lines = []
    ax, ay = polygon[-1]
    for bx, by in polygon:
        ex = bx - ax
        ey = by - ay
        length = (ex * ex + ey * ey) ** 0.5
        depth = (ex * (y - ay) - ey * (x - ax)) / length
        rate = (ex * across[1] - ey * across[0]) / length
        lines.append((depth, rate))
        ax = bx
        ay = by
    return lines


def _deepest(lines: list[tuple[float, float]]) -> float:
    """The offset within ``OFFSET_MAX`` at which the least depth is largest.

    The least of lines is concave: the best point is an end, or where a rising and a falling line
    cross.
    """
    candidates = [-OFFSET_MAX, OFFSET_MAX]
    for depth_a, rate_a in lines:
        for depth_b, rate_b in lines:
            if rate_a > rate_b + 1e-9:
                crossing = (depth_b - depth_a) / (rate_a - rate_b)
                candidates.append(min(max(crossing, -OFFSET_MAX), OFFSET_MAX))
    return max(candidates, key=lambda offset: min(depth + rate * offset for depth, rate in lines))


def meeting(earlier: tuple[float, float], later: tuple[float, float]) -> tuple[float, float]:
    """The bounds that two pairs of bounds share. Where they share nothing, the earlier's end that
    is nearer to the later: the body waits there until the later support may be had.
    """
    low = max(earlier[0], later[0])
    high = min(earlier[1], later[1])
    if low <= high:
        return low, high
    nearest = min(max(later[0], earlier[0]), earlier[1])
    return nearest, nearest


def through_gates(start: Knot, keys: Sequence[Key]) -> list[Knot]:
    """The offset and its rate at ``start`` and at every key after it.

    The offsets are those of the shortest way in the plane of time and offset (its square, so that
    the answer is one linear pass after the other: Gauss-Seidel sweeps until it is taut, cut to
    the bounds). The last rate is 0: beyond what is foreseen the body goes along the reference.
    """
    times = [start.time, *(key.time for key in keys)]
    values = [start.value, *(min(max(0.0, key.low), key.high) for key in keys)]
    pulls = [1.0 / max(b - a, SHORTEST) for a, b in pairwise(times)]
    for _ in range(SWEEPS):
        if _sweep(values, keys, pulls) < TAUT:
            break
    rates = monotone_rates(times, values, start.rate, 0.0)
    return [Knot(*knot) for knot in zip(times, values, rates, strict=True)]


def _sweep(values: list[float], keys: Sequence[Key], pulls: Sequence[float]) -> float:
    """Move the value at every key to where the way over it is shortest, that of the last to its
    neighbour's; the farthest any has moved, m. ``pulls`` of the stretches between them, 1/s.
    """
    moved = 0.0
    last = len(keys)
    for k, (_, low, high) in enumerate(keys, 1):
        value = values[k - 1]
        if k < last:
            before = pulls[k - 1]
            after = pulls[k]
            value = (before * value + after * values[k + 1]) / (before + after)
        if value < low:
            value = low
        if value > high:
            value = high
        change = abs(value - values[k])
        if change > moved:
            moved = change
        values[k] = value
    return moved


def monotone_rates(
    times: Sequence[float], values: Sequence[float], first: float, last: float
) -> list[float]:
    """Rates at the times that make the cubic through the values monotone between them.

    Fritsch & Carlson 1980 with the weighted harmonic mean of Fritsch & Butland 1984; ``first`` and
    ``last`` are the rates at the ends.
    """
    rates = [first]
    for k in range(1, len(times) - 1):
        before = times[k] - times[k - 1]
        after = times[k + 1] - times[k]
        slope = (values[k] - values[k - 1]) / max(before, SHORTEST)
        next_slope = (values[k + 1] - values[k]) / max(after, SHORTEST)
        if slope * next_slope <= 0.0:
            rates.append(0.0)
            continue
        weight = 2.0 * after + before
        next_weight = after + 2.0 * before
        rates.append((weight + next_weight) / (weight / slope + next_weight / next_slope))
    if len(times) > 1:
        rates.append(last)
    return rates


def at(knots: Sequence[Knot], time: float) -> Knot:
    """Value and rate of the cubic through the knots at a time; held beyond the last."""
    return Knot(time, *sampled(knots, (time,))[0])


def sampled(knots: Sequence[Knot], times: Sequence[float]) -> list[XY]:
    """Value and rate of the cubic through the knots at times in order; the value is held beyond the
    last.
    """
    out = []
    first, last = knots[0], knots[-1]
    k = 0
    begin = until = first.time
    span = begin_value = begin_rate = square = cube = 0.0
    for time in times:
        if time <= first.time:
            out.append((first.value, first.rate))
            continue
        if time >= last.time:
            out.append((last.value, last.rate if time <= last.time + ROUNDING else 0.0))
            continue
        if time > until:  # on to the stretch it lies in
            while time > knots[k].time:
                k += 1
            begin, begin_value, begin_rate = knots[k - 1]
            until, end_value, end_rate = knots[k]
            span = until - begin
            slope = (end_value - begin_value) / span
            square = 3.0 * slope - 2.0 * begin_rate - end_rate
            cube = begin_rate + end_rate - 2.0 * slope
        gone = time - begin
        u = gone / span
        value = begin_value + gone * (begin_rate + u * (square + u * cube))  # Hermite's form
        out.append((value, begin_rate + u * (2.0 * square + 3.0 * u * cube)))
    return out


def largest_acceleration(knots: Sequence[Knot]) -> float:
    """The largest acceleration of the cubic through the knots, m/s² (at an end of a stretch)."""
    largest = 0.0
    for a, b in zip(knots, knots[1:], strict=False):
        largest = max(largest, *map(abs, _accelerations(a, b)))
    return largest


def _accelerations(a: Knot, b: Knot) -> tuple[float, float]:
    """At the ends of one stretch."""
    span = max(b.time - a.time, SHORTEST)
    slope = (b.value - a.value) / span
    first = 2.0 * (3.0 * slope - 2.0 * a.rate - b.rate) / span
    last = 2.0 * (a.rate + 2.0 * b.rate - 3.0 * slope) / span
    return first, last
