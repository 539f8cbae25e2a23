"""Mode ``predictive``: the paper's step where it keeps the nominal walk, else the best of several
rolled out on the known map.

The paper plans one step and can dead-lock, creep or crawl. Here each candidate is followed for
several steps, mostly with the paper's own policy, and the one that gets on best is taken. In order:
the paper's step, as long as the walk is standard and open ground ahead; on open ground any step
that leads back to the standard walk; on broken ground a beam over steps near the paper's; where
that does not get on, any foothold in reach and four-leg shifts; then ``recovery``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from typing import NamedTuple

from ..motion.leg_order import SUCCESSOR
from ..protocols import SlicedJob
from ..search import Branch, Found, Option, Search, beam, firsts, ranked, rollouts
from .candidates import (
    Node,
    SearchContext,
    body_shifts,
    near_steps,
    value_after,
    wide_steps,
)
from .foothold_search import NEAR
from .gait import AGREEMENT, NominalGait, Posture
from .leg_selection import SLACK
from .steps import Candidate, SwingStep

# steps rolled out for any foothold, for its successors, and how many get successors
GLANCE, LOOK, KEPT = 3, 6, 6
GLANCE_WEIGHT = 0.5  # of the value of the posture reached, in the ranking of first glances
STUCK = 0.1  # of the standard step; slower is no walk
LOWER = 0.001  # m below s0 that still counts as the standard margin

Ways = Found[Node, Candidate]
Branches = list[Branch[Node, Candidate]]
StepSearch = Search[Node, Candidate]
Gain = Callable[[Candidate], float]


class SearchResult(NamedTuple):
    """What the search came to: ways by their first steps, best first, and which search it was."""

    search: str  # paper | back | near | wide
    ways: Branches
    horizon: int  # steps the ways were followed
    finished: bool = True  # False: the answer was wanted before the search was over

    @property
    def pace(self) -> float:
        """What the best way gains a step, m."""
        return self.ways[0].pace(self.horizon) if self.ways else 0.0


ResultJob = SlicedJob[SearchResult]


def standard_way(nominal: NominalGait) -> float:
    """Way of the nominal walk per step, m."""
    return nominal.stride / (4.0 * nominal.duty_factor)


def choose(context: SearchContext, paper: SwingStep | None) -> ResultJob:
    """The ways to go on from here, best first. ``send(True)`` asks for the best so far."""
    open_ahead = is_open(context)
    if paper is not None and _will_do(context, paper, open_ahead):
        return SearchResult("paper", [Branch(paper, context.start, paper.g, paper.g, 1)], 1)
    yield context.here.work.taken()
    enough = context.settings.gets_on * standard_way(context.nominal)
    if open_ahead:
        steps = context.settings.back_steps + 1
        back = _result("back", (yield from _back_to_standard(context)), steps)
        if not back.finished or back.pace >= enough:
            return back
    return (yield from best_of(context))


def best_of(context: SearchContext) -> ResultJob:
    """The ways on over broken ground: near the paper's, and where those do not get on, any."""
    standard = standard_way(context.nominal)
    near = _result("near", (yield from look_near(context)), context.depth)
    if not near.finished or near.pace >= context.settings.gets_on * standard:
        return near
    wide = _result("wide", (yield from look_wide(context)), LOOK + 2)
    if max(wide.pace, near.pace) < STUCK * standard:
        to_the_edge = yield from look_wide(context.to_the_edge())
        wide = _result("wide", to_the_edge, LOOK + 2)
    wider = wide.ways and (wide.pace > near.pace or not near.ways)
    best, other = (wide, near) if wider else (near, wide)
    return SearchResult(best.search, [*best.ways, *other.ways], best.horizon)


def _result(search: str, found: Ways, horizon: int) -> SearchResult:
    """A search's result; one cut short is measured by the steps it came to."""
    steps = horizon if found.finished else found.ways[0].steps
    return SearchResult(search, found.ways, steps, found.finished)


# the searches


def _back_to_standard(context: SearchContext) -> StepSearch:
    """Open ground: the first step the paper's policy walks on from best, margins counted dear."""
    start = context.start
    s0 = context.nominal.margin
    gain = gain_with(context, context.settings.open_margin_weight)
    near = near_steps(context, start, (s0, min(context.smallest, s0)), 3)
    first = _options(context, start, chain(near, any_steps(context, start)), gain)
    policy = policy_with(context, gain)
    return (yield from rollouts(first, policy, context.settings.back_steps, work=context.here.work))


def look_near(context: SearchContext) -> StepSearch:
    """Broken ground: steps near the paper's, several deep; what the footholds still hold is worth
    as much as way made.
    """
    settings = context.settings
    gain = gain_with(context, settings.margin_weight)
    least = min(context.smallest, context.nominal.margin)

    def options(node: Node, depth: int) -> Iterator[Option[Candidate, Node]]:
        margins = (context.nominal.margin, least) if depth < settings.two_margins else (least,)
        steps = near_steps(context, node, margins, settings.per_shift)
        return _options(context, node, steps, gain, 1.0)

    start, depth = context.start, context.depth
    found: Ways = yield from beam(start, options, depth, settings.width, context.here.work)
    return Found(firsts(found.ways), found.finished)


def look_wide(context: SearchContext) -> StepSearch:
    """Where the nominal order has come to an end: any foothold in reach, followed by the paper's
    policy; then two of them.
    """
    start = context.start
    gain = gain_with(context, context.settings.margin_weight)
    policy = policy_with(context, gain)
    options = _options(context, start, any_steps(context, start), gain, GLANCE_WEIGHT)
    glanced: Ways = yield from rollouts(options, policy, GLANCE, work=context.here.work)
    found: Branches = []
    finished = glanced.finished
    for branch in glanced.ways[:KEPT] if finished else ():
        first = branch.first
        reached = Node(context, start, first)
        options = _options(context, reached, any_steps(context, reached, short=False), gain)
        begun = first, gain(first)
        looked: Ways = yield from rollouts(options, policy, LOOK, begun, context.here.work)
        found += looked.ways
        finished = looked.finished
        if not finished:
            break
    return Found(firsts([*ranked(found), *glanced.ways]), finished)


def any_steps(context: SearchContext, node: Node, short: bool = True) -> Iterator[Candidate]:
    """Any foothold in reach and the four-leg shifts, one by one: all at once is a long slice."""
    yield from wide_steps(context, node, short)
    for shift in body_shifts(node.posture):
        if context.here.is_level or not node.checks.is_barred(shift):
            yield shift


def _options(
    context: SearchContext,
    node: Node,
    candidates: Iterable[Candidate],
    gain: Gain,
    weight: float = 0.0,
) -> Iterator[Option[Candidate, Node]]:
    """Candidates with where they lead, and ``weight`` times the value reached as heuristic."""
    posture = node.posture
    for candidate in candidates:
        if context.permits(node, candidate):
            heuristic = weight * value_after(posture, candidate) if weight else 0.0
            yield candidate, Node(context, node, candidate), gain(candidate), heuristic


def gain_with(context: SearchContext, weight: float) -> Gain:
    """Way along the course, less ``weight`` times the margin that is missing to s0."""
    s0 = context.nominal.margin

    def gain(candidate: Candidate) -> float:
        way = context.way(candidate)
        return way - weight * (s0 - candidate.margin) if candidate.margin < s0 else way

    return gain


def policy_with(context: SearchContext, gain: Gain) -> Callable[[Node], tuple[Node, float] | None]:
    """The paper's policy as a rollout follows it, but for steps it could not take itself: promises
    nobody keeps make it mark time.
    """

    def policy(node: Node) -> tuple[Node, float] | None:
        step = context.paper_step(node)
        if step is None or step.margin < context.least - SLACK:
            return None
        return Node(context, node, step), gain(step)

    return policy


# when the paper's step will do


def _will_do(context: SearchContext, paper: SwingStep, open_ahead: bool) -> bool:
    if open_ahead:
        return is_standard_step(context.start.posture, paper)
    return stays_standard(context, paper)


def stays_standard(context: SearchContext, paper: SwingStep) -> bool:
    """The paper's policy keeps the nominal walk for the whole horizon, past prohibited cells."""
    node = context.start
    step: SwingStep | None = paper
    for _ in range(context.settings.back_steps):
        if step is None or not is_standard_step(node.posture, step):
            return False
        node = Node(context, node, step)
        step = context.paper_step(node)
    return step is not None


def is_standard_step(posture: Posture, step: SwingStep) -> bool:
    """The walk is standard and stays so: the successor swings, by the standard distance, to I_u
    itself.
    """
    nominal = posture.nominal
    (x, y), landing = step.start, step.landing
    return (
        (posture.last < 0 or step.leg == SUCCESSOR[posture.last])
        and abs(landing.x - x) <= NEAR
        and abs(landing.y - y) <= NEAR
        and step.g >= nominal.lags[step.leg] - AGREEMENT * nominal.stride
        and step.margin >= nominal.margin - LOWER
        and _in_layout(posture, step.leg)
    )


def _in_layout(posture: Posture, leg: int) -> bool:
    """True when every foot stands on its stroke, and there where it does as ``leg`` swings next."""
    nominal = posture.nominal
    tolerance = AGREEMENT * nominal.stride
    ux, uy, _ = nominal.path
    layout = zip(posture.feet, nominal.centres, nominal.layout_before(leg), strict=True)
    return all(
        abs(ux * (fy - cy) - uy * (fx - cx)) <= tolerance
        and abs(ux * (fx - cx) + uy * (fy - cy) - ahead) <= tolerance
        for (fx, fy), (cx, cy), ahead in layout
    )


def is_open(context: SearchContext) -> bool:
    """True when no cell is prohibited anywhere the feet could come within the horizon."""
    nominal = context.nominal
    ux, uy, _ = nominal.path
    way = (context.depth + 2) * standard_way(nominal)
    x1, x2, y1, y2 = nominal.boxes[0]  # the others are its images in the axes
    x_reach = max(abs(x1), abs(x2))
    y_reach = max(abs(y1), abs(y2))
    corners = [
        context.start.posture.absolute(x + dx, y + dy)
        for x in (-x_reach, x_reach)
        for y in (-y_reach, y_reach)
        for dx, dy in ((0.0, 0.0), (way * ux, way * uy))
    ]
    x, y = zip(*corners, strict=True)
    return context.request.terrain.is_free(min(x), max(x), min(y), max(y))
