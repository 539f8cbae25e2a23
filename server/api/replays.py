"""Replay pages of runs: drawn when somebody asks, one at a time, and then kept with the run."""

from __future__ import annotations

import asyncio
from pathlib import Path

from ..limits import DRAWS_AT_ONCE, REPLAYS_ASKED_MAX
from ..run_jobs import REPLAY, RunJobs
from .errors import HTTPProblem

DRAW_TIME = 120.0  # s to draw one


class Replays:
    """Who waits for one, and whose turn it is."""

    def __init__(self, jobs: RunJobs) -> None:
        self._jobs = jobs
        self._turn = asyncio.Semaphore(DRAWS_AT_ONCE)
        self._asked = 0

    async def page_of(self, run_id: str) -> Path | None:
        """The page of a run that is over, None where it cannot be drawn; raises ``HTTPProblem``
        where too many wait.
        """
        if self._jobs.file(run_id, "run.json") is None:
            return None
        if self._asked >= REPLAYS_ASKED_MAX:
            raise HTTPProblem(429, f"{REPLAYS_ASKED_MAX} replays are waited for already")
        self._asked += 1
        try:
            async with self._turn:
                if self._jobs.file(run_id, REPLAY) is None:
                    await asyncio.to_thread(self._jobs.draw, run_id, DRAW_TIME)
                return self._jobs.file(run_id, REPLAY)
        finally:
            self._asked -= 1

    def stop(self) -> None:
        """End what is being drawn, and draw nothing more."""
        self._jobs.drawings.stop()
