"""Who swings after whom, and when each leg lands: H's order on a line; on an arc the order and the
phases with which the centre of gravity keeps farthest inside every triangle in turn.

On the spot the legs go round one after the other, on a wide arc as H has them. Four legs, numbered
by quadrant: 0 FL, 1 RL, 2 RR, 3 FR.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import permutations
from typing import NamedTuple

from ..geometry.paths import ArcPath
from ..geometry.transforms import direction
from ..robot.model import Machine
from ..stability import polygon_margin, support_polygon
from .strides import Strokes, planning_boxes, strokes_on

IS_FRONT = (True, False, False, True)
IS_LEFT = (True, True, False, False)
FRONT_ACROSS = (3, 3, 0, 0)  # f̄, the front leg on the other side
REAR_ACROSS = (2, 2, 1, 1)  # r̄
MATES = (3, 2, 1, 0)  # the other leg of the fore pair or of the hind pair
SAME_SIDE = (1, 0, 3, 2)
# on a line
SUCCESSOR = (2, 0, 3, 1)
PREDECESSOR = (1, 3, 0, 2)  # u* of H table 2
OTHERS = ((1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2))  # the legs that stay
SHARES = (  # of the four-leg time, in quarters, before each swing
    (1, 1, 1, 1),
    (2, 0, 2, 0),
    (0, 2, 0, 2),
    (4, 0, 0, 0),
    (0, 4, 0, 0),
    (0, 0, 4, 0),
    (0, 0, 0, 4),
)
LOOKS = (0.0, 0.5, 1.0)  # of a swing, at which the margin is looked at
GRAIN = math.radians(5.0)  # arcs this alike share order and phases


class LegOrder(NamedTuple):
    """Who swings after whom, when each leg lands, and the least margin this leaves."""

    successor: tuple[int, ...]
    predecessor: tuple[int, ...]  # u*
    landed: tuple[float, ...]  # [leg], cycles
    margin: (
        float  # m: longitudinal (s0) on a line, of the polygon on an arc; negative: it must shift
    )


def standard_margin(stride: float, duty_factor: float) -> float:
    """s0, the least longitudinal margin of the standard walk; zero at β = 3/4 by design."""
    return (1.0 - 3.0 / (4.0 * duty_factor)) * stride  # H §4.3 (3)


def standard_order(stride: float, duty_factor: float) -> LegOrder:
    """H's order on a line: 1-3-4-2 in H's numbers, a hind leg, then the front leg of its side."""
    margin = standard_margin(stride, duty_factor)
    return LegOrder(SUCCESSOR, PREDECESSOR, touchdown_phases(duty_factor), margin)


def touchdown_phases(duty_factor: float) -> tuple[float, float, float, float]:
    """When each leg of the gait frame lands on a line, in cycles: leg 1 (H) 0, leg 3 β-1/2, leg 4
    1/2, leg 2 β (H fig. 5).
    """
    return 0.0, duty_factor, duty_factor - 0.5, 0.5


def order_on(machine: Machine, duty_factor: float, path: ArcPath) -> LegOrder:
    """The order on an arc; arcs that differ by less than ``GRAIN`` share it."""
    ahead = math.hypot(path.ux, path.uy)
    course = round(math.atan2(path.uy, path.ux) / GRAIN) if ahead > 1e-9 else 0
    turning = round(math.atan2(machine.yaw_length * path.turn, ahead) / GRAIN)
    return best_order(machine, duty_factor, course, turning)


@lru_cache(maxsize=2048)
def best_order(machine: Machine, duty_factor: float, course: int, turning: int) -> LegOrder:
    """The order and phases with the largest least polygon margin, of all six orders and every
    spread of the four-leg time; ``course`` and ``turning`` (positive to the left) count ``GRAIN``.
    """
    ahead, aside = direction(turning * GRAIN)
    ux, uy = direction(course * GRAIN)
    path = ArcPath(ahead * ux, ahead * uy, aside / machine.yaw_length)
    strokes = strokes_on(planning_boxes(machine, 0, stretched=False), path)
    best: tuple[int, ...] = ()
    best_landed: tuple[float, ...] = ()
    largest = -math.inf
    for rest in permutations((1, 2, 3)):
        legs = (0, *rest)
        for shares in SHARES:
            landed = _landed(legs, shares, duty_factor)
            margin = _least_margin(path, strokes, duty_factor, landed, largest)
            if margin > largest + 1e-9:
                best, best_landed, largest = legs, landed, margin
    return _order_of(best, best_landed, largest)


def _order_of(legs: tuple[int, ...], landed: tuple[float, ...], margin: float) -> LegOrder:
    successor = [0] * 4
    predecessor = [0] * 4
    for leg, following in zip(legs, legs[1:] + legs[:1], strict=True):
        successor[leg] = following
        predecessor[following] = leg
    return LegOrder(tuple(successor), tuple(predecessor), landed, margin)


def _landed(
    legs: tuple[int, ...], shares: tuple[int, ...], duty_factor: float
) -> tuple[float, ...]:
    """When each leg lands if they swing in this order with so much four-leg time before each."""
    spare = (4.0 * duty_factor - 3.0) / 4.0
    landed = [0.0] * 4
    t = 0.0
    for leg, part in zip(legs, shares, strict=True):
        landed[leg] = t
        t += 1.0 - duty_factor + part * spare
    return tuple(landed)


def _least_margin(
    path: ArcPath, strokes: Strokes, duty_factor: float, landed: tuple[float, ...], enough: float
) -> float:
    """Least polygon margin over a cycle; gives up once it is no better than ``enough``."""
    centres, ends, _, stride, _ = strokes
    least = math.inf
    for leg in range(4):
        for look in LOOKS:
            now = landed[leg] - (1.0 - duty_factor) * (1.0 - look)
            feet = []
            for i in OTHERS[leg]:
                left = stride * (1.0 - ((now - landed[i]) % 1.0) / duty_factor)
                feet.append(path.seen(*centres[i], ends[i] - left))
            least = min(least, polygon_margin(support_polygon(feet), 0.0, 0.0))
            if least <= enough:
                return least
    return least
