"""The console without a loop: requests, edits of the ground, pushes, resets."""

import math

import numpy as np
import pytest

from walking_console.planner.stability import MARGIN_SLACK
from walking_console.planner.terrain.traversability import classify
from walking_console.planner.types import Command, Mode
from walking_console.sim.requests import Edit, Load, Push, Reset
from walking_console.sim.scenario import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

WALK = Command(0.0, 0.08)


def console_on(name="flat", *settings):
    return Simulation(prepare(load_scenario(name, settings)))


def cells_around(console, x, y, half):
    ground = console.perception.ground
    r0, c0 = ground.cell_at(x - half, y - half)
    r1, c1 = ground.cell_at(x + half, y + half)
    return tuple((r, c) for r in range(r0, r1 + 1) for c in range(c0, c1 + 1))


def run(console, ticks):
    for _ in range(ticks):
        console.step()
        assert console.margins(console.walk.carrying())[0] >= -MARGIN_SLACK


def test_a_hole_dug_in_the_way_is_walked_round():
    console = console_on()
    console.order(WALK)
    run(console, 100)
    console.request(Edit("dig", cells_around(console, 1.2, 0.475, 0.1)))
    run(console, 1500)
    assert console.distance > 1.8, console.reason
    assert console.mode is not Mode.FALLEN


def test_raised_ground_is_stepped_on_and_its_edges_are_not():
    console = console_on("rough", "terrain.amplitude=0.0")
    cells = cells_around(console, 1.5, 0.0, 0.5)
    console.request(Edit("raise", cells, 0.1))
    console.order(WALK)
    stood_on_top = False
    for _ in range(18):
        run(console, 100)
        standing = [
            foot for foot, on in zip(console.plant.feet, console.plant.soles, strict=True) if on
        ]
        stood_on_top = stood_on_top or any(foot[2] == pytest.approx(0.1) for foot in standing)
    assert stood_on_top
    assert console.distance > 2.0, console.reason


def test_classes_after_an_edit_are_those_of_the_whole_new_ground():
    console = console_on("rough")
    rng = np.random.default_rng(5)
    for action, amount in (("raise", 0.12), ("dig", 0.0), ("raise", -0.05)):
        x, y = rng.uniform(1.0, 3.0, 2)
        console.request(Edit(action, cells_around(console, float(x), float(y), 0.2), amount))
        console.step()
    whole = classify(
        console.perception.ground.heights, console.perception.ground.cell, console.world.machine
    )
    assert (whole == console.perception.true_forbidden).all()


def test_forbidden_cells_stay_forbidden_until_they_are_cleared():
    console = console_on()
    cells = cells_around(console, 2.0, 0.0, 0.1)
    console.request(Edit("forbid", cells))
    console.request(Edit("raise", cells_around(console, 2.0, 0.3, 0.1), 0.05))
    console.step()
    assert all(console.perception.belief.forbidden[cell] for cell in cells)
    console.request(Edit("clear", cells))
    console.request(Edit("raise", cells_around(console, 2.0, 0.3, 0.1), -0.05))
    console.step()
    assert not any(console.perception.belief.forbidden[cell] for cell in cells)


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
    console = console_on()
    before = console.perception.ground.heights.copy()
    console.request(edit)
    console.step()
    assert said in console.refused
    assert np.array_equal(before, console.perception.ground.heights, equal_nan=True)


def test_a_reset_begins_again_and_a_load_changes_the_world():
    console = console_on()
    console.order(WALK)
    run(console, 200)
    console.request(Reset())
    console.step()
    assert console.tick_count == 1 and console.distance == 0.0 and console.command.holds
    console.request(Load(prepare(load_scenario("stairs-up"))))
    console.step()
    assert console.snapshot().scenario == "stairs-up"


def test_a_push_that_friction_holds_moves_nothing_and_a_great_one_tips_the_machine():
    console = console_on()
    run(console, 5)
    console.request(Push(50.0, 0.0, 10))
    x = console.plant.body[0]
    run(console, 20)
    assert console.plant.body[0] == pytest.approx(x, abs=1e-6)
    console.request(Push(0.0, 3000.0, 60))
    for _ in range(200):
        console.step()
    assert console.mode is Mode.FALLEN
    assert "fallen" in console.reason


def test_the_same_orders_give_the_same_world_to_the_last_bit():
    def walked():
        console = console_on("dem")
        rng = np.random.default_rng(9)
        states = []
        for tick in range(1500):
            if tick % 75 == 0:
                console.order(
                    Command(float(rng.uniform(-math.pi, math.pi)), float(rng.uniform(0.0, 0.1)))
                )
            console.step()
            states.append((*console.plant.body, *(v for foot in console.plant.feet for v in foot)))
        return states

    assert walked() == walked()


def test_a_snapshot_cannot_be_changed_and_does_not_change():
    console = console_on()
    console.order(WALK)
    run(console, 100)
    snapshot = console.snapshot()
    body = snapshot.body
    run(console, 50)
    assert snapshot.body == body
    with pytest.raises(ValueError, match="read-only"):
        snapshot.terrain.forbidden[0, 0] = True
