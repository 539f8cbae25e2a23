"""What the feet feel beside their plan: obstacles on their way, edges, ground that is not there."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..geometry.transforms import left_fold_sum
from ..motion.body_tilt import unleaned
from ..terrain.map import TerrainMap
from ..types import Phase, Point, Sensing, StepPlan
from .encounter import ContactEvent, Encounter, FootState, at_top
from .execution import Execution, feet_absolute

AHEAD = 0.5  # cosine of how far aside of its way, 60°, a foot takes what it feels for an obstacle
LOOKS_ON = 0.1  # s of the plan, over which the way of the foot is told
LEVEL = 0.01  # m; ground higher than this beside a sole stands beside it
CLOSE_BY = 3  # whiskers that touch what stands nearer than ``CLOSE`` of their reach
CLOSE = math.sqrt(0.5)  # of the reach of one 45° aside, seen straight ahead
# looked at every tick: a name of the module is found quicker than one of a class
_RETURN = Phase.RETURN
_DOWN = Phase.DOWN


class Touch(NamedTuple):
    """Something met that the map does not show."""

    event: ContactEvent
    leg: int
    bearing: float | None  # rad, absolute: where it was felt, None if it was not
    tall: float | None = None  # m, absolute: what stands close beside it is at least so high


class Feelers:
    """Soles and whiskers, read against the plan that runs and the map."""

    def __init__(self, run: Execution) -> None:
        self._run = run
        self._settings = run.config.contact
        self._plan: StepPlan | None = None
        # legs that have been off the ground since the plan began
        self._off: set[int] = set()
        # leg: in which absolute direction its whiskers first felt what they still feel close by,
        # and how high, m, it was then
        self._tall: dict[int, tuple[float | None, float]] = {}

    def surprise(self, sensing: Sensing, terrain: TerrainMap) -> Touch | None:
        """Case 1 or 3 in the running plan: a swing foot meets what the map does not show, or its
        foothold is an edge, or closer beside something than the map has it.
        """
        run = self._run
        tracker = run.tracker
        plan = tracker.plan
        phase = plan.phases[tracker.stretch(run.t)]
        if phase is _RETURN:
            off = self._off if plan is self._plan else ()
            for leg in plan.swing:
                if leg in off and not (sensing.whiskers[leg] or sensing.soles[leg]):
                    continue  # as in most ticks
                felt = self._felt(leg, sensing, terrain)
                if felt is not None or self._drags(leg, sensing):
                    return Touch(ContactEvent.HIT, leg, felt)
        elif phase is _DOWN:
            for leg in plan.swing:
                if self._tall or sensing.whiskers[leg]:
                    self._look_beside(leg, sensing)
                if not sensing.soles[leg] or run.landed(leg):
                    continue
                if hangs_over(leg, sensing):
                    return Touch(ContactEvent.EDGE, leg, hangs_over_towards(leg, sensing))
                if self._is_closer_than_shown(leg, sensing, terrain):
                    return Touch(ContactEvent.EDGE, leg, None, self._tall[leg][1])
        return None

    def noticed(self, encounter: Encounter, sensing: Sensing, terrain: TerrainMap) -> Touch | None:
        """What has happened in this tick of an encounter, if its table knows it."""
        leg = encounter.leg
        self._look_beside(leg, sensing)
        bearing = self._felt(leg, sensing, terrain)
        event = self._event(encounter, sensing, bearing)
        _, tall = self._tall.get(leg, (None, None))
        return None if event is None else Touch(event, leg, bearing, tall)

    def _event(
        self, encounter: Encounter, sensing: Sensing, bearing: float | None
    ) -> ContactEvent | None:
        run = self._run
        phase = run.phase
        if phase is Phase.DOWN and (came := self._came_down(encounter, sensing)):
            return came
        drags = self._drags(encounter.leg, sensing)
        if phase is Phase.RETURN and encounter.state in _MOVING_ON:
            if bearing is not None or drags:
                return ContactEvent.HIT
            if encounter.state in _LIFTED_FIRST and encounter.leg not in self._off:
                return ContactEvent.LANDED  # the leg cannot be drawn off what it stands on
        if not run.is_over(run.t):
            return None
        if encounter.state is FootState.CLIMB:
            return self._climbed(encounter, sensing)
        return ContactEvent.NO_GROUND if phase is Phase.DOWN else ContactEvent.DONE

    def _climbed(self, encounter: Encounter, sensing: Sensing) -> ContactEvent:
        """A little higher: is it free there, or can the leg be drawn no higher?"""
        high = self.is_at_top(encounter.leg, sensing)
        free = felt_towards(encounter, sensing) is None
        if high and (encounter.at_top or not free):
            return ContactEvent.TOP
        if free:
            return ContactEvent.CLEAR
        return ContactEvent.TOP if encounter.hits >= self._settings.hits_max else ContactEvent.DONE

    def is_at_top(self, leg: int, sensing: Sensing) -> bool:
        """True when the leg is drawn as high as it can be."""
        here = unleaned(self._run.actual(sensing, self._run.plan.end))
        return at_top(here, leg, self._run.machine)

    def _look_beside(self, leg: int, sensing: Sensing) -> None:
        """Keep where the foot first felt what stands close beside it, and how high it was."""
        if sensing.whiskers[leg].bit_count() < CLOSE_BY:
            if self._tall:
                self._tall.pop(leg, None)
        elif leg not in self._tall:
            self._tall[leg] = stands_beside(leg, sensing), feet_absolute(sensing)[leg][2]

    def _came_down(self, encounter: Encounter, sensing: Sensing) -> ContactEvent | None:
        """Its sole is on: for good, or is that no foothold? Better a bad one than none."""
        leg = encounter.leg
        landed = self._run.landed(leg)
        bad = landed and hangs_over(leg, sensing)
        bad = bad or self._fell_beside(encounter, sensing)
        if bad and encounter.edges < self._settings.edges_max:
            return ContactEvent.EDGE
        return ContactEvent.LANDED if landed else None

    def _fell_beside(self, encounter: Encounter, sensing: Sensing) -> bool:
        """True of a foot that met something, or no ground where the map has it, and came down close
        before what stands there: it missed that, by less than its sole; or close before what it
        went down from. Whiskers say so at once only: those of a foot that carries feel nothing.
        """
        leg = encounter.leg
        if encounter.state not in _SURPRISED or leg not in self._tall or not sensing.soles[leg]:
            return False
        if self._is_ahead(leg):
            return True
        return encounter.state is FootState.DESCEND

    def _is_ahead(self, leg: int) -> bool:
        """True when what stands close beside a foot stands where the machine is going."""
        beside, _ = self._tall[leg]
        plan = self._run.interrupted or self._run.plan
        return beside is not None and math.cos(beside - plan.end.body[3] - plan.crab_angle) > AHEAD

    def _is_closer_than_shown(self, leg: int, sensing: Sensing, terrain: TerrainMap) -> bool:
        """True of a foot that has come down close beside what the map has not there."""
        if leg not in self._tall:
            return False
        return not self._is_shown_close_by(feet_absolute(sensing)[leg], terrain)

    def _drags(self, leg: int, sensing: Sensing) -> bool:
        """True when a foot that was off the ground drags over it on its way."""
        if self._plan is not self._run.plan:
            self._plan = self._run.plan
            self._off = set()
        if not sensing.soles[leg]:
            self._off.add(leg)
            return False
        return leg in self._off

    def _felt(self, leg: int, sensing: Sensing, terrain: TerrainMap) -> float | None:
        """Absolute bearing of something felt on the foot's way that the map does not show; None
        when there is nothing.
        """
        bits = sensing.whiskers[leg]
        if not bits:
            return None
        tracker = self._run.tracker
        t = self._run.t
        here = tracker.foot_at(leg, t)
        there = tracker.foot_at(leg, min(t + LOOKS_ON, tracker.duration))
        if here[0] == there[0] and here[1] == there[1]:
            return None
        yaw = sensing.body[5]
        ahead = felt_ahead(bits, math.atan2(there[1] - here[1], there[0] - here[0]) - yaw)
        if ahead is None or self._is_shown(feet_absolute(sensing)[leg], terrain):
            return None
        return ahead + yaw

    def _is_shown(self, foot: Point, terrain: TerrainMap) -> bool:
        """True when the map has ground higher than the foot within reach of its whiskers."""
        reach = self._run.machine.foot_radius + self._settings.whisker_tip + terrain.cell
        return _crest_about(foot, reach, terrain) > foot[2]

    def _is_shown_close_by(self, foot: Point, terrain: TerrainMap) -> bool:
        """True when the map has ground higher than what the foot stands on close beside it."""
        reach = CLOSE * (self._run.machine.foot_radius + self._settings.whisker_tip)
        return _crest_about(foot, reach, terrain) > foot[2] + LEVEL


def _crest_about(foot: Point, reach: float, terrain: TerrainMap) -> float:
    x, y, _ = foot
    return terrain.crest_in(x - reach, x + reach, y - reach, y + reach)


_LIFTED_FIRST = (FootState.RETRY, FootState.PLACE)
_SURPRISED = (FootState.RETRY, FootState.DESCEND)
_MOVING_ON = (FootState.RETRY, FootState.PLACE, FootState.RETRACE)


def felt_towards(encounter: Encounter, sensing: Sensing) -> float | None:
    """Absolute bearing of something felt between the foot and where it was to land."""
    foot = feet_absolute(sensing)[encounter.leg]
    goal = encounter.goal
    yaw = sensing.body[5]
    bearing = math.atan2(goal[1] - foot[1], goal[0] - foot[0]) - yaw
    ahead = felt_ahead(sensing.whiskers[encounter.leg], bearing)
    return None if ahead is None else ahead + yaw


def hangs_over(leg: int, sensing: Sensing) -> bool:
    """True when a sole hangs over an edge, of a machine that feels it."""
    return bool(sensing.rims) and sensing.rims[leg] != 0


def hangs_over_towards(leg: int, sensing: Sensing) -> float | None:
    """Absolute direction in which the sole hangs over."""
    bearing = _mean_bearing(_bearings(sensing.rims[leg] if sensing.rims else 0))
    return None if bearing is None else bearing + sensing.body[5]


def stands_beside(leg: int, sensing: Sensing) -> float | None:
    """Absolute direction of something that stands close beside a foot; None when nothing does."""
    bits = sensing.whiskers[leg]
    if bits.bit_count() < CLOSE_BY:
        return None
    bearing = _mean_bearing(_bearings(bits))
    return None if bearing is None else bearing + sensing.body[5]


def felt_ahead(bits: int, bearing_b: float) -> float | None:
    """Where in the forward half of eight whiskers something is felt, body axes; None when it is
    free that way.
    """
    return _mean_bearing(
        [angle for angle in _bearings(bits) if math.cos(angle - bearing_b) > AHEAD]
    )


def _bearings(bits: int) -> list[float]:
    """The directions of eight whose bits are set, rad."""
    return [k * math.pi / 4 for k in range(8) if bits >> k & 1]


def _mean_bearing(angles: list[float]) -> float | None:
    """The direction between several, rad; None without any, and when they cancel out."""
    sine = left_fold_sum(map(math.sin, angles))
    cosine = left_fold_sum(map(math.cos, angles))
    return None if math.hypot(sine, cosine) < 1e-9 else math.atan2(sine, cosine)
