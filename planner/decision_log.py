"""Why a step was taken, or why there was none: what a planner considered, as plain data for files
and screens.

A log is filled only when somebody asks (``explain``). Functions that take one accept None, and then
do nothing, so that a planner reads the same with and without it and walks the same steps.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum
from typing import Any

DecisionLog = dict[str, Any]


def note_leg(log: DecisionLog | None, leg: int, **facts: Any) -> DecisionLog | None:
    """A leg of the machine (0-based) that was tried: the entry its further fate is noted in."""
    if log is None:
        return None
    trial: DecisionLog = {"leg": leg + 1, **facts, "refused": []}
    log.setdefault("legs", []).append(trial)
    return trial


def note_reason(trial: DecisionLog | None, reason: Enum) -> None:
    """Why nothing came of a leg."""
    if trial is not None:
        trial["reason"] = reason.value


def note_cell(trial: DecisionLog | None, ax: float, ay: float, reason: Enum) -> None:
    """A foothold of a leg, in the absolute frame, that was refused."""
    if trial is not None:
        trial["refused"].append({"x": ax, "y": ay, "reason": reason.value})


def reasons_of(log: DecisionLog, otherwise: str = "") -> str:
    """All legs tried with what failed, in one sentence."""
    trials = log.get("legs", [])
    return "; ".join(f"leg {trial['leg']}: {trial.get('reason', otherwise)}" for trial in trials)


def refused_cells(log: DecisionLog, most: int) -> list[DecisionLog]:
    """The first cells refused, of whatever leg."""
    return [cell for trial in log.get("legs", []) for cell in trial["refused"]][:most]


def note_search(
    log: DecisionLog | None, search: str, horizon: int, candidates: Iterable[DecisionLog]
) -> None:
    """A search over several steps: its name, how far it looked, and what it weighed."""
    if log is not None:
        log["lookahead"] = {
            "search": search,
            "horizon": horizon,
            "candidates": list(candidates),
        }
