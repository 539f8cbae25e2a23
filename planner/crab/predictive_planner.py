"""One step of mode ``predictive``: what ``lookahead_search`` chooses, or the way out of
``recovery``, as a plan (``planner.plan_step`` is the paper's alone).
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from ..decision_log import DecisionLog, note_search
from ..geometry.transforms import turned_back
from ..motion.step_builder import changed
from ..protocols import Announced, PlanningJob
from ..search import uninterruptible
from ..types import Departure, StepPlan
from .candidates import SearchContext, entry_of
from .gait import turns
from .lookahead_search import STUCK, Branches, SearchResult, choose, standard_way
from .recovery import blocked, by_stretching, is_strained, way_out
from .step_plans import plan_of
from .steps import StepRequest, SwingStep
from .turning import turn_job

LEFT = 0.03  # m; without a way out it still goes on by as much as this
WAYS_LOGGED = 24  # candidates kept in a decision log
# by the search a step comes from, and by the kind of recovery
DEPARTURES = {
    "back": Departure.BACK_TO_STANDARD,
    "near": Departure.BROKEN_GROUND,
    "wide": Departure.ANY_FOOTHOLD,
}
WAYS_OUT = {
    "back": Departure.STEP_BACK,
    "cone": Departure.ASIDE,
    "stretch": Departure.STRETCHED,
}
CHOICE = 40  # what the paper's step weighs on relief, in postures looked at
FINISHED_MAX = 12  # ways tried until the body, too, passes over the ground


def step_job(request: StepRequest) -> PlanningJob:
    """The next step of the crab walk from N_k in slices; ``send(True)`` asks for the best so far.

    Like ``plan_step`` it walks straight courses and plans a command of speed 0 at v_max. Where the
    paper's step keeps the nominal walk on open ground it is that step. ``turning`` plans turns.
    """
    if turns(request.command, request.machine):
        return (yield from turn_job(request))
    if request.terrain.relief:
        yield Announced(CHOICE)
    course = request.command.crab_angle
    context = SearchContext(request, course)
    log = request.log(crab_angle=course, quarter_turns=context.nominal.quarter_turns)
    paper = context.paper_step(context.start, log)
    strained = is_strained(context)
    job = choose(context, paper)
    result = yield from (uninterruptible(job) if strained else job)
    if log is not None:
        weighed = [entry_of(context.start.posture, way) for way in result.ways[:WAYS_LOGGED]]
        note_search(log, result.search, result.horizon, weighed)
    return (yield from _answer(context, result, paper, strained, log))


def _answer(
    context: SearchContext,
    result: SearchResult,
    paper: SwingStep | None,
    strained: bool,
    log: DecisionLog | None,
) -> PlanningJob:
    """The best step found, or the way out where it does not get on."""
    standard = standard_way(context.nominal)
    found = Offered(
        result.ways, DEPARTURES.get(result.search) if paper else Departure.NO_STEP, paper
    )
    recovery = None
    enough = context.settings.gets_on * standard
    if strained and result.pace < enough:  # a crossing begun is gone on with
        recovery = yield from uninterruptible(by_stretching(context, result.pace))
    plan = None
    if recovery is None and (result.pace >= STUCK * standard or not result.finished):
        plan = first_that_passes(context, found, log)
    if plan is None:
        recovery = recovery or (yield from uninterruptible(way_out(context)))
    if plan is None and recovery is not None:
        if log is not None:
            log["escape"] = recovery.kind
        out = Offered(recovery.ways, WAYS_OUT[recovery.kind])
        plan = first_that_passes(recovery.context, out, log)
    if plan is None and result.ways and result.ways[0].gain >= LEFT * context.nominal.size:
        plan = first_that_passes(context, found, log)
    return plan or blocked(context, result.ways, log)


class Offered(NamedTuple):
    """Ways to choose from, best first, and why they are not the ``paper`` step."""

    ways: Branches
    why: Departure | None
    paper: SwingStep | None = None


def first_that_passes(
    context: SearchContext, found: Offered, log: DecisionLog | None
) -> StepPlan | None:
    """The best way whose first step lets the torso pass over the ground as well; None without."""
    request = context.request
    for way in found.ways[:FINISHED_MAX]:
        plan = plan_of(context.here, way.first, request.command.speed, log)
        if isinstance(plan, StepPlan):
            x, y, _, yaw = request.stance.body
            end_x, end_y, _, _ = plan.end.body
            course = yaw + request.command.crab_angle
            if turned_back(end_x - x, end_y - y, course)[0] < context.on_the_spot:
                plan = changed(plan, end=replace(plan.end, still=request.stance.still + 1))
            return plan if way.first == found.paper else changed(plan, departure=found.why)
    return None
