"""``Scenario``: a named world and a script as data.

A scenario is a TOML file (``scenario_files.py`` reads them). Its shape is the models here and in
``scenario_tables.py``: strict numbers (a boolean is no number, an integer serves as a float, nan
and infinities are refused), no unknown keys. Every refusal is a ``ScenarioError`` of one clear
line.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, PrivateAttr, model_validator
from pydantic_core import PydanticCustomError

from walking_console.planner import registry
from walking_console.planner.config import PlannerConfig, configured
from walking_console.planner.geometry.paths import Box
from walking_console.planner.geometry.transforms import Pose, direction, placed
from walking_console.planner.registry import DEFAULT_MODE, DEFAULT_PLANNER
from walking_console.planner.robot.model import (
    Machine,
    MachineError,
    as_data,
    load_machine,
    machine_from,
)
from walking_console.planner.types import Gait

from .plants import DEFAULT_PLANT, PLANTS
from .range_sensor import EyeSettings
from .scenario_tables import (
    DRIVES_MAX,
    Drive,
    End,
    Expect,
    GaitChange,
    Noise,
    PhysicsChange,
    StartPlace,
)
from .tables import Registered, Table
from .terrain.generators import SEED_MAX, AnyTerrain, Flat
from .trace_tables import Trace

ROBOT_NAME_MAX = 500  # letters
TIME_LIMIT = 600.0  # s, when [end] names no time

PlannerName = Annotated[str, Registered(registry.planner_names)]
ModeName = Annotated[str, Registered(registry.mode_names)]
PlantName = Annotated[str, Registered(PLANTS.keys)]


class ScenarioError(ValueError):
    """A scenario that cannot be used; the message is one clear line, ``faults`` holds every one of
    them where there are more than the line shows.
    """

    def __init__(self, message: str, faults: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.faults = tuple(faults) or (message,)


def _robot(value: Any) -> str | dict[str, Any]:
    """A robot's name, the path of its file, or what such a file holds; every fault of the last is
    said.
    """
    if isinstance(value, str) and 1 <= len(value) <= ROBOT_NAME_MAX:
        return value
    if not isinstance(value, Mapping):
        expected = f"a robot's name of 1 to {ROBOT_NAME_MAX} letters, or a table as in a robot file"
        raise PydanticCustomError(
            "robot_type", "Input should be {expected}", {"expected": expected}
        )
    try:
        return as_data(machine_from(value))
    except MachineError as error:
        said = {"faults": list(error.faults), "message": str(error)}
        raise PydanticCustomError("robot_table", "{message}", said) from None


Robot = Annotated[str | dict[str, Any], PlainValidator(_robot)]


class Scenario(Table):
    """One world and what is to happen in it."""

    name: str = Field(default="", max_length=200)  # the file's, when not given
    title: str = Field(default="", max_length=500)
    robot: Robot = "titan3"  # a name, a path, or the robot itself as a table
    planner: PlannerName = DEFAULT_PLANNER
    # that of its planner, when not given; naive: only to show what H fig. 6(c) shows
    mode: ModeName = DEFAULT_MODE
    plant: PlantName = DEFAULT_PLANT  # what the machine is simulated by
    # of the body: level, or leaning with the ground as far as strides allow
    attitude: Literal["level", "ground"] = "level"
    sensing: Literal["known", "eye", "none"] = "known"
    unknown: Literal["flat", "forbidden"] = "flat"
    # Level B1 goes round what cannot be crossed; false: the commanded course and no other
    detours: bool = True
    eye: EyeSettings | None = None
    seed: int = Field(default=1, ge=0, le=SEED_MAX)
    gait: GaitChange = GaitChange()
    config: dict[str, Any] = {}  # tunables of planner/config.py, by theme
    terrain: AnyTerrain = Flat(kind="flat")
    start: StartPlace = StartPlace()
    drive: list[Drive] = Field(default=[], max_length=DRIVES_MAX)
    trace: Trace | None = None
    end: End = End()
    expect: Expect = Expect()
    noise: Noise | None = None
    physics: PhysicsChange | None = None  # of the physics plant; others do without
    _base: Path | None = PrivateAttr(None)

    @model_validator(mode="before")
    @classmethod
    def _in_the_default_mode(cls, data: Any) -> Any:
        if not isinstance(data, Mapping) or "mode" in data:
            return data
        planner = data.get("planner", DEFAULT_PLANNER)
        if planner not in registry.planner_names():
            return data
        return {**data, "mode": registry.planner_entry(planner).default_mode or DEFAULT_MODE}

    @model_validator(mode="after")
    def _is_one_story(self) -> Scenario:
        for index, (one, two) in enumerate(pairwise(self.drive)):
            if not one.t < two.t:
                raise ValueError(
                    f"drive.{index + 1}.t must be later than drive.{index}.t = {one.t:g}, "
                    f"got {two.t:g}"
                )
        if self.trace is not None and self.drive:
            raise ValueError("give either [[drive]] or [trace], not both")
        return self

    @model_validator(mode="after")
    def _is_for_its_planner(self) -> Scenario:
        configured(self.config)  # raises for what there is not
        declared = registry.capabilities(self.planner, self.mode)
        if self.trace is not None and not declared.follows_trace:
            able = _keys_of(registry.choices_that(lambda planner: planner.follows_trace))
            raise ValueError(f"[trace] needs {able}; the {self.planner} planner takes [[drive]]")
        if self.attitude != "level" and not declared.may_lean:
            able = _keys_of(registry.choices_that(lambda planner: planner.may_lean))
            raise ValueError(f'attitude = "{self.attitude}" needs {able}')
        if (self.gait.duty_factor or 1.0) < declared.duty_factor_min:
            raise ValueError(
                f"gait.duty_factor of the {self.planner} gait must be at least "
                f"{declared.duty_factor_min:g}, got {self.gait.duty_factor:g}"
            )
        return self

    def machine(self) -> Machine:
        """The machine it names or holds. Raises ``MachineError``."""
        if isinstance(self.robot, str):
            return load_machine(self.robot, self.base)
        return machine_from(self.robot)

    @property
    def base(self) -> Path | None:
        """The folder relative paths start from; None when the scenario came without a file and may
        not name any.
        """
        return self._base

    @property
    def time_limit(self) -> float:
        """Simulated seconds after which the run ends in any case."""
        return TIME_LIMIT if self.end.time is None else self.end.time

    @property
    def planner_config(self) -> PlannerConfig:
        """The tunables, with this scenario's changes."""
        config = configured(self.config)
        if self.trace is None:
            return config
        search = config.trace
        sway = search.sway if self.trace.sway is None else self.trace.sway
        detour = search.detour if self.trace.detour is None else self.trace.detour
        return replace(config, trace=replace(search, sway=sway, detour=detour))

    @property
    def start_pose(self) -> Pose:
        """x, y, yaw in metres and radians."""
        return self.start.x, self.start.y, math.radians(self.start.yaw_deg)

    def gait_for(self, machine: Machine) -> Gait:
        """The machine's gait with this scenario's overrides. Raises ``ScenarioError``."""
        change = self.gait
        gait = Gait(
            machine.duty_factor if change.duty_factor is None else change.duty_factor,
            machine.lift_up if change.lift_up is None else change.lift_up,
            machine.lift_down if change.lift_down is None else change.lift_down,
            machine.height if change.height is None else change.height,
            change.smooth,
            sways=change.body == "sway",
            margin=change.margin,
            acceleration=change.acceleration or 0.0,
        )
        low, high = machine.z_range
        if not low <= -gait.height <= high:
            raise ScenarioError(
                f"gait.height must be within the legs' reach [{-high:g}, {-low:g}] m, "
                f"got {gait.height:g}"
            )
        if gait.lift_down < gait.lift_up:
            raise ScenarioError(
                f"gait.lift_down must be at least lift_up = {gait.lift_up:g} m, "
                f"got {gait.lift_down:g}"
            )
        return gait

    def span(self, machine: Machine | None = None) -> Box:
        """A box no course of this scenario leaves, however slowly it is walked: x_min, x_max,
        y_min, y_max, absolute, m.

        With a machine, commands are taken no faster than it can walk: the map need not be larger.
        """
        pose = self.start_pose
        if self.trace is not None:
            return _around([placed(pose, x, y) for x, y in self.trace.path.outline()])
        fastest = self._fastest(machine) if machine else math.inf
        distance = self.end.distance or math.inf
        return _driven(self.drive, pose, self.time_limit, distance, fastest)

    def _fastest(self, machine: Machine) -> float:
        """m/s no gait of this machine exceeds: a leg must return in (1-β)T what the body walked in
        βT, three stand at any time.
        """
        standing = registry.capabilities(self.planner, self.mode).standing_min
        duty = self.gait_for(machine).duty_factor
        if standing is not None:
            duty = standing / len(machine.legs)
        return max(machine.speed[:2]) * (1.0 - duty) / duty

    def as_data(self) -> dict[str, Any]:
        """Plain data, every default written out: ``scenario_from`` makes an equal one of it."""
        return self.model_dump(exclude_none=True)


def _keys_of(choices: Iterable[tuple[str, str]]) -> str:
    """What to write in a scenario to have one of these planners in one of these modes."""
    return " or ".join(
        f'planner = "{planner}"' + (f' and mode = "{mode}"' if mode else "")
        for planner, mode in choices
    )


def _around(points: Sequence[tuple[float, float]]) -> Box:
    xs = [x for x, _ in points]
    ys = [y for _, y in points]
    return min(xs), max(xs), min(ys), max(ys)


def _driven(
    drive: Sequence[Drive], pose: Pose, time: float, distance: float, fastest: float
) -> Box:
    """Bounds of a timeline: every entry may be walked in full or not at all, so forward and back do
    not cancel.

    Once the body has turned its heading is anybody's guess, and an entry may lead anywhere.
    """
    x, y, yaw = pose
    ends = [entry.t for entry in drive[1:]] + [time]
    back = [0.0, 0.0]
    forth = [0.0, 0.0]
    turned = False
    for entry, end in zip(drive, ends, strict=False):
        length = min(max(0.0, min(end, time) - entry.t) * min(entry.speed, fastest), distance)
        if entry.turn_rate_deg_s != 0.0:
            turned = True
            length = min(length, 2 * entry.speed / math.radians(abs(entry.turn_rate_deg_s)))
        for axis, part in enumerate(direction(yaw + math.radians(entry.crab_angle_deg))):
            back[axis] += length if turned else max(0.0, -part * length)
            forth[axis] += length if turned else max(0.0, part * length)
    back = [min(way, distance) for way in back]
    forth = [min(way, distance) for way in forth]
    return x - back[0], x + forth[0], y - back[1], y + forth[1]
