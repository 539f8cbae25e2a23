"""Encounters and steps that lead nowhere: how many there were at one place, and when that is
enough.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..config import Contact
from ..robot.model import Machine
from ..types import Blocked, Command, Reason

PLACE = 0.02  # m; encounters whose bodies are this near each other are at one place
PLACES_KEPT = 16  # the latest
GOT_ON = 0.05  # m, or this times the yaw length turned; steps of a body that got on are no setbacks
SAME_COURSE = math.radians(10.0)  # a command that turns by less still asks for the same


class Setbacks:
    """Counts encounters and steps by the place of the body; another course begins the count anew.

    ``why`` says that there were too many: nothing is begun any more on this course.
    """

    def __init__(self, settings: Contact, machine: Machine) -> None:
        self.why: Blocked | None = None
        self._encounters_max = settings.setbacks_max
        self._steps_max = settings.steps_max * len(machine.legs)
        self._yaw_length = machine.yaw_length
        self._place = machine.size * PLACE
        self._got_on = machine.size * GOT_ON
        self._command = Command()
        self._places: list[tuple[float, float, int]] = []
        self._began = (math.inf, math.inf, 0.0)  # x, y, yaw where the steps are counted from
        self._steps = 0

    def note(self, body: Sequence[float], command: Command) -> None:
        """An encounter begins; ``body`` is x, y, ... in m."""
        self.heed(command)
        x, y = body[0], body[1]
        known = self._known(x, y)
        if known is not None:
            self._places.remove(known)
            x, y = known[:2]
        count = 1 if known is None else known[2] + 1
        self._places = [*self._places, (x, y, count)][-PLACES_KEPT:]
        if count >= self._encounters_max:
            self.why = Blocked(Reason.NO_PROGRESS, facts={"times": count, "bar": ""})

    def _known(self, x: float, y: float) -> tuple[float, float, int] | None:
        """The place with encounters that is near a body, m."""
        near = (at for at in self._places if math.hypot(at[0] - x, at[1] - y) <= self._place)
        return next(near, None)

    def note_step(self, body: Sequence[float], command: Command, legs: int = 1) -> None:
        """A step of so many ``legs`` begins; ``body`` is x, y, z, yaw in m and rad. Each of its
        feet may meet something: a step with which there would be too many is not begun.
        """
        self.heed(command)
        known = self._known(body[0], body[1])
        if known is not None and known[2] + legs > self._encounters_max:
            self.why = Blocked(Reason.NO_PROGRESS, facts={"times": known[2], "bar": ""})
        x, y, yaw = self._began
        turned = self._yaw_length * (body[3] - yaw)
        if math.hypot(body[0] - x, body[1] - y, turned) > self._got_on:
            self._began = body[0], body[1], body[3]
            self._steps = 0
        self._steps += 1
        if self._steps >= self._steps_max:
            self.why = Blocked(Reason.MARKING_TIME, facts={"steps": self._steps, "bar": ""})

    def let_go(self) -> None:
        """The hand lets go: a step that it cuts short leads nowhere for no other reason, and steps
        are counted anew.
        """
        self._steps = 0

    def heed(self, command: Command) -> None:
        """Another course is another attempt."""
        if command.holds or _same_course(command, self._command):
            return
        self._command = command
        self._places = []
        self._steps = 0
        self.why = None


def _same_course(one: Command, other: Command) -> bool:
    turned = math.remainder(one.crab_angle - other.crab_angle, 2.0 * math.pi)
    moves = (one.speed > 0.0) == (other.speed > 0.0)
    turns = math.copysign(1.0, one.turn_rate) == math.copysign(1.0, other.turn_rate)
    return moves and abs(turned) <= SAME_COURSE and (turns or one.turn_rate == other.turn_rate)
