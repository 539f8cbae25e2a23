"""What a planner, a plant and a height map must offer: the seams where another one can be put in.

A planner of one's own subclasses ``Planner``, implements ``plan`` and ``capabilities``, and enters
itself with ``registry.register_planner``. A plant or a height map need not subclass anything: they
fit when they have what is written here. Everything is SI: metres, radians, seconds, newtons.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, ParamSpec, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from .config import DEFAULT, PlannerConfig, Tolerances
from .geometry.paths import SampledPath
from .geometry.transforms import Body
from .robot.model import Machine
from .terrain.map import TerrainMap
from .types import Blocked, Command, Gait, GaitPreview, Point, Sensing, Stance, StepPlan

Answer = TypeVar("Answer")
Asked = ParamSpec("Asked")
GroundT = TypeVar("GroundT", contravariant=True)

# the weight of the work since a job last paused, in postures looked at; None for a usual slice
Weight = int | None
# Pauses after each slice of work; send(True): the best step found so far is wanted now.
SlicedJob = Generator[Weight, bool | None, Answer]
PlanningJob = SlicedJob[StepPlan | Blocked]


class Announced(int):
    """The weight of what a job does next. A tick that has no room for it leaves it to the next one;
    where the step is waited for it is done at once and counts for nothing.
    """


PlantState = Literal["standing", "tipping", "fallen"]
PlanFunction = Callable[[Stance, Command, TerrainMap], PlanningJob]
BodyAttitude = Literal["level", "ground"]  # of the body: level, or following the ground
ATTITUDES: tuple[BodyAttitude, ...] = ("level", "ground")


class PlannerError(ValueError):
    """A choice of planner, mode, trace or attitude that cannot be; the message is one clear
    line.
    """


@dataclass(frozen=True, slots=True)
class Capabilities:
    """What a planner in one mode can do; whoever shows or records it asks this, never its name."""

    leg_counts: tuple[int, ...] = ()  # of the machines it walks; () is any
    may_lean: bool = False  # lets the body follow the ground when asked
    fits_slopes: bool = False  # shortens strides on slopes, from the initial stance on
    takes_detours: bool = False  # goes round what cannot be crossed
    turns: bool = True  # walks commands with a turn rate
    follows_trace: bool = False  # walks along a trace given beforehand
    gives_preview: bool = False  # says what it foresees beyond the next step
    gives_decision: bool = False  # fills the decision log of its steps when asked
    # of the stride; a step that comes out no farther off counts as the standard one of this
    # planner, and on open ground it comes back to it (H fig. 9); None: it has no standard layout
    standard_within: float | None = None
    duty_factor_min: float = 0.5  # below it no gait of this planner stands
    # legs that stand at any time; None: as many as the gait's duty factor says
    standing_min: int | None = None
    rigid_gaits: tuple[str, ...] = ()  # periodic gaits it can be held to, by name

    def but(self, **changes: Any) -> Capabilities:
        """The same with some changed."""
        return replace(self, **changes)


@dataclass(frozen=True, slots=True)
class PlannerSetup:
    """All a planner is made from."""

    machine: Machine
    gait: Gait
    mode: str = ""  # one of those it declares; "" for a planner without modes
    attitude: str = "level"
    detours: bool = False  # whether it may leave the commanded course
    cautious: bool = (
        False  # slow down before unknown ground: the machine has an eye that will see it
    )
    path: SampledPath | None = None  # a given trace
    # this periodic gait and no other, for a planner that knows some: a name, or one of one's own
    # (``rows``, ``fractions``, or ``duty`` and ``phases``)
    rigid_gait: str | Mapping[str, Any] | None = None
    explain: bool = False  # fill the decision log
    config: PlannerConfig = DEFAULT


class Planner(Protocol):
    """Decides the next step: the whole of Level B, detours included.

    A planner of one's own subclasses it and writes ``plan_step``, a plain call, or ``plan``, a job
    that pauses; either makes the other. Its class is called with a ``PlannerSetup``. The rest are
    what a planner that walks level, takes the command as it comes and foresees nothing would say.

    >>> from walking_console import Blocked, Command, Planner, Stance, StepPlan, TerrainMap
    >>> class Stubborn(Planner):
    ...     def plan_step(self, stance, command, terrain):
    ...         return Blocked.saying("it does not want to")
    >>> feet = ((0.5, 0.4, 0.0), (-0.5, 0.4, 0.0), (-0.5, -0.4, 0.0), (0.5, -0.4, 0.0))
    >>> Stubborn().plan_step(Stance((0.0, 0.0, 0.7, 0.0), feet), Command(speed=0.1), None).text
    'it does not want to'
    """

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if cls.plan is Planner.plan and cls.plan_step is Planner.plan_step:
            raise TypeError(f"{cls.__name__} must define plan_step or plan")

    @property
    def capabilities(self) -> Capabilities:
        """What it can do, in the mode it was made for."""
        return Capabilities()

    def plan_step(
        self, stance: Stance, command: Command, terrain: TerrainMap
    ) -> StepPlan | Blocked:
        """The step from ``stance``, a step-switching point N_k, or ``Blocked``: all of ``plan`` at
        once.
        """
        return run_to_completion(self.plan(stance, command, terrain))

    def plan(self, stance: Stance, command: Command, terrain: TerrainMap) -> PlanningJob:
        """Begin to plan the step from ``stance``, a step-switching point N_k.

        The job pauses after each slice of work, yields what that weighed where it is known or, as
        ``Announced``, what the next one weighs, and returns a ``StepPlan``, or ``Blocked`` when
        there is no step. It never raises for ground it cannot cross, and the same three arguments
        after the same history give the same step, bit for bit.
        """
        return self.plan_step(stance, command, terrain)
        yield

    def heed(self, command: Command) -> Command:
        """Take note of the command of this tick, and answer with the one to walk by.

        Called once a tick before anything else; slower when ground ahead is unknown.
        """
        return command

    def preview(self, stance: Stance, running: StepPlan | None) -> GaitPreview | None:
        """What it foresees from ``stance``, the last N_k, where ``running`` begins; None:
        nothing.
        """
        return None

    def progress(self, stance: Stance, running: StepPlan | None, body: Body) -> float:
        """How far along its trace a body at x, y, z, yaw is, m; 0 for a planner without one."""
        return 0.0

    def off_standard(self, plan: StepPlan) -> float | None:
        """How far the foot farthest off stands from the standard layout after a step, as a share of
        the stride; None where there is none to compare with.
        """
        return None

    @property
    def attitude(self) -> BodyAttitude:
        """Whether the body is level or follows the ground."""
        return "level"

    def take_attitude(self, attitude: str) -> None:
        """Level or following the ground, from the next step planned on; raises ``PlannerError``."""
        if checked_attitude(attitude) != self.attitude:
            raise PlannerError(f"this planner keeps the body level, got {attitude!r}")


class Plant(Protocol[GroundT]):
    """The machine on its ground: foot velocities in, what it senses out, one tick of 20 ms at a
    time.

    Changed in place, by ``Simulation`` only. ``GroundT`` is what it is set down on.

    >>> from walking_console import Plant, Simulation, load_scenario
    >>> plant: Plant = Simulation(load_scenario("flat")).plant
    >>> plant.state, plant.soles, [round(v, 3) for v in plant.body]
    ('standing', [True, True, True, True], [0.0, 0.0, 0.85, 0.0, 0.0, 0.0])
    """

    @property
    def state(self) -> PlantState: ...

    @property
    def body(self) -> Sequence[float]:
        """x, y, z, roll, pitch, yaw of the true body, m and rad."""
        ...

    @property
    def feet(self) -> Sequence[Sequence[float]]:
        """True foot tips in leg order, absolute, m: (n_legs, 3)."""
        ...

    @property
    def soles(self) -> Sequence[bool]:
        """Per leg, True where the sole is on."""
        ...

    @property
    def whiskers(self) -> Sequence[int]:
        """Per leg, one bit per direction of eight in which something is felt."""
        ...

    @property
    def loads(self) -> Sequence[float]:
        """Per leg, what the foot carries, N; () without sensors of load."""
        ...

    @property
    def joints(self) -> Sequence[Point]:
        """Per leg, its three joint coordinates, rad or m."""
        ...

    @property
    def tolerances(self) -> Tolerances:
        """How exactly it does what it is told: what the supervisor must not take for a surprise."""
        ...

    def sense(self) -> Sensing:
        """Position monitors, soles, whiskers and posture at this tick."""
        ...

    def move(self, velocities: Sequence[Point], loads: Sequence[float] | None = None) -> None:
        """One tick: every foot is driven at its velocity in body axes, m/s, in leg order, and
        presses with its planned load, N, where there is one.
        """
        ...

    def push(self, fx: float, fy: float, ticks: int) -> None:
        """Push the body with (fx, fy) newtons in the ground plane for so many ticks."""
        ...

    def replace_ground(self, ground: GroundT) -> None:
        """Put other ground under the machine, which stays where it is."""
        ...


class HeightMap(Protocol):
    """Heights on a grid of square cells: the true ground as well as what is believed of it."""

    @property
    def heights(self) -> NDArray[np.float64]:
        """(rows, columns), m; row 0 is at the least y, column 0 at the least x; NaN is a hole."""
        ...

    @property
    def cell(self) -> float:
        """Side of a cell, m."""
        ...

    @property
    def origin(self) -> tuple[float, float]:
        """Absolute x, y of the outer corner of cell (0, 0), m."""
        ...

    def height_at(self, x: float, y: float) -> float:
        """Height of the ground at a place, m; NaN over a hole and beyond the map."""
        ...

    def cell_at(self, x: float, y: float) -> tuple[int, int] | None:
        """Row and column of a place, None beyond the map."""
        ...


def checked_attitude(attitude: str) -> BodyAttitude:
    """The attitude of this name; raises ``PlannerError`` that lists those there are."""
    for known in ATTITUDES:
        if attitude == known:
            return known
    raise PlannerError(f"unknown attitude {attitude!r:.80}; there are: {', '.join(ATTITUDES)}")


def run_to_completion(job: Generator[Any, Any, Answer]) -> Answer:
    """What a job comes to when it is run without a pause."""
    while True:
        try:
            next(job)
        except StopIteration as done:
            answer: Answer = done.value
            return answer


def without_pause(
    answer: Callable[Asked, Answer],
) -> Callable[Asked, Generator[None, Any, Answer]]:
    """What answers at once, as a job that could have paused."""

    def job(*args: Asked.args, **kwargs: Asked.kwargs) -> Generator[None, Any, Answer]:
        return answer(*args, **kwargs)
        yield

    return job
