"""The fold of H table 1: the frame turned by n quarter turns in which a course is within ±α_c' of
straight ahead. The walk along x turns over into the walk along y there, its legs relabelled.
"""

from __future__ import annotations

import math

from ..geometry.transforms import XY
from ..robot.model import Machine

QUARTER = math.pi / 2
BODY_LEGS = ((0, 1, 2, 3), (1, 2, 3, 0), (2, 3, 0, 1), (3, 0, 1, 2))  # by n, gait leg -> body leg
# rad (0.5°) beyond α_c before the gait turns over; smaller: see the legs regroup as the stick
# trembles near 45°
HYSTERESIS = 0.009


def quarter_turned(x: float, y: float, n: int) -> XY:
    """A vector (or a cosine and a sine) turned by n quarter turns, without rounding."""
    for _ in range(n % 4):
        x, y = -y, x
    return x, y


def quarter_turns(machine: Machine, crab_angle: float, previous: int = -1) -> int:
    """n of H table 1, 0 to 3. Within the hysteresis of the boundary ``previous`` stays."""
    if previous >= 0:
        beyond = abs(folded(crab_angle, previous)) - half_width(machine, previous)
        if beyond <= HYSTERESIS:
            return previous
    for n in range(4):
        rest = folded(crab_angle, n)
        half = half_width(machine, n)
        if -half + 1e-12 < rest <= half + 1e-12:
            return n
    return 0  # not reached: the four ranges cover the circle


def folded(crab_angle: float, n: int) -> float:
    """The crab angle in the frame turned by n quarter turns, within ±π."""
    rest = crab_angle - n * QUARTER
    if -math.pi < rest <= math.pi:
        return rest
    return math.remainder(rest, 2 * math.pi)


def half_width(machine: Machine, n: int) -> float:
    """The greatest crab angle in the frame turned by n quarter turns, α_c'."""
    critical = machine.critical_angle
    return QUARTER - critical if n % 2 else critical


def beside_critical(machine: Machine, crab_angle: float) -> float:
    """How far a crab angle is from the nearest boundary between two quarter turns, rad."""
    critical = machine.critical_angle
    aside = abs(folded(crab_angle, 0))
    return min(abs(aside - critical), abs(math.pi - critical - aside))
