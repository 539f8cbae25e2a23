"""Scenarios by name or path, and the ``--set`` that changes them."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from walking_console.planner.robot.toml_files import (
    TomlFileError,
    is_file,
    names_toml_file,
    parse_toml,
    read_toml,
)

from .drive_files import DriveFileError, read_drive
from .scenario import Scenario, ScenarioError
from .scenario_faults import every_fault, faults
from .terrain.generators import FileTerrain

FILE_BYTES_MAX = 32_000_000  # a timeline may be long
NO_FILES = "a scenario that is not a file itself cannot name files (terrain.file, robot, drive)"
FIXED_SETTINGS = ("drive", "trace")  # either replaces the other
FILE_KEYS = (("robot",), ("drive",), ("terrain", "file"))  # values that may be paths of files


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
    return tuple((name, str(_shipped(name).get("title", ""))) for name in scenario_names())


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
        given = _shipped(name_or_path)
        base = Path()
    else:
        given = _read(Path(name_or_path), name_or_path)
        base = Path(name_or_path).parent
    data = _typed_files_found(with_settings(given, settings), settings)
    if seed is not None:
        data["seed"] = seed
    return scenario_from({"name": Path(name_or_path).stem, **data}, base)


def scenario_from(data: Mapping[str, Any], base: Path | None = None) -> Scenario:
    """Build and check a scenario from plain data. Without ``base`` it may not name files. Raises
    ``ScenarioError``.
    """
    _check_integers(data)
    plain = _with_hand(dict(data), base)
    terrain = plain.get("terrain")
    if isinstance(terrain, Mapping) and "file" in terrain and "kind" not in terrain:
        plain["terrain"] = {"kind": "file", **terrain}
    try:
        scenario = Scenario.model_validate(plain)
    except ValidationError as error:
        raise ScenarioError(faults(error), every_fault(error)) from None
    return _with_files(scenario, base)


def _with_hand(data: dict[str, Any], base: Path | None) -> dict[str, Any]:
    """``drive`` may be the name of a file of commands: its entries in its place."""
    given = data.get("drive")
    if not isinstance(given, str):
        return data
    if base is None:
        raise ScenarioError(NO_FILES)
    try:
        return {**data, "drive": read_drive(base / given, given)}
    except DriveFileError as error:
        raise ScenarioError(str(error)) from None


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
    terrain = scenario.terrain
    change: dict[str, Any] = {}
    if isinstance(terrain, FileTerrain):
        file = str(((base or Path()) / terrain.file).absolute())
        change["terrain"] = terrain.model_copy(update={"file": file})
    if isinstance(scenario.robot, str) and names_toml_file(scenario.robot):
        change["robot"] = str(((base or Path()) / scenario.robot).absolute())
    if change and base is None:
        raise ScenarioError(NO_FILES)
    if change:
        scenario = scenario.model_copy(update=change)
    scenario._base = base
    return scenario


def _shipped(name: str) -> dict[str, Any]:
    file = resources.files("walking_console.sim") / "scenarios" / f"{name}.toml"
    return parse_toml(file.read_text("utf-8"), f"scenario {name!r}")


def _read(path: Path, given: str) -> dict[str, Any]:
    if not names_toml_file(given) or not is_file(path):
        raise ScenarioError(
            f"unknown scenario {given!r:.200}; there are: {', '.join(scenario_names())}, "
            "or a path to a scenario TOML file"
        )
    try:
        return read_toml(path, f"scenario file {given!r}", FILE_BYTES_MAX)
    except TomlFileError as error:
        raise ScenarioError(str(error)) from None


def _typed_files_found(data: dict[str, Any], settings: Iterable[str]) -> dict[str, Any]:
    """``data`` with every file that a setting names sought where it was typed first: in the working
    directory. What is not there stays relative to the scenario file.
    """
    typed = {setting.partition("=")[0].strip() for setting in settings}
    for parts in FILE_KEYS:
        table = data if len(parts) == 1 else data.get(parts[0])
        name = table.get(parts[-1]) if isinstance(table, dict) else None
        asked = any(".".join(parts[:depth]) in typed for depth in range(1, len(parts) + 1))
        if asked and isinstance(table, dict) and isinstance(name, str) and "." in name:
            place = Path(name).expanduser().absolute()
            table[parts[-1]] = str(place) if is_file(place) else name
    return data


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
        _put(changed, parts, plain_value(value.strip()), setting)
    return changed


def _one_line(setting: str) -> str:
    """A setting as typed, cut, its line ends shown."""
    return repr(setting[:200])[1:-1]


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
            where = ".".join(parts[:depth])
            raise ScenarioError(
                f"--set {_one_line(setting)}: {where!r} is neither a table nor an array"
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
            f"{where} is an array of {len(array)}; index it with 0 to {len(array) - 1}, "
            f"not {part!r:.40}"
        )
    return int(part)


def plain_value(text: str) -> Any:
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
