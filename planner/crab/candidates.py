"""What a lookahead may choose from at N_k: steps near the paper's own, any foothold in reach, and a
shift of the body on four legs.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from copy import copy
from dataclasses import dataclass
from itertools import islice
from typing import Any

from ..decision_log import DecisionLog
from ..geometry.paths import corners_of_box, line_exit, room_within
from ..geometry.polygons import inside_of, nearest_of
from ..geometry.transforms import XY
from ..lazy import lazy
from ..search import Branch, thinned
from ..terrain.cells import FootholdMap, foothold_map, one_of_each_block
from .foothold_checks import FootholdChecks
from .gait import Posture, nominal_gait, posture_of
from .leg_selection import (
    STANDING_LEG,
    Accepts,
    after,
    body_shift_to,
    changes_nothing,
    decide,
    free_shift,
    leg_order,
    planned_margin,
    shift_of,
    shifted,
    steps_to,
    triangle_of,
)
from .step_refusals import StepRefusal
from .steps import BodyShift, Candidate, Landing, Shift, StepRequest, SwingStep

SMALL = 0.003  # m, the least margin that is asked for; at 0 a millimetre of servo error is outside
SPACING = 0.05  # m between footholds tried; finer maps are read in blocks of this size
# m; a step with less margin is taken only where there is no other: the CoG would balance on an edge
LEAST = 0.002
ON_THE_SPOT = 0.01  # m; a step that takes the body less far does not get on
STILL_MAX = 4  # steps on the spot in a row; the next one must get on
INSET = 0.005  # m inside a triangle's edges: where a body shift ends


@dataclass(eq=False)
class Node:
    """Where a search has come to: by a candidate from another node, or where it began. What is
    there is worked out when it goes on from it: most nodes are only weighed.
    """

    context: SearchContext
    before: Node | None = None
    candidate: Candidate | None = None

    @lazy
    def posture(self) -> Posture:
        if self.before is None or self.candidate is None:
            return self.context.here.posture
        if isinstance(self.candidate, SwingStep):
            return after(self.before.posture, self.candidate)
        return shifted(self.before.posture, self.candidate)

    @lazy
    def checks(self) -> FootholdChecks:
        """Around its stance; asked only where there are heights to mind."""
        here = self.context.here
        if self.before is None or self.candidate is None:
            return here
        stance = self.before.checks.stance_after(self.posture, self.candidate)
        return FootholdChecks(self.posture, self.context.request, stance, here.work)


class SearchContext:
    """The ground and the walker as one search sees them: one nominal walk on one map.

    ``stretched`` is with legs that reach as far as their mechanism goes.
    """

    def __init__(self, request: StepRequest, crab_angle: float, stretched: bool = False) -> None:
        stance = request.stance
        self.request = request
        self.settings = request.config.lookahead
        self.depth = max(1, self.settings.depth)
        self.nominal = nominal_gait(
            request.machine, request.gait, crab_angle, stance.quarter_turns, stretched
        )
        posture = posture_of(self.nominal, stance)
        self.cells: FootholdMap = foothold_map(request.terrain)
        self.here = FootholdChecks(posture, request)
        self.start = Node(self)
        size = self.nominal.size
        self.least = min(LEAST * size, self.nominal.margin)  # m, that every step must keep
        self.smallest = SMALL * size  # m, the least margin asked for
        self.on_the_spot = ON_THE_SPOT * size
        self.must_get_on = stance.still >= STILL_MAX
        self.stretched_ways: Any = None  # once they have been looked for (``recovery``)

    def to_the_edge(self) -> SearchContext:
        """The same with steps on the very edge of stability."""
        other = copy(self)
        other.least = 0.0
        return other

    def permits(self, node: Node, candidate: Candidate) -> bool:
        """False for one more first step on the spot when there have been enough: each leads to a
        better next one, for ever.
        """
        may_stay = not (self.must_get_on and node is self.start)
        return may_stay or self.way(candidate) >= self.on_the_spot

    def way(self, candidate: Candidate) -> float:
        """How far the body gets on along the course, m."""
        if isinstance(candidate, SwingStep):
            return candidate.g
        ux, uy, _ = self.nominal.path
        return candidate.x * ux + candidate.y * uy

    def accepts(self, node: Node) -> Accepts | None:
        """What refuses footholds for their height; None where there are no heights to mind."""
        return None if self.here.is_level else node.checks.refuses

    def paper_step(self, node: Node, log: DecisionLog | None = None) -> SwingStep | None:
        """What the paper's own policy does at a node."""
        self.here.work.asked += 1
        return decide(node.posture, self.cells, self.accepts(node), log)


# steps near the paper's own, and any foothold in reach


def near_steps(
    context: SearchContext, node: Node, margins: tuple[float, ...], per_shift: int
) -> Iterator[SwingStep]:
    """The first footholds (H §5.5) of the paper's legs in its order, with each margin."""
    posture = node.posture
    accepts = context.accepts(node)
    s0 = context.nominal.margin
    for leg, paper in islice(leg_order(posture), 3):
        if isinstance(paper, StepRefusal):
            continue
        asked = (paper if m == s0 else shift_of(posture, leg, m) for m in margins)
        for shift in dict.fromkeys(within_margin(context.least, shift) for shift in asked):
            if shift is None:
                continue
            left = per_shift
            for step in steps_to(posture, shift, context.cells, accepts):
                if not changes_nothing(posture, step, step.landing):
                    yield step
                    left -= 1
                    if left <= 0:
                        break


def within_margin(least: float, shift: Shift | StepRefusal) -> Shift | None:
    """The shift, ended early enough to keep the ``least`` margin; None when it begins with less."""
    if isinstance(shift, StepRefusal):
        return None
    g0, low, high = shift.g0, shift.low, shift.high
    if g0 - low < least - 1e-9 or high - g0 < least - 1e-9:
        return None
    return shift if high - shift.g >= least else shift._replace(g=max(g0, high - least))


def wide_steps(context: SearchContext, node: Node, short: bool = True) -> Iterator[SwingStep]:
    """Any leg but the last, any foothold in its reach, g0 as far as the triangle needs; g in full,
    by half and not at all.

    The domains of H §5.3 keep the nominal order possible; where that has come to an end they are
    in the way.
    """
    posture = node.posture
    accepts = context.accepts(node)
    for leg in range(4):
        if leg == posture.last:
            continue
        for shift in wide_shifts(context, posture, leg, short):
            steps = steps_anywhere(posture, shift, context.cells)
            if accepts is not None:
                steps = accepted(shift, steps, accepts)
            for step in thinned(list(steps), context.settings.wide_max):
                if not changes_nothing(posture, step, step.landing):
                    yield step


def accepted(shift: Shift, steps: Iterable[SwingStep], accepts: Accepts) -> Iterator[SwingStep]:
    """The steps whose footholds heights allow."""
    for step in steps:
        refusal = accepts(shift, step.landing)
        if refusal is STANDING_LEG:
            return
        if refusal is None:
            yield step


def wide_shifts(context: SearchContext, posture: Posture, leg: int, short: bool) -> list[Shift]:
    """``free_shift`` with the smallest margin: on as far as the triangle carries, half, or not."""
    shift = free_shift(posture, leg, context.smallest)
    if isinstance(shift, StepRefusal):
        return []
    g0, g = shift.g0, shift.g
    ways = (g, (g0 + g) / 2, g0) if short and g > g0 + 2 * context.on_the_spot else (g,)
    shifts = (within_margin(context.least, shift._replace(g=way)) for way in ways)
    return [shift for shift in shifts if shift is not None]


def steps_anywhere(posture: Posture, shift: Shift, cells: FootholdMap) -> Iterator[SwingStep]:
    """To free cells in the reach of a leg at N_{k+1}, one in each block of ``SPACING``."""
    leg, g0, g = shift[:3]
    ux, uy, _ = posture.nominal.path
    x1, x2, y1, y2 = posture.nominal.boxes[leg]
    x1, x2, y1, y2 = box = x1 + g * ux, x2 + g * ux, y1 + g * uy, y2 + g * uy
    margin = planned_margin(posture, shift)

    def step_to(ax: float, ay: float) -> SwingStep | None:
        x, y = posture.canonical(ax, ay)
        if not (x1 <= x <= x2 and y1 <= y <= y2):
            return None
        return SwingStep(leg, g0, g, (x, y), Landing(x, y, ax, ay), margin, False)

    return one_of_each_block(cells, posture.around(box), SPACING * posture.nominal.size, step_to)


# shifts of the body on four legs


def body_shifts(posture: Posture) -> Iterator[BodyShift]:
    """The shortest four-leg shift into each triangle of legs that stay when one swings."""
    room = shift_room(posture)
    inset = INSET * posture.nominal.size
    for leg in range(4):
        region = inside_of(room, triangle_of(posture, leg), inset)
        shift = shortest_shift(posture, [region], 2 * inset)
        if shift is not None:
            yield shift


def shortest_shift(posture: Posture, regions: Iterable[list[XY]], least: float) -> BodyShift | None:
    """The shortest four-leg shift into the first of these regions that is as long as ``least``."""
    for region in regions:
        if region:
            x, y = nearest_of(region, 0.0, 0.0)
            if math.hypot(x, y) >= least:
                return body_shift_to(posture, x, y)
    return None


def shift_room(posture: Posture) -> list[XY]:
    """The rectangle the body may be shifted in with no foot farther out of its reach than it is."""
    return corners_of_box(room_within(posture.feet, posture.nominal.boxes))


def value_after(posture: Posture, candidate: Candidate) -> float:
    """What the posture a candidate leads to is worth to a search: how far the body may then go on
    its footholds, mean of the legs, m. What a step did not use up it has kept.
    """
    nominal, most = posture.nominal, posture.nominal.stride
    ux, uy, _ = nominal.path
    if isinstance(candidate, BodyShift):
        left = [min(way, most) for way in shifted(posture, candidate).exits]
    else:
        leg, _, g, _, (x, y, _, _), *_ = candidate
        dx, dy = g * ux, g * uy
        known = posture.left_after  # the feet that stand do not depend on where this one lands
        if g not in known:
            reach = zip(posture.feet, nominal.boxes, strict=True)
            ways = [line_exit(fx - dx, fy - dy, box, ux, uy) for (fx, fy), box in reach]
            known[g] = [min(max(0.0, way), most) for way in ways]
        left = known[g].copy()
        left[leg] = min(max(0.0, line_exit(x - dx, y - dy, nominal.boxes[leg], ux, uy)), most)
    a, b, c, d = left
    return (a + b + c + d) / 4


def entry_of(posture: Posture, way: Branch[Any, Candidate], margin: str = "margin") -> DecisionLog:
    """A way of a search for the decision log: how it scored, how far it was followed, and its first
    step; ``margin`` names what is kept of a swing.
    """
    first = way.first
    entry: DecisionLog = {"score": way.score, "gain": way.gain, "steps": way.steps}
    if isinstance(first, BodyShift):
        body = list(posture.absolute(first.x, first.y))
        return entry | {"margin": first.margin, "leg": None, "body": body}
    return entry | {
        margin: first.margin,
        "leg": posture.nominal.body_leg[first.leg] + 1,
        "g0": first.g0,
        "g": first.g,
        "landing": [first.landing.ax, first.landing.ay],
    }
