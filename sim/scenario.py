"""Scenarios: named worlds and scripts as data, and the ``--set`` that changes them.

A scenario is a TOML file. Its shape is the models below: strict numbers (a boolean is no number, an
integer serves as a float, nan and infinities are refused), no unknown keys. Every refusal is a
``ScenarioError`` of one clear line.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import resources
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, ValidationError, model_validator
from pydantic_core import PydanticCustomError, core_schema

from walking_console.planner import registry
from walking_console.planner.registry import DEFAULT_MODE, DEFAULT_PLANNER
from walking_console.planner.robot.card import shown
from walking_console.planner.robot.model import Machine, is_file
from walking_console.planner.types import Command
from walking_console.planner.types import Gait as MachineGait

from .plants import DEFAULT_PLANT, PLANTS
from .range_sensor import EyeSettings
from .terrain.generators import (
    KINDS,
    SEED_MAX,
    AnyTerrain,
    Box,
    Degrees,
    FileTerrain,
    Flat,
    Place,
    list_terrains,
)

__all__ = [
    "Scenario", "ScenarioError", "list_scenarios", "list_terrains", "load_scenario", "scenario_from", "scenario_names", "with_settings",
]  # fmt: skip

TIME_LIMIT = 600.0  # s, when [end] names no time
DURATION_MAX = 3600.0  # s
FILE_BYTES_MAX = 1_000_000
FAULTS_SHOWN = 4
TABLES_BY_KIND = ("terrain", "trace")  # their keys depend on their `kind`
FIXED_SETTINGS = ("drive", "trace")  # either replaces the other


class ScenarioError(ValueError):
    """A scenario that cannot be used; the message is one clear line."""


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class _Registered:
    """A string that is one of the names there are when it is read; more may be registered later."""

    def __init__(self, names: Callable[[], Iterable[str]]) -> None:
        self._names = names

    def _check(self, value: Any) -> str:
        known = sorted(self._names())
        if isinstance(value, str) and value in known:
            return value
        quoted = [repr(name) for name in known]
        expected = " or ".join([", ".join(quoted[:-1]), quoted[-1]] if quoted[1:] else quoted)
        raise PydanticCustomError(
            "literal_error", "Input should be {expected}", {"expected": expected}
        )

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self._check)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        return {"type": "string", "enum": sorted(self._names())}


PlannerName = Annotated[str, _Registered(registry.planner_names)]
ModeName = Annotated[str, _Registered(registry.mode_names)]
PlantName = Annotated[str, _Registered(PLANTS.keys)]
RigidGaitName = Annotated[str, _Registered(registry.rigid_gait_names)]


class GaitChange(_Table):
    """Overrides of the machine's gait defaults."""

    duty_factor: float | None = Field(default=None, ge=0.5, le=0.95)
    lift_up: float | None = Field(default=None, gt=0.0, le=1.0)  # m, h_up
    lift_down: float | None = Field(default=None, gt=0.0, le=2.0)  # m, h_dwn
    height: float | None = Field(default=None, gt=0.0, le=5.0)  # m, H
    smooth: bool = True  # eased swing phases; false: constant velocity between knots
    # trace planner: this gait and no other
    rigid: RigidGaitName | None = None


class Start(_Table):
    """Where the body stands at first."""

    x: Place = 0.0  # m
    y: Place = 0.0  # m
    yaw_deg: Degrees = 0.0
    feet: list[Annotated[list[Place], Field(min_length=2, max_length=2)]] | None = Field(
        default=None, min_length=4, max_length=8
    )  # m, x and y in body axes in leg order; the standard posture when not given


class Drive(_Table):
    """One entry of the timeline; it holds until the next."""

    t: float = Field(default=0.0, ge=0.0, le=DURATION_MAX)  # s
    crab_angle_deg: Degrees = 0.0
    speed: float = Field(default=0.0, ge=0.0, le=10.0)  # m/s
    turn_rate_deg_s: float = Field(default=0.0, ge=-360.0, le=360.0)
    # taken from a standstill; standard: that of the last course
    posture: Literal["sit", "stand", "standard"] | None = None

    @model_validator(mode="after")
    def _poses_at_rest(self) -> Drive:
        if self.posture is not None and (self.speed or self.turn_rate_deg_s):
            raise ValueError(
                f'posture = "{self.posture}" needs speed = 0 and turn_rate_deg_s = 0: the machine takes it from a standstill'
            )
        return self

    def command(self) -> Command:
        """The same in radians."""
        return Command(
            math.radians(self.crab_angle_deg), self.speed, math.radians(self.turn_rate_deg_s)
        )


class _Trace(_Table):
    """What ``planner/trace/curve.py`` draws; begins at the start pose, positive angles are to the
    left.
    """

    yaw: Literal["tangent", "fixed"] = "tangent"
    speed: float = Field(default=0.1, gt=0.0, le=10.0)  # m/s along the trace

    def outline(self) -> list[tuple[float, float]]:
        """Points, in axes of the start pose, whose hull the trace does not leave."""
        return [(0.0, 0.0)]


class Waypoints(_Trace):
    """A smooth curve through given poses."""

    kind: Literal["waypoints"]
    # x m, y m, yaw deg
    waypoints: list[Annotated[list[Place], Field(min_length=2, max_length=3)]] = Field(
        min_length=2, max_length=1000
    )

    def outline(self) -> list[tuple[float, float]]:
        xs, ys = (
            [0.0, *(point[0] for point in self.waypoints)],
            [0.0, *(point[1] for point in self.waypoints)],
        )
        # a spline swings out beyond its points
        swing = max(max(xs) - min(xs), max(ys) - min(ys)) / 4
        return [
            (x, y)
            for x in (min(xs) - swing, max(xs) + swing)
            for y in (min(ys) - swing, max(ys) + swing)
        ]


class Line(_Trace):
    """Straight on, or in another direction without turning."""

    kind: Literal["line"]
    yaw: Literal["tangent", "fixed"] = "fixed"
    length: float = Field(default=5.0, ge=0.1, le=1000.0)  # m
    direction_deg: float = Field(default=0.0, ge=-180.0, le=180.0)

    def outline(self) -> list[tuple[float, float]]:
        direction = 0.0 if self.yaw == "tangent" else math.radians(self.direction_deg)
        return [(0.0, 0.0), (self.length * math.cos(direction), self.length * math.sin(direction))]


class Sideways(Line):
    """Straight to one side."""

    kind: Literal["sideways"]  # type: ignore[assignment]
    length: float = Field(default=3.0, ge=0.1, le=1000.0)  # m
    direction_deg: float = Field(default=90.0, ge=-180.0, le=180.0)


class Circle(_Trace):
    """Round a circle."""

    kind: Literal["circle"]
    radius: float = Field(default=1.5, ge=0.05, le=100.0)  # m
    angle_deg: float = Field(default=360.0, ge=-3600.0, le=3600.0)

    def outline(self) -> list[tuple[float, float]]:
        return _square(2 * self.radius)


class Sine(_Trace):
    """y = amplitude * sin(x / length)."""

    kind: Literal["sine"]
    yaw: Literal["tangent", "fixed"] = "fixed"
    amplitude: float = Field(default=0.6, ge=-100.0, le=100.0)  # m
    length: float = Field(default=1.0, ge=0.1, le=100.0)  # m
    distance: float = Field(default=8.0, ge=0.1, le=1000.0)  # m along x

    def outline(self) -> list[tuple[float, float]]:
        # then it begins straight ahead
        turn = math.atan(self.amplitude / self.length) if self.yaw == "tangent" else 0.0
        c, s = math.cos(turn), math.sin(turn)
        corners = [(x, y) for x in (0.0, self.distance) for y in (-self.amplitude, self.amplitude)]
        return [(c * x + s * y, c * y - s * x) for x, y in corners]


class Spiral(_Trace):
    """A curve whose radius goes evenly from one value to another."""

    kind: Literal["spiral"]
    radius: float = Field(default=2.0, ge=0.05, le=100.0)  # m, at the start
    radius_end: float = Field(default=0.8, ge=0.05, le=100.0)  # m
    angle_deg: float = Field(default=540.0, ge=-3600.0, le=3600.0)

    def outline(self) -> list[tuple[float, float]]:
        # it stays inside its widest circle of curvature
        return _square(2 * max(self.radius, self.radius_end))


class Turn(_Trace):
    """On the spot."""

    kind: Literal["turn"]
    angle_deg: float = Field(default=360.0, ge=-3600.0, le=3600.0)


Trace = Annotated[
    Waypoints | Line | Sideways | Circle | Sine | Spiral | Turn, Field(discriminator="kind")
]
TRACES: dict[str, type[_Trace]] = {
    "waypoints": Waypoints,
    "line": Line,
    "sideways": Sideways,
    "circle": Circle,
    "sine": Sine,
    "spiral": Spiral,
    "turn": Turn,
}


class End(_Table):
    """Whichever limit is reached first ends the run."""

    time: float | None = Field(default=None, gt=0.0, le=DURATION_MAX)  # s
    distance: float | None = Field(default=None, gt=0.0, le=1000.0)  # m along the course


class Expect(_Table):
    """Each key given becomes pass or fail in the result."""

    distance_min: float | None = None  # m
    margin_min: float | None = None  # m
    forbidden_steps_max: int | None = Field(default=None, ge=0)
    emergent_max: int | None = Field(default=None, ge=0)
    emergent_min: int | None = Field(default=None, ge=0)
    falls_max: int | None = Field(default=None, ge=0)
    time_max: float | None = None  # s
    mean_speed_min: float | None = None  # m/s
    off_line_max: float | None = None  # m, from the commanded line to the CoG at the end
    # steps at the end that each came out in the standard layout
    standard_steps_min: int | None = Field(default=None, ge=0)
    # commanded courses left, or ended, short of the standard layout
    courses_unsettled_max: int | None = Field(default=None, ge=0)
    # of the body's path, against the average-height rule on the same footholds
    roughness_ratio_max: float | None = None


class Noise(_Table):
    """Standard deviations of the sensors."""

    position: float = Field(default=0.0, ge=0.0, le=0.1)  # m, position monitors of the feet
    posture_deg: float = Field(default=0.0, ge=0.0, le=10.0)  # pitch and roll

    @property
    def posture(self) -> float:
        """The same in radians."""
        return math.radians(self.posture_deg)


class Scenario(_Table):
    """One world and what is to happen in it."""

    name: str = Field(default="", max_length=200)  # the file's, when not given
    title: str = Field(default="", max_length=500)
    robot: str = Field(default="titan3", min_length=1, max_length=500)
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
    terrain: AnyTerrain = Flat(kind="flat")
    start: Start = Start()
    drive: list[Drive] = Field(default=[], max_length=10_000)
    trace: Trace | None = None
    end: End = End()
    expect: Expect = Expect()
    noise: Noise | None = None
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
        declared = registry.capabilities(self.planner, self.mode)
        for index, (one, two) in enumerate(pairwise(self.drive)):
            if not one.t < two.t:
                raise ValueError(
                    f"drive.{index + 1}.t must be later than drive.{index}.t = {one.t:g}, got {two.t:g}"
                )
        if self.trace is not None and self.drive:
            raise ValueError("give either [[drive]] or [trace], not both")
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
    def start_pose(self) -> tuple[float, float, float]:
        """x, y, yaw in metres and radians."""
        return self.start.x, self.start.y, math.radians(self.start.yaw_deg)

    def gait_for(self, machine: Machine) -> MachineGait:
        """The machine's gait with this scenario's overrides. Raises ``ScenarioError``."""
        change = self.gait
        gait = MachineGait(
            machine.duty_factor if change.duty_factor is None else change.duty_factor,
            machine.lift_up if change.lift_up is None else change.lift_up,
            machine.lift_down if change.lift_down is None else change.lift_down,
            machine.height if change.height is None else change.height,
            change.smooth,
        )
        low, high = machine.z_range
        if not low <= -gait.height <= high:
            raise ScenarioError(
                f"gait.height must be within the legs' reach [{-high:g}, {-low:g}] m, got {gait.height:g}"
            )
        if gait.lift_down < gait.lift_up:
            raise ScenarioError(
                f"gait.lift_down must be at least lift_up = {gait.lift_up:g} m, got {gait.lift_down:g}"
            )
        return gait

    def span(self, machine: Machine | None = None) -> Box:
        """A box no course of this scenario leaves, however slowly it is walked: x_min, x_max,
        y_min, y_max.

        With a machine, commands are taken no faster than it can walk: the map need not be larger.
        """
        x, y, yaw = self.start_pose
        if self.trace is not None:
            c, d = math.cos(yaw), math.sin(yaw)
            points = [(x + c * px - d * py, y + d * px + c * py) for px, py in self.trace.outline()]
            return (
                min(p[0] for p in points),
                max(p[0] for p in points),
                min(p[1] for p in points),
                max(p[1] for p in points),
            )
        fastest = self._fastest(machine) if machine else math.inf
        return _driven(
            self.drive, x, y, yaw, self.time_limit, self.end.distance or math.inf, fastest
        )

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
        """Plain data, every default written out; ``scenario_from`` makes an equal scenario of it."""
        return self.model_dump(exclude_none=True)


def _keys_of(choices: Iterable[tuple[str, str]]) -> str:
    """What to write in a scenario to have one of these planners in one of these modes."""
    return " or ".join(
        f'planner = "{planner}"' + (f' and mode = "{mode}"' if mode else "")
        for planner, mode in choices
    )


def _square(reach: float) -> list[tuple[float, float]]:
    return [(x, y) for x in (-reach, reach) for y in (-reach, reach)]


def _driven(
    drive: Sequence[Drive],
    x: float,
    y: float,
    yaw: float,
    time: float,
    distance: float,
    fastest: float,
) -> Box:
    """Bounds of a timeline: every entry may be walked in full or not at all, so forward and back do
    not cancel.

    Once the body has turned its heading is anybody's guess, and an entry may lead anywhere.
    """
    ends = [entry.t for entry in drive[1:]] + [time]
    low, high, turned = [0.0, 0.0], [0.0, 0.0], False
    for entry, end in zip(drive, ends, strict=False):
        length = min(max(0.0, min(end, time) - entry.t) * min(entry.speed, fastest), distance)
        turned = turned or entry.turn_rate_deg_s != 0.0
        if entry.turn_rate_deg_s != 0.0:
            length = min(length, 2 * entry.speed / math.radians(abs(entry.turn_rate_deg_s)))
        heading = yaw + math.radians(entry.crab_angle_deg)
        for axis, part in enumerate((math.cos(heading) * length, math.sin(heading) * length)):
            low[axis] += length if turned else max(0.0, -part)
            high[axis] += length if turned else max(0.0, part)
    low, high = [min(v, distance) for v in low], [min(v, distance) for v in high]
    return x - low[0], x + high[0], y - low[1], y + high[1]


def scenario_names() -> tuple[str, ...]:
    """Names of the shipped scenarios, sorted."""
    folder = resources.files("walking_console.sim") / "scenarios"
    return tuple(
        sorted(
            entry.name.removesuffix(".toml")
            for entry in folder.iterdir()
            if entry.name.endswith(".toml")
        )
    )


def list_scenarios() -> tuple[tuple[str, str], ...]:
    """Every shipped scenario with its title."""
    return tuple(
        (name, str(_parse(_shipped(name), name).get("title", ""))) for name in scenario_names()
    )


def load_scenario(
    name_or_path: str, settings: Sequence[str] = (), seed: int | None = None
) -> Scenario:
    """A shipped scenario by name or a scenario file by path, changed by ``--set`` settings.

    A setting is ``KEY=VALUE`` with a dotted key and a TOML value. Raises ``ScenarioError``, a
    ``ValueError`` of one clear line, for a name, key or value there is not.

    >>> from walking_console import load_scenario
    >>> scenario = load_scenario("river", ["terrain.width=0.4", "end={time=30.0}"], seed=7)
    >>> scenario.terrain.width, scenario.end.time, scenario.seed, scenario.robot
    (0.4, 30.0, 7, 'titan3')
    """
    if name_or_path in scenario_names():
        text, base, name = _shipped(name_or_path), Path(), name_or_path
    else:
        path = Path(name_or_path)
        text, base, name = _read(path, name_or_path), path.parent, path.stem
    data = with_settings(_parse(text, name_or_path), settings)
    if seed is not None:
        data["seed"] = seed
    return scenario_from({"name": name, **data}, base)


def scenario_from(data: Mapping[str, Any], base: Path | None = None) -> Scenario:
    """Build and check a scenario from plain data. Without ``base`` it may not name files. Raises
    ``ScenarioError``.
    """
    _check_integers(data)
    plain = dict(data)
    terrain = plain.get("terrain")
    if isinstance(terrain, Mapping) and "file" in terrain and "kind" not in terrain:
        plain["terrain"] = {"kind": "file", **terrain}
    try:
        scenario = Scenario.model_validate(plain)
    except ValidationError as error:
        raise ScenarioError(_faults(error)) from None
    return _with_files(scenario, base)


def _check_integers(data: Any) -> None:
    """Refuse integers that TOML has no room for: those of thousands of digits can neither be
    checked nor said.
    """
    waiting: list[tuple[str, Any]] = [("", data)]
    while waiting:
        where, value = waiting.pop()
        if isinstance(value, int) and not -(2**63) <= value < 2**63:
            said = " ".join(where.split())  # a key may hold line ends
            raise ScenarioError(f"{said:.200} must be an integer of at most 64 bits")
        if isinstance(value, Mapping | list):
            entries = value.items() if isinstance(value, Mapping) else enumerate(value)
            waiting += [(f"{where}.{key}" if where else str(key), item) for key, item in entries]


def _with_files(scenario: Scenario, base: Path | None) -> Scenario:
    """Paths made absolute, so that a dump is complete."""
    named = isinstance(scenario.terrain, FileTerrain) or scenario.robot.endswith(".toml")
    if base is None and named:
        raise ScenarioError(
            "a scenario that is not a file itself cannot name files (terrain.file, robot)"
        )
    if base is not None and named:
        change: dict[str, Any] = {}
        if isinstance(scenario.terrain, FileTerrain):
            change["terrain"] = scenario.terrain.model_copy(
                update={"file": str((base / scenario.terrain.file).absolute())}
            )
        if scenario.robot.endswith(".toml"):
            change["robot"] = str((base / scenario.robot).absolute())
        scenario = scenario.model_copy(update=change)
    scenario._base = base
    return scenario


def _shipped(name: str) -> str:
    return (resources.files("walking_console.sim") / "scenarios" / f"{name}.toml").read_text(
        "utf-8"
    )


def _read(path: Path, given: str) -> str:
    if not given.endswith(".toml") or not is_file(path):
        raise ScenarioError(
            f"unknown scenario {given!r:.200}; there are: {', '.join(scenario_names())}, or a path to a scenario TOML file"
        )
    try:
        if path.stat().st_size > FILE_BYTES_MAX:
            raise ScenarioError(f"scenario file {given!r} is larger than {FILE_BYTES_MAX} bytes")
        return path.read_text("utf-8")
    except (OSError, ValueError) as error:
        raise ScenarioError(f"cannot read scenario file {given!r}: {error}") from None


def _parse(text: str, name: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    # TOMLDecodeError, and integers of thousands of digits
    except (ValueError, RecursionError) as error:
        raise ScenarioError(f"scenario {name!r} is not valid TOML: {error}") from None


def with_settings(data: Mapping[str, Any], settings: Iterable[str]) -> dict[str, Any]:
    """``data`` changed by KEY=VALUE settings from left to right, as the contract has them. Raises
    ``ScenarioError``.
    """
    changed: dict[str, Any] = _copy(dict(data))
    for setting in settings:
        key, equals, value = setting.partition("=")
        parts = [part.strip() for part in key.split(".")]
        if not equals or not all(parts):
            raise ScenarioError(f"--set wants KEY=VALUE with a dotted KEY, got {setting!r:.200}")
        _put(changed, parts, _value(value.strip()), setting)
    return changed


def _put(table: dict[str, Any], parts: list[str], value: Any, setting: str) -> None:
    """Put ``value`` where the path leads; missing tables on the way are made, missing array
    elements are not.
    """
    place: Any = table
    for depth, part in enumerate(parts):
        last = depth == len(parts) - 1
        if isinstance(place, list):
            key: Any = _position(place, part, ".".join(parts[:depth]))
        elif isinstance(place, dict):
            key = part
            if not last:
                place.setdefault(key, {})
        else:
            raise ScenarioError(
                f"--set {setting:.200}: {'.'.join(parts[:depth])!r} is neither a table nor an array"
            )
        if last:
            place[key] = value
        else:
            place = place[key]
    if len(parts) == 1 and parts[0] in FIXED_SETTINGS:
        table.pop(next(other for other in FIXED_SETTINGS if other != parts[0]), None)


def _position(array: list[Any], part: str, where: str) -> int:
    if not (part.isascii() and part.isdigit() and len(part) <= 9) or int(part) >= len(array):
        raise ScenarioError(
            f"{where} is an array of {len(array)}; index it with 0 to {len(array) - 1}, not {part!r:.40}"
        )
    return int(part)


def _value(text: str) -> Any:
    """A TOML value, or the text itself when it is none."""
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    value = parsed["value"]
    return (
        value
        if len(parsed) == 1 and isinstance(value, str | bool | int | float | list | dict)
        else text
    )


def _copy(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _copy(item) for key, item in value.items()}
    return [_copy(item) for item in value] if isinstance(value, list) else value


def _faults(error: ValidationError) -> str:
    """pydantic's findings as one line, the first few of them."""
    faults = error.errors(include_url=False)
    lines = [
        _fault(fault["type"], fault["loc"], fault["msg"], fault.get("input"), fault.get("ctx", {}))
        for fault in faults
    ]
    more = f"; and {len(lines) - FAULTS_SHOWN} more" if len(lines) > FAULTS_SHOWN else ""
    return "; ".join(lines[:FAULTS_SHOWN]) + more


def _fault(
    kind: str, loc: tuple[int | str, ...], message: str, value: Any, context: Mapping[str, Any]
) -> str:
    path = [
        str(part) for index, part in enumerate(loc) if not (index == 1 and loc[0] in TABLES_BY_KIND)
    ]
    where = ".".join(path)
    if kind == "extra_forbidden":
        inside = ".".join(path[:-1])
        return f"unknown key {path[-1]!r:.80}{f' in {inside}' if inside else ''}; there are: {', '.join(_keys(loc[:-1]))}"
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        known = ", ".join(KINDS if loc[0] == "terrain" else TRACES)
        given = value.get("kind") if isinstance(value, dict) else None
        return f"{f'unknown {where} kind {shown(given)}' if given is not None else f'{where} needs a kind'}; there are: {known}"
    if kind == "value_error":
        return f"{f'{where}: ' if where else ''}{context['error']}"
    if kind == "missing":
        return f"{where} is missing"
    wanted = message.removeprefix("Input should be ").replace("a valid ", "a ")
    return (
        f"{where} should be {wanted}, got {shown(value)}"
        if wanted != message
        else f"{where}: {message}, got {shown(value)}"
    )


def _keys(loc: Sequence[int | str]) -> Iterable[str]:
    """Known keys of the table at a place in the scenario."""
    if not loc:
        return Scenario.model_fields
    if loc[0] in TABLES_BY_KIND:
        kinds: Mapping[str, type[BaseModel]] = KINDS if loc[0] == "terrain" else TRACES
        return kinds[str(loc[1])].model_fields
    annotation = Scenario.model_fields[str(loc[0])].annotation
    # the table itself, or that of an array or of a table that may be missing
    table = (get_args(annotation) or (annotation,))[0]
    return list(table.model_fields)
