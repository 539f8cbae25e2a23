"""The stop that outlives the console: a file that is there as long as everything is stopped.

Only whether it is there counts, so a write that broke off stops all the same.
"""

from __future__ import annotations

import asyncio
import logging
import os
import threading
import time
from pathlib import Path

from .disk_thread import DiskThread

LOOK_EVERY = 0.005  # s

log = logging.getLogger(__name__)


class StopLatch:
    """Whether everything is stopped; kept in ``file`` over restarts where there is one."""

    def __init__(self, file: Path | None = None, disk: DiskThread | None = None) -> None:
        self._file = file
        self._disk = disk or DiskThread()
        self._kept = threading.Event()  # what the disk knows of it
        self.is_set = file is not None and os.path.lexists(file)
        if self.is_set:
            log.warning("everything is stopped, as it was before the restart")

    def set(self, stopped: bool) -> bool:
        """Stop everything, or end that; whether it was not so before. The disk follows."""
        if stopped == self.is_set:
            return False
        log.info("stopped" if stopped else "the stop is released")
        self.is_set = stopped
        if self._file is not None:
            act = self._write if stopped else self._remove
            self._kept = self._disk.write(act, "a restart will not know of the stop")
        return True

    async def wait(self, seconds: float) -> bool:
        """Until the disk knows, and whether it does; at most so long. In the web loop, since every
        other thread may hang in a dead disk.
        """
        end = time.monotonic() + seconds
        while not self._kept.is_set() and time.monotonic() < end:
            await asyncio.sleep(LOOK_EVERY)
        return self._kept.is_set()

    def _write(self) -> None:
        assert self._file is not None
        self._file.parent.mkdir(parents=True, exist_ok=True)
        # not blocking: somebody may have put a pipe there
        flags = os.O_WRONLY | os.O_CREAT | getattr(os, "O_NONBLOCK", 0)
        with open(os.open(self._file, flags, 0o644), "wb") as file:
            os.fsync(file)

    def _remove(self) -> None:
        assert self._file is not None
        self._file.unlink(missing_ok=True)
