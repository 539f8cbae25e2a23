"""What a lookahead may choose from at N_k: steps near the paper's own, any foothold in reach, and a
shift of the body on four legs.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from copy import copy
from typing import NamedTuple

from ..geometry.paths import Box, line_exit
from ..geometry.polygons import inside_of, nearest_of
from ..geometry.transforms import XY
from ..robot.model import Machine
from ..terrain.cells import FootholdMap, foothold_map
from ..terrain.map import TerrainMap
from ..types import Gait, Stance
from .decision_log import StepRefusal
from .foothold_checks import FootholdChecks
from .gait import IS_FRONT, NominalGait, Posture
from .leg_selection import (
    STANDING_LEG,
    Accepts,
    after,
    body_shift_to,
    changes_nothing,
    exits_of,
    free_shift,
    leg_order,
    planned_margin,
    shift_of,
    shifted,
    steps_to,
    triangle_of,
)
from .steps import BodyShift, Candidate, Exits, Landing, Shift, SwingStep

SMALL = 0.003  # m, the least margin that is asked for; at 0 a millimetre of servo error is outside
SPACING = 0.05  # m between footholds tried; finer maps are read in blocks of this size
WIDE_MAX = 16  # footholds of one leg and shift that are tried when anything goes
# m; a step with less margin is taken only where there is no other: the CoG would balance on an edge
LEAST = 0.002
ON_THE_SPOT = 0.01  # m; a step that takes the body less far does not get on
STILL_MAX = 4  # steps on the spot in a row; the next one must get on
INSET = 0.005  # m inside a triangle's edges: where a body shift ends


class Node(NamedTuple):
    """Where a rollout has come to; the stance, with its heights, is carried on uneven ground."""

    posture: Posture
    stance: Stance | None


class SearchContext:
    """The ground and the walker as one search sees them: one nominal walk on one map."""

    def __init__(
        self,
        nominal: NominalGait,
        stance: Stance,
        posture: Posture,
        terrain: TerrainMap,
        machine: Machine,
        gait: Gait,
    ) -> None:
        self.nominal = nominal
        self.terrain = terrain
        self.machine = machine
        self.gait = gait
        self.cells: FootholdMap = foothold_map(terrain)
        self.here = FootholdChecks(nominal, posture, stance, terrain, machine, gait)
        self.start = Node(posture, None if self.here.is_level else stance)
        self.least = min(LEAST, nominal.margin)  # m, the margin every step considered must have
        self.must_get_on = stance.still >= STILL_MAX

    def to_the_edge(self) -> SearchContext:
        """The same with steps on the very edge of stability."""
        other = copy(self)
        other.least = 0.0
        return other

    def permits(self, node: Node, candidate: Candidate) -> bool:
        """False for one more first step on the spot when there have been enough: each leads to a
        better next one, for ever.
        """
        return not (self.must_get_on and node is self.start) or self.way(candidate) >= ON_THE_SPOT

    def way(self, candidate: Candidate) -> float:
        """How far the body gets on along the course, m."""
        if isinstance(candidate, SwingStep):
            return candidate.g
        ux, uy, _ = self.nominal.path
        return candidate.x * ux + candidate.y * uy

    def checks(self, node: Node) -> FootholdChecks | None:
        """Heights around a node; None where there are none to mind."""
        if node.stance is None:
            return None
        return FootholdChecks(
            self.nominal, node.posture, node.stance, self.terrain, self.machine, self.gait
        )

    def accepts(self, node: Node) -> Accepts | None:
        """What refuses footholds for their height."""
        checks = self.checks(node)
        return None if checks is None else checks.refuses

    def after(self, node: Node, candidate: Candidate) -> Node:
        """The node at N_{k+1}."""
        if isinstance(candidate, SwingStep):
            return self._after_step(node, candidate)
        return self._after_shift(node, candidate)

    def _after_step(self, node: Node, step: SwingStep) -> Node:
        posture = after(self.nominal, node.posture, step)
        checks = self.checks(node)
        if checks is None or node.stance is None:
            return Node(posture, None)
        z = checks.height_after(step, step.landing)
        leg = self.nominal.body_leg[step.leg]
        feet = list(node.stance.feet)
        feet[leg] = step.landing.ax, step.landing.ay, checks.ground_at(step.landing)
        body = posture.x, posture.y, z, node.stance.body[3]
        return Node(posture, Stance(body, tuple(feet), leg, self.nominal.quarter_turns))

    def _after_shift(self, node: Node, shift: BodyShift) -> Node:
        posture = shifted(node.posture, shift)
        stance = node.stance
        if stance is None:
            return Node(posture, None)
        body = posture.x, posture.y, *stance.body[2:]
        turns = self.nominal.quarter_turns
        return Node(posture, Stance(body, stance.feet, stance.last_swing, turns))


# steps near the paper's own


def near_steps(
    context: SearchContext, node: Node, margins: tuple[float, ...], per_shift: int, legs: int = 3
) -> Iterator[SwingStep]:
    """The paper's legs in its order, its shifts with each margin, its footholds in the order of H
    §5.5: the first of each.
    """
    nominal = context.nominal
    posture = node.posture
    accepts = context.accepts(node)
    exits = exits_of(nominal, posture)
    for leg, shift in leg_order(nominal, posture, exits)[:legs]:
        if isinstance(shift, StepRefusal):
            continue
        tried: set[Shift] = set()
        for margin in margins:
            fitted = shift_of(nominal, posture, exits, leg, margin)
            trimmed = within_margin(context.least, fitted)
            if trimmed is None or trimmed in tried:
                continue
            tried.add(trimmed)
            yield from _first_footholds(context, posture, exits, trimmed, per_shift, accepts)


def _first_footholds(
    context: SearchContext,
    posture: Posture,
    exits: Exits,
    shift: Shift,
    most: int,
    accepts: Accepts | None,
) -> Iterator[SwingStep]:
    count = 0
    for convergent in (True,) if IS_FRONT[shift.leg] else (True, False):
        for step in steps_to(context.nominal, posture, exits, shift, context.cells, convergent):
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


def within_margin(least: float, shift: Shift | StepRefusal) -> Shift | None:
    """The shift, ended early enough to keep the ``least`` margin; None when it begins with less."""
    if isinstance(shift, StepRefusal):
        return None
    g0, low, high = shift.g0, shift.low, shift.high
    if g0 - low < least - 1e-9 or high - g0 < least - 1e-9:
        return None
    return shift if high - shift.g >= least else shift._replace(g=max(g0, high - least))


# any foothold in reach


def wide_steps(context: SearchContext, node: Node, short: bool = True) -> Iterator[SwingStep]:
    """Any leg but the last, any foothold in its reach, g0 as far as the triangle needs; g in full,
    by half and not at all.

    The domains of H §5.3 keep the nominal order possible; where that has come to an end they are
    in the way.
    """
    nominal = context.nominal
    posture = node.posture
    accepts = context.accepts(node)
    exits = exits_of(nominal, posture)
    for leg in range(4):
        if leg == posture.last:
            continue
        for shift in wide_shifts(context, posture, exits, leg, short):
            margin = planned_margin(nominal, posture, shift)
            landings = list(accepted(shift, footholds(context, posture, shift), accepts))
            for landing in thinned(landings, WIDE_MAX):
                start = landing.x, landing.y
                step = SwingStep(leg, shift.g0, shift.g, start, landing, margin, False)
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
    context: SearchContext, posture: Posture, exits: Exits, leg: int, short: bool
) -> list[Shift]:
    """``free_shift`` with the smallest margin: on four legs into the triangle, then on as far as it
    goes, half, or not.
    """
    shift = free_shift(context.nominal, posture, exits, leg, SMALL)
    if isinstance(shift, StepRefusal):
        return []
    g0, g = shift.g0, shift.g
    ways = (g, (g0 + g) / 2, g0) if short and g > g0 + 0.02 else (g,)
    shifts = (within_margin(context.least, shift._replace(g=way)) for way in ways)
    return [shift for shift in shifts if shift is not None]


def footholds(context: SearchContext, posture: Posture, shift: Shift) -> Iterator[Landing]:
    """Free cells in the reach of a leg at N_{k+1}, one in each block of ``SPACING``."""
    ux, uy, _ = context.nominal.path
    cells = context.cells
    box = _moved(context.nominal.boxes[shift.leg], shift.g * ux, shift.g * uy)
    x1, x2, y1, y2 = box
    mx, my = posture.absolute((x1 + x2) / 2, (y1 + y2) / 2)
    hx, hy = (x2 - x1) / 2, (y2 - y1) / 2
    c, s = abs(posture.c), abs(posture.s)
    half_x, half_y = c * hx + s * hy, s * hx + c * hy
    block = max(1, round(SPACING / cells.cell))
    side = block * cells.cell
    first_column = math.floor((mx - half_x - cells.x) / side)
    last_column = math.floor((mx + half_x - cells.x) / side)
    first_row = math.floor((my - half_y - cells.y) / side)
    last_row = math.floor((my + half_y - cells.y) / side)
    for row in range(first_row, last_row + 1):
        lines = range(max(0, row * block), min(cells.rows, (row + 1) * block))
        for column in range(first_column, last_column + 1):
            places = range(max(0, column * block), min(cells.columns, (column + 1) * block))
            found = _first_free(cells, posture, box, lines, places)
            if found is not None:
                yield found


def _first_free(
    cells: FootholdMap, posture: Posture, box: Box, lines: range, places: range
) -> Landing | None:
    """The first free cell of a block in reach."""
    forbidden, _, columns, cell, ox, oy = cells
    x1, x2, y1, y2 = box
    for line in lines:
        for place in places:
            if forbidden[line * columns + place]:
                continue
            ax, ay = ox + (place + 0.5) * cell, oy + (line + 0.5) * cell
            px, py = posture.canonical(ax, ay)
            if x1 <= px <= x2 and y1 <= py <= y2:
                return Landing(px, py, ax, ay)
    return None


def thinned(landings: list[Landing], most: int) -> list[Landing]:
    """At most so many, evenly picked."""
    count = len(landings)
    if count <= most:
        return landings
    return [landings[(2 * k + 1) * count // (2 * most)] for k in range(most)]


# shifts of the body on four legs


def body_shifts(context: SearchContext, node: Node) -> Iterator[BodyShift]:
    """Four-leg shifts into the triangles of the legs that stay when each one swings, as short as
    can be.
    """
    posture = node.posture
    room = shift_room(context.nominal, posture.feet)
    for leg in range(4):
        region = inside_of(room, triangle_of(posture, leg), INSET)
        if not region:
            continue
        x, y = nearest_of(region, 0.0, 0.0)
        if math.hypot(x, y) >= 2 * INSET:
            yield body_shift_to(posture, x, y)


def shift_room(nominal: NominalGait, feet: tuple[XY, ...]) -> list[XY]:
    """Where the body may be shifted to with every foot in reach, or no farther out of it than it
    is: a rectangle.
    """
    reach = list(zip(feet, nominal.boxes, strict=True))
    x1 = min(max(fx - box[1] for (fx, _), box in reach), 0.0)
    x2 = max(min(fx - box[0] for (fx, _), box in reach), 0.0)
    y1 = min(max(fy - box[3] for (_, fy), box in reach), 0.0)
    y2 = max(min(fy - box[2] for (_, fy), box in reach), 0.0)
    return [(x1, y1), (x2, y1), (x2, y2), (x1, y2)]


def value_of(nominal: NominalGait, posture: Posture) -> float:
    """What a posture is worth to a search: how far the body may go on the footholds it has, mean of
    the legs, m. What a step did not use up it has kept.
    """
    ux, uy, _ = nominal.path
    most = nominal.stride
    total = 0.0
    for (fx, fy), box in zip(posture.feet, nominal.boxes, strict=True):
        left = line_exit(fx, fy, box, ux, uy)
        if left > 0.0:
            total += most if left > most else left
    return total / 4


def _moved(box: Box, dx: float, dy: float) -> Box:
    return box[0] + dx, box[1] + dx, box[2] + dy, box[3] + dy
