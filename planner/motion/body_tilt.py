"""A body that leans: planning in a frame in which its floor is level.

A lean is the gradient l of the body's floor along absolute x and y; (0, 0) is level. The frame is
*sheared*, z' = z - l·(x, y): there the floor is level, lines stay lines and verticals vertical, and
a foot's height in body axes is z' times the cosine of the lean, whatever its place. Planners know
nothing of leans: they see a sheared stance and map, and their plan is sheared back.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..geometry.transforms import attitude_of, direction, rotation, turned_back, turned_back_by
from ..robot.model import Leg, Machine
from ..robot.quadrants import ordered
from ..stability import polygon_margin, support_polygon
from ..terrain.map import TerrainMap
from ..types import TICK, Point, Stance, StepPlan
from .step_builder import changed, plan_on_all_feet

Lean = tuple[float, float]  # gradient of the body's floor along x and y
LEVEL: Lean = (0.0, 0.0)
# change of the lean in a step, m per m; larger: see it lose stride while it leans over
LEAN_STEP = 0.02
LEANING = 25.0  # s in which it leans over by 1 m per m on feet that stand: 1 s for 2.3°
# m of map around the body that is sheared, or times its reach; by how much the window moves
WINDOW = 5.0
REACHES = 7.0
MARK = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class ShearedFrame:
    """What planning sees: stance and map with the lean taken out, and the machine fit for it."""

    stance: Stance
    terrain: TerrainMap
    machine: Machine
    lean: Lean  # at the end of the step
    anchor: tuple[float, float]  # where both frames have the same height
    ground: TerrainMap  # as it is

    def restored(self, plan: StepPlan, before: Stance) -> StepPlan:
        """A plan of this frame as it is walked from ``before``."""
        if self.lean == before.lean == LEVEL:
            return plan
        gx, gy = self.lean
        ax, ay = self.anchor
        body = plan.body.copy()
        feet = plan.feet.copy()
        for table in (body, feet):
            table[..., 2] += gx * (table[..., 0] - ax) + gy * (table[..., 1] - ay)
        standing = [leg for leg in range(len(before.feet)) if leg not in plan.swing]
        feet[:, standing] = np.array(before.feet)[standing]  # to the last bit
        tips = tuple(
            before.feet[leg] if leg in standing else self._stood(foot)
            for leg, foot in enumerate(plan.end.feet)
        )
        x, y, z = self._raised(plan.end.body[:3])
        return changed(
            plan,
            body=body,
            feet=feet,
            end=replace(plan.end, body=(x, y, z, plan.end.body[3]), feet=tips, lean=self.lean),
            lean=before.lean,
            search_start=None if plan.search_start is None else self._raised(plan.search_start),
            landing=None if plan.landing is None else self._stood(plan.landing),
        )

    def _stood(self, foot: Point) -> Point:
        """A foot that comes down on a cell of the sheared map stands on that of the map: cells are
        level in both.
        """
        x, y, z = self._raised(foot)
        height = self.ground.height_at(x, y)
        most = self.ground.cell * (abs(self.lean[0]) + abs(self.lean[1]))
        return x, y, height if abs(height - z) <= most else z

    def _raised(self, point: Point) -> Point:
        x, y, z = point
        return x, y, z + self.lean[0] * (x - self.anchor[0]) + self.lean[1] * (y - self.anchor[1])


class FrameCache:
    """Sheared frames; the last map is kept, for a walk asks for the same many times."""

    def __init__(self) -> None:
        self._kept: tuple[TerrainMap, Lean, tuple[float, float], TerrainMap] | None = None

    def frame(
        self, stance: Stance, terrain: TerrainMap, machine: Machine, lean: Lean
    ) -> ShearedFrame:
        """Stance and map with ``lean`` taken out; both themselves when there is none."""
        if lean == LEVEL:
            level = stance if stance.lean == lean else replace(stance, lean=lean)
            return ShearedFrame(level, terrain, machine, lean, LEVEL, terrain)
        anchor = rounded(stance.body[0], MARK), rounded(stance.body[1], MARK)
        return ShearedFrame(
            unleaned(stance, lean, anchor),
            self._map(terrain, lean, anchor, window_of(machine)),
            machine,
            lean,
            anchor,
            terrain,
        )

    def _map(
        self, terrain: TerrainMap, lean: Lean, anchor: tuple[float, float], window: float
    ) -> TerrainMap:
        kept = self._kept
        if kept is None or kept[0] is not terrain or kept[1] != lean or kept[2] != anchor:
            self._kept = kept = terrain, lean, anchor, sheared(terrain, lean, anchor, window)
        return kept[3]


def unleaned(
    stance: Stance, lean: Lean | None = None, anchor: tuple[float, float] = (0.0, 0.0)
) -> Stance:
    """The stance with a lean (its own, when none is given) taken out of its heights."""
    gx, gy = lean or stance.lean
    ax, ay = anchor
    feet = tuple((x, y, z - gx * (x - ax) - gy * (y - ay)) for x, y, z in stance.feet)
    x, y, z, yaw = stance.body
    return replace(
        stance, body=(x, y, z - gx * (x - ax) - gy * (y - ay), yaw), feet=feet, lean=LEVEL
    )


def leaning(stance: Stance, terrain: TerrainMap, machine: Machine) -> ShearedFrame:
    """The frame of the present lean, every leg with as much of its own reach as it has there: for
    motions of single feet.
    """
    if stance.lean == LEVEL:
        return ShearedFrame(stance, terrain, machine, stance.lean, LEVEL, terrain)
    cosine, boxes = reaches(machine, [in_body(stance.lean, stance.body[3])], *machine.z_range)
    legs = tuple(
        Leg(
            leg.name,
            ordered(box[0], box[1]),
            ordered(box[2], box[3]),
            (leg.z[0] / cosine, leg.z[1] / cosine),
        )
        for leg, box in zip(machine.legs, boxes, strict=True)
    )
    return FrameCache().frame(stance, terrain, replace(machine, legs=legs), stance.lean)


def approached(lean: Lean, target: Lean) -> Lean:
    """``target``, or as far towards it as one step leans."""
    dx = target[0] - lean[0]
    dy = target[1] - lean[1]
    way = math.hypot(dx, dy)
    return (
        target
        if way <= LEAN_STEP
        else (lean[0] + dx * LEAN_STEP / way, lean[1] + dy * LEAN_STEP / way)
    )


def leaned(stance: Stance, lean: Lean, machine: Machine) -> StepPlan | None:
    """Lean over to ``lean`` on the feet that stand, the body where it is; None if a leg does not
    reach that far.
    """
    roll, pitch = attitude_of(lean, stance.body[3])
    if any(
        not _within(machine, leg, foot, stance.body, roll, pitch)
        for leg, foot in enumerate(stance.feet)
    ):
        return None
    seconds = max(LEANING * math.dist(stance.lean, lean), TICK)
    carrying = [foot for leg, foot in enumerate(stance.feet) if leg not in stance.lifted]
    margin = polygon_margin(support_polygon(carrying), stance.body[0], stance.body[1])
    return plan_on_all_feet(
        stance,
        (0.0, seconds),
        (stance.body, stance.body),
        replace(stance, lean=lean),
        margin_min=margin,
        lean=stance.lean,
    )


def _within(
    machine: Machine,
    leg: int,
    foot: Point,
    body: tuple[float, float, float, float],
    roll: float,
    pitch: float,
) -> bool:
    """True when a foot is in the mechanical reach of its leg at this posture."""
    seen = turned_back_by(
        rotation(roll, pitch, body[3]), (foot[0] - body[0], foot[1] - body[1], foot[2] - body[2])
    )
    spec = machine.legs[leg]
    return all(
        low - over <= v <= high + over
        for v, (low, high), over in zip(
            seen, (spec.x, spec.y, spec.z), machine.overreach, strict=True
        )
    )


def window_of(machine: Machine) -> float:
    """How far around the body a step may have to know the ground, m: detours included."""
    return max(WINDOW, REACHES * max(abs(v) for box in machine.boxes for v in box))


def sheared(
    terrain: TerrainMap, lean: Lean, anchor: tuple[float, float], window: float = WINDOW
) -> TerrainMap:
    """The map within ``window`` of ``anchor`` with the lean taken out of its heights; the window
    keeps its place in the grid.
    """
    cell = terrain.cell
    ox, oy = terrain.origin
    c0, c1 = _cells_around(anchor[0], window, ox, cell, terrain.columns)
    r0, r1 = _cells_around(anchor[1], window, oy, cell, terrain.rows)
    cut = slice(r0, r1), slice(c0, c1)
    x = ox + (np.arange(c0, c1) + 0.5) * cell - anchor[0]
    y = oy + (np.arange(r0, r1) + 0.5) * cell - anchor[1]
    heights = terrain.heights[cut] - lean[0] * x[None, :] - lean[1] * y[:, None]
    known = None if terrain.known is None else terrain.known[cut]
    return TerrainMap(
        heights,
        terrain.forbidden[cut],
        cell,
        (ox + c0 * cell, oy + r0 * cell),
        terrain.foot_radius,
        known,
        terrain.edge,
        terrain.relief,
    )


def _cells_around(
    place: float, reach: float, origin: float, cell: float, count: int
) -> tuple[int, int]:
    """The first cell within reach of a place along one axis, m, and the first beyond."""
    low, high = (round((place + side - origin) / cell) for side in (-reach, reach))
    return max(0, min(count, low)), max(0, min(count, high))


def in_body(gradient: Lean, yaw: float) -> Lean:
    """An absolute gradient along body x and y."""
    return turned_back(gradient[0], gradient[1], yaw)


def reaches(
    machine: Machine, leans: Sequence[Lean], bottom: float, top: float
) -> tuple[float, list[tuple[float, float, float, float]]]:
    """What each leg reaches on the sheared ground under a body with any of these leans (body axes):
    the largest of the cosines of its posture, and rectangles every point of which is in the leg's
    box for heights from ``bottom`` to ``top`` in body axes.
    """
    boxes = [(-math.inf, math.inf, -math.inf, math.inf)] * len(machine.legs)
    largest = 0.0
    for lean in leans:
        roll, pitch = attitude_of(lean, 0.0)
        cp, sp = direction(pitch)
        cr, sr = direction(roll)
        largest = max(largest, cp * cr)
        for leg, spec in enumerate(machine.legs):
            aside = [sp * sr * y + sp * cr * z for y in spec.y for z in (bottom, top)]
            across = [-sr * z for z in (bottom, top)]
            x1, x2, y1, y2 = boxes[leg]
            boxes[leg] = (
                max(x1, cp * spec.x[0] + max(aside)),
                min(x2, cp * spec.x[1] + min(aside)),
                max(y1, cr * spec.y[0] + max(across)),
                min(y2, cr * spec.y[1] + min(across)),
            )
    return largest, boxes


def speed_leaning(machine: Machine, leans: Iterable[Lean]) -> Point:
    """What is left of a leg's speeds along the axes of a level body, m/s, when its body has any of
    these leans: a leaning leg goes sideways as it goes up.
    """
    tilt = max(math.hypot(*lean) for lean in leans)
    vx, vy, vz = machine.speed
    return vx / (1.0 + tilt), vy / (1.0 + tilt), vz / (1.0 + tilt)


def rounded(value: float, grain: float) -> float:
    return round(value / grain) * grain
