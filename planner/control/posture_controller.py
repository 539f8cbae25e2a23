"""Postures on command: sitting, standing up, going back into the standard layout.

A posture is a row of plans made at once and played one after the other; when the ground or a push
makes one come out otherwise, the rest is made anew from there.
"""

from __future__ import annotations

from collections.abc import Callable

from ..initial_stance import Placement
from ..motion.body_tilt import LEVEL, leaned
from ..motion.postures import PlanSequence, sit, stand
from ..motion.return_to_nominal import SequenceJob, return_to_nominal
from ..motion.step_builder import changed
from ..terrain.map import TerrainMap
from ..types import POSTURES, Blocked, Reason, Stance
from .activities import Activity, Event
from .execution import came_as_planned
from .plan_job import SLICE
from .walk_state import Now, WalkState

Layout = Callable[[Placement], Stance]  # the standard posture of a course


class PostureController:
    """Which posture is wanted, and the plans still to be played for it.

    ``wanted`` is the one asked for and not yet reached, ``low`` whether the body has sunk on
    command: it rises before it walks.
    """

    def __init__(self, state: WalkState, layout: Layout) -> None:
        self.wanted = ""
        self.low = False
        self._state = state
        self._run = state.run
        self._layout = layout
        self._rises_to_walk = False  # a command to move wants the posture it is taking
        self._plans: PlanSequence = ()
        self._choosing: SequenceJob | None = None  # the order of the legs is being searched for
        self._terrain: TerrainMap | None = None  # the map the plans were made on
        self._tries = 0  # times the posture wanted has been begun

    # asking

    @property
    def is_busy(self) -> bool:
        """True while a posture is being taken, or is to be."""
        return self._state.activity is Activity.POSTURE or self.wanted != ""

    def ask(self, posture: str) -> str:
        """Take a posture as soon as it stands; why not, or '' when it will. What else it was going
        to is dropped.
        """
        if posture not in POSTURES:
            return f"unknown posture {posture!r}; there are: {', '.join(POSTURES)}"
        if self._state.activity is Activity.HOVER:
            return "a foot is in the air and has found no ground: drive on first"
        if self._state.stands:
            self._state.blocked = None
        self.wanted = posture
        self._rises_to_walk = False
        self._tries = 0
        self._choosing = None
        return ""

    def halt(self) -> None:
        """Whatever posture it is taking, it stops in the next tick, and stays as it is."""
        self.wanted = ""
        self._rises_to_walk = False
        self._choosing = None

    def listen(self, now: Now) -> None:
        """Only for a machine that is low or that takes a posture, or is to: a command to move ends
        what was asked for; a command to hold ends rising to walk.
        """
        if not now.holds:
            self._rise(now)
        elif self._rises_to_walk:
            self.halt()

    def _rise(self, now: Now) -> None:
        """A command to move: a machine that has sunk rises first, and then walks."""
        state = self._state
        if not (self.low and state.activity in (Activity.STAND, Activity.POSTURE)):
            return self.halt()
        if self.wanted != "stand" and not state.is_refused(now):
            self.ask("stand")
            state.job.refused = now.command, now.terrain
        self._rises_to_walk = self.wanted == "stand"

    # planning

    def take(self, now: Now) -> None:
        """From standing: plan the posture that is wanted, and begin; the order of the legs takes a
        few ticks to find.
        """
        run = self._run
        state = self._state
        if self._choosing is None:
            if self._tries >= run.config.tracking.posture_tries:
                why = Blocked(Reason.POSTURE_KEPT_FROM)
                return self._give_up(why)
            self._tries += 1
            self._terrain = now.terrain
            state.job.forget()
        here = run.actual(now.sensing, run.stance)
        if not came_as_planned(here, run.stance, run.tolerances):
            run.stance = here
        answer = self._planned(run.stance, now.terrain)
        if isinstance(answer, Blocked):
            self._give_up(answer)
        elif answer is not None:
            state.posture = "stand" if self.low and self.wanted == "standard" else self.wanted
            self.low = self.low or self.wanted == "sit"
            state.blocked = None
            self._plans = tuple(run.gently(plan, now.terrain) for plan in answer)
            self._play_next()

    def _give_up(self, why: Blocked) -> None:
        self.halt()
        self._state.blocked = why

    def _planned(self, stance: Stance, terrain: TerrainMap) -> PlanSequence | Blocked | None:
        """The plans of the posture wanted, a leaning body levelled first; None while that takes
        longer.
        """
        if stance.lean == LEVEL:
            return self._plans_from(stance, terrain)
        levelling = leaned(stance, LEVEL, self._run.machine)
        if levelling is None:
            return Blocked(Reason.CANNOT_LEVEL)
        answer = self._plans_from(levelling.end, terrain)
        return (levelling, *answer) if isinstance(answer, tuple) else answer

    def _plans_from(self, stance: Stance, terrain: TerrainMap) -> PlanSequence | Blocked | None:
        machine = self._run.machine
        gait = self._run.gait
        crab_angle = self._state.crab_angle
        if self.wanted == "sit":
            return sit(stance, terrain, machine, gait)
        if self.wanted == "stand" or self.low:
            return stand(stance, terrain, machine, gait)
        if self._choosing is None:
            x, y, _, yaw = stance.body
            goal = self._layout(Placement((x, y, yaw), terrain.height_at, crab_angle))
            self._choosing = return_to_nominal(stance, goal, terrain, machine, gait, crab_angle)
        return self._choose_on(self._choosing)

    def _choose_on(self, choosing: SequenceJob) -> PlanSequence | Blocked | None:
        """Some more of the search for the order of the legs; None while it goes on."""
        try:
            for _ in range(self._run.config.planning.work_wanted // SLICE):
                next(choosing)
        except StopIteration as done:
            self._choosing = None
            answer: PlanSequence | Blocked = done.value
            return answer
        return None

    # playing

    def _play_next(self) -> None:
        """The next plan of the posture; when there is none left, it has been taken."""
        if not self._plans:
            return self._taken(self._run.stance)
        plan, *rest = self._plans
        self._plans = tuple(rest)
        self._state.interrupt(plan, Event.POSTURE_READY)
        self._state.steps_begun += self._state.posture == "standard"

    def _taken(self, stance: Stance) -> None:
        """The posture is taken; one that was only on the way to another leaves that wanted."""
        self.low = self._state.posture == "sit"
        if self.wanted == self._state.posture:
            self.wanted = ""
        self._state.rest(stance)

    @property
    def is_still_wanted(self) -> bool:
        """True while the posture being taken is the one wanted, or on the way to it."""
        posture = self._state.posture
        on_the_way = self.wanted == "standard" and posture == "stand" and self.low
        return self.wanted == posture or on_the_way

    def break_off(self, now: Now) -> None:
        """The posture is not gone on with: it stops, wherever it is."""
        self._state.posture = "stand"
        self._state.stop(now)

    def next_plan(self, now: Now, left: float) -> float:
        """A plan of the posture is over; ``left`` seconds of this tick belong to the next one, if
        all came out as planned. Answers with the time into what is played then, s.
        """
        run = self._run
        state = self._state
        stance = run.arrived(now.sensing)
        good = came_as_planned(stance, run.plan.end, run.tolerances)
        if good:
            stance = run.plan.end  # what sensors say beside it is noise
        if state.posture == "standard":
            state.executed = changed(run.plan, end=stance)
        run.stance = stance
        if not self._plans:
            self._taken(stance)
            return 0.0
        if not (good and self._is_still_good(now.terrain)):
            state.rest(stance)  # and plan anew from there: the posture is still wanted
            return 0.0
        self._play_next()
        return min(left, run.tracker.duration)

    def _is_still_good(self, terrain: TerrainMap) -> bool:
        """True while every foothold still to come is believed to be what it was taken for."""
        if terrain is self._terrain:
            return True
        off = self._run.config.tracking.same_ground
        places = [plan.landing for plan in self._plans if plan.landing is not None]
        return all(
            terrain.allows(x, y) and abs(terrain.height_at(x, y) - z) <= off for x, y, z in places
        )
