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

from ..motion.foot_placement import place_foot
from ..motion.step_builder import FootWay, body_still_plan
from ..motion.swing import profile_of, swing_speeds
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Blocked, Gait, Phase, Point, Stance, StepPlan

RETREAT = 0.05  # m back along the way after a hit; less and whiskers still touch
KEEP_CLEAR = 0.02  # m back before each further lift, so that whiskers come free
LIFT_STEP = 0.05  # m a leg is lifted on at a time when the obstacle is still there
SLOWER = 0.5  # of the swing speed: "somewhat lower velocity" (H §9.2 b)
EDGE_LENGTH = 0.30  # m of a sensed edge that is marked, along it
EDGE_DEPTH = 0.10  # m of a sensed edge that is marked, across it
# m: how much farther from where there was no ground it searches with each miss; smaller, see it
# feel out every cell
SHY = 0.04
HITS_MAX = 40  # of one foot before it is set down wherever it may be; reached only between walls


class State(StrEnum):
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


class Event(StrEnum):
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


TABLE: dict[tuple[State, Event], State] = {
    (State.NORMAL, Event.HIT): State.RETRACE,  # case 1
    (State.NORMAL, Event.NO_GROUND): State.DESCEND,  # case 2
    (State.NORMAL, Event.EDGE): State.WITHDRAW,  # case 3
    (State.RETRACE, Event.DONE): State.RETRY,  # (a) → (b)
    (State.RETRACE, Event.HIT): State.CLIMB,
    (State.RETRY, Event.HIT): State.CLIMB,  # (b) → (c)
    (State.RETRY, Event.LANDED): State.NORMAL,  # (d), (e)
    (State.RETRY, Event.NO_GROUND): State.SEARCH,
    (State.RETRY, Event.EDGE): State.WITHDRAW,
    (State.CLIMB, Event.CLEAR): State.RETRY,  # (c) → (b): over it, perhaps
    (State.CLIMB, Event.DONE): State.CLIMB,
    (State.CLIMB, Event.TOP): State.SEARCH,  # (f)
    (State.DESCEND, Event.LANDED): State.NORMAL,
    (State.DESCEND, Event.NO_GROUND): State.SEARCH,
    (State.DESCEND, Event.EDGE): State.WITHDRAW,
    (State.WITHDRAW, Event.DONE): State.SEARCH,
    (State.SEARCH, Event.FOUND): State.PLACE,
    (State.SEARCH, Event.NOTHING): State.STRANDED,
    (State.PLACE, Event.HIT): State.SEARCH,
    (State.PLACE, Event.NO_GROUND): State.SEARCH,
    (State.PLACE, Event.EDGE): State.WITHDRAW,
    (State.PLACE, Event.LANDED): State.NORMAL,
    (State.STRANDED, Event.ORDER): State.SEARCH,
}

# how the log counts them
KINDS = {Event.HIT: "hit", Event.NO_GROUND: "no ground", Event.EDGE: "edge"}


@dataclass(frozen=True, slots=True)
class Encounter:
    """One emergent motion under way: its state, whose foot it is, and where that foot was to land."""

    state: State
    leg: int
    goal: Point  # J_u of the step that was cut short
    hits: int = 0
    misses: int = 0  # times no ground was found

    def after(self, event: Event) -> Encounter:
        """The encounter once ``event`` has happened; raises ``KeyError`` for an event its state
        does not know.
        """
        hits, misses = self.hits + (event is Event.HIT), self.misses + (event is Event.NO_GROUND)
        return replace(self, state=TABLE[self.state, event], hits=hits, misses=misses)


class Situation(NamedTuple):
    """What a motion starts from."""

    here: Stance  # the present pose, the foot where it is
    bearing: float | None  # rad, absolute: where the obstacle was felt, None if it was not
    terrain: TerrainMap
    machine: Machine
    gait: Gait


def motion(encounter: Encounter, at: Situation) -> StepPlan | Blocked:
    """The motion of ``encounter``'s state; ``Blocked`` when there is no ground to put the foot on."""
    return _MOTIONS[encounter.state](encounter, at)


def _retrace(encounter: Encounter, at: Situation) -> StepPlan:
    """(a) Away from what was hit, then up."""
    foot = at.here.feet[encounter.leg]
    away = _bearing_to(foot, encounter.goal) if at.bearing is None else at.bearing
    back = (foot[0] - RETREAT * math.cos(away), foot[1] - RETREAT * math.sin(away), foot[2])
    up = (back[0], back[1], min(foot[2] + LIFT_STEP, ceiling(at.here, encounter.leg, at.machine)))
    return _moved(at, encounter.leg, [back, up], (Phase.RETURN, Phase.UP), SLOWER)


def _retry(encounter: Encounter, at: Situation) -> StepPlan:
    """(b) Towards the landing point again, slower, at this height, and down as far as the leg
    reaches.
    """
    foot, goal = at.here.feet[encounter.leg], encounter.goal
    over = (goal[0], goal[1], foot[2])
    down = (goal[0], goal[1], min(floor(at.here, encounter.leg, at.machine), foot[2]))
    return _moved(at, encounter.leg, [over, down], (Phase.RETURN, Phase.DOWN), SLOWER)


def _climb(encounter: Encounter, at: Situation) -> StepPlan:
    """(c) A little back, to keep clear, and a little higher."""
    foot = at.here.feet[encounter.leg]
    away = _bearing_to(foot, encounter.goal) if at.bearing is None else at.bearing
    back = (foot[0] - KEEP_CLEAR * math.cos(away), foot[1] - KEEP_CLEAR * math.sin(away), foot[2])
    up = (back[0], back[1], min(foot[2] + LIFT_STEP, ceiling(at.here, encounter.leg, at.machine)))
    return _moved(at, encounter.leg, [back, up], (Phase.RETURN, Phase.UP), SLOWER)


def _descend(encounter: Encounter, at: Situation) -> StepPlan:
    """Straight down to the bottom of the mechanical reach."""
    foot = at.here.feet[encounter.leg]
    down = (foot[0], foot[1], min(floor(at.here, encounter.leg, at.machine), foot[2]))
    return _moved(at, encounter.leg, [down], (Phase.DOWN,), 1.0)


def _withdraw(encounter: Encounter, at: Situation) -> StepPlan:
    """Off the bad foothold: straight up."""
    foot = at.here.feet[encounter.leg]
    up = (
        foot[0],
        foot[1],
        min(foot[2] + at.gait.lift_up, ceiling(at.here, encounter.leg, at.machine)),
    )
    return _moved(at, encounter.leg, [up], (Phase.UP,), 1.0)


def _place(encounter: Encounter, at: Situation) -> StepPlan | Blocked:
    """To the nearest ground not yet known to be bad, from where the foot is, backwards included."""
    return place_foot(at.here, encounter.leg, at.terrain, at.machine, at.gait)


_MOTIONS: dict[State, Callable[[Encounter, Situation], StepPlan | Blocked]] = {
    State.RETRACE: _retrace,
    State.RETRY: _retry,
    State.CLIMB: _climb,
    State.DESCEND: _descend,
    State.WITHDRAW: _withdraw,
    State.PLACE: _place,
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
    angles = [k * math.pi / 4 for k in range(8) if bits >> k & 1]
    # within 60° of the way
    ahead = [angle for angle in angles if math.cos(angle - bearing_b) > 0.5]
    if not ahead:
        return None
    return math.atan2(sum(map(math.sin, ahead)), sum(map(math.cos, ahead)))


def edge_cells(foot: Point, bearing: float, terrain: TerrainMap) -> set[tuple[int, int]]:
    """Cells of a rectangle along an edge that was felt in direction ``bearing`` from the foot (H
    §9.2, last sentence).
    """
    half, c, s = EDGE_LENGTH / 2, math.cos(bearing), math.sin(bearing)
    across = max(1, math.ceil(EDGE_DEPTH / (terrain.cell / 2)))
    along = max(1, math.ceil(EDGE_LENGTH / (terrain.cell / 2)))
    cells = set()
    for i in range(across + 1):
        ahead = EDGE_DEPTH * i / across
        for j in range(along + 1):
            aside = -half + EDGE_LENGTH * j / along
            cell = terrain.cell_at(foot[0] + c * ahead - s * aside, foot[1] + s * ahead + c * aside)
            if cell is not None:
                cells.add(cell)
    return cells


def cells_near(foot: Point, radius: float, terrain: TerrainMap) -> set[tuple[int, int]]:
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


def cell_of(foot: Point, terrain: TerrainMap) -> set[tuple[int, int]]:
    """The one cell under a foot, if the map has it."""
    cell = terrain.cell_at(foot[0], foot[1])
    return set() if cell is None else {cell}


def _bearing_to(foot: Point, goal: Point) -> float:
    return math.atan2(goal[1] - foot[1], goal[0] - foot[0])
