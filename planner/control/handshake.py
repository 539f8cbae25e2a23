"""The hand-shake of Levels B and C (H §9.3): three flags, and the six transitions that change them.

F1: Level C has called for gait operation, until Level B has completed it. F2: Level B has notified
that it is over, until Level C has received the parameters. F3: Level C wants the parameters now,
until it has received them. (The print lets F1 and F2 be "reset in turn" on completion; that F2 is
set then follows from its definition.)
"""

from __future__ import annotations

from enum import IntEnum

Flags = tuple[bool, bool, bool]  # F1, F2, F3

IDLE: Flags = (False, False, False)
ASKED: Flags = (True, False, False)
READY: Flags = (False, True, False)
WANTED: Flags = (True, False, True)


class FlagChange(IntEnum):
    """What happened to a flag; the value is its bit in the log."""

    CALLED = 0  # F1 is set
    COMPLETED = 1  # F1 is reset
    NOTIFIED = 2  # F2 is set
    TAKEN = 3  # F2 is reset
    WANTED = 4  # F3 is set
    SUPPLIED = 5  # F3 is reset


# Level C's word or Level B's: which flag it is about, and what becomes of it
_EFFECT: dict[FlagChange, tuple[int, bool]] = {
    FlagChange.CALLED: (0, True),
    FlagChange.COMPLETED: (0, False),
    FlagChange.NOTIFIED: (1, True),
    FlagChange.TAKEN: (1, False),
    FlagChange.WANTED: (2, True),
    FlagChange.SUPPLIED: (2, False),
}


class Handshake:
    """The flags as they are; ``changes`` are the transitions since ``begin_tick``, one bit each."""

    def __init__(self) -> None:
        self.flags = IDLE
        self.changes = 0

    def begin_tick(self) -> None:
        """What changed before belongs to the tick before."""
        self.changes = 0

    def call(self) -> None:
        """Level C asks Level B for a plan; what was ready for another question is not any more."""
        self._happens(FlagChange.TAKEN)
        self._happens(FlagChange.CALLED)

    def complete(self) -> None:
        """Level B has an answer: its operation is over, and Level C is told."""
        self._happens(FlagChange.COMPLETED)
        self._happens(FlagChange.NOTIFIED)

    def want(self) -> None:
        """Level C waits for the answer."""
        self._happens(FlagChange.WANTED)

    def receive(self) -> None:
        """Level C has the answer. Raises ``RuntimeError`` when Level B has given none."""
        if not self.flags[1]:
            raise RuntimeError("Level C receives what Level B has not notified: F2 is not set")
        self._happens(FlagChange.WANTED)
        self._happens(FlagChange.TAKEN)
        self._happens(FlagChange.SUPPLIED)

    def dismiss(self) -> None:
        """Level C wants no plan any more."""
        for change in (FlagChange.COMPLETED, FlagChange.TAKEN, FlagChange.SUPPLIED):
            self._happens(change)

    def _happens(self, change: FlagChange) -> None:
        flag, to = _EFFECT[change]
        if self.flags[flag] is to:
            return
        one, two, three = (to if k == flag else is_set for k, is_set in enumerate(self.flags))
        self.flags = one, two, three
        self.changes |= 1 << change
