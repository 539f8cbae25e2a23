"""One step of mode ``predictive``: what ``lookahead_search`` chooses, or the way out of
``recovery``, as a plan (``planner.plan_step`` is the paper's alone).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ..geometry.transforms import direction
from ..motion.step_builder import changed
from ..protocols import PlanningJob, run_to_completion
from ..robot.model import Machine
from ..search import Branch, uninterruptible
from ..terrain.map import TerrainMap
from ..types import Blocked, Command, Gait, Reason, Stance, StepPlan
from .candidates import ON_THE_SPOT, Node, SearchContext
from .decision_log import DecisionLog, note_search
from .leg_selection import decide
from .lookahead_search import GETS_ON, STUCK, Branches, SearchResult, choose, standard_way
from .recovery import blocked, by_stretching, context_of, is_strained, way_out
from .step_plans import body_shift_plan, swing_plan
from .steps import BodyShift, Candidate
from .turning import turn_job, turns

LEFT = 0.03  # m; without a way out it still goes on by as much as this
WAYS_LOGGED = 24  # candidates kept in a decision log
FINISHED_MAX = 12  # ways tried until the body, too, passes over the ground


def step_job(
    stance: Stance,
    command: Command,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    *,
    explain: bool = False,
) -> PlanningJob:
    """The next step of the crab walk from N_k, planned slice by slice; ``send(True)`` asks for the
    best so far.

    Like ``plan_step`` it walks straight courses and plans a command of speed 0 at v_max. Where the
    paper's step keeps the nominal walk on open ground it is that step, and answered at once. A
    command that turns is for ``turning`` to plan.
    """
    if turns(command, machine):
        return (yield from turn_job(stance, command, terrain, machine, gait, explain=explain))
    context = context_of(stance, command.crab_angle, terrain, machine, gait)
    log: DecisionLog | None = None
    if explain:
        turned = context.nominal.quarter_turns
        log = {"crab_angle": command.crab_angle, "quarter_turns": turned}
    start = context.start
    paper = decide(context.nominal, start.posture, context.cells, context.accepts(start), log)
    strained = is_strained(context)
    job = choose(context, paper)
    result = yield from (uninterruptible(job) if strained else job)
    weighed = [_entry(context, way) for way in result.ways[:WAYS_LOGGED]] if explain else []
    note_search(log, result.search, result.horizon, weighed)
    return (yield from _answer(context, stance, command, result, strained, log))


def plan_at_once(
    stance: Stance,
    command: Command,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    *,
    explain: bool = False,
) -> StepPlan | Blocked:
    """As ``step_job``, without a pause."""
    return run_to_completion(step_job(stance, command, terrain, machine, gait, explain=explain))


def _answer(
    context: SearchContext,
    stance: Stance,
    command: Command,
    result: SearchResult,
    strained: bool,
    log: DecisionLog | None,
) -> PlanningJob:
    """The best step found, or the way out where it does not get on."""
    standard = standard_way(context.nominal)
    course = command.crab_angle
    recovery = None
    if strained and result.pace < GETS_ON * standard:  # a crossing begun is gone on with
        recovery = yield from uninterruptible(by_stretching(context, stance, course, result.pace))
    if recovery is None and (result.pace >= STUCK * standard or not result.finished):
        answer = first_that_passes(context, stance, result.ways, command, log)
        if isinstance(answer, StepPlan):
            return answer
    if recovery is None:
        recovery = yield from uninterruptible(way_out(context, stance, course))
    if recovery is not None:
        if log is not None:
            log["escape"] = recovery.kind
        answer = first_that_passes(recovery.context, stance, recovery.ways, command, log)
        if isinstance(answer, StepPlan):
            return answer
    if result.ways and result.ways[0].gain >= LEFT:
        answer = first_that_passes(context, stance, result.ways, command, log)
        if isinstance(answer, StepPlan):
            return answer
    return blocked(context, result.ways, log)


def first_that_passes(
    context: SearchContext,
    stance: Stance,
    ways: Branches,
    command: Command,
    log: DecisionLog | None,
) -> StepPlan | Blocked:
    """The best way whose first step lets the torso pass over the ground as well."""
    answer: StepPlan | Blocked = Blocked(Reason.NO_STEP_PASSES)
    for way in ways[:FINISHED_MAX]:
        answer = finished(context, way.first, command, log)
        if isinstance(answer, StepPlan):
            if _way(stance, answer.end, command) >= ON_THE_SPOT:
                return answer
            return changed(answer, end=replace(answer.end, still=stance.still + 1))
    return answer


def _way(stance: Stance, end: Stance, command: Command) -> float:
    """How far the body gets on along the commanded course, m."""
    c, s = direction(stance.body[3] + command.crab_angle)
    return (end.body[0] - stance.body[0]) * c + (end.body[1] - stance.body[1]) * s


def finished(
    context: SearchContext, candidate: Candidate, command: Command, log: DecisionLog | None
) -> StepPlan | Blocked:
    """A candidate with its heights and times."""
    if isinstance(candidate, BodyShift):
        return body_shift_plan(context.here, candidate, command.speed, log)
    return swing_plan(context.here, candidate, command.speed, log)


def _entry(context: SearchContext, way: Branch[Node, Candidate]) -> dict[str, Any]:
    """A way of the search for the decision log: its first step, its score, and how far it was
    followed.
    """
    first = way.first
    entry: dict[str, Any] = {
        "score": way.score,
        "gain": way.gain,
        "steps": way.steps,
        "margin": first.margin,
    }
    if isinstance(first, BodyShift):
        there = context.start.posture.absolute(first.x, first.y)
        return entry | {"leg": None, "body": list(there)}
    return entry | {
        "leg": context.nominal.body_leg[first.leg] + 1,
        "g0": first.g0,
        "g": first.g,
        "landing": [first.landing.ax, first.landing.ay],
    }
