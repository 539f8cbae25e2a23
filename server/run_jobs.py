"""Scripted runs: each a child process (``walking-console run``) with its directory under the data
folder, never in the walking thread.

``DATA/runs/ID`` is the run directory of the contract, written by the child; ``DATA/jobs/ID`` holds
the scenario it was given, its progress lines and its errors. Nothing here waits: a state is read
from the process and the files when somebody asks.
"""

from __future__ import annotations

import json
import logging
import os
import re
import shutil
import subprocess
import time
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any

from .child_process import start_child
from .toml_text import toml

RUNS_AT_ONCE = 2
RUNS_KEPT = 1000
SPACE_MIN = 200e6  # bytes free, below which no run begins
PATIENCE = 2.0  # s between asking a child to end and ending it
REASON_SHOWN = 500  # characters of what a child said last
ID = re.compile(r"[a-z0-9][a-z0-9_-]{0,63}")
STEM_LENGTH = 50  # characters of a name that an id keeps
FILES = {
    "run.json": "application/json",
    "ticks.npz": "application/octet-stream",
    "steps.jsonl": "application/x-ndjson",
    "terrain.npz": "application/octet-stream",
    "inputs.jsonl": "application/x-ndjson",
    "replay.html": "text/html; charset=utf-8",
}
RESULTS = ("completed", "blocked", "fell", "interrupted")
SUMMARY = (
    "result",
    "reason",
    "ticks",
    "seconds",
    "distance",
    "mean_speed",
    "steps",
    "margin_min",
    "forbidden_steps",
    "falls",
    "emergent",
    "expect",
    "state_hash",
)


log = logging.getLogger(__name__)


class RunRefused(Exception):
    """A run that is not begun, with the HTTP status that says so."""

    def __init__(self, status: int, reason: str) -> None:
        super().__init__(reason)
        self.status = status


@dataclass(eq=False)
class Job:
    """A child at work."""

    process: subprocess.Popen[bytes]
    cancelled_at: float | None = None  # s, monotonic

    @property
    def working(self) -> bool:
        """Whether it has not ended."""
        return self.process.poll() is None

    def ask_to_end(self) -> None:
        """Once; one that is over stays as it is."""
        if self.working and self.cancelled_at is None:
            self.cancelled_at = time.monotonic()
            self.process.terminate()

    def end_if_overdue(self) -> None:
        """Asked to end and still there after ``PATIENCE``: ended."""
        if self.cancelled_at is not None and time.monotonic() - self.cancelled_at > PATIENCE:
            self.process.kill()


class RunJobs:
    """Starts, lists and cancels runs. Used from the web loop only."""

    def __init__(self, data: Path) -> None:
        self.data = data.absolute()
        self.runs = self.data / "runs"
        self._jobs_folder = self.data / "jobs"
        self._jobs: dict[str, Job] = {}

    def start(
        self, scenario: Mapping[str, Any], name: str, *, trace_decisions: bool = False
    ) -> str:
        """Begin a run of this resolved scenario; answers its id, or raises ``RunRefused``."""
        self._check_room()
        run_id = self._new_id(name)
        folder = self._jobs_folder / run_id
        written = folder / "scenario.toml"
        written.write_text(toml(scenario), "utf-8")
        arguments = ["run", str(written), "--out", str(self.runs / run_id), "--progress-json"]
        if trace_decisions:
            arguments.append("--trace-decisions")
        with (
            (folder / "progress.jsonl").open("wb") as progress,
            (folder / "errors.txt").open("wb") as errors,
        ):
            self._jobs[run_id] = Job(start_child(arguments, folder, progress, errors))
        log.info("run %s begun", run_id)
        return run_id

    def _check_room(self) -> None:
        working = sum(self._working(run_id) for run_id in list(self._jobs))
        if working >= RUNS_AT_ONCE:
            raise RunRefused(429, f"{RUNS_AT_ONCE} runs are at work already")
        try:
            self.runs.mkdir(parents=True, exist_ok=True)
            self._jobs_folder.mkdir(parents=True, exist_ok=True)
            free = shutil.disk_usage(self.data).free
        except OSError as error:
            raise self._cannot_be_kept(error) from None
        if free < SPACE_MIN:
            raise RunRefused(507, f"less than {SPACE_MIN / 1e6:.0f} MB are free for runs")
        if len(self.ids()) >= RUNS_KEPT:
            raise RunRefused(
                507, f"{RUNS_KEPT} runs are kept already; remove some from {str(self.data)!r}"
            )

    def _cannot_be_kept(self, error: OSError) -> RunRefused:
        return RunRefused(507, f"runs cannot be kept in {str(self.data)!r}: {error.strerror}")

    def _new_id(self, name: str) -> str:
        """The next free number of this name, with its folder made."""
        for number in count(1):
            run_id = numbered(name, number)
            if (self.runs / run_id).exists():
                continue
            try:
                (self._jobs_folder / run_id).mkdir()
            except FileExistsError:
                continue
            except OSError as error:
                raise self._cannot_be_kept(error) from None
            return run_id
        raise AssertionError("unreachable")

    def ids(self) -> list[str]:
        """Every run there is, sorted."""
        return sorted({*_folders(self.runs), *_folders(self._jobs_folder)})

    def knows(self, run_id: str) -> bool:
        """Whether there is such a run, at work or over."""
        return ID.fullmatch(run_id) is not None and any(
            (folder / run_id).is_dir() for folder in (self.runs, self._jobs_folder)
        )

    def _working(self, run_id: str) -> bool:
        """Whether its child is at work; one that was asked to end and did not is ended."""
        job = self._jobs.get(run_id)
        if job is None or not job.working:
            return False
        job.end_if_overdue()
        return True

    def state(self, run_id: str) -> dict[str, Any]:
        """Progress and result of a run that ``knows`` knows."""
        working = self._working(run_id)
        summary = None if working else _json(self.runs / run_id / "run.json")
        state, reason = ("running", "") if working else self._outcome(run_id, summary)
        return {
            "id": run_id,
            "state": state,
            "reason": reason,
            "progress": _last_line(self._jobs_folder / run_id / "progress.jsonl"),
            "result": None if summary is None else {key: summary.get(key) for key in SUMMARY},
        }

    def _outcome(self, run_id: str, summary: dict[str, Any] | None) -> tuple[str, str]:
        """State and reason of a run that is over."""
        if summary is not None and summary.get("result") in RESULTS:
            return str(summary["result"]), str(summary.get("reason", ""))
        job = self._jobs.get(run_id)
        if job is None:
            return "interrupted", "the console was ended while it ran"
        if job.cancelled_at is not None:
            return "interrupted", "cancelled"
        said = _text(self._jobs_folder / run_id / "errors.txt").strip()
        last = said.rsplit("\n", 1)[-1][:REASON_SHOWN]
        return "failed", last or f"the run ended with status {job.process.returncode}"

    def cancel(self, run_id: str) -> None:
        """Ask a run to end; one that is over stays as it is."""
        job = self._jobs.get(run_id)
        if job is not None:
            log.info("run %s cancelled", run_id)
            job.ask_to_end()

    def file(self, run_id: str, name: str) -> Path | None:
        """One of the files of a run, None when it has none of that name."""
        if name not in FILES or not self.knows(run_id) or self._working(run_id):
            return None
        path = self.runs / run_id / name
        return path if path.is_file() and not path.is_symlink() else None

    def draw(self, run_id: str) -> subprocess.Popen[bytes]:
        """A child that writes ``replay.html`` into a finished run."""
        folder = self.runs / run_id
        page = str(folder / "replay.html")
        return start_child(["export", str(folder), "--to", "html", "--out", page], folder)

    def stop(self) -> None:
        """End every child, at once where it has to be."""
        for run_id in self._jobs:
            self.cancel(run_id)
        deadline = time.monotonic() + 1.0
        for job in self._jobs.values():
            try:
                job.process.wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                job.process.kill()
                job.process.wait(1.0)


def numbered(name: str, number: int) -> str:
    """``flat-0001``: a name as ids and folders of runs carry it."""
    stem = re.sub(r"[^a-z0-9_-]+", "-", name.lower()).strip("-_")[:STEM_LENGTH] or "run"
    return f"{stem}-{number:04d}"


def _folders(folder: Path) -> list[str]:
    """Names of the runs in a folder; none when there is no such folder."""
    try:
        return [
            entry.name
            for entry in os.scandir(folder)
            if ID.fullmatch(entry.name) and entry.is_dir(follow_symlinks=False)
        ]
    except OSError:
        return []


def _text(path: Path) -> str:
    try:
        return path.read_text("utf-8", "replace")
    except OSError:
        return ""


def _json(path: Path) -> dict[str, Any] | None:
    try:
        data = json.loads(_text(path) or "null")
    except ValueError:
        return None
    return data if isinstance(data, dict) else None


def _last_line(path: Path) -> dict[str, Any] | None:
    """The newest whole progress line; a half-written one is not there yet."""
    for line in reversed(_text(path).splitlines()[-2:]):
        try:
            data = json.loads(line)
        except ValueError:
            continue
        if isinstance(data, dict):
            return data
    return None
