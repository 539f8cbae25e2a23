"""Ground that gives way: patches that go down once a foot presses on them hard enough.

A patch goes down whole and at once, after the tick in which a foot has pressed on it with more than
it bears: a crust that breaks, a loose slab. The machine is not told; it feels that a foot has lost
its load.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from walking_console.planner.protocols import Plant
from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import GRAVITY
from walking_console.planner.terrain.grid import Window

from .terrain.generators import LoosePatch
from .terrain.ground import Ground


class GivingGround:
    """The patches of one ground that still hold."""

    def __init__(self, patches: Sequence[LoosePatch], machine: Machine) -> None:
        self.holding = tuple(patches)
        self._weight = machine.mass * GRAVITY

    def after(self, plant: Plant[Ground], ground: Ground) -> Ground:
        """The ground as the feet leave it; the same one while everything holds."""
        loads = self._loads(plant)
        feet = list(zip(plant.feet, loads, strict=True))
        broken = [patch for patch in self.holding if _is_overloaded(patch, feet)]
        if not broken:
            return ground
        self.holding = tuple(patch for patch in self.holding if patch not in broken)
        for patch in broken:
            ground = ground.lowered(_cells_of(patch, ground), patch.sinks)
        return ground

    def _loads(self, plant: Plant[Ground]) -> Sequence[float]:
        """What every foot presses with, N: an even share where the plant does not say."""
        if plant.loads:
            return plant.loads
        soles = plant.soles
        share = self._weight / max(1, sum(soles))
        return [share if on else 0.0 for on in soles]


def _is_overloaded(patch: LoosePatch, feet: Sequence[tuple[Sequence[float], float]]) -> bool:
    return any(
        load > patch.bears
        and patch.x[0] <= foot[0] <= patch.x[1]
        and patch.y[0] <= foot[1] <= patch.y[1]
        for foot, load in feet
    )


def _cells_of(patch: LoosePatch, ground: Ground) -> Window:
    """The cells of the whole map whose centres lie in a patch."""
    (x, y), (rows, columns) = ground.whole_origin, ground.whole_shape
    sides = []
    for (low, high), corner, count in ((patch.y, y, rows), (patch.x, x, columns)):
        centres = corner + (np.arange(count) + 0.5) * ground.cell
        first = np.searchsorted(centres, low, side="left")
        sides.append(slice(int(first), int(np.searchsorted(centres, high, side="right"))))
    return sides[0], sides[1]
