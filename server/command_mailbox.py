"""What is left for the walking thread: the newest command with its time to live, and when to sit
down. Each is one attribute holding a frozen value; the newest wins.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from walking_console.planner.types import Command


class TimedCommand(NamedTuple):
    """A command as it waits for the next tick, with the wall time at which it lapses."""

    command: Command
    ttl: float  # s
    deadline: float  # s, monotonic


class CommandMailbox:
    """Any thread puts, the walking thread takes."""

    def __init__(self) -> None:
        self._newest: TimedCommand | None = None
        # the last one that was taken: the mailbox itself is only ever overwritten
        self._taken: TimedCommand | None = None
        self._deadline = math.inf

    def put(self, command: Command, ttl: float, now: float) -> None:
        """Leave a command that lapses ``ttl`` s after ``now``."""
        self._newest = TimedCommand(command, ttl, now + ttl)

    def take(self) -> TimedCommand | None:
        """The newest command, or None when it has been taken already."""
        newest = self._newest
        if newest is None or newest is self._taken:
            return None
        self._taken = newest
        self._deadline = newest.deadline
        return newest

    def lapses(self, now: float) -> bool:
        """True once, when the command that was taken has outlived its time."""
        if now <= self._deadline:
            return False
        self._deadline = math.inf
        return True


class Deadline(NamedTuple):
    """When the machine is to sit down unless somebody is heard before."""

    at: float  # s, monotonic


class SitDownTimer:
    """Any thread sets, the walking thread asks."""

    def __init__(self) -> None:
        self._newest = Deadline(math.inf)
        self._served = self._newest

    def set(self, at: float) -> None:
        """Due at this time unless another is set before; ``inf``: never."""
        self._newest = Deadline(at)

    def falls_due(self, now: float) -> bool:
        """True once for every time that was set, when it has come."""
        newest = self._newest
        if now <= newest.at or newest is self._served:
            return False
        self._served = newest
        return True
