"""``Snapshot``: the world at one instant, all a viewer may see.

Every field also says here, and nowhere else, how it leaves the program (``Sent``): frames, their
conversion and the API's description are made from this one list.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.protocols import Capabilities
from walking_console.planner.robot.model import Machine
from walking_console.planner.types import Command, GaitPreview, Mode, Point, StepPlan


@dataclass(frozen=True, slots=True)
class Sent:
    """How a field goes out to pages and scripts.

    A field without a ``Sent`` goes out under its own name. ``key`` is the name with the unit in it
    (``_m``, ``_m_s``, ``_rad``, ``_s``), ``meaning`` what a reader of the API is told, ``example``
    a value as it looks outside. ``parts`` spreads a record over keys of their own. ``may_lack``:
    there are moments without a finite value, which go out as null. ``inside``: it does not go out
    like this; it is drawn, or has a frame of its own.
    """

    key: str = ""
    meaning: str = ""
    example: Any = None
    parts: Mapping[str, Sent] = field(default_factory=dict)
    may_lack: bool = False
    inside: bool = False


INSIDE = Sent(inside=True)
COMMANDED = Sent(
    parts={
        "crab_angle": Sent("crab_angle_rad", example=0.0),
        "speed": Sent("speed_m_s", "commanded", 0.1),
        "turn_rate": Sent("turn_rate_rad_s", example=0.0),
    }
)
DECLARED = Sent(
    parts={
        "may_lean": Sent("", "the planner lets the body follow the ground", True),
        "turns": Sent("may_turn", "the planner takes a turn rate", True),
        "follows_trace": Sent("", "the planner walks along a trace", False),
    }
)
FEET_SHOWN = [[1.7, 0.5, 0.0], [0.8, 0.5, 0.0], [0.8, -0.5, 0.0], [1.7, -0.5, 0.05]]
LOADS = [249.1, 284.2, 251.5, 0.0]
JOINTS = [[0.5, 0.45, -0.85], [-0.5, 0.45, -0.85], [-0.5, -0.45, -0.85], [0.5, -0.45, -0.8]]
THREE_OF_FOUR = [True, True, True, False]
POSTURE_MEANING = "in it, or being taken to it: stand, sit or standard"
ATTITUDE_MEANING = "of the body: level, or ground when it is to follow it"


class WholeMap(Protocol):
    """A wide map, as far as viewers may ask it."""

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""

    @property
    def origin(self) -> tuple[float, float]:
        """x, y of the corner of cell [0, 0], m."""

    def read(self, rows: slice, columns: slice) -> NDArray[np.float64]:
        """True heights of rows and columns, m; every so many where the slices have a step."""


@dataclass(frozen=True, slots=True, eq=False)
class TerrainView:
    """The ground as viewers draw it. A new ``revision`` means: draw it again. NaN height is a
    bottomless hole. Of a wide map it is a window about the machine.
    """

    revision: int
    heights: NDArray[np.float64]  # (ny, nx) m, row index y, column index x, write-protected
    forbidden: NDArray[np.bool_]  # (ny, nx) what the machine believes it must not step on
    cell: float  # m
    origin: tuple[float, float]  # m, corner of cell [0, 0]
    # where cell [0, 0] is in the whole map, and that map where this is a window of a wide one
    corner: tuple[int, int] = (0, 0)
    whole: WholeMap | None = None

    @property
    def whole_shape(self) -> tuple[int, int]:
        """Rows and columns of the whole map."""
        rows, columns = self.heights.shape
        return (rows, columns) if self.whole is None else self.whole.shape

    @property
    def whole_origin(self) -> tuple[float, float]:
        """x, y of the corner of cell [0, 0] of the whole map, m."""
        return self.origin if self.whole is None else self.whole.origin


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """One instant: what a viewer may see. Absolute frame, SI units, legs in machine order. Frozen.

    >>> from walking_console import Simulation, load_scenario
    >>> sim = Simulation(load_scenario("flat"))
    >>> seen = sim.snapshot()
    >>> seen.time, seen.mode.name, seen.contact, round(seen.polygon_margin, 3)
    (0.0, 'STAND', (True, True, True, True), 0.457)
    """

    tick: Annotated[int, Sent(example=4211)]
    time: Annotated[float, Sent("time_s", example=84.22)]  # s of simulated time
    machine: Annotated[Machine, Sent("robot", example="titan3")]
    scenario: Annotated[str, Sent(example="dem")]
    planner: Annotated[str, Sent(example="crab")]
    planner_mode: Annotated[str, Sent(example="paper")]
    plant: Annotated[str, Sent("", "kinematic, or physics: rigid bodies", "kinematic")]
    body_way: Annotated[
        str, Sent("", "sway: bent into every support; straight: as the papers print it", "sway")
    ]
    # x, y, z, roll, pitch, yaw
    body: Annotated[
        tuple[float, float, float, float, float, float],
        Sent("", "x, y, z in m, roll, pitch, yaw in rad", [1.2, 0.0, 0.85, 0.0, 0.0, 0.0]),
    ]
    # foot tips
    feet: Annotated[tuple[Point, ...], Sent("", "foot tips, absolute, m", FEET_SHOWN)]
    contact: Annotated[tuple[bool, ...], Sent(example=THREE_OF_FOUR)]  # sole sensors
    support: Annotated[tuple[bool, ...], Sent(example=THREE_OF_FOUR)]  # legs meant to carry
    mode: Annotated[Mode, Sent(example="return")]
    reason: Annotated[str, Sent(example="")]  # why blocked, tipping or fallen; "" otherwise
    command: Annotated[Command, COMMANDED]
    speed: Annotated[float, Sent("walked_m_s", example=0.1)]  # m/s, in the mean of the running step
    # m/s, v_max of the running step; 0 when none runs
    speed_max: Annotated[float, Sent("speed_max_m_s", example=0.15)]
    margin: Annotated[float, Sent("margin_m", "longitudinal", 0.05, may_lack=True)]
    polygon_margin: Annotated[float, Sent("polygon_margin_m", example=0.04, may_lack=True)]
    energy_margin: Annotated[float, Sent("energy_margin_m", example=0.02, may_lack=True)]
    step: Annotated[int, Sent(example=12)]  # steps begun
    distance: Annotated[float, Sent("distance_m", example=1.2)]  # along the commanded course
    # the running step
    plan: Annotated[StepPlan | None, Sent("swing", "legs in the air, from 1", [4])]
    plan_time: Annotated[float, INSIDE]  # s into it
    ready: Annotated[StepPlan | None, INSIDE]  # the step after it, once planned
    terrain: Annotated[TerrainView, INSIDE]
    flags: Annotated[
        tuple[bool, bool, bool], Sent("", "F1, F2, F3 of H §9.3", [True, False, False])
    ]
    whiskers: Annotated[tuple[int, ...], INSIDE]
    paused: Annotated[bool, Sent(example=False)]
    rate: Annotated[float, Sent("", "times real time", 1.0)]
    late: Annotated[float, Sent("late_s", "worst of the last second", 0.0004)]
    attitude: Annotated[str, Sent("", ATTITUDE_MEANING, "level")] = "level"
    posture: Annotated[str, Sent("", POSTURE_MEANING, "stand")] = "stand"
    # s of the body on its trace, m
    course: Annotated[
        float, Sent("course_m", "s of the body on its trace (trace planner)", 0.0)
    ] = 0.0
    # why the running step is not that of the paper's rules; "" when it is, or none runs
    departure: Annotated[
        str,
        Sent(
            "",
            "why the step is not that of the paper's rules; empty when it is",
            "the paper's rules find no step here",
        ),
    ] = ""
    # from the trace given, of the body; NaN where none is
    off_trace: Annotated[
        float,
        Sent("off_trace_m", "of the body from the trace it was given", 0.004, may_lack=True),
    ] = math.nan
    # what the planner declares for its mode
    capabilities: Annotated[Capabilities, DECLARED] = Capabilities()
    # what the trace walker foresees; the same object until it foresees something else
    ahead: Annotated[GaitPreview | None, INSIDE] = None
    sway_slows: Annotated[
        bool, Sent("", "the body's sway gives the running step more time than its legs need", False)
    ] = False
    # of the feet that touch the ground and are meant to carry
    contact_margin: Annotated[
        float,
        Sent(
            "contact_margin_m", "polygon margin of the feet that really carry", 0.04, may_lack=True
        ),
    ] = math.nan
    blocked_by: Annotated[str, Sent("", "the reason as a word; empty when not blocked", "")] = ""
    given_trace: Annotated[
        bool, Sent("", "walks a given trace: of the stick only the speed counts", False)
    ] = False
    # the polygon margin less what a dead stop needs
    capture_margin: Annotated[
        float, Sent("capture_margin_m", "less what a dead stop needs", 0.03, may_lack=True)
    ] = math.nan
    # what each foot carries, () without sensors of it, and what it is meant to, () where legs do
    # not give
    loads: Annotated[tuple[float, ...], Sent("loads_n", "what each foot carries", LOADS)] = ()
    planned_loads: Annotated[
        tuple[float, ...], Sent("planned_loads_n", "what each foot is to carry", LOADS)
    ] = ()
    # three a leg
    joints: Annotated[
        tuple[Point, ...], Sent("", "of every leg, rad or m, as its kind has it", JOINTS)
    ] = ()
    # why the running step, or why there is none, where the console keeps it
    decision: Annotated[Mapping[str, Any] | None, INSIDE] = None
