"""Why the machine steps as it does, for those who watch: what a trace walker foresees, and what
the running step was chosen for. Sent when it changes, not with every snapshot.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any, Literal

from pydantic import BaseModel, Field

from walking_console.planner.types import StepPlan
from walking_console.sim.snapshot import Snapshot

from .frames import number
from .schemas import example

REFUSED_SHOWN = 200  # cells of one decision on the wire
CANDIDATES_SHOWN = 8  # ways on of one decision on the wire


class AheadFrame(BaseModel):
    """Server to client on /drive when a trace walker foresees something else; also ``GET
    /api/v1/console/ahead``. Null without one.
    """

    model_config = example(
        type="ahead",
        line_m=[[0.0, 0.0, 0.0], [0.05, 0.05, 0.0]],
        footholds_m=[[[0.7, 0.6, 0.0]]],
        segments_m=[[[0.0, 0.4, 0.0, 0.3]]],
        states_m=[[0.0, 0.3], [0.0, 0.5], [0.2, 0.5]],
        reached_m=3.2,
        goal_m=3.2,
        complete=True,
        reason="",
    )
    type: Literal["ahead"] = "ahead"
    line_m: list[list[float]] = Field(description="the trace ahead: s, x, y")
    footholds_m: list[list[list[float]]] = Field(description="planned, per leg, in their order")
    segments_m: list[list[list[float]]] = Field(
        description="per leg and foothold: existence segment s1, s2, and where placed and lifted"
    )
    states_m: list[list[float]] = Field(
        description="existence segments of whole states: standing, legs lifted, standing ... in "
        "turn"
    )
    reached_m: float | None = Field(
        description="s up to which the walk is sure; short of the goal it is a dead end or the "
        "end of the known"
    )
    goal_m: float | None
    complete: bool
    reason: str


class DecisionFrame(BaseModel):
    """Server to client on /drive with every step begun or refused: why this one; also ``GET
    /api/v1/console/decision``.
    """

    model_config = example(
        type="decision",
        step=12,
        leg=4,
        shift_m=[0.0, 0.08],
        domain_m=[[1.6, 0.3], [1.9, 0.3], [1.9, 0.7]],
        search_start_m=[1.7, 0.5],
        landing_m=[1.7, 0.5],
        refused_m=[[1.72, 0.52]],
        legs=[{"leg": 4, "agreeing_pairs": 2, "return_m": 0.32, "reason": "", "refused": {}}],
        search="paper",
        escape="",
        candidates=[],
        notes=[],
    )
    type: Literal["decision"] = "decision"
    step: int
    leg: int | None = Field(description="that swings; null for a four-leg shift or none")
    shift_m: list[float | None] | None = Field(description="g0 and g")
    domain_m: list[list[float]] | None = Field(description="corners of the search domain")
    search_start_m: list[float] | None
    landing_m: list[float] | None
    refused_m: list[list[float]] = Field(description="cells refused on the way to the landing")
    legs: list[dict[str, Any]] = Field(description="in the order they were tried")
    search: str = Field(description="paper | back | near | wide in predictive mode, turn on an arc")
    escape: str
    candidates: list[dict[str, Any]] = Field(description="best first, in predictive mode")
    notes: list[str]


def ahead_frame(snapshot: Snapshot) -> AheadFrame | None:
    """What a trace walker foresees; None for any other."""
    ahead = snapshot.ahead
    if ahead is None:
        return None
    return AheadFrame(
        line_m=_rows(ahead.line),
        footholds_m=[_rows(footholds) for footholds in ahead.footholds],
        segments_m=[_rows(bars) for bars in ahead.bars],
        states_m=_rows(ahead.states),
        reached_m=number(ahead.reached),
        goal_m=number(ahead.goal),
        complete=ahead.complete,
        reason=ahead.reason,
    )


def decision_frame(snapshot: Snapshot) -> DecisionFrame | None:
    """Why the running step, or why there is none; None where nobody keeps it."""
    decision = snapshot.decision
    if decision is None:
        return None
    step = _step_of(snapshot)
    leg = step.swing[0] + 1 if step is not None and step.swing else None
    trials = decision.get("legs", ())
    lookahead = decision.get("lookahead") or decision
    return DecisionFrame(
        step=snapshot.step,
        leg=leg,
        shift_m=None if step is None else [number(step.support_shift), number(step.shift)],
        domain_m=_rows(decision["domain"]) if decision.get("domain") else None,
        search_start_m=None if step is None else _place(step.search_start),
        landing_m=None if step is None else _place(step.landing),
        refused_m=_refused(trials, leg),
        legs=[_trial(trial) for trial in trials],
        search=lookahead.get("search", ""),
        escape=decision.get("escape", ""),
        candidates=_candidates(lookahead.get("candidates", ())),
        notes=_notes(decision),
    )


def _step_of(snapshot: Snapshot) -> StepPlan | None:
    """The running step, if it is the one that was decided on."""
    plan = snapshot.plan
    return plan if plan is not None and plan.decision is snapshot.decision else None


def _rows(rows: Iterable[Iterable[float]]) -> list[list[float]]:
    """Rows of metres for a drawing, in whole millimetres."""
    return [[round(value, 3) for value in row] for row in rows]


def _place(point: Iterable[float] | None) -> list[float] | None:
    return None if point is None else [round(value, 3) for value in point]


def _refused(trials: Iterable[Mapping[str, Any]], leg: int | None) -> list[list[float]]:
    """The cells refused for the leg that swings."""
    own = [trial.get("refused", ()) for trial in trials if trial.get("leg") == leg]
    cells = [(cell["x"], cell["y"]) for refused in own for cell in refused]
    return _rows(cells[:REFUSED_SHOWN])


def _notes(decision: Mapping[str, Any]) -> list[str]:
    """What a trace walker says of its prediction."""
    if "states_met" not in decision:
        return []
    sure = f"sure up to s = {decision['reached_m']:.2f} m of {decision['goal_m']:.2f} m"
    reason = [str(decision["reason"])] if decision["reason"] else []
    return [f"{decision['states_met']} states met; {sure}", *reason]


def _trial(trial: Mapping[str, Any]) -> dict[str, Any]:
    """One leg tried: how well it fits the standard walk, and what came of it."""
    return {
        "leg": trial["leg"],
        "agreeing_pairs": trial.get("agreeing_pairs"),
        "return_m": number(trial.get("return_length", math.nan)),
        "g0_m": number(trial.get("g0", math.nan)),
        "g_m": number(trial.get("g", math.nan)),
        "reason": trial.get("reason", ""),
        "refused": dict(Counter(cell["reason"] for cell in trial.get("refused", ()))),
    }


def _candidates(ways: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """The best ways on, those that differ."""
    seen: dict[tuple[Any, ...], dict[str, Any]] = {}
    for way in ways:
        found = _candidate(way)
        seen.setdefault((found["leg"], round(found["score_m"] or 0.0, 3), found["steps"]), found)
    return list(seen.values())[:CANDIDATES_SHOWN]


def _candidate(way: Mapping[str, Any]) -> dict[str, Any]:
    """One way on of a lookahead: its first step, its score, and how far it was followed."""
    return {
        "leg": way["leg"],
        "score_m": number(way["score"]),
        "gain_m": number(way["gain"]),
        "steps": way["steps"],
        "margin_m": number(way.get("margin", way.get("inset", math.nan))),
        "g_m": number(way.get("g", math.nan)),
    }
