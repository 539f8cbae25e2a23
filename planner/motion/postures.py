"""Postures on command: sitting down, standing up, and back into the standard layout, as short
sequences of plans.

All motion is quasi-static and nothing else moves while a foot is in the air: the body sways on all
standing feet to where the others carry it, then one foot goes to its place, and so on. With the yaw
held, the places of the body from which a set of feet is in reach are a rectangle in body axes, and
those over the support polygon a convex piece of it: whether a leg can be put somewhere, and where
the body goes for it, is a few cuts of a rectangle. The order of the legs is searched for, bounded
by count. Both planners' machines use this file; ``walk`` plays what it answers.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from ..geometry.paths import Box
from ..robot.collision import leg_in_the_way
from ..robot.model import Machine
from ..stability import XY, Polygon, polygon_margin, support_polygon
from ..terrain.map import TerrainMap
from ..types import TICK, Blocked, Gait, Point, Reason, Stance, StepPlan
from .body_height import torso_needs, torso_needs_exactly
from .step_builder import FootWay, body_still_plan, changed, holding_plan, plan_on_all_feet
from .swing import CLEARANCE, STRETCHES, lift, profile_of, swing_speeds

THERE = 0.01  # m; a foot this near its place stays; smaller: see feet lifted and put back
LINE = 1e-9  # m²; an area of less is a line
STILL = 1e-4  # m; a shorter way of the body is none
# of V_z at which the body sinks and rises; more: see it drop rather than sit down
HEIGHT_SHARE = 0.5
# of V_x, V_y at which it sways on all feet: about the speed of a walk; more: see it lurch
SWAY_SHARE = 0.2
GIVE = 0.005  # m of the legs' last reach kept while sitting, for Level C to level the torso with
# m between the heights at which the legs of a sinking body are held against the ground beside them
LEG_LOOK = 0.025
TORSO_LOOK = 0.05  # m of sway between looks at the ground under the torso
# m from every edge of the support polygon as a foot lifts: the first that can be kept
INSETS = (0.03, 0.015, 0.005, 0.001)
GOAL_INSET = 0.005  # m of margin at least in the layout arrived at; less: see other cells taken
# places looked at for one order of the legs; far more than any standing posture on open ground
# takes
LOOKS_MAX = 600
CELLS_TRIED = 4  # cells tried for one foot, nearest to its place first

Poses = tuple[StepPlan, ...]
Choosing = Generator[None, None, "Poses | Blocked"]  # pauses after each place looked at


def sit(stance: Stance, terrain: TerrainMap, machine: Machine, gait: Gait) -> Poses | Blocked:
    """The body sinks on its feet until the torso is just above the ground, or the legs (δz
    included) can be drawn no higher.
    """
    if stance.lifted:
        return _in_the_air(stance)
    x, y, z, yaw = stance.body
    drawn = (
        max(foot[2] - leg.z[1] for foot, leg in zip(stance.feet, machine.legs, strict=True))
        - machine.overreach[2]
        + GIVE
    )
    lowest = max(drawn, torso_needs_exactly(terrain, machine, x, y, yaw))
    reached = z
    while reached > lowest:
        lower = max(lowest, reached - LEG_LOOK)
        if leg_in_the_way(terrain, machine, (x, y, lower, yaw), stance.feet) is not None:
            break
        reached = lower
    if reached == z and lowest < z - STILL:
        met = leg_in_the_way(terrain, machine, (x, y, max(lowest, z - LEG_LOOK), yaw), stance.feet)
        return Blocked(Reason.LEG_BESIDE, met)
    return _moved(stance, ((x, y, min(reached, z)),), machine, gait)


def stand(stance: Stance, terrain: TerrainMap, machine: Machine, gait: Gait) -> Poses | Blocked:
    """The body rises (or sinks) to H above the mean of its feet, as far as every leg reaches, and
    over the ground below it.
    """
    if stance.lifted:
        return _in_the_air(stance)
    x, y, _, yaw = stance.body
    return _moved(
        stance,
        ((x, y, standing_height(stance, stance.feet, terrain, machine, gait, (x, y, yaw))),),
        machine,
        gait,
    )


def standing_height(
    stance: Stance,
    feet: Sequence[Point],
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    place: tuple[float, float, float],
) -> float:
    """H above the mean of the feet, within reach of them all; where nothing is, half of what is
    amiss is left to δz. m.
    """
    low, high = height_limits(feet, machine)
    if low > high:
        return (low + high) / 2
    wanted = max(
        sum(foot[2] for foot in feet) / len(feet) + gait.height, _torso(terrain, machine, *place)
    )
    return min(max(wanted, low), high)


def height_limits(feet: Sequence[Point], machine: Machine) -> tuple[float, float]:
    """Lowest and highest CoG from which every foot is in its control reach; low > high when there
    is none.
    """
    pairs = list(zip(feet, machine.legs, strict=True))
    return max(foot[2] - leg.z[1] for foot, leg in pairs), min(
        foot[2] - leg.z[0] for foot, leg in pairs
    )


def _in_the_air(stance: Stance) -> Blocked:
    return Blocked(Reason.FOOT_IN_THE_AIR, stance.lifted[0])


def _torso(
    terrain: TerrainMap, machine: Machine, x: float, y: float, yaw: float, height: float = -math.inf
) -> float:
    """Lowest CoG at which the torso clears the ground at x, y, m; looked at exactly only where the
    quick look says no.
    """
    needs = torso_needs(terrain, machine, x, y, yaw)
    return needs if needs <= height else torso_needs_exactly(terrain, machine, x, y, yaw)


# motions of the body on standing feet


def _moved(stance: Stance, places: Sequence[Point], machine: Machine, gait: Gait) -> Poses:
    """One plan that takes the body through ``places`` (x, y, z) on all feet that stand; none where
    there is no way to go.
    """
    x, y, z, yaw = stance.body
    times, rows = [0.0], [stance.body]
    vx, vy, vz = swing_speeds(machine, gait)
    c, s = math.cos(yaw), math.sin(yaw)
    for px, py, pz in places:
        ahead, left, up = c * (px - x) + s * (py - y), c * (py - y) - s * (px - x), pz - z
        seconds = max(
            abs(ahead) / (SWAY_SHARE * vx),
            abs(left) / (SWAY_SHARE * vy),
            abs(up) / (HEIGHT_SHARE * vz),
        )
        if math.hypot(ahead, left, up) < STILL:
            continue
        begun = times[-1]
        for tau, share in profile_of(gait):
            times.append(begun + tau * seconds)
            rows.append((x + share * (px - x), y + share * (py - y), z + share * (pz - z), yaw))
        x, y, z = px, py, pz
    if len(times) == 1:
        return ()
    rows[-1] = (x, y, z, yaw)
    end = replace(stance, body=(x, y, z, yaw))
    way = math.hypot(x - stance.body[0], y - stance.body[1])
    return (plan_on_all_feet(stance, times, rows, end, support_shift=way),)


# back into the standard layout


class _Place(NamedTuple):
    """Where a foot may stand on the way: in body axes turned by the yaw, relative to the origin,
    and in the absolute frame.
    """

    u: float
    v: float
    at: Point
    box: Box  # that it must be in, seen from the body


class _Move(NamedTuple):
    """One leg to one place: the body goes to (u, v, z) first."""

    leg: int
    place: int  # index into the leg's places
    u: float
    v: float
    z: float
    margin: float
    way: float  # m the body sways for it


def regroup(
    stance: Stance,
    goal: Stance,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    crab_angle: float = 0.0,
) -> Choosing:
    """Every foot to its place in the layout ``goal``, one at a time, the body ending over it;
    ``Blocked`` when no order works.

    Where a foot may not stand it takes the nearest cell in reach of the body at the goal. ``goal``
    lies at the body's own yaw. The last plan's end remembers what the goal does (who swung last,
    quarter turns).
    """
    if stance.lifted:
        return _in_the_air(stance)
    search = _Regrouping(stance, goal, terrain, machine, gait, crab_angle)
    yield
    for targets in search.layouts():
        moves = yield from search.order(targets)
        if moves is not None:
            return search.plans(moves)
        if search.looks >= LOOKS_MAX:
            break
    return search.why


class _Regrouping:
    """One search for the order in which the legs are put into their places."""

    def __init__(
        self,
        stance: Stance,
        goal: Stance,
        terrain: TerrainMap,
        machine: Machine,
        gait: Gait,
        crab_angle: float,
    ) -> None:
        self.stance, self.goal, self.terrain, self.machine, self.gait, self.crab_angle = (
            stance,
            goal,
            terrain,
            machine,
            gait,
            crab_angle,
        )
        self.yaw = stance.body[3]
        self.c, self.s = math.cos(self.yaw), math.sin(self.yaw)
        self.start = self.turned(*stance.body[:2])
        self.end = self.turned(*goal.body[:2])
        self.looks = 0
        self.why = Blocked(Reason.NO_FOOTHOLD_BACK)
        self.level = sum(foot[2] for foot in stance.feet) / len(stance.feet)
        self.here = [self._here(leg) for leg in range(len(machine.legs))]

    def turned(self, x: float, y: float) -> XY:
        """An absolute point along the body's axes."""
        return self.c * x + self.s * y, self.c * y - self.s * x

    def absolute(self, u: float, v: float) -> XY:
        return self.c * u - self.s * v, self.s * u + self.c * v

    def _here(self, leg: int) -> _Place:
        """Where the foot is now; its box reaches as far as it already does: a step cut short may
        have left it a little outside.
        """
        foot, (x1, x2, y1, y2) = self.stance.feet[leg], self.machine.boxes[leg]
        u, v = self.turned(foot[0], foot[1])
        ahead, left = u - self.start[0], v - self.start[1]
        return _Place(u, v, foot, (min(x1, ahead), max(x2, ahead), min(y1, left), max(y2, left)))

    def _place(self, leg: int, at: Point) -> _Place:
        return _Place(*self.turned(at[0], at[1]), at, self.machine.boxes[leg])

    # where the feet are to stand

    def layouts(self) -> Iterator[tuple[_Place, ...]]:
        """Sets of places for all feet, best first: all in their nearest, then one leg after the
        other in its next nearest.
        """
        choices = [self.cells(leg) for leg in range(len(self.machine.legs))]
        for leg, cells in enumerate(choices):
            if not cells:
                self.why = Blocked(Reason.NO_FOOTHOLD_THERE, leg)
                return
        nearest = tuple(cells[0] for cells in choices)
        found = [nearest]
        for k in range(1, CELLS_TRIED):
            found += [
                (*nearest[:leg], cells[k], *nearest[leg + 1 :])
                for leg, cells in enumerate(choices)
                if len(cells) > k
            ]
        for layout in found:
            low, high = height_limits([place.at for place in layout], self.machine)
            margin = polygon_margin(
                support_polygon([(place.u, place.v) for place in layout]), *self.end
            )
            if low <= high and margin >= GOAL_INSET:
                yield layout
        if not self.looks:
            self.why = Blocked(Reason.NO_STANDING_BODY)

    def cells(self, leg: int) -> list[_Place]:
        """Where one foot may stand, nearest to its place first: where it is, the place itself, or
        centres of cells; a few at most.
        """
        (gx, gy, _), here, terrain = self.goal.feet[leg], self.here[leg], self.terrain
        gu, gv = self.turned(gx, gy)
        off = math.hypot(here.u - gu, here.v - gv) if self.fits(leg, here.at) else math.inf
        if off <= THERE:
            return [here]
        found: list[tuple[float, _Place]] = [(off, here)] if off < math.inf else []
        if terrain.allows(gx, gy) and self.fits(leg, exact := (gx, gy, terrain.height_at(gx, gy))):
            found.append((0.0, self._place(leg, exact)))
        else:
            found += [
                (distance, self._place(leg, at)) for distance, at in self._centres(leg, gx, gy)
            ]
        found.sort(key=lambda entry: (entry[0], entry[1].at))
        return [place for _, place in found[:CELLS_TRIED]]

    def _centres(self, leg: int, gx: float, gy: float) -> list[tuple[float, Point]]:
        """The nearest centres of cells round the place that may be stepped on, in rings of cells
        until no farther one can be nearer.
        """
        terrain, (x1, x2, y1, y2) = self.terrain, self.machine.boxes[leg]
        column, row = (
            (value - origin) / terrain.cell
            for value, origin in zip((gx, gy), terrain.origin, strict=True)
        )
        column0, row0 = math.floor(column), math.floor(row)
        farthest = math.ceil(math.hypot(x2 - x1, y2 - y1) / terrain.cell)
        found: list[tuple[float, Point]] = []
        for ring in range(farthest + 1):
            if (
                len(found) >= CELLS_TRIED
                and sorted(found)[CELLS_TRIED - 1][0] <= (ring - 0.5) * terrain.cell
            ):
                break
            for k, m in _ring(ring):
                r, q = row0 + k, column0 + m
                if (
                    not (0 <= r < terrain.rows and 0 <= q < terrain.columns)
                    or terrain.forbidden_bytes[r * terrain.columns + q]
                ):
                    continue
                px, py = terrain.centre(r, q)
                at = (px, py, terrain.height_at(px, py))
                if self.fits(leg, at):
                    found.append((math.hypot(px - gx, py - gy), at))
        return sorted(found)[:CELLS_TRIED]

    def fits(self, leg: int, at: Point) -> bool:
        """In the leg's control reach with the body at the goal, at a height it can stand at."""
        (x1, x2, y1, y2), (low, high) = self.machine.boxes[leg], self.machine.legs[leg].z
        u, v = self.turned(at[0], at[1])
        u, v, drop = u - self.end[0], v - self.end[1], at[2] - self.level - self.gait.height
        return (
            x1 - STILL <= u <= x2 + STILL and y1 - STILL <= v <= y2 + STILL and low <= drop <= high
        )

    # in which order

    def order(
        self, targets: tuple[_Place, ...]
    ) -> Generator[None, None, list[tuple[_Move, _Place]] | None]:
        """Depth first, the leg that needs the shortest sway first; a leg may pause in the middle of
        its reach on its way.
        """
        legs = range(len(targets))
        places = [(self.here[leg], targets[leg], *self._middle(leg)) for leg in legs]
        first = tuple(1 if targets[leg] is self.here[leg] else 0 for leg in legs)
        seen, path = {first}, list[tuple[_Move, _Place]]()
        waiting = [(yield from self._moves(first, places, (*self.start, self.stance.body[2])))]
        trail = [first]
        while waiting:
            if all(
                index == 1 or targets[leg] is self.here[leg] for leg, index in enumerate(trail[-1])
            ):
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

    def _middle(self, leg: int) -> tuple[_Place, ...]:
        """The middle of the leg's reach with the body at the goal: where a foot may pause to make
        room for others.
        """
        bx, by = self.machine.legs[leg].centre
        x, y = self.absolute(self.end[0] + bx, self.end[1] + by)
        cells = (
            [(x, y)]
            if self.terrain.allows(x, y)
            else [(at[0], at[1]) for _, at in self._centres(leg, x, y)[:1]]
        )
        return tuple(self._place(leg, (px, py, self.terrain.height_at(px, py))) for px, py in cells)

    def _moves(
        self, state: tuple[int, ...], places: list[tuple[_Place, ...]], body: Point
    ) -> Generator[None, None, list[_Move]]:
        """What can be done next, straight to the targets first, the shorter sway first."""
        found: list[_Move] = []
        for leg, index in enumerate(state):
            for goal in range(1, len(places[leg])):
                if index == 1 or goal == index:
                    continue
                self.looks += 1
                move = self._look(
                    leg, goal, [places[k][i] for k, i in enumerate(state)], places[leg][goal], body
                )
                yield
                if isinstance(move, _Move):
                    found.append(move)
                else:
                    self.why = Blocked(Reason.NO_WAY_BACK, leg, facts={"because": move})
        return sorted(found, key=lambda move: (move.place, round(move.way, 6), move.leg))

    def _look(
        self, leg: int, goal: int, feet: list[_Place], to: _Place, body: Point
    ) -> _Move | str:
        """The body's way and the swing for one leg from here, or why it cannot be."""
        reach = _rectangle([*feet, to])
        if reach is None:
            return "the feet are too far apart for the body to reach them all"
        polygon = support_polygon([(place.u, place.v) for k, place in enumerate(feet) if k != leg])
        over = (_nearest(_cut(reach, polygon, inset), body[0], body[1]) for inset in INSETS)
        place = next((found for found in over if found is not None), None)
        if place is None:
            return "the centre of gravity cannot be brought over the other feet"
        u, v = place
        (ax, ay, az), (bx, by, bz), machine = feet[leg].at, to.at, self.machine
        crest = max(az, bz, self.terrain.crest_between(ax, ay, bx, by))
        stand_low, stand_high = height_limits([foot.at for foot in feet], machine)
        low = max(
            stand_low,
            bz - machine.legs[leg].z[1],
            crest + CLEARANCE - machine.legs[leg].z[1] - machine.overreach[2],
        )
        high = min(stand_high, bz - machine.legs[leg].z[0])
        if low > high:
            return "the feet stand too high and too low for a foot to be lifted over the ground between"
        low = max(low, self._torso_on_the_way(body, u, v))
        if low > high:
            return "the torso would touch the ground"
        z = min(max(body[2], low), high)
        if self._meets(leg, feet, to, (u, v, z)):
            return "a leg would run into something tall"
        return _Move(
            leg, goal, u, v, z, polygon_margin(polygon, u, v), math.hypot(u - body[0], v - body[1])
        )

    def _torso_on_the_way(self, body: Point, u: float, v: float) -> float:
        """Lowest CoG that clears the ground all the way from here to (u, v), m."""
        z = body[2]
        if self.terrain.highest + self.machine.torso[2] / 2 + CLEARANCE <= z:
            return -math.inf
        count = max(1, math.ceil(math.hypot(u - body[0], v - body[1]) / TORSO_LOOK))
        shares = (k / count for k in range(1, count + 1))
        places = (
            self.absolute(body[0] + w * (u - body[0]), body[1] + w * (v - body[1])) for w in shares
        )
        return max(_torso(self.terrain, self.machine, x, y, self.yaw, z) for x, y in places)

    def _meets(self, leg: int, feet: list[_Place], to: _Place, body: Point) -> bool:
        """True when some leg meets ground beside it, before the swing or after it."""
        if self.terrain.is_level:
            return False
        pose = (*self.absolute(body[0], body[1]), body[2], self.yaw)
        before: list[Point | None] = [place.at for place in feet]
        after: list[Point | None] = [to.at if k == leg else None for k in range(len(feet))]
        return any(
            leg_in_the_way(self.terrain, self.machine, pose, points) is not None
            for points in (before, after)
        )

    # as plans

    def plans(self, moves: list[tuple[_Move, _Place]]) -> Poses:
        """The sequence with its times; the last plan ends over the layout, at the height of a
        standing machine.
        """
        out: list[StepPlan] = []
        now = self.stance
        for move, place in moves:
            x, y = self.absolute(move.u, move.v)
            now = self._sway(now, (x, y, move.z), out, move.margin)
            now = self._swing(now, move.leg, place.at, out, move.margin)
        feet = now.feet
        gx, gy, _, yaw = self.goal.body
        z = standing_height(now, feet, self.terrain, self.machine, self.gait, (gx, gy, yaw))
        now = self._sway(now, (gx, gy, z), out, 0.0)
        end = replace(
            now, last_swing=self.goal.last_swing, quarter_turns=self.goal.quarter_turns, still=0
        )
        if not out:
            return (changed(holding_plan(now), end=end, crab_angle=self.crab_angle),)
        out[-1] = changed(out[-1], end=end)
        return tuple(out)

    def _sway(self, now: Stance, to: Point, out: list[StepPlan], least: float) -> Stance:
        """The body to a place: up before it goes, down after."""
        (x, y, z, _), (px, py, pz) = now.body, to
        first = (x, y, pz) if pz > z else (px, py, z)
        way = _moved(now, (first, to), self.machine, self.gait)
        if not way:
            return now
        polygon = support_polygon(now.feet)
        margin = min(polygon_margin(polygon, x, y), polygon_margin(polygon, px, py))
        out += [changed(plan, crab_angle=self.crab_angle, margin_min=margin) for plan in way]
        return out[-1].end

    def _swing(
        self, now: Stance, leg: int, landing: Point, out: list[StepPlan], margin: float
    ) -> Stance:
        """One foot up, over the crest of the ground and down, the body where it is."""
        machine, gait = self.machine, self.gait
        foot, z = now.feet[leg], now.body[2]
        crest = max(
            foot[2],
            landing[2],
            self.terrain.crest_between(foot[0], foot[1], landing[0], landing[1]),
        )
        ceiling = z + machine.legs[leg].z[1] + machine.overreach[2]
        corners = lift(foot, landing, crest, ceiling, z, machine, gait)
        vx, vy, vz = swing_speeds(machine, gait)
        c, s = self.c, self.s
        _, top, over, aim = corners
        dx, dy = landing[0] - foot[0], landing[1] - foot[1]
        back = max(
            abs(c * dx + s * dy) / vx, abs(c * dy - s * dx) / vy, abs(over[2] - top[2]) / vz, TICK
        )
        seconds = ((top[2] - foot[2]) / vz, back, (over[2] - aim[2]) / vz)
        way = FootWay(corners, landing)
        plan = body_still_plan(now, {leg: way}, seconds, STRETCHES, profile_of(gait))
        out.append(changed(plan, crab_angle=self.crab_angle, margin_min=margin))
        return plan.end


# the plane, in body axes


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


def _cut(area: Polygon, polygon: Polygon, inset: float) -> Polygon:
    """What of a convex area lies inside a convex polygon by ``inset``; empty when nothing does."""
    if len(polygon) < 3:
        return ()
    left = list(area)
    ax, ay = polygon[-1]
    for bx, by in polygon:
        ex, ey = bx - ax, by - ay
        length = math.hypot(ex, ey)
        depths = [(ex * (y - ay) - ey * (x - ax)) / length - inset for x, y in left]
        kept: list[XY] = []
        for k, (x, y) in enumerate(left):
            (px, py), before, depth = left[k - 1], depths[k - 1], depths[k]
            if (before < 0.0) != (depth < 0.0):
                w = before / (before - depth)
                kept.append((px + w * (x - px), py + w * (y - py)))
            if depth >= 0.0:
                kept.append((x, y))
        left = kept
        if not left:
            return ()
        ax, ay = bx, by
    return tuple(left)


def _nearest(area: Polygon, x: float, y: float) -> XY | None:
    """The point of a convex area, counter-clockwise, nearest to (x, y); None of an empty one."""
    best, found = math.inf, None
    inside, twice_area = True, 0.0
    for k, (bx, by) in enumerate(area):
        ax, ay = area[k - 1]
        ex, ey = bx - ax, by - ay
        twice_area += ax * by - ay * bx
        if ex * (y - ay) - ey * (x - ax) < 0.0:
            inside = False
        size = ex * ex + ey * ey
        w = max(0.0, min(1.0, ((x - ax) * ex + (y - ay) * ey) / size)) if size > 0.0 else 0.0
        px, py = ax + w * ex, ay + w * ey
        distance = math.hypot(px - x, py - y)
        if distance < best:
            best, found = distance, (px, py)
    # a line, where the legs give no room across it, has no inside
    return (x, y) if inside and twice_area > LINE else found
