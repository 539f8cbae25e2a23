"""``Snapshot``: the world at one instant, all a viewer may see."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.robot.model import Machine
from walking_console.planner.types import Command, GaitPreview, Mode, Point, StepPlan


@dataclass(frozen=True, slots=True, eq=False)
class TerrainView:
    """The ground as viewers draw it. A new ``revision`` means: draw it again. NaN height is a
    bottomless hole.
    """

    revision: int
    heights: NDArray[np.float64]  # (ny, nx) m, row index y, column index x, write-protected
    forbidden: NDArray[np.bool_]  # (ny, nx) what the machine believes it must not step on
    cell: float  # m
    origin: tuple[float, float]  # m, corner of cell [0, 0]


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """One instant. Absolute frame; SI units; legs in machine order."""

    tick: int
    time: float  # s of simulated time
    machine: Machine
    scenario: str
    planner: str  # crab | trace
    planner_mode: str  # paper | predictive
    body: tuple[float, float, float, float, float, float]  # x, y, z, roll, pitch, yaw
    feet: tuple[Point, ...]  # foot tips
    contact: tuple[bool, ...]  # sole sensors
    support: tuple[bool, ...]  # legs meant to carry
    mode: Mode
    reason: str  # why it is blocked, tipping or fallen; "" otherwise
    command: Command
    speed: float  # m/s, what is walked now
    speed_max: float  # m/s, v_max of the running step; 0 when none runs
    margin: float  # longitudinal, m
    polygon_margin: float  # m
    energy_margin: float  # m
    step: int  # steps begun
    distance: float  # m walked along the commanded course
    plan: StepPlan | None  # the running step
    plan_time: float  # s into it
    ready: StepPlan | None  # the step after it, once planned
    terrain: TerrainView
    flags: tuple[bool, bool, bool]  # F1, F2, F3 of H §9.3
    whiskers: tuple[int, ...]
    paused: bool
    rate: float  # times real time
    late: float  # s, worst lateness of the walking clock in the last second
    attitude: str = "level"  # of the body: level, or ground when it is to follow it
    posture: str = "stand"  # the posture it is in, or is being taken to: stand | sit | standard
    course: float = 0.0  # s of the body on its trace, m (trace planner)
    # what the trace walker foresees; the same object until it foresees something else
    ahead: GaitPreview | None = None
    # why the running step, or why there is none, where the console keeps it
    decision: Mapping[str, Any] | None = None
