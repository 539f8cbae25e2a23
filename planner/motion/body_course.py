"""The reference of a step: a smooth course through the places its body was planned at.

The places are knots of a line or an arc; between them the course is a cubic whose direction has no
jumps. It also knows what carries the machine: the polygons a swaying body keeps its margin in.
Metres, seconds, absolute frame.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Collection, Sequence
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

from ..geometry.polygons import Polygon
from ..geometry.transforms import XY, Body, Point, direction, tilt_of, turned_back_by, turned_by
from ..robot.model import Machine
from ..stability import polygon_margin, support_polygon
from ..statics import centre_of_gravity
from ..terrain.map import TerrainMap
from ..types import Phase, Stance, StepPlan
from .body_path import OFFSET_MAX, lateral_bounds, meeting, nearest_edge_normal
from .body_tilt import LEVEL, Lean
from .sway_room import SAFE, SwayRoom

STILL = 1e-9  # m; a reference that goes no farther stands
STRAIGHT = 1e-9  # m and rad that a straight reference may be off its line
NUDGE = 0.01  # m
HALVES = 5  # of a way onward that leads too far, until there is none
APART = 0.008  # m between places of a reference; nearer ones: see it swing to and fro
MUCH = 1.5  # times the margin; a smaller gain: see a small machine sway to and fro and keep less
FLAT_MIN = 0.3  # of way over the ground per metre of a reference; one with less turns or climbs


class Moment(NamedTuple):
    """An instant of a step: how far the reference has come and where it has the body, where the
    centre of gravity is from that then, absolute axes, the feet that stand, in leg order, and how
    the body leans.
    """

    length: float
    body: Body
    centre: XY
    feet: Sequence[Point | None]
    lean: Lean


class SwayAxes:
    """In what direction a body sways along its course, and how far its centre of gravity goes with
    it. The course is taken to turn evenly from its beginning to its end.
    """

    __slots__ = ("begins", "turning", "carries_along", "aside", "_side", "_leverage")

    def __init__(
        self, begins: float, turning: float, carries_along: float, aside: float = math.pi / 2
    ) -> None:
        self.begins = begins  # absolute direction of the course, rad
        self.turning = turning  # rad per metre of the reference's length
        self.carries_along = carries_along  # by which the centre of gravity goes with the body
        self.aside = aside  # rad, from the course to the direction in which the body sways
        self._side = direction(begins + aside)
        self._leverage = self._side[0] * carries_along, self._side[1] * carries_along

    def towards(self, aside: float) -> SwayAxes:
        """The same of a body that sways in another direction from its course, rad."""
        return SwayAxes(self.begins, self.turning, self.carries_along, aside)

    def side(self, length: float) -> XY:
        """The unit vector along which the body sways after a length of its reference: to the left
        of its course, or away from an edge.
        """
        if self.turning == 0.0:
            return self._side
        return direction(self.begins + self.turning * length + self.aside)

    def leverage(self, length: float) -> XY:
        """How far the centre of gravity goes when the body sways by a metre there: legs stay
        behind.
        """
        if self.turning == 0.0:
            return self._leverage
        sx, sy = self.side(length)
        return sx * self.carries_along, sy * self.carries_along


class Course:
    """The reference of a step as a polyline, and what carries the machine on its way."""

    def __init__(
        self,
        reference: list[Body],
        crab_angle: float,
        polygons: tuple[Polygon, Polygon],
        centres: tuple[XY, XY],
        lift: int,
        carries_along: float,
        room: SwayRoom,
        standing: tuple[Sequence[Point | None], Sequence[Point | None]],
        leans: tuple[Lean, Lean, Lean],
    ) -> None:
        lengths = _lengths(reference)
        kept = [0, len(lengths) - 1] if _is_even(reference, lengths) else _apart(lengths)
        self.reference = [reference[k] for k in kept]
        self.turns = any(body[3] != reference[0][3] for body in self.reference)  # on its way
        self.crab_angle = crab_angle
        self.before, self.after = polygons  # of the feet that carry before, and after, a leg lifts
        self.lengths = [lengths[k] for k in kept]
        self.lift_length = lengths[lift]  # behind the body when a leg lifts, m
        self._stretches = _stretches(self.reference, self.lengths)
        begins = self.heading(0.0)
        turn = math.remainder(self.heading(self.length) - begins, 2.0 * math.pi)
        self.sway = SwayAxes(begins, turn / max(self.length, STILL), carries_along)
        # the direction in which it sets out, and way over the ground per metre of it there
        self.sets_out = direction(begins), self.flat(0.0)
        # of the centre of gravity from the body when a leg lifts, and at the end, absolute axes
        self.centres = centres
        self._lifts_at = self.at(self.lift_length)
        self._room = room
        self._standing = standing  # the feet that stand before, and after, a leg lifts
        self.leans = leans  # of the body at the beginning, when a leg lifts, and at the end

    @classmethod
    def of(
        cls, plan: StepPlan, stance: Stance, machine: Machine, terrain: TerrainMap | None = None
    ) -> Course:
        """That of a plan as it was decided; ``terrain`` is the ground it leads over, where it is to
        keep clear of what stands tall there.
        """
        legs = range(len(stance.feet))
        standing = support_polygon(stance.feet[leg] for leg in legs if leg not in stance.lifted)
        first = first_swing(plan.phases)
        swinging: Polygon = ()
        if first is not None:
            swinging = support_polygon(stance.feet[leg] for leg in legs if leg not in plan.swing)
        reference = [(b[0], b[1], b[2], b[3]) for b in plan.body.tolist()]
        lift = first or 0
        leans = _leans(plan, lift)
        feet = plan.feet[lift].tolist()
        lifting = centre_over(machine, reference[lift], feet, leans[1])
        centres = lifting, centre_over(machine, reference[-1], plan.feet[-1].tolist(), leans[2])
        lifts = len(plan.phases) if first is None else first
        share = _carried_along(machine, reference[lift], feet, (lifting, leans[1]))
        on = _feet_but(stance, stance.lifted), _feet_but(stance, plan.swing)
        polygons = standing, swinging
        room = SwayRoom.about(stance, machine, terrain)
        return cls(reference, plan.crab_angle, polygons, centres, lifts, share, room, on, leans)

    @property
    def leaning(self) -> bool:
        """True when the body leans at any time."""
        return self.leans[0] != LEVEL or self.leans[2] != LEVEL

    def lean_at(self, share: float) -> Lean:
        """How the body leans after a share of the step's time: it leans over evenly."""
        (bx, by), _, (ex, ey) = self.leans
        return bx + share * (ex - bx), by + share * (ey - by)

    @property
    def length(self) -> float:
        """Of the whole reference, m."""
        return self.lengths[-1]

    def at(self, length: float) -> Body:
        """The reference after a length of it: a cubic over the ground, even in height and yaw."""
        return self.motion(length)[0]

    def slope(self, length: float) -> Body:
        """Change of x, y, z and yaw per metre of the reference's length there."""
        return self.motion(length)[1]

    def motion(self, length: float) -> tuple[Body, Body]:
        """Both of these at once."""
        stretches = self._stretches
        k = 0
        if len(stretches) > 1:
            k = min(max(bisect_right(self.lengths, length) - 1, 0), len(stretches) - 1)
        begin, way, place, change, (sx, sy), (ex, ey), mean = stretches[k]
        x, y, z, yaw = place
        dx, dy, climbed, turned = change
        onward, left_on, climb, turn = mean
        share = min(max((length - begin) / max(way, STILL), 0.0), 1.0)
        left = 1.0 - share
        ends = share * share * (1.0 + 2.0 * left)
        out = share * left * left * way
        back = -share * share * left * way
        middle = 6.0 * share * left
        first = left * (left - 2.0 * share)
        last = share * (share - 2.0 * left)
        return (
            x + ends * dx + out * sx + back * ex,
            y + ends * dy + out * sy + back * ey,
            z + share * climbed,
            yaw + share * turned,
        ), (
            middle * onward + first * sx + last * ex,
            middle * left_on + first * sy + last * ey,
            climb,
            turn,
        )

    def heading(self, length: float) -> float:
        """Absolute direction of the course there, rad."""
        x, y, _, _ = self.slope(length)
        if math.hypot(x, y) <= FLAT_MIN:
            return self.at(length)[3] + self.crab_angle
        return math.atan2(y, x)

    def flat(self, length: float) -> float:
        """Way over the ground per metre of the reference, about there."""
        x, y, _, _ = self.slope(length)
        return math.hypot(x, y)

    def lifting(self, length: float) -> Moment:
        """A leg lifts after a length of the reference."""
        body = self.at(length)
        centre = _left_behind(self.centres[0], self._lifts_at, body, self.sway.carries_along)
        return Moment(length, body, centre, self._standing[0], self.leans[1])

    def halfway(self, length: float) -> Moment:
        """A leg is halfway in the air after a length of the reference."""
        (ax, ay), (bx, by) = self.centres
        centre = (ax + bx) / 2.0, (ay + by) / 2.0
        return Moment(length, self.at(length), centre, self._standing[1], self.leans[2])

    @cached_property
    def landing(self) -> Moment:
        """The step ends, and with it a leg's swing."""
        return self._end(self._standing[1])

    @property
    def shifted(self) -> Moment:
        """The step ends in which no leg has lifted."""
        return self._end(self._standing[0])

    def _end(self, standing: Sequence[Point | None]) -> Moment:
        return Moment(self.length, self.at(self.length), self.centres[1], standing, self.leans[2])

    def bounds_at(self, when: Moment, polygon: Polygon, margin: float, along: float = 0.0) -> XY:
        """The offsets at which the body keeps a margin in a polygon, when it is so far ``along``
        the course from its reference.
        """
        return self.all_bounds_at(when, (polygon,), margin, along)[0]

    def all_bounds_at(
        self, when: Moment, polygons: Sequence[Polygon], margin: float, along: float
    ) -> list[XY]:
        """Those in each of some polygons."""
        x, y = self.weight_at(when, 0.0, along)
        reach = self.in_reach(when, along)
        leverage = self.sway.leverage(when.length)
        return [
            meeting(reach, lateral_bounds(polygon, x, y, leverage, margin)) for polygon in polygons
        ]

    def in_reach(self, when: Moment, along: float = 0.0) -> XY:
        """The offsets at which every foot that stands is within its leg's mechanical reach, and no
        leg nor the torso in something tall.
        """
        x, y, z, yaw = when.body
        sx, sy = side = self.sway.side(when.length)
        lx, ly = when.lean
        body = x + along * sy, y - along * sx, z + along * (lx * sy - ly * sx), yaw
        return self._room.offsets(body, side, when.feet, when.lean)

    def beyond(self, body: Body, lifted: bool, lean: Lean = LEVEL) -> float:
        """How far the farthest foot that stands before, or after, a leg is ``lifted`` is outside of
        its leg's mechanical reach with the body there, m; negative inside.
        """
        return self._room.beyond(body, self._standing[lifted], lean)

    def keeps_within(self, bodies: Sequence[Body], lifted: bool, spare: float) -> bool:
        """True when these feet are all within reach, by at least ``spare``, m, with a level body
        at any of some places, where it faces one way.
        """
        return self._room.keeps_within(bodies, self._standing[lifted], spare)

    @property
    def is_among_tall(self) -> bool:
        """True when something tall is near."""
        return self._room.is_among_tall

    def is_met(self, body: Body, feet: Sequence[Point]) -> bool:
        """True when a leg is in something tall with body and feet there."""
        return self._room.is_met(body, feet)

    def within_reach(self, length: float) -> float:
        """A length of the reference, or what of it is left in halves of it until every foot that
        stands before a leg lifts is within reach, m.
        """
        for _ in range(HALVES):
            if self.beyond(self.at(length), lifted=False, lean=self.leans[0]) <= -SAFE:
                return length
            length /= 2.0
        return 0.0

    def weight_at(self, when: Moment, aside: float, along: float) -> XY:
        """Where the centre of gravity is above, with the body so far beside the reference."""
        x, y, _, _ = when.body
        sx, sy = self.sway.leverage(when.length)
        return (
            x + when.centre[0] + aside * sx + along * sy,
            y + when.centre[1] + aside * sy - along * sx,
        )

    def margin_at(self, when: Moment, aside: float, along: float) -> float:
        """That in the polygon after a leg has lifted, so far beside the reference."""
        return polygon_margin(self.after, *self.weight_at(when, aside, along))

    def turn_to_safety(self, margin: float) -> None:
        """Where no offset across the course keeps the margin when a leg lifts, sway away from the
        nearest edge instead, if that is better; or until it lands, if that is much better.
        """
        if not self.after:
            return
        lifting = self.lifting(self.lift_length)
        ends = (lifting, self.landing)
        first, last = map(self._best, ends)
        kept = min(first, last)
        if kept >= margin:
            return
        when = ends[last < first]
        across = self.sway
        nx, ny = nearest_edge_normal(self.after, *self.weight_at(when, 0.0, 0.0))
        now = across.begins + across.turning * when.length
        self.sway = across.towards(math.atan2(ny, nx) - now)
        least = min(map(self._best, ends))
        if least <= kept or (when is not lifting and least < min(margin, MUCH * kept)):
            self.sway = across

    def _best(self, when: Moment) -> float:
        """The most margin an offset leaves at a moment with a leg in the air, m."""
        low, high = self.bounds_at(when, self.after, OFFSET_MAX)
        least = self.margin_at(when, low, 0.0)
        return least if low == high else max(least, self.margin_at(when, high, 0.0))


def centre_over(
    machine: Machine, body: Body, feet: Sequence[Sequence[float]], lean: Lean = LEVEL
) -> XY:
    """The centre of gravity of body and legs from the body's own place, absolute axes."""
    bx, by, bz, yaw = body
    c, s = direction(yaw)
    at_feet = machine.mass_at_feet
    if at_feet is not None and lean == LEVEL:
        ahead, aside, _, mass, whole = at_feet
        for fx, fy, _ in feet:
            dx = fx - bx
            dy = fy - by
            ahead += mass * (c * dx + s * dy)
            aside += mass * (c * dy - s * dx)
        ahead /= whole
        aside /= whole
        return c * ahead - s * aside, s * ahead + c * aside
    seen = [
        (c * (fx - bx) + s * (fy - by), c * (fy - by) - s * (fx - bx), fz - bz)
        for fx, fy, fz in feet
    ]
    tilt = None if lean == LEVEL else tilt_of(lean, yaw)
    if tilt is not None:
        seen = [turned_back_by(tilt, foot) for foot in seen]
    centre = centre_of_gravity(machine, seen)
    x, y, _ = centre if tilt is None else turned_by(tilt, centre)
    return c * x - s * y, s * x + c * y


def _left_behind(centre: XY, begin: Body, end: Body, carried: float) -> XY:
    """The centre of gravity from the body's own place when that has gone on from one place to
    another with all feet on the ground: legs come along by less than the body.
    """
    left = 1.0 - carried
    return centre[0] - left * (end[0] - begin[0]), centre[1] - left * (end[1] - begin[1])


def _leans(plan: StepPlan, lift: int) -> tuple[Lean, Lean, Lean]:
    """How the body of a plan leans at its beginning, at its knot ``lift`` and at its end."""
    after = plan.end.lean
    before = after if plan.lean is None else plan.lean
    if before == after:
        return after, after, after
    share = float(plan.times[lift] / plan.times[-1])
    x, y = (a + share * (b - a) for a, b in zip(before, after, strict=True))
    return before, (x, y), after


def _feet_but(stance: Stance, legs: Collection[int]) -> list[Point | None]:
    """The feet of a stance, without those of some legs."""
    return [None if leg in legs else foot for leg, foot in enumerate(stance.feet)]


def _carried_along(
    machine: Machine, body: Body, feet: Sequence[Sequence[float]], now: tuple[XY, Lean]
) -> float:
    """By how much of a small sway of the body the centre of gravity goes with it; ``now`` is where
    it is from the body before, and how that leans.
    """
    x, y, z, yaw = body
    centre, lean = now
    swayed = centre_over(machine, (x + NUDGE, y, z + NUDGE * lean[0], yaw), feet, lean)
    return 1.0 + (swayed[0] - centre[0]) / NUDGE


def first_swing(phases: Sequence[Phase]) -> int | None:
    """The first stretch in which a leg is in the air on its way."""
    for k, phase in enumerate(phases):
        if phase is not Phase.SUPPORT and phase is not Phase.SHIFT:
            return k
    return None


def _lengths(body: Sequence[Body]) -> list[float]:
    """How far the reference has come at every knot, m; a turn on the spot and a climb count too."""
    out = [0.0]
    for a, b in pairwise(body):
        out.append(out[-1] + math.dist(a, b))
    return out


class _Stretch(NamedTuple):
    """From one place of a reference to the next."""

    begin: float  # of the reference's length, m
    way: float  # m
    body: Body  # where it begins
    change: Body  # of x, y, z and yaw
    sets_out: XY  # way along x and y per metre where it begins
    comes_in: XY  # and where it ends
    mean: Body  # change of x, y, z and yaw per metre


def _stretches(reference: Sequence[Body], lengths: Sequence[float]) -> list[_Stretch]:
    """All of a reference."""
    slopes = _slopes(reference, lengths)
    out = []
    for k, ((x, y, z, yaw), (ex, ey, ez, eyaw)) in enumerate(pairwise(reference)):
        way = lengths[k + 1] - lengths[k]
        dx, dy, climb, turn = change = (ex - x, ey - y, ez - z, eyaw - yaw)
        length = max(way, STILL)
        mean = dx / length, dy / length, climb / length, turn / length
        out.append(_Stretch(lengths[k], way, reference[k], change, slopes[k], slopes[k + 1], mean))
    return out


def _is_even(reference: Sequence[Body], lengths: Sequence[float]) -> bool:
    """True of a reference that goes straight, and climbs and turns evenly, from end to end."""
    x, y, z, yaw = reference[0]
    ex, ey, ez, eyaw = reference[-1]
    for place, length in zip(reference, lengths, strict=True):
        share = length / max(lengths[-1], STILL)
        off = math.dist(
            place,
            (
                x + share * (ex - x),
                y + share * (ey - y),
                z + share * (ez - z),
                yaw + share * (eyaw - yaw),
            ),
        )
        if off > STRAIGHT:
            return False
    return True


def _apart(lengths: Sequence[float]) -> list[int]:
    """The places of a reference that are far enough from each other to say which way it goes."""
    last = len(lengths) - 1
    kept = [0]
    for k in range(1, last):
        if min(lengths[k] - lengths[kept[-1]], lengths[last] - lengths[k]) >= APART:
            kept.append(k)
    return [*kept, last]


def _slopes(reference: Sequence[Body], lengths: Sequence[float]) -> list[XY]:
    """Way along x and y per metre of length at every place: of the parabola through it and its
    neighbours.
    """
    kept = [k for k in range(len(lengths)) if k == 0 or lengths[k] - lengths[k - 1] > STILL]
    chords = [_chord(reference, lengths, a, b) for a, b in zip(kept, kept[1:], strict=False)] or [
        (0.0, 0.0)
    ]
    inner = [
        _mixed(
            chords[k - 1],
            chords[k],
            (lengths[kept[k]] - lengths[kept[k - 1]])
            / max(lengths[kept[k + 1]] - lengths[kept[k - 1]], STILL),
        )
        for k in range(1, len(chords))
    ]
    if inner:
        first = _mixed(inner[0], chords[0], 2.0)
        last = _mixed(inner[-1], chords[-1], 2.0)
    else:
        first = last = chords[0]
    at_kept = [first, *inner, last]
    out: list[XY] = []
    n = -1
    for k in range(len(lengths)):
        n += k in kept
        out.append(at_kept[min(n, len(at_kept) - 1)])
    return out


def _chord(reference: Sequence[Body], lengths: Sequence[float], a: int, b: int) -> XY:
    way = lengths[b] - lengths[a]
    return (
        (reference[b][0] - reference[a][0]) / way,
        (reference[b][1] - reference[a][1]) / way,
    )


def _mixed(one: XY, other: XY, share: float) -> XY:
    """``share`` of the other and the rest of the one."""
    return one[0] + share * (other[0] - one[0]), one[1] + share * (other[1] - one[1])
