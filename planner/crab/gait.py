"""The nominal gait along a path: the stroke of its legs, their order and phases, its layout, its
margin. On a line it is the standard crab walk of H §4.3.

A path is a line or an arc (a line is an arc of turn 0), and one description serves both. Everything
in this folder thinks in the *gait frame*. On a line that is the canonical frame: the body frame
turned by n quarter turns so that the crab angle lies within ±α_c' (H table 1), legs relabelled by
quadrant there: 0 FL, 1 RL, 2 RR, 3 FR of the way ahead. On an arc it is the body frame itself
(n = 0): where the body turns tightly no quadrant is ahead. The order and the phases of the legs are
H's on a line; on an arc they are those with which the centre of gravity keeps farthest inside every
triangle in turn: on the spot the legs go round one after the other, on a wide arc as H has them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import permutations
from typing import NamedTuple

from ..geometry.paths import ArcPath, Box, arc_exit
from ..geometry.transforms import XY, direction, left_fold_sum
from ..motion.strides import (
    critical_angle,
    mechanical_boxes,
    planning_boxes,
    stroke_length,
)
from ..robot.model import Machine
from ..stability import polygon_margin, support_polygon
from ..types import Gait, Stance

QUARTER = math.pi / 2
# rad (0.5°) beyond α_c before the gait turns over; smaller: see the legs regroup as the stick
# trembles near 45°
HYSTERESIS = 0.009
# rad; the course keeps this far from α_c, where the CoG would pass over a foot and no triangle can
# be entered
TIE = 0.001
AGREEMENT = 0.05  # of λ*; two legs standing closer than this to the nominal layout agree with it

# Leg roles in the gait frame, 0-based. The walk on a line goes 1-3-4-2 in H's numbers: a hind leg,
# then the front leg of its side.
SUCCESSOR = (2, 0, 3, 1)
PREDECESSOR = (1, 3, 0, 2)  # u* of H table 2
IS_FRONT = (True, False, False, True)
IS_LEFT = (True, True, False, False)
OTHERS = ((1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2))  # the legs that stay
FRONT_ACROSS = (3, 3, 0, 0)  # f̄, the front leg on the other side
REAR_ACROSS = (2, 2, 1, 1)  # r̄
MATES = (3, 2, 1, 0)  # the other leg of the fore pair or of the hind pair
SAME_SIDE = (1, 0, 3, 2)
BODY_LEGS = ((0, 1, 2, 3), (1, 2, 3, 0), (2, 3, 0, 1), (3, 0, 1, 2))  # by n, gait leg -> body leg

STROKE_MAX = 1.0  # m of s on an arc; on a circle about itself a foot would never leave its reach
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

LegPair = tuple[int, int, float, float]  # legs i, j and the nominal displacement from j to i


class LegOrder(NamedTuple):
    """Who swings after whom, when each leg lands, and the least margin this leaves."""

    successor: tuple[int, ...]
    predecessor: tuple[int, ...]  # u*
    landed: tuple[float, ...]  # [leg], cycles
    margin: (
        float  # m: longitudinal (s0) on a line, of the polygon on an arc; negative: it must shift
    )


class Strokes(NamedTuple):
    """The stretch of the path every leg can stay on the ground for, lengths in m of s."""

    centres: tuple[XY, ...]  # C_i
    ends: tuple[float, ...]  # from C_i to the end of the stroke
    spares: tuple[float, ...]  # from there to the end of the reach
    length: float  # λ*


@dataclass(frozen=True, slots=True, eq=False)
class NominalGait:
    """The nominal walk of one machine, duty factor and path, in the gait frame. Lengths are metres
    of s, angles radians.
    """

    path: ArcPath
    quarter_turns: int  # n of H table 1
    course: float  # the crab angle that is walked, in body axes: the commanded one but for the tie
    duty_factor: float  # β
    boxes: tuple[Box, ...]  # reach in which footholds are planned
    far_boxes: tuple[Box, ...]  # mechanical reach
    centres: tuple[XY, ...]  # C_i
    ends: tuple[float, ...]  # from C_i to the end of the stroke
    spares: tuple[float, ...]  # from there to the end of the reach; 0 on a line
    stride: float  # λ*
    order: LegOrder
    lags: tuple[float, ...]  # how much later than u* leg u leaves its stroke
    # [u][i]: how far leg i stands ahead of C_i when u has just landed
    layouts: tuple[tuple[float, ...], ...]
    # [u]: fore or hind pair, left or right pair, among the legs that stay when u swings next
    pairs: tuple[tuple[LegPair, LegPair], ...]

    @property
    def body_leg(self) -> tuple[int, ...]:
        """Leg of the gait frame -> leg of the machine."""
        return BODY_LEGS[self.quarter_turns]

    @property
    def margin(self) -> float:
        """s0: the least margin of the walk, m."""
        return self.order.margin

    def layout_before(self, leg: int) -> tuple[float, ...]:
        """How far every leg stands ahead of its C_i at the switching point where ``leg`` swings
        next.
        """
        return self.layouts[self.order.predecessor[leg]]

    def shift_of(self, leg: int) -> float:
        """g of the nominal step of ``leg``: on a line (1-β)/β·λ* for a front leg, (β-1/2)/β·λ* for
        a hind leg.
        """
        return self.lags[leg]


class Posture(NamedTuple):
    """The machine seen from above at N_k: where the CoG is, how the gait frame lies, where the feet
    are in it.
    """

    x: float
    y: float
    c: float  # cosine and sine of the gait frame's heading in the absolute frame
    s: float
    feet: tuple[XY, ...]  # legs of the gait frame, relative to the CoG
    last: int  # leg that swung last, -1 for none

    def absolute(self, px: float, py: float) -> XY:
        """A point of the gait frame in the absolute one."""
        return self.x + self.c * px - self.s * py, self.y + self.s * px + self.c * py

    def canonical(self, ax: float, ay: float) -> XY:
        """An absolute point in the gait frame."""
        dx = ax - self.x
        dy = ay - self.y
        return self.c * dx + self.s * dy, self.c * dy - self.s * dx


def posture_of(nominal: NominalGait, stance: Stance) -> Posture:
    """A stance in the gait frame of ``nominal``."""
    x, y, _, yaw = stance.body
    c, s = quarter_turned(*direction(yaw), nominal.quarter_turns)
    seen = []
    for leg in nominal.body_leg:
        px, py, _ = stance.feet[leg]
        dx = px - x
        dy = py - y
        seen.append((c * dx + s * dy, c * dy - s * dx))
    last = stance.last_swing
    return Posture(x, y, c, s, tuple(seen), (last - nominal.quarter_turns) % 4 if last >= 0 else -1)


def quarter_turned(x: float, y: float, n: int) -> XY:
    """A vector (or a cosine and a sine) turned by n quarter turns, without rounding."""
    for _ in range(n % 4):
        x, y = -y, x
    return x, y


# the fold of H table 1


def quarter_turns(machine: Machine, crab_angle: float, previous: int = -1) -> int:
    """n of H table 1, 0 to 3. Within the hysteresis of the boundary ``previous`` stays."""
    critical = critical_angle(machine)
    if previous >= 0:
        beyond = abs(folded(crab_angle, previous)) - _half_width(critical, previous)
        if beyond <= HYSTERESIS:
            return previous
    for n in range(4):
        rest = folded(crab_angle, n)
        half = _half_width(critical, n)
        if -half + 1e-12 < rest <= half + 1e-12:
            return n
    return 0  # not reached: the four ranges cover the circle


def folded(crab_angle: float, n: int) -> float:
    """The crab angle in the frame turned by n quarter turns, within ±π."""
    rest = crab_angle - n * QUARTER
    if -math.pi < rest <= math.pi:
        return rest
    return math.remainder(rest, 2 * math.pi)


def _half_width(critical: float, n: int) -> float:
    return QUARTER - critical if n % 2 else critical


# the gait on a line and on an arc


def nominal_gait(
    machine: Machine, gait: Gait, crab_angle: float, previous: int = -1, stretched: bool = False
) -> NominalGait:
    """The nominal walk on a line at a commanded crab angle, staying with ``previous`` quarter turns
    on the boundary.

    ``stretched`` is the walk of legs that reach as far as their mechanism goes, less what lifting
    needs at least (``recovery``).
    """
    return _on_line(machine, gait.duty_factor, crab_angle, previous, stretched)


def nominal_gait_on(
    machine: Machine, gait: Gait, path: ArcPath, crab_angle: float | None = None
) -> NominalGait:
    """The nominal walk on an arc, which may be a line, in the body frame; ``crab_angle`` names the
    course of a turn on the spot, which has no direction.
    """
    course = math.atan2(path.uy, path.ux) if crab_angle is None else crab_angle
    return _on_arc(machine, gait.duty_factor, path, course)


@lru_cache(maxsize=512)
def _on_line(
    machine: Machine, duty_factor: float, crab_angle: float, previous: int, stretched: bool
) -> NominalGait:
    n = quarter_turns(machine, crab_angle, previous)
    asked = folded(crab_angle, n)
    widest = _half_width(critical_angle(machine), n) - TIE
    alpha = min(max(asked, -widest), widest)
    boxes = planning_boxes(machine, n, stretched)
    x1, x2, y1, y2 = boxes[0]
    stride = stroke_length(x2 - x1, y2 - y1, alpha)
    return _described(
        ArcPath(*direction(alpha)),
        (n, crab_angle + (alpha - asked)),
        duty_factor,
        (boxes, mechanical_boxes(machine, n)),
        Strokes(_centres(boxes), (stride / 2,) * 4, (0.0,) * 4, stride),
        standard_order(stride, duty_factor),
    )


@lru_cache(maxsize=256)
def _on_arc(machine: Machine, duty_factor: float, path: ArcPath, course: float) -> NominalGait:
    boxes = planning_boxes(machine, 0, stretched=False)
    return _described(
        path,
        (0, course),
        duty_factor,
        (boxes, mechanical_boxes(machine, 0)),
        strokes_on(boxes, path),
        best_order(machine, duty_factor, *_coarse(machine, path)),
    )


def _described(
    path: ArcPath,
    heading: tuple[int, float],
    duty_factor: float,
    boxes: tuple[tuple[Box, ...], tuple[Box, ...]],
    strokes: Strokes,
    order: LegOrder,
) -> NominalGait:
    """The description of a walk whose strokes and order are known."""
    centres, ends, spares, stride = strokes
    landed = order.landed
    lags = tuple(
        ((landed[u] - landed[order.predecessor[u]]) % 1.0) / duty_factor * stride for u in range(4)
    )
    layouts = tuple(
        tuple(
            (stride - end) - stride * ((landed[u] - before) % 1.0) / duty_factor
            for end, before in zip(ends, landed, strict=True)
        )
        for u in range(4)
    )
    pairs = tuple(_pairs(u, centres, layouts[order.predecessor[u]], path) for u in range(4))
    return NominalGait(
        path=path,
        quarter_turns=heading[0],
        course=heading[1],
        duty_factor=duty_factor,
        boxes=boxes[0],
        far_boxes=boxes[1],
        centres=centres,
        ends=ends,
        spares=spares,
        stride=stride,
        order=order,
        lags=lags,
        layouts=layouts,
        pairs=pairs,
    )


def _pairs(
    u: int, centres: tuple[XY, ...], ahead: tuple[float, ...], path: ArcPath
) -> tuple[LegPair, LegPair]:
    """A and C for the fore or hind pair, L and B for the left or right pair, of the legs that stay
    when u swings (H fig. 9).
    """
    places = [path.placed(cx, cy, d) for (cx, cy), d in zip(centres, ahead, strict=True)]
    # diagonal of u: its fore or hind mate and its side mate are the two pairs that stay
    across = MATES[SAME_SIDE[u]]

    def pair(i: int, j: int) -> LegPair:
        return i, j, places[i][0] - places[j][0], places[i][1] - places[j][1]

    return pair(across, MATES[across]), pair(across, SAME_SIDE[across])


# strokes


def strokes_on(boxes: Sequence[Box], path: ArcPath) -> Strokes:
    """C_i and, on circles about the turning centre, the stroke the legs share: that of the leg
    which has least. On a line it is H's (``stroke_length``).
    """
    back = path.reversed()
    centres = _centres(boxes)
    ahead = [arc_exit(x, y, box, path) for (x, y), box in zip(centres, boxes, strict=True)]
    behind = [arc_exit(x, y, box, back) for (x, y), box in zip(centres, boxes, strict=True)]
    stride = min(STROKE_MAX, *(a + b for a, b in zip(ahead, behind, strict=True)))
    ends = tuple(
        ((a - b if a < math.inf else 0.0) + stride) / 2 for a, b in zip(ahead, behind, strict=True)
    )
    spares = tuple(
        leave - end if leave < math.inf else 0.0 for leave, end in zip(ahead, ends, strict=True)
    )
    return Strokes(centres, ends, spares, stride)


def _centres(boxes: Sequence[Box]) -> tuple[XY, ...]:
    return tuple(((x1 + x2) / 2, (y1 + y2) / 2) for x1, x2, y1, y2 in boxes)


# the order of the legs


def standard_margin(stride: float, duty_factor: float) -> float:
    """s0, the least longitudinal margin of the standard walk; zero at β = 3/4 by design."""
    return (1.0 - 3.0 / (4.0 * duty_factor)) * stride  # H §4.3 (3)


def standard_order(stride: float, duty_factor: float) -> LegOrder:
    """H's order on a line: 1-3-4-2."""
    margin = standard_margin(stride, duty_factor)
    return LegOrder(SUCCESSOR, PREDECESSOR, touchdown_phases(duty_factor), margin)


def touchdown_phases(duty_factor: float) -> tuple[float, float, float, float]:
    """When each leg of the gait frame lands on a line, in cycles: leg 1 (H) 0, leg 3 β-1/2, leg 4
    1/2, leg 2 β (H fig. 5).
    """
    return 0.0, duty_factor, duty_factor - 0.5, 0.5


def _coarse(machine: Machine, path: ArcPath) -> tuple[int, int]:
    """The path as two whole numbers of ``GRAIN``: its direction, and how much of it is turning
    (positive to the left).
    """
    ahead = math.hypot(path.ux, path.uy)
    turning = round(math.atan2(machine.yaw_length * path.turn, ahead) / GRAIN)
    return (round(math.atan2(path.uy, path.ux) / GRAIN) if ahead > 1e-9 else 0), turning


@lru_cache(maxsize=2048)
def best_order(machine: Machine, duty_factor: float, course: int, turning: int) -> LegOrder:
    """The order and phases with the largest least polygon margin, of all six orders and every
    spread of the four-leg time; ``course`` and ``turning`` count ``GRAIN``.
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
    centres, ends, _, stride = strokes
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


# the standard posture


def standard_stance(
    machine: Machine,
    gait: Gait,
    crab_angle: float,
    x: float,
    y: float,
    yaw: float,
    height_at: Callable[[float, float], float],
) -> Stance:
    """The standard posture: the standard layout at the switching point where canonical leg 3 of H
    swings next.

    Feet stand on the ground (on the mean of the others over a hole), the body at mean foot height +
    H. Standing on four C_i instead, the paper's rules mostly end in a limit cycle.
    """
    nominal = nominal_gait(machine, gait, crab_angle)
    swing = 2
    ux, uy, _ = nominal.path
    c, s = quarter_turned(*direction(yaw), nominal.quarter_turns)
    frame = Posture(x, y, c, s, (), -1)
    places: list[XY] = [(0.0, 0.0)] * 4
    layout = zip(nominal.body_leg, nominal.centres, nominal.layout_before(swing), strict=True)
    for leg, (cx, cy), ahead in layout:
        places[leg] = frame.absolute(cx + ahead * ux, cy + ahead * uy)
    heights = [height_at(px, py) for px, py in places]
    solid = [h for h in heights if h == h]
    ground = left_fold_sum(solid) / len(solid) if solid else 0.0
    feet = tuple(
        (px, py, h if h == h else ground) for (px, py), h in zip(places, heights, strict=True)
    )
    low, high = machine.z_range
    highest = min(foot[2] for foot in feet) - low
    z = min(max(ground + gait.height, max(foot[2] for foot in feet) - high), highest)
    last = nominal.body_leg[nominal.order.predecessor[swing]]
    return Stance((x, y, z, yaw), feet, last_swing=last, quarter_turns=nominal.quarter_turns)


def off_standard(machine: Machine, gait: Gait, crab_angle: float, stance: Stance) -> float:
    """How far the foot that is farthest off stands from its place in the standard layout at this
    N_k, as a share of λ*; inf where no leg has swung yet.
    """
    nominal = nominal_gait(machine, gait, crab_angle, stance.quarter_turns)
    posture = posture_of(nominal, stance)
    if posture.last < 0:
        return math.inf
    ux, uy, _ = nominal.path
    places = zip(posture.feet, nominal.centres, nominal.layouts[posture.last], strict=True)
    off = max(math.hypot(fx - cx - d * ux, fy - cy - d * uy) for (fx, fy), (cx, cy), d in places)
    return off / nominal.stride


def is_standard(off: float) -> bool:
    """True when a layout so far off still counts as standard (the tolerance of H fig. 9)."""
    return off <= AGREEMENT
