"""The gait supervisor: decides once a tick which plan is played, and answers with foot velocities.

What it is at is a row of the table in ``activities``; each row has a part that says what happens in
a tick of it: steps (``step_controller``), postures on command (``posture_controller``), feet that
meet what the map does not show (``contact_reflexes``). They share a ``WalkState``.

``GaitSupervisor`` is changed in place, once a tick, by the simulation alone; viewers get a
``Snapshot``. (A frozen value rebuilt every 20 ms cost a tenth of the whole tick.)
"""

from __future__ import annotations

import math

from ..protocols import Planner
from ..terrain.map import TerrainMap
from ..types import Blocked, Command, Mode, Phase, Point, Sensing, Stance, StepPlan
from .activities import RESUMED, STILL, Activity
from .contact_reflexes import ContactReflexes
from .execution import END, Execution, kept_stance
from .handshake import Flags
from .pacing import pace_for
from .place_doubt import PlaceDoubt
from .plan_job import PlanJob
from .posture_controller import Layout, PostureController
from .sole_watch import SoleWatch
from .step_controller import StepController
from .walk_state import Now, WalkState

MODES_OF_A_STEP = {
    Phase.SUPPORT: Mode.SUPPORT,
    Phase.UP: Mode.UP,
    Phase.RETURN: Mode.RETURN,
    Phase.DOWN: Mode.DOWN,
    Phase.SHIFT: Mode.SHIFT,
}
MODES_OF_A_POSTURE = {"sit": Mode.SIT_DOWN, "stand": Mode.STAND_UP, "standard": Mode.REGROUP}
# looked at every tick: a name of the module is found quicker than one of a class
_STEP = Activity.STEP
_POSTURE = Activity.POSTURE
MODES = {
    Activity.HOVER: Mode.BLOCKED,
    Activity.SETTLE: Mode.SETTLE,
    Activity.REFLEX: Mode.EMERGENT,
}


class GaitSupervisor:
    """One walker's walk.

    ``planner`` plans its steps, ``run`` is the machine as it stands, ``layout`` gives the standard
    posture of a course, ``crab_angle`` (rad) is that of the first course.
    """

    def __init__(
        self, planner: Planner, run: Execution, layout: Layout, crab_angle: float = 0.0
    ) -> None:
        self.run = run
        self.job = PlanJob(planner, run.machine.yaw_length, run.config.planning)
        self.state = WalkState(run, self.job, crab_angle)
        self.contacts = ContactReflexes(self.state, planner.capabilities.standing_min)
        self._soles = SoleWatch(self.state, self.contacts)
        self.postures = PostureController(self.state, layout)
        self._steps = StepController(self.state)
        self._heed = planner.heed
        drift = run.tolerances.drift
        self._doubt = PlaceDoubt(drift) if drift > 0.0 else None
        self._work = run.config.planning.work
        self._now: Now | None = None

    # what others may ask

    @property
    def activity(self) -> Activity:
        """What it is at."""
        return self.state.activity

    @property
    def stands(self) -> bool:
        """True while it stands on its feet and plays nothing."""
        return self.state.stands

    @property
    def steps(self) -> bool:
        """True while a step is played."""
        return self.state.steps

    @property
    def plays(self) -> bool:
        """True while a plan is played that moves anything."""
        return self.state.activity not in STILL

    @property
    def plan(self) -> StepPlan:
        """The plan that runs."""
        return self.run.plan

    @property
    def ready(self) -> StepPlan | None:
        """The step after the running one, once it is planned."""
        return self.job.ready

    @property
    def executed(self) -> StepPlan | None:
        """The step finished in this tick, its end as it came out."""
        return self.state.executed

    @property
    def blocked(self) -> Blocked | None:
        """Why it stands when it should not."""
        return self.state.blocked

    @property
    def stance(self) -> Stance:
        """The stance at the last step-switching point."""
        return self.run.stance

    @property
    def kept_stance(self) -> Stance:
        """The same, by the reference that a body still rests beside."""
        return kept_stance(self.run)

    @property
    def flags(self) -> Flags:
        """F1, F2, F3 of H §9.3."""
        return self.job.flags

    @property
    def steps_begun(self) -> int:
        """Steps begun, those of a posture that is walked into among them."""
        return self.state.steps_begun

    @property
    def heading(self) -> float:
        """Absolute direction of the course walked, rad."""
        return self.state.heading

    @property
    def posture(self) -> str:
        """The posture it is in, or going to: stand, sit or standard."""
        return self.state.posture

    @property
    def speed(self) -> float:
        """Of the body on its course, in the mean of the step; while it comes to rest, now: m/s."""
        if self.steps:
            return self.plan.mean_speed * self.run.pace
        if self.activity is not Activity.SETTLE:
            return 0.0
        vx, vy, _, turn = self.run.tracker.velocity_at(self.run.t)
        return math.hypot(vx, vy, self.run.machine.yaw_length * turn)

    @property
    def loads(self) -> tuple[float, ...] | None:
        """What the legs are to press with, N; None for a plant whose legs do not give."""
        compliant = self.run.compliant
        return None if compliant is None else compliant.loads

    @property
    def mode(self) -> Mode:
        """What it is at, in the words of the log."""
        activity = self.state.activity
        if activity is _STEP:
            run = self.run
            return MODES_OF_A_STEP[run.tracker.phase(run.t)]
        if activity is _POSTURE:
            return MODES_OF_A_POSTURE[self.posture]
        if activity is not Activity.STAND:
            return MODES[activity]
        if self.blocked:
            return Mode.BLOCKED
        sits = self.posture == "sit" and not self.postures.wanted
        return Mode.SIT if sits else Mode.STAND

    def carrying(self) -> tuple[bool, ...]:
        """Legs meant to carry: all that do not swing, and swing legs that have landed early."""
        return self.run.carrying(self.state.stands)

    # postures on command

    def pose(self, posture: str) -> str:
        """Take a posture as soon as it stands; why not, or '' when it will."""
        return self.postures.ask(posture)

    def halt(self) -> None:
        """Whatever posture it is taking, it stops in the next tick, and stays as it is."""
        self.postures.halt()

    @property
    def posing(self) -> bool:
        """True while a posture is being taken, or is to be."""
        return self.postures.is_busy

    # one tick

    def advance(self, sensing: Sensing, command: Command, terrain: TerrainMap) -> list[Point]:
        """Decide for one tick: foot velocities in body axes, m/s, in leg order."""
        state = self.state
        state.executed = None
        self.job.begin_tick()
        command = self._heed(command)
        if self.run.compliant is not None:
            sensing = self.run.compliant.believed(sensing)
        if self._doubt is not None:
            terrain = self._doubt.cautious(sensing, terrain)
        now = self._now
        if now is None or now.command is not command:
            now = self._now = Now(sensing, command, terrain, command.holds)
        else:
            now.sensing = sensing
            now.terrain = terrain
        postures = self.postures
        if postures.wanted or postures.low or state.activity is _POSTURE:
            postures.listen(now)
        _AT[state.activity](self, now)
        return self.run.velocities_to(self._time_ahead(now), sensing)

    def _standing(self, now: Now) -> None:
        if self.postures.wanted:
            self.postures.take(now)
        elif not now.holds and not self._loses_its_stand(now):
            self._steps.start(now)

    def _loses_its_stand(self, now: Now) -> bool:
        """True while a leg that should stand does not."""
        return self.contacts.loses_a_foothold(now) or self._soles.keeps_standing(now)

    def _stepping(self, now: Now) -> None:
        run = self.run
        if now.holds:
            self.state.stop(now)
        elif run.held_back(now.sensing):
            self._steps.count_held_back(now)
            self.state.stop(now)
        elif not self.contacts.is_surprised(now):
            self.job.consider(run.tracker.plan.end, now.command, now.terrain, self._work)
            if run.compliant is not None:
                run.compliant.foresee(self.job.ready)

    def _posturing(self, now: Now) -> None:
        if not self.postures.is_still_wanted or self.run.held_back(now.sensing):
            self.postures.break_off(now)
        else:
            self.contacts.is_surprised(now)

    def _settling(self, now: Now) -> None:
        run = self.run
        if run.comes_to_rest or self.contacts.loses_a_foothold(now):
            return
        lifted = self.plan.end.lifted
        if all(run.landed(leg) for leg in self.plan.swing if leg not in lifted):
            self.state.stand_still(now, lifted)
            self._walk_on(now)

    def _reacting(self, now: Now) -> None:
        self.contacts.react(now)
        self._walk_on(now)

    def _walk_on(self, now: Now) -> None:
        """A foot that was put down after its step: the walk goes on in the same tick, unless the
        map is to be told something first.
        """
        if self.stands and not self.contacts.has_news and not self.postures.wanted:
            self._standing(now)

    def _hovering(self, now: Now) -> None:
        """Ordered on, it goes on with what it was at."""
        state = self.state
        if now.holds:
            return
        state.happens(RESUMED[state.hovered])
        state.blocked = None
        if state.activity is Activity.REFLEX:
            self.contacts.go_on(now)

    def _time_ahead(self, now: Now) -> float:
        """Time into the plan by the end of this tick; what is over gives way to what comes next."""
        run = self.run
        activity = self.state.activity
        stepping = activity is _STEP
        if not stepping and activity in STILL:
            run.pace = 0.0
            return run.t
        run.pace = pace_for(run, now.command) if stepping else 1.0
        t_next, left = run.time_ahead()
        if stepping and run.t <= run.tracker.rises_until and self._soles.keeps_down(t_next, now):
            return run.t
        if t_next < run.tracker.duration - END:
            return t_next
        if activity is Activity.REFLEX:
            return run.tracker.duration
        if run.feels_on(stepping, now.sensing):
            return run.tracker.duration
        if activity is Activity.SETTLE or run.misses_ground(stepping):
            return self.contacts.find_no_ground(now)
        follow = self._steps.switch if stepping else self.postures.next_plan
        return self._soles.time_begun(follow(now, max(left, 0.0)), now)


_AT = {
    Activity.STAND: GaitSupervisor._standing,
    Activity.STEP: GaitSupervisor._stepping,
    Activity.SETTLE: GaitSupervisor._settling,
    Activity.REFLEX: GaitSupervisor._reacting,
    Activity.HOVER: GaitSupervisor._hovering,
    Activity.POSTURE: GaitSupervisor._posturing,
}
