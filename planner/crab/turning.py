"""Level B2 while the torso turns (H §5 with circles for lines): who swings, how far, where the foot
comes down.

The course is a course of constant curvature, down to a turn on the spot. What the paper settles by rule
on a straight course is searched for here: sequences of swings and of sways (the body shifted on
four legs) are grown a few steps deep, always the most promising ones, and the first step of the
best is taken. Each swing is the paper's: g0 until the triangle carries, g as far as it carries and
every standing leg reaches, the foot put where it leaves its stroke later than u* by the standard
phase difference. Bounded by count; no memory, so it takes over from any posture of a straight walk
and hands any back.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

from ..geometry.paths import arc_exit, arc_of_command
from ..protocols import PlanningJob, run_to_completion
from ..robot.model import Machine
from ..search import Option, Search, beam, firsts, uninterruptible
from ..stability import XY, stable_on_arc, support_polygon
from ..terrain.map import TerrainMap
from ..types import Blocked, Command, Gait, Stance, StepPlan
from . import turning_log
from .arcplan import EARLY, Move, Rises, in_body, sway_plan, swing_plan
from .arcs import Circular, carried, circular_gait
from .foothold_search import Ground, clipped, ground_of, nearest_of
from .gait import OTHERS
from .leg_selection import SLACK, STILL, Notes

# rad per m of s; a course that bends less, one of a kilometre's radius, is walked straight
STRAIGHT = 1e-3
# steps a sequence is long, sequences kept, and for how many of its steps feet may come down
# anywhere in reach
LOOKS = (
    (6, 6, 0),  # less: see it sway where a swing would do
    (9, 16, 0),  # each of these when the one before finds no way on
    # without: see it stand for good after a turn of mind, its legs at the edges of their reach
    (8, 32, 1),
    (6, 128, 2),
)
# of the reach, along and across: where feet are tried when they may come down anywhere
ANYWHERE = (0.02, 0.5, 0.98)
INSET = 0.03  # m from every edge of the triangle, where the standard walk has so much
INSET_SHARE = 0.6  # of the least margin of the standard walk, where it has less
# m; an inset every swing keeps where it can, and one it keeps always; none: see the torso tip as a
# foot lifts
THIN, BARE = 0.004, 0.001
THIN_COST = 0.15  # m of course a swing without it is held to lose
# of the standard swing's way; a swing that moves the body less is looked at with no inset, and
# beside sways
USEFUL = 0.5
FAR_ENOUGH = 0.45  # m around I_u in which footholds are looked for
CELLS_MAX = 4  # footholds compared
# steps without a useful way after which the way that gets on soonest is taken; else see it go to
# and fro
STILL_MAX = 2
HURRY = 10.0  # m such a way is held to gain over one that never gets on; more than any way loses
HURRIED = 2  # the look it begins with
SWAY_MIN = 0.002  # m; a shorter sway is none
# of what the legs lack of the standard phases, m of progress per m; 0: see legs bunch up and sway
PHASE_WEIGHT = 0.25


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


class Outlook:
    """One search for the next step of a turn from one stance."""

    def __init__(
        self, circular: Circular, stance: Stance, terrain: TerrainMap, machine: Machine, gait: Gait
    ) -> None:
        self.circular, self.stance, self.terrain, self.machine, self.gait = (
            circular,
            stance,
            terrain,
            machine,
            gait,
        )
        self.ground: Ground = ground_of(terrain)
        self.rises = Rises(stance, circular, terrain, machine, gait)
        self.full = circular.swing_share * circular.stride
        self.useful = USEFUL * self.full
        comfort = min(INSET, INSET_SHARE * circular.margin)
        self.insets = (comfort, THIN, BARE) if comfort > THIN else (THIN, BARE)
        x, y, _, yaw = stance.body
        feet = in_body(stance)
        self.root = Place(x, y, yaw, feet, self.exits(feet), stance.last_swing)
        self.hurries = stance.still >= STILL_MAX  # the way that gets on soonest is the best
        self.anywhere = 0  # steps in which feet may come down anywhere in reach

    def look(self, depth: int, width: int, anywhere: int = 0) -> Search[Place, Move]:
        """The ways on, best first: way gone, less what was lost on it, less what the legs lack of
        the standard phases.
        """
        self.anywhere = anywhere
        return beam(self.root, self.options, depth, width)

    def options(self, place: Place, depth: int) -> Iterator[Option[Place, Move]]:
        """Every next step worth looking at, for the beam."""
        for move in self.moves(place, depth):
            after, gain = self.after(place, move)
            if self.hurries and place.way < self.useful <= after.way:
                gain += HURRY / (1 + depth)
            yield Option(move, after, gain, self.promise(after))

    def promise(self, place: Place) -> float:
        """Minus what the legs' exits lack of those in the standard walk after the same leg has
        landed, m.
        """
        layouts = (self.circular.layouts[place.last],) if place.last >= 0 else self.circular.layouts
        lacks = min(
            sum(max(0.0, want - has) for want, has in zip(layout, place.exits, strict=True))
            for layout in layouts
        )
        return -PHASE_WEIGHT * lacks

    def exits(self, feet: tuple[XY, ...]) -> tuple[float, ...]:
        """g_i of every leg on the arc."""
        return tuple(
            arc_exit(fx, fy, box, self.circular.arc, EARLY)
            for (fx, fy), box in zip(feet, self.circular.boxes, strict=True)
        )

    # what can be done next

    def moves(self, place: Place, depth: int) -> Iterator[Move]:
        """Swings of every leg but the last, sways where swings do little; the last leg again when
        nothing else is left.
        """
        first, found, stuck = depth == 0, False, []
        for leg in range(4):
            shift = self.shift_of(place, leg) if leg != place.last else None
            if shift is not None:
                for move in self.landings(place, leg, *shift, depth):
                    found = True
                    yield move
            if shift is None or shift[1] - shift[0] < self.useful:
                stuck.append(leg)
        if not found and place.last >= 0:
            shift = self.shift_of(place, place.last)
            if shift is not None:
                for move in self.landings(place, place.last, *shift, depth):
                    found = True
                    yield move
        if not found or (not place.swayed and (first or depth < self.anywhere or len(stuck) == 4)):
            for leg in stuck:
                sway = self.sway(place, leg)
                if sway is not None:
                    yield sway

    def shift_of(self, place: Place, leg: int) -> tuple[float, float, float] | None:
        """g0, g and the inset kept when ``leg`` swings; None when it cannot."""
        arc, feet, exits, best = self.circular.arc, place.feet, place.exits, None
        i, j, k = OTHERS[leg]
        triangle = support_polygon((feet[i], feet[j], feet[k]))
        g_max = min(exits[i], exits[j], exits[k])  # H §5.2 (12)
        for inset in self.insets:
            low, high = stable_on_arc(triangle, *arc, inset)
            if low > high or high < 0.0 or low > min(g_max, exits[leg]):
                continue
            g0 = max(0.0, low)
            if g0 > 0.0:
                before, after = stable_on_arc(support_polygon(feet), *arc, -SLACK)
                if before > 0.0 or after < g0:
                    continue
            g = max(g0, min(g_max, high))
            if best is None or g - g0 > best[1] - best[0]:
                best = g0, g, inset
            if g - g0 >= self.useful:
                break
        return best

    def landings(
        self, place: Place, leg: int, g0: float, g: float, inset: float, depth: int
    ) -> Iterator[Move]:
        """Where the foot may come down: by phase, as far ahead as its stroke goes, and, when
        nothing else leads on, anywhere.
        """
        circular, exits, arc = self.circular, place.exits, self.circular.arc
        before, farthest = circular.predecessor[leg], g + circular.stride
        phase = min(max(exits[before] - circular.spares[before] + circular.lags[leg], g), farthest)
        starts = []
        for wanted in (phase, farthest) if farthest - phase > 0.05 * circular.stride else (phase,):
            starts.append(
                (carried(arc, *circular.centres[leg], wanted - circular.ends[leg]), wanted)
            )
        if depth < self.anywhere:
            x1, x2, y1, y2 = circular.boxes[leg]
            starts += [
                (carried(arc, x1 + u * (x2 - x1), y1 + v * (y2 - y1), g), 0.0) for u in ANYWHERE for v in ANYWHERE
            ]  # fmt: skip
        for start, wanted in starts:
            move = self.foothold(
                place, leg, Move(leg, g0, g, start, start, start, inset), wanted, depth == 0
            )
            if move is not None:
                yield move

    def foothold(
        self, place: Place, leg: int, swing: Move, wanted: float, first: bool
    ) -> Move | None:
        """I_u itself, or the best of the free cells nearest to it: near, and left no sooner than
        ``wanted``.
        """
        g, start = swing.g, swing.start
        ax, ay = place.absolute(*start)
        fx, fy = place.feet[leg]
        if self.ground.allows(ax, ay) and self.fits(leg, g, start, (ax, ay), first) is not None:
            if g <= STILL and math.hypot(start[0] - fx, start[1] - fy) <= STILL:
                return None
            return swing._replace(ground=(ax, ay))
        best, least, count = None, math.inf, 0
        for px, py, qx, qy, away in self.cells(place, (ax, ay)):
            left = self.fits(leg, g, (px, py), (qx, qy), first)
            if left is None or (g <= STILL and math.hypot(px - fx, py - fy) <= STILL):
                continue
            cost = away + max(0.0, wanted - g - left)
            if cost < least:
                best, least = swing._replace(landing=(px, py), ground=(qx, qy)), cost
            count += 1
            if count >= CELLS_MAX:
                break
        return best

    def fits(self, leg: int, g: float, point: XY, at: XY, first: bool) -> float | None:
        """How far on from N_{k+1} a foothold stays in reach; None when it is not, or its height
        will not do.
        """
        x, y = self.circular.arc.seen(*point, g)
        box = self.circular.boxes[leg]
        if not (box[0] <= x <= box[1] and box[2] <= y <= box[3]):
            return None
        if first and self.rises.refuses(leg, g, at):
            return None
        return arc_exit(x, y, box, self.circular.arc)

    def cells(
        self, place: Place, around: XY, every: bool = False
    ) -> Iterator[tuple[float, float, float, float, float]]:
        """Free cells (or ``every`` one) from the nearest on: centre in body axes, in the absolute
        frame, and how far away it is.
        """
        forbidden, rows, columns, cell, ox, oy = self.ground
        c, s = math.cos(place.yaw), math.sin(place.yaw)
        column, row = math.floor((around[0] - ox) / cell), math.floor((around[1] - oy) / cell)
        for dc, dr, away in _ring(cell):
            i, j = column + dc, row + dr
            if not (0 <= i < columns and 0 <= j < rows) or (
                forbidden[j * columns + i] and not every
            ):
                continue
            qx, qy = ox + (i + 0.5) * cell, oy + (j + 0.5) * cell
            dx, dy = qx - place.x, qy - place.y
            yield c * dx + s * dy, c * dy - s * dx, qx, qy, away

    def sway(self, place: Place, leg: int) -> Move | None:
        """The shortest shift of the body on four legs after which ``leg`` can swing: for a useful
        way, else at all.
        """
        feet, arc = place.feet, self.circular.arc
        i, j, k = OTHERS[leg]
        triangle = support_polygon((feet[i], feet[j], feet[k]))
        if len(triangle) < 3:
            return None
        ahead = arc.pose(2.0 * self.useful)
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
        """Where the body may be shifted to with every foot in reach, or no farther out of it than
        it is: a rectangle.
        """
        x1, x2, y1, y2 = -math.inf, math.inf, -math.inf, math.inf
        for (fx, fy), box in zip(feet, self.circular.boxes, strict=True):
            x1, x2, y1, y2 = (
                max(x1, fx - box[1]),
                min(x2, fx - box[0]),
                max(y1, fy - box[3]),
                min(y2, fy - box[2]),
            )
        x1, x2, y1, y2 = min(x1, 0.0), max(x2, 0.0), min(y1, 0.0), max(y2, 0.0)
        return [(x1, y1), (x2, y1), (x2, y2), (x1, y2)]

    def after(self, place: Place, move: Move) -> tuple[Place, float]:
        """The posture at N_{k+1}, and the way gone less what could have been gone in the time: the
        cheap roll-out of one step.
        """
        if move.leg < 0:
            dx, dy = move.landing
            feet = tuple((fx - dx, fy - dy) for fx, fy in place.feet)
            return Place(
                *move.ground, place.yaw, feet, self.exits(feet), place.last, place.way, True
            ), -math.hypot(dx, dy)
        arc = self.circular.arc
        dx, dy, turn = arc.pose(move.g)
        feet = tuple(
            arc.seen(*(move.landing if i == move.leg else foot), move.g)
            for i, foot in enumerate(place.feet)
        )
        lost = max(0.0, self.full - (move.g - move.g0)) + (THIN_COST if move.inset < THIN else 0.0)
        return Place(
            *place.absolute(dx, dy),
            place.yaw + turn,
            feet,
            self.exits(feet),
            move.leg,
            place.way + move.g,
        ), move.g - lost


def _inside_of(
    corners: list[XY], polygon: tuple[XY, ...], inset: float, dx: float, dy: float
) -> list[XY]:
    """The part of a convex polygon whose points, moved by (dx, dy), are inside another by
    ``inset``.
    """
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
    steps = [
        (c, r, math.hypot(c, r) * cell)
        for c in range(-count, count + 1)
        for r in range(-count, count + 1)
    ]
    return tuple(
        sorted((step for step in steps if step[2] <= FAR_ENOUGH), key=lambda step: (step[2], step))
    )


def turns(command: Command, machine: Machine) -> bool:
    """True when the course of a command bends enough to be an arc."""
    pace = math.hypot(command.speed, machine.yaw_length * command.turn_rate)
    return abs(command.turn_rate) > STRAIGHT * pace


def plan_turn(
    stance: Stance,
    command: Command,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    *,
    explain: bool = False,
) -> StepPlan | Blocked:
    """The next step of a turning walk from N_k, or why there is none."""
    return run_to_completion(think_turn(stance, command, terrain, machine, gait, explain=explain))


def think_turn(
    stance: Stance,
    command: Command,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    *,
    explain: bool = False,
) -> PlanningJob:
    """The same, thought through piece by piece; always to the end, a few ticks of standing at most."""
    arc, pace = arc_of_command(
        command.crab_angle, command.speed, command.turn_rate, machine.yaw_length
    )
    circular = circular_gait(machine, gait, arc)
    notes: Notes | None = (
        {"crab_angle": command.crab_angle, "turn": arc.turn, "stride": circular.stride}
        if explain
        else None
    )
    outlook = Outlook(circular, stance, terrain, machine, gait)
    rises, stay = outlook.rises, outlook.promise(outlook.root)
    answer: StepPlan | Blocked = Blocked(
        "no sequence of swings and sways leads on along the arc", None, notes
    )
    for depth, width, anywhere in LOOKS[HURRIED:] if outlook.hurries else LOOKS:
        # half a search knows no better than to stay, and a walk of such answers never ends
        found = yield from uninterruptible(outlook.look(depth, width, anywhere))
        if notes is not None:
            notes["lookahead"] = turning_log.weighed(found.ways, depth)
        for way in firsts(found.ways):
            if way.state.way < outlook.useful and (
                outlook.hurries or outlook.promise(way.state) <= stay + STILL
            ):
                continue  # no better than to stay
            plan: StepPlan | Blocked
            if notes is not None:
                notes["legs"] = turning_log.legs_tried(outlook, way.first)
                notes["domain"] = (
                    turning_log.searched(outlook, way.first) if way.first.leg >= 0 else None
                )
            if way.first.leg < 0:
                plan = sway_plan(rises, way.first, pace, notes)
            else:
                plan = swing_plan(rises, way.first, command, pace, outlook.useful, notes)
            if isinstance(plan, StepPlan):
                return plan
            answer = plan
    if notes is not None and "legs" not in notes:
        notes["legs"] = turning_log.legs_tried(outlook, None)
    return answer
