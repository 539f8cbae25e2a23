"""Level B3 before a step is taken: whether heights allow a foothold, and how high the body then
stands (H §6, K's truncations).

One description of a step serves lines and arcs: the body goes along the path of its gait. Only the
height the body goes for differs. On a line it is H's, towards H above the ground where the course
passes between the leading feet; on an arc no two feet lead, and it is H above the mean of all four.
"""

from __future__ import annotations

import math

from ..geometry.transforms import Body
from ..lazy import lazy
from ..motion.body_height import (
    FeetHeights,
    body_height,
    clears_all,
    ground_ahead,
    torso_clearance,
)
from ..motion.step_builder import with_feet
from ..motion.sway_room import shift_is_barred
from ..motion.swing import CLEARANCE
from ..robot.collision import SteppingLegs, something_tall
from ..search import Work
from ..types import Point, Stance
from .gait import Posture
from .step_refusals import StepRefusal
from .steps import BodyShift, Candidate, Landing, Shift, StepRequest, SwingStep

LEVEL = 0.005  # m; feet this close to the height of level ground stand on it: no height to plan
CLIMB = 0.4  # m the body may rise or sink per m of an arc

ASKED, AMONG_TALL = 1, 4  # what asking about a foothold weighs, in postures looked at
Swinging = Shift | SwingStep


class FootholdChecks:
    """Heights around one stance (the request's unless given): what Level B3 says of a foothold."""

    def __init__(
        self,
        posture: Posture,
        request: StepRequest,
        stance: Stance | None = None,
        work: Work | None = None,
    ) -> None:
        self.work = work or Work()  # is told of every foothold that is asked about
        self.posture = posture
        self.nominal = nominal = posture.nominal
        self.stance = stance = stance or request.stance
        self.terrain = terrain = request.terrain
        self.machine = request.machine
        self.gait = gait = request.gait
        self.heights = [stance.feet[leg][2] for leg in nominal.body_leg]  # legs of the gait frame
        self.feet = FeetHeights(self.machine, self.heights, stance.body[2])
        self.summit = max(terrain.highest, *self.heights)  # no way of a foot is higher
        self.level = terrain.highest if terrain.is_level else math.nan
        self.is_level = (
            terrain.is_level
            and all(abs(z - self.level) <= LEVEL for z in self.heights)
            and self.ceiling(self.level + gait.height) >= self.level + CLEARANCE
        )

    def ground_at(self, landing: Landing) -> float:
        """Height of the foothold, m."""
        return self.level if self.is_level else self.terrain.height_at(landing.ax, landing.ay)

    def foot_at(self, landing: Landing) -> Point:
        """The foot on its new foothold, absolute frame."""
        return landing.ax, landing.ay, self.ground_at(landing)

    def stance_after(self, posture: Posture, step: Candidate, z: float | None = None) -> Stance:
        """The stance in which a step to a posture leaves the walker, at its height or ``z``."""
        _, _, z_now, yaw = self.stance.body
        feet, leg = self.stance.feet, self.stance.last_swing
        if isinstance(step, SwingStep):
            z_now = self.height_after(step, step.landing) if z is None else z
            leg = self.nominal.body_leg[step.leg]
            feet = with_feet(feet, {leg: self.foot_at(step.landing)})
        return Stance((posture.x, posture.y, z_now, yaw), feet, leg, self.nominal.quarter_turns)

    def body_at(self, way: float, z: float) -> Body:
        """The body after so much way along the path, m, at height ``z``."""
        dx, dy, turn = self.nominal.path.pose(way)
        x, y = self.posture.absolute(dx, dy)
        return x, y, z, self.stance.body[3] + turn

    # the height of the body

    def height_limits(self, step: Swinging, ground: float) -> tuple[float, float]:
        """Lowest and highest CoG at N_{k+1} with u on such ground: all four feet in reach there,
        and u still in reach after g0; low > high when none is.
        """
        leg, g0, g = step[:3]
        return self.feet.limits(leg, ground, g0 / g if g0 > 0.0 else 0.0)

    def height_after(
        self, step: Swinging, landing: Landing, limits: tuple[float, float] | None = None
    ) -> float:
        """Height of the CoG at N_{k+1} within the limits (H §6), m."""
        leg = step.leg
        ground = self.ground_at(landing)
        low, high = limits or self.height_limits(step, ground)
        z = self.stance.body[2]
        ux, uy, turn = self.nominal.path
        if turn != 0.0:
            wanted = self.feet.mean(leg, ground) + self.gait.height - z
            change = min(max(wanted, -CLIMB * step.g), CLIMB * step.g)
            return min(max(z + change, low), high)
        left: Point = (*self.posture.feet[0], self.heights[0])
        right: Point = (*self.posture.feet[3], self.heights[3])
        if leg == 0:
            left = landing.x, landing.y, ground
        elif leg == 3:
            right = landing.x, landing.y, ground
        ahead = ground_ahead(left, right, ux, uy)
        return body_height(z, step.g, ahead, self.gait.height, low, high)

    # what refuses a foothold

    def refuses(self, shift: Shift, landing: Landing) -> StepRefusal | None:
        """Why a foothold cannot be used for its height; None when it can."""
        leg = shift.leg
        legs = self.legs_among_tall
        self.work.asked += ASKED if legs is None else AMONG_TALL
        z = self.stance.body[2]
        if legs is not None and legs.standing_meet(self.nominal.body_leg[leg], shift.g, z):
            return StepRefusal.STANDING_LEG
        ground = self.ground_at(landing)
        if ground != ground:
            return StepRefusal.UNKNOWN_GROUND
        limits = self.height_limits(shift, ground)
        if limits[0] > limits[1]:
            return StepRefusal.TOO_UNEVEN
        if legs is None and max(self.summit, ground) + CLEARANCE <= self.ceiling(limits[0]):
            return None  # however low the body ends, the foot is lifted over all of the map
        height = self.height_after(shift, landing, limits)
        if self.crest(leg, landing) + CLEARANCE > self.ceiling(height):
            return StepRefusal.LIFT
        if legs is not None and self._swung_leg_meets(legs, shift, landing, height):
            return StepRefusal.TALL
        return None

    @lazy
    def legs_among_tall(self) -> SteppingLegs | None:
        """The legs as they step, where something near is tall enough to meet one."""
        x, y, _, _ = self.stance.body
        if not something_tall(self.terrain, self.machine, x, y, min(self.heights)):
            return None
        return SteppingLegs(self.terrain, self.machine, self.stance.feet, self.body_at)

    def _swung_leg_meets(
        self, legs: SteppingLegs, shift: Shift, landing: Landing, height: float
    ) -> bool:
        """True when the leg that swings meets ground as the step ends, or on its way, lifted as it
        is.
        """
        leg = self.nominal.body_leg[shift.leg]
        foot = self.foot_at(landing)
        if legs.meet(shift.g, height, {leg: foot}):
            return True
        z = self.stance.body[2]
        over = self.crest(shift.leg, landing) + CLEARANCE
        lifted = min(max(self.stance.feet[leg][2] + self.gait.lift_up, over), self.ceiling(z))
        return legs.swinging_meets(leg, foot[:2], (shift.g0, shift.g), z, lifted)

    # what the swing and the torso must clear

    def crest(self, leg: int, landing: Landing) -> float:
        """Highest ground under the way of the swing foot, its own two footholds included, m."""
        if self.is_level:
            return self.level
        px, py, z = self.stance.feet[self.nominal.body_leg[leg]]
        between = self.terrain.crest_between(px, py, landing.ax, landing.ay)
        return max(z, self.ground_at(landing), between)

    def ceiling(self, height: float) -> float:
        """How high a foot can be lifted in this step, δz above the control reach included, m."""
        low = min(self.stance.body[2], height)
        return low + self.machine.z_range[1] + self.machine.overreach[2]

    def is_barred(self, shift: BodyShift) -> bool:
        """True when a four-leg shift leads a leg, or the torso, into something tall."""
        if self.legs_among_tall is None:
            return False
        place = self.posture.absolute(shift.x, shift.y)
        return shift_is_barred(self.terrain, self.machine, self.stance, place)

    def torso_needs(self, g: float, height: float) -> float:
        """Lowest CoG at N_{k+1} at which the torso clears the ground there, m; -inf when ``height``
        clears all of the map.
        """
        if clears_all(self.terrain, self.machine, height):
            return -math.inf
        x, y, _, yaw = self.body_at(g, height)
        return torso_clearance(self.terrain, self.machine, x, y, yaw, height)
