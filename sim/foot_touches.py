"""What standing feet tell the map, and when."""

from __future__ import annotations

from walking_console.planner.control.execution import feet_absolute
from walking_console.planner.control.supervisor import GaitSupervisor
from walking_console.planner.terrain.mapping import ElevationMapper
from walking_console.planner.types import Sensing


class FootTouches:
    """When the map is told where feet stand: as a step begins, and once where a walker that stands
    has no step to go on with. After an encounter feet may stand where the map has other ground, by
    which no step is possible.
    """

    def __init__(self) -> None:
        self._step = -1
        self._stuck_after = -1

    def count_now(self, supervisor: GaitSupervisor, sensing: Sensing) -> bool:
        """Once a tick: True in one in which the map is to be told."""
        steps = supervisor.steps_begun
        if steps != self._step:
            self._step = steps
            return True
        stuck = supervisor.stands and supervisor.blocked is not None
        if not stuck or steps == self._stuck_after:
            return False
        lifted = supervisor.stance.lifted
        if not all(on or leg in lifted for leg, on in enumerate(sensing.soles)):
            return False
        self._stuck_after = steps
        return True


def touch(mapper: ElevationMapper, sensing: Sensing) -> None:
    """Feet whose soles are on say how high the ground is, in m of the absolute frame."""
    feet = zip(feet_absolute(sensing), sensing.soles, strict=True)
    standing = [foot for foot, sole in feet if sole]
    mapper.touch(standing)
    if standing:
        mapper.set_prior(standing)
