"""Looks into the data folder in threads of their own: a dead disk keeps them, and nobody else.

Where looks hang, the next ones are refused in time, and what needs no disk, a stop above all, goes
on. What is no plain file, such as a pipe that somebody has put there, has nothing to say.
"""

from __future__ import annotations

import asyncio
import os
import stat
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TypeVar

from .limits import DISK_LOOKS_AT_ONCE, DISK_TIME, TEXT_FILE_MAX

T = TypeVar("T")


class DeadDisk(Exception):
    """The data folder does not answer."""


class DiskReads:
    """Threads that look, and nothing else."""

    def __init__(self, seconds: float = DISK_TIME) -> None:
        self._seconds = seconds
        self._threads = ThreadPoolExecutor(DISK_LOOKS_AT_ONCE, "disk reads")

    async def ask(self, look: Callable[..., T], *of: object) -> T:
        """What a look answers; raises ``DeadDisk`` where it takes too long, and what it raises."""
        loop = asyncio.get_running_loop()
        looking = loop.run_in_executor(self._threads, lambda: look(*of))
        try:
            return await asyncio.wait_for(looking, self._seconds)
        except TimeoutError:
            raise DeadDisk(f"the data folder has not answered for {self._seconds:g} s") from None


def plain_text(path: Path, most: int = TEXT_FILE_MAX) -> str:
    """The last ``most`` bytes of a plain file as text; '' where there is none."""
    # not blocking: somebody may have put a pipe there
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)
    try:
        with open(os.open(path, flags), "rb") as file:
            found = os.fstat(file.fileno())
            if not stat.S_ISREG(found.st_mode):
                return ""
            file.seek(max(0, found.st_size - most))
            return file.read(most).decode("utf-8", "replace")
    except OSError:
        return ""
