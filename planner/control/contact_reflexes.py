"""Emergent motions (H §9): what a swing leg does when the ground is not what the plan took it for.

Three cases: (1) the swing foot hits something, (2) there is no ground at N_{k+1}, (3) the foothold
gives way or is an edge. The body stops at once (static stability makes that safe at any tick) and
stays until the foot stands. What happens next is a transition table, and each state is a motion of
one foot, handed over as a ``StepPlan`` like every other.

In case 1 the letters of H §9.2: (a) stop, retrace the way and lift; (b) go again, slower, the
others standing; (c) on a new hit lift on, whiskers keeping clear; (d), (e) over it: come down; (f)
no way over: mark the cells, search again from here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import NamedTuple

from ..config import Contact
from ..geometry.transforms import direction, left_fold_sum, placed
from ..motion.body_tilt import leaning, unleaned
from ..motion.foot_placement import place_foot
from ..motion.step_builder import FootWay, body_still_plan
from ..motion.swing import profile_of, swing_speeds
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Blocked, Gait, Phase, Point, Sensing, Stance, StepPlan
from .execution import Execution, feet_absolute

Cells = set[tuple[int, int]]  # row, column

AHEAD = 0.5  # cosine of how far aside of its way, 60°, a foot takes what it feels for an obstacle
FEELS_AHEAD = 0.1  # s along the plan, over which the way of the foot is told


class FootState(StrEnum):
    """What the foot is doing."""

    NORMAL = "normal"
    RETRACE = "retrace"  # 1 (a)
    RETRY = "retry"  # 1 (b), (d), (e)
    CLIMB = "climb"  # 1 (c)
    DESCEND = "descend"  # 2
    WITHDRAW = "withdraw"  # 3: off the foothold that gives way
    SEARCH = "search"  # 1 (f), 2, 3: back to Level B
    PLACE = "place"  # to the new landing point
    STRANDED = "stranded"  # no landing point is left


class ContactEvent(StrEnum):
    """What the sensors say of it."""

    HIT = "hit"  # whiskers ahead touch, or the foot is held
    DONE = "done"  # the motion came to its end
    CLEAR = "clear"  # whiskers ahead are free again
    TOP = "top"  # the leg can be drawn no higher
    LANDED = "landed"
    NO_GROUND = "no ground"  # down to the bottom of the reach, and nothing
    EDGE = "edge"  # the sole hangs over, or the foothold gave way
    FOUND = "found"
    NOTHING = "nothing"
    ORDER = "order"  # the operator wants to go on


TABLE: dict[tuple[FootState, ContactEvent], FootState] = {
    (FootState.NORMAL, ContactEvent.HIT): FootState.RETRACE,  # case 1
    (FootState.NORMAL, ContactEvent.NO_GROUND): FootState.DESCEND,  # case 2
    (FootState.NORMAL, ContactEvent.EDGE): FootState.WITHDRAW,  # case 3
    (FootState.RETRACE, ContactEvent.DONE): FootState.RETRY,  # (a) → (b)
    (FootState.RETRACE, ContactEvent.HIT): FootState.CLIMB,
    (FootState.RETRY, ContactEvent.HIT): FootState.CLIMB,  # (b) → (c)
    (FootState.RETRY, ContactEvent.LANDED): FootState.NORMAL,  # (d), (e)
    (FootState.RETRY, ContactEvent.NO_GROUND): FootState.SEARCH,
    (FootState.RETRY, ContactEvent.EDGE): FootState.WITHDRAW,
    (FootState.CLIMB, ContactEvent.CLEAR): FootState.RETRY,  # (c) → (b): over it, perhaps
    (FootState.CLIMB, ContactEvent.DONE): FootState.CLIMB,
    (FootState.CLIMB, ContactEvent.TOP): FootState.SEARCH,  # (f)
    (FootState.DESCEND, ContactEvent.LANDED): FootState.NORMAL,
    (FootState.DESCEND, ContactEvent.NO_GROUND): FootState.SEARCH,
    (FootState.DESCEND, ContactEvent.EDGE): FootState.WITHDRAW,
    (FootState.WITHDRAW, ContactEvent.DONE): FootState.SEARCH,
    (FootState.SEARCH, ContactEvent.FOUND): FootState.PLACE,
    (FootState.SEARCH, ContactEvent.NOTHING): FootState.STRANDED,
    (FootState.PLACE, ContactEvent.HIT): FootState.SEARCH,
    (FootState.PLACE, ContactEvent.NO_GROUND): FootState.SEARCH,
    (FootState.PLACE, ContactEvent.EDGE): FootState.WITHDRAW,
    (FootState.PLACE, ContactEvent.LANDED): FootState.NORMAL,
    (FootState.STRANDED, ContactEvent.ORDER): FootState.SEARCH,
}


@dataclass(frozen=True, slots=True)
class Encounter:
    """One emergent motion under way: its state, whose foot it is, and where that foot was to land."""

    state: FootState
    leg: int
    goal: Point  # J_u of the step that was cut short
    hits: int = 0
    misses: int = 0  # times no ground was found

    def after(self, event: ContactEvent) -> Encounter:
        """The encounter once ``event`` has happened; raises ``KeyError`` for an event its state
        does not know.
        """
        return replace(
            self,
            state=TABLE[self.state, event],
            hits=self.hits + (event is ContactEvent.HIT),
            misses=self.misses + (event is ContactEvent.NO_GROUND),
        )


class Situation(NamedTuple):
    """What a motion starts from."""

    here: Stance  # the present pose, the foot where it is
    bearing: float | None  # rad, absolute: where the obstacle was felt, None if it was not
    terrain: TerrainMap
    machine: Machine
    gait: Gait
    settings: Contact


def motion(encounter: Encounter, at: Situation) -> StepPlan | Blocked:
    """The motion of ``encounter``'s state; ``Blocked`` when there is no ground to put the foot on."""
    return _MOTIONS[encounter.state](encounter, at)


def _retrace(encounter: Encounter, at: Situation) -> StepPlan:
    """(a) Away from what was hit, then up."""
    return _back_and_up(encounter, at, at.settings.retreat)


def _climb(encounter: Encounter, at: Situation) -> StepPlan:
    """(c) A little back, to keep clear, and a little higher."""
    return _back_and_up(encounter, at, at.settings.keep_clear)


def _back_and_up(encounter: Encounter, at: Situation, way: float) -> StepPlan:
    """So many metres back from what was felt, and a little higher."""
    x, y, z = at.here.feet[encounter.leg]
    goal = encounter.goal
    away = math.atan2(goal[1] - y, goal[0] - x) if at.bearing is None else at.bearing
    c, s = direction(away)
    back = (x - way * c, y - way * s, z)
    highest = ceiling(at.here, encounter.leg, at.machine)
    up = (back[0], back[1], min(z + at.settings.lift_step, highest))
    phases = (Phase.RETURN, Phase.UP)
    return _moved(at, encounter.leg, [back, up], phases, at.settings.slower)


def _retry(encounter: Encounter, at: Situation) -> StepPlan:
    """(b) Towards the landing point again, slower, at this height, and down as far as the leg
    reaches.
    """
    foot, goal = at.here.feet[encounter.leg], encounter.goal
    over = (goal[0], goal[1], foot[2])
    down = (goal[0], goal[1], min(floor(at.here, encounter.leg, at.machine), foot[2]))
    return _moved(at, encounter.leg, [over, down], (Phase.RETURN, Phase.DOWN), at.settings.slower)


def _descend(encounter: Encounter, at: Situation) -> StepPlan:
    """Straight down to the bottom of the mechanical reach."""
    foot = at.here.feet[encounter.leg]
    down = (foot[0], foot[1], min(floor(at.here, encounter.leg, at.machine), foot[2]))
    return _moved(at, encounter.leg, [down], (Phase.DOWN,), 1.0)


def _withdraw(encounter: Encounter, at: Situation) -> StepPlan:
    """Off the bad foothold: straight up."""
    foot = at.here.feet[encounter.leg]
    highest = ceiling(at.here, encounter.leg, at.machine)
    up = (foot[0], foot[1], min(foot[2] + at.gait.lift_up, highest))
    return _moved(at, encounter.leg, [up], (Phase.UP,), 1.0)


def _place(encounter: Encounter, at: Situation) -> StepPlan | Blocked:
    """To the nearest ground not yet known to be bad, from where the foot is, backwards included."""
    return place_foot(at.here, encounter.leg, at.terrain, at.machine, at.gait)


_MOTIONS: dict[FootState, Callable[[Encounter, Situation], StepPlan | Blocked]] = {
    FootState.RETRACE: _retrace,
    FootState.RETRY: _retry,
    FootState.CLIMB: _climb,
    FootState.DESCEND: _descend,
    FootState.WITHDRAW: _withdraw,
    FootState.PLACE: _place,
}


def _moved(
    at: Situation, leg: int, knots: list[Point], phases: tuple[Phase, ...], share: float
) -> StepPlan:
    """The foot along ``knots`` at a ``share`` of its swing speed."""
    ahead, left, vertical = swing_speeds(at.machine, at.gait, share)
    across = min(ahead, left)
    points = [at.here.feet[leg], *knots]
    seconds = tuple(
        max(math.hypot(b[0] - a[0], b[1] - a[1]) / across, abs(b[2] - a[2]) / vertical)
        for a, b in zip(points, points[1:], strict=False)
    )
    way = FootWay(points, knots[-1])
    return body_still_plan(at.here, {leg: way}, seconds, phases, profile_of(at.gait))


def ceiling(here: Stance, leg: int, machine: Machine) -> float:
    """How high the foot can be drawn now, absolute, m: the top of the mechanical reach."""
    return here.body[2] + machine.legs[leg].z[1] + machine.overreach[2]


def floor(here: Stance, leg: int, machine: Machine) -> float:
    """How low the foot can be put now, absolute, m: the bottom of the mechanical reach."""
    return here.body[2] + machine.legs[leg].z[0] - machine.overreach[2]


def at_top(here: Stance, leg: int, machine: Machine) -> bool:
    """True when the foot is as high as the leg draws it."""
    return here.feet[leg][2] >= ceiling(here, leg, machine) - 1e-3


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


def edge_cells(foot: Point, bearing: float, terrain: TerrainMap, settings: Contact) -> Cells:
    """Cells of a rectangle along an edge that was felt in direction ``bearing`` from the foot (H
    §9.2, last sentence).
    """
    length, depth = settings.edge_length, settings.edge_depth
    across = max(1, math.ceil(depth / (terrain.cell / 2)))
    along = max(1, math.ceil(length / (terrain.cell / 2)))
    pose = (foot[0], foot[1], bearing)
    cells = (
        terrain.cell_at(*placed(pose, depth * i / across, length * j / along - length / 2))
        for i in range(across + 1)
        for j in range(along + 1)
    )
    return {cell for cell in cells if cell is not None}


def cells_near(foot: Point, radius: float, terrain: TerrainMap) -> Cells:
    """Cells whose centre is within ``radius`` of a foot, seen from above."""
    reach = math.ceil(radius / terrain.cell)
    at = terrain.cell_at(foot[0], foot[1])
    if at is None:
        return set()
    rows = range(max(0, at[0] - reach), min(terrain.rows - 1, at[0] + reach) + 1)
    columns = range(max(0, at[1] - reach), min(terrain.columns - 1, at[1] + reach) + 1)
    centres = ((row, column, *terrain.centre(row, column)) for row in rows for column in columns)
    return {
        (row, column)
        for row, column, x, y in centres
        if math.hypot(x - foot[0], y - foot[1]) <= radius
    }


def cell_of(foot: Point, terrain: TerrainMap) -> Cells:
    """The one cell under a foot, if the map has it."""
    cell = terrain.cell_at(foot[0], foot[1])
    return set() if cell is None else {cell}


class Touch(NamedTuple):
    """Something met that the map does not show."""

    event: ContactEvent
    leg: int
    bearing: float | None  # rad, absolute: where it was felt, None if it was not


class ContactReflexes:
    """What the feet feel beside their plan, the encounter under way, and what was learnt of it.

    ``counts`` says how many encounters began, by what they began with.
    """

    def __init__(self, run: Execution) -> None:
        self.encounter: Encounter | None = None
        self.counts: dict[str, int] = {}
        self._run = run
        self._settings = run.config.contact
        self._learnt: Cells = set()
        # near where this encounter found no ground: searched last, not remembered
        self._shunned: Cells = set()

    # noticing

    def surprise(self, sensing: Sensing, terrain: TerrainMap) -> Touch | None:
        """Case 1 or 3 in the running plan: a swing foot meets what the map does not show, or its
        foothold is an edge.
        """
        run = self._run
        for leg in run.plan.swing:
            phase = run.phase
            if phase is Phase.RETURN:
                felt = self._felt(leg, sensing, terrain)
                if felt is not None:
                    return Touch(ContactEvent.HIT, leg, felt)
            elif phase is Phase.DOWN and sensing.soles[leg] and not run.landed(leg):
                if _hangs_over(leg, sensing):
                    return Touch(ContactEvent.EDGE, leg, _over(leg, sensing))
        return None

    def missing_ground(self) -> Touch:
        """Case 2: the plan is over and a foot has found no ground."""
        leg = next(leg for leg in self._run.plan.swing if not self._run.landed(leg))
        return Touch(ContactEvent.NO_GROUND, leg, None)

    def noticed(self, sensing: Sensing, terrain: TerrainMap) -> Touch | None:
        """What has happened in this tick of the encounter, if the table knows it."""
        encounter = self.encounter
        if encounter is None:
            return None
        bearing = self._felt(encounter.leg, sensing, terrain)
        event = self._event(encounter, sensing, bearing)
        return None if event is None else Touch(event, encounter.leg, bearing)

    def _event(
        self, encounter: Encounter, sensing: Sensing, bearing: float | None
    ) -> ContactEvent | None:
        run = self._run
        phase = run.phase
        if phase is Phase.DOWN and run.landed(encounter.leg):
            over = _hangs_over(encounter.leg, sensing)
            return ContactEvent.EDGE if over else ContactEvent.LANDED
        if phase is Phase.RETURN and bearing is not None and encounter.state in _MOVING_ON:
            return ContactEvent.HIT
        if not run.is_over(run.t):
            return None
        if encounter.state is FootState.CLIMB:
            return self._climbed(encounter, sensing)
        return ContactEvent.NO_GROUND if phase is Phase.DOWN else ContactEvent.DONE

    def _climbed(self, encounter: Encounter, sensing: Sensing) -> ContactEvent:
        """A little higher: is it free there, or can the leg be drawn no higher?"""
        if _felt_towards(encounter, sensing) is None:
            return ContactEvent.CLEAR
        here = unleaned(self._run.actual(sensing, self._run.plan.end))
        high = at_top(here, encounter.leg, self._run.machine)
        enough = encounter.hits >= self._settings.hits_max
        return ContactEvent.TOP if high or enough else ContactEvent.DONE

    # answering

    def meet(self, touch: Touch) -> Encounter:
        """A new encounter: the body has stopped, what the foot does next is the table's to say."""
        name = touch.event.value
        self.counts[name] = self.counts.get(name, 0) + 1
        landing = self._run.plan.landing or self._run.plan.end.feet[touch.leg]
        return Encounter(FootState.NORMAL, touch.leg, landing).after(touch.event)

    def ordered_on(self) -> Encounter | None:
        """A stranded foot searches again, everywhere; None when no encounter is under way."""
        if self.encounter is None:
            return None
        self._shunned = set()
        return replace(self.encounter, misses=0).after(ContactEvent.ORDER)

    def over(self) -> None:
        """The foot stands, or is given up."""
        self.encounter = None
        self._shunned = set()

    def answer(
        self, encounter: Encounter, touch: Touch | None, sensing: Sensing, terrain: TerrainMap
    ) -> StepPlan | Blocked:
        """The motion of an encounter's new state, which is the one under way from now on; a search
        is answered at once.
        """
        bearing = None if touch is None else touch.bearing
        here = self._run.actual(sensing, self._run.plan.end)
        if encounter.state is not FootState.SEARCH:
            self.encounter = encounter
            return self._motion(encounter, here, bearing, terrain)
        near = self._settings.shy * encounter.misses
        self._shunned |= cells_near(here.feet[encounter.leg], near, terrain)
        searched = terrain.forbid(self._learnt | self._shunned)
        placing = replace(encounter, state=FootState.PLACE)
        answer = self._motion(placing, here, bearing, searched)
        found = isinstance(answer, StepPlan)
        self.encounter = encounter.after(ContactEvent.FOUND if found else ContactEvent.NOTHING)
        return answer

    def _motion(
        self, encounter: Encounter, here: Stance, bearing: float | None, terrain: TerrainMap
    ) -> StepPlan | Blocked:
        run = self._run
        frame = leaning(here, terrain, run.machine)
        situation = Situation(
            frame.stance, bearing, frame.terrain, frame.machine, run.gait, self._settings
        )
        answer = motion(encounter, situation)
        return frame.restored(answer, here) if isinstance(answer, StepPlan) else answer

    # learning

    def learn(self, touch: Touch, sensing: Sensing, terrain: TerrainMap, placing: bool) -> None:
        """What touch has shown is no ground: one cell, or a rectangle along an edge whose direction
        was felt. ``placing``: the foot was being put down after its step already.
        """
        foot = feet_absolute(sensing)[touch.leg]
        under = cell_of(foot, terrain)
        if self._bars_the_way(touch.event):
            assert self.encounter is not None
            known = _felt_towards(self.encounter, sensing)
            self._learnt |= under if known is None else self._edge(foot, known, terrain)
        elif touch.event is ContactEvent.NO_GROUND and placing:
            self._learnt |= under
        elif touch.event is ContactEvent.EDGE:
            over = _over(touch.leg, sensing)
            self._learnt |= under if over is None else self._edge(foot, over, terrain) | under

    def _bars_the_way(self, event: ContactEvent) -> bool:
        if event is ContactEvent.TOP:
            return True
        placing = self.encounter is not None and self.encounter.state is FootState.PLACE
        return event is ContactEvent.HIT and placing

    def _edge(self, foot: Point, bearing: float, terrain: TerrainMap) -> Cells:
        return edge_cells(foot, bearing, terrain, self._settings)

    def take_learnt(self) -> Cells:
        """Cells touch has shown to be no ground, once."""
        learnt = self._learnt
        self._learnt = set()
        return learnt

    def _felt(self, leg: int, sensing: Sensing, terrain: TerrainMap) -> float | None:
        """Absolute bearing of something felt on the foot's way that the map does not show; None
        when there is nothing.
        """
        bits = sensing.whiskers[leg]
        if not bits:
            return None
        tracker, t = self._run.tracker, self._run.t
        here = tracker.foot_at(leg, t)
        there = tracker.foot_at(leg, min(t + FEELS_AHEAD, tracker.duration))
        if here[0] == there[0] and here[1] == there[1]:
            return None
        yaw = sensing.body[5]
        ahead = felt_ahead(bits, math.atan2(there[1] - here[1], there[0] - here[0]) - yaw)
        if ahead is None or self._is_shown(feet_absolute(sensing)[leg], terrain):
            return None
        return ahead + yaw

    def _is_shown(self, foot: Point, terrain: TerrainMap) -> bool:
        """True when the map has ground higher than the foot within reach of its whiskers."""
        x, y, z = foot
        reach = self._run.machine.foot_radius + self._settings.whisker_tip + terrain.cell
        return terrain.crest_in(x - reach, x + reach, y - reach, y + reach) > z


_MOVING_ON = (FootState.RETRY, FootState.PLACE, FootState.RETRACE)


def _felt_towards(encounter: Encounter, sensing: Sensing) -> float | None:
    """Absolute bearing of something felt between the foot and where it was to land."""
    foot, goal, yaw = feet_absolute(sensing)[encounter.leg], encounter.goal, sensing.body[5]
    bearing = math.atan2(goal[1] - foot[1], goal[0] - foot[0]) - yaw
    ahead = felt_ahead(sensing.whiskers[encounter.leg], bearing)
    return None if ahead is None else ahead + yaw


def _hangs_over(leg: int, sensing: Sensing) -> bool:
    """True when a sole hangs over an edge, of a machine that feels it."""
    return bool(sensing.rims) and sensing.rims[leg] != 0


def _over(leg: int, sensing: Sensing) -> float | None:
    """Absolute direction in which the sole hangs over."""
    bearing = _mean_bearing(_bearings(sensing.rims[leg] if sensing.rims else 0))
    return None if bearing is None else bearing + sensing.body[5]
