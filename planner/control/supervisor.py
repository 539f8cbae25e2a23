"""The gait supervisor: what the walker is at, and what becomes of that when something happens.

Its activities are the rows of a table, what may happen to it the columns (``TABLE``); the rest of
this file says when each of those things has happened. It plays one plan at a time (``Execution``),
keeps the next step in planning (``PlanJob``), and answers once a tick with foot velocities.

``GaitSupervisor`` is changed in place, once a tick, by the simulation alone; viewers get a
``Snapshot``. (A frozen value rebuilt every 20 ms cost a tenth of the whole tick.)
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

from ..motion.body_tilt import leaning
from ..motion.foot_placement import place_feet
from ..motion.step_builder import changed
from ..protocols import Planner
from ..terrain.map import TerrainMap
from ..types import (
    POSTURES,
    Blocked,
    Command,
    Mode,
    Phase,
    Point,
    Sensing,
    Stance,
    StepPlan,
)
from .contact_reflexes import ContactReflexes, Encounter, FootState, Touch
from .execution import Execution
from .plan_job import WANTED, Flags, PlanJob, Question
from .posture_controller import Layout, PostureController


class Activity(Enum):
    """What the walker is at."""

    STAND = "stand"
    STEP = "step"
    SETTLE = "settle"  # setting feet down after a step that was cut short
    REFLEX = "reflex"  # an emergent motion of one foot (H §9)
    HOVER = "hover"  # a foot in the air has no ground to come down on
    POSTURE = "posture"  # taking a posture on command


class Event(Enum):
    """What happens to it."""

    STEP_READY = "the next step is planned"
    POSTURE_READY = "a plan of the posture is next"
    AT_REST = "it stands on its feet with nothing to play"
    CUT_SHORT = "the body stops with feet in the air"
    TOUCHED = "a foot meets what the map does not show, or finds no ground"
    NO_PLACE = "there is no ground for a foot in the air"
    STEP_RESUMED = "ordered on, in a step"
    POSTURE_RESUMED = "ordered on, in a posture"
    REFLEX_RESUMED = "ordered on, in a reflex"


_A, _E = Activity, Event
# Where each event leads; what is not in a row cannot happen there.
TABLE: dict[Activity, dict[Event, Activity]] = {
    _A.STAND: {
        _E.STEP_READY: _A.STEP,
        _E.POSTURE_READY: _A.POSTURE,
        _E.AT_REST: _A.STAND,
    },
    _A.STEP: {
        _E.STEP_READY: _A.STEP,
        _E.AT_REST: _A.STAND,
        _E.CUT_SHORT: _A.SETTLE,
        _E.TOUCHED: _A.REFLEX,
        _E.NO_PLACE: _A.HOVER,
    },
    _A.SETTLE: {
        _E.AT_REST: _A.STAND,
        _E.TOUCHED: _A.REFLEX,
    },
    _A.REFLEX: {
        _E.AT_REST: _A.STAND,
        _E.TOUCHED: _A.REFLEX,
        _E.NO_PLACE: _A.HOVER,
    },
    _A.HOVER: {
        _E.STEP_RESUMED: _A.STEP,
        _E.POSTURE_RESUMED: _A.POSTURE,
        _E.REFLEX_RESUMED: _A.REFLEX,
    },
    _A.POSTURE: {
        _E.POSTURE_READY: _A.POSTURE,
        _E.AT_REST: _A.STAND,
        _E.CUT_SHORT: _A.SETTLE,
        _E.TOUCHED: _A.REFLEX,
        _E.NO_PLACE: _A.HOVER,
    },
}
RESUMED = {
    Activity.STEP: Event.STEP_RESUMED,
    Activity.POSTURE: Event.POSTURE_RESUMED,
    Activity.REFLEX: Event.REFLEX_RESUMED,
}
STILL = (Activity.STAND, Activity.HOVER)  # nothing is played
PLACING = (Activity.SETTLE, Activity.REFLEX)  # feet come down after the plan they swung in

MODES = {
    Phase.SUPPORT: Mode.SUPPORT,
    Phase.UP: Mode.UP,
    Phase.RETURN: Mode.RETURN,
    Phase.DOWN: Mode.DOWN,
    Phase.SHIFT: Mode.SHIFT,
}
MODES_OF = {
    Activity.HOVER: Mode.BLOCKED,
    Activity.SETTLE: Mode.SETTLE,
    Activity.REFLEX: Mode.EMERGENT,
}
POSING = {"sit": Mode.SIT_DOWN, "stand": Mode.STAND_UP, "standard": Mode.REGROUP}


class Now(NamedTuple):
    """What a tick brings."""

    sensing: Sensing
    command: Command
    terrain: TerrainMap


class GaitSupervisor:
    """One walker's walk. ``advance`` is called once a tick and answers with foot velocities.

    ``blocked`` says why it stands when it should not, ``executed`` is the step finished in this
    tick with its end as it came out, ``heading`` (rad) the absolute direction of the course walked,
    ``crab_angle`` (rad) that of the last course commanded.
    """

    def __init__(
        self, planner: Planner, run: Execution, layout: Layout, crab_angle: float = 0.0
    ) -> None:
        self.activity = Activity.STAND
        self.run = run
        self.job = PlanJob(planner, run.machine.yaw_length, run.config.planning)
        self.postures = PostureController(run, layout)
        self.contacts = ContactReflexes(run)
        self.blocked: Blocked | None = None
        self.executed: StepPlan | None = None
        self.steps_begun = 0
        self.heading = 0.0
        self.crab_angle = crab_angle
        # steps running that were cut short because the body was not where they had it
        self._held = 0
        self._hovered = Activity.STEP  # what it was at when it began to hover

    # what others may ask

    @property
    def plan(self) -> StepPlan:
        """The plan that runs."""
        return self.run.plan

    @property
    def ready(self) -> StepPlan | None:
        """The step after the running one, once it is planned."""
        return self.job.ready

    @property
    def flags(self) -> Flags:
        """F1, F2, F3 of H §9.3."""
        return self.job.flags

    @property
    def stance(self) -> Stance:
        """The stance at the last step-switching point."""
        return self.run.stance

    @property
    def stands(self) -> bool:
        """True while no plan is played because none is wanted or none is there."""
        return self.activity is Activity.STAND

    @property
    def steps(self) -> bool:
        """True while a step is played."""
        return self.activity is Activity.STEP

    @property
    def plays(self) -> bool:
        """True while a plan is played that moves anything."""
        return self.activity not in STILL

    @property
    def mode(self) -> Mode:
        """What it is at, in the words of the log."""
        if self.steps:
            return MODES[self.run.phase]
        if self.activity is Activity.POSTURE:
            return POSING[self.postures.posture]
        if not self.stands:
            return MODES_OF[self.activity]
        if self.blocked:
            return Mode.BLOCKED
        sits = self.postures.posture == "sit" and not self.postures.wanted
        return Mode.SIT if sits else Mode.STAND

    @property
    def speed(self) -> float:
        """Speed of the centre of gravity along the course now, m/s."""
        return self.plan.speed * self.run.pace if self.steps else 0.0

    def carrying(self) -> tuple[bool, ...]:
        """Legs meant to carry: all that do not swing, and swing legs that have landed early."""
        return self.run.carrying(self.stands)

    # one tick

    def advance(self, sensing: Sensing, command: Command, terrain: TerrainMap) -> list[Point]:
        """Decide for one tick: foot velocities in body axes, m/s, in leg order."""
        self.executed = None
        now = Now(sensing, self.job.planner.heed(command), terrain)
        self._listen(now)
        _AT[self.activity](self, now)
        return self.run.velocities_to(self._time_ahead(now), sensing)

    def _happens(self, event: Event) -> None:
        row = TABLE[self.activity]
        if event not in row:
            raise RuntimeError(f"while it is at {self.activity.name}, {event.value}: no such row")
        self.activity = row[event]

    def _time_ahead(self, now: Now) -> float:
        """Time into the plan by the end of this tick; what is over gives way to what comes next."""
        run = self.run
        if self.activity in STILL:
            run.pace = 0.0
            return run.t
        run.pace = run.pace_for(now.command) if self.steps else 1.0
        t_next, left = run.time_ahead()
        if not run.is_over(t_next):
            return t_next
        if self.activity is Activity.REFLEX:
            return run.tracker.duration
        if self._airborne():
            return self._meet(self.contacts.missing_ground(), now)
        left = max(left, 0.0)
        return self._switch(now, left) if self.steps else self._next_posture(now, left)

    def _airborne(self) -> bool:
        """True when the plan that is over should have set down a foot that is in the air."""
        plan = self.plan
        waiting = plan.end.lifted if self.steps else ()
        if self.activity is Activity.SETTLE:
            return True
        return any(leg not in waiting and not self.run.landed(leg) for leg in plan.swing)

    # standing, and starting to walk

    def _standing(self, now: Now) -> None:
        if self.postures.wanted:
            self._take_posture(now)
        elif not now.command.holds:
            self._start(now)

    def _start(self, now: Now) -> None:
        """From standing: plan the first step now; when it is ready, walk."""
        job, command, terrain = self.job, now.command, now.terrain
        if self._is_refused(command, terrain):
            return
        if self._held >= self.run.config.tracking.held_max:
            self._held = 0
            job.refused = (command, terrain)
            self.blocked = Blocked(
                "something holds the body back: a leg or the torso is against an obstacle"
            )
            return
        stance = job.stance_asked(command, terrain)
        if stance is None:
            stance = self.run.actual(now.sensing, self.stance)
        answer = job.answer_standing(Question(stance, command, terrain))
        asked = job.asked
        if answer is not None and asked is not None:
            self._begin(answer, stance, 0.0, command)
            job.refused = (asked.command, terrain)

    def _is_refused(self, command: Command, terrain: TerrainMap) -> bool:
        """True when just this was answered by what it is blocked by."""
        return self.blocked is not None and self.job.refused == (command, terrain)

    def _rest(self, stance: Stance, keep_job: bool = False) -> None:
        """On standing feet, from here on."""
        run = self.run
        if self.activity in PLACING and run.interrupted is not None:
            self.executed = changed(run.interrupted, end=stance)
            run.interrupted = None
        run.hold(stance)
        self._happens(Event.AT_REST)
        self.contacts.over()
        self.blocked = None
        self.job.rest(keep_job)

    def _stand_still(self, now: Now) -> None:
        """Rest where the machine really is."""
        run = self.run
        cut_short = run.interrupted if self.activity in PLACING else run.plan
        settling = self.activity is Activity.SETTLE
        self._rest(run.actual(now.sensing, run.remembered(now.sensing, cut_short, settling)))

    # stepping: H §4.4, §9.3

    def _stepping(self, now: Now) -> None:
        if now.command.holds:
            self._stop(now)
        elif self.run.held_back(now.sensing):
            self._held += 1
            self._stop(now)
        elif not self._is_surprised(now):
            question = Question(self.plan.end, now.command, now.terrain)
            self.job.consider(question, self.run.config.planning.slices)

    def _switch(self, now: Now, left: float) -> float:
        """N_{k+1}: the running step is over; ``left`` seconds of this tick belong to the next one."""
        stance = self.run.arrived(now.sensing)
        self.executed = changed(self.plan, end=stance)
        self._held = 0
        question = Question(stance, now.command, now.terrain)
        self.job.consider(question, self.run.config.planning.slices_wanted)
        answer = self.job.answer(now.command)
        if answer is None:  # not planned yet: hold on standing feet
            self._rest(stance, keep_job=True)
            return 0.0
        return self._begin(answer, stance, left, now.command)

    def _begin(
        self, answer: StepPlan | Blocked, stance: Stance, left: float, command: Command
    ) -> float:
        """The next step, or standing because there is none."""
        if isinstance(answer, Blocked):
            self._rest(stance)
            self.blocked = answer
            return 0.0
        run = self.run
        run.stance = stance
        self.job.begun()
        self.blocked = None
        run.play(answer)
        self._happens(Event.STEP_READY)
        self.steps_begun += 1
        self.heading = stance.body[3] + answer.crab_angle
        self.postures.posture = "stand"
        if command.speed > 0.0:
            self.crab_angle = command.crab_angle
        run.pace = run.pace_for(command)
        return min(left * run.pace, run.tracker.duration)

    # stopping, settling and hovering

    def _stop(self, now: Now) -> None:
        """The body stops in this tick; feet in the air are set down where they are nearest to
        ground.
        """
        run = self.run
        airborne = run.in_the_air()
        if not airborne:
            return self._stand_still(now)
        here = run.actual(now.sensing, run.plan.end)
        self.job.forget()
        frame = leaning(here, now.terrain, run.machine)
        settling = place_feet(frame.stance, airborne, frame.terrain, frame.machine, run.gait)
        if isinstance(settling, Blocked):
            self._hover(settling)
        else:
            self._interrupt(frame.restored(settling, here), Event.CUT_SHORT)

    def _interrupt(self, plan: StepPlan, event: Event) -> None:
        """Play a plan in place of the one that runs; a step is remembered as cut short."""
        if self.steps or self.activity is Activity.POSTURE:
            self.run.interrupted = self.plan
        self._happens(event)
        self.run.play(plan)

    def _settling(self, now: Now) -> None:
        if all(self.run.landed(leg) for leg in self.plan.swing):
            self._stand_still(now)
            if not now.command.holds and not self.postures.wanted:
                self._start(now)

    def _hover(self, why: Blocked) -> None:
        """Hold everything, one foot in the air on three that carry: there is no ground for it here.
        Driving on resumes.
        """
        self._hovered = self.activity
        self._happens(Event.NO_PLACE)
        self.blocked = why

    def _hovering(self, now: Now) -> None:
        """The step goes on where it was held when ordered so; a stranded foot searches again."""
        if now.command.holds:
            return
        self._happens(RESUMED[self._hovered])
        self.blocked = None
        encounter = self.contacts.ordered_on() if self.activity is Activity.REFLEX else None
        if encounter is not None:
            self._follow(encounter, None, now)

    # emergent motions: H §9

    def _is_surprised(self, now: Now) -> bool:
        touch = self.contacts.surprise(now.sensing, now.terrain)
        if touch is not None:
            self._meet(touch, now)
        return touch is not None

    def _meet(self, touch: Touch, now: Now) -> float:
        """The body stops in this tick; what the foot does next is the table's to say."""
        self.contacts.learn(touch, now.sensing, now.terrain, self.activity in PLACING)
        self._follow(self.contacts.meet(touch), touch, now)
        self.job.flags = WANTED
        self.run.pace = 1.0
        return 0.0

    def _reacting(self, now: Now) -> None:
        """One tick of a reflex: has something happened that its table knows?"""
        touch, encounter = self.contacts.noticed(now.sensing, now.terrain), self.contacts.encounter
        if touch is None or encounter is None:
            return
        self.contacts.learn(touch, now.sensing, now.terrain, placing=True)
        self._follow(encounter.after(touch.event), touch, now)
        if self.stands and not now.command.holds and not self.postures.wanted:
            self._start(now)

    def _follow(self, encounter: Encounter, touch: Touch | None, now: Now) -> None:
        """Do what the encounter's new state says."""
        if encounter.state is FootState.NORMAL:
            return self._stand_still(now)
        answer = self.contacts.answer(encounter, touch, now.sensing, now.terrain)
        if isinstance(answer, StepPlan):
            return self._interrupt(answer, Event.TOUCHED)
        self._happens(Event.TOUCHED)
        self._hover(answer)

    # postures on command

    def pose(self, posture: str) -> str:
        """Take a posture as soon as it stands; why not, or '' when it will. What else it was going
        to is dropped.
        """
        if posture not in POSTURES:
            return f"unknown posture {posture!r}; there are: {', '.join(POSTURES)}"
        if self.activity is Activity.HOVER:
            return "a foot is in the air and has found no ground: drive on first"
        if self.stands:
            self.blocked = None
        self.postures.ask(posture)
        return ""

    def halt(self) -> None:
        """Whatever posture it is taking, it stops in the next tick, and stays as it is."""
        self.postures.halt()

    @property
    def posing(self) -> bool:
        """True while a posture is being taken, or is to be."""
        return self.activity is Activity.POSTURE or self.postures.wanted != ""

    def _listen(self, now: Now) -> None:
        """A command to move ends what is not moving."""
        postures, holds = self.postures, now.command.holds
        if postures.rises_to_walk and holds:
            postures.halt()
        elif not holds and (postures.low or self.posing):
            self._rise(now)

    def _rise(self, now: Now) -> None:
        """A command to move: the posture asked for is dropped, but a machine that has sunk rises
        first, and then walks.
        """
        postures = self.postures
        if not (postures.low and self.activity in (Activity.STAND, Activity.POSTURE)):
            return postures.halt()
        if postures.wanted != "stand" and not self._is_refused(now.command, now.terrain):
            self.pose("stand")
            self.job.refused = now.command, now.terrain
        postures.rises_to_walk = postures.wanted == "stand"

    def _take_posture(self, now: Now) -> None:
        """From standing: plan the posture that is wanted, and begin; the order of the legs takes a
        few ticks to find.
        """
        run, postures = self.run, self.postures
        if not postures.is_choosing:
            why = postures.begin(now.terrain)
            if why is not None:
                return self._give_up(why)
            self.job.forget()
        here = run.actual(now.sensing, run.stance)
        if not run.as_planned(here, run.stance):
            run.stance = here
        answer = postures.planned(run.stance, now.terrain, self.crab_angle)
        if isinstance(answer, Blocked):
            self._give_up(answer)
        elif answer:
            self.blocked = None
            self._play_posture()

    def _give_up(self, why: Blocked) -> None:
        self.postures.halt()
        self.blocked = why

    def _play_posture(self) -> None:
        """The next plan of the posture; when there is none left, it has been taken."""
        if not self.postures.plans:
            return self._posed(self.stance)
        self._interrupt(self.postures.next_plan(), Event.POSTURE_READY)
        self.steps_begun += self.postures.posture == "standard"

    def _posed(self, stance: Stance) -> None:
        self.postures.taken()
        self._rest(stance)

    def _posturing(self, now: Now) -> None:
        """One tick of a posture being taken: is it still wanted, does all go as planned?"""
        if not self.postures.is_still_wanted or self.run.held_back(now.sensing):
            self.postures.broken_off()
            self._stop(now)
        else:
            self._is_surprised(now)

    def _next_posture(self, now: Now, left: float) -> float:
        """A plan of the posture is over; ``left`` seconds of this tick belong to the next one, if
        all came out as planned.
        """
        run, postures, plan = self.run, self.postures, self.plan
        stance = run.arrived(now.sensing)
        good = run.as_planned(stance, plan.end)
        if good:
            stance = plan.end  # what sensors say beside it is noise
        if postures.posture == "standard":
            self.executed = changed(plan, end=stance)
        run.stance = stance
        if not postures.plans:
            self._posed(stance)
            return 0.0
        if not (good and postures.is_still_good(now.terrain)):
            self._rest(stance)  # and plan anew from there: the posture is still wanted
            return 0.0
        self._play_posture()
        return min(left, run.tracker.duration)


_AT = {
    Activity.STAND: GaitSupervisor._standing,
    Activity.STEP: GaitSupervisor._stepping,
    Activity.SETTLE: GaitSupervisor._settling,
    Activity.REFLEX: GaitSupervisor._reacting,
    Activity.HOVER: GaitSupervisor._hovering,
    Activity.POSTURE: GaitSupervisor._posturing,
}
