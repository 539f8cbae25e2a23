"""Children that wait their turn: so many at work at once, the others in the order they came."""

from __future__ import annotations

import subprocess
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from .child_process import PATIENCE

AT_ONCE = 2
WAITING_MAX = 200

Begin = Callable[[], "subprocess.Popen[bytes]"]


@dataclass(eq=False)
class Job:
    """A child at work, or one to be: ``begin`` starts it."""

    begin: Begin
    process: subprocess.Popen[bytes] | None = None
    cancelled_at: float | None = None  # s, monotonic
    fault: str = ""  # why it could not be begun

    @property
    def waiting(self) -> bool:
        """Whether its turn has not come."""
        return self.process is None and self.cancelled_at is None and not self.fault

    @property
    def working(self) -> bool:
        """Whether it has begun and has not ended."""
        return self.process is not None and self.process.poll() is None

    def ask_to_end(self) -> None:
        """Once; one that is over stays as it is."""
        if self.cancelled_at is not None or not (self.waiting or self.working):
            return
        self.cancelled_at = time.monotonic()
        if self.process is not None:
            self.process.terminate()

    def end_if_overdue(self) -> None:
        """Asked to end and still there after ``PATIENCE``: ended."""
        overdue = self.cancelled_at is not None and time.monotonic() - self.cancelled_at > PATIENCE
        if overdue and self.process is not None:
            self.process.kill()


class JobQueue:
    """Begins each job when its turn comes: a thread waits for every child at work, and its end is
    the turn of the next. May be used from any thread.
    """

    def __init__(self, at_once: int = AT_ONCE) -> None:
        self.at_once = at_once
        self._turn = threading.Lock()
        self._waiting = deque[Job]()
        self._working: list[Job] = []
        self._stopped = False

    @property
    def full(self) -> bool:
        """Whether so many wait that no more are taken."""
        with self._turn:
            return len(self._waiting) >= WAITING_MAX

    def add(self, begin: Begin) -> Job:
        """A job at the end of the queue; begun now where there is room."""
        job = Job(begin)
        with self._turn:
            self._waiting.append(job)
        self._begin_next()
        return job

    def place(self, job: Job) -> int | None:
        """How many jobs are before this one; None when it does not wait."""
        with self._turn:
            return self._waiting.index(job) if job in self._waiting else None

    def cancel(self, job: Job) -> None:
        """Take a job out of the queue, or ask its child to end; one that is over stays."""
        with self._turn:
            if job in self._waiting:
                self._waiting.remove(job)
            job.ask_to_end()

    def _begin_next(self) -> None:
        with self._turn:
            self._working = [job for job in self._working if job.working]
            while self._waiting and len(self._working) < self.at_once and not self._stopped:
                self._begin(self._waiting.popleft())

    def _begin(self, job: Job) -> None:
        try:
            job.process = job.begin()
        except OSError as error:
            job.fault = f"it could not be begun: {error.strerror}"
            return
        self._working.append(job)
        threading.Thread(target=self._wait_for, args=(job.process,), daemon=True).start()

    def _wait_for(self, process: subprocess.Popen[bytes]) -> None:
        process.wait()
        self._begin_next()

    def stop(self) -> None:
        """Nothing more is begun, and every child is ended, at once where it has to be."""
        with self._turn:
            self._stopped = True
            jobs = [*self._waiting, *self._working]
            self._waiting.clear()
            for job in jobs:
                job.ask_to_end()
        deadline = time.monotonic() + 1.0
        for process in [job.process for job in jobs if job.process is not None]:
            try:
                process.wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait(1.0)
