"""A recorded hand: a CSV file of commands over time, as ``drive`` of a scenario.

Columns by their names, in any order; others are passed over, so a run's own ``ticks.csv`` is one.
``t``, and either ``alpha``, ``speed`` and ``turn``, or ``vx``, ``vy`` and ``wz``. A unit may stand
behind a name (``alpha_rad``, ``vx (mm/s)``); without one they are s, degrees, m/s and degrees/s,
and rad/s for ``wz``. Comma, or semicolon or tab (then also decimal commas). Fields of a ROS topic
(``/cmd_vel/linear/x``) are known by their ends.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from walking_console.planner.robot.toml_files import TomlFileError, is_file, read_text

from .scenario_tables import DRIVES_MAX, DURATION_MAX

FILE_BYTES_MAX = 32_000_000
HEADER_SHOWN = 200  # letters
# the names of a column, without its unit
NAMES = {
    "t": "t",
    "time": "t",
    "timestamp": "t",
    "alpha": "alpha",
    "crab_angle": "alpha",
    "angle": "alpha",
    "direction": "alpha",
    "speed": "speed",
    "turn": "turn",
    "turn_rate": "turn",
    "vx": "vx",
    "linear_x": "vx",
    "vy": "vy",
    "linear_y": "vy",
    "wz": "wz",
    "angular_z": "wz",
}
TIMES = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
SPEEDS = {"m_s": 1.0, "mm_s": 1e-3, "cm_s": 1e-2, "mps": 1.0, "km_h": 1 / 3.6, "kmh": 1 / 3.6}
ANGLES = {"deg": 1.0, "rad": math.degrees(1.0)}  # in degrees, as scenarios have them
RATES = {"deg_s": 1.0, "rad_s": math.degrees(1.0)}
UNITS = {
    "t": TIMES,
    "alpha": ANGLES,
    "speed": SPEEDS,
    "turn": RATES,
    "vx": SPEEDS,
    "vy": SPEEDS,
    "wz": RATES,
}
UNASKED = {"t": "s", "alpha": "deg", "turn": "deg_s", "wz": "rad_s"}  # m_s otherwise
OF_A_MESSAGE = re.compile(r"^.*_(?=linear_[xy]|angular_z)")  # of a ROS topic, before its fields
DECIMAL_COMMAS = (";", "\t")  # separators that leave the comma to be one
POLAR = ("alpha", "speed", "turn")
CARTESIAN = ("vx", "vy", "wz")

Entry = dict[str, float]


class DriveFileError(ValueError):
    """A file that holds no recorded hand; the message is one clear line."""


class Column(NamedTuple):
    """What a column holds, where it is, and what one of its units is in ours."""

    name: str
    place: int
    factor: float


def read_drive(path: Path, given: str) -> list[Entry]:
    """The entries of a timeline, each with the keys of ``[[drive]]``; raises ``DriveFileError``."""
    what = f"drive file {given!r:.200}"
    if not is_file(path):
        raise DriveFileError(f"{what} does not exist, or is not a file")
    try:
        text = read_text(path, what, FILE_BYTES_MAX)
        return _entries(text)
    except TomlFileError as error:
        raise DriveFileError(str(error)) from None
    except (DriveFileError, csv.Error) as error:
        raise DriveFileError(f"{what}: {error}") from None


def _entries(text: str) -> list[Entry]:
    lines = [line for line in text.split("\n") if line.strip() and not line.startswith("#")]
    if len(lines) < 2:
        raise DriveFileError("it needs a line of column names and at least one of numbers")
    if len(lines) - 1 > DRIVES_MAX:
        raise DriveFileError(f"{len(lines) - 1} lines; at most {DRIVES_MAX} are taken")
    separator = _separator(lines[0])
    rows = csv.reader(lines, delimiter=separator)
    columns = _columns(next(rows))
    entries: list[Entry] = []
    for number, row in enumerate(rows, 2):
        values = {column.name: _number(row, column, number, separator) for column in columns}
        _add(entries, _entry(values, entries), number)
    return _from_the_start(entries)


def _separator(header: str) -> str:
    return next((mark for mark in (";", "\t", ",") if mark in header), ",")


def _columns(header: Sequence[str]) -> list[Column]:
    found = [column for index, name in enumerate(header) for column in _column(name, index)]
    names = [column.name for column in found]
    polar = any(name in POLAR for name in names)
    cartesian = any(name in CARTESIAN for name in names)
    whole = "speed" in names if polar else "vx" in names
    if "t" not in names or polar == cartesian or not whole or len(set(names)) < len(names):
        raise DriveFileError(
            "it needs columns t and alpha, speed, turn, or t and vx, vy, wz, each once, "
            f"got {', '.join(header)[:HEADER_SHOWN]!r}"
        )
    return found


def _column(header: str, index: int) -> Iterator[Column]:
    """The column of a name with or without its unit; none for any other name."""
    words = re.sub(r"[^a-z0-9]+", "_", header.strip().lower()).strip("_")
    words = OF_A_MESSAGE.sub("", words)
    for known, name in NAMES.items():
        unit = words.removeprefix(known).removeprefix("_")
        if words == known:
            yield Column(name, index, UNITS[name][UNASKED.get(name, "m_s")])
        elif words.startswith(f"{known}_") and unit in UNITS[name]:
            yield Column(name, index, UNITS[name][unit])


def _number(row: Sequence[str], column: Column, line: int, separator: str) -> float:
    text = row[column.place].strip() if column.place < len(row) else ""
    if separator in DECIMAL_COMMAS:
        text = text.replace(",", ".")
    try:
        value = float(text) * column.factor
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise DriveFileError(f"line {line}: {column.name} must be a number, got {text!r:.40}")
    return value


def _entry(values: Entry, before: Sequence[Entry]) -> Entry:
    """One entry; a hand at rest keeps its direction."""
    direction = before[-1]["crab_angle_deg"] if before else 0.0
    if "vx" in values:
        x, y = values["vx"], values.get("vy", 0.0)
        speed = math.hypot(x, y)
        angle = math.degrees(math.atan2(y, x)) if speed else direction
        turn = values.get("wz", 0.0)
    else:
        speed = values["speed"]
        angle = values.get("alpha", 0.0)
        turn = values.get("turn", 0.0)
    if speed < 0.0:
        speed = -speed
        angle += 180.0
    return {
        "t": values["t"],
        "crab_angle_deg": math.remainder(angle, 360.0),
        "speed": speed,
        "turn_rate_deg_s": turn,
    }


def _add(entries: list[Entry], entry: Entry, line: int) -> None:
    """Of several at one time the last counts."""
    if entries and entry["t"] < entries[-1]["t"]:
        raise DriveFileError(
            f"line {line}: t must not go back, got {entry['t']:g} after {entries[-1]['t']:g}"
        )
    if entries and entry["t"] == entries[-1]["t"]:
        entries.pop()
    entries.append(entry)


def _from_the_start(entries: list[Entry]) -> list[Entry]:
    """Times of day begin with the run."""
    first = entries[0]["t"]
    if 0.0 <= first <= DURATION_MAX:
        return entries
    return [{**entry, "t": entry["t"] - first} for entry in entries]
