"""Step plans from knots: the one place that builds a ``StepPlan``.

A plan is a table of knots: at each a time, the body and every foot. Four ways to give that table
cover all there is: every foot at every knot (``plan_from_knots``), one foot that swings while the
others stand (``plan_of_one_foot``), feet that swing while the body waits (``body_still_plan``), and
a body that moves on all its feet (``plan_on_all_feet``). ``holding_plan`` stands still for a tick;
``changed`` copies a plan with other contents.

What else is known of a step (its margin, speed, landing point ...) goes along by name: the words
of ``StepFacts``, explained at ``StepPlan``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import Any, NamedTuple, TypedDict, Unpack

import numpy as np

from ..geometry.transforms import XY, Body
from ..types import TICK, Array, Departure, Phase, Point, Stance, StepPlan
from .swing import Profile, between

Feet = tuple[Point, ...]
# s from the step-switching point, and x, y, z, yaw of the body and x, y, z of the swing foot then
FootKnot = tuple[float, float, float, float, float, float, float, float]
KNOT = 8  # numbers of one


class FootWay(NamedTuple):
    """The way of one foot, absolute frame, m: straight lines between corners, of which the first is
    where it is, and where it is expected to stand at the end.
    """

    corners: Sequence[Point]
    landing: Point


class StepFacts(TypedDict, total=False):
    """What is told of a step beside its motion; units and meaning as in ``StepPlan``."""

    crab_angle: float
    support_shift: float
    shift: float
    standard_margin: float
    margin_min: float
    speed: float
    speed_max: float
    search_start: Point | None
    landing: Point | None
    lean: tuple[float, float] | None
    decision: dict[str, Any] | None
    rates: Array | None
    foot_rates: Array | None
    polygon_margin_min: float
    departure: Departure | None


def plan_from_knots(
    swing: tuple[int, ...],
    times: Sequence[float] | Array,
    body: Sequence[Body] | Array,
    feet: Sequence[Feet] | Array,
    phases: tuple[Phase, ...],
    end: Stance,
    **facts: Unpack[StepFacts],
) -> StepPlan:
    """The plan through m knots: ``times`` (m,) in s, ``body`` (m, 4), ``feet`` (m, n_legs, 3), and
    a phase for each of the m - 1 stretches between them.
    """
    return _plan_of(
        swing,
        np.asarray(times, dtype=np.float64),
        np.asarray(body, dtype=np.float64),
        np.asarray(feet, dtype=np.float64),
        phases,
        end,
        facts,
    )


def _plan_of(
    swing: tuple[int, ...],
    times: Array,
    body: Array,
    feet: Array,
    phases: tuple[Phase, ...],
    end: Stance,
    facts: StepFacts,
) -> StepPlan:
    return StepPlan(swing, times, body, feet, phases, end, **facts)


def plan_of_one_foot(
    stance: Stance,
    leg: int,
    knots: Sequence[FootKnot],
    phases: Sequence[Phase],
    end: Stance,
    **facts: Unpack[StepFacts],
) -> StepPlan:
    """The plan of a step of one leg: its foot and the body go along ``knots``, all other feet of
    ``stance`` stay.
    """
    flat = chain.from_iterable(knots)
    table = np.fromiter(flat, np.float64, KNOT * len(knots)).reshape(-1, KNOT)
    feet = np.empty((len(knots), len(stance.feet), 3))
    feet[:] = stance.feet
    feet[:, leg] = table[:, 5:]
    return _plan_of((leg,), table[:, 0], table[:, 1:5], feet, tuple(phases), end, facts)


def body_still_plan(
    stance: Stance,
    ways: Mapping[int, FootWay],
    seconds: Sequence[float],
    phases: Sequence[Phase],
    profile: Profile,
) -> StepPlan:
    """The plan of feet that go along their ``ways`` (per leg) at the speeds of a profile while the
    body stays where it is; ``seconds`` and a phase per stretch between corners.

    A stretch of no time is left out; where none is left, the plan is one tick of staying.
    """
    rows: list[tuple[float, Feet]] = [(0.0, stance.feet)]
    kept: list[Phase] = []
    done = {leg: way.corners[0] for leg, way in ways.items()}
    for k, (duration, phase) in enumerate(zip(seconds, phases, strict=True), 1):
        if duration <= 0.0:
            continue
        begin = rows[-1][0]
        corner = {leg: way.corners[k] for leg, way in ways.items()}
        for tau, share in profile[:-1]:
            moved = {leg: between(done[leg], corner[leg], share) for leg in ways}
            rows.append((begin + tau * duration, with_feet(stance.feet, moved)))
        rows.append((begin + duration, with_feet(stance.feet, corner)))
        kept += [phase] * len(profile)
        done = corner
    if not kept:
        rows.append((TICK, stance.feet))
        kept.append(phases[0])
    landings = {leg: way.landing for leg, way in ways.items()}
    return plan_from_knots(
        tuple(ways),
        [time for time, _ in rows],
        [stance.place] * len(rows),
        [feet for _, feet in rows],
        tuple(kept),
        replace(stance.at_rest(), feet=with_feet(stance.feet, landings)),
        landing=next(iter(landings.values())),
    )


def plan_on_all_feet(
    stance: Stance,
    times: Sequence[float],
    body: Sequence[Body],
    end: Stance,
    **facts: Unpack[StepFacts],
) -> StepPlan:
    """The plan of a body that goes through ``body`` at ``times`` while no foot moves; legs that
    are in the air stay there.
    """
    phases = (Phase.SHIFT,) * (len(times) - 1)
    feet = [stance.feet] * len(times)
    return plan_from_knots(stance.lifted, times, body, feet, phases, end, **facts)


def shift_plan(
    stance: Stance, place: XY, quarter_turns: int, **facts: Unpack[StepFacts]
) -> StepPlan:
    """The plan of a body that goes straight to a place on all its feet, at its height, as far and
    as fast as ``facts`` say: ``shift``, m, and ``speed``, m/s.
    """
    _, _, z, yaw = stance.body
    way = facts["shift"]
    end = replace(
        stance,
        body=(*place, z, yaw),
        quarter_turns=quarter_turns,
        course=stance.course + way,
    )
    facts["support_shift"] = way
    times = (0.0, way / facts["speed"])
    return plan_on_all_feet(stance, times, (stance.body, end.body), end, **facts)


def holding_plan(stance: Stance, **facts: Unpack[StepFacts]) -> StepPlan:
    """The plan that stands where it stands for one tick, when nothing is to move."""
    still = stance.at_rest()
    return plan_on_all_feet(still, (0.0, TICK), (still.body, still.body), still, **facts)


def changed(
    plan: StepPlan,
    *,
    times: Array | None = None,
    body: Array | None = None,
    feet: Array | None = None,
    phases: tuple[Phase, ...] | None = None,
    end: Stance | None = None,
    **facts: Unpack[StepFacts],
) -> StepPlan:
    """A copy of a plan with another table of knots, another ``end`` or other facts."""
    return replace(
        plan,
        times=plan.times if times is None else times,
        phases=plan.phases if phases is None else phases,
        body=plan.body if body is None else body,
        feet=plan.feet if feet is None else feet,
        end=plan.end if end is None else end,
        **facts,
    )


def feet_of(plan: StepPlan) -> list[list[Point]]:
    """Every foot at every knot of a plan, as plain floats."""
    flat = plan.feet.ravel().tolist()
    feet = list(zip(flat[0::3], flat[1::3], flat[2::3], strict=True))
    legs = plan.feet.shape[1]
    return [feet[k : k + legs] for k in range(0, len(feet), legs)]


def as_table(rows: Sequence[Sequence[float]]) -> Array:
    """Rows of equal length as an array: a third of the time that ``np.array`` takes."""
    wide = len(rows[0])
    flat = chain.from_iterable(rows)
    return np.fromiter(flat, np.float64, wide * len(rows)).reshape(-1, wide)


def as_feet(rows: Sequence[Sequence[Point]]) -> Array:
    """Every foot at every knot as an array (m, n_legs, 3)."""
    legs = len(rows[0])
    return as_table(list(chain.from_iterable(rows))).reshape(-1, legs, 3)


def with_feet(feet: Feet, places: Mapping[int, Point]) -> Feet:
    """The feet with those of some legs somewhere else."""
    return tuple(places.get(leg, foot) for leg, foot in enumerate(feet))
