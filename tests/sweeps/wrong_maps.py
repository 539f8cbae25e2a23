"""Random wrong maps: a tenth of the holes and a tenth of the blocks are missing from the belief (H
§9).

Run: python -m tests.sweeps.wrong_maps --seeds 200. The result is kept in docs/wrong-maps.md.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import replace

import numpy as np

from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.terrain.traversability import classify
from walking_console.planner.types import TICK, Command, Mode
from walking_console.sim.scenario_files import scenario_from
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import World, prepare

CELL = 0.025  # m
LENGTH = 10.0  # m to walk
TIME = 400.0  # s
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


def world(seed: int, base: World, mode: str) -> World:
    """One seed's world: the true ground for the plant, the wrong map for the planner."""
    truth, believed = ground_and_belief(seed, base.ground.heights.shape, base.ground.origin)
    ground = replace(base.ground, heights=truth, kind="file")
    belief = TerrainMap(
        believed,
        classify(believed, CELL, base.machine),
        CELL,
        ground.origin,
        base.machine.foot_radius,
    )
    return replace(
        base, ground=ground, belief=belief, forbidden=classify(truth, CELL, base.machine)
    )


def base_world(mode: str) -> World:
    """Flat ground of the right size."""
    scenario = scenario_from(
        {
            "name": "wrong-map",
            "mode": mode,
            "terrain": {"kind": "rough", "amplitude": 0.0, "cell": CELL},
            "drive": [{"t": 0.0, "speed": 0.08}],
            "end": {"time": TIME, "distance": LENGTH},
        }
    )
    return prepare(scenario)


def walk(seed: int, base: World, mode: str) -> dict[str, object]:
    """Walk one seed to its end; hanging feet are those meant to carry but without ground when a
    step begins.
    """
    console = Simulation(world(seed, base, mode))
    console.order(Command(0.0, 0.08))
    hanging, steps, stuck = 0, 0, 0
    for _ in range(round(TIME / TICK)):
        console.step()
        if console.mode is Mode.FALLEN:
            return {
                "result": "fell",
                "distance": console.distance,
                "hanging": hanging,
                "emergent": console.walk.contacts.counts,
            }
        if console.walk.steps_begun != steps:
            steps = console.walk.steps_begun
            swing = console.walk.plan.swing
            hanging += sum(
                not sole for leg, sole in enumerate(console.plant.soles) if leg not in swing
            )
        if console.distance >= LENGTH:
            return {
                "result": "reached",
                "distance": console.distance,
                "hanging": hanging,
                "emergent": console.walk.contacts.counts,
            }
        stuck = stuck + 1 if console.walk.blocked is not None else 0
        if stuck * TICK >= 10.0:
            return {
                "result": "stopped",
                "reason": console.reason,
                "distance": console.distance,
                "hanging": hanging,
                "emergent": console.walk.contacts.counts,
            }
    return {
        "result": "time",
        "distance": console.distance,
        "hanging": hanging,
        "emergent": console.walk.contacts.counts,
    }


def main() -> None:
    """Sweep and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--mode", default="predictive")
    options = parser.parse_args()
    base = base_world(options.mode)
    results: Counter[str] = Counter()
    hanging = 0
    for seed in range(options.first, options.first + options.seeds):
        outcome = walk(seed, base, options.mode)
        results[str(outcome["result"])] += 1
        hanging += int(outcome["hanging"])  # type: ignore[call-overload]
        if outcome["result"] != "reached" or outcome["hanging"]:
            print(seed, outcome, flush=True)
        elif seed % 10 == 9:
            print(f"up to seed {seed}: {dict(results)}", flush=True)
    print(dict(results), "hanging feet at step switches:", hanging)


if __name__ == "__main__":
    main()
