"""One step after the other: starting from a standstill, and switching at N_{k+1} (H §4.4, §9.3)."""

from __future__ import annotations

from dataclasses import replace

from ..motion.step_builder import changed
from ..types import Blocked, Reason, Stance, StepPlan
from .activities import Event
from .barred_way import UNFELT, what_bars
from .execution import off_place
from .pacing import pace_for
from .walk_state import Now, WalkState


class StepController:
    """When a step begins, what is asked for while it runs, and what follows on it."""

    def __init__(self, state: WalkState) -> None:
        self._state = state
        self._run = state.run
        self._job = state.job
        # steps running that were cut short because the body was not where they had it
        self._held = 0
        self._off: dict[str, float | str] = {}  # how far off, when it was last

    def start(self, now: Now) -> None:
        """From standing: plan the first step now; when it is ready, walk."""
        job = self._job
        if self._state.is_refused(now):
            return
        self._state.setbacks.heed(now.command)
        if self._state.setbacks.why is not None:
            job.refused = (now.command, now.terrain)
            self._state.blocked = self._naming_the_bar(self._state.setbacks.why, now)
            return
        if self._held >= self._run.config.tracking.held_max:
            self._held = 0
            job.refused = (now.command, now.terrain)
            held = Blocked(Reason.HELD_BACK, facts={**self._off, "bar": UNFELT})
            self._state.blocked = self._naming_the_bar(held, now)
            return
        stance = job.stance_asked(now.command, now.terrain)
        if stance is None:
            stance = self._run.standing(now.sensing)
        answer = job.answer_standing(stance, now.command, now.terrain)
        asked = job.asked
        if answer is not None and asked is not None:
            self._begin(answer, stance, 0.0, now)
            job.refused = (asked.command, now.terrain)

    def count_held_back(self, now: Now) -> None:
        """A step is cut short because the body is not where it has it."""
        self._held += 1
        self._off = off_place(self._run, now.sensing)

    def switch(self, now: Now, left: float) -> float:
        """N_{k+1}: the running step is over; ``left`` seconds of this tick belong to the next one.

        Answers with the time into what is played then, s.
        """
        stance = self._run.arrived(now.sensing)
        self._state.executed = changed(self._run.plan, end=stance)
        self._held = 0
        work = self._run.config.planning.work_wanted
        self._job.consider(stance, now.command, now.terrain, work, is_waited_for=True)
        answer = self._job.answer(now.command)
        if not isinstance(answer, StepPlan) and self._state.slow_down(stance):
            return min(left, self._run.tracker.duration)
        if answer is None:  # not planned yet: hold on standing feet
            self._job.shake.want()
            self._state.rest(stance, keep_job=stance is stance.at_rest())
            return 0.0
        return self._begin(answer, stance, left, now)

    def _naming_the_bar(self, why: Blocked, now: Now) -> Blocked:
        """A reason for which the body gets no farther, with what bars its way as the map has it."""
        x, y, z, _, _, yaw = now.sensing.body
        heading = yaw + now.command.crab_angle
        bar = what_bars((x, y, z, yaw), heading, now.terrain, self._run.machine)
        return replace(why, facts={**why.facts, "bar": bar or why.facts["bar"]})

    def _begin(self, answer: StepPlan | Blocked, stance: Stance, left: float, now: Now) -> float:
        """The next step, or standing because there is none."""
        state, run = self._state, self._run
        command = now.command
        if not command.holds:
            legs = len(answer.swing) if isinstance(answer, StepPlan) else 0
            state.setbacks.note_step(stance.body, command, legs)
        if state.setbacks.why is not None:
            answer = self._naming_the_bar(state.setbacks.why, now)
        if isinstance(answer, Blocked):
            state.rest(stance)
            state.blocked = answer
            return 0.0
        run.stance = stance
        self._job.begun()
        state.blocked = None
        if state.stands:
            run.pace = 1.0
        run.play(answer)
        state.happens(Event.STEP_READY)
        state.steps_begun += 1
        state.heading = stance.body[3] + answer.crab_angle
        state.posture = "stand"
        if command.speed > 0.0:
            state.crab_angle = command.crab_angle
        run.pace = pace_for(run, command)
        return min(left * run.pace, run.tracker.duration)
