"""Scripted runs: each a child process (``walking-console run``) with its directory under the data
folder, never in the walking thread.

``DATA/runs/ID`` is the run directory of the contract, written by the child; ``DATA/jobs/ID`` holds
the scenario it was given, its progress lines and its errors. A state is read from the process and
the files when somebody asks; who waits for whom is the queue's (``job_queue``).
"""

from __future__ import annotations

import json
import logging
import os
import re
import shutil
import subprocess
from collections.abc import Callable, Mapping
from itertools import count
from pathlib import Path
from typing import Any, ClassVar

from .child_process import start_child
from .disk_reads import DiskReads, plain_text
from .job_queue import WAITING_MAX, Job, JobQueue
from .toml_text import toml

RUNS_KEPT = 1000
SPACE_MIN = 200e6  # bytes free, below which no run begins
REASON_SHOWN = 500  # characters of what a child said last
ID = re.compile(r"[a-z0-9][a-z0-9_-]{0,63}")
STEM_LENGTH = 50  # characters of a name that an id keeps
REPLAY = "replay.html"
FILES = {
    "run.json": "application/json",
    "ticks.npz": "application/octet-stream",
    "steps.jsonl": "application/x-ndjson",
    "terrain.npz": "application/octet-stream",
    "inputs.jsonl": "application/x-ndjson",
    REPLAY: "text/html; charset=utf-8",
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


WALKED = ("robot", "planner", "mode", "seed", "plant")  # what tells two runs of a scenario apart

log = logging.getLogger(__name__)


class RunRefused(Exception):
    """A run or sweep that is not begun, with the HTTP status that says so."""

    def __init__(self, status: int, reason: str) -> None:
        super().__init__(reason)
        self.status = status


class ChildJobs:
    """What runs and sweeps share: a folder of results, a folder of what the children were given and
    said, and their turn in a queue. May be used from any thread.
    """

    word: ClassVar[str]  # what one of them is called
    results: ClassVar[str]  # the folders below the data folder
    given: ClassVar[str]
    files: ClassVar[Mapping[str, str]]  # that may be read, with their media types
    summary: ClassVar[str]  # the file that is there once it can be drawn
    drawing: ClassVar[str]  # the file that is drawn when somebody asks

    def __init__(self, data: Path, queue: JobQueue) -> None:
        self.data = data.absolute()
        self.queue = queue
        self.folder = self.data / self.results
        self._given = self.data / self.given
        self._jobs: dict[str, Job] = {}
        self.drawings = JobQueue(at_once=1)
        self.disk = DiskReads()  # whoever waits in the web loop looks by it

    def _begin(self, name: str, words: Callable[[Path, Path], list[str]]) -> str:
        """Queue a child; ``words`` makes its arguments of its folder and of that of its results.
        Answers the id, or raises ``RunRefused``.
        """
        self._check_room()
        job_id = self._new_id(name)
        folder = self._given / job_id
        arguments = words(folder, self.folder / job_id)

        def begin() -> subprocess.Popen[bytes]:
            with (
                (folder / "progress.jsonl").open("wb") as progress,
                (folder / "errors.txt").open("wb") as errors,
            ):
                log.info("%s %s begun", self.word, job_id)
                return start_child(arguments, folder, progress, errors)

        self._jobs[job_id] = self.queue.add(begin)
        return job_id

    def _check_room(self) -> None:
        if self.queue.full:
            raise RunRefused(429, f"{WAITING_MAX} jobs are waiting already")
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            self._given.mkdir(parents=True, exist_ok=True)
            free = shutil.disk_usage(self.data).free
        except OSError as error:
            raise self._cannot_be_kept(error) from None
        if free < SPACE_MIN:
            raise RunRefused(507, f"less than {SPACE_MIN / 1e6:.0f} MB are free for {self.word}s")
        if len(self.ids()) >= RUNS_KEPT:
            kept = f"{RUNS_KEPT} {self.word}s are kept already"
            raise RunRefused(507, f"{kept}; remove some from {str(self.data)!r}")

    def _cannot_be_kept(self, error: OSError) -> RunRefused:
        where = repr(str(self.data))
        return RunRefused(507, f"{self.word}s cannot be kept in {where}: {error.strerror}")

    def _new_id(self, name: str) -> str:
        """The next free number of this name, with its folder made."""
        for number in count(1):
            job_id = numbered(name, number)
            if (self.folder / job_id).exists():
                continue
            try:
                (self._given / job_id).mkdir()
            except FileExistsError:
                continue
            except OSError as error:
                raise self._cannot_be_kept(error) from None
            return job_id
        raise AssertionError("unreachable")

    def ids(self) -> list[str]:
        """Every one there is, sorted."""
        return sorted({*_folders(self.folder), *_folders(self._given)})

    def knows(self, job_id: str) -> bool:
        """Whether there is such a one, waiting, at work or over."""
        return ID.fullmatch(job_id) is not None and any(
            (folder / job_id).is_dir() for folder in (self.folder, self._given)
        )

    def _working(self, job_id: str) -> bool:
        """Whether its child is at work; one that was asked to end and did not is ended."""
        job = self._jobs.get(job_id)
        if job is None or not job.working:
            return False
        job.end_if_overdue()
        return True

    def state(self, job_id: str) -> dict[str, Any]:
        """Progress and result of one that ``knows`` knows."""
        job = self._jobs.get(job_id)
        before = None if job is None else self.queue.place(job)
        state, reason, result = self._told(job_id, before)
        return {
            "id": job_id,
            "state": state,
            "reason": reason,
            "before": before,
            "progress": _last_line(self._given / job_id / "progress.jsonl"),
            "result": result,
        }

    def _told(self, job_id: str, before: int | None) -> tuple[str, str, dict[str, Any] | None]:
        """State, reason, and the result where it is over."""
        if before is not None:
            return "queued", "", None
        if self._working(job_id):
            return "running", "", None
        found = self._result(job_id)
        if found is not None:
            return found
        return *self._why_there_is_none(job_id), None

    def _result(self, job_id: str) -> tuple[str, str, dict[str, Any] | None] | None:
        """State, reason and figures that a child left; None where it left none."""
        raise NotImplementedError

    def _why_there_is_none(self, job_id: str) -> tuple[str, str]:
        job = self._jobs.get(job_id)
        if job is None:
            return "interrupted", "the console was ended while it ran or waited"
        if job.cancelled_at is not None:
            return "interrupted", "cancelled"
        said = plain_text(self._given / job_id / "errors.txt").strip()
        last = said.rsplit("\n", 1)[-1][:REASON_SHOWN]
        status = None if job.process is None else job.process.returncode
        return "failed", last or job.fault or f"the {self.word} ended with status {status}"

    def cancel(self, job_id: str) -> None:
        """Ask one to end; one that is over stays as it is."""
        job = self._jobs.get(job_id)
        if job is not None:
            log.info("%s %s cancelled", self.word, job_id)
            self.queue.cancel(job)

    def file(self, job_id: str, name: str) -> Path | None:
        """One of its files once it is over, None when it has none of that name."""
        if name not in self.files or not self.knows(job_id) or self._working(job_id):
            return None
        path = self.folder / job_id / name
        return path if path.is_file() and not path.is_symlink() else None

    def draw(self, job_id: str, limit: float) -> None:
        """Make the drawing of a finished one in a child; waits for it, at most ``limit`` s, so from
        a worker thread, one at a time.
        """
        folder = self.folder / job_id
        part = folder / f"part-{self.drawing}"
        arguments = self._drawing_words(folder, part)
        drawing = self.drawings.add(lambda: start_child(arguments, folder)).process
        if drawing is None:
            return  # the console ends
        try:
            drawing.wait(limit)
        except subprocess.TimeoutExpired:
            drawing.kill()
        else:
            if part.is_file() and drawing.returncode == 0:
                os.replace(part, folder / self.drawing)

    def _drawing_words(self, folder: Path, part: Path) -> list[str]:
        """The command line that draws what is in ``folder`` to ``part``."""
        raise NotImplementedError


class RunJobs(ChildJobs):
    """Starts, lists and cancels runs."""

    word = "run"
    results = "runs"
    given = "jobs"
    files = FILES
    summary = "run.json"
    drawing = REPLAY

    def start(
        self, scenario: Mapping[str, Any], name: str, *, trace_decisions: bool = False
    ) -> str:
        """Queue a run of this resolved scenario; answers its id, or raises ``RunRefused``."""

        def words(folder: Path, out: Path) -> list[str]:
            written = folder / "scenario.toml"
            written.write_text(toml(scenario), "utf-8")
            why = ["--trace-decisions"] if trace_decisions else []
            return ["run", str(written), "--out", str(out), "--progress-json", *why]

        return self._begin(name, words)

    def _result(self, job_id: str) -> tuple[str, str, dict[str, Any] | None] | None:
        summary = read_json(self.folder / job_id / "run.json")
        if summary is None or summary.get("result") not in RESULTS:
            return None
        figures = {key: summary.get(key) for key in SUMMARY}
        scenario = summary.get("scenario")
        if isinstance(scenario, dict):
            figures |= {key: scenario.get(key) for key in WALKED}
        return str(summary["result"]), str(summary.get("reason", "")), figures

    def _drawing_words(self, folder: Path, part: Path) -> list[str]:
        return ["export", str(folder), "--to", "html", "--out", str(part)]


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


def read_json(path: Path) -> dict[str, Any] | None:
    try:
        data = json.loads(plain_text(path) or "null")
    except ValueError:
        return None
    return data if isinstance(data, dict) else None


def _last_line(path: Path) -> dict[str, Any] | None:
    """The newest whole progress line; a half-written one is not there yet."""
    for line in reversed(plain_text(path).splitlines()[-2:]):
        try:
            data = json.loads(line)
        except ValueError:
            continue
        if isinstance(data, dict):
            return data
    return None
