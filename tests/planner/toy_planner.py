"""A planner of one module and one entry: two tripods in turn, straight on, on six legs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from walking_console.planner.geometry.transforms import placed, turned
from walking_console.planner.protocols import Capabilities, Planner, PlannerSetup, PlanningJob
from walking_console.planner.registry import register_planner
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import Blocked, Command, Phase, Point, Reason, Stance, StepPlan

TRIPODS = ((0, 2, 4), (1, 3, 5))
TIMES = np.array([0.0, 0.5, 1.5, 2.0])  # s: lift, carry, lower
ADVANCE_MAX = 0.1  # m a step
PHASES = (Phase.UP, Phase.RETURN, Phase.DOWN)
SIX_LEGS = Capabilities(leg_counts=(6,), turns=False, standing_min=3)


@register_planner("toy", modes={"": SIX_LEGS})
class ToyPlanner(Planner):
    """Every foot comes down ahead of the middle of its reach by as much as the body goes on."""

    def __init__(self, setup: PlannerSetup) -> None:
        self.setup = setup

    @property
    def capabilities(self) -> Capabilities:
        return SIX_LEGS

    def plan(self, stance: Stance, command: Command, terrain: TerrainMap) -> PlanningJob:
        yield
        swing = TRIPODS[0] if stance.last_swing in TRIPODS[1] else TRIPODS[1]
        advance = min(command.speed * float(TIMES[-1]), ADVANCE_MAX)
        x, y, z, yaw = stance.body
        dx, dy = turned(advance, 0.0, yaw + command.crab_angle)
        feet = list(stance.feet)
        for leg in swing:
            landing = self._landing(leg, (x + 2 * dx, y + 2 * dy, yaw), terrain)
            if landing is None:
                return Blocked(Reason.PROHIBITED_CELL, leg)
            feet[leg] = landing
        end = replace(stance, body=(x + dx, y + dy, z, yaw), feet=tuple(feet), last_swing=swing[0])
        return self._step(stance, end, swing, command)

    def _landing(
        self, leg: int, pose: tuple[float, float, float], terrain: TerrainMap
    ) -> Point | None:
        px, py = placed(pose, *self.setup.machine.legs[leg].centre)
        return (px, py, terrain.height_at(px, py)) if terrain.allows(px, py) else None

    def _step(
        self, stance: Stance, end: Stance, swing: tuple[int, ...], command: Command
    ) -> StepPlan:
        shares = (TIMES / TIMES[-1])[:, None]
        here = np.array(stance.body)
        body = here + shares * (np.array(end.body) - here)
        feet = np.stack([stance.feet, stance.feet, end.feet, end.feet])
        feet[1:3, swing, 2] += self.setup.gait.lift_up
        feet[3, swing, 2] -= self.setup.gait.lift_up  # aims below the ground, so that touch decides
        advance = float(np.hypot(*(body[-1] - body[0])[:2]))
        speed = advance / float(TIMES[-1])
        return StepPlan(
            swing,
            TIMES.copy(),
            body,
            feet,
            PHASES,
            end,
            command.crab_angle,
            shift=advance,
            speed=speed,
            speed_max=ADVANCE_MAX / float(TIMES[-1]),
            landing=end.feet[swing[0]],
        )
