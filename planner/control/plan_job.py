"""The conversation of Levels B and C: which step is asked for, how far its planning is, what is
ready.

While step k is walked, step k+1 is planned from the stance expected at N_{k+1} (H §4.4), a few
slices a tick: as many as weigh what a tick may take, counted and never timed. Flags as in H §9.3
(``handshake``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..config import Planning
from ..geometry.transforms import direction
from ..protocols import Announced, Planner, PlanningJob
from ..terrain.map import TerrainMap
from ..types import Blocked, Command, Stance, StepPlan
from .handshake import Flags, Handshake

HURRY = 4  # this part of a tick's work is done on top of it by a job that is to come to an end
SLICE = 10  # weight of a slice that says nothing of its own, in postures looked at


@dataclass(frozen=True, slots=True, eq=False)
class Question:
    """What a step is planned for."""

    stance: Stance
    command: Command
    terrain: TerrainMap


class PlanJob:
    """The planning of the next step, across ticks. ``refused`` is what the last ``Blocked``
    answered.
    """

    def __init__(self, planner: Planner, yaw_length: float, settings: Planning) -> None:
        self.planner = planner
        self.settings = settings
        self.shake = Handshake()
        self.asked: Question | None = None
        self.refused: tuple[Command, TerrainMap] | None = None
        self._yaw_length = yaw_length
        self._job: PlanningJob | None = None
        self._has_begun = False  # the job; only then can it be told that its answer is wanted
        self._ready: StepPlan | Blocked | None = None
        # a step planned to its end for a command much like this one
        self._spare: tuple[Command, StepPlan] | None = None
        self._waited = 0  # ticks Level C has waited for the step
        self._spent = 0  # weight of what was done in this tick
        self._put_off = 0  # weight of what was left to the next one

    def begin_tick(self) -> None:
        """What was done before belongs to the tick before."""
        self._spent = 0
        self.shake.begin_tick()

    @property
    def flags(self) -> Flags:
        """F1, F2, F3 of H §9.3."""
        return self.shake.flags

    @property
    def ready(self) -> StepPlan | None:
        """The next step, once it is planned."""
        return self._ready if isinstance(self._ready, StepPlan) else None

    def consider(
        self,
        stance: Stance,
        command: Command,
        terrain: TerrainMap,
        work: int,
        is_waited_for: bool = False,
    ) -> None:
        """Ask for a step unless just that was asked already; plan a little further on it, until
        this tick's ``work`` is done, of which a step that ``is_waited_for`` leaves nothing that
        is announced to the next one.

        While the stick moves a little, or only farther out, a job is finished all the same, and its
        step is kept while the next is begun.
        """
        asked = self.asked
        same = (
            asked is not None
            and asked.command is command
            and asked.stance is stance
            and asked.terrain is terrain
        )  # as in most ticks
        if not same and self._begins_with(stance, command, terrain):
            self.asked = Question(stance, command, terrain)
            self._job = self.planner.plan(stance, command, terrain)
            self._has_begun = False
            self._put_off = 0
            self._ready = None
            self.shake.call()
        if self._ready is None:
            self._go_on(work, is_waited_for)

    def _begins_with(self, stance: Stance, command: Command, terrain: TerrainMap) -> bool:
        """True when a new job is to be begun; what is ready already is kept where it may serve."""
        asked = self.asked
        if asked is None or asked.stance is not stance or asked.terrain is not terrain:
            self._spare = None
            return True
        if asked.command is command or asked.command == command:
            return False
        if self._ready is None and self.alike(asked.command, command):
            return False
        if isinstance(self._ready, StepPlan):
            self._spare = asked.command, self._ready
        return True

    def answer(self, command: Command) -> StepPlan | Blocked | None:
        """The step that is ready, for this command or for one alike; None when there is none
        yet.
        """
        if self._ready is not None or self._spare is None:
            return self._ready
        return self._spare[1] if self.alike(self._spare[0], command) else None

    def stance_asked(self, command: Command, terrain: TerrainMap) -> Stance | None:
        """The stance the running job plans from, when it is one for such a command on this map."""
        asked = self.asked
        if asked is None or asked.terrain is not terrain:
            return None
        return asked.stance if self.alike(asked.command, command) else None

    def answer_standing(
        self, stance: Stance, command: Command, terrain: TerrainMap
    ) -> StepPlan | Blocked | None:
        """One tick of planning a step from a standstill; after a few ticks the best so far will
        do.
        """
        work = self.settings.work_wanted
        self.shake.want()
        self._waited += 1
        will_do = self._waited >= self.settings.wait_max  # the best so far
        self.consider(stance, command, terrain, work, is_waited_for=True)
        if will_do and self.answer(command) is None:
            self._go_on(work + work // HURRY, is_waited_for=True, wanted_now=True)
        return self.answer(command)

    def alike(self, one: Command, other: Command) -> bool:
        """True when a step for one command will do for the other: another speed, and all but the
        same course.
        """
        if one == other:
            return True
        if one.holds or other.holds:
            return False
        ax, ay, at = self._velocity(one)
        bx, by, bt = self._velocity(other)
        least = math.cos(self.settings.alike) * math.hypot(ax, ay, at) * math.hypot(bx, by, bt)
        return ax * bx + ay * by + at * bt >= least

    def _velocity(self, command: Command) -> tuple[float, float, float]:
        """Of the body ahead, to the left and, at the yaw length, round, m/s."""
        c, s = direction(command.crab_angle)
        return command.speed * c, command.speed * s, self._yaw_length * command.turn_rate

    def _go_on(self, work: int, is_waited_for: bool, wanted_now: bool = False) -> None:
        """Slices of the job until so much has been done in this tick: the last may be more than was
        left, but for one that is announced for a step that is not waited for.
        """
        if self._job is None:
            return
        self._spent += self._put_off
        self._put_off = 0
        try:
            while self._spent < work:
                hurried = wanted_now and self._has_begun
                self._has_begun = True
                weight = self._job.send(True) if hurried else next(self._job)
                if not isinstance(weight, Announced):
                    self._spent += SLICE if weight is None else weight
                elif not is_waited_for:
                    if self._spent + weight > work:
                        self._put_off = min(weight, work - 1)
                        break
                    self._spent += weight
        except StopIteration as done:
            self._ready = done.value
            self._job = None
            self.shake.complete()

    def forget(self) -> None:
        """Nothing is asked for and nothing is ready."""
        self.asked = None
        self._job = None
        self._ready = None
        self._spare = None

    def begun(self) -> None:
        """The step that was ready has begun: the next one is called for."""
        self.shake.complete()  # of a step kept for a command alike Level B works on another
        self.shake.receive()
        self.forget()
        self._waited = 0
        self.shake.call()

    def rest(self, keep_job: bool = False) -> None:
        """Level C stands and wants no step; a job under way may be gone on with."""
        self.refused = None
        self._waited = 0
        if not keep_job:
            self.forget()
            self.shake.dismiss()
