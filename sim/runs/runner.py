"""Runs without a browser, faster than life: a scenario's timeline, its end, its expectations."""

from __future__ import annotations

import gc
import math
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path, PurePath
from typing import Any

from walking_console.planner.robot.model import as_data
from walking_console.planner.types import TICK, Command, Reason
from walking_console.sim.plants import versions
from walking_console.sim.requests import Halt, TakePosture
from walking_console.sim.runs.metrics import measured
from walking_console.sim.runs.recorder import MODES, SCHEMA, Recorder
from walking_console.sim.runs.run_files import RunError
from walking_console.sim.scenario import Scenario
from walking_console.sim.scenario_tables import Drive
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import World, prepare

BLOCKED_LIMIT = 10.0  # s
PROGRESS_TICKS = 250
AT_GOAL = 1e-9  # m; a distance this little short of its goal has reached it

Progress = Callable[[Simulation, float], None]  # and the share done, 0 to 1
Ending = tuple[str, str]  # result and reason of run.json


@dataclass(frozen=True)
class TimelineEntry:
    """What a timeline gives at a tick: a command, and maybe a posture or a halt."""

    tick: int
    command: Command
    request: TakePosture | Halt | None = None


def timeline(scenario: Scenario) -> list[TimelineEntry]:
    """The drive entries in order; a given trace is one command at its speed; with neither, hold."""
    if scenario.trace is not None:
        return [TimelineEntry(0, Command(0.0, scenario.trace.speed))]
    return [
        TimelineEntry(round(entry.t / TICK), entry.command(), _request(entry))
        for entry in scenario.drive
    ]


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
    again. A keyboard interrupt ends the walk, and what was walked is kept. Raises ``RunError`` when
    the directory cannot be written, and what ``prepare`` raises.

    >>> from walking_console import load_scenario, run_scenario
    >>> summary = run_scenario(load_scenario("flat", ["end={time=10.0}", "expect={}"]))
    >>> summary["result"], summary["steps"], round(summary["distance"], 3)
    ('completed', 4, 0.8)
    """
    summary, recorder = walk_scenario(scenario, explain=explain, progress=progress, world=world)
    if out is not None:
        try:
            Path(out).mkdir(parents=True, exist_ok=True)
            recorder.write(Path(out), summary)
        except OSError as error:
            why = error.strerror
            raise RunError(f"cannot write the run directory {str(out)!r}: {why}") from None
    return summary


def walk_scenario(
    scenario: Scenario,
    *,
    explain: bool = False,
    progress: Progress | None = None,
    world: World | None = None,
) -> tuple[dict[str, Any], Recorder]:
    """As ``run_scenario``, but nothing is written: the summary, and the recorder that could."""
    simulation = Simulation(world or prepare(scenario), explain=explain)
    recorder = Recorder(simulation)
    ending = "interrupted", "interrupted"
    with long_lived_objects_kept():
        try:
            ending = _walk_to_end(simulation, recorder, progress)
        except KeyboardInterrupt:
            pass
    return summarise(simulation, recorder, *ending), recorder


@contextmanager
def long_lived_objects_kept() -> Iterator[None]:
    """While a walk lasts the garbage collector leaves alone what was there before it: a full
    collection took longer than a tick may. Whoever has frozen objects already keeps them so.
    """
    if gc.get_freeze_count():
        yield
        return
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


def _walk_to_end(simulation: Simulation, recorder: Recorder, progress: Progress | None) -> Ending:
    scenario = simulation.world.scenario
    player = TimelinePlayer(simulation, recorder)
    while player.ending is None:
        player.give()
        simulation.step()
        index = player.ticks
        player.note()
        if progress is not None and player.ending is None and index % PROGRESS_TICKS == 0:
            progress(simulation, _share(index / player.ticks_max, simulation.distance, scenario))
    if progress is not None:
        progress(simulation, 1.0)
    return player.ending


class TimelinePlayer:
    """Walks a simulation by its scenario's timeline: ``give`` before every tick, ``note`` after it,
    until there is an ``ending``.
    """

    def __init__(self, simulation: Simulation, recorder: Recorder | None = None) -> None:
        self.simulation = simulation
        self.recorder = recorder or Recorder(simulation)
        self.ticks = 0
        self.ending: Ending | None = None
        self._entries = deque(timeline(simulation.world.scenario))
        self._ends = _Ends(simulation, self._entries[-1].tick if self._entries else 0)

    @property
    def ticks_max(self) -> int:
        """When the timeline ends in any case."""
        return round(self.simulation.world.scenario.time_limit / TICK)

    def give(self) -> None:
        """Order and request what is due."""
        while self._entries and self._entries[0].tick <= self.ticks:
            entry = self._entries.popleft()
            self.simulation.order(entry.command)
            if entry.request is not None:
                self.simulation.request(entry.request)

    def note(self) -> None:
        """Record the tick just run, and whether the walk has ended with it."""
        self.recorder.note()
        self.ending = self._ends.reached(self.ticks)
        self.ticks += 1
        if self.ending is None and self.ticks >= self.ticks_max:
            timed = self.simulation.world.scenario.end.time is not None
            self.ending = ("completed" if timed else "blocked", "time")

    def expectations(self) -> dict[str, dict[str, Any]]:
        """Each expectation of the scenario: wanted, got, pass."""
        return held(self.simulation.world.scenario, _figures(self.simulation, self.recorder))


class _Ends:
    """What ends a walk before its time: a fall, its distance or path walked, being blocked for
    long.
    """

    def __init__(self, simulation: Simulation, last_entry: int) -> None:
        self.simulation = simulation
        self.last_entry = last_entry
        distance = simulation.world.scenario.end.distance
        self.goal = math.inf if distance is None else distance - AT_GOAL
        self.blocked_ticks = 0

    def reached(self, index: int) -> Ending | None:
        """How the walk has ended with the tick just run, None when it goes on."""
        simulation = self.simulation
        if simulation.plant.state == "fallen":
            return "fell", simulation.reason
        if simulation.distance >= self.goal:
            return "completed", "distance"
        blocked = simulation.walk.blocked
        if blocked is None:
            self.blocked_ticks = 0
            return None
        if blocked.reason is Reason.ARRIVED:
            return "completed", blocked.text
        self.blocked_ticks += 1
        if self.blocked_ticks * TICK >= BLOCKED_LIMIT and index >= self.last_entry:
            return "blocked", simulation.reason
        return None


def _share(of_time: float, distance: float, scenario: Scenario) -> float:
    """How much of a run is done, 0 to 1."""
    goal = scenario.end.distance
    return of_time if goal is None else min(1.0, max(of_time, distance / goal))


def summarise(
    simulation: Simulation, recorder: Recorder, result: str, reason: str
) -> dict[str, Any]:
    """``run.json``: what was run, how it ended, and each expectation held against what came."""
    scenario = simulation.world.scenario
    ground = simulation.world.ground
    figures = _figures(simulation, recorder)
    return {
        "schema": SCHEMA,
        "version": product_version(),
        "versions": versions(scenario.plant),
        "plant": scenario.plant,
        "body": scenario.gait.body,
        "scenario": without_folders(scenario),
        "robot": as_data(simulation.world.machine),
        "start_ground": {"kind": ground.kind, "final": ground.final},
        "result": result,
        "reason": reason,
        "ground": ground.note or ground.kind,
        **figures,
        "expect": held(scenario, figures),
        "modes": MODES,
        "state_hash": recorder.state_hash,
    }


def _figures(simulation: Simulation, recorder: Recorder) -> dict[str, Any]:
    """The figures of merit; None where there is nothing to measure."""
    seconds = recorder.ticks * TICK
    margin_min = recorder.margin_min
    return {
        "ticks": recorder.ticks,
        "seconds": seconds,
        "distance": simulation.distance,
        "mean_speed": simulation.distance / seconds if seconds else 0.0,
        "steps": len(recorder.steps),
        "margin_min": margin_min if math.isfinite(margin_min) else None,
        "forbidden_steps": recorder.forbidden_steps,
        "falls": recorder.falls,
        "emergent": dict(sorted(simulation.walk.contacts.counts.items())),
        **measured(simulation, recorder),
    }


def without_folders(scenario: Scenario) -> dict[str, Any]:
    """A scenario as plain data in which files are named without their folders: a run directory goes
    to other machines, and brings robot and ground along.
    """
    data = scenario.as_data()
    if "file" in data["terrain"]:
        data["terrain"]["file"] = PurePath(data["terrain"]["file"]).name
    if isinstance(data["robot"], str):
        data["robot"] = PurePath(data["robot"]).name
    return data


def held(scenario: Scenario, figures: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Each expectation: wanted, got, pass."""
    got = {
        **figures,
        "emergent": sum(figures["emergent"].values()),
        "time": figures["seconds"],
        "margin": figures["margin_min"],
        "polygon_margin": figures.get("polygon_margin_min"),
        "capture_margin": figures.get("capture_margin_min"),
    }
    answer = {}
    for key, wanted in scenario.expect.model_dump(exclude_none=True).items():
        figure, bound = _figure_and_bound(key)
        value = got[figure]
        passed = value is not None and (value >= wanted if bound == "min" else value <= wanted)
        answer[key] = {"wanted": wanted, "got": value, "pass": bool(passed)}
    return answer


def _figure_and_bound(key: str) -> tuple[str, str]:
    """Of an expectation's key: what it is about, its unit included, and min or max."""
    for bound in ("min", "max"):
        before, found, unit = key.partition(f"_{bound}")
        if found:
            return before + unit, bound
    raise KeyError(key)


def succeeded(summary: dict[str, Any]) -> bool:
    """Completed, and every expectation held."""
    expected = all(entry["pass"] for entry in summary["expect"].values())
    return summary["result"] == "completed" and expected


@cache
def product_version() -> str:
    """The installed version."""
    try:
        return version("walking-console")
    except PackageNotFoundError:
        return "0+unknown"
