"""A step of the crab walk while the torso turns: Levels B2 to B4 on an arc (H §5-§7 with circles for lines).

The course is an arc of constant twist, down to a turn on the spot. What the paper settles by rule on a straight course is
searched for here: sequences of swings and of sways (the body shifted on four legs) are grown a few steps deep, always the
most promising ones, and the first step of the best is taken. Each swing is the paper's: g0 until the triangle carries, g as
far as it carries and every standing leg reaches, the foot put where it leaves its stroke later than u* by the standard phase
difference. Bounded by count; no memory, so it takes over from any posture of a straight walk and hands any back.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..course import Twist, arc_exit, twist_of
from ..lookahead import Branch, Found, Option, Search, beam, firsts
from ..machine import Machine
from ..support import XY, polygon_margin, stable_on_arc, support_polygon
from ..terrain import TerrainMap
from ..vocabulary import Array, Blocked, Command, Gait, Phase, Point, Stance, StepPlan
from .arcs import Circular, carried, circular_gait, reversed_course
from .height import CLEARANCE, height_range, lift, torso_needs, torso_needs_exactly
from .landing import Ground, clipped, ground_of, nearest_of
from .standard import OTHERS
from .trajectory import BACK_MIN, EASED, EVEN, Swing
from .xy import SLACK, STILL, Notes

STRAIGHT = 1e-3  # rad per m of s; a course that bends less, one of a kilometre's radius, is walked straight
DEPTH, WIDTH = 6, 6  # steps a sequence is long, sequences kept; less: see it sway where a swing would do
FAR_DEPTH, FAR_WIDTH = 9, 16  # the second look, when the first finds no way on
INSET = 0.03  # m from every edge of the triangle, where the standard walk has so much
INSET_SHARE = 0.6  # of the least margin of the standard walk, where it has less
THIN, BARE = 0.004, 0.001  # m; an inset every swing keeps where it can, and one it keeps always; none: see the torso tip as a foot lifts
THIN_COST = 0.15  # m of course a swing without it is held to lose
USEFUL = 0.5  # of the standard swing's way; a swing that moves the body less is looked at with no inset, and beside sways
FAR_ENOUGH = 0.45  # m around I_u in which footholds are looked for
CELLS_MAX = 4  # footholds compared
STILL_MAX = 2  # steps without a useful way after which sways and the leg before are left out in turn; else see it go to and fro
SWAY_MIN = 0.002  # m; a shorter sway is none
PHASE_WEIGHT = 0.25  # of what the legs lack of the standard phases, m of progress per m; 0: see legs bunch up and sway
KNOT_TURN = 0.02  # rad of yaw between knots; more: see the swing foot leave its line
CLIMB = 0.4  # m the body may rise or sink per m of course
EARLY = 0.02  # m a foot may stand outside its reach when it touches early, at mid-descent (H §4.5)
ROUNDING = 0.995  # of every speed limit: straight lines between knots in axes that turn


Thinking = Generator[None, bool | None, StepPlan | Blocked]


class Place(NamedTuple):
    """A posture in the search. Feet in its own body axes."""

    x: float
    y: float
    yaw: float
    feet: tuple[XY, ...]
    exits: tuple[float, ...]  # g_i
    last: int
    way: float = 0.0  # m of course gone
    swayed: bool = False

    def absolute(self, px: float, py: float) -> XY:
        """A point of the body axes in the absolute frame."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return self.x + c * px - s * py, self.y + s * px + c * py


class Move(NamedTuple):
    """One step: a swing (g0, g, where from I_u to J_u), or, with leg -1, a sway of the body to ``landing``. Body axes at N_k."""

    leg: int
    g0: float
    g: float
    start: XY
    landing: XY
    ground: XY  # the landing point in the absolute frame
    inset: float


class Outlook:
    """One search for the next step of a turn from one stance."""

    def __init__(
        self, circular: Circular, stance: Stance, pace: float, terrain: TerrainMap, machine: Machine, gait: Gait
    ) -> None:
        self.circular, self.stance, self.terrain, self.machine, self.gait = circular, stance, terrain, machine, gait
        self.ground: Ground = ground_of(terrain)
        self.rises = Rises(stance, circular, terrain, machine, gait)
        standard = circular.swing_share * circular.stride
        self.useful = USEFUL * standard
        self.full = standard
        comfort = min(INSET, INSET_SHARE * circular.margin)
        self.insets = (comfort, THIN, BARE) if comfort > THIN else (THIN, BARE)
        x, y, _, yaw = stance.body
        feet = _in_body(stance)
        self.root = Place(x, y, yaw, feet, self.exits(feet), stance.last_swing, 0.0, stance.still >= STILL_MAX and stance.still % 2 == 1)
        self.never_again = stance.still >= STILL_MAX and stance.still % 2 == 0
    def look(self, depth: int, width: int) -> Search[Place, Move]:
        """The ways on, best first: way gone, less what was lost on it, less what the legs lack of the standard phases."""
        return beam(self.root, self.options, depth, width)

    def options(self, place: Place, depth: int) -> Iterator[Option[Place, Move]]:
        """Every next step worth looking at, for the beam."""
        for move in self.moves(place, depth == 0):
            after, gain = self.after(place, move)
            yield Option(move, after, gain, self.promise(after))

    def promise(self, place: Place) -> float:
        """Minus what the legs' exits lack of those in the standard walk after the same leg has landed, m."""
        layouts = (self.circular.layouts[place.last],) if place.last >= 0 else self.circular.layouts
        lacks = min(sum(max(0.0, want - has) for want, has in zip(layout, place.exits, strict=True)) for layout in layouts)
        return -PHASE_WEIGHT * lacks

    def exits(self, feet: tuple[XY, ...]) -> tuple[float, ...]:
        """g_i of every leg on the arc."""
        return tuple(arc_exit(fx, fy, box, self.circular.twist, EARLY) for (fx, fy), box in zip(feet, self.circular.boxes, strict=True))

    # what can be done next

    def moves(self, place: Place, first: bool) -> Iterator[Move]:
        """Swings of every leg but the last, sways where swings do little; the last leg again when nothing else is left."""
        found, stuck = False, []
        for leg in range(4):
            shift = self.shift_of(place, leg) if leg != place.last else None
            if shift is not None:
                for move in self.landings(place, leg, *shift, first):
                    found = True
                    yield move
            if shift is None or shift[1] - shift[0] < self.useful:
                stuck.append(leg)
        if not found and place.last >= 0 and not (first and self.never_again):
            shift = self.shift_of(place, place.last)
            if shift is not None:
                for move in self.landings(place, place.last, *shift, first):
                    found = True
                    yield move
        if not found or (not place.swayed and (first or len(stuck) == 4)):
            for leg in stuck:
                sway = self.sway(place, leg)
                if sway is not None:
                    yield sway

    def shift_of(self, place: Place, leg: int) -> tuple[float, float, float] | None:
        """g0, g and the inset kept when ``leg`` swings; None when it cannot."""
        twist, feet, exits, best = self.circular.twist, place.feet, place.exits, None
        i, j, k = OTHERS[leg]
        triangle = support_polygon((feet[i], feet[j], feet[k]))
        g_max = min(exits[i], exits[j], exits[k])  # H §5.2 (12)
        for inset in self.insets:
            low, high = stable_on_arc(triangle, *twist, inset)
            if low > high or high < 0.0 or low > min(g_max, exits[leg]):
                continue
            g0 = max(0.0, low)
            if g0 > 0.0:
                before, after = stable_on_arc(support_polygon(feet), *twist, -SLACK)
                if before > 0.0 or after < g0:
                    continue
            g = max(g0, min(g_max, high))
            if best is None or g - g0 > best[1] - best[0]:
                best = g0, g, inset
            if g - g0 >= self.useful:
                break
        return best

    def landings(self, place: Place, leg: int, g0: float, g: float, inset: float, first: bool) -> Iterator[Move]:
        """Where the foot may come down: by phase, and as far ahead as its stroke goes."""
        circular, exits = self.circular, place.exits
        before, farthest = circular.predecessor[leg], g + circular.stride
        phase = min(max(exits[before] - circular.spares[before] + circular.lags[leg], g), farthest)
        for wanted in (phase, farthest) if farthest - phase > 0.05 * circular.stride else (phase,):
            move = self.foothold(place, leg, g0, g, inset, wanted, first)
            if move is not None:
                yield move

    def foothold(self, place: Place, leg: int, g0: float, g: float, inset: float, wanted: float, first: bool) -> Move | None:
        """The point on the circular stroke that is left after ``wanted``, or the best of the free cells nearest to it."""
        circular, twist = self.circular, self.circular.twist
        start = carried(twist, *circular.centres[leg], wanted - circular.ends[leg])
        ax, ay = place.absolute(*start)
        fx, fy = place.feet[leg]
        if self.ground.allows(ax, ay) and self.fits(leg, g, start, (ax, ay), first) is not None:
            if g <= STILL and math.hypot(start[0] - fx, start[1] - fy) <= STILL:
                return None
            return Move(leg, g0, g, start, start, (ax, ay), inset)
        best, least, count = None, math.inf, 0
        for px, py, qx, qy, away in self.cells(place, (ax, ay)):
            left = self.fits(leg, g, (px, py), (qx, qy), first)
            if left is None or (g <= STILL and math.hypot(px - fx, py - fy) <= STILL):
                continue
            cost = away + max(0.0, wanted - g - left)
            if cost < least:
                best, least = Move(leg, g0, g, start, (px, py), (qx, qy), inset), cost
            count += 1
            if count >= CELLS_MAX:
                break
        return best

    def fits(self, leg: int, g: float, point: XY, at: XY, first: bool) -> float | None:
        """How far on from N_{k+1} a foothold stays in reach; None when it is not, or its height will not do."""
        x, y = self.circular.twist.seen(*point, g)
        box = self.circular.boxes[leg]
        if not (box[0] <= x <= box[1] and box[2] <= y <= box[3]):
            return None
        if first and self.rises.refuses(leg, g, at):
            return None
        return arc_exit(x, y, box, self.circular.twist)

    def cells(self, place: Place, around: XY) -> Iterator[tuple[float, float, float, float, float]]:
        """Free cells from the nearest on: centre in body axes, in the absolute frame, and how far away it is."""
        forbidden, rows, columns, cell, ox, oy = self.ground
        c, s = math.cos(place.yaw), math.sin(place.yaw)
        column, row = math.floor((around[0] - ox) / cell), math.floor((around[1] - oy) / cell)
        for dc, dr, away in _ring(cell):
            i, j = column + dc, row + dr
            if not (0 <= i < columns and 0 <= j < rows) or forbidden[j * columns + i]:
                continue
            qx, qy = ox + (i + 0.5) * cell, oy + (j + 0.5) * cell
            dx, dy = qx - place.x, qy - place.y
            yield c * dx + s * dy, c * dy - s * dx, qx, qy, away

    def sway(self, place: Place, leg: int) -> Move | None:
        """The shortest shift of the body on four legs after which ``leg`` can swing: for a useful way, else at all."""
        feet, twist = place.feet, self.circular.twist
        i, j, k = OTHERS[leg]
        triangle = support_polygon((feet[i], feet[j], feet[k]))
        if len(triangle) < 3:
            return None
        ahead = twist.pose(2.0 * self.useful)
        within = self._room(feet)
        for inset in self.insets:
            for reach in ((0.0, 0.0), ahead[:2]), ((0.0, 0.0),):
                corners = within
                for dx, dy in reach:
                    corners = _inside_of(corners, triangle, inset, dx, dy)
                if corners:
                    to = nearest_of(corners, 0.0, 0.0)
                    if math.hypot(*to) >= SWAY_MIN:
                        return Move(-1, 0.0, 0.0, to, to, place.absolute(*to), inset)
        return None

    def _room(self, feet: tuple[XY, ...]) -> list[XY]:
        """Where the body may be shifted to with every foot in reach: a rectangle, empty when a foot is out of reach."""
        x1, x2, y1, y2 = -math.inf, math.inf, -math.inf, math.inf
        for (fx, fy), box in zip(feet, self.circular.boxes, strict=True):
            x1, x2, y1, y2 = max(x1, fx - box[1]), min(x2, fx - box[0]), max(y1, fy - box[3]), min(y2, fy - box[2])
        return [(x1, y1), (x2, y1), (x2, y2), (x1, y2)] if x1 <= x2 and y1 <= y2 else []

    def after(self, place: Place, move: Move) -> tuple[Place, float]:
        """The posture at N_{k+1}, and the way gone less what could have been gone in the time: the cheap roll-out of one step."""
        if move.leg < 0:
            dx, dy = move.landing
            feet = tuple((fx - dx, fy - dy) for fx, fy in place.feet)
            return Place(*move.ground, place.yaw, feet, self.exits(feet), place.last, place.way, True), -math.hypot(dx, dy)
        twist = self.circular.twist
        dx, dy, turn = twist.pose(move.g)
        feet = tuple(twist.seen(*(move.landing if i == move.leg else foot), move.g) for i, foot in enumerate(place.feet))
        lost = max(0.0, self.full - (move.g - move.g0)) + (THIN_COST if move.inset < THIN else 0.0)
        return Place(*place.absolute(dx, dy), place.yaw + turn, feet, self.exits(feet), move.leg, place.way + move.g), move.g - lost


def _told(ways: list[Branch[Place, Move]]) -> list[dict[str, Any]]:
    """The search for the decision trace: each candidate's first step and how it scored."""
    return [
        {
            "leg": way.first.leg + 1 if way.first.leg >= 0 else None, "g0": way.first.g0, "g": way.first.g, "inset": way.first.inset,
            "landing": list(way.first.ground), "score": way.score, "gain": way.gain, "steps": way.steps,
        }
        for way in firsts(ways)
    ]  # fmt: skip


def _in_body(stance: Stance) -> tuple[XY, ...]:
    x, y, _, yaw = stance.body
    c, s = math.cos(yaw), math.sin(yaw)
    return tuple((c * (fx - x) + s * (fy - y), c * (fy - y) - s * (fx - x)) for fx, fy, _ in stance.feet)


def _inside_of(corners: list[XY], polygon: tuple[XY, ...], inset: float, dx: float, dy: float) -> list[XY]:
    """The part of a convex polygon whose points, moved by (dx, dy), are inside another by ``inset``."""
    ax, ay = polygon[-1]
    for bx, by in polygon:
        ex, ey = bx - ax, by - ay
        length = math.hypot(ex, ey)
        nx, ny = -ey / length, ex / length
        if corners:
            corners = clipped(corners, nx, ny, nx * (dx - ax) + ny * (dy - ay) - inset)
        ax, ay = bx, by
    return corners


@lru_cache(maxsize=16)
def _ring(cell: float) -> tuple[tuple[int, int, float], ...]:
    """Columns and rows away from a cell, and how far, from the nearest on."""
    count = math.floor(FAR_ENOUGH / cell)
    steps = [(c, r, math.hypot(c, r) * cell) for c in range(-count, count + 1) for r in range(-count, count + 1)]
    return tuple(sorted((step for step in steps if step[2] <= FAR_ENOUGH), key=lambda step: (step[2], step)))


def _swing_time(machine: Machine, gait: Gait, circular: Circular) -> float:
    """s a swing of the standard walk takes at the legs' limits, about."""
    reach = circular.stride * (1.0 + circular.swing_share)
    rates = [_rate(circular.twist, x, y) for x, y in circular.centres]
    fastest = max(max(rx / machine.speed[0], ry / machine.speed[1]) for rx, ry in rates)
    return gait.peak * ((gait.lift_up + gait.lift_down) / machine.speed[2] + reach * fastest)


def _rate(twist: Twist, x: float, y: float) -> XY:
    """How fast a standing foot at (x, y) goes in body axes, per metre of s."""
    return abs(twist.ux - twist.turn * y), abs(twist.uy + twist.turn * x)


class Rises:
    """Heights around one stance on an arc: Level B3."""

    def __init__(self, stance: Stance, circular: Circular, terrain: TerrainMap, machine: Machine, gait: Gait) -> None:
        self.stance, self.circular, self.terrain, self.machine, self.gait = stance, circular, terrain, machine, gait
        self.is_level = terrain.is_level and all(abs(foot[2] - terrain.highest) < 0.005 for foot in stance.feet)

    def ground_at(self, at: XY) -> float:
        """Height of a foothold, m."""
        return self.terrain.highest if self.is_level else self.terrain.height_at(*at)

    def height_after(self, leg: int, g0: float, g: float, at: XY) -> tuple[float, float, float]:
        """Height of the CoG at N_{k+1}, and the lowest and highest it may be: towards H above the mean of the feet."""
        z, heights = self.stance.body[2], [foot[2] for foot in self.stance.feet]
        before = heights[leg]
        heights[leg] = self.ground_at(at)
        low, high = height_range(self.machine, heights)
        if g0 > 0.0:
            bottom, top = height_range(self.machine, [before])
            low, high = max(low, z + (bottom - z) * g / g0), min(high, z + (top - z) * g / g0)
        change = min(max(sum(heights) / 4 + self.gait.height - z, -CLIMB * g), CLIMB * g)
        return min(max(z + change, low), high), low, high

    def refuses(self, leg: int, g: float, at: XY) -> bool:
        """True when a foothold cannot be used for its height."""
        if self.is_level:
            return False
        ground = self.ground_at(at)
        if ground != ground:
            return True
        height, low, high = self.height_after(leg, 0.0, g, at)
        return low > high or self.crest(leg, at) + CLEARANCE > self.ceiling(height)

    def crest(self, leg: int, at: XY) -> float:
        """Highest ground under the way of the swing foot, m."""
        x, y, z = self.stance.feet[leg]
        return max(z, self.ground_at(at)) if self.is_level else max(z, self.ground_at(at), self.terrain.crest_between(x, y, *at))

    def ceiling(self, height: float) -> float:
        """How high a foot can be lifted in this step, m."""
        return min(self.stance.body[2], height) + self.machine.z_range[1] + self.machine.overreach[2]

    def torso_needs(self, x: float, y: float, yaw: float, height: float) -> float:
        """Lowest CoG at which the torso clears the ground there, m."""
        if self.terrain.highest + self.machine.torso[2] / 2 + CLEARANCE <= height:
            return -math.inf
        needs = torso_needs(self.terrain, self.machine, x, y, yaw)
        return needs if needs <= height else torso_needs_exactly(self.terrain, self.machine, x, y, yaw)


def turns(command: Command, machine: Machine) -> bool:
    """True when the course of a command bends enough to be an arc."""
    pace = math.hypot(command.speed, machine.yaw_length * command.turn_rate)
    return abs(command.turn_rate) > STRAIGHT * pace


def plan_turn(
    stance: Stance, command: Command, terrain: TerrainMap, machine: Machine, gait: Gait, *, explain: bool = False
) -> StepPlan | Blocked:
    """The next step of a turning walk from N_k, or why there is none."""
    thinking = think_turn(stance, command, terrain, machine, gait, explain=explain)
    while True:
        try:
            next(thinking)
        except StopIteration as done:
            answer: StepPlan | Blocked = done.value
            return answer


def think_turn(
    stance: Stance, command: Command, terrain: TerrainMap, machine: Machine, gait: Gait, *, explain: bool = False
) -> Thinking:
    """The same, thought through piece by piece; always to the end, a few ticks of standing at most."""
    twist, pace = twist_of(command.crab_angle, command.speed, command.turn_rate, machine.yaw_length)
    circular = circular_gait(machine, gait, twist)
    notes: Notes | None = {"crab_angle": command.crab_angle, "turn": twist.turn, "stride": circular.stride} if explain else None
    outlook = Outlook(circular, stance, pace, terrain, machine, gait)
    stay = outlook.promise(outlook.root)
    answer: StepPlan | Blocked = Blocked("no sequence of swings and sways leads on along the arc", None, notes)
    for depth, width in (DEPTH, WIDTH), (FAR_DEPTH, FAR_WIDTH):
        found = yield from _patiently(outlook.look(depth, width))
        if notes is not None:
            notes["candidates"] = _told(found.ways)
        for way in firsts(found.ways):
            if way.state.way < outlook.useful and outlook.promise(way.state) <= stay + STILL:
                continue  # no better than to stay
            plan = _sway(outlook, way.first, pace, notes) if way.first.leg < 0 else _swing(outlook, way.first, command, pace, notes)
            if isinstance(plan, StepPlan):
                return plan
            answer = plan
        outlook.never_again = False
    return answer


def _patiently(search: Search[Place, Move]) -> Generator[None, bool | None, Found[Place, Move]]:
    """The search without hurry: half of it knows no better than to stay, and a walk of such answers never ends."""
    while True:
        try:
            next(search)
        except StopIteration as done:
            found: Found[Place, Move] = done.value
            return found
        yield


def _sway(outlook: Outlook, move: Move, pace: float, notes: Notes | None) -> StepPlan:
    """The body shifted on four legs, level and without turning."""
    stance, circular = outlook.stance, outlook.circular
    machine, gait = outlook.machine, outlook.gait
    (x, y), (_, _, z, yaw) = move.ground, stance.body
    cruise = _cruise(machine, gait, circular)
    speed = min(pace, cruise) if pace > 0.0 else cruise
    dx, dy = move.landing
    way = math.hypot(dx, dy)
    times = np.array([0.0, way / speed])
    body = np.array([stance.body, (x, y, z, yaw)])
    feet = np.array([stance.feet, stance.feet])
    for array in (times, body, feet):
        array.setflags(write=False)
    polygon = support_polygon(_in_body(stance))
    return StepPlan(
        swing=(), times=times, body=body, feet=feet, phases=(Phase.SHIFT,),
        end=Stance((x, y, z, yaw), stance.feet, stance.last_swing, stance.quarter_turns, (), stance.course, stance.still + 1),
        crab_angle=math.atan2(dy, dx), standard_margin=circular.margin,
        margin_min=min(polygon_margin(polygon, 0.0, 0.0), polygon_margin(polygon, dx, dy)),
        speed=speed, speed_max=cruise, decision=notes,
    )  # fmt: skip


def _cruise(machine: Machine, gait: Gait, circular: Circular) -> float:
    """About the pace of the standard walk on the arc at the legs' limits, m/s."""
    return circular.swing_share * circular.stride / _swing_time(machine, gait, circular)


class Clock(NamedTuple):
    """The clock of a step on an arc: ds/dt in m/s, durations in s."""

    speed: float
    speed_max: float
    support_speed: float
    support: float
    up: float
    back: float
    down: float


def _swing(outlook: Outlook, move: Move, command: Command, pace: float, notes: Notes | None) -> StepPlan | Blocked:
    """The plan of a swing the search decided on."""
    stance, circular, rises = outlook.stance, outlook.circular, outlook.rises
    machine, gait, leg = outlook.machine, outlook.gait, move.leg
    x, y, _, yaw = stance.body
    dx, dy, turn = circular.twist.pose(move.g)
    c, s = math.cos(yaw), math.sin(yaw)
    end_x, end_y, end_yaw = x + c * dx - s * dy, y + s * dx + c * dy, yaw + turn
    height, _, high = rises.height_after(leg, move.g0, move.g, move.ground)
    needs = rises.torso_needs(end_x, end_y, end_yaw, height)
    if needs > height:
        if needs > high:
            return Blocked(f"the torso would touch the ground: it needs {needs:.2f} m, the legs reach {high:.2f} m", None, notes)
        height = needs
    landing: Point = (*move.ground, rises.ground_at(move.ground))
    corners = lift(stance.feet[leg], landing, rises.crest(leg, move.ground), rises.ceiling(height), height, machine, gait)
    path = ArcPath(stance, circular.twist, move.g0, move.g, height)
    clock = _clock(outlook, move, path, corners, pace)
    times, body, feet, phases = _knots(path, clock, corners, leg, gait.smooth)
    still = 0 if move.g >= outlook.useful else stance.still + 1
    ends = tuple(landing if i == leg else foot for i, foot in enumerate(stance.feet))
    start_x, start_y = (x + c * move.start[0] - s * move.start[1], y + s * move.start[0] + c * move.start[1])
    return StepPlan(
        swing=(leg,), times=times, body=body, feet=feet, phases=phases,
        end=Stance((end_x, end_y, height, end_yaw), ends, leg, stance.quarter_turns, (), stance.course + move.g, still),
        crab_angle=command.crab_angle, support_shift=move.g0, shift=move.g,
        standard_margin=circular.margin, margin_min=_margin(path, stance, leg),
        speed=clock.speed, speed_max=clock.speed_max,
        search_start=(start_x, start_y, landing[2]), landing=landing, decision=notes,
    )  # fmt: skip


class ArcPath:
    """The body's way through one step: the arc, and the height in proportion to the way."""

    def __init__(self, stance: Stance, twist: Twist, g0: float, g: float, height: float) -> None:
        self.stance, self.twist, self.g0, self.g = stance, twist, g0, g
        self.x, self.y, self.z, self.yaw = stance.body
        self.c, self.s = math.cos(self.yaw), math.sin(self.yaw)
        self.climb = height - self.z

    def at(self, way: float, waited: float = 0.0) -> tuple[float, float, float, float]:
        """The body after ``way``; ``waited`` is the share of the swing over, by which a body that waits changes height."""
        dx, dy, turn = self.twist.pose(way)
        share = way / self.g if self.g > STILL else waited
        return self.x + self.c * dx - self.s * dy, self.y + self.s * dx + self.c * dy, self.z + share * self.climb, self.yaw + turn

    def seen(self, point: Point, way: float, waited: float = 0.0) -> Point:
        """A point of the absolute frame in body axes."""
        x, y, z, yaw = self.at(way, waited)
        c, s = math.cos(yaw), math.sin(yaw)
        return c * (point[0] - x) + s * (point[1] - y), c * (point[1] - y) - s * (point[0] - x), point[2] - z


def absolute(body: tuple[float, float, float, float], point: Point) -> Point:
    """A point in body axes in the absolute frame."""
    x, y, z, yaw = body
    c, s = math.cos(yaw), math.sin(yaw)
    return x + c * point[0] - s * point[1], y + s * point[0] + c * point[1], z + point[2]


def _margin(path: ArcPath, stance: Stance, leg: int) -> float:
    """Least polygon margin of a step, looked at along it."""
    feet = _in_body(stance)
    least = math.inf
    for polygon, low, high in (
        (support_polygon(feet), 0.0, path.g0),
        (support_polygon([foot for i, foot in enumerate(feet) if i != leg]), path.g0, path.g),
    ):
        for k in range(5):
            dx, dy, _ = path.twist.pose(low + k / 4 * (high - low))
            least = min(least, polygon_margin(polygon, dx, dy))
    return least


def _clock(outlook: Outlook, move: Move, path: ArcPath, corners: Swing, pace: float) -> Clock:
    """The fastest clock that keeps every limit, or the commanded pace: H §7 with the displacement taken in turning body axes."""
    machine, gait, circular = outlook.machine, outlook.gait, outlook.circular
    vx, vy, vz = (ROUNDING * limit / gait.peak for limit in machine.speed)
    stand, top, over, aim = corners
    g_u = move.g - move.g0
    climbs = abs(path.climb) / move.g if move.g > STILL else 0.0

    def swing(v: float) -> tuple[float, float, float]:
        """Durations of up, return and down at the legs' limits when the body goes at v."""
        left = max(vz - v * climbs, 0.2 * vz)
        up, down = (top[2] - stand[2]) / left, (over[2] - aim[2]) / left
        ax, ay, az = path.seen(top, min(move.g0 + v * up, move.g))
        bx, by, bz = path.seen(over, max(move.g - v * down, move.g0), 1.0)
        return up, max(BACK_MIN, abs(bx - ax) / vx, abs(by - ay) / vy, abs(bz - az) / left), down

    cruise = _cruise(machine, gait, circular)
    wanted = pace if pace > 0.0 else cruise
    if g_u <= STILL:
        up, back, down = swing(0.0)
        speed = min(wanted, cruise)
        return Clock(0.0, 0.0, speed, move.g0 / speed, up, back, down)
    box, twist = circular.far_boxes[move.leg], circular.twist
    behind = arc_exit(*twist.seen(*_in_body(outlook.stance)[move.leg], move.g0), box, twist)
    landed = twist.seen(*move.landing, move.g)
    beyond = arc_exit(*landed, box, reversed_course(twist))
    drift = max(*_rate(twist, *landed), 1e-9)
    standing = _standing(outlook, climbs)

    def holds(v: float) -> bool:
        up, back, down = swing(v)
        early = v * down * drift / 2 <= EARLY
        return v * (up + back + down) <= g_u and v * up <= max(behind, EARLY / 2) and v * down <= max(beyond, EARLY / 2) and early

    low, high = 0.0, min(standing, g_u / sum(swing(0.0)) * 2.0)
    for _ in range(24):
        middle = (low + high) / 2
        low, high = (middle, high) if holds(middle) else (low, middle)
    v = min(low, wanted)
    up, _, down = swing(v)
    support_speed = max(v, min(wanted, cruise, standing))
    return Clock(v, low, support_speed, move.g0 / support_speed, up, g_u / v - up - down, down)


def _standing(outlook: Outlook, climbs: float) -> float:
    """The largest pace at which standing legs keep their limits."""
    machine, twist = outlook.machine, outlook.circular.twist
    fastest = max(climbs / (0.5 * machine.speed[2]), 1e-9)
    for x1, x2, y1, y2 in outlook.circular.far_boxes:
        for x, y in ((x1, y1), (x1, y2), (x2, y1), (x2, y2)):
            rx, ry = _rate(twist, x, y)
            fastest = max(fastest, rx / machine.speed[0], ry / machine.speed[1])
    return ROUNDING / fastest


Knots = tuple[Array, Array, Array, tuple[Phase, ...]]


def _knots(path: ArcPath, clock: Clock, corners: Swing, leg: int, smooth: bool) -> Knots:
    """The step as knots: up and down vertical in the absolute frame, the return a straight line in the turning body axes."""
    stand, top, over, aim = corners
    g0, g = path.g0, path.g
    total = clock.up + clock.back + clock.down
    rows: list[tuple[float, tuple[float, float, float, float], Point]] = [(0.0, path.at(0.0), stand)]
    phases: list[Phase] = []
    for k in range(1, (pieces := _pieces(path.twist, g0)) + 1 if g0 > STILL else 1):
        rows.append((clock.support * k / pieces, path.at(g0 * k / pieces), stand))
        phases.append(Phase.SUPPORT)
    begin, way, spent = rows[-1][0], g0, 0.0
    for phase, duration, a, b in (
        (Phase.UP, clock.up, stand, top),
        (Phase.RETURN, clock.back, top, over),
        (Phase.DOWN, clock.down, over, aim),
    ):
        if duration <= 0.0:
            continue
        gone = (g - g0) * duration / total
        share = duration / total
        from_b, to_b = path.seen(a, way, spent), path.seen(b, way + gone, spent + share)
        for tau, eased in _profile(smooth, _pieces(path.twist, gone)):
            body = path.at(way + tau * gone, spent + tau * share)
            if phase is Phase.RETURN:
                foot = absolute(body, _between(from_b, to_b, eased))
            else:
                foot = a[0], a[1], a[2] + eased * (b[2] - a[2])
            rows.append((begin + tau * duration, body, foot))
            phases.append(phase)
        begin, way, spent = begin + duration, way + gone, spent + share
        rows[-1] = begin, rows[-1][1], b
    rows[-1] = rows[-1][0], path.at(g, 1.0), aim
    return *_arrays(rows, path.stance.feet, leg), tuple(phases)


def _pieces(twist: Twist, way: float) -> int:
    """Into how many straight lines a stretch of an arc is cut."""
    return max(1, math.ceil(abs(twist.turn) * way / KNOT_TURN))


def _profile(smooth: bool, pieces: int) -> Iterator[tuple[float, float]]:
    """Share of the time and of the way: the stairs of speed, cut finely enough."""
    before, done = 0.0, 0.0
    for tau, eased in EASED if smooth else EVEN:
        count = max(1, math.ceil(pieces * (tau - before)))
        for k in range(1, count + 1):
            yield before + (tau - before) * k / count, done + (eased - done) * k / count
        before, done = tau, eased


def _between(a: Point, b: Point, share: float) -> Point:
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])


def _arrays(
    rows: list[tuple[float, tuple[float, float, float, float], Point]], feet: tuple[Point, ...], leg: int
) -> tuple[Array, Array, Array]:
    """Knots as write-protected arrays."""
    times, body = np.array([row[0] for row in rows]), np.array([row[1] for row in rows])
    paths = np.broadcast_to(np.array(feet), (len(rows), len(feet), 3)).copy()
    paths[:, leg] = [row[2] for row in rows]
    for array in (times, body, paths):
        array.setflags(write=False)
    return times, body, paths
