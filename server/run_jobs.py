"""Scripted runs: each a child process (``walking-console run``) with its directory under the data
folder, never in the walking thread.

``DATA/runs/ID`` is the run directory of the contract, written by the child; ``DATA/jobs/ID`` holds
the scenario it was given, its progress lines and its errors. Nothing here waits: a state is read
from the process and the files when somebody asks.
"""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any

COMMAND = (sys.executable, "-m", "walking_console")
RUNS_AT_ONCE = 2
RUNS_KEPT = 1000
DURATION_MAX = 3600.0  # s of simulated time
SPACE_MIN = 200e6  # bytes free, below which no run begins
NICENESS = 10  # the walk on the screen goes first
PATIENCE = 2.0  # s between asking a child to end and ending it
ID = re.compile(r"[a-z0-9][a-z0-9_-]{0,63}")
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
)


class RunRefused(Exception):
    """A run that is not begun, with the HTTP status that says so."""

    def __init__(self, status: int, reason: str) -> None:
        super().__init__(reason)
        self.status = status


@dataclass(eq=False)
class Job:
    """A child at work."""

    process: subprocess.Popen[bytes]
    asked: float | None = None  # s, monotonic, when it was asked to end


class Runs:
    """Starts, lists and cancels runs. Used from the web loop only."""

    def __init__(self, data: Path) -> None:
        self.data = data
        self.runs, self._jobs_folder = data / "runs", data / "jobs"
        self._jobs: dict[str, Job] = {}

    def start(
        self, scenario: Mapping[str, Any], name: str, *, trace_decisions: bool = False
    ) -> str:
        """Begin a run of this resolved scenario; answers its id, or raises ``RunRefused``."""
        self._check_room()
        run_id = self._new_id(name)
        folder = self._jobs_folder / run_id
        (folder / "scenario.toml").write_text(toml(scenario), "utf-8")
        command = [
            *COMMAND,
            "run",
            str(folder / "scenario.toml"),
            "--out",
            str(self.runs / run_id),
            "--progress-json",
        ]
        if trace_decisions:
            command.append("--trace-decisions")
        with (
            (folder / "progress.jsonl").open("wb") as progress,
            (folder / "errors.txt").open("wb") as errors,
        ):
            process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=progress,
                stderr=errors,
                start_new_session=True,
            )
        self._jobs[run_id] = Job(process)
        try:
            os.setpriority(os.PRIO_PROCESS, process.pid, NICENESS)
        except (OSError, AttributeError):
            pass  # it has ended already, or this system has no such call
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
            raise RunRefused(
                507, f"runs cannot be kept in {str(self.data)!r}: {error.strerror}"
            ) from None
        if free < SPACE_MIN:
            raise RunRefused(507, f"less than {SPACE_MIN / 1e6:.0f} MB are free for runs")
        if len(self.ids()) >= RUNS_KEPT:
            raise RunRefused(
                507, f"{RUNS_KEPT} runs are kept already; remove some from {str(self.data)!r}"
            )

    def _new_id(self, name: str) -> str:
        stem = re.sub(r"[^a-z0-9_-]+", "-", name.lower()).strip("-_")[:50] or "run"
        for number in count(1):
            run_id = f"{stem}-{number:04d}"
            if (self.runs / run_id).exists():
                continue
            try:
                (self._jobs_folder / run_id).mkdir()
            except FileExistsError:
                continue
            except OSError as error:
                raise RunRefused(
                    507, f"runs cannot be kept in {str(self.data)!r}: {error.strerror}"
                ) from None
            return run_id
        raise AssertionError("unreachable")

    def ids(self) -> list[str]:
        """Every run there is, sorted."""
        return sorted({*self._names(self.runs), *self._names(self._jobs_folder)})

    @staticmethod
    def _names(folder: Path) -> list[str]:
        try:
            return [
                entry.name
                for entry in os.scandir(folder)
                if ID.fullmatch(entry.name) and entry.is_dir(follow_symlinks=False)
            ]
        except OSError:
            return []

    def knows(self, run_id: str) -> bool:
        return ID.fullmatch(run_id) is not None and any(
            (folder / run_id).is_dir() for folder in (self.runs, self._jobs_folder)
        )

    def _working(self, run_id: str) -> bool:
        """Whether its child is at work; one that was asked to end and did not is ended."""
        job = self._jobs.get(run_id)
        if job is None or job.process.poll() is not None:
            return False
        if job.asked is not None and time.monotonic() - job.asked > PATIENCE:
            job.process.kill()
        return True

    def state(self, run_id: str) -> dict[str, Any]:
        """Progress and result of a run that ``knows`` knows."""
        working = self._working(run_id)
        summary = None if working else _json(self.runs / run_id / "run.json")
        state, reason = self._outcome(run_id, summary) if not working else ("running", "")
        result = None
        if summary is not None:
            result = {key: summary.get(key) for key in SUMMARY} | {
                "expect": summary.get("expect"),
                "state_hash": summary.get("state_hash"),
            }
        progress = _last_line(self._jobs_folder / run_id / "progress.jsonl")
        return {
            "id": run_id,
            "state": state,
            "reason": reason,
            "progress": progress,
            "result": result,
        }

    def _outcome(self, run_id: str, summary: dict[str, Any] | None) -> tuple[str, str]:
        if summary is not None and summary.get("result") in RESULTS:
            return str(summary["result"]), str(summary.get("reason", ""))
        job = self._jobs.get(run_id)
        if job is None:
            return "interrupted", "the console was ended while it ran"
        if job.asked is not None:
            return "interrupted", "cancelled"
        said = _text(self._jobs_folder / run_id / "errors.txt").strip()
        return "failed", said.rsplit("\n", 1)[-1][
            :500
        ] or f"the run ended with status {job.process.returncode}"

    def cancel(self, run_id: str) -> None:
        """Ask a run to end; one that is over stays as it is."""
        job = self._jobs.get(run_id)
        if job is not None and job.process.poll() is None and job.asked is None:
            job.asked = time.monotonic()
            job.process.terminate()

    def file(self, run_id: str, name: str) -> Path | None:
        """One of the files of a run, None when it has none of that name."""
        if name not in FILES or not self.knows(run_id) or self._working(run_id):
            return None
        path = self.runs / run_id / name
        return path if path.is_file() and not path.is_symlink() else None

    def draw(self, run_id: str) -> subprocess.Popen[bytes]:
        """A child that writes ``replay.html`` into a finished run."""
        folder = self.runs / run_id
        command = [
            *COMMAND,
            "export",
            str(folder),
            "--to",
            "html",
            "--out",
            str(folder / "replay.html"),
        ]
        nowhere = subprocess.DEVNULL
        return subprocess.Popen(
            command, stdin=nowhere, stdout=nowhere, stderr=nowhere, start_new_session=True
        )

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


def toml(data: Mapping[str, Any]) -> str:
    """Plain data as TOML, one line a key; None is left out."""
    return "".join(
        f"{_key(key)} = {_value(value)}\n" for key, value in data.items() if value is not None
    )


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _string(key)


def _string(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return (
            repr(value)
            if math.isfinite(value)
            else {math.inf: "inf", -math.inf: "-inf"}.get(value, "nan")
        )
    if isinstance(value, Mapping):
        return (
            "{"
            + ", ".join(
                f"{_key(key)} = {_value(item)}" for key, item in value.items() if item is not None
            )
            + "}"
        )
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_value(item) for item in value) + "]"
    raise TypeError(f"TOML has no {type(value).__name__}")
