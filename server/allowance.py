"""How often somebody may do something: a burst, refilled as time goes by."""

from __future__ import annotations


class Allowance:
    """So many at once, and so many a second after them; what is refused costs nothing."""

    def __init__(self, burst: float, per_second: float, now: float) -> None:
        self._burst = burst
        self._per_second = per_second
        self._left = burst
        self._counted = now  # s

    def take(self, now: float) -> bool:
        """One more at ``now``, s; False when it is one too many."""
        earned = (now - self._counted) * self._per_second
        self._left = min(self._burst, self._left + earned)
        self._counted = now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True
