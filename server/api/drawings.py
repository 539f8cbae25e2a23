"""Replay pages of runs and curves of sweeps: drawn when somebody asks, one at a time, and then
kept with what they show.
"""

from __future__ import annotations

import asyncio
from pathlib import Path

from ..limits import DRAWINGS_ASKED_MAX, DRAWS_AT_ONCE
from ..run_jobs import ChildJobs
from .errors import HTTPProblem

DRAW_TIME = 120.0  # s to draw one


class Drawings:
    """Who waits for one, and whose turn it is."""

    def __init__(self, *kinds: ChildJobs) -> None:
        self._kinds = kinds
        self._turn = asyncio.Semaphore(DRAWS_AT_ONCE)
        self._asked = 0

    async def drawing_of(self, jobs: ChildJobs, job_id: str) -> Path | None:
        """The drawing of a run or sweep that is over, None where it cannot be drawn; raises
        ``HTTPProblem`` where too many wait.
        """
        if await jobs.disk.ask(jobs.file, job_id, jobs.summary) is None:
            return None
        if self._asked >= DRAWINGS_ASKED_MAX:
            raise HTTPProblem(429, f"{DRAWINGS_ASKED_MAX} drawings are waited for already")
        self._asked += 1
        try:
            async with self._turn:
                if await jobs.disk.ask(jobs.file, job_id, jobs.drawing) is None:
                    await asyncio.to_thread(jobs.draw, job_id, DRAW_TIME)
                return await jobs.disk.ask(jobs.file, job_id, jobs.drawing)
        finally:
            self._asked -= 1

    def stop(self) -> None:
        """End what is being drawn, and draw nothing more."""
        for jobs in self._kinds:
            jobs.drawings.stop()
