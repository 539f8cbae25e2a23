"""One step of mode ``predictive``: what ``predict`` chooses, or the way out of ``escape``, as a
plan (the twin of ``plan``).
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from ..motion.step_builder import plan_on_all_feet
from ..protocols import PlanningJob, run_to_completion
from ..robot.model import Machine
from ..search import uninterruptible
from ..terrain.map import TerrainMap
from ..types import Blocked, Command, Gait, Stance, StepPlan
from .candidates import ON_THE_SPOT, Field, Sway
from .leg_selection import Notes, Step, decide
from .lookahead_search import GETS_ON, STUCK, Choice, Chosen, Ways, choose, standard_way
from .planner import build, cruise_speed
from .recovery import blocked, by_stretching, field_of, is_strained, way_out
from .turning import think_turn, turns

LEFT = 0.03  # m; without a way out it still goes on by as much as this
WAYS_TOLD = 24  # candidates kept in a decision trace
FINISHED_MAX = 12  # ways tried until the body, too, passes over the ground


def think(
    stance: Stance,
    command: Command,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    *,
    explain: bool = False,
) -> PlanningJob:
    """The next step of the crab walk from N_k, thought through piece by piece; ``send(True)`` asks
    for the best so far.

    Like ``plan_step`` it walks straight courses and plans a command of speed 0 at v_max. Where the
    paper's step keeps the standard walk on open ground it is that step, and answered at once. A
    command that turns is ``turning``'s to think about.
    """
    if turns(command, machine):
        return (yield from think_turn(stance, command, terrain, machine, gait, explain=explain))
    field = field_of(stance, command.crab_angle, terrain, machine, gait)
    notes: Notes | None = (
        {"crab_angle": command.crab_angle, "quarter_turns": field.standard.quarter_turns}
        if explain
        else None
    )
    paper = decide(
        field.standard, field.start.posture, field.ground, field.accepts(field.start), notes
    )
    strained = is_strained(field)
    choice = yield from (
        uninterruptible(choose(field, paper)) if strained else choose(field, paper)
    )
    if notes is not None:
        notes["lookahead"] = told(field, choice)
    standard, escape = standard_way(field.standard), None
    if strained and choice.pace < GETS_ON * standard:  # a crossing begun is gone on with
        escape = yield from uninterruptible(
            by_stretching(field, stance, command.crab_angle, choice.pace)
        )
    if escape is None and (choice.pace >= STUCK * standard or not choice.finished):
        answer = first_that_passes(field, stance, choice.ways, command, notes)
        if isinstance(answer, StepPlan):
            return answer
    if escape is None:
        escape = yield from uninterruptible(way_out(field, stance, command.crab_angle))
    if escape is not None:
        if notes is not None:
            notes["escape"] = escape.kind
        answer = first_that_passes(escape.field, stance, escape.ways, command, notes)
        if isinstance(answer, StepPlan):
            return answer
    if choice.ways and choice.ways[0].gain >= LEFT:
        answer = first_that_passes(field, stance, choice.ways, command, notes)
        if isinstance(answer, StepPlan):
            return answer
    return blocked(field, choice.ways, notes)


def at_once(
    stance: Stance,
    command: Command,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    *,
    explain: bool = False,
) -> StepPlan | Blocked:
    """The same without a pause."""
    return run_to_completion(think(stance, command, terrain, machine, gait, explain=explain))


def first_that_passes(
    field: Field, stance: Stance, ways: Ways, command: Command, notes: Notes | None
) -> StepPlan | Blocked:
    """The best way whose first step lets the torso pass over the ground as well."""
    answer: StepPlan | Blocked = Blocked("no way on")
    for way in ways[:FINISHED_MAX]:
        answer = finished(field, stance, way.first, command, notes)
        if isinstance(answer, StepPlan):
            still = stance.still + 1 if _way(stance, answer.end, command) < ON_THE_SPOT else 0
            return replace(answer, end=replace(answer.end, still=still)) if still else answer
    return answer


def _way(stance: Stance, end: Stance, command: Command) -> float:
    """How far the body gets on along the commanded course, m."""
    course = stance.body[3] + command.crab_angle
    return (end.body[0] - stance.body[0]) * math.cos(course) + (
        end.body[1] - stance.body[1]
    ) * math.sin(course)


def finished(
    field: Field, stance: Stance, choice: Chosen, command: Command, notes: Notes | None
) -> StepPlan | Blocked:
    """A choice with its heights and times."""
    if isinstance(choice, Sway):
        return sway_plan(field, stance, choice, command, notes)
    ahead, machine, gait = field.here, field.machine, field.gait
    low, highest = ahead.height_limits(choice.leg, choice.g0, choice.g, choice.landing)
    height = ahead.height_after(choice.leg, choice.g, choice.landing, low, highest)
    needs = ahead.torso_needs(choice.g, height)
    if needs > highest:
        return Blocked(
            f"the torso would touch the ground: it needs {needs:.2f} m, the legs reach {highest:.2f} m",
            None,
            notes,
        )
    posture = field.start.posture
    return build(
        field.standard,
        posture,
        stance,
        choice,
        max(height, needs),
        ahead,
        command,
        machine,
        gait,
        notes,
    )


def sway_plan(
    field: Field, stance: Stance, sway: Sway, command: Command, notes: Notes | None
) -> StepPlan:
    """A four-leg shift: the body goes straight, at its height, no faster than the standard walk in
    that direction.
    """
    x, y, z, yaw = stance.body
    end_x, end_y = field.start.posture.absolute(sway.x, sway.y)
    way, course = math.hypot(sway.x, sway.y), math.atan2(end_y - y, end_x - x) - yaw
    speed_max = cruise_speed(field.machine, field.gait, math.remainder(course, 2 * math.pi))
    speed = min(speed_max, command.speed) if command.speed > 0.0 else speed_max
    end = replace(
        stance,
        body=(end_x, end_y, z, yaw),
        quarter_turns=field.standard.quarter_turns,
        course=stance.course + way,
    )
    return plan_on_all_feet(
        stance,
        (0.0, way / speed),
        (stance.body, end.body),
        end,
        crab_angle=course,
        support_shift=way,
        shift=way,
        standard_margin=field.standard.margin,
        margin_min=sway.margin,
        speed=speed,
        speed_max=speed_max,
        decision=notes,
    )


def told(field: Field, choice: Choice) -> dict[str, Any]:
    """The search for the decision trace: each candidate's first step, its score, and how far it was
    followed.
    """
    standard, posture = field.standard, field.start.posture
    candidates = []
    for way in choice.ways[:WAYS_TOLD]:
        first = way.first
        told: dict[str, Any] = {
            "score": way.score,
            "gain": way.gain,
            "steps": way.steps,
            "margin": first.margin,
        }
        if isinstance(first, Step):
            told |= {
                "leg": standard.body_leg[first.leg] + 1,
                "g0": first.g0,
                "g": first.g,
                "landing": [first.landing.ax, first.landing.ay],
            }
        else:
            told |= {"leg": None, "body": list(posture.absolute(first.x, first.y))}
        candidates.append(told)
    return {"search": choice.search, "horizon": choice.horizon, "candidates": candidates}
