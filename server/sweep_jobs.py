"""Sweeps over HTTP: each a child process (``walking-console sweep``), in one queue with the runs.

``DATA/sweeps/ID`` is the folder of the sweep, ``DATA/sweep-jobs/ID`` holds what the child was given
and what it said.
"""

from __future__ import annotations

import csv
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from walking_console.sim.runs.sweep.executors import cores

from .run_jobs import ChildJobs, read_json
from .toml_text import toml

CURVE = "pass-rate.svg"
TABLE = "table.csv"
SUMMARY = "sweep.json"
SWEEP_FILES = {
    TABLE: "text/csv; charset=utf-8",
    "table.parquet": "application/vnd.apache.parquet",
    SUMMARY: "application/json",
    CURVE: "image/svg+xml",
}


@dataclass(frozen=True)
class SweepOrder:
    """What a sweep over HTTP is to walk: a shipped scenario by name or one as data, the words of
    ``--set``, the seeds, whose directories are kept, and files that the scenario names.
    """

    name: str
    scenario: Mapping[str, Any] | None
    settings: tuple[str, ...]
    seeds: str | None
    keep: str
    files: Sequence[Path] = ()

    def words(self, folder: Path, out: Path) -> list[str]:
        """The command line of it; half of the cores walk, the others are the console's."""
        named = self.name
        if self.scenario is not None:
            named = str(folder / "scenario.toml")
            Path(named).write_text(toml(self.scenario), "utf-8")
        for file in self.files:
            shutil.copyfile(file, folder / file.name)
        settings = [word for setting in self.settings for word in ("--set", setting)]
        seeds = [] if self.seeds is None else ["--seeds", self.seeds]
        jobs = ["--jobs", str(max(1, cores() // 2)), "--keep", self.keep, "--progress-json"]
        return ["sweep", named, "--out", str(out), *settings, *seeds, *jobs]


class SweepJobs(ChildJobs):
    """Starts, lists and cancels sweeps."""

    word = "sweep"
    results = "sweeps"
    given = "sweep-jobs"
    files = SWEEP_FILES
    summary = SUMMARY
    drawing = CURVE

    def start(self, order: SweepOrder) -> str:
        """Queue a sweep; answers its id, or raises ``RunRefused``."""
        return self._begin(order.name, order.words)

    def _result(self, job_id: str) -> tuple[str, str, dict[str, Any] | None] | None:
        asked = read_json(self.folder / job_id / SUMMARY)
        passed = _passed(self.folder / job_id / TABLE)
        if asked is None or passed is None:
            return None
        figures = {"runs": len(passed), "passed": sum(passed)}
        if len(passed) == asked.get("runs"):
            return "completed", "", figures
        return *self._why_there_is_none(job_id), figures

    def _drawing_words(self, folder: Path, part: Path) -> list[str]:
        return ["sweep", "plot", str(folder), "--out", str(part)]


def _passed(path: Path) -> list[bool] | None:
    """Of every row of a table whether its run passed; None where there is no table."""
    if not path.is_file():  # a pipe would be waited for
        return None
    try:
        with path.open(newline="", encoding="utf-8") as file:
            return [row.get("passed") == "1" for row in csv.DictReader(file)]
    except OSError:
        return None
