"""Tokens and what they are good for: the driver's for everything, the viewer's to watch and stop.

Whoever shows wrong ones too often is not looked at for a while, by the address. An address from
which a right one has come is never locked out, and a stop is always looked at.
"""

from __future__ import annotations

import hmac
import time
from collections import OrderedDict, deque
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import TypeVar

from .limits import ADDRESSES_KEPT, GUESSES_MAX, GUESSES_WITHIN

V = TypeVar("V")

WATCHES = "walking_console.watches"  # in the scope of who may watch and stop only


class Role(Enum):
    """What a token is good for."""

    DRIVER = "driver"
    VIEWER = "viewer"


@dataclass(frozen=True)
class Tokens:
    """The secrets of this console; without a driver's everybody drives."""

    driver: str | None = None
    viewer: str | None = None

    def role_of(self, shown: str) -> Role | None:
        """What this token is good for; None: for nothing."""
        found = None
        for role, token in ((Role.VIEWER, self.viewer), (Role.DRIVER, self.driver)):
            same = hmac.compare_digest(shown.encode("utf-8", "replace"), (token or "").encode())
            if token is not None and same:
                found = role
        return found


class Guesses:
    """Wrong tokens of the last minute, by the address they came from; so many addresses are
    remembered, the newest.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._wrong: OrderedDict[str, deque[float]] = OrderedDict()
        self._known: OrderedDict[str, None] = OrderedDict()

    def note(self, address: str, role: Role | None) -> None:
        """A token that came from this address, and what it was good for."""
        if role is not None:
            self._wrong.pop(address, None)
            _keep(self._known, address, None)
        elif address not in self._known:
            times = self._wrong.pop(address, deque[float](maxlen=GUESSES_MAX))
            times.append(self._now())
            _keep(self._wrong, address, times)

    def wait(self, address: str) -> float:
        """Seconds until tokens from this address are looked at again; 0: now."""
        times = self._wrong.get(address)
        if times is None or len(times) < GUESSES_MAX or address in self._known:
            return 0.0
        return max(0.0, times[0] + GUESSES_WITHIN - self._now())


def _keep(kept: OrderedDict[str, V], address: str, value: V) -> None:
    kept[address] = value
    kept.move_to_end(address)
    while len(kept) > ADDRESSES_KEPT:
        kept.popitem(last=False)
