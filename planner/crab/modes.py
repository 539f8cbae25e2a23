"""Hirose's planner as a whole, in its three modes: detours, slopes and steps in one object.

From the command down: ``SlopeAdaptation`` gives the machine and the frame to plan in (mode
``predictive`` only), ``LocalPlanner`` (Level B1) the course, and the mode's own planner the step.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from ..motion.body_sway import swaying
from ..motion.leg_choice import on_surer_legs
from ..motion.steady_course import holding, steadied
from ..navigation.local_planner import LocalPlanner, RouteState
from ..protocols import (
    BodyAttitude,
    Capabilities,
    PlanFunction,
    Planner,
    PlannerError,
    PlannerSetup,
    PlanningJob,
    checked_attitude,
    without_pause,
)
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Blocked, Command, Stance, StepPlan
from . import baseline, planner
from .expected_supports import expected_supports
from .gait import AGREEMENT, off_standard, turns
from .predictive_planner import step_job
from .slope_adaptation import SlopeAdaptation
from .steps import StepRequest

# The crab walk has a standard margin of 0 at β = 0.75 (H §4.3 (3)).
PAPER = Capabilities(
    leg_counts=(4,),
    takes_detours=True,
    gives_decision=True,
    standard_within=AGREEMENT,
    duty_factor_min=0.75,
)
PREDICTIVE = PAPER.but(may_lean=True, fits_slopes=True)
NAIVE = PAPER.but(takes_detours=False, turns=False)


class CrabPlanner(Planner):
    """Hirose's planner: ``predictive``, ``paper``, or ``naive`` to show what the paper warns of."""

    def __init__(self, setup: PlannerSetup, capabilities: Capabilities) -> None:
        self._capabilities = capabilities
        self._machine = setup.machine
        self._gait = setup.gait
        self._job = _JOBS[setup.mode]
        self._explain = setup.explain
        self._config = setup.config
        detours = setup.detours and capabilities.takes_detours
        self._local = LocalPlanner(
            setup.cautious, capabilities.fits_slopes, detours, setup.config.navigation
        )
        self._slopes: SlopeAdaptation | None = None
        self._plan = self._planner_for(setup.machine)
        if capabilities.fits_slopes:
            self._slopes = SlopeAdaptation(setup.machine, setup.gait, self._planner_for)
            self._plan = self._slopes
        self.take_attitude(setup.attitude)

    def _planner_for(self, machine: Machine) -> PlanFunction:
        """What plans the steps of one machine, on courses of Level B1 if there is one."""

        def steps(stance: Stance, command: Command, terrain: TerrainMap) -> PlanningJob:
            known = stance, command, terrain, machine, self._gait
            return self._job(StepRequest(*known, self._explain, self._config))

        return partial(self._local.plan, steps, machine)

    @property
    def capabilities(self) -> Capabilities:
        return self._capabilities

    @property
    def route(self) -> RouteState:
        """What Level B1 remembers."""
        return self._local.route

    def plan(self, stance: Stance, command: Command, terrain: TerrainMap) -> PlanningJob:
        held = None
        if not turns(command, self._machine):
            command, held = steadied(command, stance, self._machine)
        stance = holding(stance, held)
        if not self._gait.sways:
            return self._plan(stance, command, terrain)
        swayed = partial(self._swayed, command, terrain)
        return on_surer_legs(swayed, stance, self._gait) if self._slopes else swayed(stance)

    def _swayed(self, command: Command, terrain: TerrainMap, stance: Stance) -> PlanningJob:
        answer = yield from self._plan(stance, command, terrain)
        if isinstance(answer, Blocked):
            return answer
        ahead = expected_supports(answer, command, self._machine, self._gait)
        return (yield from swaying(answer, stance, ahead, self._gait, self._machine, terrain))

    def heed(self, command: Command) -> Command:
        return self._local.heed(command)

    def off_standard(self, plan: StepPlan) -> float | None:
        if plan.end.last_swing < 0:
            return None
        return off_standard(self._machine, self._gait, plan.crab_angle, plan.end)

    @property
    def attitude(self) -> BodyAttitude:
        return "level" if self._slopes is None else self._slopes.attitude

    def take_attitude(self, attitude: str) -> None:
        wanted = checked_attitude(attitude)
        if self._slopes is not None:
            self._slopes.attitude = wanted
        elif wanted != self.attitude:
            raise PlannerError(
                'the body follows the ground only with the crab planner in mode "predictive"'
            )


MODES = {"predictive": PREDICTIVE, "paper": PAPER, "naive": NAIVE}
_JOBS: dict[str, Callable[[StepRequest], PlanningJob]] = {
    "predictive": step_job,
    "paper": without_pause(planner.plan_step),
    "naive": without_pause(baseline.plan_step),
}
