"""What a finished walk is held against: the standard layout it should have come to, and the height
rule it should do better than.

Nothing here decides anything; results and drawings use it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..robot.model import Machine
from ..types import Array, Gait, Stance
from .gait import AGREEMENT, SUCCESSOR, posture_of, standard_for

SPACING = 0.1  # m of course between the heights of which second differences are taken


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


def average_height(feet: Sequence[Sequence[float]], height: float) -> float:
    """The height rule H fig. 15 draws as a broken line: H above the mean of the feet that stand, m."""
    return sum(foot[2] for foot in feet) / len(feet) + height


def roughness(course: Array, heights: Array) -> float:
    """RMS second difference of heights along a course, sampled every 0.1 m and linked linearly
    between the points given, m.
    """
    samples = np.interp(np.arange(course[0], course[-1], SPACING), course, heights)
    if samples.size < 3:
        return 0.0
    return float(np.sqrt(np.mean(np.diff(samples, 2) ** 2)))
