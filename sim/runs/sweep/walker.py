"""One walk of a sweep, in whatever process it is given: a row, and the run directory where it is to
be kept.
"""

from __future__ import annotations

import tempfile
from enum import StrEnum
from pathlib import Path
from typing import Any, NamedTuple

from walking_console.sim.runs.runner import succeeded, walk_scenario
from walking_console.sim.scenario_files import scenario_from

from .grid import Case

REASON_SHOWN = 500  # characters
FIGURES = (
    "seconds",
    "distance",
    "mean_speed",
    "steps",
    "margin_min",
    "polygon_margin_min",
    "forbidden_steps",
    "falls",
)


class Keep(StrEnum):
    """Whose run directories are kept."""

    FAILED = "failed"
    ALL = "all"
    NONE = "none"


class WalkedCase(NamedTuple):
    """What came of a walk: figures of its row, and the files of its run directory, if kept."""

    row: dict[str, Any]
    files: dict[str, bytes] | None


def walk_case(case: Case, keep: Keep) -> WalkedCase:
    """Walk one case to its end. What cannot be walked at all becomes a row of result ``failed``
    that says why: one bad walk is no reason to lose the others.
    """
    try:
        summary, recorder = walk_scenario(scenario_from(case.scenario, Path()))
        if summary["result"] == "interrupted":
            raise KeyboardInterrupt
        passed = succeeded(summary)
        wanted = keep is Keep.ALL or (keep is Keep.FAILED and not passed)
        return WalkedCase(row_of(summary), _files(recorder, summary) if wanted else None)
    except Exception as error:
        return failed(f"{type(error).__name__}: {error}")


def failed(reason: str) -> WalkedCase:
    """The row of a walk that there is nothing to say of but why."""
    return WalkedCase({"result": "failed", "passed": False, "reason": reason[:REASON_SHOWN]}, None)


def row_of(summary: dict[str, Any]) -> dict[str, Any]:
    """The figures of ``run.json`` that a table of many runs shows: plain numbers and words."""
    return {
        "result": summary["result"],
        "passed": succeeded(summary),
        "reason": summary["reason"][:REASON_SHOWN],
        "unmet": " ".join(key for key, entry in summary["expect"].items() if not entry["pass"]),
        **{key: summary.get(key) for key in FIGURES},
        "emergent": sum(summary["emergent"].values()),
        "state_hash": summary["state_hash"],
    }


def _files(recorder: Any, summary: dict[str, Any]) -> dict[str, bytes]:
    """The run directory as bytes: where it was walked need not be where it is kept."""
    with tempfile.TemporaryDirectory() as folder:
        recorder.write(Path(folder), summary)
        return {path.name: path.read_bytes() for path in Path(folder).iterdir()}
