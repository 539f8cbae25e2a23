"""How long the ticks of a walk take: every one of them, not the mean of the easy ones.

Processor time of the thread that walks, since other work on a shared machine must not count. One
measurement gives all figures of a walk: the microseconds of its ticks and how many times faster
than life it is cannot contradict each other.
"""

from __future__ import annotations

import time
from array import array
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from walking_console.planner.types import TICK
from walking_console.sim.runs.runner import TimelinePlayer, long_lived_objects_kept
from walking_console.sim.scenario import ScenarioError
from walking_console.sim.scenario_files import load_scenario, scenario_names
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

SENSINGS = ("known", "eye", "none")
MILLI = 1e3


@dataclass(frozen=True)
class TickTimes:
    """One walk: what was walked, and the processor time of its ticks. Milliseconds but for
    ``factor``, which is simulated time over processor time.
    """

    scenario: str
    planner: str
    plant: str
    sensing: str
    seconds: float | None  # simulated, at which the walk was cut; None: walked to its end
    ticks: int
    distance: float  # m
    prepare: float  # before the first tick
    first: float
    median: float
    p99: float
    p999: float
    largest: float
    per_metre: float | None  # None where it went nowhere
    factor: float

    def as_data(self) -> dict[str, Any]:
        """Plain data for a file, four digits being more than repeat."""
        return {
            key: float(f"{value:.4g}") if isinstance(value, float) else value
            for key, value in asdict(self).items()
        }


def time_walk(name: str, settings: Sequence[str] = (), seconds: float | None = None) -> TickTimes:
    """Walk a shipped scenario, at most so many simulated seconds of it, and time every tick.

    Raises what ``load_scenario`` and ``prepare`` raise.
    """
    scenario = load_scenario(name, settings)
    began = time.thread_time()
    simulation = Simulation(prepare(scenario))
    prepared = time.thread_time() - began
    player = TimelinePlayer(simulation)
    limit = player.ticks_max if seconds is None else round(seconds / TICK)
    with long_lived_objects_kept():
        spent = np.array(_tick_times(player, limit))
    total = float(spent.sum())
    metres = simulation.distance
    median, p99, p999 = (float(part) * MILLI for part in np.percentile(spent, (50, 99, 99.9)))
    return TickTimes(
        name,
        scenario.planner,
        scenario.plant,
        scenario.sensing,
        seconds,
        len(spent),
        metres,
        prepared * MILLI,
        float(spent[0]) * MILLI,
        median,
        p99,
        p999,
        float(spent.max()) * MILLI,
        total * MILLI / metres if metres > 0.01 else None,
        len(spent) * TICK / total,
    )


def _tick_times(player: TimelinePlayer, limit: int) -> array[float]:
    """Seconds of every step of the simulation alone: what watches it is not timed."""
    spent = array("d")
    now = time.thread_time
    while player.ending is None and len(spent) < limit:
        player.give()
        began = now()
        player.simulation.step()
        spent.append(now() - began)
        player.note()
    return spent


def walks_to_time(plants: Sequence[str]) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Every shipped scenario with what it is walked by: the kinematic plant with each kind of
    sensing, other plants with the ground as known.
    """
    for name in scenario_names():
        for sensing in SENSINGS:
            yield name, (f"sensing={sensing}",)
        for plant in plants:
            yield name, ("sensing=known", f"plant={plant}")


def time_walks(
    plants: Sequence[str], seconds: float | None, names: Sequence[str] = ()
) -> Iterator[TickTimes]:
    """Time them all, or those of some scenarios; what a scenario cannot be walked by is left
    out.
    """
    for name, settings in walks_to_time(plants):
        if names and name not in names:
            continue
        try:
            yield time_walk(name, settings, seconds)
        except ScenarioError:
            continue
