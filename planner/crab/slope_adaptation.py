"""Standing on a slope: strides as long as the legs' height allows, and a body that is level or
leans with the ground.

*Shortened strides.* A level body on a slope γ needs feet at heights that differ by γ times what
they stand apart; the legs reach z* (H fig. 1). Where the standard walk of the machine's own boxes
needs more than that, the walker thinks with smaller ones: inner edges kept, mirrored, the pair of
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
turns the body to the lean (``reflex``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ..motion.body_tilt import (
    LEVEL,
    Frame,
    Lean,
    Shears,
    approached,
    in_body,
    leaned,
    ordered,
    reaches,
    rounded,
)
from ..motion.strides import stroke_length
from ..protocols import BodyAttitude, PlanFunction, PlanningJob
from ..robot.model import Leg, Machine
from ..terrain.map import TerrainMap
from ..types import Array, Command, Gait, Point, Stance, StepPlan
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
AHEAD = 0.43  # of the reach ahead of the body, the middle of the ground that counts as the slope
SAMPLES = 5  # of the ground, along and across
OUTLIER = 0.4  # of z* from the plane; farther is a block, a pole or a pit and no slope
ENOUGH = 8  # samples that make a slope; fewer: the feet alone
# m of planned margin a step that leans must have; 0: see it rock off a narrow triangle on 25°
SURE = 0.002
# H a second of every leg's speed kept for the lean itself, per m/m that changes in a step; 0: see
# feet land aside
TURNING = 3.5


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
        self.machine, self.gait = machine, gait
        self.attitude = attitude
        self._planner_for = planner_for
        self._shears = Shears()
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

    def _planned(self, frame: Frame, command: Command) -> PlanningJob:
        return self._planner_for(frame.machine)(frame.stance, command, frame.terrain)

    def frame(
        self, stance: Stance, command: Command, terrain: TerrainMap, may_lean: bool = True
    ) -> Frame:
        """The lean of the next step, and the frame it is planned in."""
        slope = self._slope_known(slope_under(stance, command, terrain, self.machine))
        lean = self._next_lean(stance, command, slope) if may_lean else LEVEL
        machine = self._fitted(stance, command, slope, lean)
        if machine is None and stance.lean != LEVEL:
            lean = approached(stance.lean, LEVEL)
            machine = self._fitted(stance, command, slope, lean)
        if machine is None:
            machine = whole(
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
        """One step from the present lean towards the one that follows the ground as far as it may."""
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
    """True of a step so daring that a body which leans over in it could rock off its feet."""
    return plan.margin_min < min(SURE, plan.standard_margin)


# the slope


def slope_under(stance: Stance, command: Command, terrain: TerrainMap, machine: Machine) -> Lean:
    """Gradient of the plane through the ground under and ahead of the machine; level where the map
    is.

    Holes, blocks and what is unknown do not count.
    """
    if terrain.is_level:
        return 0.0, 0.0
    x, y, _, yaw = stance.body
    course = yaw + command.crab_angle
    ahead = AHEAD * max(box[1] for box in machine.boxes) if command.speed > 0.0 else 0.0
    known = terrain.known
    points = [*stance.feet]
    for px, py in _samples(
        machine, x + ahead * math.cos(course), y + ahead * math.sin(course), yaw
    ):
        flat = terrain.index(px, py)
        if flat >= 0 and (known is None or known.flat[flat]):
            points.append((px, py, terrain.height_view[flat]))
    return plane_of(points, len(stance.feet), _even(machine))


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
    gx, gy = plane_of(
        [(px, py, height_at(px, py)) for px, py in _samples(machine, *pose)], 0, _even(machine)
    )
    slope = rounded(gx, SLOPE_GRAIN), rounded(gy, SLOPE_GRAIN)
    return fitted(machine, gait, pose[2], slope, (LEVEL, LEVEL), crab_angle) or machine


def _samples(machine: Machine, x: float, y: float, yaw: float) -> list[tuple[float, float]]:
    """Places evenly spread over the rectangle of all reaches."""
    half_x, half_y = max(box[1] for box in machine.boxes), max(box[3] for box in machine.boxes)
    c, s = math.cos(yaw), math.sin(yaw)
    shares = [2 * k / (SAMPLES - 1) - 1 for k in range(SAMPLES)]
    return [
        (x + c * u * half_x - s * v * half_y, y + s * u * half_x + c * v * half_y)
        for u in shares
        for v in shares
    ]


def _even(machine: Machine) -> float:
    low, high = machine.z_range
    return OUTLIER * (high - low)


def plane_of(points: Sequence[Point], feet: int, even: float) -> Lean:
    """Gradient of the plane through points of the ground within ``even`` m of it; of the first
    ``feet`` alone where few are left.
    """
    solid = [point for point in points if point[2] == point[2]]
    plane = _plane(solid)
    if plane is not None:
        gx, gy, z, mx, my = plane
        near = [p for p in solid if abs(p[2] - z - gx * (p[0] - mx) - gy * (p[1] - my)) <= even]
        if len(near) < len(solid):
            plane = _plane(near) if len(near) >= ENOUGH else _plane(points[:feet])
    return LEVEL if plane is None else (plane[0], plane[1])


def _plane(points: Sequence[Point]) -> tuple[float, float, float, float, float] | None:
    """Least squares: gradient along x and y, and the middle the plane goes through as z, x, y. None
    when the points do not span one.
    """
    n = len(points)
    if n < 3:
        return None
    mx, my, mz = (sum(p[axis] for p in points) / n for axis in range(3))
    xx = xy = yy = xz = yz = 0.0
    for px, py, pz in points:
        dx, dy, dz = px - mx, py - my, pz - mz
        xx, xy, yy, xz, yz = xx + dx * dx, xy + dx * dy, yy + dy * dy, xz + dx * dz, yz + dy * dz
    det = xx * yy - xy * xy
    if det < 1e-9:
        return None
    return (xz * yy - yz * xy) / det, (yz * xx - xz * xy) / det, mz, mx, my


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


def whole(machine: Machine, gait: Gait, leans: tuple[Lean, ...]) -> Machine | None:
    """All of its boxes that a machine has with these leans (body axes), whatever the slope; None
    when they are not mirrored anywhere.
    """
    if all(lean == LEVEL for lean in leans):
        return machine
    cosine, boxes = reaches(machine, leans, *machine.z_range)
    box = _mirrored_part(boxes)
    if box is None:
        return None
    return _boxed(
        machine,
        gait,
        leans,
        np.array([box[0], box[2]]),
        box[1] - box[0],
        box[3] - box[2],
        machine.z_range,
        cosine,
    )


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


@lru_cache(maxsize=2048)
def _fitted(
    machine: Machine, gait: Gait, slope: Lean, leans: tuple[Lean, Lean], degrees: int
) -> Machine | None:
    level = leans == (LEVEL, LEVEL)
    angle = math.radians(degrees)
    rests = {(slope[0] - lean[0], slope[1] - lean[1]) for lean in leans}

    def needs(inner: Array, x: Array, y: Array) -> Array:
        return np.asarray(
            np.max([spread(machine, gait, rest, angle, inner, x, y) for rest in rests], axis=0)
        )

    return _longest(
        machine,
        gait,
        leans if leans[0] != leans[1] else leans[:1],
        level,
        needs,
        lambda x, y: _strokes(x, y, angle),
    )


@lru_cache(maxsize=512)
def _fitted_turning(
    machine: Machine, gait: Gait, steep: float, rest: float, tilted: float
) -> Machine | None:
    """As ``_fitted`` for any heading: the whole boxes on the diagonal of the slope, and leans to
    all four sides.
    """
    leans = [(tilted, 0.0), (-tilted, 0.0), (0.0, tilted), (0.0, -tilted)] if tilted else [LEVEL]
    full = machine.reach
    if (
        not tilted
        and 2 * rest * math.hypot(full.x0 + full.x_span, full.y0 + full.y_span) <= full.z_span
    ):
        return machine

    def needs(inner: Array, x: Array, y: Array) -> Array:
        return np.asarray(2 * rest * np.hypot(inner[0] + x, inner[1] + y))

    return _longest(
        machine,
        gait,
        leans,
        False,
        needs,
        lambda x, y: np.minimum(x / full.x_span, y / full.y_span),
    )


def _longest(
    machine: Machine,
    gait: Gait,
    leans: Sequence[Lean],
    level: bool,
    needs: Callable[[Array, Array, Array], Array],
    worth: Callable[[Array, Array], Array],
) -> Machine | None:
    """Of the boxes that fit the one worth most, and of those the largest."""
    full = machine.reach
    if (
        level
        and float(needs(np.array([full.x0, full.y0]), np.array(full.x_span), np.array(full.y_span)))
        <= full.z_span
    ):
        return machine
    low, high = machine.z_range
    halves = (1.0,) if max(math.hypot(*lean) for lean in leans) == 0.0 else HALVES
    least = SPAN_LEAST * (full.x_span + full.y_span) / 2
    changing = max(math.dist(a, b) for a in leans for b in leans) if len(leans) == 2 else 0.0
    best, found = LEVEL, None
    for share in halves:
        half = share * (high - low) / 2
        bottom, top = max(low, -gait.height - half), min(high, -gait.height + half)
        if share == 1.0:
            bottom, top = low, high
        cosine, boxes = reaches(machine, leans, bottom, top)
        box = _mirrored_part(boxes)
        if box is None:
            continue
        inner, room = np.array([box[0], box[2]]), (box[1] - box[0], box[3] - box[2])
        shares = np.arange(1, SPANS + 1) / SPANS
        x, y = (grid.ravel() for grid in np.meshgrid(shares * room[0], shares * room[1]))
        slack = SLACK * full.z_span + changing * (box[1] + box[3])
        fits = (needs(inner, x, y) + slack <= (top - bottom) / cosine) & (x >= least) & (y >= least)
        if not fits.any():
            continue
        value, area = np.where(fits, np.round(worth(x, y), 6), -1.0), x * y
        k = int(np.lexsort((area, value))[-1])
        if (value[k], area[k]) > best:
            best, found = (
                (float(value[k]), float(area[k])),
                _boxed(machine, gait, leans, inner, x[k], y[k], (bottom, top), cosine),
            )
    return found


def _strokes(x: Array, y: Array, angle: float) -> Array:
    c, s = abs(math.cos(angle)), abs(math.sin(angle))
    return np.minimum(
        x / c if c > 1e-12 else np.full(x.shape, np.inf),
        y / s if s > 1e-12 else np.full(y.shape, np.inf),
    )


SIDES = np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)])  # of the legs of H


def spread(
    machine: Machine, gait: Gait, rest: Lean, angle: float, inner: Array, x: Array, y: Array
) -> Array:
    """How much higher the highest foot of the standard walk stands than the lowest, m, on a slope
    ``rest`` above the body's floor.

    For boxes of lengths ``x`` and ``y``; at the switching points, where four feet stand.
    """
    nominal = nominal_gait(machine, gait, angle)
    ratios = np.array(nominal.layouts) / nominal.stride  # [u][i], canonical legs
    cx, cy, stride = inner[0] + x / 2, inner[1] + y / 2, _strokes(x, y, angle)
    critical, off = np.arctan2(cy, cx), abs(math.remainder(angle, 2 * math.pi))
    aside = 1 if math.remainder(angle, 2 * math.pi) > 0.0 else 3
    turns = np.where(off <= critical, 0, np.where(off >= math.pi - critical, 2, aside))
    climb = rest[0] * math.cos(angle) + rest[1] * math.sin(angle)
    worst = np.zeros(np.shape(stride))
    for n in np.unique(turns):
        sides = SIDES[(np.arange(4) + n) % 4]
        middles = rest[0] * sides[:, 0] * cx[..., None] + rest[1] * sides[:, 1] * cy[..., None]
        for row in ratios:
            heights = middles + climb * stride[..., None] * row
            worst = np.where(
                turns == n, np.maximum(worst, heights.max(axis=-1) - heights.min(axis=-1)), worst
            )
    return np.asarray(worst)


def _mirrored_part(
    boxes: Sequence[tuple[float, float, float, float]],
) -> tuple[float, float, float, float] | None:
    """The largest box that, mirrored to four quadrants, lies in all four; None when there is none."""
    x = [
        ordered(sx * box[0], sx * box[1])
        for box, (sx, _) in zip(boxes, SIDES.tolist(), strict=True)
    ]
    y = [
        ordered(sy * box[2], sy * box[3])
        for box, (_, sy) in zip(boxes, SIDES.tolist(), strict=True)
    ]
    box = max(a for a, _ in x), min(b for _, b in x), max(a for a, _ in y), min(b for _, b in y)
    return box if box[1] > box[0] and box[3] > box[2] else None


def _boxed(
    machine: Machine,
    gait: Gait,
    leans: Sequence[Lean],
    inner: Array,
    x: float,
    y: float,
    heights: tuple[float, float],
    cosine: float,
) -> Machine:
    """The machine with these boxes, in the sheared frame; what leaning takes of its speeds and its
    overreach is taken.
    """
    tilt = max(math.hypot(*lean) for lean in leans)
    low, high = machine.z_range
    z = heights[0] / cosine, heights[1] / cosine
    x1, y1 = float(inner[0]), float(inner[1])
    legs = tuple(
        Leg(
            leg.name,
            ordered(sx * x1, sx * (x1 + float(x))),
            ordered(sy * y1, sy * (y1 + float(y))),
            z,
        )
        for leg, (sx, sy) in zip(machine.legs, SIDES.tolist(), strict=True)
    )
    if tilt == 0.0:
        return replace(machine, legs=legs)
    turning = (
        TURNING
        * gait.height
        * (max(math.dist(a, b) for a in leans for b in leans) if len(leans) == 2 else 0.0)
    )
    vx, vy, vz = (v - turning for v in machine.speed)
    dx, dy, dz = machine.overreach
    cut = tilt * gait.lift_up
    kept = min(heights[0] - low, high - heights[1])
    return replace(
        machine,
        legs=legs,
        speed=(vx * cosine - vz * tilt, vy * cosine - vz * tilt, vz),
        overreach=(max(0.0, dx - cut), max(0.0, dy - cut), dz + kept),
    )
