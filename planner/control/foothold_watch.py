"""Case 3 of H §9: a foothold that gives way, told from load and slip.

A leg that is to carry has lost its load, or slips alone, and its foot is not where it stood any
more: it has gone down after the ground (C2 of (36)), or aside. When several feet slip the machine
is pushed, and its footholds are not to blame.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..geometry.transforms import left_fold_sum
from ..stability import polygon_margin, support_polygon
from ..types import Point, Sensing
from .execution import Execution, feet_absolute

SIGMAS = 6.0  # of what the sensors scatter by, that is no way yet


class FootholdWatch:
    """Whether the footholds of the legs that carry still hold. To be asked every tick of a walk."""

    def __init__(self, run: Execution) -> None:
        self._run = run
        settings = run.config.contact
        tolerances = run.tolerances
        blur = tolerances.position_noise + tolerances.posture_noise * run.machine.yaw_length
        self._way = max(settings.gives_way, SIGMAS * blur)
        self._spare = settings.spare
        self._soles: tuple[bool, ...] = (True,) * len(run.machine.legs)
        # where all feet were when a leg lost its load
        self._lost: dict[int, Sequence[Point]] = {}

    def gone(self, sensing: Sensing) -> int | None:
        """A leg whose foothold gives way, None while all hold."""
        soles = sensing.soles
        slips = True in sensing.slipping
        if soles == self._soles and not (slips or self._lost):
            return None
        run = self._run
        stretch = run.tracker.stretches[run.tracker.stretch(run.t)]
        landed = (leg for leg in stretch.air if run.landed(leg))
        stand = [leg for leg in (*stretch.stand, *landed) if leg not in run.stance.lifted]
        if soles != self._soles:
            self._note(sensing, stand)
        if not slips and not self._lost:
            return None
        feet = feet_absolute(sensing)
        holding = [leg for leg in stand if soles[leg]]
        sliding = [leg for leg in stand if sensing.slipping[leg]]
        if len(sliding) == 1 and self._aside(sliding[0], feet[sliding[0]]) > self._way:
            return sliding[0]
        lost = (leg for leg in self._lost if leg in stand)
        return next((leg for leg in lost if self._sunk(leg, holding, feet) > self._way), None)

    def _note(self, sensing: Sensing, stand: Sequence[int]) -> None:
        """Some sole has come on or off."""
        feet = feet_absolute(sensing)
        for leg, on in enumerate(sensing.soles):
            if on or leg not in stand:
                self._lost.pop(leg, None)
            elif self._soles[leg]:
                self._lost[leg] = feet
        self._soles = sensing.soles

    def _aside(self, leg: int, foot: Point) -> float:
        """How far beside where it stood a foot is, m."""
        x, y, _ = self._run.tracker.foot_at(leg, self._run.t)
        return math.hypot(foot[0] - x, foot[1] - y)

    def _sunk(self, leg: int, holding: Sequence[int], feet: Sequence[Point]) -> float:
        """How much lower than when it lost its load a foot is, m, by the mean of those that hold: a
        body that errs about its height errs about them all.
        """
        before = self._lost[leg]
        others = left_fold_sum(before[each][2] - feet[each][2] for each in holding)
        return before[leg][2] - feet[leg][2] - others / max(1, len(holding))

    def may_rise(self, leg: int, sensing: Sensing) -> bool:
        """True when the other soles carry the body without this one, ``contact.spare`` m inside."""
        feet = feet_absolute(sensing)
        others = (foot for other, foot in enumerate(feet) if other != leg and sensing.soles[other])
        margin = polygon_margin(support_polygon(others), sensing.body[0], sensing.body[1])
        return margin >= self._spare
