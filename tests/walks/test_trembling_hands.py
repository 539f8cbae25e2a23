"""A hand that trembles at the critical angle walks as far as a steady one, on every machine."""

from __future__ import annotations

import math
import random
import runpy
from dataclasses import replace
from pathlib import Path

import pytest

from walking_console.planner.robot.model import Leg, Machine, as_data, load_machine
from walking_console.server.toml_text import toml
from walking_console.sim.runs.runner import run_scenario, succeeded
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation

FIXTURES = Path(__file__).parents[1] / "fixtures"
MAKE = FIXTURES / "tremor-at-the-diagonal" / "make.py"
DOG = FIXTURES / "robot-option-and-folders" / "robots" / "dog.toml"
SECONDS = 60.0


def half_size(machine: Machine) -> Machine:
    """The machine with every length halved, its reach boxes without joints."""

    def half(pair: tuple[float, float]) -> tuple[float, float]:
        return pair[0] / 2, pair[1] / 2

    legs = tuple(Leg(leg.name, half(leg.x), half(leg.y), half(leg.z)) for leg in machine.legs)
    lengths = ("height", "foot_radius", "yaw_length", "lift_up", "lift_down")
    halved = {name: getattr(machine, name) / 2 for name in lengths}
    triples = ("torso", "speed", "overreach")
    halves = {name: tuple(v / 2 for v in getattr(machine, name)) for name in triples}
    bare = {"name": "small", "card_chains": (), "card_masses": None}
    return replace(machine, legs=legs, **halved, **halves, **bare)


def walked(machine: Machine, speed: float, hand: list[float]) -> tuple[float, float]:
    """m walked on level ground and the least margin, m, when the hand says an angle every 0.05 s;
    it begins in the layout of the first one.
    """
    first = f"{{crab_angle_deg={math.degrees(hand[0])},speed={speed}}}"
    robot = toml({"robot": as_data(machine)}).strip()
    settings = (robot, f"drive=[{first}]", f"end={{time={SECONDS}}}", "expect={}")
    simulation = Simulation(load_scenario("flat", settings))
    least = math.inf
    for tick in range(int(SECONDS / 0.02)):
        said = math.floor(tick * 0.02 / 0.05 + 1e-6)
        simulation.drive(hand[min(said, len(hand) - 1)], speed)
        simulation.step()
        least = min(least, simulation.snapshot().margin)
    return simulation.distance, least


MACHINES = [
    (load_machine("titan3"), 0.08),
    (load_machine(str(DOG)), 0.06),
    (half_size(load_machine("titan3")), 0.04),
]


@pytest.mark.parametrize(("machine", "speed"), MACHINES, ids=["titan3", "dog", "small"])
def test_a_tremor_of_one_degree_costs_at_most_3_percent_and_half_the_margin(
    machine: Machine, speed: float
) -> None:
    chance = random.Random(11)
    middle = machine.critical_angle
    hand = [middle + math.radians(chance.gauss(0.0, 1.0)) for _ in range(int(SECONDS / 0.05))]
    steady, kept = walked(machine, speed, [middle])
    distance, margin = walked(machine, speed, hand)
    assert distance >= 0.97 * steady
    assert margin >= 0.5 * kept


@pytest.mark.parametrize(("body", "least"), [("straight", 9.3), ("sway", 8.8)])
def test_the_reported_hand_walks_as_far_as_a_steady_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, body: str, least: float
) -> None:
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(MAKE))
    settings = (f'gait.body="{body}"', f"expect.distance_min={least}")
    summary = run_scenario(load_scenario("s.toml", settings))
    assert succeeded(summary), summary["expect"]
