"""Encounters that lead nowhere: how many there were at one place, and when that is enough."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..types import Command

PLACE = 0.02  # m; encounters whose bodies are this near each other are at one place
PLACES_KEPT = 16  # the latest
SAME_COURSE = math.radians(10.0)  # a command that turns by less still asks for the same


class Setbacks:
    """Counts encounters by the place of the body; another course begins the count anew."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._places: list[tuple[float, float, int]] = []
        self._command = Command()
        self.spent = 0  # encounters at the place where there were too many; 0: there is none

    def note(self, body: Sequence[float], command: Command) -> None:
        """An encounter begins; ``body`` is x, y, ... in m."""
        self.heed(command)
        x, y = body[0], body[1]
        count = 1
        for place in self._places:
            if math.hypot(place[0] - x, place[1] - y) <= PLACE:
                count = place[2] + 1
                x, y = place[0], place[1]
                self._places.remove(place)
                break
        self._places = [*self._places, (x, y, count)][-PLACES_KEPT:]
        if count >= self._most:
            self.spent = count

    def heed(self, command: Command) -> None:
        """Another course is another attempt."""
        if command.holds or _same_course(command, self._command):
            return
        self._command = command
        self._places = []
        self.spent = 0


def _same_course(one: Command, other: Command) -> bool:
    turned = math.remainder(one.crab_angle - other.crab_angle, 2.0 * math.pi)
    moves = (one.speed > 0.0) == (other.speed > 0.0)
    turns = math.copysign(1.0, one.turn_rate) == math.copysign(1.0, other.turn_rate)
    return moves and abs(turned) <= SAME_COURSE and (turns or one.turn_rate == other.turn_rate)
