"""The longest strides that fit a slope, and how far a body may lean with the ground for them.

A level body on a slope γ needs feet at heights that differ by γ times what they stand apart; the
legs reach z* (H fig. 1). Where the nominal walk of the machine's own boxes needs more than that,
the walker plans with smaller ones: inner edges kept, mirrored, the pair of lengths with the longest
stroke λ* whose nominal walk fits. A body whose floor has the gradient l needs heights for γ - l
only, but stands as far as H·|l| downhill of the middle of its own feet: mirrored about the centre
of gravity every box loses 2·H·|l| along the slope (titan3: 0.15 m of 0.5 m for 5°). A lean is a
trade, and follows the ground only as far as it leaves ``SHARE`` of the longest stride any lean
allows.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from ..geometry.paths import Box
from ..geometry.transforms import Pose, direction
from ..robot.model import Machine
from ..robot.quadrants import SIDES, mirrored_part
from ..terrain.slope import slope_at
from ..types import Array, Gait
from .body_tilt import LEVEL, Lean, in_body, reaches, rounded
from .strides import stroke_length
from .tilted_reach import change_of, with_box

# of the longest stride any lean allows; 1: see it hardly lean at all, 0.3: see it creep with its
# nose in the air
SHARE = 0.6
LEAN_GRAIN = 0.02  # a lean is a multiple of this; smaller: see it nod on rough ground
LEAN_MAX = 0.35  # m per m, 19°
# m per m to which a slope is rounded before strides are fitted to it; smaller: see strides change
# on rough ground
SLOPE_GRAIN = 0.01
# of a slope, by which a body may lean; finer: see it think longer and lean hardly better
LEAN_SHARES = tuple(k / 10 for k in range(11))
FITTING = 40  # what fitting strides to one lean weighs, in postures looked at
SPANS = 12  # lengths of a box that are tried
# of z*, that are tried: a leaning leg reaches a wider box over heights that differ less
HALVES = (0.4, 0.7, 1.0)
SPAN_LEAST = 0.14  # of a box's mean side; footholds must be found in what is left
# of z*, kept beyond what the nominal walk needs; 0: see it stumble over the cells' own steps
SLACK = 0.05


class SlopeWalker(NamedTuple):
    """A machine and its nominal walk, as strides are fitted to it."""

    machine: Machine
    gait: Gait
    # crab angle -> [u][i]: how far leg i stands ahead of C_i when leg u has just landed, in strides
    layouts: Callable[[Machine, Gait, float], Array]


class BoxRule(NamedTuple):
    """How boxes are chosen. Both functions take lengths along x and y, arrays of one shape."""

    needs: Callable[[Array, Array, Array], Array]  # inner corner, lengths -> heights apart, m
    worth: Callable[[Array, Array], Array]


def fitted(
    walker: SlopeWalker, yaw: float, slope: Lean, leans: tuple[Lean, Lean], crab_angle: float | None
) -> Machine | None:
    """The machine whose nominal walk fits a slope under a body that leans like this (from, to);
    itself where it does.

    Without a crab angle the body turns: every course and every heading must fit. None when nothing
    fits.
    """
    if leans == (LEVEL, LEVEL) and slope == LEVEL:
        return walker.machine
    if crab_angle is None:
        rest = max(math.hypot(slope[0] - lean[0], slope[1] - lean[1]) for lean in leans)
        tilted = max(math.hypot(*lean) for lean in leans)
        return _fitted_turning(walker, rounded(rest, SLOPE_GRAIN), rounded(tilted, LEAN_GRAIN / 2))
    first, last = (_seen(lean, yaw) for lean in leans)
    return _fitted(walker, _seen(slope, yaw), (first, last), _whole_degrees(crab_angle))


def fitted_at_start(
    walker: SlopeWalker,
    crab_angle: float,
    pose: Pose,
    height_at: Callable[[float, float], float],
) -> Machine:
    """The machine whose nominal walk fits the ground it is to be set down on, level; itself where
    nothing fits.
    """
    gx, gy = slope_at(walker.machine, pose, height_at)
    slope = rounded(gx, SLOPE_GRAIN), rounded(gy, SLOPE_GRAIN)
    return fitted(walker, pose[2], slope, (LEVEL, LEVEL), crab_angle) or walker.machine


def followed(walker: SlopeWalker, yaw: float, slope: Lean, crab_angle: float | None) -> float:
    """The largest share of the slope the body may lean by: the stride is at least ``SHARE`` of the
    longest with any lean. Without a crab angle the body turns.
    """
    if crab_angle is None:
        return _followed_turning(walker, rounded(math.hypot(*slope), SLOPE_GRAIN))
    return _followed(walker, _seen(slope, yaw), _whole_degrees(crab_angle))


def towards_level(gradient: float) -> float:
    """The lean nearest to a gradient that is no steeper."""
    return math.trunc(gradient / LEAN_GRAIN + 1e-9 * (1 if gradient > 0.0 else -1)) * LEAN_GRAIN


def _seen(gradient: Lean, yaw: float) -> Lean:
    """An absolute gradient in body axes, without the rounding that would miss what was kept of the
    last step.
    """
    ahead, left = in_body(gradient, yaw)
    return round(ahead, 4), round(left, 4)


def _whole_degrees(angle: float) -> int:
    return round(math.degrees(math.remainder(angle, 2 * math.pi)))


# how far to lean


class Leans:
    """How far one walker leans with the ground, for a caller that has a tick to keep."""

    def __init__(self, walker: SlopeWalker) -> None:
        self._walker = walker
        self._asked: tuple[float, Lean, float | None] | None = None  # last

    def followed(self, yaw: float, slope: Lean, crab_angle: float | None) -> float:
        """``followed`` of this walker."""
        return followed(self._walker, yaw, slope, crab_angle)

    def weighed(self, yaw: float, slope: Lean, crab_angle: float | None) -> Iterator[int]:
        """What ``followed`` is going to ask, one lean after the other: it is remembered. Yields
        what each weighs, in postures looked at; asked the same again, nothing.
        """
        asked = yaw, slope, crab_angle
        if slope == LEVEL or asked == self._asked:
            return
        self._asked = asked
        for share in LEAN_SHARES:
            if crab_angle is None:
                _stride_turning(self._walker, rounded(math.hypot(*slope), SLOPE_GRAIN), share)
            else:
                _stride(self._walker, _seen(slope, yaw), _whole_degrees(crab_angle), share)
            yield FITTING


@lru_cache(maxsize=512)
def _followed(walker: SlopeWalker, slope: Lean, degrees: int) -> float:
    return _share_kept(math.hypot(*slope), partial(_stride, walker, slope, degrees))


def _stride(walker: SlopeWalker, slope: Lean, degrees: int, share: float) -> float:
    """The stride with a lean of this share of the slope, m; 0 when no boxes fit."""
    lean = share * slope[0], share * slope[1]
    fit = _fitted(walker, slope, (lean, lean), degrees)
    if fit is None:
        return 0.0
    return stroke_length(fit.reach.x_span, fit.reach.y_span, math.radians(degrees))


@lru_cache(maxsize=128)
def _followed_turning(walker: SlopeWalker, steep: float) -> float:
    """As ``_followed``, of a slope of any direction."""
    return _share_kept(steep, partial(_stride_turning, walker, steep))


def _stride_turning(walker: SlopeWalker, steep: float, share: float) -> float:
    full = walker.machine.reach
    lean = share * steep
    rest = rounded(steep - lean, SLOPE_GRAIN)
    fit = _fitted_turning(walker, rest, rounded(lean, LEAN_GRAIN / 2))
    if fit is None:
        return 0.0
    return min(fit.reach.x_span / full.x_span, fit.reach.y_span / full.y_span)


def _share_kept(steep: float, stride: Callable[[float], float]) -> float:
    strides = {share: stride(share) for share in LEAN_SHARES}
    enough = SHARE * max(strides.values())
    return max(
        (
            share
            for share, length in strides.items()
            if length >= enough > 0.0 and share * steep <= LEAN_MAX
        ),
        default=0.0,
    )


# the boxes that fit


@lru_cache(maxsize=2048)
def _fitted(
    walker: SlopeWalker, slope: Lean, leans: tuple[Lean, Lean], degrees: int
) -> Machine | None:
    level = leans == (LEVEL, LEVEL)
    angle = math.radians(degrees)
    ratios = walker.layouts(walker.machine, walker.gait, angle)
    rests = {(slope[0] - lean[0], slope[1] - lean[1]) for lean in leans}

    def needs(inner: Array, x: Array, y: Array) -> Array:
        apart = [spread(ratios, rest, angle, inner, x, y) for rest in rests]
        return np.asarray(np.max(apart, axis=0))

    rule = BoxRule(needs, lambda x, y: _strokes(x, y, angle))
    return _longest(walker, leans if leans[0] != leans[1] else leans[:1], level, rule)


@lru_cache(maxsize=512)
def _fitted_turning(walker: SlopeWalker, rest: float, tilted: float) -> Machine | None:
    """As ``_fitted`` for any heading: the whole boxes on the diagonal of a slope ``rest`` above the
    body's floor, and leans to all four sides.
    """
    leans = [(tilted, 0.0), (-tilted, 0.0), (0.0, tilted), (0.0, -tilted)] if tilted else [LEVEL]
    full = walker.machine.reach
    across = 2 * rest * math.hypot(full.x0 + full.x_span, full.y0 + full.y_span)
    if not tilted and across <= full.z_span:
        return walker.machine

    def needs(inner: Array, x: Array, y: Array) -> Array:
        return np.asarray(2 * rest * np.hypot(inner[0] + x, inner[1] + y))

    rule = BoxRule(needs, lambda x, y: np.minimum(x / full.x_span, y / full.y_span))
    return _longest(walker, leans, False, rule)


def _longest(
    walker: SlopeWalker, leans: Sequence[Lean], level: bool, rule: BoxRule
) -> Machine | None:
    """Of the boxes that fit the one worth most, and of those the largest."""
    machine, gait, _ = walker
    full = machine.reach
    inner = np.array([full.x0, full.y0])
    whole = rule.needs(inner, np.array(full.x_span), np.array(full.y_span)) if level else math.inf
    if float(whole) <= full.z_span:
        return machine
    tilted = max(math.hypot(*lean) for lean in leans) != 0.0
    best = LEVEL
    found = None
    for share in HALVES if tilted else (1.0,):
        heights = _heights(machine, gait, share)
        cosine, boxes = reaches(machine, leans, *heights)
        box = mirrored_part(boxes)
        if box is None:
            continue
        spare = SLACK * full.z_span + change_of(leans) * (box[1] + box[3])
        room = (heights[1] - heights[0]) / cosine, spare
        worth, part = _best_part(machine, box, room, rule)
        if worth > best:
            best = worth
            found = with_box(machine, gait, leans, part, heights, cosine)
    return found


def _heights(machine: Machine, gait: Gait, share: float) -> tuple[float, float]:
    """A share of z* about the height the feet have under a standing body, m."""
    low, high = machine.z_range
    if share == 1.0:
        return low, high
    half = share * (high - low) / 2
    return max(low, -gait.height - half), min(high, -gait.height + half)


def _best_part(
    machine: Machine, box: Box, room: tuple[float, float], rule: BoxRule
) -> tuple[tuple[float, float], Box]:
    """Of the parts of a box at its inner corner that need no more height than there is ``room`` for
    (in all, and kept spare) the one worth most, and its worth and area; worth 0 when none fits.
    """
    full = machine.reach
    least = SPAN_LEAST * (full.x_span + full.y_span) / 2
    x1, x2, y1, y2 = box
    shares = np.arange(1, SPANS + 1) / SPANS
    x, y = (grid.ravel() for grid in np.meshgrid(shares * (x2 - x1), shares * (y2 - y1)))
    limit, spare = room
    fits = (rule.needs(np.array([x1, y1]), x, y) + spare <= limit) & (x >= least) & (y >= least)
    if not fits.any():
        return LEVEL, box
    value = np.where(fits, np.round(rule.worth(x, y), 6), -1.0)
    area = x * y
    k = int(np.lexsort((area, value))[-1])
    part = x1, x1 + float(x[k]), y1, y1 + float(y[k])
    return (float(value[k]), float(area[k])), part


def _strokes(x: Array, y: Array, angle: float) -> Array:
    """λ* of boxes of many lengths (``stroke_length``)."""
    c, s = map(abs, direction(angle))
    return np.minimum(
        x / c if c > 1e-12 else np.full(x.shape, np.inf),
        y / s if s > 1e-12 else np.full(y.shape, np.inf),
    )


def spread(ratios: Array, rest: Lean, angle: float, inner: Array, x: Array, y: Array) -> Array:
    """How much higher the highest foot of the nominal walk stands than the lowest, m, on a slope
    ``rest`` above the body's floor.

    For boxes of lengths ``x`` and ``y``; at the switching points, where four feet stand.
    """
    cx, cy, stride = inner[0] + x / 2, inner[1] + y / 2, _strokes(x, y, angle)
    critical = np.arctan2(cy, cx)
    off = abs(math.remainder(angle, 2 * math.pi))
    aside = 1 if math.remainder(angle, 2 * math.pi) > 0.0 else 3
    turns = np.where(off <= critical, 0, np.where(off >= math.pi - critical, 2, aside))
    ux, uy = direction(angle)
    climb = rest[0] * ux + rest[1] * uy
    worst = np.zeros(np.shape(stride))
    for n in np.unique(turns):
        sides = np.array(SIDES)[(np.arange(4) + n) % 4]
        middles = rest[0] * sides[:, 0] * cx[..., None] + rest[1] * sides[:, 1] * cy[..., None]
        for row in ratios:
            heights = middles + climb * stride[..., None] * row
            apart = heights.max(axis=-1) - heights.min(axis=-1)
            worst = np.where(turns == n, np.maximum(worst, apart), worst)
    return np.asarray(worst)
