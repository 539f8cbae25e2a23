"""What is believed of sensors that scatter or are late: every reading weighed against what was to
be expected.

Feet are expected where the velocities they were told take them, the attitude where it was or, with
a sensor of rates, where those take it. Of what a reading says beside that, a share is believed. One
that is late is weighed against what was expected of the tick it is from; the body, whose place does
not scatter, has gone on since as its plan has it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from ..geometry.transforms import XY, Body
from ..types import TICK, Point, Sensing

STANDS: Body = (0.0, 0.0, 0.0, 0.0)  # m and rad


class SensorFilter:
    """Believes ``share`` of every reading of the feet and of roll and pitch; readings are ``late``
    ticks old.
    """

    def __init__(self, share: float, late: int = 0) -> None:
        self._share = share
        self._feet: list[Point] | None = None
        self._tilt = (0.0, 0.0)
        # what was believed of the ticks readings are still to come of, the oldest first
        self._feet_before: deque[list[Point]] = deque(maxlen=late)
        self._tilt_before: deque[XY] = deque(maxlen=late)
        self._gone: deque[Body] = deque(maxlen=late)  # by the body in those ticks

    def believed(self, sensing: Sensing) -> Sensing:
        """A reading with what is believed of it in its place; the first is believed whole."""
        x, y, z, roll, pitch, yaw = sensing.body
        if self._feet is None:
            self._feet = list(sensing.feet_b)
            self._tilt = (roll, pitch)
            return sensing
        self._believe_feet(sensing.feet_b)
        roll, pitch = self._believe_tilt(sensing)
        for dx, dy, dz, turn in self._gone:
            x += dx
            y += dy
            z += dz
            yaw += turn
        return sensing._replace(body=(x, y, z, roll, pitch, yaw), feet_b=tuple(self._feet))

    def _believe_feet(self, read: Sequence[Point]) -> None:
        feet = self._feet or []
        then = self._feet_before[0] if self._feet_before else feet
        share = self._share
        off = [_scaled_between(a, b, share) for a, b in zip(then, read, strict=True)]
        self._feet = _moved(feet, off)
        for k, before in enumerate(self._feet_before):
            self._feet_before[k] = _moved(before, off)

    def _believe_tilt(self, sensing: Sensing) -> XY:
        old_roll, old_pitch = self._tilt
        old_roll += sensing.rates[0] * TICK
        old_pitch += sensing.rates[1] * TICK
        then_roll, then_pitch = self._tilt_before[0] if self._tilt_before else (old_roll, old_pitch)
        _, _, _, roll, pitch, _ = sensing.body
        off = self._share * (roll - then_roll), self._share * (pitch - then_pitch)
        self._tilt = old_roll + off[0], old_pitch + off[1]
        for k, (one, other) in enumerate(self._tilt_before):
            self._tilt_before[k] = one + off[0], other + off[1]
        return self._tilt

    def expect(self, velocities: Sequence[Point], moved: Body = STANDS) -> None:
        """What the feet are told to do in the tick that begins, m/s in body axes, and how far its
        plan has the body go in it.
        """
        if self._feet is None:
            return
        self._feet_before.append(self._feet)
        self._tilt_before.append(self._tilt)
        self._gone.append(moved)
        self._feet = _moved(self._feet, [(TICK * a, TICK * b, TICK * c) for a, b, c in velocities])


def _moved(feet: Sequence[Point], by: Sequence[Point]) -> list[Point]:
    return [(x + a, y + b, z + c) for (x, y, z), (a, b, c) in zip(feet, by, strict=True)]


def _scaled_between(a: Point, b: Point, share: float) -> Point:
    return share * (b[0] - a[0]), share * (b[1] - a[1]), share * (b[2] - a[2])
