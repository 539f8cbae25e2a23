"""The plan that runs: how far it has got, and where the machine really is beside it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from ..config import PlannerConfig, Tolerances
from ..geometry.transforms import Body, attitude_of, direction, placed, seen
from ..motion.body_bounds import bounds_of
from ..motion.step_builder import holding_plan, with_feet
from ..motion.swing_profile import gentle, legs_on_known_ground
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import TICK, Gait, Phase, Point, Sensing, Stance, StepPlan
from .compliant_controller import CompliantController
from .foot_controller import ReflexState, reflex
from .tracking import TrajectoryTracker

ON_ALL_FEET = (Phase.SUPPORT, Phase.SHIFT)
END = 1e-9  # s; a plan with less than this to go is over
AHEAD = 0.7  # cosine, 45°: a body further aside of its course than that is beside its legs
# m below the ground expected at which a foot has felt that there is none. Smaller: see false alarms
# where the aim is hardly below the ground; larger: see it feel on over every hole
FELT_BELOW = 0.005
SCATTERED = 2.0  # of what position monitors scatter by, that a stance may be beside what it was
FEELS_ON_MAX = 3  # ticks a foot feels on at its aim: one to get there, one to feel, one to say so


def resting(stance: Stance, place: Body) -> Stance:
    """A stance whose body comes to rest at a place beside its reference."""
    x, y, _, _ = stance.body
    return replace(stance, sway=(place[0] - x, place[1] - y), velocity=(0.0, 0.0))


class Execution:
    """What Level C is at, between one step-switching point and the next.

    ``stance`` is that of the last N_k, ``t`` the time into the running plan (s), ``pace`` how many
    seconds of it are played a second, ``interrupted`` the step that a settling or a contact reflex
    cut short.
    """

    def __init__(
        self,
        machine: Machine,
        gait: Gait,
        stance: Stance,
        config: PlannerConfig | None = None,
        plant: Tolerances | None = None,
    ) -> None:
        self.machine = machine
        self.gait = gait
        given = config or PlannerConfig()
        self.config = replace(given, contact=given.contact.for_size(machine.size))
        self.tolerances = self.config.tracking.within(plant or Tolerances())
        self._held_back = self.tolerances.held_back
        self._gains = self.config.gains
        self.stance = stance
        self.tracker = TrajectoryTracker(holding_plan(stance))
        self.t = 0.0
        self.pace = 0.0
        self.reflexes = ReflexState.begin(len(machine.legs))
        self.interrupted: StepPlan | None = None
        # None: a plant that does exactly what it is told
        self.compliant = CompliantController.wanted(machine, self.config, self.tolerances)
        self._felt_on = 0  # ticks the feet have felt on for ground since the plan was over
        self.rested: Stance | None = None  # with its reference, as a swaying body came to rest

    # the plan

    @property
    def plan(self) -> StepPlan:
        """The plan that runs; a machine that stands plays one that holds."""
        return self.tracker.plan

    @property
    def phase(self) -> Phase:
        """What the swing legs do now."""
        return self.tracker.phase(self.t)

    @property
    def on_all_feet(self) -> bool:
        """True on stretches in which no leg swings."""
        return self.tracker.phase(self.t) in ON_ALL_FEET

    def play(self, plan: StepPlan) -> None:
        """Begin a plan."""
        if self.compliant is not None:
            left = self.tracker.duration - self.t
            self.compliant.take_over(self.tracker, left / max(self.pace, 1.0))
        self.tracker = TrajectoryTracker(plan, self.stance.lifted)
        self.reflexes = self.reflexes.next_step()
        self.t = 0.0
        self._felt_on = 0

    def gently(self, plan: StepPlan, terrain: TerrainMap) -> StepPlan:
        """A plan with smooth swings and shifts, unless walks are to be as printed."""
        if not (self.gait.sways and self.gait.smooth):
            return plan
        return gentle(plan, self.machine, legs_on_known_ground(plan, terrain), self.acceleration)

    def hold(self, stance: Stance) -> None:
        """Stand as it stands, from a step-switching point on."""
        if stance.sway != (0.0, 0.0):
            self.rested = resting(stance, stance.place)
        self.stance = stance.at_rest()
        self.play(holding_plan(self.stance))
        self.pace = 0.0

    @property
    def acceleration(self) -> float:
        """The most the body may speed up or slow down, m/s²."""
        return bounds_of(self.stance, self.gait).acceleration

    @property
    def comes_to_rest(self) -> bool:
        """True while the body is still to slow down."""
        return self.t < self.tracker.rests_from - END

    def time_ahead(self) -> tuple[float, float]:
        """Time into the plan one tick on, and how much of the tick, s, its end leaves over."""
        if self.pace > 1.0:
            return self.tracker.onward(self.t, TICK, self.pace, self.machine)
        t_next = self.t + self.pace * TICK
        return t_next, (t_next - self.tracker.duration) / self.pace if self.pace > 0.0 else 0.0

    def is_over(self, t: float) -> bool:
        """True when the plan has come to its end by ``t``."""
        return t >= self.tracker.duration - END

    def velocities_to(self, t_next: float, sensing: Sensing) -> list[Point]:
        """Level C of this tick: foot velocities in body axes, m/s, in leg order."""
        if self.compliant is None:
            velocities, self.reflexes = reflex(
                self.tracker, t_next, sensing, self.reflexes, self._gains, TICK
            )
        else:
            velocities, self.reflexes = self.compliant.velocities(
                self.tracker, t_next, sensing, self.reflexes
            )
        self.t = t_next
        return velocities

    # the legs

    def carrying(self, standing: bool) -> tuple[bool, ...]:
        """Legs meant to carry: all that do not swing, and swing legs that have landed early."""
        carrying = [True] * len(self.machine.legs)
        if standing:
            for leg in self.stance.lifted:
                carrying[leg] = False
            return tuple(carrying)
        plan = self.tracker.plan
        for leg in plan.end.lifted:
            carrying[leg] = leg in plan.swing
        landed = self.reflexes.landed
        for leg in self.stance.lifted if self.on_all_feet else plan.swing:
            carrying[leg] = landed[leg]
        return tuple(carrying)

    def landed(self, leg: int) -> bool:
        """True of a swing leg that has touched down in this plan."""
        return self.reflexes.landed[leg]

    def misses_ground(self, lifts: bool) -> bool:
        """True when a swing leg has not touched down, though the plan is over; ``lifts``: those
        that stay in the air across the switch do not count.
        """
        waiting = self.plan.end.lifted if lifts else ()
        return any(leg not in waiting and not self.landed(leg) for leg in self.plan.swing)

    def feels_on(self, lifts: bool, sensing: Sensing) -> bool:
        """True when the plan is over and a swing leg may yet touch down: it has hardly been below
        the ground expected, or its sole has just come on. Call it once a tick; it says so a few
        times only.
        """
        waiting = self.plan.end.lifted if lifts else ()
        legs = [leg for leg in self.plan.swing if leg not in waiting and not self.landed(leg)]
        if self._felt_on >= FEELS_ON_MAX or not legs:
            return False
        self._felt_on += 1
        feet = feet_absolute(sensing)
        return any(
            sensing.soles[leg] or feet[leg][2] > self.plan.end.feet[leg][2] - FELT_BELOW
            for leg in legs
        )

    def in_the_air(self) -> list[int]:
        """Swing legs that are in the air now: none of a plan that has not begun to lift them."""
        if self.on_all_feet or self.t <= 0.0:
            return [leg for leg in self.plan.swing if leg in self.stance.lifted]
        return [leg for leg in self.plan.swing if not self.landed(leg)]

    # where the machine really is

    def held_back(self, sensing: Sensing) -> bool:
        """True when the body is not where the plan has it: pushed, slid, or against an obstacle."""
        x, y, _, _ = self.tracker.body_at(self.t)
        body = sensing.body
        limit = self._held_back
        dx = x - body[0]
        dy = y - body[1]
        return dx > limit or dx < -limit or dy > limit or dy < -limit

    def arrived(self, sensing: Sensing) -> Stance:
        """The stance at N_{k+1}: the plan's end when all went as planned up to this tick, in which
        the last of the way is still to go. A foot that stays lifted has its last to go as well.
        """
        end = self.plan.end
        now = self.tracker.body_at(self.t)
        lean = self.tracker.lean_at(self.t)
        in_the_air = {leg: self.tracker.foot_at(leg, self.t) for leg in end.lifted}
        feet = with_feet(end.feet, in_the_air)
        actual = self.actual(sensing, replace(end.at_rest(), body=now, feet=feet, lean=lean))
        if actual.body == now and actual.feet == feet:
            return end
        x, y, z, yaw = actual.body
        if self.plan.rates is not None:
            way = zip(actual.body, end.place, now, strict=True)
            x, y, z, yaw = (place + last - before for place, last, before in way)
        dx, dy = end.sway
        reference = (x - dx, y - dy, z - end.lean[0] * dx - end.lean[1] * dy, yaw)
        return replace(actual, body=reference, sway=end.sway, velocity=end.velocity)

    def standing(self, sensing: Sensing) -> Stance:
        """What the next step is decided from: by the reference that a body still rests beside."""
        if self.rested and self.actual(sensing, self.rested) == self.rested.at_rest():
            return self.rested
        return self.actual(sensing, self.stance)

    def actual(self, sensing: Sensing, expected: Stance) -> Stance:
        """The sensed stance, at rest, or ``expected`` itself when it came out so."""
        expected = expected.at_rest()
        x, y, z, roll, pitch, yaw = sensing.body
        feet = feet_absolute(sensing)
        lean = self.tracker.lean_at(self.t)
        if lean != expected.lean:
            expected = replace(expected, lean=lean)
        if self.tracker.leans:
            wanted_roll, wanted_pitch = attitude_of(lean, yaw)
            roll -= wanted_roll
            pitch -= wanted_pitch
        ex, ey, ez, eyaw = expected.body
        off = max(abs(x - ex), abs(y - ey), abs(z - ez), abs(yaw - eyaw), abs(roll), abs(pitch))
        for foot, wanted in zip(feet, expected.feet, strict=True):
            off = max(off, *(abs(a - b) for a, b in zip(foot, wanted, strict=True)))
        if off <= self.tolerances.same_place:
            return expected
        moved = moved_whole(expected, (x, y, z, yaw), feet, self.tolerances)
        return moved or replace(expected, body=(x, y, z, yaw), feet=feet)

    def remembered(
        self, sensing: Sensing, cut_short: StepPlan | None, lifted: tuple[int, ...] = ()
    ) -> Stance:
        """What the planner should remember after a step that was cut short: who swung last, if
        anybody did, and which legs are ``lifted`` now.
        """
        if cut_short is None or cut_short.landing is None or not cut_short.swing:
            same = self.stance.lifted == lifted
            return self.stance if same else replace(self.stance, lifted=lifted)
        u = cut_short.swing[0]
        at = self.actual(sensing, cut_short.end).feet[u]
        off = math.hypot(at[0] - cut_short.landing[0], at[1] - cut_short.landing[1])
        finished = off <= self.tolerances.landed_as_planned
        return replace(
            cut_short.end,
            last_swing=u if finished else self.stance.last_swing,
            lifted=lifted,
            course=self._course_at(sensing, cut_short),
        )

    def _course_at(self, sensing: Sensing, plan: StepPlan) -> float:
        """s where the body stands in a step cut short, m: between its ends by how far it has
        got.
        """
        start = plan.body[0]
        end = plan.end.body
        rho = self.machine.yaw_length
        way = math.hypot(end[0] - start[0], end[1] - start[1], rho * (end[3] - start[3]))
        if way < self.tolerances.same_place:
            return plan.end.course
        x, y, yaw = sensing.body[0], sensing.body[1], sensing.body[5]
        gone = math.hypot(x - start[0], y - start[1], rho * (yaw - start[3]))
        return self.stance.course + min(gone / way, 1.0) * (plan.end.course - self.stance.course)


def moved_whole(
    expected: Stance, body: Body, feet: Sequence[Point], tolerances: Tolerances
) -> Stance | None:
    """The stance moved as a whole to where the body is; None when more than what sensors scatter is
    left of its feet beside that, and of sensors that do not.
    """
    if not tolerances.scatters:
        return None
    ex, ey, ez, eyaw = expected.body
    x, y, z, yaw = body
    left = max(SCATTERED * tolerances.position_noise, tolerances.same_place)
    if abs(z - ez) > left:
        return None
    if max(abs(x - ex), abs(y - ey), abs(yaw - eyaw)) <= tolerances.same_place:
        at = expected
    else:
        pose = x, y, yaw
        seen_from = (seen((ex, ey, eyaw), fx, fy) for fx, fy, _ in expected.feet)
        places = (placed(pose, *foot) for foot in seen_from)
        moved = tuple(
            (fx, fy, foot[2]) for (fx, fy), foot in zip(places, expected.feet, strict=True)
        )
        at = replace(expected, body=(x, y, ez, yaw), feet=moved)
    pairs = zip(feet, at.feet, strict=True)
    near = all(abs(a - b) <= left for foot, spot in pairs for a, b in zip(foot, spot, strict=True))
    return at if near else None


def kept_stance(run: Execution) -> Stance:
    """The stance of the last N_k, by the reference that a body still rests beside."""
    rested = run.rested
    if rested is None or rested.feet != run.stance.feet:
        return run.stance
    off = math.dist(rested.place, run.stance.place)
    return rested if off <= run.tolerances.same_place else run.stance


def came_as_planned(came: Stance, planned: Stance, tolerances: Tolerances) -> bool:
    """True when a plan came out near enough to what the next one of its posture begins with."""
    if came is planned:
        return True
    body = zip(came.body, planned.body, strict=True)
    feet = (
        pair
        for one, two in zip(came.feet, planned.feet, strict=True)
        for pair in zip(one, two, strict=True)
    )
    return all(abs(a - b) <= tolerances.body_off for a, b in body) and all(
        abs(a - b) <= tolerances.foot_off for a, b in feet
    )


def feet_absolute(sensing: Sensing) -> tuple[Point, ...]:
    """Foot tips in the absolute frame from position monitors, posture and dead reckoning, m."""
    x, y, z, roll, pitch, yaw = sensing.body
    cr, sr = direction(roll)
    cp, sp = direction(pitch)
    cy, sy = direction(yaw)
    feet = []
    for fx, fy, fz in sensing.feet_b:
        ry = cr * fy - sr * fz
        rz = sr * fy + cr * fz
        px = cp * fx + sp * rz
        pz = cp * rz - sp * fx
        feet.append((x + cy * px - sy * ry, y + sy * px + cy * ry, z + pz))
    return tuple(feet)


def off_place(run: Execution, sensing: Sensing) -> dict[str, float | str]:
    """How far the body is from where its legs should have it, mm, and to which side of it."""
    x, y, _, yaw = run.tracker.body_at(run.t)
    dx = sensing.body[0] - x
    dy = sensing.body[1] - y
    ahead = math.cos(math.atan2(dy, dx) - yaw - run.plan.crab_angle)
    side = "beside"
    if abs(ahead) > AHEAD:
        side = "ahead of" if ahead > 0.0 else "behind"
    return {"off": 1000.0 * math.hypot(dx, dy), "side": side}
