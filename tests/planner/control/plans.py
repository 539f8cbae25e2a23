"""A machine on level ground, what it senses, and a plan of one swing. Shared by the control
tests.
"""

import math
from dataclasses import replace

import numpy as np

from walking_console.planner.config import Tolerances
from walking_console.planner.control.execution import Execution
from walking_console.planner.control.foot_controller import ReflexState
from walking_console.planner.control.plan_job import PlanJob
from walking_console.planner.control.walk_state import Now, WalkState
from walking_console.planner.protocols import Capabilities, Planner
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import Command, Gait, Phase, Sensing, Stance, StepPlan

TITAN = load_machine("titan3")
HEIGHT = TITAN.height
FEET = tuple((*leg.centre, 0.0) for leg in TITAN.legs)
ON = (True, True, True, True)
FRESH = ReflexState.begin(4)
GAIT = Gait(TITAN.duty_factor, TITAN.lift_up, TITAN.lift_down, HEIGHT)
STANCE = Stance((0.0, 0.0, HEIGHT, 0.0), FEET)
AHEAD = Command(0.0, 0.1)


def sensed(
    body: tuple[float, ...] = (0.0, 0.0, HEIGHT, 0.0, 0.0, 0.0), feet=FEET, soles=ON
) -> Sensing:
    """What a machine with these feet senses; its posture is small."""
    x, y, z, roll, pitch, yaw = body
    c, d = math.cos(yaw), math.sin(yaw)
    level = [
        (c * (fx - x) + d * (fy - y), c * (fy - y) - d * (fx - x), fz - z) for fx, fy, fz in feet
    ]
    feet_b = tuple(
        (px - pz * pitch, py + pz * roll, pz + px * pitch - py * roll) for px, py, pz in level
    )
    return Sensing(0, (x, y, z, roll, pitch, yaw), feet_b, soles, (0,) * 4, (False,) * 4)


def swing_plan(leg: int = 0, advance: float = 0.1) -> StepPlan:
    """Support, up, return, down of one leg, while the body goes ahead at 0.1 m/s."""
    times = np.array([0.0, 0.25, 0.375, 0.875, 1.0])
    body = np.array([[advance * t, 0.0, HEIGHT, 0.0] for t in times])
    feet = np.array([FEET] * 5)
    x = FEET[leg][0]
    feet[2:, leg, 2] = 0.1, 0.1, -0.1
    feet[3:, leg, 0] = x + 0.2
    return StepPlan(
        (leg,),
        times,
        body,
        feet,
        (Phase.SUPPORT, Phase.UP, Phase.RETURN, Phase.DOWN),
        Stance((0.1, 0, HEIGHT, 0), FEET),
    )


class Scripted(Planner):
    """Answers with what it is given, after so many slices of a ``weight``; ``asked`` and
    ``hurried`` count.
    """

    def __init__(self, *answers, slices=0, weight=None):
        self.weight = weight
        self.answers = list(answers)
        self.slices = slices
        self.asked = []
        self.hurried = 0

    @property
    def capabilities(self):
        return Capabilities()

    def plan(self, stance, command, terrain):
        self.asked.append(command)
        answer = self.answers[min(len(self.asked), len(self.answers)) - 1]
        for _ in range(self.slices):
            if (yield self.weight):
                self.hurried += 1
                break
        return answer


def flat(holes=False):
    """Level ground, or ground that may be stepped on nowhere."""
    forbidden = np.full((160, 160), holes)
    return TerrainMap(np.where(forbidden, np.nan, 0.0), forbidden, 0.05, (-4.0, -4.0))


def execution(config=None, plant=None):
    return Execution(TITAN, GAIT, STANCE, config, plant or Tolerances())


def state_with(planner=None, config=None):
    run = execution(config)
    return WalkState(
        run, PlanJob(planner or Scripted(None), TITAN.yaw_length, run.config.planning), 0.3
    )


def now(command=AHEAD, terrain=None, **more):
    return Now(sensed(**more), command, terrain or flat(), command.holds)


def swinging_at(t):
    """A machine in the middle of ``swing_plan``, and where its plan has everything then."""
    state = state_with()
    state.run.play(swing_plan())
    state.run.t = t
    tracker = state.run.tracker
    x, y, z, yaw = tracker.body_at(t)
    feet = tuple(tracker.foot_at(leg, t) for leg in range(4))
    return state, replace(STANCE, body=(x, y, z, yaw), feet=feet)
