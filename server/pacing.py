"""How fast the walk goes and how well the loop keeps up: rate, pause, single ticks, lateness, and
which tick was on the screen when.
"""

from __future__ import annotations

import math
from collections import deque

from walking_console.planner.types import TICK

RATE_MIN = 0.1  # times real time
RATE_MAX = 8.0  # times real time; more starves the pages on two cores
STALL = 0.2  # s without a tick of the loop that counts as stalled
ADVANCE_PER_TICK = 100  # simulated ticks in one of the loop; more would make it late itself
ADVANCE_MAX = 3000  # ticks of one request: a minute of walking
SHOWN_KEPT = 128  # published ticks that are remembered


class Pace:
    """How many simulated ticks the next tick of the loop walks."""

    def __init__(self) -> None:
        self.rate = 1.0
        self.paused = False
        self._begun = 0.0  # share of the next tick that is due already, below real time
        self._advances: deque[int] = deque()
        self._owed = 0

    def set_rate(self, rate: float) -> bool:
        """0.1 to 8 times real time, else ``ValueError``; answers whether it is another one."""
        if not RATE_MIN <= rate <= RATE_MAX:
            raise ValueError(f"rate must be {RATE_MIN:g} to {RATE_MAX:g}, got {rate:g}")
        changes = rate != self.rate
        self.rate = rate
        return changes

    def advance(self, ticks: int) -> None:
        """Walk this many ticks while paused."""
        self._advances.append(ticks)

    @property
    def owed(self) -> int:
        """Ticks still to be walked for ``advance``."""
        return self._owed + sum(self._advances.copy())

    def ticks_due(self) -> int:
        """Ticks to walk now. What remains of an advance is dropped when the walk goes on."""
        while self._advances:
            self._owed += self._advances.popleft()
        if not self.paused:
            self._owed = 0
            return self._ticks_at_rate()
        ticks = min(self._owed, ADVANCE_PER_TICK)
        self._owed -= ticks
        return ticks

    def _ticks_at_rate(self) -> int:
        self._begun += self.rate
        ticks = int(self._begun)
        self._begun -= ticks
        return ticks

    def forgive(self) -> None:
        """Nothing is owed any more: the walk stands still."""
        self._owed = 0


class Lateness:
    """How late the ticks of the loop come, s."""

    def __init__(self, now: float) -> None:
        self.worst = 0.0  # since the start
        self.skipped = 0  # ticks dropped because the loop was late
        self.last_at = now  # end of the last tick
        self._recent: deque[float] = deque([0.0], maxlen=round(1 / TICK))

    def note(self, late: float) -> int:
        """One tick came ``late`` s too late; answers how many whole ticks were missed by it."""
        missed = int(late / TICK)
        self.skipped += missed
        self.worst = max(self.worst, late)
        self._recent.append(late)
        return missed

    @property
    def last_second(self) -> float:
        """Worst lateness of the last second."""
        return max(self._recent.copy())


class ShownTicks:
    """Which tick was the newest picture, and since when."""

    def __init__(self, tick: int, now: float) -> None:
        self._shown: deque[tuple[int, float]] = deque([(tick, now)], maxlen=SHOWN_KEPT)

    def note(self, tick: int, now: float) -> None:
        """A snapshot of ``tick`` is out; an earlier tick than the last begins the list anew."""
        last = self._shown[-1][0]
        if tick < last:
            self._shown = deque([(tick, now)], maxlen=SHOWN_KEPT)
        elif tick > last:
            self._shown.append((tick, now))

    def age_of(self, tick: int, now: float) -> float | None:
        """For how many seconds ``tick`` has no longer been the newest picture; None for a tick that
        has not been shown.
        """
        shown = self._shown.copy()
        if tick > shown[-1][0]:
            return None
        if tick < shown[0][0]:
            return math.inf
        return next((now - at for later, at in shown if later > tick), 0.0)
