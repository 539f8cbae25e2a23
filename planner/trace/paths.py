"""The traces the walker follows: one that is given, sampled for a machine, or the joystick's.

A joystick's trace is the constant curvature from where the machine stands; it is drawn again,
longer, as the machine walks on.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..geometry.path_kinds import STEP, path_from, sampled
from ..geometry.paths import SampledPath, arc_of_command
from ..geometry.transforms import Pose, direction
from ..robot.model import Machine
from ..types import Array

JOYSTICK_AHEAD = 4.0  # m of s a joystick's trace reaches ahead of the machine


def step_for(machine: Machine) -> float:
    """Metres of s between samples for a machine of this size."""
    return min(STEP, machine.torso[0] / 100)


def trace_for(
    spec: Mapping[str, Any], machine: Machine, start: Pose = (0.0, 0.0, 0.0)
) -> SampledPath:
    """A scenario's ``[trace]`` for this machine, from its start pose on. Raises ``TraceError``."""
    return sampled(path_from(spec), machine.yaw_length, start, step_for(machine))


def joystick_trace(
    start: Pose,
    crab_angle: float,
    speed: float,
    turn_rate: float,
    yaw_length: float,
    ahead: float = JOYSTICK_AHEAD,
    step: float = STEP,
) -> SampledPath:
    """The trace of a held joystick: the course of constant curvature from ``start``."""
    arc, _ = arc_of_command(crab_angle, speed, turn_rate, yaw_length)
    s = np.arange(round(ahead / step) + 1) * step
    angle = arc.turn * s
    sine: Array = s * np.sinc(angle / math.pi)  # sin(angle)/turn, also at turn 0
    versine: Array = s * np.sin(angle / 2) * np.sinc(angle / (2 * math.pi))  # (1 - cos(angle))/turn
    dx = arc.ux * sine - arc.uy * versine
    dy = arc.ux * versine + arc.uy * sine
    x0, y0, yaw0 = start
    c, d = direction(yaw0)
    yaw: Array = np.asarray(yaw0 + angle, dtype=np.float64)
    return SampledPath(step, x0 + c * dx - d * dy, y0 + d * dx + c * dy, yaw)
