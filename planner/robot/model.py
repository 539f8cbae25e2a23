"""What a walker is: legs, reach boxes, speed limits, mass. Shipped robots are data
(``machines/*.toml``).
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Any

LEGS_MIN, LEGS_MAX = 4, 8
NUMBER_MAX = 1e6
LENGTH_MAX = 10.0  # m: beyond it maps and searches outgrow memory, and nothing walks
FOOT_MAX = 0.5  # m
CRAB_LEGS = 4
FILE_BYTES_MAX = 1_000_000


class MachineError(ValueError):
    """A robot description that cannot walk; the message lists every reason."""


@dataclass(frozen=True, slots=True)
class Leg:
    """One leg: its name and its control reach, a box in body axes (gait-planning limits, H fig. 1)."""

    name: str
    x: tuple[float, float]
    y: tuple[float, float]
    z: tuple[float, float]

    @property
    def centre(self) -> tuple[float, float]:
        """C_i, the middle of the reach rectangle (H §2.1)."""
        return (self.x[0] + self.x[1]) / 2, (self.y[0] + self.y[1]) / 2

    @property
    def box(self) -> tuple[float, float, float, float]:
        """The reach rectangle as x_min, x_max, y_min, y_max."""
        return self.x[0], self.x[1], self.y[0], self.y[1]


@dataclass(frozen=True, slots=True)
class Reach:
    """H's one box for all four legs: |x| in [x0, x0+x*], |y| in [y0, y0+y*], z in [-z0-z*, -z0] (H
    fig. 1).
    """

    x0: float
    x_span: float  # x*
    y0: float
    y_span: float  # y*
    z0: float
    z_span: float  # z*


@dataclass(frozen=True)
class Machine:
    """A walker as both planners and the simulation see it. Lengths in metres, mass in kilograms."""

    name: str
    title: str
    source: str
    mass: float
    torso: tuple[float, float, float]  # length, width, height
    height: float  # H, centre of gravity above the ground
    foot_radius: float
    friction: float
    yaw_length: float  # ρ, metres per radian
    duty_factor: float  # β
    lift_up: float  # h_up
    lift_down: float  # h_dwn
    speed: tuple[float, float, float]  # V_x, V_y, V_z
    overreach: tuple[float, float, float]  # δx, δy, δz
    legs: tuple[Leg, ...]

    @cached_property
    def boxes(self) -> tuple[tuple[float, float, float, float], ...]:
        """Every leg's reach rectangle as (x_min, x_max, y_min, y_max)."""
        return tuple(leg.box for leg in self.legs)

    @cached_property
    def hips(self) -> tuple[tuple[float, float], ...]:
        """Where each leg leaves the torso: the point of its outline nearest to the middle of the
        leg's reach.
        """
        half_length, half_width = self.torso[0] / 2, self.torso[1] / 2
        return tuple(
            (max(-half_length, min(half_length, x)), max(-half_width, min(half_width, y)))
            for x, y in (leg.centre for leg in self.legs)
        )

    @cached_property
    def reach(self) -> Reach:
        """H's symmetric box; raises ``MachineError`` when this machine does not have one (the crab
        planner needs it).
        """
        if len(self.legs) != CRAB_LEGS:
            raise MachineError(
                f"the crab planner walks four-legged machines; {self.name!r} has {len(self.legs)} legs"
            )
        first = self.legs[0]
        x_span, y_span, z_span = (
            round(span[1] - span[0], 12) for span in (first.x, first.y, first.z)
        )
        reach = Reach(first.x[0], x_span, first.y[0], y_span, -first.z[1], z_span)
        for leg, (sx, sy) in zip(self.legs, ((1, 1), (-1, 1), (-1, -1), (1, -1)), strict=True):
            mirrored = (*sorted(sx * v for v in first.x), *sorted(sy * v for v in first.y))
            if (
                any(abs(a - b) > 1e-9 for a, b in zip(leg.box, mirrored, strict=True))
                or leg.z != first.z
            ):
                raise MachineError(
                    f"the crab planner needs one reach box mirrored to four quadrants; leg {leg.name!r} differs"
                )
        return reach

    @cached_property
    def z_range(self) -> tuple[float, float]:
        """Heights every leg can stand at: the intersection of the legs' z ranges."""
        return max(leg.z[0] for leg in self.legs), min(leg.z[1] for leg in self.legs)


_NUMBERS = (
    "mass",
    "height",
    "foot_radius",
    "friction",
    "yaw_length",
    "duty_factor",
    "lift_up",
    "lift_down",
)
_TRIPLES = ("torso", "speed", "overreach")
_WORDS = ("name", "title", "source")
_KNOWN = (*_WORDS, *_NUMBERS, *_TRIPLES, "legs")


def machine_names() -> tuple[str, ...]:
    """Names of the shipped robots, sorted."""
    folder = resources.files("walking_console.planner.robot") / "descriptions"
    return tuple(
        sorted(
            entry.name.removesuffix(".toml")
            for entry in folder.iterdir()
            if entry.name.endswith(".toml")
        )
    )


def load_machine(name_or_path: str, relative_to: Path | None = None) -> Machine:
    """A shipped robot by name, or a robot file by path (relative to ``relative_to``); raises
    ``MachineError``.
    """
    if name_or_path in machine_names():
        text = (
            resources.files("walking_console.planner.robot")
            / "descriptions"
            / f"{name_or_path}.toml"
        ).read_text("utf-8")
        return machine_from(_parse(text, name_or_path))
    path = (relative_to or Path()) / name_or_path
    if not name_or_path.endswith(".toml") or not is_file(path):
        raise MachineError(
            f"unknown robot {name_or_path!r:.200}; there are: {', '.join(machine_names())}, or a path to a robot TOML file"
        )
    try:
        if path.stat().st_size > FILE_BYTES_MAX:
            raise MachineError(f"robot file {name_or_path!r} is larger than {FILE_BYTES_MAX} bytes")
        text = path.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise MachineError(f"cannot read robot file {name_or_path!r}: {error}") from None
    return machine_from(_parse(text, name_or_path))


def is_file(path: Path) -> bool:
    """Whether a file is there to be read; a path that no system could have names none."""
    try:
        return path.is_file()
    except OSError:  # too long a name, a folder nobody may look into
        return False


def shown(value: Any) -> str:
    """A refused value in at most 80 characters."""
    try:
        return f"{value!r:.80}"
    # an integer of thousands of digits, tables in tables in tables
    except (ValueError, RecursionError):
        return (
            "a number too long to show" if isinstance(value, int) else "a value too large to show"
        )


def _parse(text: str, name: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    # TOMLDecodeError, and integers of thousands of digits
    except (ValueError, RecursionError) as error:
        raise MachineError(f"robot file {name!r} is not valid TOML: {error}") from None


def machine_from(data: Mapping[str, Any]) -> Machine:
    """Build and check a machine from plain data (a parsed robot file); a refusal lists every
    reason.
    """
    faults: list[str] = []
    for key in data:
        if key not in _KNOWN:
            faults.append(f"unknown key {key!r:.80}; there are: {', '.join(_KNOWN)}")
    words = {key: _word(data, key, faults) for key in _WORDS}
    numbers = {key: _number(data.get(key), key, faults) for key in _NUMBERS}
    triples = {key: _numbers(data.get(key), key, 3, faults) for key in _TRIPLES}
    legs = _legs(data.get("legs"), faults)
    if not faults:
        _check_numbers(numbers, triples, faults)
        _check_stance(legs, numbers, faults)
    if faults:
        raise MachineError(f"robot {words['name'] or '?'!s} cannot be used: " + "; ".join(faults))
    plain: dict[str, Any] = {**words, **numbers}
    return Machine(
        **plain,
        torso=(triples["torso"][0], triples["torso"][1], triples["torso"][2]),
        speed=(triples["speed"][0], triples["speed"][1], triples["speed"][2]),
        overreach=(triples["overreach"][0], triples["overreach"][1], triples["overreach"][2]),
        legs=legs,
    )


def as_data(machine: Machine) -> dict[str, Any]:
    """The robot as plain data, the inverse of ``machine_from`` (what ``run.json`` keeps)."""
    plain = {key: getattr(machine, key) for key in (*_WORDS, *_NUMBERS)}
    triples = {key: list(getattr(machine, key)) for key in _TRIPLES}
    legs = [
        {"name": leg.name, "x": list(leg.x), "y": list(leg.y), "z": list(leg.z)}
        for leg in machine.legs
    ]
    return {**plain, **triples, "legs": legs}


def _word(data: Mapping[str, Any], key: str, faults: list[str]) -> str:
    value = data.get(key)
    if not isinstance(value, str) or not value.strip() or len(value) > 500:
        faults.append(f"{key} must be a text of 1 to 500 characters, got {shown(value)}")
        return ""
    return value


def _number(value: Any, key: str, faults: list[str]) -> float:
    if (
        isinstance(value, bool)
        or not isinstance(value, int | float)
        or not abs(value) <= NUMBER_MAX
    ):
        faults.append(
            f"{key} must be a finite number of at most {NUMBER_MAX:g}, got {shown(value)}"
        )
        return 0.0
    return float(value)


def _numbers(value: Any, key: str, count: int, faults: list[str]) -> tuple[float, ...]:
    if not isinstance(value, list) or len(value) != count:
        faults.append(f"{key} must be a list of {count} numbers, got {shown(value)}")
        return (0.0,) * count
    return tuple(_number(item, f"{key}[{index}]", faults) for index, item in enumerate(value))


def _legs(value: Any, faults: list[str]) -> tuple[Leg, ...]:
    if not isinstance(value, list) or not LEGS_MIN <= len(value) <= LEGS_MAX:
        got = len(value) if isinstance(value, list) else shown(value)
        faults.append(f"legs must be {LEGS_MIN} to {LEGS_MAX} tables, got {got}")
        return ()
    legs = []
    for index, item in enumerate(value, 1):
        if not isinstance(item, Mapping) or set(item) - {"name", "x", "y", "z"}:
            faults.append(f"leg {index} must be a table with name, x, y, z")
            continue
        name = _word(item, "name", faults)
        spans = [
            _numbers(item.get(axis), f"leg {index} {axis}", 2, faults) for axis in ("x", "y", "z")
        ]
        for axis, span in zip("xyz", spans, strict=True):
            if not span[0] < span[1] and not faults:
                faults.append(
                    f"leg {index} {axis} must be [low, high] with low < high, got {list(span)}"
                )
        legs.append(
            Leg(
                name,
                (spans[0][0], spans[0][1]),
                (spans[1][0], spans[1][1]),
                (spans[2][0], spans[2][1]),
            )
        )
    return tuple(legs)


def _check_numbers(
    numbers: Mapping[str, float], triples: Mapping[str, tuple[float, ...]], faults: list[str]
) -> None:
    for key in ("mass", "height", "foot_radius", "friction", "yaw_length", "lift_up", "lift_down"):
        if not numbers[key] > 0:
            faults.append(f"{key} must be positive, got {numbers[key]:g}")
    if not 0.5 <= numbers["duty_factor"] < 1.0:
        faults.append(f"duty_factor must be in [0.5, 1), got {numbers['duty_factor']:g}")
    for key in ("torso", "speed"):
        if not all(value > 0 for value in triples[key]):
            faults.append(f"{key} must be positive, got {list(triples[key])}")
    if not all(value >= 0 for value in triples["overreach"]):
        faults.append(f"overreach must not be negative, got {list(triples['overreach'])}")
    for key in ("height", "yaw_length", "lift_up", "lift_down"):
        if numbers[key] > LENGTH_MAX:
            faults.append(f"{key} must be at most {LENGTH_MAX:g} m, got {numbers[key]:g}")
    for key in ("torso", "overreach"):
        if max(triples[key]) > LENGTH_MAX:
            faults.append(f"{key} must be at most {LENGTH_MAX:g} m, got {list(triples[key])}")
    if numbers["foot_radius"] > FOOT_MAX:
        faults.append(f"foot_radius must be at most {FOOT_MAX:g} m, got {numbers['foot_radius']:g}")
    if numbers["lift_down"] < numbers["lift_up"]:
        faults.append(
            f"lift_down must be at least lift_up {numbers['lift_up']:g}, got {numbers['lift_down']:g}"
        )


def _check_stance(legs: tuple[Leg, ...], numbers: Mapping[str, float], faults: list[str]) -> None:
    for number, leg in enumerate(legs, 1):
        for axis, span in (("x", leg.x), ("y", leg.y), ("z", leg.z)):
            if max(abs(span[0]), abs(span[1])) > LENGTH_MAX:
                faults.append(
                    f"leg {number} {axis} must be within {LENGTH_MAX:g} m, got {list(span)}"
                )
    low, high = max(leg.z[0] for leg in legs), min(leg.z[1] for leg in legs)
    if not low <= -numbers["height"] <= high:
        faults.append(
            f"height {numbers['height']:g} is outside the legs' common z range [{-high:g}, {-low:g}]"
        )
    angles = [math.atan2(leg.centre[1], leg.centre[0]) % (2 * math.pi) for leg in legs]
    if any(b <= a for a, b in zip(angles, angles[1:], strict=False)):
        faults.append("legs must run counter-clockwise from front-left")
    gaps = [(b - a) % (2 * math.pi) for a, b in zip(angles, angles[1:] + angles[:1], strict=True)]
    if max(gaps) >= math.pi:
        faults.append(
            "no statically stable stance: the centre of gravity is outside the polygon of the leg centres"
        )
