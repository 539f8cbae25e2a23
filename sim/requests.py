"""What may be asked of a ``Simulation`` beside driving it, and each as a line of ``inputs.jsonl``.

A request is a frozen value; ``Simulation.request`` takes it and the next tick serves it. Whatever
came from outside, commands included, is kept as a record and fed again when a run is replayed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.types import POSTURES, Array, Command

from .terrain.ground import HEIGHT_MAX, Ground
from .world import World

EDITS = ("dig", "raise", "forbid", "clear")
EDIT_CELLS_MAX = 40_000  # cells one terrain edit may change
ATTITUDES = ("level", "ground")

Record = dict[str, Any]


@dataclass(frozen=True)
class Reset:
    """Back to the start of the scenario."""


@dataclass(frozen=True)
class Load:
    """Go on in another world, made by ``prepare``."""

    world: World


@dataclass(frozen=True)
class Edit:
    """Change cells of the true ground and of what is believed of it.

    ``dig`` makes a bottomless hole, ``raise`` adds ``amount`` metres, ``forbid`` closes cells to
    the feet whatever their height, ``clear`` opens them again and fills holes to 0.
    """

    action: str  # dig | raise | forbid | clear
    cells: tuple[tuple[int, int], ...]  # (row, column), of a wide map those of the whole
    amount: float = 0.0  # m


@dataclass(frozen=True)
class Push:
    """Push the torso horizontally with (fx, fy) newtons, absolute axes, for a number of ticks."""

    fx: float
    fy: float
    ticks: int = 1


@dataclass(frozen=True)
class TakePosture:
    """Take a posture: sit, stand, or standard (its feet in the layout of the last course).

    The machine stops first; it is refused with a reason where it cannot be taken.
    """

    posture: str


@dataclass(frozen=True)
class Halt:
    """Stop in whatever posture it is being taken to; a walking machine holds by its command."""


@dataclass(frozen=True)
class Follow:
    """Keep the body level, or let it follow the ground as far as strides allow, from the next step
    planned on.
    """

    attitude: str  # level | ground


Request = Reset | Load | Edit | Push | TakePosture | Halt | Follow


def edited(ground: Ground, edit: Edit) -> Ground:
    """The ground after an edit; the same one where no height changes. Raises ``ValueError`` before
    anything has changed.
    """
    if edit.action not in EDITS:
        raise ValueError(f"unknown terrain edit {edit.action!r}; there are: {', '.join(EDITS)}")
    if len(edit.cells) > EDIT_CELLS_MAX:
        raise ValueError(f"an edit changes at most {EDIT_CELLS_MAX} cells, got {len(edit.cells)}")
    rows, columns = rows_and_columns(edit)
    ny, nx = ground.whole_shape
    inside = (rows >= 0) & (rows < ny) & (columns >= 0) & (columns < nx)
    if not inside.all():
        raise ValueError(f"cells must be within {ny} rows and {nx} columns")
    if edit.action == "forbid" or not edit.cells:
        return ground
    heights = _edited(ground.heights_of(rows, columns), edit)
    return ground.with_heights(rows, columns, heights)


def _edited(heights: Array, edit: Edit) -> Array:
    """Heights of the cells of an edit after it."""
    if edit.action == "dig":
        return np.full(heights.shape, np.nan)
    if edit.action == "clear":
        return np.where(np.isnan(heights), 0.0, heights)
    raised = heights + edit.amount
    if np.nanmax(np.abs(raised), initial=0.0) > HEIGHT_MAX:
        raise ValueError(f"heights must be within {HEIGHT_MAX:g} m of 0")
    return raised


def rows_and_columns(edit: Edit) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The cells of an edit as two index arrays."""
    rows = np.array([row for row, _ in edit.cells], dtype=np.intp)
    columns = np.array([column for _, column in edit.cells], dtype=np.intp)
    return rows, columns


# -- as lines of inputs.jsonl


def input_record(given: object) -> Record:
    """One input from outside as JSON: what ``inputs.jsonl`` keeps and ``input_from`` reads back."""
    name = _NAMES.get(type(given))
    if name is None:
        raise TypeError(f"unknown input {given!r}")
    if isinstance(given, Load):
        return {"input": name, "scenario": given.world.scenario.name}
    if isinstance(given, Edit):
        cells = [list(cell) for cell in given.cells]
        return {"input": name, "action": given.action, "cells": cells, "amount": given.amount}
    return {"input": name, **asdict(given)}  # type: ignore[call-overload]


def input_from(record: Record) -> Command | Request:
    """The inverse of ``input_record``; raises ``ValueError`` for what a replay cannot feed."""
    kind = record.get("input")
    read = _READERS.get(kind) if isinstance(kind, str) else None
    if read is None:
        raise ValueError(f"unknown input {kind!r}; there are: {', '.join(_READERS)}")
    return read(record)


def _command(record: Record) -> Command:
    return Command(*(_finite(record[key]) for key in ("crab_angle", "speed", "turn_rate")))


def _edit(record: Record) -> Edit:
    cells = tuple((_index(row), _index(column)) for row, column in record["cells"])
    return Edit(record["action"], cells, _finite(record["amount"]))


def _push(record: Record) -> Push:
    return Push(_finite(record["fx"]), _finite(record["fy"]), int(record["ticks"]))


_NAMES: dict[type, str] = {
    Command: "command",
    Edit: "edit",
    Push: "push",
    TakePosture: "pose",
    Halt: "halt",
    Follow: "attitude",
    Reset: "reset",
    Load: "load",
}
_READERS: dict[str, Callable[[Record], Command | Request]] = {
    "command": _command,
    "edit": _edit,
    "push": _push,
    "pose": lambda record: TakePosture(_one_of(record, "posture", POSTURES)),
    "halt": lambda record: Halt(),
    "attitude": lambda record: Follow(_one_of(record, "attitude", ATTITUDES)),
    "reset": lambda record: Reset(),
}


def _one_of(record: Record, key: str, known: Sequence[str]) -> str:
    value: str = record[key]
    if value not in known:
        raise ValueError(f"unknown {key} {value!r:.80}; there are: {', '.join(known)}")
    return value


def _finite(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"a finite number is wanted, got {value!r:.80}")
    return value


def _index(value: Any) -> int:
    if type(value) is not int or not 0 <= value < 2**31:
        raise ValueError(f"a row or column is wanted, got {value!r:.80}")
    return value
