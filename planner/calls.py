"""Planners as plain calls: a stance, a command and a map in, a step or a refusal out.

Inside, a planner is a job that pauses so that a walk goes on while it works; here the job is run
to its end.
"""

from __future__ import annotations

from dataclasses import replace

from .initial_stance import Placement
from .protocols import Capabilities, PlannerSetup
from .registry import DEFAULT_PLANNER, initial_stance, make_planner
from .robot.model import Machine
from .terrain.map import TerrainMap
from .types import Blocked, Command, Gait, Stance, StepPlan


class StepPlanner:
    """A planner by name, asked for one step after the other.

    ``planner`` is ``"crab"`` (Hirose, Fukuda & Kikuchi 1986, four legs), ``"trace"`` (Kugushev &
    Jaroshevskij 1975, four to eight legs) or one of your own (``register_planner``); ``mode`` one
    of its modes, its default when not given. ``gait`` is the machine's own with the body
    swayed unless given; ``explain`` fills ``StepPlan.decision``. Raises ``PlannerError``, a
    ``ValueError``, for what there is not.

    A planner may remember what it was asked before: use one for one walk.

    >>> import numpy as np
    >>> from walking_console import Command, StepPlanner, TerrainMap, load_machine
    >>> machine = load_machine("titan3")
    >>> terrain = TerrainMap.from_heights(np.zeros((120, 120)), 0.05, machine, origin=(-3.0, -3.0))
    >>> planner = StepPlanner(machine)
    >>> stance = planner.stance_on(terrain)
    >>> plan = planner.plan(stance, Command(speed=0.1), terrain)
    >>> plan.swing, round(plan.shift, 3)
    ((2,), 0.187)
    """

    def __init__(
        self,
        machine: Machine,
        planner: str = DEFAULT_PLANNER,
        mode: str = "",
        *,
        gait: Gait | None = None,
        explain: bool = False,
    ) -> None:
        self.machine = machine
        self.gait = gait or replace(machine.gait, sways=True)
        self._name = planner
        self._mode = mode
        setup = PlannerSetup(machine, self.gait, mode, explain=explain)
        self._planner = make_planner(planner, setup)

    @property
    def capabilities(self) -> Capabilities:
        """What it declares it can do."""
        return self._planner.capabilities

    def stance_on(
        self,
        terrain: TerrainMap,
        x: float = 0.0,
        y: float = 0.0,
        yaw: float = 0.0,
        crab_angle: float = 0.0,
    ) -> Stance:
        """The posture this planner begins a walk in, with the body over x, y (m) heading ``yaw``
        (rad), for a first course of ``crab_angle`` (rad).

        Raises ``ValueError`` where a foot would stand on forbidden ground.
        """
        place = Placement((x, y, yaw), terrain.height_at, crab_angle)
        stance = initial_stance(self._name, self._mode, self.machine, self.gait, place)
        for number, (foot_x, foot_y, _) in enumerate(stance.feet, 1):
            if not terrain.allows(foot_x, foot_y):
                raise ValueError(
                    f"foot {number} would stand on forbidden ground at ({foot_x:.3f}, {foot_y:.3f})"
                )
        return stance

    def plan(self, stance: Stance, command: Command, terrain: TerrainMap) -> StepPlan | Blocked:
        """The step from ``stance`` under ``command``, or ``Blocked``, which says why there is none.

        ``plan.end`` is the stance to plan the next step from.
        """
        return self._planner.plan_step(stance, command, terrain)
