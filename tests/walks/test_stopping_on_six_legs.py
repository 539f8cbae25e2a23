"""Stopping in mid-step with several feet in the air: a hexapod on sparse footholds, driven as an
undecided hand would.
"""

import random

import pytest

from walking_console.planner.types import Command
from walking_console.sim.scenario_files import load_scenario, scenario_from
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

LOWEST = -0.12  # m; a foot below has missed its foothold


def hexapod(seed: int, fraction: float) -> Simulation:
    terrain = {"kind": "footholds", "fraction": fraction}
    return Simulation(
        prepare(
            scenario_from(
                {
                    "name": "six",
                    "robot": "hexapod",
                    "planner": "trace",
                    "terrain": terrain,
                    "seed": seed,
                },
                None,
            )
        )
    )


@pytest.mark.parametrize("seed", (1, 2))
def test_an_undecided_hand_never_drops_a_hexapod_into_a_hole(seed: int) -> None:
    console, hand = hexapod(seed, 0.1), random.Random(seed)
    command, until = Command(), 0
    for tick in range(1500):
        if tick >= until:
            until = tick + hand.randint(10, 150)
            command = Command(
                hand.uniform(-3.0, 3.0),
                hand.choice((0.0, 0.06, 0.12)),
                hand.choice((0.0, 0.15, -0.15)),
            )
            command = Command() if hand.random() < 0.35 else command
        console.order(command)
        console.step()
        assert min(foot[2] for foot in console.plant.feet) > LOWEST
        assert console.plant.state == "standing"
    assert console.walk.steps_begun > 5


def test_feet_still_in_the_air_when_it_stands_are_not_meant_to_carry() -> None:
    console = hexapod(1, 0.1)
    console.order(Command(speed=0.12))
    while not any(
        console.walk.plan.phases[console.walk.run.tracker.stretch(console.walk.run.t)] == phase
        for phase in (2,)
    ):
        console.step()
    swinging = console.walk.plan.swing
    console.order(Command())
    for _ in range(200):
        console.step()
    assert console.walk.stands and swinging
    carrying = console.walk.carrying()
    assert all(sole for sole, carries in zip(console.plant.soles, carrying, strict=True) if carries)
    assert all(console.plant.soles[leg] or leg in console.walk.stance.lifted for leg in swinging)


def test_a_leg_that_waited_in_the_air_carries_again_once_it_is_set_down() -> None:
    console = Simulation(
        prepare(
            scenario_from(
                {
                    "name": "six",
                    "robot": "hexapod",
                    "planner": "trace",
                    "terrain": {"kind": "footholds", "fraction": 0.02},
                    "seed": 2,
                    "trace": {"kind": "sine"},
                },
                None,
            )
        )
    )
    for _ in range(400):
        console.order(Command(speed=0.1))
        console.step()
        if console.walk.steps and console.walk.stance.lifted:
            break
    assert console.walk.stance.lifted
    for _ in range(150):
        console.order(Command())
        console.step()
    assert console.walk.stands and console.walk.stance.lifted == () and all(console.plant.soles)


def test_a_leg_that_stays_in_the_air_at_the_end_of_a_trace_carries_at_no_tick() -> None:
    simulation = Simulation(load_scenario("k-turn", ["gait.body=sway"]))
    simulation.drive(speed=0.15)
    while not simulation.reason:
        simulation.step()
        for foot, carries in zip(simulation.plant.feet, simulation.walk.carrying(), strict=True):
            assert not carries or foot[2] < 0.05, simulation.tick_count
    assert simulation.reason == "the trace ends here"
    assert max(foot[2] for foot in simulation.plant.feet) > 0.05
