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


class StepRefusal(Enum):
    """Why a leg cannot swing or a foothold cannot be used; the value is the text that is shown."""

    # of the swing of a leg, whatever its foothold (H §5.2)
    MISSES = "the course misses the triangle of the other feet"
    LEFT = "the centre of gravity has already left the triangle of the other feet"
    NOT_YET = "the centre of gravity is not yet in the triangle of the other feet"
    TOO_LATE = (
        "the centre of gravity cannot enter the triangle of the other feet before a leg leaves "
        "its reach"
    )
    UNCARRIED = "the centre of gravity would leave the feet on the way into the triangle"
    NO_FOOTHOLD = "no foothold in the search domain"
    NONE_IN_REACH = "no foothold in reach"
    NOTHING = "the step would change nothing"
    # of a foothold (H §5.3, §6)
    PROHIBITED = "prohibited cell"
    OUT_OF_REACH = "out of reach"
    METHOD_III = "on the other side of the course (method III)"
    METHOD_I = "the hind leg after next could not swing (method I)"
    METHOD_II = "the front leg of this side could not swing next (method II)"
    UNKNOWN_GROUND = "no ground known there"
    TOO_UNEVEN = "too high or too low for the legs to reach together"
    LIFT = "the foot cannot be lifted over the ground on the way"
    TALL = "a leg would run into something tall"
    # whatever the foothold: no use to try another with this shift
    STANDING_LEG = "a leg that stands would run into something tall"


def note_leg(log: DecisionLog | None, leg: int, **facts: Any) -> DecisionLog | None:
    """A leg of the machine (0-based) that was tried: the entry its further fate is noted in."""
    if log is None:
        return None
    trial: DecisionLog = {"leg": leg + 1, **facts, "refused": []}
    log.setdefault("legs", []).append(trial)
    return trial


def note_reason(trial: DecisionLog | None, reason: StepRefusal) -> None:
    """Why nothing came of a leg."""
    if trial is not None:
        trial["reason"] = reason.value


def note_cell(trial: DecisionLog | None, ax: float, ay: float, reason: StepRefusal) -> None:
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
