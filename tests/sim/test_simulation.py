"""The simulation without a clock: requests, edits of the ground, pushes, resets."""

import math

import numpy as np
import pytest

from walking_console.planner.stability import MARGIN_SLACK
from walking_console.planner.terrain.traversability import classify
from walking_console.planner.types import Command, Mode
from walking_console.sim.requests import Edit, Load, Push, Reset
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

WALK = Command(0.0, 0.08)


def simulation_on(name="flat", *settings):
    return Simulation(prepare(load_scenario(name, settings)))


def cells_around(simulation, x, y, half):
    ground = simulation.perception.ground
    r0, c0 = ground.cell_at(x - half, y - half)
    r1, c1 = ground.cell_at(x + half, y + half)
    return tuple((r, c) for r in range(r0, r1 + 1) for c in range(c0, c1 + 1))


def run(simulation, ticks):
    for _ in range(ticks):
        simulation.step()
        assert simulation.margins(simulation.walk.carrying())[0] >= -MARGIN_SLACK


def test_a_hole_dug_in_the_way_is_walked_round():
    simulation = simulation_on()
    simulation.order(WALK)
    run(simulation, 100)
    simulation.request(Edit("dig", cells_around(simulation, 1.2, 0.475, 0.1)))
    run(simulation, 1500)
    assert simulation.distance > 1.8, simulation.reason
    assert simulation.mode is not Mode.FALLEN


def test_raised_ground_is_stepped_on_and_its_edges_are_not():
    simulation = simulation_on("rough", "terrain.amplitude=0.0")
    cells = cells_around(simulation, 1.5, 0.0, 0.5)
    simulation.request(Edit("raise", cells, 0.1))
    simulation.order(WALK)
    stood_on_top = False
    for _ in range(18):
        run(simulation, 100)
        standing = [
            foot
            for foot, on in zip(simulation.plant.feet, simulation.plant.soles, strict=True)
            if on
        ]
        stood_on_top = stood_on_top or any(foot[2] == pytest.approx(0.1) for foot in standing)
    assert stood_on_top
    assert simulation.distance > 2.0, simulation.reason


def test_classes_after_an_edit_are_those_of_the_whole_new_ground():
    simulation = simulation_on("rough")
    rng = np.random.default_rng(5)
    for action, amount in (("raise", 0.12), ("dig", 0.0), ("raise", -0.05)):
        x, y = rng.uniform(1.0, 3.0, 2)
        simulation.request(Edit(action, cells_around(simulation, float(x), float(y), 0.2), amount))
        simulation.step()
    whole = classify(
        simulation.perception.ground.heights,
        simulation.perception.ground.cell,
        simulation.world.machine,
    )
    assert (whole == simulation.perception.true_forbidden).all()


def test_forbidden_cells_stay_forbidden_until_they_are_cleared():
    simulation = simulation_on()
    cells = cells_around(simulation, 2.0, 0.0, 0.1)
    simulation.request(Edit("forbid", cells))
    simulation.request(Edit("raise", cells_around(simulation, 2.0, 0.3, 0.1), 0.05))
    simulation.step()
    assert all(simulation.perception.belief.forbidden[cell] for cell in cells)
    simulation.request(Edit("clear", cells))
    simulation.request(Edit("raise", cells_around(simulation, 2.0, 0.3, 0.1), -0.05))
    simulation.step()
    assert not any(simulation.perception.belief.forbidden[cell] for cell in cells)


@pytest.mark.parametrize(
    ("edit", "said"),
    [
        (
            Edit("melt", ((0, 0),)),
            "unknown terrain edit 'melt'; there are: dig, raise, forbid, clear",
        ),
        (Edit("dig", ((10**6, 0),)), "cells must be within"),
        (Edit("raise", ((0, 0),), 999.0), "heights must be within 100 m"),
    ],
)
def test_an_edit_that_cannot_be_is_refused_whole(edit, said):
    simulation = simulation_on()
    before = simulation.perception.ground.heights.copy()
    simulation.request(edit)
    simulation.step()
    assert said in simulation.refused
    assert np.array_equal(before, simulation.perception.ground.heights, equal_nan=True)


def test_a_reset_begins_again_and_a_load_changes_the_world():
    simulation = simulation_on()
    simulation.order(WALK)
    run(simulation, 200)
    simulation.request(Reset())
    simulation.step()
    assert simulation.tick_count == 1 and simulation.distance == 0.0 and simulation.command.holds
    simulation.request(Load(prepare(load_scenario("stairs-up"))))
    simulation.step()
    assert simulation.snapshot().scenario == "stairs-up"


def test_a_push_that_friction_holds_moves_nothing_and_a_great_one_tips_the_machine():
    simulation = simulation_on()
    run(simulation, 5)
    simulation.request(Push(50.0, 0.0, 10))
    x = simulation.plant.body[0]
    run(simulation, 20)
    assert simulation.plant.body[0] == pytest.approx(x, abs=1e-6)
    simulation.request(Push(0.0, 3000.0, 60))
    for _ in range(200):
        simulation.step()
    assert simulation.mode is Mode.FALLEN
    assert "fallen" in simulation.reason


def test_the_same_orders_give_the_same_world_to_the_last_bit():
    def walked():
        simulation = simulation_on("dem")
        rng = np.random.default_rng(9)
        states = []
        for tick in range(1500):
            if tick % 75 == 0:
                simulation.order(
                    Command(float(rng.uniform(-math.pi, math.pi)), float(rng.uniform(0.0, 0.1)))
                )
            simulation.step()
            states.append(
                (*simulation.plant.body, *(v for foot in simulation.plant.feet for v in foot))
            )
        return states

    assert walked() == walked()


def test_a_snapshot_cannot_be_changed_and_does_not_change():
    simulation = simulation_on()
    simulation.order(WALK)
    run(simulation, 100)
    snapshot = simulation.snapshot()
    body = snapshot.body
    run(simulation, 50)
    assert snapshot.body == body
    with pytest.raises(ValueError, match="read-only"):
        snapshot.terrain.forbidden[0, 0] = True


def test_requests_that_come_while_others_are_served_wait_for_the_next_step() -> None:
    simulation = Simulation(load_scenario("flat"))
    served = []

    def ask_again(tick: int, given: object) -> None:
        served.append(tick)
        simulation.request(Edit("raise", ((3, 3),), 0.01))

    simulation.on_input = ask_again
    simulation.request(Edit("raise", ((3, 3),), 0.01))
    for _ in range(3):
        simulation.step()
    assert served == [0, 1, 2]
    assert simulation.requests_waiting == 1
