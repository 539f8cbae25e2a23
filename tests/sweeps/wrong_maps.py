"""Random wrong maps: a tenth of the holes and a tenth of the blocks are missing from the belief (H
§9).

Run: python -m tests.sweeps.wrong_maps --seeds 200. The result is kept in docs/wrong-maps.md.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np

from tests.sweeps.seams import Watch
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.terrain.traversability import classify
from walking_console.planner.types import TICK, Command, Mode
from walking_console.sim.scenario_files import scenario_from
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import World, prepare

CELL = 0.025  # m
LENGTH = 10.0  # m to walk
TIME = 400.0  # s
SPEED = 0.08  # m/s
STOPPED = 10.0  # s; a walk that has been blocked for as long has stopped
HOLES, BLOCKS = 60, 40  # on 14 m x 6 m
HOLE = (0.10, 0.30)  # m, side from, to
BLOCK = (0.15, 0.40)  # m, side
TOP = (0.05, 0.15)  # m, height of a block
MISSING = 0.1  # share of holes, and of blocks, the map does not show


def ground_and_belief(
    seed: int, shape: tuple[int, int], origin: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """True heights, and heights as believed: some holes and blocks left out of the latter."""
    rng = np.random.default_rng(seed)
    truth, believed = np.zeros(shape), np.zeros(shape)
    for kind, count, sides in (("hole", HOLES, HOLE), ("block", BLOCKS, BLOCK)):
        for _ in range(count):
            x, y = rng.uniform(1.2, LENGTH + 2.0), rng.uniform(-3.0, 3.0)
            width, depth = rng.uniform(*sides, 2)
            height = np.nan if kind == "hole" else rng.uniform(*TOP)
            shown = rng.random() >= MISSING
            rows = slice(
                max(0, round((y - origin[1]) / CELL)), max(0, round((y + depth - origin[1]) / CELL))
            )
            columns = slice(
                max(0, round((x - origin[0]) / CELL)), max(0, round((x + width - origin[0]) / CELL))
            )
            truth[rows, columns] = height
            if shown:
                believed[rows, columns] = height
    return truth, believed


@dataclass(frozen=True)
class Walker:
    """Who walks, and what it has for a map: the wrong one given (``known``), or what an eye sees to
    which the same holes and blocks do not show.
    """

    robot: str
    sensing: str
    mode: str


def base_world(walker: Walker) -> World:
    """Flat ground of the right size."""
    by_planner = {"mode": walker.mode} if walker.robot == "titan3" else {"planner": "trace"}
    scenario = scenario_from(
        {
            "name": "wrong-map",
            "robot": walker.robot,
            "sensing": walker.sensing,
            **by_planner,
            "terrain": {"kind": "rough", "amplitude": 0.0, "cell": CELL},
            "drive": [{"t": 0.0, "speed": SPEED}],
            "end": {"time": TIME, "distance": LENGTH},
        }
    )
    return prepare(scenario)


def begin(seed: int, base: World) -> Simulation:
    """One seed's walk: the true ground for the plant, the wrong one for map and eye."""
    truth, believed = ground_and_belief(seed, base.ground.heights.shape, base.ground.origin)
    machine = base.machine
    shown = replace(base.ground, heights=believed, kind="file")
    forbidden = classify(believed, CELL, machine)
    belief = TerrainMap(believed, forbidden, CELL, shown.origin, machine.foot_radius)
    simulation = Simulation(replace(base, ground=shown, belief=belief, forbidden=forbidden))
    simulation.plant.replace_ground(replace(shown, heights=truth))
    return simulation


@dataclass
class Outcome:
    """How one walk ended; ``hanging`` are feet meant to carry without ground when a step begins."""

    result: str = "time"  # reached | stopped | fell | time
    reason: str = ""
    distance: float = 0.0  # m
    seconds: float = 0.0
    hanging: int = 0
    slide: float = 0.0  # m a standing foot moved, at most
    emergent: dict[str, int] = field(default_factory=dict)


def walk(seed: int, base: World) -> Outcome:
    """Walk one seed to its end."""
    simulation = begin(seed, base)
    simulation.order(Command(0.0, SPEED))
    watch = Watch(simulation)
    outcome = Outcome()
    steps = 0
    stuck = 0
    while outcome.result == "time" and simulation.tick_count * TICK < TIME:
        simulation.step()
        watch.look()
        if simulation.walk.steps_begun != steps:
            steps = simulation.walk.steps_begun
            outcome.hanging += _hanging(simulation)
        stuck = stuck + 1 if simulation.walk.blocked is not None else 0
        if simulation.mode is Mode.FALLEN:
            outcome.result = "fell"
        elif simulation.distance >= LENGTH:
            outcome.result = "reached"
        elif stuck * TICK >= STOPPED:
            outcome.result = "stopped"
    outcome.reason = simulation.reason
    outcome.distance = simulation.distance
    outcome.seconds = simulation.tick_count * TICK
    outcome.slide = watch.told.slide
    outcome.emergent = dict(simulation.walk.contacts.counts)
    return outcome


def _hanging(simulation: Simulation) -> int:
    swing = simulation.walk.plan.swing
    return sum(not on for leg, on in enumerate(simulation.plant.soles) if leg not in swing)


def main() -> None:
    """Sweep and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--mode", default="predictive")
    parser.add_argument("--robot", default="titan3")
    parser.add_argument("--sensing", default="known", choices=("known", "eye"))
    options = parser.parse_args()
    base = base_world(Walker(options.robot, options.sensing, options.mode))
    results: Counter[str] = Counter()
    hanging = 0
    slide = 0.0
    for seed in range(options.first, options.first + options.seeds):
        outcome = walk(seed, base)
        results[outcome.result] += 1
        hanging += outcome.hanging
        slide = max(slide, outcome.slide)
        if outcome.result != "reached" or outcome.hanging:
            print(seed, outcome, flush=True)
        elif seed % 10 == 9:
            print(f"up to seed {seed}: {dict(results)}", flush=True)
    print(dict(results), "hanging feet at step switches:", hanging, f"slide {1000 * slide:.1f} mm")


if __name__ == "__main__":
    main()
