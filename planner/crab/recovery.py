"""What is left when no step gets on along the course: a step back, another course within a cone,
legs stretched to the limit, the reason.

Four-leg shifts, other legs and lifting a foot to put it elsewhere are choices of ``predict``
already; these are of another kind: they give up the commanded course for one step, or the control
reach until a gap is behind the walker. They are thought to their end even when Level C waits:
bounded by count, some two thousand pieces of thought at the very most.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import replace
from typing import Any, NamedTuple

from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Blocked, Gait, Stance
from .candidates import Field, State, near_steps
from .gait import posture_of, standard_for
from .leg_selection import Notes, Step, decide
from .lookahead_search import DEPTH, Ways, best_of, is_open, look_near, standard_way

# degrees against the commanded course, in the order they are tried
CONE = (15.0, -15.0, 30.0, -30.0)
BACK_MAX = 4  # steps back that are tried
WORTH = 0.1  # of the standard way: net way a step an escape must lead to; less is wandering
STRAIN = 0.005  # m beyond the control reach that counts as stretched; less and servo errors do
CELLS_TOLD = 8  # refused cells named when blocked


class Escape(NamedTuple):
    """A way out: what it is, on which course, and by which steps, best first."""

    kind: str  # back | cone | stretch
    field: Field
    ways: Ways


def field_of(
    stance: Stance,
    crab_angle: float,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    stretched: bool = False,
) -> Field:
    """The walker on its ground, along one course; ``stretched``: with legs that reach as far as
    their mechanism goes.
    """
    standard = standard_for(machine, gait, crab_angle, stance.quarter_turns, stretched)
    return Field(standard, stance, posture_of(standard, stance), terrain, machine, gait)


def way_out(
    field: Field, stance: Stance, crab_angle: float
) -> Generator[None, bool | None, Escape | None]:
    """A step back that lets the walk get past where it stands, a course within the cone that gets
    on, stretched legs; None without one.
    """
    back = yield from _by_a_step_back(field, stance, crab_angle)
    if back is not None:
        return back
    for degrees in CONE:
        aside = field_of(
            stance, crab_angle + math.radians(degrees), field.terrain, field.machine, field.gait
        )
        found = yield from look_near(aside)
        need = WORTH * standard_way(field.standard) / math.cos(math.radians(degrees))
        if found.ways and found.ways[0].pace(DEPTH) >= need:
            return Escape("cone", aside, found.ways)
    return (
        yield from by_stretching(field, stance, crab_angle, WORTH * standard_way(field.standard))
    )


def by_stretching(
    field: Field, stance: Stance, crab_angle: float, least: float
) -> Generator[None, bool | None, Escape | None]:
    """The commanded course with legs stretched to the mechanical limit, if that gains more than
    ``least`` m a step: wider gaps, slowly.
    """
    far = field_of(stance, crab_angle, field.terrain, field.machine, field.gait, stretched=True)
    found = yield from best_of(far)
    return Escape("stretch", far, found.ways) if found.pace > least else None


def is_strained(field: Field) -> bool:
    """True in the middle of a stretched crossing: a foot stands beyond its control reach, and the
    ground ahead is not open.
    """
    feet, boxes = field.start.posture.feet, field.standard.boxes
    beyond = any(
        not (x1 - STRAIN <= x <= x2 + STRAIN and y1 - STRAIN <= y <= y2 + STRAIN)
        for (x, y), (x1, x2, y1, y2) in zip(feet, boxes, strict=True)
    )
    return beyond and not is_open(field)


def _by_a_step_back(
    field: Field, stance: Stance, crab_angle: float
) -> Generator[None, bool | None, Escape | None]:
    terrain, machine, gait = field.terrain, field.machine, field.gait
    behind = field_of(stance, crab_angle + math.pi, terrain, machine, gait)
    for step in list(near_steps(behind, behind.start, (behind.standard.margin,), 2))[:BACK_MAX]:
        there = stance_at(behind, stance, behind.after(behind.start, step), step)
        found = yield from look_near(field_of(there, crab_angle, terrain, machine, gait))
        if found.ways and found.ways[0].gain - step.g >= WORTH * (DEPTH + 1) * standard_way(
            field.standard
        ):
            return Escape("back", behind, [replace(found.ways[0], first=step)])
    return None


def stance_at(field: Field, stance: Stance, state: State, step: Step) -> Stance:
    """The stance after one step, on level ground too, where states do not carry it."""
    if state.stance is not None:
        return state.stance
    leg, feet = field.standard.body_leg[step.leg], list(stance.feet)
    feet[leg] = step.landing.ax, step.landing.ay, field.here.ground_at(step.landing)
    x, y = state.posture.x, state.posture.y
    return Stance((x, y, *stance.body[2:]), tuple(feet), leg, field.standard.quarter_turns)


def blocked(field: Field, ways: Ways, notes: Notes | None) -> Blocked:
    """No way on: what failed for each leg where the farthest way ends, and the cells refused there."""
    end = ways[0].state if ways else field.start
    tried: dict[str, Any] = {}
    decide(field.standard, end.posture, field.ground, field.accepts(end), tried)
    legs = tried.get("legs", [])
    reasons = "; ".join(f"leg {trial['leg']}: {trial.get('reason', 'no gain')}" for trial in legs)
    cells = [cell for trial in legs for cell in trial["refused"]][:CELLS_TOLD]
    where = f"after {ways[0].gain:.2f} m more " if ways and ways[0].gain > 0.005 else ""
    told = "".join(f" ({cell['x']:.2f}, {cell['y']:.2f})" for cell in cells[:3])
    reason = f"no way on {where}by any leg, shift, step back, course within 30 degrees or stretched leg: {reasons}"
    decision = {**(notes or {}), "refused": cells}
    return Blocked(
        reason + (f"; refused cells:{told}" if told else ""),
        legs[0]["leg"] - 1 if legs else None,
        decision,
    )
