"""The step of a turning walk as a plan: heights, clock and knots on an arc (Levels B3 and B4, the
twin of ``plan.build``).

Standing feet turn about the centre as the body does; the swing foot returns along a straight line
in the turning body axes, which is what the servos drive. Between knots the body goes straight:
pieces of 0.02 rad are within 0.03 mm of the arc.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

from ..geometry.paths import ArcPath, arc_exit
from ..motion.body_height import height_range, torso_needs, torso_needs_exactly
from ..motion.step_builder import FootKnot, plan_of_one_foot, plan_on_all_feet
from ..motion.swing import (
    CLEARANCE,
    Profile,
    SwingCorners,
    between,
    lift,
    peak,
    profile_of,
    stairs,
    swing_speeds,
)
from ..motion.timing import BACK_MIN
from ..robot.collision import leg_in_the_way, something_tall
from ..robot.model import Machine
from ..stability import XY, polygon_margin, support_polygon
from ..terrain.map import TerrainMap
from ..types import Blocked, Command, Gait, Phase, Point, Stance, StepPlan
from .arcs import Circular, reversed_course
from .leg_selection import STILL, Notes

KNOT_TURN = 0.02  # rad of yaw between knots; more: see the swing foot leave its line
CLIMB = 0.4  # m the body may rise or sink per m of course
EARLY = 0.02  # m a foot may stand outside its reach when it touches early, at mid-descent (H §4.5)
ROUNDING = 0.995  # of every speed limit: straight lines between knots in axes that turn
# shares of a step at which the legs are held against tall things
LEG_CHECKS = (0.25, 0.5, 0.75, 1.0)


class Move(NamedTuple):
    """One step: a swing (g0, g, where from I_u to J_u), or, with leg -1, a sway of the body to
    ``landing``. Body axes at N_k.
    """

    leg: int
    g0: float
    g: float
    start: XY
    landing: XY
    ground: XY  # the landing point in the absolute frame
    inset: float


def in_body(stance: Stance) -> tuple[XY, ...]:
    x, y, _, yaw = stance.body
    c, s = math.cos(yaw), math.sin(yaw)
    return tuple(
        (c * (fx - x) + s * (fy - y), c * (fy - y) - s * (fx - x)) for fx, fy, _ in stance.feet
    )


def swing_time(machine: Machine, gait: Gait, circular: Circular) -> float:
    """s a swing of the standard walk takes at the legs' limits, about."""
    reach = circular.stride * (1.0 + circular.swing_share)
    rates = [_rate(circular.arc, x, y) for x, y in circular.centres]
    fastest = max(max(rx / machine.speed[0], ry / machine.speed[1]) for rx, ry in rates)
    return peak(profile_of(gait)) * (
        (gait.lift_up + gait.lift_down) / machine.speed[2] + reach * fastest
    )


def _rate(arc: ArcPath, x: float, y: float) -> XY:
    """How fast a standing foot at (x, y) goes in body axes, per metre of s."""
    return abs(arc.ux - arc.turn * y), abs(arc.uy + arc.turn * x)


class Rises:
    """Heights around one stance on an arc: Level B3."""

    def __init__(
        self, stance: Stance, circular: Circular, terrain: TerrainMap, machine: Machine, gait: Gait
    ) -> None:
        self.stance, self.circular, self.terrain, self.machine, self.gait = (
            stance,
            circular,
            terrain,
            machine,
            gait,
        )
        self.is_level = terrain.is_level and all(
            abs(foot[2] - terrain.highest) < 0.005 for foot in stance.feet
        )
        lowest = min(foot[2] for foot in stance.feet)
        self.has_tall = not self.is_level and something_tall(
            terrain, machine, stance.body[0], stance.body[1], lowest
        )

    def ground_at(self, at: XY) -> float:
        """Height of a foothold, m."""
        return self.terrain.highest if self.is_level else self.terrain.height_at(*at)

    def height_after(self, leg: int, g0: float, g: float, at: XY) -> tuple[float, float, float]:
        """Height of the CoG at N_{k+1}, and the lowest and highest it may be: towards H above the
        mean of the feet.
        """
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
        if low > high or self.crest(leg, at) + CLEARANCE > self.ceiling(height):
            return True
        return self.has_tall and self.leg_in_the_way(leg, g, at, height)

    def leg_in_the_way(self, leg: int, g: float, at: XY, height: float) -> bool:
        """True when on the way of the step some leg that stands, or at its end the new one, meets
        ground.
        """
        path = BodyOnArc(self.stance, self.circular.arc, 0.0, g, height)
        feet: list[Point | None] = [
            None if i == leg else foot for i, foot in enumerate(self.stance.feet)
        ]
        for share in LEG_CHECKS:
            if share == 1.0:
                feet[leg] = (*at, self.ground_at(at))
            if (
                leg_in_the_way(self.terrain, self.machine, path.at(share * g, share), feet)
                is not None
            ):
                return True
        return False

    def crest(self, leg: int, at: XY) -> float:
        """Highest ground under the way of the swing foot, m."""
        x, y, z = self.stance.feet[leg]
        return (
            max(z, self.ground_at(at))
            if self.is_level
            else max(z, self.ground_at(at), self.terrain.crest_between(x, y, *at))
        )

    def ceiling(self, height: float) -> float:
        """How high a foot can be lifted in this step, m."""
        return (
            min(self.stance.body[2], height) + self.machine.z_range[1] + self.machine.overreach[2]
        )

    def torso_needs(self, x: float, y: float, yaw: float, height: float) -> float:
        """Lowest CoG at which the torso clears the ground there, m."""
        if self.terrain.highest + self.machine.torso[2] / 2 + CLEARANCE <= height:
            return -math.inf
        needs = torso_needs(self.terrain, self.machine, x, y, yaw)
        return (
            needs if needs <= height else torso_needs_exactly(self.terrain, self.machine, x, y, yaw)
        )


def sway_plan(rises: Rises, move: Move, pace: float, notes: Notes | None) -> StepPlan:
    """The body shifted on four legs, level and without turning."""
    stance, circular = rises.stance, rises.circular
    machine, gait = rises.machine, rises.gait
    (x, y), (_, _, z, yaw) = move.ground, stance.body
    cruise = _cruise(machine, gait, circular)
    speed = min(pace, cruise) if pace > 0.0 else cruise
    dx, dy = move.landing
    way = math.hypot(dx, dy)
    end_body = x, y, z, yaw
    end = replace(stance, body=end_body, lifted=(), still=stance.still + 1, lean=(0.0, 0.0))
    polygon = support_polygon(in_body(stance))
    return plan_on_all_feet(
        stance,
        (0.0, way / speed),
        (stance.body, end_body),
        end,
        crab_angle=math.atan2(dy, dx),
        standard_margin=circular.margin,
        margin_min=min(polygon_margin(polygon, 0.0, 0.0), polygon_margin(polygon, dx, dy)),
        speed=speed,
        speed_max=cruise,
        decision=notes,
    )


def _cruise(machine: Machine, gait: Gait, circular: Circular) -> float:
    """About the pace of the standard walk on the arc at the legs' limits, m/s."""
    return circular.swing_share * circular.stride / swing_time(machine, gait, circular)


class Clock(NamedTuple):
    """The clock of a step on an arc: ds/dt in m/s, durations in s."""

    speed: float
    speed_max: float
    support_speed: float
    support: float
    up: float
    back: float
    down: float


def swing_plan(
    rises: Rises, move: Move, command: Command, pace: float, useful: float, notes: Notes | None
) -> StepPlan | Blocked:
    """The plan of a swing the search decided on."""
    stance, circular = rises.stance, rises.circular
    machine, gait, leg = rises.machine, rises.gait, move.leg
    x, y, _, yaw = stance.body
    dx, dy, turn = circular.arc.pose(move.g)
    c, s = math.cos(yaw), math.sin(yaw)
    end_x, end_y, end_yaw = x + c * dx - s * dy, y + s * dx + c * dy, yaw + turn
    height, _, high = rises.height_after(leg, move.g0, move.g, move.ground)
    needs = rises.torso_needs(end_x, end_y, end_yaw, height)
    if needs > height:
        if needs > high:
            return Blocked(
                f"the torso would touch the ground: it needs {needs:.2f} m, the legs reach {high:.2f} m",
                None,
                notes,
            )
        height = needs
    landing: Point = (*move.ground, rises.ground_at(move.ground))
    corners = lift(
        stance.feet[leg],
        landing,
        rises.crest(leg, move.ground),
        rises.ceiling(height),
        height,
        machine,
        gait,
    )
    path = BodyOnArc(stance, circular.arc, move.g0, move.g, height)
    clock = _clock(rises, move, path, corners, pace)
    rows, phases = _knots(path, clock, corners, profile_of(gait))
    still = 0 if move.g >= useful else stance.still + 1
    ends = tuple(landing if i == leg else foot for i, foot in enumerate(stance.feet))
    start_x, start_y = (
        x + c * move.start[0] - s * move.start[1],
        y + s * move.start[0] + c * move.start[1],
    )
    end = Stance(
        (end_x, end_y, height, end_yaw),
        ends,
        leg,
        stance.quarter_turns,
        (),
        stance.course + move.g,
        still,
    )
    return plan_of_one_foot(
        stance,
        leg,
        rows,
        phases,
        end,
        crab_angle=command.crab_angle,
        support_shift=move.g0,
        shift=move.g,
        standard_margin=circular.margin,
        margin_min=_margin(path, stance, leg),
        speed=clock.speed,
        speed_max=clock.speed_max,
        search_start=(start_x, start_y, landing[2]),
        landing=landing,
        decision=notes,
    )


class BodyOnArc:
    """The body's way through one step: the arc, and the height in proportion to the way."""

    def __init__(self, stance: Stance, arc: ArcPath, g0: float, g: float, height: float) -> None:
        self.stance, self.arc, self.g0, self.g = stance, arc, g0, g
        self.x, self.y, self.z, self.yaw = stance.body
        self.c, self.s = math.cos(self.yaw), math.sin(self.yaw)
        self.climb = height - self.z

    def at(self, way: float, waited: float = 0.0) -> tuple[float, float, float, float]:
        """The body after ``way``; ``waited`` is the share of the swing over, by which a body that
        waits changes height.
        """
        dx, dy, turn = self.arc.pose(way)
        share = way / self.g if self.g > STILL else waited
        return (
            self.x + self.c * dx - self.s * dy,
            self.y + self.s * dx + self.c * dy,
            self.z + share * self.climb,
            self.yaw + turn,
        )

    def seen(self, point: Point, way: float, waited: float = 0.0) -> Point:
        """A point of the absolute frame in body axes."""
        x, y, z, yaw = self.at(way, waited)
        c, s = math.cos(yaw), math.sin(yaw)
        return (
            c * (point[0] - x) + s * (point[1] - y),
            c * (point[1] - y) - s * (point[0] - x),
            point[2] - z,
        )


def absolute(body: tuple[float, float, float, float], point: Point) -> Point:
    """A point in body axes in the absolute frame."""
    x, y, z, yaw = body
    c, s = math.cos(yaw), math.sin(yaw)
    return x + c * point[0] - s * point[1], y + s * point[0] + c * point[1], z + point[2]


def _margin(path: BodyOnArc, stance: Stance, leg: int) -> float:
    """Least polygon margin of a step, looked at along it."""
    feet = in_body(stance)
    least = math.inf
    for polygon, low, high in (
        (support_polygon(feet), 0.0, path.g0),
        (support_polygon([foot for i, foot in enumerate(feet) if i != leg]), path.g0, path.g),
    ):
        for k in range(5):
            dx, dy, _ = path.arc.pose(low + k / 4 * (high - low))
            least = min(least, polygon_margin(polygon, dx, dy))
    return least


def _clock(rises: Rises, move: Move, path: BodyOnArc, corners: SwingCorners, pace: float) -> Clock:
    """The fastest clock that keeps every limit, or the commanded pace: H §7 with the displacement
    taken in turning body axes.
    """
    machine, gait, circular = rises.machine, rises.gait, rises.circular
    vx, vy, vz = swing_speeds(machine, gait, ROUNDING)
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
    box, arc = circular.far_boxes[move.leg], circular.arc
    behind = arc_exit(*arc.seen(*in_body(rises.stance)[move.leg], move.g0), box, arc)
    landed = arc.seen(*move.landing, move.g)
    beyond = arc_exit(*landed, box, reversed_course(arc))
    drift = max(*_rate(arc, *landed), 1e-9)
    standing = _standing(rises, climbs)

    def holds(v: float) -> bool:
        up, back, down = swing(v)
        early = v * down * drift / 2 <= EARLY
        return (
            v * (up + back + down) <= g_u
            and v * up <= max(behind, EARLY / 2)
            and v * down <= max(beyond, EARLY / 2)
            and early
        )

    low, high = 0.0, min(standing, g_u / sum(swing(0.0)) * 2.0)
    for _ in range(24):
        middle = (low + high) / 2
        low, high = (middle, high) if holds(middle) else (low, middle)
    v = min(low, wanted)
    up, _, down = swing(v)
    support_speed = max(v, min(wanted, cruise, standing))
    return Clock(v, low, support_speed, move.g0 / support_speed, up, g_u / v - up - down, down)


def _standing(rises: Rises, climbs: float) -> float:
    """The largest pace at which standing legs keep their limits."""
    machine, arc = rises.machine, rises.circular.arc
    fastest = max(climbs / (0.5 * machine.speed[2]), 1e-9)
    for x1, x2, y1, y2 in rises.circular.far_boxes:
        for x, y in ((x1, y1), (x1, y2), (x2, y1), (x2, y2)):
            rx, ry = _rate(arc, x, y)
            fastest = max(fastest, rx / machine.speed[0], ry / machine.speed[1])
    return ROUNDING / fastest


Knots = tuple[list[FootKnot], list[Phase]]


def _knots(path: BodyOnArc, clock: Clock, corners: SwingCorners, profile: Profile) -> Knots:
    """The step as knots: up and down vertical in the absolute frame, the return a straight line in
    the turning body axes.
    """
    stand, top, over, aim = corners
    g0, g = path.g0, path.g
    total = clock.up + clock.back + clock.down
    rows: list[FootKnot] = [(0.0, path.at(0.0), stand)]
    phases: list[Phase] = []
    for k in range(1, (pieces := _pieces(path.arc, g0)) + 1 if g0 > STILL else 1):
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
        for tau, eased in stairs(profile, _pieces(path.arc, gone)):
            body = path.at(way + tau * gone, spent + tau * share)
            if phase is Phase.RETURN:
                foot = absolute(body, between(from_b, to_b, eased))
            else:
                foot = a[0], a[1], a[2] + eased * (b[2] - a[2])
            rows.append((begin + tau * duration, body, foot))
            phases.append(phase)
        begin, way, spent = begin + duration, way + gone, spent + share
        rows[-1] = begin, rows[-1][1], b
    rows[-1] = rows[-1][0], path.at(g, 1.0), aim
    return rows, phases


def _pieces(arc: ArcPath, way: float) -> int:
    """Into how many straight lines a stretch of an arc is cut."""
    return max(1, math.ceil(abs(arc.turn) * way / KNOT_TURN))
