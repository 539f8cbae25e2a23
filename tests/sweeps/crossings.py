"""Six legs whose reach overlaps, on sparse footholds: do they cross, and how near do feet come?

Run: python -m tests.sweeps.crossings --seeds 150. A walk a seed for each of two overlaps and two
shares of cells that may be stepped on; the result is kept in docs/trace-walker.md.
"""

from __future__ import annotations

import argparse
import math
import tomllib
from dataclasses import dataclass
from importlib import resources
from itertools import combinations, product
from typing import Any

from walking_console.planner.geometry.transforms import XY, placed
from walking_console.sim.scenario_files import scenario_from
from walking_console.sim.simulation import Simulation

TICKS = 1500
OVERLAPS = (0.1, 0.25)  # m by which rectangles are wider to the front and to the rear
FRACTIONS = (0.1, 0.04)


def overlapping(by: float) -> dict[str, Any]:
    """The hexapod with rectangles so many metres wider to the front and to the rear."""
    file = resources.files("walking_console.planner.robot") / "descriptions" / "hexapod.toml"
    machine = tomllib.loads(file.read_text("utf-8"))
    del machine["chain"], machine["masses"]  # fitted to the boxes
    for leg in machine["legs"]:
        leg["x"] = [leg["x"][0] - by, leg["x"][1] + by]
        del leg["hip"]
        leg.pop("chain", None)
    return machine


def side(a: XY, b: XY, p: XY) -> float:
    """On which side of the way from a to b a point lies, times its length, m²."""
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])


def cross(a: XY, b: XY, c: XY, d: XY) -> bool:
    """True when the segments a–b and c–d cross."""
    return side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0


@dataclass
class Told:
    """One walk: ticks in which two legs crossed, and how near two standing feet came to each other
    beyond two radii, m.
    """

    crossed: int = 0
    apart: float = math.inf
    distance: float = 0.0


def walk(by: float, fraction: float, seed: int) -> Told:
    """Thirty seconds of one machine on one field."""
    scenario = scenario_from(
        {
            "name": "overlap",
            "robot": overlapping(by),
            "planner": "trace",
            "seed": seed,
            "terrain": {"kind": "footholds", "fraction": fraction},
            "trace": {"kind": "sine", "distance": 5.0, "speed": 0.15},
        }
    )
    simulation = Simulation(scenario)
    simulation.drive(speed=0.15)
    told = Told()
    for _ in range(TICKS):
        simulation.step()
        look(simulation, told)
    told.distance = simulation.distance
    return told


def look(simulation: Simulation, told: Told) -> None:
    """One tick."""
    machine = simulation.world.machine
    plant = simulation.plant
    x, y, _, _, _, yaw = plant.body
    lines = [
        (placed((x, y, yaw), *hip), (foot[0], foot[1]))
        for hip, foot in zip(machine.hips, plant.feet, strict=True)
    ]
    pairs = list(combinations(range(len(lines)), 2))
    told.crossed += any(cross(*lines[a], *lines[b]) for a, b in pairs)
    for a, b in pairs:
        if plant.soles[a] and plant.soles[b]:
            apart = math.dist(lines[a][1], lines[b][1]) - 2 * machine.foot_radius
            told.apart = min(told.apart, apart)


def main() -> None:
    """Walk all and print those that cross, then one line of all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=150)
    parser.add_argument("--first", type=int, default=0)
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.seeds)
    walks = 0
    bad = 0
    nearest = math.inf
    distance = 0.0
    for seed, by, fraction in product(seeds, OVERLAPS, FRACTIONS):
        told = walk(by, fraction, seed)
        walks += 1
        distance += told.distance
        nearest = min(nearest, told.apart)
        if told.crossed or told.apart < -1e-6:
            bad += 1
            print(by, fraction, seed, told, flush=True)
        elif walks % 40 == 0:
            print(f"{walks} walks, {bad} bad, nearest {1000 * nearest:.1f} mm", flush=True)
    mean = distance / max(1, walks)
    print(f"{walks} walks of {mean:.2f} m: {bad} bad, {1000 * nearest:.1f} mm apart at least")


if __name__ == "__main__":
    main()
