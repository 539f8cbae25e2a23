"""Runs without a browser, faster than life: a scenario's timeline, its end, its expectations, and
replays.
"""

from __future__ import annotations

import json
import math
import zipfile
from collections.abc import Callable, Iterator, Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from walking_console.planner.robot.card import shown
from walking_console.planner.robot.model import as_data, machine_from
from walking_console.planner.trace.planner import ARRIVED
from walking_console.planner.types import TICK, Command
from walking_console.sim.requests import Halt, TakePosture, input_from
from walking_console.sim.runs.metrics import measured
from walking_console.sim.runs.recorder import MODES, SCHEMA, Recorder
from walking_console.sim.scenario import Drive, Scenario, scenario_from
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import World, prepare

BLOCKED_LIMIT = 10.0  # s
PROGRESS_TICKS = 250
# of one .npz of a run: an hour of eight legs over the largest map is half of it
ARRAYS_BYTES_MAX = 1_000_000_000
LOG_DIMENSIONS = {
    "t": 1, "body": 2, "feet": 3, "contact": 2, "support": 2, "command": 2,
    "margin": 1, "polygon_margin": 1, "step": 1, "mode": 1, "hash": 1,
}  # fmt: skip
SUMMARY_KINDS: dict[str, type] = {
    "version": str, "scenario": dict, "robot": dict, "result": str, "reason": str, "ticks": int, "modes": dict, "state_hash": str,
}  # fmt: skip

Progress = Callable[[Simulation, float], None]  # console, share done 0..1


class RunError(ValueError):
    """A run directory that cannot be used; the message is one clear line."""


def timeline(scenario: Scenario) -> list[tuple[int, Command, TakePosture | Halt | None]]:
    """The drive entries as (tick, command, request), in order; a given trace is one command at its
    speed; with neither, hold.
    """
    if scenario.trace is not None:
        return [(0, Command(0.0, scenario.trace.speed), None)]
    return [(round(entry.t / TICK), entry.command(), _request(entry)) for entry in scenario.drive]


def _request(entry: Drive) -> TakePosture | Halt | None:
    """What an entry asks for beside its command: a posture, or, where it is to hold, that none goes
    on being taken.
    """
    if entry.posture is not None:
        return TakePosture(entry.posture)
    return Halt() if entry.command().holds else None


def run_scenario(
    scenario: Scenario,
    out: str | Path | None = None,
    *,
    explain: bool = False,
    progress: Progress | None = None,
    world: World | None = None,
) -> dict[str, Any]:
    """Walk a scenario to its end, faster than life, and say how it went: what ``run.json`` holds.

    ``out`` is the run directory to write, made when it is not there. ``explain`` keeps why every
    step was taken, ``progress`` is called now and then, ``world`` saves preparing the scenario's
    again. Raises ``RunError`` when the directory cannot be written, and what ``prepare`` raises.

    >>> from walking_console import load_scenario, run_scenario
    >>> summary = run_scenario(load_scenario("flat", ["end={time=10.0}", "expect={}"]))
    >>> summary["result"], summary["steps"], round(summary["distance"], 3)
    ('completed', 4, 0.8)
    """
    console = Simulation(world or prepare(scenario), explain=explain)
    recorder = Recorder(console)
    result, reason = "interrupted", "interrupted"
    try:
        result, reason = _walk_to_end(console, recorder, scenario, progress)
    except KeyboardInterrupt:
        pass
    summary = summarise(console, recorder, scenario, result, reason)
    if out is not None:
        try:
            Path(out).mkdir(parents=True, exist_ok=True)
            recorder.write(Path(out), summary)
        except OSError as error:
            raise RunError(
                f"cannot write the run directory {str(out)!r}: {error.strerror}"
            ) from None
    return summary


def _walk_to_end(
    console: Simulation, recorder: Recorder, scenario: Scenario, progress: Progress | None
) -> tuple[str, str]:
    orders = timeline(scenario)
    last_order = orders[-1][0] if orders else 0
    time_end, distance_end = scenario.end.time, scenario.end.distance
    ticks_max = round(scenario.time_limit / TICK)
    blocked_ticks, next_order = 0, 0
    step, note, plant = console.step, recorder.note, console.plant
    for index in range(ticks_max):
        while next_order < len(orders) and orders[next_order][0] <= index:
            _, command, request = orders[next_order]
            console.order(command)
            if request is not None:
                console.request(request)
            next_order += 1
        step()
        note()
        if plant.state == "fallen":
            return "fell", console.reason
        if distance_end is not None and console.distance >= distance_end - 1e-9:
            return "completed", "distance"
        if console.walk.blocked is not None and console.walk.blocked.reason == ARRIVED:
            return "completed", ARRIVED
        blocked_ticks = blocked_ticks + 1 if console.walk.blocked is not None else 0
        if blocked_ticks * TICK >= BLOCKED_LIMIT and index >= last_order:
            return "blocked", console.reason
        if progress is not None and index % PROGRESS_TICKS == 0:
            progress(console, _share(index / ticks_max, console.distance, distance_end))
    return ("blocked", "time") if time_end is None else ("completed", "time")


def _share(of_time: float, distance: float, distance_end: float | None) -> float:
    return of_time if distance_end is None else min(1.0, max(of_time, distance / distance_end))


def summarise(
    console: Simulation, recorder: Recorder, scenario: Scenario, result: str, reason: str
) -> dict[str, Any]:
    """``run.json``: what was run, how it ended, and each expectation held against what came."""
    seconds = recorder.ticks * TICK
    figures: dict[str, Any] = {
        "ticks": recorder.ticks,
        "seconds": seconds,
        "distance": console.distance,
        "mean_speed": console.distance / seconds if seconds else 0.0,
        "steps": len(recorder.steps),
        "margin_min": recorder.margin_min if math.isfinite(recorder.margin_min) else None,
        "forbidden_steps": recorder.forbidden_steps,
        "falls": recorder.falls,
        "emergent": dict(sorted(console.walk.contacts.counts.items())),
        **measured(console, recorder),
    }
    return {
        "schema": SCHEMA,
        "version": product_version(),
        "scenario": scenario.as_data(),
        "robot": as_data(console.world.machine),
        "result": result,
        "reason": reason,
        "ground": console.perception.ground.note or console.perception.ground.kind,
        **figures,
        "expect": held(scenario, figures),
        "modes": MODES,
        "state_hash": recorder.state_hash,
    }


def held(scenario: Scenario, figures: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Each expectation: wanted, got, pass."""
    got = {
        **figures,
        "emergent": sum(figures["emergent"].values()),
        "time": figures["seconds"],
        "margin": figures["margin_min"],
    }
    answer = {}
    for key, wanted in scenario.expect.model_dump(exclude_none=True).items():
        figure, bound = key.rsplit("_", 1)
        value = got[figure]
        passed = value is not None and (value >= wanted if bound == "min" else value <= wanted)
        answer[key] = {"wanted": wanted, "got": value, "pass": bool(passed)}
    return answer


def succeeded(summary: dict[str, Any]) -> bool:
    """Completed, and every expectation held."""
    return summary["result"] == "completed" and all(
        entry["pass"] for entry in summary["expect"].values()
    )


def product_version() -> str:
    """The installed version."""
    try:
        return version("walking-console")
    except PackageNotFoundError:
        return "0+unknown"


def read_run(directory: Path) -> dict[str, Any]:
    """``run.json`` of a run directory; raises ``RunError``."""
    try:
        summary = json.loads((directory / "run.json").read_text("utf-8"))
    except FileNotFoundError:
        raise RunError(f"{directory} is not a run directory: it has no run.json") from None
    except (OSError, ValueError, RecursionError) as error:
        raise RunError(f"cannot read {directory / 'run.json'}: {error}") from None
    if not isinstance(summary, dict) or summary.get("schema") != SCHEMA:
        got = summary.get("schema") if isinstance(summary, dict) else type(summary).__name__
        raise RunError(f"{directory / 'run.json'} must have schema {SCHEMA}, got {shown(got)}")
    for key, kind in SUMMARY_KINDS.items():
        if not isinstance(summary.get(key), kind):
            raise RunError(
                f"{directory / 'run.json'}: {key} is missing or is no {kind.__name__}, got {shown(summary.get(key))}"
            )
    return summary


def recorded_world(directory: Path, summary: dict[str, Any]) -> World:
    """The world a run was walked in; raises ``RunError`` when its files no longer say."""
    try:
        return prepare(
            scenario_from(summary["scenario"], directory), machine_from(summary["robot"])
        )
    except ValueError as error:
        raise RunError(f"{directory / 'run.json'}: {error}") from None


def read_arrays(path: Path, wanted: Mapping[str, int]) -> dict[str, np.ndarray[Any, Any]]:
    """The arrays of an .npz of a run, each of the wanted number of dimensions; raises ``RunError``."""
    try:
        with zipfile.ZipFile(path) as archive:
            size = sum(info.file_size for info in archive.infolist())
        if size > ARRAYS_BYTES_MAX:
            raise RunError(f"{path} unpacks to {size} bytes; at most {ARRAYS_BYTES_MAX}")
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except RunError:
        raise
    # broken files raise whatever the decoders underneath happen to: struct, zlib, tokenize ...
    except Exception as error:
        raise RunError(f"cannot read {path}: {error or type(error).__name__}") from None
    for name, dimensions in wanted.items():
        array = arrays.get(name)
        if array is None:
            raise RunError(f"cannot read {path}: there is no {name!r} in it")
        if array.ndim != dimensions or array.dtype.kind not in "fiub":
            raise RunError(
                f"cannot read {path}: {name!r} must be numbers of {dimensions} dimensions, got {array.dtype} {array.shape}"
            )
    return arrays


def read_log(directory: Path) -> dict[str, np.ndarray[Any, Any]]:
    """``ticks.npz`` as named arrays of one length; raises ``RunError``."""
    path = directory / "ticks.npz"
    log = read_arrays(path, LOG_DIMENSIONS)
    ticks, legs = log["feet"].shape[:2]
    widths = {
        "body": (6,),
        "feet": (legs, 3),
        "contact": (legs,),
        "support": (legs,),
        "command": (3,),
    }
    for name in LOG_DIMENSIONS:
        if log[name].shape != (ticks, *widths.get(name, ())) or not ticks:
            raise RunError(
                f"cannot read {path}: {name!r} has shape {log[name].shape} where there are {ticks} ticks of {legs} legs"
            )
    if log["hash"].dtype != np.uint64:
        raise RunError(f"cannot read {path}: 'hash' must be uint64, got {log['hash'].dtype}")
    for name in ("contact", "support", "step", "mode"):
        if log[name].dtype.kind == "f":
            raise RunError(
                f"cannot read {path}: {name!r} must be whole numbers, got {log[name].dtype}"
            )
    for name in ("t", "body", "feet", "command"):
        if not np.isfinite(log[name]).all():
            raise RunError(f"cannot read {path}: {name!r} has values that are no numbers")
    return log


def read_steps(directory: Path) -> list[dict[str, Any]]:
    """``steps.jsonl``; raises ``RunError``."""
    path = directory / "steps.jsonl"
    try:
        steps = [json.loads(line) for line in path.read_text("utf-8").splitlines()]
    except (OSError, ValueError, RecursionError) as error:
        raise RunError(f"cannot read {path}: {error}") from None
    for number, step in enumerate(steps, 1):
        if (
            not isinstance(step, dict)
            or type(step.get("tick")) is not int
            or not isinstance(step.get("swing"), list)
        ):
            raise RunError(
                f"{path} line {number} is not a step: it needs a tick and the legs that swing"
            )
    return steps


def rerun(directory: Path) -> Iterator[tuple[Simulation, bool]]:
    """Run a recorded run again from its inputs: after every tick the console, and whether its hash
    is the recorded one.
    """
    summary = read_run(directory)
    recorded = read_log(directory)["hash"]
    inputs = list(_recorded_inputs(directory))
    console = Simulation(recorded_world(directory, summary))
    recorder = Recorder(console)
    next_input = 0
    for index in range(len(recorded)):
        while next_input < len(inputs) and inputs[next_input][0] <= index:
            given = inputs[next_input][1]
            if isinstance(given, Command):
                console.order(given)
            else:
                console.request(given)
            next_input += 1
        console.step()
        recorder.note()
        yield console, recorder.hash == int(recorded[index]).to_bytes(8, "little")


def replay(directory: Path) -> dict[str, Any]:
    """Run a recorded run again and compare the state hash of every tick; stops at the first
    difference.
    """
    ticks = 0
    for console, equal in rerun(directory):
        ticks = console.tick_count
        if not equal:
            return {"equal": False, "first_difference": ticks - 1, "t": ticks * TICK}
    return {"equal": True, "ticks": ticks, "state_hash": read_run(directory)["state_hash"]}


def _recorded_inputs(directory: Path) -> Iterator[tuple[int, Any]]:
    path = directory / "inputs.jsonl"
    try:
        lines = path.read_text("utf-8").splitlines()
    except (OSError, ValueError) as error:
        raise RunError(f"cannot read {path}: {error}") from None
    for number, line in enumerate(lines, 1):
        try:
            record = json.loads(line)
            yield int(record["tick"]), input_from(record)
        except (
            ValueError,
            KeyError,
            TypeError,
            AttributeError,
            OverflowError,
            RecursionError,
        ) as error:
            raise RunError(
                f"{path} line {number} is not an input: {type(error).__name__} {error}"
            ) from None
