"""What the physics plant may be told to be: servos, contact, sensors, and what the planner has
wrong about it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class ServoSettings:
    """Position servos with velocity fed forward, alike in all legs, stated at the foot.

    A joint's stiffness is that of its share of the foot's, so that every kind of leg gives way by
    ``sag`` under its share of the weight in the standard posture.
    """

    # m a leg gives under a quarter (an n-th) of the weight. More: see the body lean into each
    # lifted leg; less than 0.2 mm: see the feet hammer
    sag: float = 0.005
    damping: float = 0.7  # of critical, of a leg's share of the body on its stiffness
    # times the leg's mass, what the drives' own inertia seems to weigh at the foot
    reflected: float = 1.0
    limited: bool = True  # the card's torques are the most they give
    # m a foot's target may run ahead of the foot. Less: see legs give up under load; more: see them
    # wind up against an obstacle and jump when it goes
    lead: float = 0.05

    def __post_init__(self) -> None:
        _check("sag", self.sag, 1e-5, 0.1)
        _check("damping", self.damping, 0.0, 10.0)
        _check("reflected", self.reflected, 0.0, 100.0)
        _check("lead", self.lead, 1e-3, 1.0)


@dataclass(frozen=True, slots=True)
class Physics:
    """The whole of it. ``mass_factor`` and ``centre_off`` make the true machine another than the
    card, which is what planners know.
    """

    servos: ServoSettings = field(default_factory=ServoSettings)
    friction: float | None = None  # None: the card's
    contact_time: float = 0.005  # s, time constant of a contact; at least two steps
    # m, radius of a foot's ball. Larger: see feet roll over edges that a point falls off
    tip: float = 0.004
    step: float = 0.002  # s; a tick is a whole number of them
    mass_factor: float = 1.0
    centre_off: tuple[float, float, float] = (0.0, 0.0, 0.0)  # m, of the torso
    # where the body senses itself to be: by its legs, which drift, or truly
    true_place: bool = False

    def __post_init__(self) -> None:
        _check("step", self.step, 1e-4, 0.004)
        _check("contact_time", self.contact_time, 2.0 * self.step, 0.1)
        _check("tip", self.tip, 1e-3, 0.2)
        _check("mass_factor", self.mass_factor, 0.1, 10.0)
        if self.friction is not None:
            _check("friction", self.friction, 0.0, 10.0)
        if not all(math.isfinite(part) and abs(part) <= 1.0 for part in self.centre_off):
            raise ValueError(f"centre_off must be within 1 m, got {self.centre_off!r:.80}")


def _check(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise ValueError(f"{name} must be from {low:g} to {high:g}, got {value!r:.80}")
