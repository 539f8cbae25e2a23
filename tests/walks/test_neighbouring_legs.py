"""Six legs whose reach overlaps: they never cross, and their feet keep two radii apart."""

from __future__ import annotations

import math
import tomllib
from importlib import resources
from itertools import combinations

import pytest

from walking_console.planner.geometry.transforms import placed
from walking_console.sim.scenario_files import scenario_from
from walking_console.sim.simulation import Simulation


def overlapping(by: float) -> dict[str, object]:
    """The hexapod with rectangles so many metres wider to the front and to the rear."""
    file = resources.files("walking_console.planner.robot") / "descriptions" / "hexapod.toml"
    machine = tomllib.loads(file.read_text("utf-8"))
    del machine["chain"], machine["masses"]  # fitted to the boxes
    for leg in machine["legs"]:
        leg["x"] = [leg["x"][0] - by, leg["x"][1] + by]
        del leg["hip"]
        leg.pop("chain", None)
    return machine


def side(a, b, p) -> float:
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])


def cross(a, b, c, d) -> bool:
    return side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0


@pytest.mark.parametrize("by", [0.1, 0.25])
@pytest.mark.parametrize("fraction", [0.1, 0.04])
def test_legs_whose_reach_overlaps_neither_cross_nor_touch(by: float, fraction: float) -> None:
    scenario = scenario_from(
        {
            "name": "overlap",
            "robot": overlapping(by),
            "planner": "trace",
            "seed": 1,
            "terrain": {"kind": "footholds", "fraction": fraction},
            "trace": {"kind": "sine", "distance": 5.0, "speed": 0.15},
        }
    )
    simulation = Simulation(scenario)
    simulation.drive(speed=0.15)
    hips = simulation.world.machine.hips
    apart = 2 * simulation.world.machine.foot_radius - 1e-6
    for _ in range(1500):
        simulation.step()
        x, y, _, _, _, yaw = simulation.plant.body
        feet = simulation.plant.feet
        lines = [
            (placed((x, y, yaw), *hip), (foot[0], foot[1]))
            for hip, foot in zip(hips, feet, strict=True)
        ]
        for a, b in combinations(range(6), 2):
            assert not cross(*lines[a], *lines[b]), (simulation.tick_count, a + 1, b + 1)
            soles = simulation.plant.soles
            if soles[a] and soles[b]:
                assert math.dist(lines[a][1], lines[b][1]) >= apart
    assert simulation.distance > 2.0
