"""The standard crab walk (H §4.3): any crab angle folded into one quadrant, its stroke, its layout,
its margin.

Everything in ``planner.crab`` below ``plan`` thinks in the *canonical* frame: the body frame turned
by n quarter turns so that the crab angle lies within ±α_c' (H table 1), legs relabelled by quadrant
there: 0 FL, 1 RL, 2 RR, 3 FR of the way ahead. ``Standard`` is all of it that depends on machine,
gait and crab angle only; it is computed once and kept.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

from ..geometry.paths import Box
from ..robot.model import Machine
from ..stability import XY
from ..types import Gait, Point, Stance

QUARTER = math.pi / 2
# rad (0.5°) beyond α_c before the gait turns over; smaller: see the legs regroup as the stick
# trembles near 45°
HYSTERESIS = 0.009
# rad; the course keeps this far from α_c, where the CoG would pass over a foot and no triangle can
# be entered
TIE = 0.001
AGREEMENT = 0.05  # of λ*; two legs standing closer than this to the standard layout agree with it
# m; reach kept beyond the strokes for vertical lifting while the body moves; less and v_max
# collapses
LEAN = 0.02
# m; the same where legs stretch to the mechanical limit (``escape``): the body goes 0.016 m/s as a
# foot comes down
STRETCH_LEAN = 0.005

# Leg roles, canonical and 0-based. The walk goes 1-3-4-2 in H's numbers: a hind leg, then the front
# leg of its side.
SUCCESSOR = (2, 0, 3, 1)
PREDECESSOR = (1, 3, 0, 2)  # u* of H table 2
IS_FRONT = (True, False, False, True)
IS_LEFT = (True, True, False, False)
OTHERS = ((1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2))  # the legs that stay
FRONT_ACROSS = (3, 3, 0, 0)  # f̄, the front leg on the other side
REAR_ACROSS = (2, 2, 1, 1)  # r̄
MATES = (3, 2, 1, 0)  # the other leg of the fore pair or of the hind pair
SAME_SIDE = (1, 0, 3, 2)

Pair = tuple[int, int, float, float]  # legs i, j and the standard displacement from j to i


@dataclass(frozen=True, slots=True, eq=False)
class Standard:
    """The standard crab walk of one machine, gait and crab angle, in the canonical frame. Metres
    and radians.
    """

    quarter_turns: int  # n of H table 1
    body_leg: tuple[int, ...]  # canonical leg -> leg of the machine
    crab_angle: float  # folded α, kept off the tie at α_c
    course: float  # the crab angle that is walked, in body axes: the commanded one but for the tie
    ux: float  # cos α
    uy: float  # sin α
    duty_factor: float  # β
    boxes: tuple[Box, ...]  # control reach, canonical legs
    far_boxes: tuple[Box, ...]  # mechanical reach
    centres: tuple[XY, ...]  # C_i
    stride: float  # λ*
    margin: float  # s0
    lags: tuple[float, ...]  # how much later than u* leg u leaves its reach
    # [u][i]: how far leg i stands ahead of C_i when u swings next
    offsets: tuple[tuple[float, ...], ...]
    # [u]: fore or hind pair, left or right pair, among the legs that stay
    pairs: tuple[tuple[Pair, Pair], ...]

    def shift_of(self, leg: int) -> float:
        """g of the standard step of ``leg``: (1-β)/β·λ* for a front leg, (β-1/2)/β·λ* for a hind
        leg.
        """
        return self.lags[leg]


class Posture(NamedTuple):
    """The machine seen from above at N_k: where the CoG is, how the canonical frame lies, where the
    feet are in it.
    """

    x: float
    y: float
    c: float  # cosine and sine of the canonical frame's heading in the absolute frame
    s: float
    feet: tuple[XY, ...]  # canonical legs, relative to the CoG
    last: int  # canonical leg that swung last, -1 for none

    def absolute(self, px: float, py: float) -> XY:
        """A point of the canonical frame in the absolute one."""
        return self.x + self.c * px - self.s * py, self.y + self.s * px + self.c * py

    def canonical(self, ax: float, ay: float) -> XY:
        """An absolute point in the canonical frame."""
        dx, dy = ax - self.x, ay - self.y
        return self.c * dx + self.s * dy, self.c * dy - self.s * dx


def posture_of(standard: Standard, stance: Stance) -> Posture:
    """A stance in the canonical frame of ``standard``."""
    x, y, _, yaw = stance.body
    c, s = turned(math.cos(yaw), math.sin(yaw), standard.quarter_turns)
    seen = []
    for leg in standard.body_leg:
        px, py, _ = stance.feet[leg]
        dx, dy = px - x, py - y
        seen.append((c * dx + s * dy, c * dy - s * dx))
    last = stance.last_swing
    return Posture(
        x, y, c, s, tuple(seen), (last - standard.quarter_turns) % 4 if last >= 0 else -1
    )


def stroke_length(x_span: float, y_span: float, crab_angle: float) -> float:
    """λ*, the longest stroke through the middle of a reach rectangle."""
    c, s = abs(math.cos(crab_angle)), abs(math.sin(crab_angle))
    # H §4.3 (1)
    return min(x_span / c if c > 1e-12 else math.inf, y_span / s if s > 1e-12 else math.inf)


def critical_angle(machine: Machine) -> float:
    """α_c, where the walk along x turns over into the walk along y."""
    reach = machine.reach
    return math.atan((reach.y0 + reach.y_span / 2) / (reach.x0 + reach.x_span / 2))  # H §4.3 (2)


def standard_margin(stride: float, duty_factor: float) -> float:
    """s0, the least longitudinal margin of the standard walk; zero at β = 3/4 by design."""
    return (1.0 - 3.0 / (4.0 * duty_factor)) * stride  # H §4.3 (3)


def quarter_turns(machine: Machine, crab_angle: float, previous: int = -1) -> int:
    """n of H table 1, 0 to 3. Within the hysteresis of the boundary ``previous`` stays."""
    critical = critical_angle(machine)
    if (
        previous >= 0
        and abs(folded(crab_angle, previous)) <= _half_width(critical, previous) + HYSTERESIS
    ):
        return previous
    for n in range(4):
        rest, half = folded(crab_angle, n), _half_width(critical, n)
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


def standard_for(
    machine: Machine, gait: Gait, crab_angle: float, previous: int = -1, stretched: bool = False
) -> Standard:
    """The standard walk for a commanded crab angle, staying with ``previous`` quarter turns on the
    boundary.

    ``stretched`` is the walk of legs that reach as far as their mechanism goes, less what lifting
    needs at least (``escape``).
    """
    return _standard(machine, gait.duty_factor, crab_angle, previous, stretched)


@lru_cache(maxsize=512)
def _standard(
    machine: Machine, duty_factor: float, crab_angle: float, previous: int, stretched: bool
) -> Standard:
    n = quarter_turns(machine, crab_angle, previous)
    asked, widest = folded(crab_angle, n), _half_width(critical_angle(machine), n) - TIE
    alpha = min(max(asked, -widest), widest)
    boxes, far_boxes = _canonical_boxes(machine, n, stretched)
    x_span, y_span = boxes[0][1] - boxes[0][0], boxes[0][3] - boxes[0][2]
    stride = stroke_length(x_span, y_span, alpha)
    centres = tuple(((box[0] + box[1]) / 2, (box[2] + box[3]) / 2) for box in boxes)
    ux, uy = math.cos(alpha), math.sin(alpha)
    offsets = tuple(_layout(u, stride, duty_factor) for u in range(4))
    front, hind = (
        (1.0 - duty_factor) / duty_factor * stride,
        (duty_factor - 0.5) / duty_factor * stride,
    )
    return Standard(
        quarter_turns=n,
        body_leg=tuple((leg + n) % 4 for leg in range(4)),
        crab_angle=alpha,
        course=crab_angle + (alpha - asked),
        ux=ux,
        uy=uy,
        duty_factor=duty_factor,
        boxes=boxes,
        far_boxes=far_boxes,
        centres=centres,
        stride=stride,
        margin=standard_margin(stride, duty_factor),
        lags=tuple(front if IS_FRONT[u] else hind for u in range(4)),
        offsets=offsets,
        pairs=tuple(_pairs(u, centres, offsets[u], ux, uy) for u in range(4)),
    )


def _canonical_boxes(
    machine: Machine, n: int, stretched: bool
) -> tuple[tuple[Box, ...], tuple[Box, ...]]:
    """Control and mechanical reach in the turned frame; odd n swaps (x0, x*) with (y0, y*) (H table
    1).
    """
    (x1, x2, y1, y2), (over_x, over_y, _) = machine.boxes[0], machine.overreach
    spans = [(x1, x2, over_x, kept(over_x, stretched)), (y1, y2, over_y, kept(over_y, stretched))]
    if n % 2:
        spans.reverse()
    (ax, bx, dx, kx), (ay, by, dy, ky) = spans
    control = (ax + kx, bx - kx, ay + ky, by - ky)
    far = (ax - dx, bx + dx, ay - dy, by + dy)
    return _mirrored(control), _mirrored(far)


def kept(overreach: float, stretched: bool) -> float:
    """By how much footholds are planned inside the control reach, m; negative: outside it."""
    return STRETCH_LEAN - overreach if stretched else max(0.0, LEAN - overreach)


def _mirrored(box: Box) -> tuple[Box, ...]:
    x1, x2, y1, y2 = box
    return (x1, x2, y1, y2), (-x2, -x1, y1, y2), (-x2, -x1, -y2, -y1), (x1, x2, -y2, -y1)


def touchdown_phases(duty_factor: float) -> tuple[float, float, float, float]:
    """When each canonical leg lands, in cycles: leg 1 (H) 0, leg 3 β-1/2, leg 4 1/2, leg 2 β (H
    fig. 5).
    """
    return 0.0, duty_factor, duty_factor - 0.5, 0.5


def _layout(next_swing: int, stride: float, duty_factor: float) -> tuple[float, ...]:
    """How far each leg stands ahead of its C_i at the switching point where ``next_swing`` swings
    next.
    """
    landed = touchdown_phases(duty_factor)
    now = landed[PREDECESSOR[next_swing]]
    return tuple(stride / 2 - stride * ((now - landed[i]) % 1.0) / duty_factor for i in range(4))


def _pairs(
    u: int, centres: tuple[XY, ...], offsets: tuple[float, ...], ux: float, uy: float
) -> tuple[Pair, Pair]:
    """A and C for the fore or hind pair, L and B for the left or right pair, of the legs that stay
    when u swings (H fig. 9).
    """
    places = [(cx + d * ux, cy + d * uy) for (cx, cy), d in zip(centres, offsets, strict=True)]
    # diagonal of u: its fore or hind mate and its side mate are the two pairs that stay
    across = MATES[SAME_SIDE[u]]

    def pair(i: int, j: int) -> Pair:
        return i, j, places[i][0] - places[j][0], places[i][1] - places[j][1]

    return pair(across, MATES[across]), pair(across, SAME_SIDE[across])


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
    standard = standard_for(machine, gait, crab_angle)
    n, swing = standard.quarter_turns, 2
    c, s = turned(math.cos(yaw), math.sin(yaw), n)
    places: list[tuple[float, float]] = [(0.0, 0.0)] * 4
    for leg, ((cx, cy), ahead) in enumerate(
        zip(standard.centres, standard.offsets[swing], strict=True)
    ):
        px, py = cx + ahead * standard.ux, cy + ahead * standard.uy
        places[standard.body_leg[leg]] = (x + c * px - s * py, y + s * px + c * py)
    heights = [height_at(px, py) for px, py in places]
    solid = [h for h in heights if h == h]
    ground = sum(solid) / len(solid) if solid else 0.0
    feet: tuple[Point, ...] = tuple(
        (px, py, h if h == h else ground) for (px, py), h in zip(places, heights, strict=True)
    )
    low, high = machine.z_range
    z = min(
        max(ground + gait.height, max(f[2] for f in feet) - high), min(f[2] for f in feet) - low
    )
    return Stance(
        (x, y, z, yaw), feet, last_swing=standard.body_leg[PREDECESSOR[swing]], quarter_turns=n
    )


def turned(cosine: float, sine: float, n: int) -> tuple[float, float]:
    """Cosine and sine of an angle plus n quarter turns, without rounding."""
    for _ in range(n % 4):
        cosine, sine = -sine, cosine
    return cosine, sine
