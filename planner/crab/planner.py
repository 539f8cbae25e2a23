"""One step of the crab walk on one page: B1 takes the command, B2 the plane, B3 the height, B4 the
clock (H §3, §5-§7).
"""

from __future__ import annotations

import math
from functools import cached_property, lru_cache

from ..geometry.paths import line_exit
from ..motion.body_height import (
    body_height,
    ground_ahead,
    height_range,
    torso_needs,
    torso_needs_exactly,
)
from ..motion.step_builder import plan_of_one_foot
from ..motion.swing import CLEARANCE, SwingCorners, lift, profile_of, swing_speeds
from ..motion.timing import Timing, knots, speed_limit, timing
from ..robot.collision import leg_in_the_way, something_tall
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Blocked, Command, Gait, Point, Stance, StepPlan
from .foothold_search import Landing, corners_of, domain_of, ground_of
from .gait import STRETCH_LEAN, Posture, Standard, posture_of, standard_for
from .leg_selection import STANDING_LEG, Notes, Shift, Step, decide, exits_of
from .turning import plan_turn, turns

# shares of a swing at which the leg that swings is held against them; coarser and a pole slips
# between
SWEPT = (0.0, 0.25, 0.5, 0.75)
# shares of a step at which the legs are held against tall things; 6 cm apart at most
LEG_CHECKS = (0.25, 0.5, 0.75, 1.0)
LEVEL = 0.005  # m; feet this close to the height of level ground stand on it: no height to plan


def plan_step(
    stance: Stance,
    command: Command,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    *,
    explain: bool = False,
) -> StepPlan | Blocked:
    """The next step of the crab walk from N_k, or why there is none.

    A command that turns is walked on an arc (``turning``); here the course is straight. A command
    of speed 0 is planned at v_max, to be played at the walker's own pace. ``explain`` fills the
    decision trace.
    """
    if turns(command, machine):
        return plan_turn(stance, command, terrain, machine, gait, explain=explain)
    standard = standard_for(machine, gait, command.crab_angle, stance.quarter_turns)
    posture = posture_of(standard, stance)
    notes: Notes | None = (
        {"crab_angle": command.crab_angle, "quarter_turns": standard.quarter_turns}
        if explain
        else None
    )
    ahead = Ahead(standard, posture, stance, terrain, machine, gait)
    step = decide(
        standard, posture, ground_of(terrain), None if ahead.is_level else ahead.refuses, notes
    )
    if step is None:
        return _blocked(standard, posture, terrain, ahead, notes)
    low, highest = ahead.height_limits(step.leg, step.g0, step.g, step.landing)
    height = ahead.height_after(step.leg, step.g, step.landing, low, highest)
    needs = ahead.torso_needs(step.g, height)
    if needs > height:
        if needs > highest:
            return Blocked(
                f"the torso would touch the ground: it needs {needs:.2f} m, the legs reach {highest:.2f} m",
                None,
                notes,
            )
        height = needs
    return build(standard, posture, stance, step, height, ahead, command, machine, gait, notes)


def _blocked(
    standard: Standard, posture: Posture, terrain: TerrainMap, ahead: Ahead, notes: Notes | None
) -> Blocked:
    """No leg is left: say of each what failed, in the order they were tried."""
    if notes is None:  # ask again, this time for the reasons
        tried: Notes = {}
        decide(
            standard, posture, ground_of(terrain), None if ahead.is_level else ahead.refuses, tried
        )
    else:
        tried = notes
    legs = tried["legs"]
    reasons = "; ".join(f"leg {trial['leg']}: {trial['reason']}" for trial in legs)
    return Blocked(f"no leg can take a step: {reasons}", legs[0]["leg"] - 1, notes)


class Ahead:
    """Heights around one stance: what Level B3 says of a foothold before it is taken."""

    def __init__(
        self,
        standard: Standard,
        posture: Posture,
        stance: Stance,
        terrain: TerrainMap,
        machine: Machine,
        gait: Gait,
    ) -> None:
        self.standard, self.posture, self.stance = standard, posture, stance
        self.terrain, self.machine, self.gait = terrain, machine, gait
        self.heights = [stance.feet[leg][2] for leg in standard.body_leg]  # canonical legs
        self.level = terrain.highest if terrain.is_level else math.nan
        self._met: dict[tuple[int, float], bool] = {}
        self.is_level = (
            terrain.is_level
            and all(abs(z - self.level) <= LEVEL for z in self.heights)
            and self.ceiling(self.level + gait.height) >= self.level + CLEARANCE
        )

    def ground_at(self, landing: Landing) -> float:
        """Height of the foothold, m."""
        return self.level if self.is_level else self.terrain.height_at(landing.ax, landing.ay)

    def height_limits(self, leg: int, g0: float, g: float, landing: Landing) -> tuple[float, float]:
        """Lowest and highest CoG at N_{k+1}: all four feet in reach there, and u still in reach
        after g0; low > high when none is.
        """
        return self._limits(leg, g0, g, self.ground_at(landing))

    def _limits(self, leg: int, g0: float, g: float, ground: float) -> tuple[float, float]:
        heights = self.heights.copy()
        heights[leg] = ground
        low, high = height_range(self.machine, heights)
        if g0 > 0.0:
            z, share = self.stance.body[2], g0 / g
            bottom, top = height_range(self.machine, self.heights[leg : leg + 1])
            low, high = max(low, z + (bottom - z) / share), min(high, z + (top - z) / share)
        return low, high

    def height_after(self, leg: int, g: float, landing: Landing, low: float, high: float) -> float:
        """Height of the CoG at N_{k+1} within the limits (H §6), m."""
        return self._height(leg, g, landing, self.ground_at(landing), low, high)

    def _height(
        self, leg: int, g: float, landing: Landing, ground: float, low: float, high: float
    ) -> float:
        (lx, ly), (rx, ry) = self.posture.feet[0], self.posture.feet[3]
        left, right = (lx, ly, self.heights[0]), (rx, ry, self.heights[3])
        if leg == 0:
            left = landing.x, landing.y, ground
        elif leg == 3:
            right = landing.x, landing.y, ground
        predicted = ground_ahead(left, right, self.standard.ux, self.standard.uy)
        return body_height(self.stance.body[2], g, predicted, self.gait.height, low, high)

    def refuses(self, shift: Shift, landing: Landing) -> str | None:
        """Why a foothold cannot be used for its height; None when it can."""
        leg = shift.leg
        if self.has_tall and self._standing_legs_meet(self.standard.body_leg[leg], shift.g):
            return STANDING_LEG
        z = self.ground_at(landing)
        if z != z:
            return "no ground known there"
        low, high = self._limits(leg, shift.g0, shift.g, z)
        if low > high:
            return "too high or too low for the legs to reach together"
        height = self._height(leg, shift.g, landing, z, low, high)
        if self.crest(leg, landing) + CLEARANCE > self.ceiling(height):
            return "the foot cannot be lifted over the ground on the way"
        if self.has_tall and (
            self._new_leg_meets(shift, landing, z, height)
            or self._swinging_leg_meets(shift, landing)
        ):
            return "a leg would run into something tall"
        return None

    @cached_property
    def has_tall(self) -> bool:
        """True when something near is tall enough to meet a leg."""
        return something_tall(
            self.terrain, self.machine, self.stance.body[0], self.stance.body[1], min(self.heights)
        )

    def _new_leg_meets(self, shift: Shift, landing: Landing, ground: float, height: float) -> bool:
        """True when at the end of the step the leg that swings, on its new foothold, meets ground."""
        u = self.standard.body_leg[shift.leg]
        x, y = self.posture.absolute(shift.g * self.standard.ux, shift.g * self.standard.uy)
        feet: list[Point | None] = [None] * len(self.stance.feet)
        feet[u] = landing.ax, landing.ay, ground
        return (
            leg_in_the_way(self.terrain, self.machine, (x, y, height, self.stance.body[3]), feet)
            is not None
        )

    def _swinging_leg_meets(self, shift: Shift, landing: Landing) -> bool:
        """True when the leg that swings sweeps through ground on its way, lifted as it is; first
        where its foot stands yet.
        """
        u, (_, _, z, yaw) = self.standard.body_leg[shift.leg], self.stance.body
        from_x, from_y, from_z = self.stance.feet[u]
        top = min(
            max(from_z + self.gait.lift_up, self.crest(shift.leg, landing) + CLEARANCE),
            self.ceiling(z),
        )
        feet: list[Point | None] = [None] * len(self.stance.feet)
        for share in SWEPT:
            way = shift.g0 + share * (shift.g - shift.g0)
            x, y = self.posture.absolute(way * self.standard.ux, way * self.standard.uy)
            feet[u] = (
                from_x + share * (landing.ax - from_x),
                from_y + share * (landing.ay - from_y),
                top if share else from_z,
            )
            if leg_in_the_way(self.terrain, self.machine, (x, y, z, yaw), feet) is not None:
                return True
        return False

    def _standing_legs_meet(self, u: int, g: float) -> bool:
        """True when on the way of the step a leg that stays meets ground, whatever the foothold;
        asked for every cell, so remembered.
        """
        key = u, g
        if key not in self._met:
            z, yaw = self.stance.body[2], self.stance.body[3]
            feet: list[Point | None] = list(self.stance.feet)
            feet[u] = None
            places = (
                self.posture.absolute(share * g * self.standard.ux, share * g * self.standard.uy)
                for share in LEG_CHECKS
            )
            self._met[key] = any(
                leg_in_the_way(self.terrain, self.machine, (x, y, z, yaw), feet) is not None
                for x, y in places
            )
        return self._met[key]

    def crest(self, leg: int, landing: Landing) -> float:
        """Highest ground under the way of the swing foot, its own two footholds included, m."""
        if self.is_level:
            return self.level
        px, py, z = self.stance.feet[self.standard.body_leg[leg]]
        return max(
            z, self.ground_at(landing), self.terrain.crest_between(px, py, landing.ax, landing.ay)
        )

    def ceiling(self, height: float) -> float:
        """How high a foot can be lifted in this step, m: the lift may use δz above the control
        reach.
        """
        return (
            min(self.stance.body[2], height) + self.machine.z_range[1] + self.machine.overreach[2]
        )

    def torso_needs(self, g: float, height: float) -> float:
        """Lowest CoG at N_{k+1} at which the torso clears the ground there, m; -inf when ``height``
        clears all of the map.
        """
        terrain, machine = self.terrain, self.machine
        if terrain.highest + machine.torso[2] / 2 + CLEARANCE <= height:
            return -math.inf
        x, y = self.posture.absolute(g * self.standard.ux, g * self.standard.uy)
        needs = torso_needs(terrain, machine, x, y, self.stance.body[3])
        return (
            needs
            if needs <= height
            else torso_needs_exactly(terrain, machine, x, y, self.stance.body[3])
        )


def build(
    standard: Standard,
    posture: Posture,
    stance: Stance,
    step: Step,
    height: float,
    ahead: Ahead,
    command: Command,
    machine: Machine,
    gait: Gait,
    notes: Notes | None = None,
) -> StepPlan:
    """The plan of a step Level B2 decided on, the body ending at ``height`` (H §7)."""
    leg = standard.body_leg[step.leg]
    x, y, z, yaw = stance.body
    end_x, end_y = posture.absolute(step.g * standard.ux, step.g * standard.uy)
    landing: Point = (step.landing.ax, step.landing.ay, ahead.ground_at(step.landing))
    swing = lift(
        stance.feet[leg],
        landing,
        ahead.crest(step.leg, step.landing),
        ahead.ceiling(height),
        height,
        machine,
        gait,
    )
    clock = _clock(standard, posture, step, swing, height - z, command, machine, gait)
    rows, phases = knots(
        clock, profile_of(gait), ((x, y, z), (end_x, end_y, height)), step.g0, step.g, swing
    )
    feet = list(stance.feet)
    feet[leg] = landing
    start_x, start_y = posture.absolute(*step.start)
    along = [(t, (*place, yaw), foot) for t, place, foot in rows]
    if notes is not None:
        notes["domain"] = searched(standard, posture, step)
    end = Stance(
        (end_x, end_y, height, yaw),
        tuple(feet),
        leg,
        standard.quarter_turns,
        (),
        stance.course + step.g,
    )
    return plan_of_one_foot(
        stance,
        leg,
        along,
        phases,
        end,
        crab_angle=standard.course,
        support_shift=step.g0,
        shift=step.g,
        standard_margin=standard.margin,
        margin_min=step.margin,
        speed=clock.speed if clock.speed > 0.0 else clock.support_speed,
        speed_max=clock.speed_max if clock.speed > 0.0 else clock.support_speed,
        search_start=(start_x, start_y, landing[2]),
        landing=landing,
        decision=notes,
    )


def searched(standard: Standard, posture: Posture, step: Step) -> list[list[float]]:
    """Corners of D_u in the absolute frame, for the decision trace; the leg's whole reach where a
    lookahead went beyond D_u.
    """
    domain = domain_of(
        standard, posture.feet, exits_of(standard, posture), step.leg, step.g, step.convergent
    )
    x1, x2, y1, y2 = domain.box
    reach = [(x1, y1), (x2, y1), (x2, y2), (x1, y2)]
    corners = (
        corners_of(domain) if domain.refuses(step.landing.x, step.landing.y) is None else reach
    )
    return [list(posture.absolute(x, y)) for x, y in corners]


def _clock(
    standard: Standard,
    posture: Posture,
    step: Step,
    swing: SwingCorners,
    climb: float,
    command: Command,
    machine: Machine,
    gait: Gait,
) -> Timing:
    n, g = standard.quarter_turns, step.g
    course = _body_axes(standard.ux, standard.uy, n)
    fx, fy = posture.feet[step.leg]
    way = _body_axes(step.landing.x - fx, step.landing.y - fy, n)
    _, top, over, aim = swing
    box, ux, uy = standard.far_boxes[step.leg], standard.ux, standard.uy
    behind = line_exit(fx, fy, box, ux, uy) - step.g0
    beyond = line_exit(step.landing.x - g * ux, step.landing.y - g * uy, box, -ux, -uy)
    return timing(
        machine,
        gait,
        (way[0], way[1], over[2] - top[2]),
        (course[0], course[1], climb / g if g > 0.0 else 0.0),
        climb,
        step.g0,
        g,
        top[2] - swing[0][2],
        over[2] - aim[2],
        (max(behind, STRETCH_LEAN), max(beyond, STRETCH_LEAN)),
        command.speed,
        lambda: _cruise(machine, gait, standard.duty_factor, standard.stride, course),
    )


@lru_cache(maxsize=512)
def _cruise(
    machine: Machine, gait: Gait, duty_factor: float, stride: float, course: tuple[float, float]
) -> float:
    """v_max of the standard step on level ground, m/s."""
    g = (1.0 - duty_factor) / duty_factor * stride
    limits = swing_speeds(machine, gait)
    way = stride + g
    return speed_limit(
        (way * course[0], way * course[1], 0.0),
        (*course, 0.0),
        limits,
        g,
        (gait.lift_up + gait.lift_down) / limits[2],
    )


def cruise_speed(machine: Machine, gait: Gait, crab_angle: float) -> float:
    """v_max of the standard walk at a crab angle, m/s: what a command is held against before any
    step is planned.
    """
    standard = standard_for(machine, gait, crab_angle)
    return _cruise(
        machine,
        gait,
        standard.duty_factor,
        standard.stride,
        _body_axes(standard.ux, standard.uy, standard.quarter_turns),
    )


def _body_axes(x: float, y: float, n: int) -> tuple[float, float]:
    """A canonical vector in body axes."""
    for _ in range(n):
        x, y = -y, x
    return x, y
