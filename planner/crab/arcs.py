"""The standard walk on an arc: strokes on circles about the turning centre, the order of the legs,
the phase of each.

What ``standard`` is on a straight course. Body axes, no canonical frame: on a tight arc no quadrant
is ahead. The order and the phases of the legs are those with which the centre of gravity keeps
farthest inside every triangle in turn: on the spot the legs go round one after the other, on a wide
arc as H has them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import permutations
from typing import NamedTuple

from ..geometry.paths import ArcPath, Box, arc_exit
from ..robot.model import Machine
from ..stability import XY, polygon_margin, support_polygon
from ..types import Gait
from .gait import LEAN, OTHERS

STROKE_MAX = 1.0  # m of s; on a circle about itself a foot would never leave its reach
SHARES = (  # of the four-leg time, in quarters, before each swing
    (1, 1, 1, 1), (2, 0, 2, 0), (0, 2, 0, 2), (4, 0, 0, 0), (0, 4, 0, 0), (0, 0, 4, 0), (0, 0, 0, 4),
)  # fmt: skip
LOOKS = (0.0, 0.5, 1.0)  # of a swing, at which the margin is looked at
GRAIN = math.radians(5.0)  # courses this alike share order and phases


class Order(NamedTuple):
    """Who swings after whom on a course, when each lands, and the least polygon margin this leaves."""

    legs: tuple[int, ...]
    landed: tuple[float, ...]  # [leg], cycles
    margin: float  # m


@dataclass(frozen=True, slots=True, eq=False)
class Circular:
    """The standard walk of one machine on one arc, in body axes. Lengths are metres of s."""

    arc: ArcPath
    boxes: tuple[Box, ...]  # control reach
    far_boxes: tuple[Box, ...]  # mechanical reach
    centres: tuple[XY, ...]  # C_i
    ends: tuple[float, ...]  # from C_i to the end of the stroke
    spares: tuple[float, ...]  # from there to the end of the reach
    stride: float  # λ* of the arc: what every leg can stay on the ground for
    successor: tuple[int, ...]
    predecessor: tuple[int, ...]  # u*
    lags: tuple[float, ...]  # how much later than u* leg u leaves its stroke
    # [u][i]: how far leg i is from the end of its stroke when u has just landed
    layouts: tuple[tuple[float, ...], ...]
    margin: float  # the least polygon margin of the standard walk, m; negative: it must sway
    swing_share: float  # 1-β over β: the body's way during a swing, in strides


def boxes_of(machine: Machine) -> tuple[tuple[Box, ...], tuple[Box, ...]]:
    """Control and mechanical reach; a machine with less than 0.02 m of overreach plans in a smaller
    control reach.
    """
    over_x, over_y, _ = machine.overreach
    kx, ky = max(0.0, LEAN - over_x), max(0.0, LEAN - over_y)
    control = tuple((a + kx, b - kx, c + ky, d - ky) for a, b, c, d in machine.boxes)
    far = tuple((a - over_x, b + over_x, c - over_y, d + over_y) for a, b, c, d in machine.boxes)
    return control, far


@lru_cache(maxsize=256)
def circular_for(machine: Machine, duty_factor: float, arc: ArcPath) -> Circular:
    """The standard walk on the arc ``arc``."""
    boxes, far_boxes = boxes_of(machine)
    centres, ends, stride = _strokes(boxes, arc)
    leaves = [arc_exit(x, y, box, arc) for (x, y), box in zip(centres, boxes, strict=True)]
    spares = tuple(
        leave - end if leave < math.inf else 0.0 for leave, end in zip(leaves, ends, strict=True)
    )
    order = order_for(machine, duty_factor, *_coarse(machine, arc))
    successor, predecessor = [0] * 4, [0] * 4
    for leg, after in zip(order.legs, order.legs[1:] + order.legs[:1], strict=True):
        successor[leg], predecessor[after] = after, leg
    cycle = stride / duty_factor
    lags = tuple(
        ((order.landed[leg] - order.landed[predecessor[leg]]) % 1.0) * cycle for leg in range(4)
    )
    layouts = tuple(
        tuple(stride - (order.landed[u] - landed) % 1.0 * cycle for landed in order.landed)
        for u in range(4)
    )
    return Circular(
        arc, boxes, far_boxes, centres, ends, spares, stride, tuple(successor), tuple(predecessor), lags, layouts, order.margin,
        (1.0 - duty_factor) / duty_factor,
    )  # fmt: skip


def circular_gait(machine: Machine, gait: Gait, arc: ArcPath) -> Circular:
    """The same by gait."""
    return circular_for(machine, gait.duty_factor, arc)


def _strokes(
    boxes: tuple[Box, ...], arc: ArcPath
) -> tuple[tuple[XY, ...], tuple[float, ...], float]:
    """C_i, the way from there to the end of each leg's stroke, and the stride they share: that of
    the leg that has least.
    """
    back = reversed_course(arc)
    centres = tuple(((a + b) / 2, (c + d) / 2) for a, b, c, d in boxes)
    ahead = [arc_exit(x, y, box, arc) for (x, y), box in zip(centres, boxes, strict=True)]
    behind = [arc_exit(x, y, box, back) for (x, y), box in zip(centres, boxes, strict=True)]
    stride = min(STROKE_MAX, *(a + b for a, b in zip(ahead, behind, strict=True)))
    ends = tuple(
        ((a - b if a < math.inf else 0.0) + stride) / 2 for a, b in zip(ahead, behind, strict=True)
    )
    return centres, ends, stride


def reversed_course(arc: ArcPath) -> ArcPath:
    """The way back along the same arc."""
    return ArcPath(-arc.ux, -arc.uy, -arc.turn)


def carried(arc: ArcPath, x: float, y: float, s: float) -> XY:
    """Where a point fixed to the body is after s, in present body axes."""
    dx, dy, angle = arc.pose(s)
    c, d = math.cos(angle), math.sin(angle)
    return dx + c * x - d * y, dy + d * x + c * y


def _coarse(machine: Machine, arc: ArcPath) -> tuple[int, int]:
    """The course as two whole numbers of ``GRAIN``: its direction, and how much of it is turning
    (positive to the left).
    """
    ahead = math.hypot(arc.ux, arc.uy)
    turning = round(math.atan2(machine.yaw_length * arc.turn, ahead) / GRAIN)
    return (round(math.atan2(arc.uy, arc.ux) / GRAIN) if ahead > 1e-9 else 0), turning


@lru_cache(maxsize=2048)
def order_for(machine: Machine, duty_factor: float, direction: int, turning: int) -> Order:
    """The order and phases with the largest least margin, of all six orders and every spread of the
    four-leg time.
    """
    share = math.cos(turning * GRAIN)
    arc = ArcPath(
        share * math.cos(direction * GRAIN),
        share * math.sin(direction * GRAIN),
        math.sin(turning * GRAIN) / machine.yaw_length,
    )
    centres, ends, stride = _strokes(boxes_of(machine)[0], arc)
    best = Order((0, 1, 2, 3), (0.0, 0.25, 0.5, 0.75), -math.inf)
    spare = (4.0 * duty_factor - 3.0) / 4.0
    for rest in permutations((1, 2, 3)):
        legs = (0, *rest)
        for shares in SHARES:
            landed, t = [0.0] * 4, 0.0
            for leg, part in zip(legs, shares, strict=True):
                landed[leg] = t
                t += 1.0 - duty_factor + part * spare
            margin = _least_margin(arc, centres, ends, stride, duty_factor, landed, best.margin)
            if margin > best.margin + 1e-9:
                best = Order(legs, tuple(landed), margin)
    return best


def _least_margin(
    arc: ArcPath,
    centres: tuple[XY, ...],
    ends: tuple[float, ...],
    stride: float,
    duty_factor: float,
    landed: list[float],
    enough: float,
) -> float:
    """Least polygon margin over a cycle; gives up once it is no better than ``enough``."""
    least = math.inf
    for leg in range(4):
        for look in LOOKS:
            now = landed[leg] - (1.0 - duty_factor) * (1.0 - look)
            feet = []
            for i in OTHERS[leg]:
                left = stride * (1.0 - ((now - landed[i]) % 1.0) / duty_factor)
                feet.append(arc.seen(*centres[i], ends[i] - left))
            least = min(least, polygon_margin(support_polygon(feet), 0.0, 0.0))
            if least <= enough:
                return least
    return least
