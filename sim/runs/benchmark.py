"""Speed of the planner, of Level C, of the whole tick and of headless runs on this machine: medians
of processor time.

Processor time, since other work on a shared machine must not count; on an idle one it is the time
on the clock.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

from walking_console.planner.config import Gains
from walking_console.planner.control.foot_controller import ReflexState, reflex
from walking_console.planner.control.tracking import TrajectoryTracker
from walking_console.planner.protocols import Planner, PlannerSetup, run_to_completion
from walking_console.planner.registry import make_planner
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import TICK, Blocked, Command, Sensing, Stance, StepPlan
from walking_console.sim.runs.recorder import Recorder
from walking_console.sim.runs.runner import product_version, run_scenario
from walking_console.sim.runs.tick_times import TickTimes
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import World, prepare

TICKS = 2500  # a round: four metres, the whole course of scenario flat
ROUNDS = 7  # medians are taken over this many rounds
COMMAND = Command(0.0, 0.08)


def measure() -> dict[str, Any]:
    """All figures: name → {value, unit, target}. Targets are of the product's own specification."""
    micro = "µs"
    real = "x real time"
    # of one tick both: µs and factor of the same walk cannot contradict each other
    plain = tick_time(recorded=False)
    recorded = tick_time(recorded=True)
    return {
        **_made_with(),
        "figures": {
            "plan_step, crab, paper, 50 % of 5 cm cells forbidden": _figure(
                plan_time() * 1e6, micro, "<= 100"
            ),
            "Level C tick, four legs": _figure(reflex_time() * 1e6, micro, "<= 15"),
            "headless tick, not recorded": _figure(plain * 1e6, micro, "<= 60"),
            "headless tick, recorded": _figure(recorded * 1e6, micro, "<= 100"),
            "headless speed, not recorded": _figure(TICK / plain, real, ">= 330"),
            "headless speed, recorded": _figure(TICK / recorded, real, ">= 200"),
            "whole run of scenario flat with its files": _figure(run_speed(), real, ""),
            "start-up of the command line": _figure(start_up() * 1e3, "ms", ""),
        },
    }


def measured_walks(times: Iterable[TickTimes]) -> dict[str, Any]:
    """Walks that were timed, as plain data for a file and for ``comparison``."""
    return {**_made_with(), "walks": [walk.as_data() for walk in times]}


def _made_with() -> dict[str, Any]:
    return {"version": product_version(), "python": platform.python_version()}


def _figure(value: float, unit: str, target: str) -> dict[str, Any]:
    return {"value": round(value, 2), "unit": unit, "target": target}


def _median_of(work: Callable[[], int]) -> float:
    """Median over rounds of seconds per unit of work; ``work`` answers how many units it did."""
    spent = []
    for _ in range(ROUNDS):
        began = process_time()
        units = work()
        spent.append((process_time() - began) / units)
    return median(spent)


def plan_time() -> float:
    """Seconds per step planned on ground with half of its 5 cm cells forbidden: median over
    postures met walking there.
    """
    planner, ground, stances = broken_ground()
    spent = []
    for _ in range(ROUNDS):
        for stance in stances:
            began = process_time()
            run_to_completion(planner.plan(stance, COMMAND, ground))
            spent.append(process_time() - began)
    return median(spent)


def broken_ground() -> tuple[Planner, TerrainMap, list[Stance]]:
    """The planner of scenario ``holes``, its ground at 50 %, the postures its first steps meet."""
    world = prepare(load_scenario("holes", ("terrain.fraction=0.5", "terrain.cell=0.05")))
    planner = planner_in(world)
    ground = world.belief
    stances = []
    stance = world.stance
    for _ in range(60):
        plan = run_to_completion(planner.plan(stance, COMMAND, ground))
        if isinstance(plan, Blocked):
            break
        stances.append(stance)
        stance = plan.end
    return planner, ground, stances or [world.stance]


def planner_in(world: World) -> Planner:
    """The planner of a world as the paper has it: step by step, without detours."""
    setup = PlannerSetup(world.machine, world.gait, "paper")
    return make_planner(world.scenario.planner, setup)


def reflex_time() -> float:
    """Seconds per Level C tick of four legs in mid-step."""
    world = prepare(load_scenario("flat"))
    stance = world.stance
    plan = run_to_completion(planner_in(world).plan(stance, COMMAND, world.belief))
    if not isinstance(plan, StepPlan):
        raise RuntimeError(f"no first step on flat ground: {plan.text}")
    x, y, z, yaw = plan.end.body
    feet = tuple((fx - x, fy - y, fz - z) for fx, fy, fz in stance.feet)
    sensing = Sensing(0, (x, y, z, 0.0, 0.0, yaw), feet, (True,) * 4, (0,) * 4, (False,) * 4)
    tracker = TrajectoryTracker(plan)
    gains = Gains()
    state = ReflexState.begin(4)
    ticks = int(tracker.duration / TICK)

    def work() -> int:
        for _ in range(5):
            for k in range(ticks):
                reflex(tracker, k * TICK, sensing, state, gains, TICK)
        return 5 * ticks

    return _median_of(work)


def tick_time(*, recorded: bool) -> float:
    """Seconds per whole headless tick on flat ground, as scenario ``flat`` walks by default."""
    world = prepare(load_scenario("flat"))
    spent = []
    for _ in range(ROUNDS):
        simulation = Simulation(world)
        recorder = Recorder(simulation) if recorded else None
        simulation.order(COMMAND)
        began = process_time()
        for _ in range(TICKS):
            simulation.step()
            if recorder is not None:
                recorder.note()
        spent.append((process_time() - began) / TICKS)
    return median(spent)


def start_up() -> float:
    """Seconds until the command line has said what it can do; 0 where the system does not tell the
    processor time of children.
    """
    spent = []
    for _ in range(min(ROUNDS, 3)):
        before = os.times()
        subprocess.run(
            [sys.executable, "-m", "walking_console", "--help"],
            stdout=subprocess.DEVNULL,
            check=True,
        )
        now = os.times()
        user = now.children_user - before.children_user
        spent.append(user + now.children_system - before.children_system)
    return median(spent)


def run_speed() -> float:
    """Simulated seconds per second of a whole run of ``flat``, set-up and files included."""
    scenario = load_scenario("flat")

    def work() -> int:
        with tempfile.TemporaryDirectory() as folder:
            return int(run_scenario(scenario, Path(folder))["ticks"])

    return TICK / _median_of(work)
