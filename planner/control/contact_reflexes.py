"""The part of the supervisor that answers contacts: H §9, from what the feet feel to what the foot
does next and what the map is told of it (the table and the motions are in ``encounter``).
"""

from __future__ import annotations

import math
from dataclasses import replace

from ..config import Contact
from ..geometry.transforms import placed
from ..motion.body_tilt import leaning
from ..terrain.map import TerrainMap
from ..types import Blocked, Point, Stance, StepPlan
from .activities import PLACING, Event
from .encounter import ContactEvent, Encounter, FootState, Situation, motion
from .execution import feet_absolute
from .feelers import Feelers, Touch, felt_towards, hangs_over_towards
from .plan_job import WANTED
from .walk_state import Now, WalkState

CellSet = set[tuple[int, int]]  # row, column


class ContactReflexes:
    """What the feet feel beside their plan, the encounter under way, and what was learnt of it.

    ``counts`` says how many encounters began, by what they began with.
    """

    def __init__(self, state: WalkState) -> None:
        self.encounter: Encounter | None = None
        self.counts: dict[str, int] = {}
        self._state = state
        self._run = state.run
        self._feelers = Feelers(state.run)
        self._settings = state.run.config.contact
        self._learnt: CellSet = set()
        # near where this encounter found no ground: searched last, not remembered
        self._shunned: CellSet = set()

    def is_surprised(self, now: Now) -> bool:
        """One tick of a plan: begins an encounter when a foot meets what the map does not show."""
        touch = self._feelers.surprise(now.sensing, now.terrain)
        if touch is None:
            return False
        self._meet(touch, now)
        return True

    def find_no_ground(self, now: Now) -> float:
        """Case 2: the plan is over and a foot has found no ground. Answers with the time into what
        is played then, s.
        """
        leg = next(leg for leg in self._run.plan.swing if not self._run.landed(leg))
        self._meet(Touch(ContactEvent.NO_GROUND, leg, None), now)
        self._run.pace = 1.0
        return 0.0

    def _meet(self, touch: Touch, now: Now) -> None:
        """The body stops in this tick; what the foot does next is the table's to say."""
        name = touch.event.value
        self.counts[name] = self.counts.get(name, 0) + 1
        landing = self._run.plan.landing or self._run.plan.end.feet[touch.leg]
        self._learn(touch, now)
        met = Encounter(FootState.NORMAL, touch.leg, landing)
        self._follow(met.after(touch.event), touch.bearing, now)
        self._state.job.flags = WANTED

    def react(self, now: Now) -> None:
        """One tick of an encounter: has something happened that the table knows?"""
        encounter = self.encounter
        if encounter is None:
            return
        touch = self._feelers.noticed(encounter, now.sensing, now.terrain)
        if touch is not None:
            self._learn(touch, now)
            self._follow(encounter.after(touch.event), touch.bearing, now)

    def go_on(self, now: Now) -> None:
        """Ordered on, a stranded foot searches again, everywhere."""
        if self.encounter is not None:
            self._shunned = set()
            again = replace(self.encounter, misses=0)
            self._follow(again.after(ContactEvent.ORDER), None, now)

    def _follow(self, encounter: Encounter, bearing: float | None, now: Now) -> None:
        """Do what the encounter's new state says; a search is answered at once."""
        state = self._state
        if encounter.state is FootState.NORMAL:
            self.encounter = None
            self._shunned = set()
            return state.stand_still(now)
        here = self._run.actual(now.sensing, self._run.plan.end)
        if encounter.state is FootState.SEARCH:
            answer = self._searched(encounter, here, bearing, now.terrain)
            found = isinstance(answer, StepPlan)
            encounter = encounter.after(ContactEvent.FOUND if found else ContactEvent.NOTHING)
        else:
            answer = self._motion(encounter, here, bearing, now.terrain)
        self.encounter = encounter
        if isinstance(answer, StepPlan):
            return state.interrupt(answer, Event.TOUCHED)
        state.happens(Event.TOUCHED)
        state.hover(answer)

    def _searched(
        self, encounter: Encounter, here: Stance, bearing: float | None, terrain: TerrainMap
    ) -> StepPlan | Blocked:
        """The motion to the nearest ground, away from where there was none."""
        away = self._settings.shy * encounter.misses
        self._shunned |= cells_near(here.feet[encounter.leg], away, terrain)
        left = terrain.forbid(self._learnt | self._shunned)
        return self._motion(replace(encounter, state=FootState.PLACE), here, bearing, left)

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

    def _learn(self, touch: Touch, now: Now) -> None:
        """What touch has shown is no ground: one cell, or a rectangle along an edge whose direction
        was felt.
        """
        foot = feet_absolute(now.sensing)[touch.leg]
        under = cell_of(foot, now.terrain)
        edge: float | None = None
        if self._bars_the_way(touch.event) and self.encounter is not None:
            edge = felt_towards(self.encounter, now.sensing)
            self._learnt |= under if edge is None else self._edge(foot, edge, now.terrain)
        elif touch.event is ContactEvent.EDGE:
            edge = hangs_over_towards(touch.leg, now.sensing)
            self._learnt |= under if edge is None else self._edge(foot, edge, now.terrain) | under
        elif touch.event is ContactEvent.NO_GROUND and self._state.activity in PLACING:
            self._learnt |= under

    def _bars_the_way(self, event: ContactEvent) -> bool:
        if event is ContactEvent.TOP:
            return True
        placing = self.encounter is not None and self.encounter.state is FootState.PLACE
        return event is ContactEvent.HIT and placing

    def _edge(self, foot: Point, bearing: float, terrain: TerrainMap) -> CellSet:
        return edge_cells(foot, bearing, terrain, self._settings)

    def take_learnt(self) -> CellSet:
        """CellSet touch has shown to be no ground, once."""
        learnt = self._learnt
        self._learnt = set()
        return learnt


def edge_cells(foot: Point, bearing: float, terrain: TerrainMap, settings: Contact) -> CellSet:
    """CellSet of a rectangle along an edge that was felt in direction ``bearing`` from the foot (H
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


def cells_near(foot: Point, radius: float, terrain: TerrainMap) -> CellSet:
    """CellSet whose centre is within ``radius`` of a foot, seen from above."""
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


def cell_of(foot: Point, terrain: TerrainMap) -> CellSet:
    """The one cell under a foot, if the map has it."""
    cell = terrain.cell_at(foot[0], foot[1])
    return set() if cell is None else {cell}
