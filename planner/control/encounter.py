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
from ..geometry.transforms import direction
from ..motion.foot_placement import place_foot
from ..motion.step_builder import FootWay, body_still_plan
from ..motion.swing import profile_of, swing_speeds
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Blocked, Gait, Phase, Point, Stance, StepPlan


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
    EDGE = "edge"  # the sole hangs over
    GAVE_WAY = "gave way"  # the foothold, under a leg that the others can do without
    SANK = "sank"  # the foothold, under a leg that is needed where it is
    FOUND = "found"
    NOTHING = "nothing"
    ORDER = "order"  # the operator wants to go on
    LEFT = "left in the air"  # when the encounter of another foot was over
    NEEDED = "needed"  # in the air, and the feet that stand do not carry the body


TABLE: dict[tuple[FootState, ContactEvent], FootState] = {
    (FootState.NORMAL, ContactEvent.HIT): FootState.RETRACE,  # case 1
    (FootState.NORMAL, ContactEvent.NO_GROUND): FootState.DESCEND,  # case 2
    (FootState.NORMAL, ContactEvent.EDGE): FootState.WITHDRAW,  # case 3
    (FootState.NORMAL, ContactEvent.GAVE_WAY): FootState.WITHDRAW,  # case 3
    (FootState.NORMAL, ContactEvent.SANK): FootState.DESCEND,  # case 3
    (FootState.NORMAL, ContactEvent.LEFT): FootState.SEARCH,
    (FootState.NORMAL, ContactEvent.NEEDED): FootState.DESCEND,
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
    (FootState.PLACE, ContactEvent.NO_GROUND): FootState.DESCEND,
    (FootState.PLACE, ContactEvent.EDGE): FootState.WITHDRAW,
    (FootState.PLACE, ContactEvent.LANDED): FootState.NORMAL,
    (FootState.STRANDED, ContactEvent.ORDER): FootState.SEARCH,
}


@dataclass(frozen=True, slots=True)
class Encounter:
    """One emergent motion under way: its state, whose foot it is, and where that foot was to
    land.
    """

    state: FootState
    leg: int
    goal: Point  # J_u of the step that was cut short
    hits: int = 0
    misses: int = 0  # times no ground was found
    at_top: bool = False  # it has been hit with the leg drawn as high as it can be
    edges: int = 0  # times it came down on an edge
    turns: int = 0  # changes of state so far
    felt: float | None = None  # rad, absolute: where the last hit was felt
    yielded: bool = False  # it began with a foothold that gave way

    def after(
        self, event: ContactEvent, at_top: bool = False, felt: float | None = None
    ) -> Encounter:
        """The encounter once ``event`` has happened; ``at_top``: with the leg drawn as high as it
        can be; ``felt``: in which direction, rad. Raises ``KeyError`` for an event its state does
        not know.
        """
        hit = event is ContactEvent.HIT
        return replace(
            self,
            state=TABLE[self.state, event],
            hits=self.hits + hit,
            misses=self.misses
            + (event is ContactEvent.NO_GROUND and self.state is not FootState.PLACE),
            at_top=self.at_top or (hit and at_top),
            edges=self.edges + (event is ContactEvent.EDGE),
            turns=self.turns + 1,
            felt=self.felt if felt is None else felt,
            yielded=self.yielded or event in (ContactEvent.GAVE_WAY, ContactEvent.SANK),
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
    """The motion of ``encounter``'s state; ``Blocked`` when there is no ground to put the foot
    on.
    """
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
    """(b) Towards the landing point again, slower, clear of what was felt, and down as far as the
    leg reaches.
    """
    foot = at.here.feet[encounter.leg]
    goal = encounter.goal
    highest = max(foot[2], ceiling(at.here, encounter.leg, at.machine))
    top = min(foot[2] + at.settings.keep_clear, highest)
    up = (foot[0], foot[1], top)
    over = (goal[0], goal[1], top)
    down = (goal[0], goal[1], min(floor(at.here, encounter.leg, at.machine), foot[2]))
    phases = (Phase.UP, Phase.RETURN, Phase.DOWN)
    return _moved(at, encounter.leg, [up, over, down], phases, at.settings.slower)


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
