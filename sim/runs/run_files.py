"""A run directory, read back: every file checked before it is believed, each refusal one line."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from walking_console.planner.robot.card import shown
from walking_console.planner.robot.model import machine_from
from walking_console.planner.types import Command
from walking_console.sim.requests import Request, input_from
from walking_console.sim.runs.ground_record import ground_from
from walking_console.sim.runs.recorder import SCHEMA
from walking_console.sim.runs.wide_record import Arrays
from walking_console.sim.scenario_files import scenario_from
from walking_console.sim.terrain.ground import Ground
from walking_console.sim.world import World, prepare

# of one .npz of a run: an hour of eight legs over the largest map is half of it
ARRAYS_BYTES_MAX = 1_000_000_000
# dimensions of every array of ticks.npz
LOG_DIMENSIONS = {
    "t": 1,
    "body": 2,
    "feet": 3,
    "contact": 2,
    "support": 2,
    "command": 2,
    "margin": 1,
    "polygon_margin": 1,
    "step": 1,
    "mode": 1,
    "hash": 1,
}
WHOLE_NUMBERS = ("contact", "support", "step", "mode")
FINITE = ("t", "body", "feet", "command")
SUMMARY_KINDS: dict[str, type] = {
    "version": str,
    "scenario": dict,
    "robot": dict,
    "result": str,
    "reason": str,
    "ticks": int,
    "modes": dict,
    "state_hash": str,
}
GROUND_DIMENSIONS = {"heights": 2, "cell": 0, "origin": 1, "forbidden": 2}

BROKEN_RECORD = (
    ValueError,
    KeyError,
    TypeError,
    AttributeError,
    OverflowError,
    RecursionError,
)

Summary = dict[str, Any]


class RunError(ValueError):
    """A run directory that cannot be used; the message is one clear line."""


def read_run(directory: Path) -> Summary:
    """``run.json`` of a run directory; raises ``RunError``."""
    path = directory / "run.json"
    try:
        summary = json.loads(path.read_text("utf-8"))
    except FileNotFoundError:
        raise RunError(f"{directory} is not a run directory: it has no run.json") from None
    except (OSError, ValueError, RecursionError) as error:
        raise RunError(f"cannot read {path}: {error}") from None
    if not isinstance(summary, dict) or summary.get("schema") != SCHEMA:
        got = summary.get("schema") if isinstance(summary, dict) else type(summary).__name__
        raise RunError(f"{path} must have schema {SCHEMA}, got {shown(got)}")
    for key, kind in SUMMARY_KINDS.items():
        got = summary.get(key)
        if not isinstance(got, kind):
            raise RunError(f"{path}: {key} is missing or is no {kind.__name__}, got {shown(got)}")
    return summary


def read_arrays(path: Path, wanted: Mapping[str, int]) -> Arrays:
    """The arrays of an .npz of a run, each of the wanted number of dimensions; raises
    ``RunError``.
    """
    arrays = _unpacked(path)
    for name, dimensions in wanted.items():
        array = arrays.get(name)
        if array is None:
            raise RunError(f"cannot read {path}: there is no {name!r} in it")
        if array.ndim != dimensions or array.dtype.kind not in "fiub":
            raise RunError(
                f"cannot read {path}: {name!r} must be numbers of {dimensions} dimensions, "
                f"got {array.dtype} {array.shape}"
            )
    return arrays


def _unpacked(path: Path) -> Arrays:
    """All arrays of an .npz, unless they are more than any run has."""
    try:
        with zipfile.ZipFile(path) as archive:
            size = sum(info.file_size for info in archive.infolist())
        if size > ARRAYS_BYTES_MAX:
            raise RunError(f"{path} unpacks to {size} bytes; at most {ARRAYS_BYTES_MAX}")
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except RunError:
        raise
    # broken files raise whatever the decoders underneath happen to: struct, zlib, tokenize ...
    except Exception as error:
        raise RunError(f"cannot read {path}: {error or type(error).__name__}") from None


def read_log(directory: Path) -> Arrays:
    """``ticks.npz`` as named arrays of one length; raises ``RunError``."""
    path = directory / "ticks.npz"
    log = read_arrays(path, LOG_DIMENSIONS)
    _check_shapes(path, log)
    if log["hash"].dtype != np.uint64:
        raise RunError(f"cannot read {path}: 'hash' must be uint64, got {log['hash'].dtype}")
    for name in WHOLE_NUMBERS:
        kind = log[name].dtype
        if kind.kind == "f":
            raise RunError(f"cannot read {path}: {name!r} must be whole numbers, got {kind}")
    for name in FINITE:
        if not np.isfinite(log[name]).all():
            raise RunError(f"cannot read {path}: {name!r} has values that are no numbers")
    return log


def _check_shapes(path: Path, log: Arrays) -> None:
    """One row a tick in every array, of as many legs as there are feet."""
    ticks, legs = log["feet"].shape[:2]
    widths: dict[str, tuple[int, ...]] = {
        "body": (6,),
        "feet": (legs, 3),
        "contact": (legs,),
        "support": (legs,),
        "command": (3,),
    }
    for name in LOG_DIMENSIONS:
        shape = log[name].shape
        if shape != (ticks, *widths.get(name, ())) or not ticks:
            raise RunError(
                f"cannot read {path}: {name!r} has shape {shape} where there are {ticks} ticks "
                f"of {legs} legs"
            )


def read_steps(directory: Path) -> list[dict[str, Any]]:
    """``steps.jsonl``; raises ``RunError``."""
    path = directory / "steps.jsonl"
    try:
        steps = [json.loads(line) for line in path.read_text("utf-8").splitlines()]
    except (OSError, ValueError, RecursionError) as error:
        raise RunError(f"cannot read {path}: {error}") from None
    for number, step in enumerate(steps, 1):
        if not _is_step(step):
            raise RunError(
                f"{path} line {number} is not a step: it needs a tick and the legs that swing"
            )
    return steps


def _is_step(step: object) -> bool:
    return (
        isinstance(step, dict)
        and type(step.get("tick")) is int
        and isinstance(step.get("swing"), list)
    )


def read_inputs(directory: Path) -> Iterator[tuple[int, Command | Request]]:
    """``inputs.jsonl``: tick and what came from outside before it; raises ``RunError``."""
    path = directory / "inputs.jsonl"
    try:
        lines = path.read_text("utf-8").splitlines()
    except (OSError, ValueError) as error:
        raise RunError(f"cannot read {path}: {error}") from None
    for number, line in enumerate(lines, 1):
        try:
            record = json.loads(line)
            yield int(record["tick"]), input_from(record)
        except BROKEN_RECORD as error:
            fault = f"{type(error).__name__} {error}"
            raise RunError(f"{path} line {number} is not an input: {fault}") from None


def recorded_world(directory: Path, summary: Summary) -> World:
    """The world a run was walked in, made anew from its directory alone; raises ``RunError``.

    Runs of before the ground was kept need the files their scenario names.
    """
    try:
        scenario = scenario_from(summary["scenario"], directory)
        machine = machine_from(summary["robot"])
        return prepare(scenario, machine, recorded_ground(directory, summary))
    except RunError:
        raise
    except ValueError as error:
        raise RunError(f"{directory / 'run.json'}: {error}") from None


def recorded_ground(directory: Path, summary: Summary) -> Ground | None:
    """The ground a run was begun on, to the last bit; None when it was not kept. Raises
    ``RunError``.
    """
    kept = summary.get("start_ground")
    if not isinstance(kept, dict):
        return None
    path = directory / "terrain.npz"
    arrays = read_arrays(path, GROUND_DIMENSIONS)
    try:
        return ground_from(arrays, str(kept.get("kind")), kept.get("final") is True)
    except ValueError as error:
        raise RunError(f"cannot read {path}: {error}") from None
