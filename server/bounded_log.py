"""A log that no client can fill a disk with: so many letters a minute, and then how much was left
unsaid.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from typing import TextIO

from .limits import LOG_LETTERS, LOG_WINDOW

OURS = "walking_console"
UNSAID = "%d more lines of the last %.0f s are left unsaid"


class LogBudget:
    """What may still be said in this window; shared by the handlers of one console."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._begun = now()
        self._left = LOG_LETTERS
        self._unsaid = 0

    def take(self, letters: int) -> bool:
        """Whether so much may be said."""
        self._left -= letters
        if self._left < 0:
            self._unsaid += 1
        return self._left >= 0

    def window_over(self) -> int | None:
        """Once a window has passed: how many lines of it were left unsaid; None before."""
        now = self._now()
        if now < self._begun + LOG_WINDOW:
            return None
        unsaid = self._unsaid
        self._begun = now
        self._left = LOG_LETTERS
        self._unsaid = 0
        return unsaid


class BoundedHandler(logging.StreamHandler[TextIO]):
    """Writes what the budget allows."""

    def __init__(self, stream: TextIO, budget: LogBudget) -> None:
        super().__init__(stream)
        self._budget = budget

    def emit(self, record: logging.LogRecord) -> None:
        """Say it, or count it; what the last window left unsaid comes first."""
        unsaid = self._budget.window_over()
        if unsaid:
            said = (unsaid, LOG_WINDOW)
            self._say(logging.LogRecord(record.name, logging.WARNING, "", 0, UNSAID, said, None))
        self._say(record)

    def _say(self, record: logging.LogRecord) -> None:
        if self._budget.take(len(self.format(record)) + 1):
            super().emit(record)


def is_of_others(record: logging.LogRecord) -> bool:
    """True for what libraries say."""
    return record.name.partition(".")[0] != OURS
