"""The nominal gait along a path: the stroke of its legs, their order and phases, its layout, its
margin. On a line it is the standard crab walk of H §4.3.

A path is a line or an arc (a line is an arc of turn 0), and one description serves both. Everything
in this folder thinks in the *gait frame*. On a line that is the canonical frame: the body frame
turned by n quarter turns so that the crab angle lies within ±α_c' (H table 1), legs relabelled by
quadrant there: 0 FL, 1 RL, 2 RR, 3 FR of the way ahead. On an arc it is the body frame itself
(n = 0): where the body turns tightly no quadrant is ahead.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

from ..geometry.paths import ArcPath, Box, arc_exit, arc_of_command, box_around, line_exit
from ..geometry.polygons import Polygon, convex_hull
from ..geometry.transforms import XY, direction
from ..initial_stance import Placement, standing
from ..lazy import lazy
from ..motion.leg_order import MATES, SAME_SIDE, LegOrder, order_on, standard_order
from ..motion.quarter_turns import (
    BODY_LEGS,
    folded,
    half_width,
    quarter_turned,
    quarter_turns,
)
from ..motion.strides import (
    Strokes,
    centres_of,
    mechanical_boxes,
    planning_boxes,
    stroke_length,
    strokes_on,
)
from ..robot.model import Machine
from ..stability import stable_on
from ..types import Command, Gait, Stance

# rad per m of s; a path that bends less, one of a kilometre's radius, is walked straight
STRAIGHT = 1e-3
# rad; the course keeps this far from α_c, where the CoG would pass over a foot and no triangle can
# be entered
TIE = 0.001
# m a foot may stand outside its reach on an arc when it touches early, at mid-descent (H §4.5)
EARLY = 0.02
AGREEMENT = 0.05  # of λ*; two legs standing closer than this to the nominal layout agree with it

LegPair = tuple[int, int, float, float]  # legs i, j and the nominal displacement from j to i


@dataclass(frozen=True, slots=True, eq=False)
class NominalGait:
    """The nominal walk of one machine on one path, in the gait frame: m of s, radians."""

    path: ArcPath
    quarter_turns: int  # n of H table 1
    body_leg: tuple[int, ...]  # leg of the gait frame -> leg of the machine
    course: float  # the crab angle that is walked, in body axes: the commanded one but for the tie
    duty_factor: float  # β
    boxes: tuple[Box, ...]  # reach in which footholds are planned
    far_boxes: tuple[Box, ...]  # mechanical reach
    centres: tuple[XY, ...]  # C_i
    ends: tuple[float, ...]  # from C_i to the end of the stroke
    spares: tuple[float, ...]  # from there to the end of the reach; 0 on a line
    stride: float  # λ*
    size: float  # of the machine, which metres are taken times
    order: LegOrder
    # how much later than u* leg u leaves its stroke: g of its nominal step, on a line (1-β)/β·λ* of
    # a front leg, (β-1/2)/β·λ* of a hind leg
    lags: tuple[float, ...]
    # [u][i]: how far leg i stands ahead of C_i when u has just landed
    layouts: tuple[tuple[float, ...], ...]
    # [u]: fore or hind pair, left or right pair, among the legs that stay when u swings next
    pairs: tuple[tuple[LegPair, LegPair], ...]

    @property
    def margin(self) -> float:
        """s0: the least margin of the walk, m."""
        return self.order.margin

    def layout_before(self, leg: int) -> tuple[float, ...]:
        """How far every leg stands ahead of its C_i where ``leg`` swings next."""
        return self.layouts[self.order.predecessor[leg]]


@dataclass(eq=False)
class Posture:
    """The machine seen from above at N_k in the gait frame of its nominal walk, m.

    Nobody changes one. (A frozen one takes three times as long to make, and a search makes one for
    every step it follows.)
    """

    nominal: NominalGait
    x: float  # the CoG in the absolute frame
    y: float
    c: float  # cosine and sine of the gait frame's heading in the absolute frame
    s: float
    feet: tuple[XY, ...]  # legs of the gait frame, relative to the CoG
    last: int  # leg that swung last, -1 for none
    kept_down: tuple[int, ...] = ()  # legs that are not to lift from here

    @lazy
    def exits(self) -> tuple[float, ...]:
        """g_i of every leg: how far the body may go before leg i leaves its reach, never less than
        0 (H §5.2 (4)-(10)).
        """
        path = self.nominal.path
        reach = zip(self.feet, self.nominal.boxes, strict=True)
        if path.turn != 0.0:
            early = self.nominal.size * EARLY
            return tuple([arc_exit(fx, fy, box, path, early) for (fx, fy), box in reach])
        ux, uy, _ = path
        return tuple([max(0.0, line_exit(fx, fy, box, ux, uy)) for (fx, fy), box in reach])

    @lazy
    def support(self) -> Polygon:
        """The support polygon of all four feet."""
        return convex_hull(self.feet)

    @lazy
    def carried(self) -> XY:
        """From where to where on its path the body is over all four feet, m of s."""
        return stable_on(self.nominal.path, self.support)

    @lazy
    def stretches(self) -> dict[int, XY]:
        return {}  # the same of the other three, by the leg that swings, once it has been asked

    @lazy
    def left_after(self) -> dict[float, list[float]]:
        return {}  # m each leg still reaches on its foothold after so much way, likewise

    def turned(self, dx: float, dy: float) -> XY:
        """A vector of the gait frame in the absolute one."""
        return self.c * dx - self.s * dy, self.s * dx + self.c * dy

    def absolute(self, px: float, py: float) -> XY:
        """A point of the gait frame in the absolute one."""
        return self.x + self.c * px - self.s * py, self.y + self.s * px + self.c * py

    def half_plane(self, a: float, b: float, c: float) -> tuple[float, float, float]:
        """Where a·x + b·y + c >= 0 in the gait frame, in the absolute one."""
        a, b = self.turned(a, b)
        return a, b, c - a * self.x - b * self.y

    def canonical(self, ax: float, ay: float) -> XY:
        """An absolute point in the gait frame."""
        dx = ax - self.x
        dy = ay - self.y
        return self.c * dx + self.s * dy, self.c * dy - self.s * dx

    def around(self, box: Box) -> Box:
        """The upright box in the absolute frame around one of the gait frame."""
        middle = self.absolute((box[0] + box[1]) / 2, (box[2] + box[3]) / 2)
        return box_around(box, *middle, self.c, self.s)


def posture_of(nominal: NominalGait, stance: Stance) -> Posture:
    """A stance in the gait frame of ``nominal``."""
    x, y, _, yaw = stance.body
    c, s = quarter_turned(*direction(yaw), nominal.quarter_turns)
    feet = []
    for leg in nominal.body_leg:
        px, py, _ = stance.feet[leg]
        dx = px - x
        dy = py - y
        feet.append((c * dx + s * dy, c * dy - s * dx))
    last = (stance.last_swing - nominal.quarter_turns) % 4 if stance.last_swing >= 0 else -1
    kept = tuple([nominal.body_leg.index(leg) for leg in stance.kept_down])
    return Posture(nominal, x, y, c, s, tuple(feet), last, kept)


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


def nominal_gait_of(
    command: Command, machine: Machine, gait: Gait, previous: int = -1
) -> NominalGait:
    """The nominal walk that a command asks for, on an arc when it turns, else on a line."""
    if not turns(command, machine):
        return nominal_gait(machine, gait, command.crab_angle, previous)
    course = command.crab_angle
    path, _ = arc_of_command(course, command.speed, command.turn_rate, machine.yaw_length)
    return nominal_gait_on(machine, gait, path, course)


def turns(command: Command, machine: Machine) -> bool:
    """True when the path of a command bends enough to be an arc."""
    if command.turn_rate == 0.0:
        return False
    pace = math.hypot(command.speed, machine.yaw_length * command.turn_rate)
    return abs(command.turn_rate) > STRAIGHT * pace


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
    widest = half_width(machine, n) - TIE
    alpha = min(max(asked, -widest), widest)
    boxes = planning_boxes(machine, n, stretched)
    x1, x2, y1, y2 = boxes[0]
    stride = stroke_length(x2 - x1, y2 - y1, alpha)
    return _described(
        ArcPath(*direction(alpha)),
        (n, crab_angle + (alpha - asked)),
        duty_factor,
        (boxes, mechanical_boxes(machine, n)),
        Strokes(centres_of(boxes), (stride / 2,) * 4, (0.0,) * 4, stride, machine.size),
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
        strokes_on(boxes, path)._replace(size=machine.size),
        order_on(machine, duty_factor, path),
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
    centres, ends, _, stride, _ = strokes
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
        body_leg=BODY_LEGS[heading[0]],
        course=heading[1],
        duty_factor=duty_factor,
        boxes=boxes[0],
        far_boxes=boxes[1],
        **strokes._asdict(),
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


# the standard posture


def standard_stance(machine: Machine, gait: Gait, place: Placement) -> Stance:
    """The standard posture: the standard layout at the switching point where canonical leg 3 of H
    swings next. Standing on four C_i instead, the paper's rules mostly end in a limit cycle.
    """
    nominal = nominal_gait(machine, gait, place.crab_angle)
    swing = 2
    ux, uy, _ = nominal.path
    x, y, yaw = place.pose
    heading = quarter_turned(*direction(yaw), nominal.quarter_turns)
    frame = Posture(nominal, x, y, *heading, (), -1)
    places: list[XY] = [(0.0, 0.0)] * 4
    layout = zip(nominal.body_leg, nominal.centres, nominal.layout_before(swing), strict=True)
    for leg, (cx, cy), ahead in layout:
        places[leg] = frame.absolute(cx + ahead * ux, cy + ahead * uy)
    stance = standing(machine, gait, place.pose, places, place.height_at)
    last = nominal.body_leg[nominal.order.predecessor[swing]]
    return replace(stance, last_swing=last, quarter_turns=nominal.quarter_turns)


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
