"""What all parts of the supervisor share: what the walker is at, and how that ends or is broken
off.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..motion.body_tilt import leaning
from ..motion.braking import Braking
from ..motion.foot_placement import place_feet
from ..motion.step_builder import changed, holding_plan
from ..terrain.map import TerrainMap
from ..types import Blocked, Command, Sensing, Stance, StepPlan
from .activities import PLACING, Activity, Event, after
from .execution import Execution, resting
from .pacing import braking_from, braking_now, lands_first
from .plan_job import PlanJob
from .setbacks import Setbacks


@dataclass(slots=True)
class Now:
    """What a tick brings; the supervisor has one and fills it anew every tick."""

    sensing: Sensing
    command: Command
    terrain: TerrainMap
    holds: bool  # the command is to hold


class WalkState:
    """The walk as it is.

    ``blocked`` says why it stands when it should not, ``executed`` is the step finished in this
    tick with its end as it came out, ``heading`` (rad) the absolute direction of the course walked,
    ``crab_angle`` (rad) that of the last course commanded, ``posture`` the one it is in or going to
    (stand, sit, standard), ``hovered`` what it was at when it began to hover, ``setbacks`` the
    encounters that led nowhere.
    """

    def __init__(self, run: Execution, job: PlanJob, crab_angle: float) -> None:
        self.activity = Activity.STAND
        self.run = run
        self.job = job
        self.blocked: Blocked | None = None
        self.executed: StepPlan | None = None
        self.steps_begun = 0
        self.heading = 0.0
        self.crab_angle = crab_angle
        self.posture = "stand"
        self.hovered = Activity.STEP
        self.setbacks = Setbacks(run.config.contact, run.machine)
        self._braking: Braking | None = None  # of the body, until what it does next is played

    @property
    def stands(self) -> bool:
        """True while it stands on its feet and plays nothing."""
        return self.activity is Activity.STAND

    @property
    def steps(self) -> bool:
        """True while a step is played."""
        return self.activity is Activity.STEP

    def is_refused(self, now: Now) -> bool:
        """True when just this was answered by what it is blocked by."""
        return self.blocked is not None and self.job.refused == (now.command, now.terrain)

    def happens(self, event: Event) -> None:
        """Something happens: the table says what it is at from here on."""
        self.activity = after(self.activity, event)

    def interrupt(self, plan: StepPlan, event: Event) -> None:
        """Play a plan in place of the one that runs; a step is remembered as cut short."""
        if self.activity is Activity.STEP or self.activity is Activity.POSTURE:
            self.run.interrupted = self.run.plan
        self.happens(event)
        if self._braking is not None:
            plan = self._braking.onto(plan)
            self._braking = None
        self.run.play(plan)

    def rest(self, stance: Stance, keep_job: bool = False) -> None:
        """On standing feet, from here on; a step cut short has come to its end."""
        run = self.run
        if self.activity in PLACING and run.interrupted is not None:
            self.executed = changed(run.interrupted, end=stance)
            run.interrupted = None
        run.hold(stance)
        self.happens(Event.AT_REST)
        self.blocked = None
        self.job.rest(keep_job)

    def stand_still(self, now: Now, lifted: tuple[int, ...] = ()) -> None:
        """Rest where the machine really is, with these legs in the air."""
        run = self.run
        cut_short = run.interrupted if self.activity in PLACING else run.plan
        remembered = run.remembered(now.sensing, cut_short, lifted)
        self.rest(run.actual(now.sensing, remembered))

    def brought_to_rest(self, now: Now, at_once: bool = False) -> Stance:
        """The stance as it will be once the body stands; what is played next slows it down, by what
        the nearest edge allows unless it is to stop ``at_once``, by what those ahead do.
        """
        run = self.run
        here = run.actual(now.sensing, run.plan.end)
        self._braking = braking_now(run, now.sensing, nearest=not at_once)
        return here if self._braking is None else self._braking.rest_of(here)

    def stop(self, now: Now) -> None:
        """The body stops, as soon as its margin allows; feet in the air are set down where they are
        nearest to ground. A body too fast to stop without one that lands soon goes on until then.
        One whose sole is on stands already.
        """
        run = self.run
        if now.holds:
            self.setbacks.let_go()
        here = self.brought_to_rest(now, at_once=True)
        airborne = run.in_the_air()
        if airborne and lands_first(run, self._braking):
            self._braking = None
            return
        airborne = [leg for leg in airborne if not now.sensing.soles[leg]]
        if not airborne and self._braking is None:
            return self.stand_still(now)
        self.job.forget()
        if not airborne:
            return self.interrupt(holding_plan(here), Event.CUT_SHORT)
        frame = leaning(here, now.terrain, run.machine)
        settling = place_feet(frame.stance, airborne, frame.terrain, frame.machine, run.gait)
        if isinstance(settling, Blocked):
            self.hover(settling)
        else:
            settling = run.gently(frame.restored(settling, here), now.terrain)
            self.interrupt(settling, Event.CUT_SHORT)

    def slow_down(self, stance: Stance) -> bool:
        """At a step-switching point with no step to go on with: the body comes to rest on its feet.
        False when it stands already.
        """
        run = self.run
        run.t = run.tracker.duration
        way = braking_from(run, stance)
        if way is None:
            return False
        self.job.forget()
        run.stance = stance
        run.rested = resting(stance, way.body[-1])
        self.happens(Event.CUT_SHORT)
        run.play(way.onto(holding_plan(way.rest_of(stance))))
        run.interrupted = None
        return True

    def hover(self, why: Blocked) -> None:
        """Hold everything, one foot in the air on three that carry: there is no ground for it here.
        Driving on resumes.
        """
        self._braking = None
        self.hovered = self.activity
        self.happens(Event.NO_PLACE)
        self.blocked = why
