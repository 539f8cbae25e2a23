"""Standing on a slope: strides as long as the legs' height allows, and a body that is level or
leans with the ground.

*Shortened strides.* A level body on a slope γ needs feet at heights that differ by γ times what
they stand apart; the legs reach z* (H fig. 1). Where the standard walk of the machine's own boxes
needs more than that, the walker plans with smaller ones: inner edges kept, mirrored, the pair of
lengths with the longest stroke λ* whose standard walk fits. Elsewhere, and so on every slope the
whole boxes can walk, nothing changes.

*Leaning.* A body whose floor has the gradient l needs heights for γ - l only, but stands as far as
H·|l| downhill of the middle of its own feet. The standard walk wants boxes mirrored about the
centre of gravity, so it loses 2·H·|l| of every box along the slope (titan3: 0.15 m of 0.5 m for
5°). A lean is a trade, and follows the ground only as far as it leaves ``SHARE`` of the longest
stride any lean allows; across a steep slope it may also gain (docs/slopes.md has the figures).

*Planning with a lean* goes on in a sheared frame, z' = z - l·(x, y): there the floor is level,
lines stay lines and verticals vertical, and a foot's height in body axes is z' times the cosine of
the lean, whatever its place. Below it nothing knows of leans. The plan is sheared back; Level C
turns the body to the lean (``control.posture_controller``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..geometry.paths import Box
from ..geometry.transforms import direction
from ..motion.body_tilt import (
    LEVEL,
    FrameCache,
    Lean,
    ShearedFrame,
    approached,
    in_body,
    leaned,
    reaches,
    rounded,
)
from ..motion.strides import stroke_length
from ..motion.tilted_reach import SIDES, change_of, mirrored_part, whole_reach, with_box
from ..protocols import BodyAttitude, PlanFunction, PlanningJob
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..terrain.slope import slope_at, slope_under
from ..types import Array, Command, Gait, Stance, StepPlan
from .gait import nominal_gait

# of the longest stride any lean allows; 1: see it hardly lean at all, 0.3: see it creep with its
# nose in the air
SHARE = 0.6
LEAN_GRAIN = 0.02  # a lean is a multiple of this; smaller: see it nod on rough ground
LEAN_MAX = 0.35  # m per m, 19°
# of a grain, by which a slope must change before it counts; less than 0.8: see strides and leans
# tremble
STAYS = 1.0
# m per m to which a slope is rounded before strides are fitted to it; smaller: see strides change
# on rough ground
SLOPE_GRAIN = 0.01
SPANS = 12  # lengths of a box that are tried
# of z*, that are tried: a leaning leg reaches a wider box over heights that differ less
HALVES = (0.4, 0.7, 1.0)
SPAN_LEAST = 0.14  # of a box's mean side; footholds must be found in what is left
# of z*, kept beyond what the standard walk needs; 0: see it stumble over the cells' own steps
SLACK = 0.05
# m of planned margin a step that leans must have; 0: see it rock off a narrow triangle on 25°
SURE = 0.002


class SlopeAdaptation:
    """A planner that stands on slopes as its machine can: strides fitted, and the body leaning
    when it is to follow the ground.

    ``planner_for`` makes the planner of one machine. The lean is remembered in ``Stance``;
    ``attitude`` may be changed at any time and counts from the next step planned on.
    """

    def __init__(
        self,
        machine: Machine,
        gait: Gait,
        planner_for: Callable[[Machine], PlanFunction],
        attitude: BodyAttitude = "level",
    ) -> None:
        self.machine = machine
        self.gait = gait
        self.attitude = attitude
        self._planner_for = planner_for
        self._shears = FrameCache()
        self._slope = LEVEL  # that the present strides are fitted to
        # share of the lean it would take on this slope: less after steps with it that stood on an
        # edge
        self._trust = 1.0

    def __call__(self, stance: Stance, command: Command, terrain: TerrainMap) -> PlanningJob:
        frame = self.frame(stance, command, terrain)
        answer = yield from self._planned(frame, command)
        if frame.lean != LEVEL or stance.lean != LEVEL:
            if isinstance(answer, StepPlan) and not on_edge(answer):
                return frame.restored(answer, stance)
            self._trust /= 2
            if stance.lean != LEVEL:
                back = leaned(stance, approached(stance.lean, LEVEL), self.machine)
                return back or (
                    frame.restored(answer, stance) if isinstance(answer, StepPlan) else answer
                )
            frame = self.frame(stance, command, terrain, may_lean=False)
            answer = yield from self._planned(frame, command)
        if isinstance(answer, StepPlan) or frame.machine is self.machine:
            return answer
        # feet where the shorter strides do not want them
        return (yield from self._planner_for(self.machine)(stance, command, terrain))

    def _planned(self, frame: ShearedFrame, command: Command) -> PlanningJob:
        return self._planner_for(frame.machine)(frame.stance, command, frame.terrain)

    def frame(
        self, stance: Stance, command: Command, terrain: TerrainMap, may_lean: bool = True
    ) -> ShearedFrame:
        """The lean of the next step, and the frame it is planned in."""
        slope = self._slope_known(slope_under(stance, command, terrain, self.machine))
        lean = self._next_lean(stance, command, slope) if may_lean else LEVEL
        machine = self._fitted(stance, command, slope, lean)
        if machine is None and stance.lean != LEVEL:
            lean = approached(stance.lean, LEVEL)
            machine = self._fitted(stance, command, slope, lean)
        if machine is None:
            machine = whole_reach(
                self.machine,
                self.gait,
                tuple(in_body(each, stance.body[3]) for each in (stance.lean, lean)),
            )
        return self._shears.frame(stance, terrain, machine or self.machine, lean)

    def _fitted(self, stance: Stance, command: Command, slope: Lean, lean: Lean) -> Machine | None:
        course = command.crab_angle if command.turn_rate == 0.0 else None
        return fitted(self.machine, self.gait, stance.body[3], slope, (stance.lean, lean), course)

    def _slope_known(self, measured: Lean) -> Lean:
        """The slope rounded, and the one before as long as it is near: strides that change with
        every step keep no standard walk.
        """
        if math.dist(measured, self._slope) >= STAYS * SLOPE_GRAIN:
            self._slope = rounded(measured[0], SLOPE_GRAIN), rounded(measured[1], SLOPE_GRAIN)
            self._trust = 1.0
        return self._slope

    def _next_lean(self, stance: Stance, command: Command, slope: Lean) -> Lean:
        """One step of lean towards the one that follows the ground as far as it may."""
        target = LEVEL
        if self.attitude == "ground":
            gx, gy = self._followed(stance, command, slope)
            target = towards_level(self._trust * gx), towards_level(self._trust * gy)
        return approached(stance.lean, target)

    def _followed(self, stance: Stance, command: Command, slope: Lean) -> Lean:
        """The lean along the slope that keeps ``SHARE`` of the longest stride."""
        if command.turn_rate != 0.0:
            share = followed_turning(
                self.machine, self.gait, rounded(math.hypot(*slope), SLOPE_GRAIN)
            )
        else:
            share = followed(
                self.machine,
                self.gait,
                _seen(slope, stance.body[3]),
                _whole_degrees(command.crab_angle),
            )
        return share * slope[0], share * slope[1]


def on_edge(plan: StepPlan) -> bool:
    """True of a step so near the edge that a body which leans in it could rock off its feet."""
    return plan.margin_min < min(SURE, plan.standard_margin)


def fitted_at_start(
    machine: Machine,
    gait: Gait,
    crab_angle: float,
    pose: tuple[float, float, float],
    height_at: Callable[[float, float], float],
) -> Machine:
    """The machine whose standard posture fits the ground it is to be set down on, level; itself
    where nothing fits.
    """
    gx, gy = slope_at(machine, pose, height_at)
    slope = rounded(gx, SLOPE_GRAIN), rounded(gy, SLOPE_GRAIN)
    return fitted(machine, gait, pose[2], slope, (LEVEL, LEVEL), crab_angle) or machine


def _seen(gradient: Lean, yaw: float) -> Lean:
    """An absolute gradient in body axes, without the rounding that would miss what was kept of the
    last step.
    """
    ahead, left = in_body(gradient, yaw)
    return round(ahead, 4), round(left, 4)


def _whole_degrees(angle: float) -> int:
    return round(math.degrees(math.remainder(angle, 2 * math.pi)))


# the strides that fit


def fitted(
    machine: Machine,
    gait: Gait,
    yaw: float,
    slope: Lean,
    leans: tuple[Lean, Lean],
    crab_angle: float | None,
) -> Machine | None:
    """The machine whose standard walk fits a slope under a body that leans like this (from, to);
    itself where it does.

    Without a crab angle the body turns: every course and every heading must fit. None when nothing
    fits.
    """
    if leans == (LEVEL, LEVEL) and slope == LEVEL:
        return machine
    if crab_angle is None:
        steep, tilted = math.hypot(*slope), max(math.hypot(*lean) for lean in leans)
        rest = max(math.hypot(slope[0] - lean[0], slope[1] - lean[1]) for lean in leans)
        return _fitted_turning(
            machine,
            gait,
            rounded(steep, SLOPE_GRAIN),
            rounded(rest, SLOPE_GRAIN),
            rounded(tilted, LEAN_GRAIN / 2),
        )
    seen = [_seen(gradient, yaw) for gradient in (slope, *leans)]
    return _fitted(machine, gait, seen[0], (seen[1], seen[2]), _whole_degrees(crab_angle))


@lru_cache(maxsize=512)
def followed(machine: Machine, gait: Gait, slope: Lean, degrees: int) -> float:
    """The largest share of the slope (body axes) the body may lean by: the stride is at least
    ``SHARE`` of the longest with any lean.
    """
    return _share_kept(
        slope,
        [
            _stride_with(machine, gait, slope, (k / 10 * slope[0], k / 10 * slope[1]), degrees)
            for k in range(11)
        ],
    )


@lru_cache(maxsize=128)
def followed_turning(machine: Machine, gait: Gait, steep: float) -> float:
    """The same for a body that turns, of a slope of any direction."""
    found = []
    for k in range(11):
        lean = k / 10 * steep
        fit = _fitted_turning(
            machine, gait, steep, rounded(steep - lean, SLOPE_GRAIN), rounded(lean, LEAN_GRAIN / 2)
        )
        found.append(
            0.0
            if fit is None
            else min(
                fit.reach.x_span / machine.reach.x_span, fit.reach.y_span / machine.reach.y_span
            )
        )
    return _share_kept((steep, 0.0), found)


def towards_level(gradient: float) -> float:
    """The lean nearest to a gradient that is no steeper."""
    return math.trunc(gradient / LEAN_GRAIN + 1e-9 * (1 if gradient > 0.0 else -1)) * LEAN_GRAIN


def _share_kept(slope: Lean, strides: list[float]) -> float:
    enough, steep = SHARE * max(strides), math.hypot(*slope)
    kept = [
        k / 10
        for k, stride in enumerate(strides)
        if stride >= enough > 0.0 and k / 10 * steep <= LEAN_MAX
    ]
    return kept[-1] if kept else 0.0


def _stride_with(machine: Machine, gait: Gait, slope: Lean, lean: Lean, degrees: int) -> float:
    fit = _fitted(machine, gait, slope, (lean, lean), degrees)
    return (
        0.0
        if fit is None
        else stroke_length(fit.reach.x_span, fit.reach.y_span, math.radians(degrees))
    )


class BoxRule(NamedTuple):
    """How boxes are chosen. Both functions take lengths along x and y, arrays of one shape."""

    needs: Callable[[Array, Array, Array], Array]  # inner corner, lengths -> heights apart, m
    worth: Callable[[Array, Array], Array]


@lru_cache(maxsize=2048)
def _fitted(
    machine: Machine, gait: Gait, slope: Lean, leans: tuple[Lean, Lean], degrees: int
) -> Machine | None:
    level = leans == (LEVEL, LEVEL)
    angle = math.radians(degrees)
    rests = {(slope[0] - lean[0], slope[1] - lean[1]) for lean in leans}

    def needs(inner: Array, x: Array, y: Array) -> Array:
        apart = [spread(machine, gait, rest, angle, inner, x, y) for rest in rests]
        return np.asarray(np.max(apart, axis=0))

    rule = BoxRule(needs, lambda x, y: _strokes(x, y, angle))
    return _longest(machine, gait, leans if leans[0] != leans[1] else leans[:1], level, rule)


@lru_cache(maxsize=512)
def _fitted_turning(
    machine: Machine, gait: Gait, steep: float, rest: float, tilted: float
) -> Machine | None:
    """As ``_fitted`` for any heading: the whole boxes on the diagonal of the slope, and leans to
    all four sides.
    """
    leans = [(tilted, 0.0), (-tilted, 0.0), (0.0, tilted), (0.0, -tilted)] if tilted else [LEVEL]
    full = machine.reach
    across = 2 * rest * math.hypot(full.x0 + full.x_span, full.y0 + full.y_span)
    if not tilted and across <= full.z_span:
        return machine

    def needs(inner: Array, x: Array, y: Array) -> Array:
        return np.asarray(2 * rest * np.hypot(inner[0] + x, inner[1] + y))

    rule = BoxRule(needs, lambda x, y: np.minimum(x / full.x_span, y / full.y_span))
    return _longest(machine, gait, leans, False, rule)


def _longest(
    machine: Machine, gait: Gait, leans: Sequence[Lean], level: bool, rule: BoxRule
) -> Machine | None:
    """Of the boxes that fit the one worth most, and of those the largest."""
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


def spread(
    machine: Machine, gait: Gait, rest: Lean, angle: float, inner: Array, x: Array, y: Array
) -> Array:
    """How much higher the highest foot of the nominal walk stands than the lowest, m, on a slope
    ``rest`` above the body's floor.

    For boxes of lengths ``x`` and ``y``; at the switching points, where four feet stand.
    """
    nominal = nominal_gait(machine, gait, angle)
    ratios = np.array(nominal.layouts) / nominal.stride  # [u][i], legs of the gait frame
    cx, cy, stride = inner[0] + x / 2, inner[1] + y / 2, _strokes(x, y, angle)
    critical, off = np.arctan2(cy, cx), abs(math.remainder(angle, 2 * math.pi))
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
