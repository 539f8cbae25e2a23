"""What is believed of sensors that scatter: every reading weighed against what was to be expected.

Feet are expected where the velocities they were told take them, the attitude where it was or, with
a sensor of rates, where those take it. Of what a reading says beside that, a share is believed.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..types import TICK, Point, Sensing


class SensorFilter:
    """Believes ``share`` of every reading of the feet and of roll and pitch."""

    def __init__(self, share: float) -> None:
        self._share = share
        self._feet: list[Point] | None = None
        self._tilt = (0.0, 0.0)

    def believed(self, sensing: Sensing) -> Sensing:
        """A reading with what is believed of it in its place; the first is believed whole."""
        x, y, z, roll, pitch, yaw = sensing.body
        if self._feet is None:
            self._feet = list(sensing.feet_b)
            self._tilt = (roll, pitch)
            return sensing
        share = self._share
        self._feet = [
            _between(a, b, share) for a, b in zip(self._feet, sensing.feet_b, strict=True)
        ]
        old_roll, old_pitch = self._tilt
        old_roll += sensing.rates[0] * TICK
        old_pitch += sensing.rates[1] * TICK
        roll = old_roll + share * (roll - old_roll)
        pitch = old_pitch + share * (pitch - old_pitch)
        self._tilt = (roll, pitch)
        return sensing._replace(body=(x, y, z, roll, pitch, yaw), feet_b=tuple(self._feet))

    def expect(self, velocities: Sequence[Point]) -> None:
        """What the feet are told to do in the tick that begins, m/s in body axes."""
        if self._feet is not None:
            self._feet = [
                (x + vx * TICK, y + vy * TICK, z + vz * TICK)
                for (x, y, z), (vx, vy, vz) in zip(self._feet, velocities, strict=True)
            ]


def _between(a: Point, b: Point, share: float) -> Point:
    return (
        a[0] + share * (b[0] - a[0]),
        a[1] + share * (b[1] - a[1]),
        a[2] + share * (b[2] - a[2]),
    )
