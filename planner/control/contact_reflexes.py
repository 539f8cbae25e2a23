"""The part of the supervisor that answers contacts: H §9, from what the feet feel to what the foot
does next and what the map is told of it (the table and the motions are in ``encounter``).

One foot at a time: the others that are in the air wait there, and are seen to after it. An
encounter is over when every leg stands with its sole on, or is lifted and known to be.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from ..motion.body_tilt import leaning
from ..terrain.map import TerrainMap
from ..types import TICK, Blocked, Point, Reason, Stance, StepPlan
from .activities import PLACING, Activity, Event
from .encounter import ContactEvent, Encounter, FootState, Situation, motion
from .execution import feet_absolute
from .feelers import Feelers, Touch
from .foothold_watch import FootholdWatch
from .touch_lessons import TouchLessons
from .touch_memory import CellSet, Felt, cells_near
from .walk_state import Now, WalkState

AT_GOAL = 0.01  # m; a foot this near its landing point, seen from above, is over it


class ContactReflexes:
    """What the feet feel beside their plan, the encounter under way, and what was learnt of it.

    ``counts`` says how many encounters began, by what they began with. ``standing_min`` is how many
    legs the planner wants on the ground: with fewer it waits for ground, else it walks on with legs
    lifted.
    """

    def __init__(self, state: WalkState, standing_min: int | None = None) -> None:
        self.encounter: Encounter | None = None
        self.counts: dict[str, int] = {}
        self._state = state
        self._run = state.run
        self._feelers = Feelers(state.run)
        self._settings = state.run.config.contact
        legs = len(state.run.machine.legs)
        self._standing_min = legs if standing_min is None else standing_min
        self._lessons = TouchLessons(state.run)
        # near where this encounter found no ground: searched last, not remembered
        self._shunned: CellSet = set()
        # in the air beside the foot that is seen to: still to be seen to, and without any ground
        self._waiting: tuple[int, ...] = ()
        self._stranded: tuple[int, ...] = ()
        self._footholds = FootholdWatch(state.run)
        self._sinking: int | None = None  # the leg whose foothold gave way, still to be seen to

    def is_surprised(self, now: Now) -> bool:
        """One tick of a plan: begins an encounter when a foot meets what the map does not show."""
        touch = self._feelers.surprise(now.sensing, now.terrain)
        if touch is None:
            return self.loses_a_foothold(now)
        self._meet(touch, self._run.in_the_air(), now)
        return True

    def loses_a_foothold(self, now: Now) -> bool:
        """Case 3 under a leg that carries: legs in the air are put down first, then it is seen
        to.
        """
        leg = self._footholds.gone(now.sensing)
        if leg is None:
            return False
        self._lessons.gave_way(feet_absolute(now.sensing)[leg], now.terrain)
        lifted = self._run.stance.lifted if self._state.stands else ()
        airborne = self._run.in_the_air() or list(lifted)
        self._sinking = leg
        first = airborne[0] if airborne else leg
        self._meet(Touch(self._left(first, now), first, None), (*airborne, leg), now)
        return True

    def find_no_ground(self, now: Now) -> float:
        """Case 2: the plan is over and feet have found no ground. Answers with the time into what
        is played then, s.
        """
        run = self._run
        waiting = run.plan.end.lifted if self._state.activity is not Activity.SETTLE else ()
        missing = [leg for leg in run.in_the_air() if leg not in waiting]
        self._meet(Touch(ContactEvent.NO_GROUND, missing[0], None), run.in_the_air(), now)
        run.pace = 1.0
        return TICK if run.comes_to_rest else 0.0

    def let_down(self, legs: Sequence[int], now: Now) -> None:
        """Legs meant to carry hang: they feel for ground, one after the other, before any is
        lifted.
        """
        lifted = [leg for leg in self._run.in_the_air() if leg not in legs]
        self._meet(Touch(ContactEvent.NO_GROUND, legs[0], None), (*legs, *lifted), now)
        self._run.pace = 1.0

    def _meet(self, touch: Touch, airborne: Sequence[int], now: Now) -> None:
        """The body stops in this tick; what the foot does next is the table's to say. The hit calls
        Level B at once (H §9.3); the other cases when they search.
        """
        self._state.job.forget()
        self._state.job.shake.dismiss()
        if touch.event is ContactEvent.HIT:
            self._call()
        self._lessons.learn(touch, None, now)
        self._waiting = tuple(leg for leg in airborne if leg != touch.leg)
        self._stranded = ()
        self._begin(touch, now)

    def _call(self) -> None:
        """F1 and F3 are set at the same time: the answer is passed on as soon as there is one."""
        self._state.job.shake.call()
        self._state.job.shake.want()

    def _begin(self, touch: Touch, now: Now) -> None:
        if touch.event not in (ContactEvent.LEFT, ContactEvent.NEEDED):
            name = touch.event.value
            self.counts[name] = self.counts.get(name, 0) + 1
            self._state.setbacks.note(now.sensing.body, now.command)
        met = Encounter(FootState.NORMAL, touch.leg, self._goal(touch.leg, now))
        after = met.after(touch.event, self._is_at_top(touch, now), touch.bearing)
        self._follow(after, touch.bearing, now)

    def _is_at_top(self, touch: Touch, now: Now) -> bool:
        hit = touch.event is ContactEvent.HIT
        return hit and self._feelers.is_at_top(touch.leg, now.sensing)

    def _goal(self, leg: int, now: Now) -> Point:
        """Where the foot was to land; where it is, when no plan says so."""
        run = self._run
        plan = run.interrupted if self._state.activity in PLACING else run.plan
        if plan is None or leg not in plan.swing:
            return feet_absolute(now.sensing)[leg]
        alone = plan.landing is not None and len(plan.swing) == 1
        return plan.landing if alone and plan.landing else plan.end.feet[leg]

    def react(self, now: Now) -> None:
        """One tick of an encounter: has something happened that the table knows?"""
        encounter = self.encounter
        if encounter is None:
            return
        touch = self._feelers.noticed(encounter, now.sensing, now.terrain)
        if touch is not None:
            if touch.event is ContactEvent.EDGE and self._sinking is not None:
                touch = touch._replace(event=ContactEvent.LANDED)  # it is needed, on an edge or not
            self._lessons.learn(touch, encounter, now)
            after = encounter.after(touch.event, self._is_at_top(touch, now), touch.bearing)
            self._follow(after, touch.bearing, now)

    def go_on(self, now: Now) -> None:
        """Ordered on, a stranded foot searches again, everywhere; and so do all others."""
        if self.encounter is not None:
            again = replace(self.encounter, misses=0)
            if again.state is not FootState.STRANDED:  # its foot stands, and others hang
                leg = self._stranded[0]
                again = Encounter(FootState.STRANDED, leg, self._goal(leg, now))
            self._waiting = tuple(leg for leg in self._stranded if leg != again.leg)
            self._stranded = ()
            self._follow(again.after(ContactEvent.ORDER), None, now)

    def _follow(self, encounter: Encounter, bearing: float | None, now: Now) -> None:
        """Do what the encounter's new state says; a search is answered at once."""
        if encounter.state is FootState.NORMAL:
            return self._see_to_next(now)
        here = self._state.brought_to_rest(now)
        if encounter.state is FootState.SEARCH:
            self._call()
            answer = self._searched(encounter, here, bearing, now.terrain)
            self._state.job.shake.complete()
            self._state.job.shake.receive()
            found = isinstance(answer, StepPlan)
            encounter = encounter.after(ContactEvent.FOUND if found else ContactEvent.NOTHING)
        else:
            answer = self._motion(encounter, here, bearing, now.terrain)
        self.encounter = encounter
        if isinstance(answer, StepPlan):
            return self._state.interrupt(answer, Event.TOUCHED)
        if encounter.yielded:
            answer = Blocked(Reason.GAVE_WAY, encounter.leg)
        self._stranded += (encounter.leg,)
        self._see_to_next(now, answer)

    def _see_to_next(self, now: Now, blocked: Blocked | None = None) -> None:
        """The foot stands, or is ``blocked``: the next one that is in the air, or the end of the
        encounter.
        """
        self._shunned = set()
        if self._waiting:
            leg, *rest = self._waiting
            self._waiting = tuple(rest)
            return self._begin(Touch(self._left(leg, now), leg, None), now)
        stranded = self._stranded
        legs = len(self._run.machine.legs)
        if stranded and legs - len(stranded) < self._standing_min:
            return self._hover(blocked or Blocked(Reason.NO_PLACE, stranded[0]))
        self.encounter = None
        self._state.stand_still(now, stranded)

    def _left(self, leg: int, now: Now) -> ContactEvent:
        """Over its landing point a foot has found no ground; elsewhere it is only left over. Of one
        whose foothold gave way it depends on whether the others can do without it; and while they
        cannot, those in the air go straight down.
        """
        if self._sinking is not None:
            can_go = self._footholds.may_rise(leg, now.sensing)
            if leg == self._sinking:
                self._sinking = None
                return ContactEvent.GAVE_WAY if can_go else ContactEvent.SANK
            if not can_go:
                return ContactEvent.NEEDED
        foot = feet_absolute(now.sensing)[leg]
        goal = self._goal(leg, now)
        over = math.hypot(foot[0] - goal[0], foot[1] - goal[1]) <= AT_GOAL
        return ContactEvent.NO_GROUND if over else ContactEvent.LEFT

    def _hover(self, why: Blocked) -> None:
        self._state.happens(Event.TOUCHED)
        self._state.hover(why)

    def _searched(
        self, encounter: Encounter, here: Stance, bearing: float | None, terrain: TerrainMap
    ) -> StepPlan | Blocked:
        """The motion to the nearest ground, away from where there was none."""
        if encounter.turns > self._settings.turns_max:
            return Blocked(Reason.NO_PLACE, encounter.leg)
        away = self._settings.shy * encounter.misses
        self._shunned |= cells_near(here.feet[encounter.leg], away, terrain)
        left = terrain.forbid(self._lessons.felt.prohibited | self._shunned)
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
        if isinstance(answer, Blocked):
            return answer
        held = tuple(sorted((*self._waiting, *self._stranded)))
        return holding_up(frame.restored(answer, here), held)

    @property
    def has_news(self) -> bool:
        """True when touch has shown what the map does not know yet."""
        return bool(self._lessons.felt)

    def take_felt(self) -> Felt:
        """What touch has shown of the ground, once."""
        return self._lessons.take()


def holding_up(plan: StepPlan, legs: tuple[int, ...]) -> StepPlan:
    """The same plan with legs that wait in the air where they are."""
    if not legs:
        return plan
    swing = (*plan.swing, *(leg for leg in legs if leg not in plan.swing))
    return replace(plan, swing=swing, end=replace(plan.end, lifted=legs))
