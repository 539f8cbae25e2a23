"""Which brain walks: a planner picked by name, and the posture it begins in."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from .control.supervisor import PlanStep, Think, Thinking
from .crab import baseline, predictive_planner
from .crab.gait import standard_stance
from .crab.planner import plan_step
from .crab.slope_adaptation import KINDS, Attitude, Kind, fitted_at_start
from .geometry.paths import SampledPath
from .robot.model import Machine
from .terrain.map import TerrainMap
from .trace.paths import trace_for
from .trace.periodic_gaits import rigid_gait
from .trace.planner import TraceWalk
from .trace.preview import ahead, course_now
from .types import Command, Gait, GaitPreview, Point, Stance, StepPlan

Pose = tuple[float, float, float]  # x, y, yaw
HeightAt = Callable[[float, float], float]
Via = Callable[[Think, Machine, Stance, Command, TerrainMap], Thinking]
# the crab mode that fits strides and posture to slopes; the others stay as they were printed
FITTING = "predictive"


class PlannerError(ValueError):
    """A choice of planner, mode or trace that cannot be; the message is one clear line."""


def crab_brain(
    mode: str,
    machine: Machine,
    gait: Gait,
    attitude: Kind = "level",
    via: Via | None = None,
    *,
    explain: bool = False,
) -> Think:
    """Hirose's planner: ``predictive``, ``paper``, or ``naive`` to show what the paper warns of.

    ``via`` comes between: a Level B1 that asks the thought of a machine for steps on courses of its
    own. Only ``predictive`` fits its strides to slopes and may lean with them (``attitude``).
    """
    if mode not in CRAB_MODES:
        raise PlannerError(f"unknown crab mode {mode!r}; there are: {', '.join(CRAB_MODES)}")

    def think_of(machine: Machine) -> Think:
        think = CRAB_MODES[mode](machine, gait, explain)
        return think if via is None else partial(via, think, machine)

    return Attitude(machine, gait, think_of, attitude) if mode == FITTING else think_of(machine)


def attitude_of(think: Think) -> Kind:
    """Whether the body is level or follows the ground."""
    return think.kind if isinstance(think, Attitude) else "level"


def take_attitude(think: Think, kind: str) -> None:
    """Level, or following the ground, from the next step planned on; raises ``PlannerError`` for a
    planner that cannot.
    """
    if kind not in KINDS:
        raise PlannerError(f"unknown attitude {kind!r:.80}; there are: {', '.join(KINDS)}")
    if isinstance(think, Attitude):
        think.kind = "ground" if kind == "ground" else "level"
    elif kind != "level":
        raise PlannerError(
            f'the body follows the ground only with the crab planner in mode "{FITTING}"'
        )


def drawn_trace(trace: Mapping[str, Any], machine: Machine, start: Pose) -> SampledPath:
    """A scenario's trace, sampled: too slow for a tick when it is long."""
    try:
        return trace_for(trace, machine, start)
    except ValueError as error:
        raise PlannerError(str(error)) from None


def trace_brain(
    machine: Machine,
    gait: Gait,
    course: SampledPath | None,
    rigid: str | None = None,
    *,
    explain: bool = False,
) -> Think:
    """Kugushev and Jaroshevskij's planner, along a given trace or, with none, wherever the joystick
    leads.
    """
    try:
        walk = TraceWalk(machine, gait, course, None if rigid is None else rigid_gait(rigid))
    except ValueError as error:
        raise PlannerError(str(error)) from None
    walk.explain = explain
    return walk


def square_stance(machine: Machine, gait: Gait, pose: Pose, height_at: HeightAt) -> Stance:
    """Every foot in the middle of its reach: the posture a trace walk begins in."""
    x, y, yaw = pose
    c, s = math.cos(yaw), math.sin(yaw)
    feet: list[Point] = []
    for leg in machine.legs:
        bx, by = leg.centre
        fx, fy = x + c * bx - s * by, y + s * bx + c * by
        feet.append((fx, fy, height_at(fx, fy)))
    level = [z for _, _, z in feet if z == z] or [0.0]
    return Stance((x, y, sum(level) / len(level) + gait.height, yaw), tuple(feet))


def start_stance(
    planner: str,
    machine: Machine,
    gait: Gait,
    crab_angle: float,
    pose: Pose,
    height_at: HeightAt,
    mode: str = FITTING,
) -> Stance:
    """The posture a walk begins in: standard for the crab planner (gait-dependent, H §4.3), square
    for the trace planner.
    """
    if planner == "crab":
        fit = (
            fitted_at_start(machine, gait, crab_angle, pose, height_at)
            if mode == FITTING
            else machine
        )
        return standard_stance(fit, gait, crab_angle, *pose, height_at)
    return square_stance(machine, gait, pose, height_at)


def foreseen(think: Think, stance: Stance, running: StepPlan | None) -> GaitPreview | None:
    """What a trace walker foresees from the last N_k on, for viewers; None for any other brain."""
    return ahead(think, stance, running) if isinstance(think, TraceWalk) else None


def course_of(
    think: Think,
    stance: Stance,
    running: StepPlan | None,
    body: tuple[float, ...],
    yaw_length: float,
) -> float:
    """s of the body on its trace, m; 0 for a brain without one."""
    return course_now(stance, running, body, yaw_length) if isinstance(think, TraceWalk) else 0.0


def _foreseeing(machine: Machine, gait: Gait, explain: bool) -> Think:
    return partial(predictive_planner.think, machine=machine, gait=gait, explain=explain)


def _as_printed(machine: Machine, gait: Gait, explain: bool) -> Think:
    return _without_pause(partial(plan_step, machine=machine, gait=gait, explain=explain))


def _naively(machine: Machine, gait: Gait, explain: bool) -> Think:
    return _without_pause(partial(baseline.plan_step, machine=machine, gait=gait, explain=explain))


def _without_pause(step: PlanStep) -> Think:
    """A planner that answers at once, as one that could have paused."""

    def think(stance: Stance, command: Command, terrain: TerrainMap) -> Thinking:
        return step(stance, command, terrain)
        yield

    return think


CRAB_MODES: dict[str, Callable[[Machine, Gait, bool], Think]] = {
    "predictive": _foreseeing,
    "paper": _as_printed,
    "naive": _naively,
}
