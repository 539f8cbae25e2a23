"""How far a step came out from the standard layout. Nothing here decides anything."""

from __future__ import annotations

import math

from ..robot.model import Machine
from ..types import Gait, Stance
from .gait import AGREEMENT, SUCCESSOR, posture_of, standard_for


def off_standard(machine: Machine, gait: Gait, crab_angle: float, stance: Stance) -> float:
    """How far the foot that is farthest off stands from its place in the standard layout at this
    N_k, as a share of λ*.
    """
    standard = standard_for(machine, gait, crab_angle, stance.quarter_turns)
    posture = posture_of(standard, stance)
    if posture.last < 0:
        return math.inf
    places = zip(
        posture.feet, standard.centres, standard.offsets[SUCCESSOR[posture.last]], strict=True
    )
    off = max(
        math.hypot(fx - cx - d * standard.ux, fy - cy - d * standard.uy)
        for (fx, fy), (cx, cy), d in places
    )
    return off / standard.stride


def is_standard(off: float) -> bool:
    """True when a layout so far off still counts as the standard one (the tolerance of H fig. 9)."""
    return off <= AGREEMENT
