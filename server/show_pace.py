"""How often a page is shown the walk: seldomer over a link that cannot carry all of it."""

from __future__ import annotations

SHOW_RATE = 30.0  # Hz, snapshots to one page at most
SLOWEST = 6.0  # Hz; less: the picture itself makes a hand late
LATE = 0.12  # s that a picture takes from which on fewer are sent; longer: old pictures drive
FRESH = 0.05  # s that it takes up to which more are
LOOKS_EVERY = 0.2  # s between two changes; shorter: it changes before the last change is seen
LESS, MORE = 0.6, 1.15  # times the rate; a link that was too narrow is tried with care


class ShowPace:
    """The rate of snapshots to one page, by how late the last ones came there."""

    def __init__(self, now: float) -> None:
        self.rate = SHOW_RATE
        self._changed = now

    @property
    def is_thinned(self) -> bool:
        """Whether the page gets fewer than it would like."""
        return self.rate < SHOW_RATE

    def note(self, age: float | None, now: float) -> None:
        """What the page shows was ``age`` s old when it said so; None: it is not known."""
        if age is None or now - self._changed < LOOKS_EVERY:
            return
        taken = age - 1.0 / self.rate  # the next one was not due before
        if taken > LATE:
            self.rate = max(SLOWEST, LESS * self.rate)
        elif taken < FRESH:
            self.rate = min(SHOW_RATE, MORE * self.rate)
        else:
            return
        self._changed = now
