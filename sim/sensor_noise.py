"""What sensors add to the truth: noise drawn anew every tick, from a seeded generator."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from walking_console.planner.types import Sensing

# m and rad; readings that scatter less may be acted on in full
FINE = 0.001
FINE_ANGLE = 0.002


@dataclass(frozen=True, slots=True)
class SensorNoise:
    """Standard deviations of what the sensors of any plant add."""

    position: float = 0.0  # m, position monitors, per axis
    posture: float = 0.0  # rad, roll and pitch
    rate: float = 0.0  # rad/s, turning, per axis
    load: float = 0.0  # N, per foot
    delay: int = 0  # ticks a reading is late; kept by who asks for readings

    @property
    def blurs(self) -> bool:
        """True when no reading can be acted on at once and in full."""
        return self.position > FINE or self.posture > FINE_ANGLE or self.delay > 0


def with_noise(sensing: Sensing, noise: SensorNoise, rng: np.random.Generator) -> Sensing:
    """What noisy sensors make of an exact reading; three numbers a leg and two for the body are
    drawn from ``rng``, and more only for loads and rates that are noisy.
    """
    drawn = rng.standard_normal(3 * len(sensing.feet_b) + 2).tolist()
    p, a = noise.position, noise.posture
    off = zip(sensing.feet_b, drawn[0::3], drawn[1::3], drawn[2::3], strict=False)
    feet = tuple((x + p * ax, y + p * ay, z + p * az) for (x, y, z), ax, ay, az in off)
    x, y, z, roll, pitch, yaw = sensing.body
    body = x, y, z, roll + a * drawn[-2], pitch + a * drawn[-1], yaw
    sensing = sensing._replace(body=body, feet_b=feet)
    if noise.rate == 0.0 == noise.load:
        return sensing
    more = rng.standard_normal(3 + len(sensing.loads)).tolist()
    rx, ry, rz = (rate + noise.rate * off for rate, off in zip(sensing.rates, more, strict=False))
    loads = (load + noise.load * off for load, off in zip(sensing.loads, more[3:], strict=True))
    return sensing._replace(rates=(rx, ry, rz), loads=tuple(max(0.0, load) for load in loads))
