"""What a lookahead may choose from at N_k: steps near the paper's own, any foothold in reach, and a
sway on four legs.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from copy import copy
from typing import NamedTuple

from ..geometry.paths import Box, line_exit
from ..robot.model import Machine
from ..stability import XY, stable_interval, support_polygon
from ..terrain.map import TerrainMap
from ..types import Gait, Stance
from .foothold_search import Ground, Landing, ground_of
from .gait import IS_FRONT, OTHERS, Posture, Standard
from .leg_selection import (
    STANDING_LEG,
    Accepts,
    Shift,
    Step,
    after,
    changes_nothing,
    exits_of,
    leg_order,
    planned_margin,
    shift_of,
    steps_to,
)
from .planner import Ahead

SMALL = 0.003  # m, the least margin that is asked for; at 0 a millimetre of servo error is outside
SPACING = 0.05  # m between footholds tried; finer maps are read in blocks of this size
WIDE_MAX = 16  # footholds of one leg and shift that are tried when anything goes
# m; a step with less margin is taken only where there is no other: the CoG would balance on an edge
LEAST = 0.002
ON_THE_SPOT = 0.01  # m; a step that takes the body less far does not get on
STILL_MAX = 4  # steps on the spot in a row; the next one must get on
INSET = 0.005  # m inside a triangle's edges: where a sway ends


class State(NamedTuple):
    """Where a rollout has come to. The stance, with its heights, is carried on uneven ground only."""

    posture: Posture
    stance: Stance | None


class Sway(NamedTuple):
    """A four-leg shift: no leg swings, the body goes (x, y) in the canonical frame."""

    x: float
    y: float
    margin: float  # least longitudinal margin along its own way


class Field:
    """The ground and the walker as choices see them: one standard walk on one map."""

    def __init__(
        self,
        standard: Standard,
        stance: Stance,
        posture: Posture,
        terrain: TerrainMap,
        machine: Machine,
        gait: Gait,
    ) -> None:
        self.standard, self.terrain, self.machine, self.gait = standard, terrain, machine, gait
        self.ground: Ground = ground_of(terrain)
        self.here = Ahead(standard, posture, stance, terrain, machine, gait)
        self.start = State(posture, None if self.here.is_level else stance)
        self.least = min(LEAST, standard.margin)  # m, the margin every step considered must have
        self.must_get_on = stance.still >= STILL_MAX

    def daring(self) -> Field:
        """The same with steps on the very edge."""
        other = copy(self)
        other.least = 0.0
        return other

    def permits(self, state: State, choice: Step | Sway) -> bool:
        """False for one more first step on the spot when there have been enough: each leads to a
        better next one, for ever.
        """
        return not (self.must_get_on and state is self.start) or self.way(choice) >= ON_THE_SPOT

    def way(self, choice: Step | Sway) -> float:
        """How far the body gets on along the course, m."""
        return (
            choice.g
            if isinstance(choice, Step)
            else choice.x * self.standard.ux + choice.y * self.standard.uy
        )

    def ahead(self, state: State) -> Ahead | None:
        """Heights around a state; None where there are none to mind."""
        if state.stance is None:
            return None
        return Ahead(
            self.standard, state.posture, state.stance, self.terrain, self.machine, self.gait
        )

    def accepts(self, state: State) -> Accepts | None:
        """What refuses footholds for their height."""
        ahead = self.ahead(state)
        return None if ahead is None else ahead.refuses

    def after(self, state: State, choice: Step | Sway) -> State:
        """The state at N_{k+1}."""
        return (
            self._after_step(state, choice)
            if isinstance(choice, Step)
            else self._after_sway(state, choice)
        )

    def _after_step(self, state: State, step: Step) -> State:
        posture = after(self.standard, state.posture, step)
        ahead = self.ahead(state)
        if ahead is None or state.stance is None:
            return State(posture, None)
        z = ahead.height_after(
            step.leg,
            step.g,
            step.landing,
            *ahead.height_limits(step.leg, step.g0, step.g, step.landing),
        )
        leg, feet = self.standard.body_leg[step.leg], list(state.stance.feet)
        feet[leg] = step.landing.ax, step.landing.ay, ahead.ground_at(step.landing)
        return State(
            posture,
            Stance(
                (posture.x, posture.y, z, state.stance.body[3]),
                tuple(feet),
                leg,
                self.standard.quarter_turns,
            ),
        )

    def _after_sway(self, state: State, sway: Sway) -> State:
        x, y = state.posture.absolute(sway.x, sway.y)
        posture = state.posture._replace(
            x=x, y=y, feet=tuple((fx - sway.x, fy - sway.y) for fx, fy in state.posture.feet)
        )
        if state.stance is None:
            return State(posture, None)
        _, _, z, yaw = state.stance.body
        return State(
            posture,
            Stance(
                (x, y, z, yaw),
                state.stance.feet,
                state.stance.last_swing,
                self.standard.quarter_turns,
            ),
        )


def near_steps(
    field: Field, state: State, margins: tuple[float, ...], per_shift: int, legs: int = 3
) -> Iterator[Step]:
    """The paper's legs in its order, its shifts with each margin, its footholds in the order of H
    §5.5: the first of each.
    """
    standard, posture = field.standard, state.posture
    accepts = field.accepts(state)
    exits = exits_of(standard, posture)
    for leg, shift in leg_order(standard, posture, exits)[:legs]:
        if isinstance(shift, str):
            continue
        tried: set[Shift] = set()
        for margin in margins:
            trimmed = within_margin(field.least, shift_of(standard, posture, exits, leg, margin))
            if trimmed is None or trimmed in tried:
                continue
            tried.add(trimmed)
            yield from _first_footholds(field, posture, exits, trimmed, per_shift, accepts)


def _first_footholds(
    field: Field,
    posture: Posture,
    exits: tuple[float, float, float, float],
    shift: Shift,
    most: int,
    accepts: Accepts | None,
) -> Iterator[Step]:
    count = 0
    for convergent in (True,) if IS_FRONT[shift.leg] else (True, False):
        for step in steps_to(field.standard, posture, exits, shift, field.ground, convergent):
            if changes_nothing(posture, step):
                continue
            refusal = accepts(shift, step.landing) if accepts is not None else None
            if refusal is STANDING_LEG:
                return
            if refusal is not None:
                continue
            yield step
            count += 1
            if count == most:
                return


def within_margin(least: float, shift: Shift | str) -> Shift | None:
    """The shift, ended early enough to keep the ``least`` margin; None when it begins with less."""
    if isinstance(shift, str):
        return None
    leg, g0, g, low, high = shift
    if g0 - low < least - 1e-9 or high - g0 < least - 1e-9:
        return None
    return shift if high - g >= least else Shift(leg, g0, max(g0, high - least), low, high)


def wide_steps(field: Field, state: State, short: bool = True) -> Iterator[Step]:
    """Any leg but the last, any foothold in its reach, g0 as far as the triangle needs; g in full,
    by half and not at all.

    The domains of H §5.3 keep the standard order possible; where that has come to an end they are
    in the way.
    """
    standard, posture = field.standard, state.posture
    accepts = field.accepts(state)
    exits = exits_of(standard, posture)
    for leg in range(4):
        if leg == posture.last:
            continue
        for shift in wide_shifts(field, posture, exits, leg, short):
            margin = planned_margin(standard, posture, shift)
            landings = list(accepted(shift, footholds(field, posture, leg, shift.g), accepts))
            for landing in thinned(landings, WIDE_MAX):
                step = Step(leg, shift.g0, shift.g, (landing.x, landing.y), landing, margin, False)
                if not changes_nothing(posture, step):
                    yield step


def accepted(
    shift: Shift, landings: Iterable[Landing], accepts: Accepts | None
) -> Iterator[Landing]:
    """The footholds that heights allow."""
    for landing in landings:
        refusal = accepts(shift, landing) if accepts is not None else None
        if refusal is STANDING_LEG:
            return
        if refusal is None:
            yield landing


def wide_shifts(
    field: Field, posture: Posture, exits: tuple[float, float, float, float], leg: int, short: bool
) -> list[Shift]:
    """As (14) for any leg, with the smallest margin: on four legs into the triangle, then on as far
    as it goes, half, or not.
    """
    i, j, k = OTHERS[leg]
    standard, feet = field.standard, posture.feet
    low, high = stable_interval(
        support_polygon((feet[i], feet[j], feet[k])), 0.0, 0.0, standard.ux, standard.uy
    )
    if low > high or high < 0.0:
        return []
    g_max = min(exits[i], exits[j], exits[k])
    g0_max = min(g_max, exits[leg])
    if low > g0_max:
        return []
    margin = min(SMALL, (high - low) / 2)
    g0 = min(max(0.0, low + margin), g0_max)
    g = max(g0, min(g_max, high - margin))
    ways = (g, (g0 + g) / 2, g0) if short and g > g0 + 0.02 else (g,)
    shifts = (within_margin(field.least, Shift(leg, g0, way, low, high)) for way in ways)
    return [shift for shift in shifts if shift is not None]


def footholds(field: Field, posture: Posture, leg: int, g: float) -> Iterator[Landing]:
    """Free cells in the reach of ``leg`` at N_{k+1}, one in each block of ``SPACING``."""
    standard, ground = field.standard, field.ground
    forbidden, rows, columns, cell, ox, oy = ground
    x1, x2, y1, y2 = _moved(standard.boxes[leg], g * standard.ux, g * standard.uy)
    mx, my = posture.absolute((x1 + x2) / 2, (y1 + y2) / 2)
    c, s, hx, hy = abs(posture.c), abs(posture.s), (x2 - x1) / 2, (y2 - y1) / 2
    half_x, half_y = c * hx + s * hy, s * hx + c * hy
    block = max(1, round(SPACING / cell))
    side = block * cell
    for row in range(
        math.floor((my - half_y - oy) / side), math.floor((my + half_y - oy) / side) + 1
    ):
        for column in range(
            math.floor((mx - half_x - ox) / side), math.floor((mx + half_x - ox) / side) + 1
        ):
            for line in range(max(0, row * block), min(rows, (row + 1) * block)):
                found = None
                for place in range(max(0, column * block), min(columns, (column + 1) * block)):
                    if forbidden[line * columns + place]:
                        continue
                    ax, ay = ox + (place + 0.5) * cell, oy + (line + 0.5) * cell
                    px, py = posture.canonical(ax, ay)
                    if x1 <= px <= x2 and y1 <= py <= y2:
                        found = Landing(px, py, ax, ay)
                        break
                if found is not None:
                    yield found
                    break


def thinned(landings: list[Landing], most: int) -> list[Landing]:
    """At most so many, evenly picked."""
    count = len(landings)
    return (
        landings
        if count <= most
        else [landings[(2 * k + 1) * count // (2 * most)] for k in range(most)]
    )


def sways(field: Field, state: State) -> Iterator[Sway]:
    """Four-leg shifts into the triangles of the legs that stay when each one swings, as short as
    can be.
    """
    standard, feet = field.standard, state.posture.feet
    low_x = max(fx - box[1] for (fx, _), box in zip(feet, standard.boxes, strict=True))
    high_x = min(fx - box[0] for (fx, _), box in zip(feet, standard.boxes, strict=True))
    low_y = max(fy - box[3] for (_, fy), box in zip(feet, standard.boxes, strict=True))
    high_y = min(fy - box[2] for (_, fy), box in zip(feet, standard.boxes, strict=True))
    low_x, high_x, low_y, high_y = (
        min(low_x, 0.0),
        max(high_x, 0.0),
        min(low_y, 0.0),
        max(high_y, 0.0),
    )
    room = ((low_x, low_y), (high_x, low_y), (high_x, high_y), (low_x, high_y))
    whole = support_polygon(feet)
    for leg in range(4):
        i, j, k = OTHERS[leg]
        region = list(room)
        triangle = support_polygon((feet[i], feet[j], feet[k]))
        for a, b in zip(triangle, (*triangle[1:], triangle[0]), strict=True):
            region = beside(region, a, b, INSET)
        target = nearest_to_origin(region)
        if target is None:
            continue
        x, y = target
        way = math.hypot(x, y)
        if way < 2 * INSET:
            continue
        low, high = stable_interval(whole, 0.0, 0.0, x / way, y / way)
        yield Sway(x, y, min(-low, high - way))


def beside(corners: list[XY], a: XY, b: XY, inset: float) -> list[XY]:
    """The part of a convex polygon at least ``inset`` to the left of the line from a to b."""
    ex, ey = b[0] - a[0], b[1] - a[1]
    length = math.hypot(ex, ey)
    kept: list[XY] = []
    for (px, py), (qx, qy) in zip(corners, corners[1:] + corners[:1], strict=True):
        p = (ex * (py - a[1]) - ey * (px - a[0])) / length - inset
        q = (ex * (qy - a[1]) - ey * (qx - a[0])) / length - inset
        if p >= 0.0:
            kept.append((px, py))
        if (p > 0.0 > q) or (p < 0.0 < q):
            w = p / (p - q)
            kept.append((px + w * (qx - px), py + w * (qy - py)))
    return kept


def nearest_to_origin(corners: list[XY]) -> XY | None:
    """The point of a convex polygon's rim nearest to the origin; None when it has none or the
    origin is inside.
    """
    best, least, inside = None, math.inf, True
    for (px, py), (qx, qy) in zip(corners, corners[1:] + corners[:1], strict=True):
        ex, ey = qx - px, qy - py
        inside = inside and ey * px - ex * py >= 0.0
        length = ex * ex + ey * ey
        w = min(1.0, max(0.0, -(px * ex + py * ey) / length)) if length > 0.0 else 0.0
        nx, ny = px + w * ex, py + w * ey
        if nx * nx + ny * ny < least:
            best, least = (nx, ny), nx * nx + ny * ny
    return None if inside else best


def reserve(standard: Standard, posture: Posture) -> float:
    """How far the body may go on the footholds it has, mean of the legs: what a step did not use up
    it has kept.
    """
    ux, uy, most = standard.ux, standard.uy, standard.stride
    total = 0.0
    for (fx, fy), box in zip(posture.feet, standard.boxes, strict=True):
        exit_ = line_exit(fx, fy, box, ux, uy)
        total += most if exit_ > most else exit_ if exit_ > 0.0 else 0.0
    return total / 4


def _moved(box: Box, dx: float, dy: float) -> Box:
    return box[0] + dx, box[1] + dx, box[2] + dy, box[3] + dy
