"""What a machine whose legs give believes of a reading, and what it remembers of those before."""

from __future__ import annotations

from collections.abc import Sequence

from ..geometry.transforms import XY, Body
from ..robot.model import Machine
from ..types import Point, Sensing
from .centre_watch import CentreWatch
from .sensor_filter import STANDS, SensorFilter

SLIP_TICKS = 50  # a slip is remembered; fewer: see it speed up and slip again


class Senses:
    """``filter`` weighs readings that scatter, ``centre`` learns by ``share`` of a reading where
    the centre of gravity is.
    """

    def __init__(self, machine: Machine, share: float) -> None:
        self.filter: SensorFilter | None = None
        self.centre = CentreWatch(machine, share)
        self._slipped = 0  # ticks that a slip is still remembered
        self._acceleration: XY = (0.0, 0.0)  # the plan has now, m/s², absolute axes

    @property
    def slips(self) -> bool:
        """A foot slips, or has just slipped."""
        return self._slipped > 0

    def believed(self, sensing: Sensing) -> Sensing:
        """One reading with what is believed of it in its place."""
        slips = any(on and slid for on, slid in zip(sensing.soles, sensing.slipping, strict=True))
        self._slipped = SLIP_TICKS if slips else max(0, self._slipped - 1)
        if self.filter is not None:
            sensing = self.filter.believed(sensing)
        self.centre.learn(sensing, self._acceleration)
        return self.centre.corrected(sensing)

    def expect(self, velocities: Sequence[Point], acceleration: XY, moved: Body = STANDS) -> None:
        """What feet are told in the tick that begins, m/s in body axes, how the plan has the body
        speed up, m/s² in absolute axes, and how far it has it go.
        """
        self._acceleration = acceleration
        if self.filter is not None:
            self.filter.expect(velocities, moved)
