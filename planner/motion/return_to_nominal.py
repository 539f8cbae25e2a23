"""Back into the nominal layout: which leg goes to its place when, searched for and made into plans.

With the yaw held, the places of the body from which a set of feet is in reach are a rectangle in
body axes, and those over the support polygon a convex piece of it: whether a leg can be put
somewhere, and where the body goes for it, is a few cuts of a rectangle. The order of the legs is
searched for, bounded by count. One foot is in the air at a time, and the body waits meanwhile.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from ..geometry.paths import Box
from ..geometry.polygons import Polygon, inside_of, nearest_of
from ..geometry.transforms import XY, left_fold_sum, turned, turned_back
from ..robot.collision import leg_in_the_way
from ..robot.model import Machine
from ..stability import polygon_margin, support_polygon
from ..terrain.map import TerrainMap
from ..types import TICK, Blocked, Gait, Point, Reason, Stance, StepPlan
from .body_height import clears_all, torso_clearance
from .postures import STILL, PlanSequence, height_limits, in_the_air, shifted, standing_height
from .step_builder import FootWay, body_still_plan, changed, holding_plan
from .swing import CLEARANCE, STRETCHES, SwingCorners, lift, profile_of, swing_speeds

THERE = 0.01  # m; a foot this near its place stays; smaller: see feet lifted and put back
TORSO_LOOK = 0.05  # m of body shift between looks at the ground under the torso
# m from every edge of the support polygon as a foot lifts: the first that can be kept
INSETS = (0.03, 0.015, 0.005, 0.001)
GOAL_INSET = 0.005  # m of margin at least in the layout arrived at; less: see other cells taken
# places looked at for one order of the legs; far more than any standing posture on open ground
# takes
LOOKS_MAX = 600
CELLS_TRIED = 4  # cells tried for one foot, nearest to its place first

# pauses after each place looked at
SequenceJob = Generator[None, None, "PlanSequence | Blocked"]


class _Place(NamedTuple):
    """Where a foot may stand on the way: along the body's axes from the origin, and in the absolute
    frame, m.
    """

    u: float
    v: float
    at: Point
    box: Box  # that it must be in, seen from the body


class _LegMove(NamedTuple):
    """One leg to one place: the body goes to (u, v, z) first."""

    leg: int
    place: int  # index into the leg's places
    u: float
    v: float
    z: float
    margin: float  # m
    way: float  # m the body shifts for it


@dataclass(frozen=True, slots=True)
class _Task:
    """What is to be reached, from where, on what."""

    stance: Stance
    goal: Stance  # at the yaw of the stance
    terrain: TerrainMap
    machine: Machine
    gait: Gait

    @property
    def yaw(self) -> float:
        """rad, held throughout."""
        return self.stance.body[3]

    @property
    def start(self) -> XY:
        """The body now, along its axes."""
        return self.along(*self.stance.body[:2])

    @property
    def end(self) -> XY:
        """The body at the goal, along its axes."""
        return self.along(*self.goal.body[:2])

    def along(self, x: float, y: float) -> XY:
        """An absolute point along the body's axes."""
        return turned_back(x, y, self.yaw)

    def absolute(self, u: float, v: float) -> XY:
        """A point along the body's axes in the absolute frame."""
        return turned(u, v, self.yaw)

    def here(self, leg: int) -> _Place:
        """Where the foot is now; its box reaches as far as it already does: a step cut short may
        have left it a little outside.
        """
        foot = self.stance.feet[leg]
        x1, x2, y1, y2 = self.machine.boxes[leg]
        u, v = self.along(foot[0], foot[1])
        ahead = u - self.start[0]
        left = v - self.start[1]
        box = min(x1, ahead), max(x2, ahead), min(y1, left), max(y2, left)
        return _Place(u, v, foot, box)

    def place(self, leg: int, at: Point) -> _Place:
        """A foothold for a leg."""
        return _Place(*self.along(at[0], at[1]), at, self.machine.boxes[leg])


def return_to_nominal(
    stance: Stance,
    goal: Stance,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    crab_angle: float = 0.0,
) -> SequenceJob:
    """Every foot to its place in the layout ``goal``, one at a time, the body ending over it;
    ``Blocked`` when no order works.

    Where a foot may not stand it takes the nearest cell in reach of the body at the goal. ``goal``
    lies at the body's own yaw. The last plan's end remembers what the goal does (who swung last,
    quarter turns).
    """
    if stance.lifted:
        return in_the_air(stance)
    task = _Task(stance, goal, terrain, machine, gait)
    layouts = _Layouts(task)
    search = _OrderSearch(task, layouts)
    yield
    for targets in layouts.found():
        moves = yield from search.order(targets)
        if moves is not None:
            return _Sequence(task, crab_angle).plans(moves)
        if search.looks >= LOOKS_MAX:
            break
    if search.looks:
        return search.why
    return layouts.why


class _Layouts:
    """Where the feet are to stand: cells near their places in the goal."""

    def __init__(self, task: _Task) -> None:
        self.task = task
        self.why = Blocked(Reason.NO_FOOTHOLD_BACK)
        feet = task.stance.feet
        self.level = left_fold_sum(foot[2] for foot in feet) / len(feet)
        self.here = [task.here(leg) for leg in range(len(feet))]

    def found(self) -> Iterator[tuple[_Place, ...]]:
        """Sets of places for all feet, best first: all in their nearest, then one leg after the
        other in its next nearest.
        """
        task = self.task
        choices = [self.cells(leg) for leg in range(len(task.machine.legs))]
        for leg, cells in enumerate(choices):
            if not cells:
                self.why = Blocked(Reason.NO_FOOTHOLD_THERE, leg)
                return
        nearest = tuple(cells[0] for cells in choices)
        layouts = [nearest]
        for k in range(1, CELLS_TRIED):
            layouts += [
                (*nearest[:leg], cells[k], *nearest[leg + 1 :])
                for leg, cells in enumerate(choices)
                if len(cells) > k
            ]
        self.why = Blocked(Reason.NO_STANDING_BODY)
        for layout in layouts:
            low, high = height_limits([place.at for place in layout], task.machine)
            polygon = support_polygon([(place.u, place.v) for place in layout])
            if low <= high and polygon_margin(polygon, *task.end) >= GOAL_INSET:
                yield layout

    def cells(self, leg: int) -> list[_Place]:
        """Where one foot may stand, nearest to its place first: where it is, the place itself, or
        centres of cells; a few at most.
        """
        task = self.task
        gx, gy, _ = task.goal.feet[leg]
        here = self.here[leg]
        gu, gv = task.along(gx, gy)
        off = math.hypot(here.u - gu, here.v - gv) if self._fits(leg, here.at) else math.inf
        if off <= THERE:
            return [here]
        found: list[tuple[float, _Place]] = [(off, here)] if off < math.inf else []
        exact = gx, gy, task.terrain.height_at(gx, gy)
        if task.terrain.allows(gx, gy) and self._fits(leg, exact):
            found.append((0.0, task.place(leg, exact)))
        else:
            found += [(away, task.place(leg, at)) for away, at in self._centres(leg, gx, gy)]
        found.sort(key=lambda entry: (entry[0], entry[1].at))
        return [place for _, place in found[:CELLS_TRIED]]

    def pause(self, leg: int) -> tuple[_Place, ...]:
        """The middle of the leg's reach with the body at the goal: where a foot may pause to make
        room for others.
        """
        task = self.task
        bx, by = task.machine.legs[leg].centre
        x, y = task.absolute(task.end[0] + bx, task.end[1] + by)
        if task.terrain.allows(x, y):
            return (task.place(leg, (x, y, task.terrain.height_at(x, y))),)
        return tuple(task.place(leg, at) for _, at in self._centres(leg, x, y)[:1])

    def _centres(self, leg: int, gx: float, gy: float) -> list[tuple[float, Point]]:
        """The nearest centres of cells round a place that may be stepped on, with their distances,
        in rings of cells until no farther one can be nearer.
        """
        terrain = self.task.terrain
        x1, x2, y1, y2 = self.task.machine.boxes[leg]
        column = math.floor((gx - terrain.origin[0]) / terrain.cell)
        row = math.floor((gy - terrain.origin[1]) / terrain.cell)
        farthest = math.ceil(math.hypot(x2 - x1, y2 - y1) / terrain.cell)
        found: list[tuple[float, Point]] = []
        for ring in range(farthest + 1):
            if len(found) >= CELLS_TRIED:
                if sorted(found)[CELLS_TRIED - 1][0] <= (ring - 0.5) * terrain.cell:
                    break
            for k, m in _ring(ring):
                at = self._allowed(row + k, column + m)
                if at is not None and self._fits(leg, at):
                    found.append((math.hypot(at[0] - gx, at[1] - gy), at))
        return sorted(found)[:CELLS_TRIED]

    def _allowed(self, row: int, column: int) -> Point | None:
        """The centre of a cell that may be stepped on, None of any other."""
        terrain = self.task.terrain
        if not terrain.has_cell(row, column):
            return None
        if terrain.forbidden_bytes[row * terrain.columns + column]:
            return None
        x, y = terrain.centre(row, column)
        return x, y, terrain.height_at(x, y)

    def _fits(self, leg: int, at: Point) -> bool:
        """In the leg's control reach with the body at the goal, at a height it can stand at."""
        task = self.task
        x1, x2, y1, y2 = task.machine.boxes[leg]
        low, high = task.machine.legs[leg].z
        u, v = task.along(at[0], at[1])
        ahead = u - task.end[0]
        left = v - task.end[1]
        drop = at[2] - self.level - task.gait.height
        in_box = x1 - STILL <= ahead <= x2 + STILL and y1 - STILL <= left <= y2 + STILL
        return in_box and low <= drop <= high


class _OrderSearch:
    """In which order the legs are put into their places."""

    def __init__(self, task: _Task, layouts: _Layouts) -> None:
        self.task = task
        self.layouts = layouts
        self.looks = 0
        self.why = layouts.why

    def order(
        self, targets: tuple[_Place, ...]
    ) -> Generator[None, None, list[tuple[_LegMove, _Place]] | None]:
        """Depth first, the leg that needs the shortest shift first; a leg may pause in the middle
        of its reach on its way. None when there is no order.
        """
        here = self.layouts.here
        legs = range(len(targets))
        places = [(here[leg], targets[leg], *self.layouts.pause(leg)) for leg in legs]
        first = tuple(1 if targets[leg] is here[leg] else 0 for leg in legs)
        body = (*self.task.start, self.task.stance.body[2])
        seen = {first}
        path: list[tuple[_LegMove, _Place]] = []
        trail = [first]
        waiting = [(yield from self._moves(first, places, body))]
        while waiting:
            there = enumerate(trail[-1])
            if all(index == 1 or targets[leg] is here[leg] for leg, index in there):
                return path
            if not waiting[-1] or self.looks >= LOOKS_MAX:
                waiting.pop()
                trail.pop()
                if path:
                    path.pop()
                continue
            move = waiting[-1].pop(0)
            after = (*trail[-1][: move.leg], move.place, *trail[-1][move.leg + 1 :])
            if after in seen:
                continue
            seen.add(after)
            path.append((move, places[move.leg][move.place]))
            trail.append(after)
            waiting.append((yield from self._moves(after, places, (move.u, move.v, move.z))))
        return None

    def _moves(
        self, state: tuple[int, ...], places: list[tuple[_Place, ...]], body: Point
    ) -> Generator[None, None, list[_LegMove]]:
        """What can be done next, straight to the targets first, the shorter shift first."""
        found: list[_LegMove] = []
        feet = [places[leg][index] for leg, index in enumerate(state)]
        for leg, index in enumerate(state):
            for goal in range(1, len(places[leg])):
                if index == 1 or goal == index:
                    continue
                self.looks += 1
                move = self._look(leg, goal, feet, places[leg][goal], body)
                yield
                if isinstance(move, _LegMove):
                    found.append(move)
                else:
                    self.why = Blocked(Reason.NO_WAY_BACK, leg, facts={"because": move})
        return sorted(found, key=lambda move: (move.place, round(move.way, 6), move.leg))

    def _look(
        self, leg: int, goal: int, feet: list[_Place], to: _Place, body: Point
    ) -> _LegMove | str:
        """The body's way and the swing for one leg from here, or why it cannot be."""
        reach = _rectangle([*feet, to])
        if reach is None:
            return "the feet are too far apart for the body to reach them all"
        polygon = support_polygon([(place.u, place.v) for k, place in enumerate(feet) if k != leg])
        over = (inside_of(reach, polygon, inset) for inset in INSETS if len(polygon) > 2)
        area = next((found for found in over if found), None)
        if area is None:
            return "the centre of gravity cannot be brought over the other feet"
        u, v = nearest_of(area, body[0], body[1])
        low, high = self._heights(leg, feet, to)
        if low > high:
            between = "for a foot to be lifted over the ground between"
            return f"the feet stand too high and too low {between}"
        low = max(low, self._torso_on_the_way(body, u, v))
        if low > high:
            return "the torso would touch the ground"
        z = min(max(body[2], low), high)
        if self._meets(leg, feet, to, (u, v, z)):
            return "a leg would run into something tall"
        way = math.hypot(u - body[0], v - body[1])
        return _LegMove(leg, goal, u, v, z, polygon_margin(polygon, u, v), way)

    def _heights(self, leg: int, feet: list[_Place], to: _Place) -> tuple[float, float]:
        """Lowest and highest CoG from which all feet are in reach, the new one too, and the lift
        over the ground between clears it, m; low > high when there is none.
        """
        task = self.task
        machine = task.machine
        ax, ay, az = feet[leg].at
        bx, by, bz = to.at
        crest = max(az, bz, task.terrain.crest_between(ax, ay, bx, by))
        stand_low, stand_high = height_limits([foot.at for foot in feet], machine)
        z_low, z_high = machine.legs[leg].z
        lifted = crest + CLEARANCE - z_high - machine.overreach[2]
        return max(stand_low, bz - z_high, lifted), min(stand_high, bz - z_low)

    def _torso_on_the_way(self, body: Point, u: float, v: float) -> float:
        """Lowest CoG that clears the ground all the way from here to (u, v), m."""
        task = self.task
        z = body[2]
        if clears_all(task.terrain, task.machine, z):
            return -math.inf
        count = max(1, math.ceil(math.hypot(u - body[0], v - body[1]) / TORSO_LOOK))
        needs = []
        for k in range(1, count + 1):
            w = k / count
            x, y = task.absolute(body[0] + w * (u - body[0]), body[1] + w * (v - body[1]))
            needs.append(torso_clearance(task.terrain, task.machine, x, y, task.yaw, z))
        return max(needs)

    def _meets(self, leg: int, feet: list[_Place], to: _Place, body: Point) -> bool:
        """True when some leg meets ground beside it, before the swing or after it."""
        task = self.task
        if task.terrain.is_level:
            return False
        pose = (*task.absolute(body[0], body[1]), body[2], task.yaw)
        before: list[Point | None] = [place.at for place in feet]
        after: list[Point | None] = [to.at if k == leg else None for k in range(len(feet))]
        return any(
            leg_in_the_way(task.terrain, task.machine, pose, points) is not None
            for points in (before, after)
        )


class _Sequence:
    """The moves as plans."""

    def __init__(self, task: _Task, crab_angle: float) -> None:
        self.task = task
        self.crab_angle = crab_angle
        self.now = task.stance
        self.done: list[StepPlan] = []

    def plans(self, moves: list[tuple[_LegMove, _Place]]) -> PlanSequence:
        """The sequence with its times; the last plan ends over the layout, at the height of a
        standing machine.
        """
        task = self.task
        for move, place in moves:
            x, y = task.absolute(move.u, move.v)
            self._shift((x, y, move.z))
            self._swing(move.leg, place.at, move.margin)
        gx, gy, _, yaw = task.goal.body
        feet = self.now.feet
        z = standing_height(feet, task.terrain, task.machine, task.gait, (gx, gy, yaw))
        self._shift((gx, gy, z))
        goal = task.goal
        end = replace(
            self.now, last_swing=goal.last_swing, quarter_turns=goal.quarter_turns, still=0
        )
        if not self.done:
            return (changed(holding_plan(self.now), end=end, crab_angle=self.crab_angle),)
        self.done[-1] = changed(self.done[-1], end=end)
        return tuple(self.done)

    def _shift(self, to: Point) -> None:
        """The body to a place: up before it goes, down after."""
        x, y, z, _ = self.now.body
        px, py, pz = to
        first = (x, y, pz) if pz > z else (px, py, z)
        polygon = support_polygon(self.now.feet)
        margin = min(polygon_margin(polygon, x, y), polygon_margin(polygon, px, py))
        for plan in shifted(self.now, (first, to), self.task.machine, self.task.gait):
            self._add(plan, margin)

    def _swing(self, leg: int, landing: Point, margin: float) -> None:
        """One foot up, over the crest of the ground and down, the body where it is."""
        task = self.task
        machine = task.machine
        foot = self.now.feet[leg]
        z = self.now.body[2]
        between = task.terrain.crest_between(foot[0], foot[1], landing[0], landing[1])
        ceiling = z + machine.legs[leg].z[1] + machine.overreach[2]
        crest = max(foot[2], landing[2], between)
        corners = lift(foot, landing, crest, ceiling, z, machine, task.gait)
        ways = {leg: FootWay(corners, landing)}
        seconds = self._seconds(corners)
        profile = profile_of(task.gait)
        self._add(body_still_plan(self.now, ways, seconds, STRETCHES, profile), margin)

    def _seconds(self, corners: SwingCorners) -> tuple[float, float, float]:
        """How long the stretches of a swing take at the limits of the leg."""
        vx, vy, vz = swing_speeds(self.task.machine, self.task.gait)
        stand, top, over, aim = corners
        ahead, left = self.task.along(over[0] - stand[0], over[1] - stand[1])
        back = max(abs(ahead) / vx, abs(left) / vy, abs(over[2] - top[2]) / vz, TICK)
        return (top[2] - stand[2]) / vz, back, (over[2] - aim[2]) / vz

    def _add(self, plan: StepPlan, margin: float) -> None:
        self.done.append(changed(plan, crab_angle=self.crab_angle, margin_min=margin))
        self.now = plan.end


# the plane, along the body's axes


def _ring(ring: int) -> Iterator[tuple[int, int]]:
    """Offsets of the cells that are so many rows or columns away, in a fixed order."""
    for k in range(-ring, ring + 1):
        for m in range(-ring, ring + 1) if abs(k) == ring else (-ring, ring):
            yield k, m


def _rectangle(feet: Sequence[_Place]) -> Polygon | None:
    """Where the body may be for all these footholds to be in reach, counter-clockwise; None when
    nowhere.
    """
    u1 = max(foot.u - foot.box[1] for foot in feet)
    u2 = min(foot.u - foot.box[0] for foot in feet)
    v1 = max(foot.v - foot.box[3] for foot in feet)
    v2 = min(foot.v - foot.box[2] for foot in feet)
    if u1 > u2 + STILL or v1 > v2 + STILL:
        return None
    return (u1, v1), (u2, v1), (u2, v2), (u1, v2)
