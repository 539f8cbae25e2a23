"""Writes to the data folder in a thread of their own, in order: a dead disk holds nobody up."""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable
from typing import NamedTuple

log = logging.getLogger(__name__)


class Write(NamedTuple):
    """What is to be written, and what is said where that fails."""

    act: Callable[[], None]
    otherwise: str
    done: threading.Event


class DiskThread:
    """Begun by its first write; ends with the program, whatever is still to be written."""

    def __init__(self) -> None:
        self._writes: queue.SimpleQueue[Write] = queue.SimpleQueue()
        self._thread: threading.Thread | None = None

    def write(self, act: Callable[[], None], otherwise: str) -> threading.Event:
        """Leave a write, which may raise ``OSError``; the event is set as soon as it is done."""
        write = Write(act, otherwise, threading.Event())
        self._writes.put(write)
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="disk", daemon=True)
            self._thread.start()
        return write.done

    def _run(self) -> None:
        while True:
            act, otherwise, done = self._writes.get()
            try:
                act()
            except OSError as error:
                log.warning("%s: %s", otherwise, error)
            else:
                done.set()
