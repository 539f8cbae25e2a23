"""What feet feel: their loads, whether their soles are on, whiskers and rims."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import GRAVITY

from ..kinematic.contact import ContactWorld
from ..kinematic.swing_feet import EIGHTH, overhang
from ..terrain.ground import Ground

SOLE_ON = 0.01  # of the weight; a foot that carries more is on the ground
SOLE_OFF = 0.004  # of the weight; one that carries less is off it
UNSEEN = -1  # a rim that is still to be looked at


class FootContacts:
    """What the feet feel: their loads, whether their soles are on, whiskers and rims."""

    def __init__(self, machine: Machine, ground: Ground) -> None:
        legs = len(machine.legs)
        self.machine = machine
        self.replace_ground(ground)
        self.loads = [0.0] * legs
        self.soles = [False] * legs
        self.whiskers = [0] * legs
        self.rims = [0] * legs

    def replace_ground(self, ground: Ground) -> None:
        """Feel other ground from now on."""
        self.ground = ground
        self.world = ContactWorld(ground.obstacles, self.machine)

    def take_loads(self, loads: Sequence[float]) -> None:
        """A sole is on from one load up and off from a lesser one down: it does not flutter."""
        weight = self.machine.mass * GRAVITY
        for leg, load in enumerate(loads):
            was_on = self.soles[leg]
            on = load > (SOLE_OFF if was_on else SOLE_ON) * weight
            self.loads[leg] = load
            self.soles[leg] = on
            if not on:
                self.rims[leg] = 0
            elif not was_on:
                self.rims[leg] = UNSEEN

    def feel(
        self,
        feet: Sequence[Sequence[float]],
        body: Sequence[float],
        sides: Sequence[tuple[int, float, float]],
    ) -> None:
        """Whiskers near obstacles and against risers, rims of feet that have just come down."""
        for leg, (x, y, z) in enumerate(feet):
            near = not self.soles[leg] and self.world.near(x, y)
            self.whiskers[leg] = self.world.feel(x, y, z, body[5]) if near else 0
            if self.rims[leg] == UNSEEN:
                sole = x, y, self.ground.height_at(x, y)
                self.rims[leg] = overhang(self.ground, self.machine.foot_radius, body[5], sole)
        for leg, dx, dy in sides:
            if not self.soles[leg]:
                self.whiskers[leg] |= 1 << _eighth(math.atan2(dy, dx) - body[5])

    def state(self) -> dict[str, Any]:
        """What ``restore`` goes on from."""
        return {
            "loads": list(self.loads),
            "soles": list(self.soles),
            "whiskers": list(self.whiskers),
            "rims": list(self.rims),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from a ``state``."""
        self.loads[:] = state["loads"]
        self.soles[:] = state["soles"]
        self.whiskers[:] = state["whiskers"]
        self.rims[:] = state["rims"]


def _eighth(bearing: float) -> int:
    return round(bearing / EIGHTH) % 8
