"""Feet in the air, and what stops them."""

import math
from dataclasses import replace

import pytest

from tests.sim.kinematic.machines import TITAN, made, one_leg, run, shaped, standing
from walking_console.sim.kinematic.configuration import STEP_UP
from walking_console.sim.kinematic.swing_feet import overhang
from walking_console.sim.terrain.generators import Obstacle


def test_a_foot_stops_on_the_ground_of_its_cell():
    plant = standing(ground=made("rough"), up={0: 0.05}, x=-0.1, y=-0.1)
    run(plant, one_leg(0, (0.0, 0.0, -0.7)), 10)
    assert plant.feet[0][2] == plant.q.ground.height_at(*plant.feet[0][:2])
    assert plant.soles[0]


def test_on_a_slope_a_foot_comes_down_where_the_slope_is_between_the_middles_of_cells():
    slope = shaped(lambda x, y: 0.2 * x)
    for aside in (0.0, 0.012, 0.024):
        plant = standing(ground=slope, up={0: 0.05}, x=-0.1, y=-0.1)
        run(plant, one_leg(0, (aside / 0.02, 0.0, 0.0)), 1)
        run(plant, one_leg(0, (0.0, 0.0, -0.5)), 10)
        assert plant.soles[0]
        assert plant.feet[0][2] == pytest.approx(0.2 * plant.feet[0][0], abs=1e-9)


def test_a_riser_stops_a_foot_on_its_way_and_its_whiskers_say_where():
    plant = standing(
        ground=shaped(lambda x, y: 0.2 if x > 0.55 else 0.0), up={0: 0.1}, x=-0.1, y=-0.1
    )
    run(plant, one_leg(0, (0.5, 0.0, 0.0)), 20)
    assert 0.549 < plant.feet[0][0] <= 0.55
    assert plant.whiskers[0] == 1  # ahead
    assert plant.feet[0][2] == pytest.approx(0.1)
    run(plant, one_leg(0, (0.0, 0.0, 0.8)), 8)
    run(plant, one_leg(0, (0.5, 0.0, 0.0)), 4)
    assert plant.feet[0][0] == pytest.approx(0.59, abs=0.002)  # over it
    assert plant.whiskers[0] == 0


@pytest.mark.parametrize("aside", [-0.49, -0.2, 0.0, 0.2, 0.49])
@pytest.mark.parametrize("cells", [1, 2])
def test_a_sole_hangs_over_all_of_the_cell_before_a_drop_as_the_map_has_it_and_no_other(
    aside, cells
):
    ground = shaped(lambda x, y: -0.2 if x > 0.5 else 0.0)
    row, column = ground.cell_at(0.5 - 1e-6, 0.3)
    x = ground.centre(row, column + 1 - cells)[0] + aside * ground.cell
    assert (overhang(ground, 1.2 * ground.cell, 0.2, (x, 0.3, 0.0)) != 0) is (cells == 1)


def test_whiskers_do_not_feel_what_a_foot_has_just_come_down_on():
    top = Obstacle(0.45, 0.475, 0.0, 0.1, radius=0.3)
    plant = standing(ground=shaped(lambda x, y: 0.1 if x > 0.2 and y > 0.2 else 0.0), up={0: 0.05})
    plant.replace_ground(replace(plant.q.ground, obstacles=(top,)))
    run(plant, one_leg(0, (0.0, 0.0, -0.79)), 6)
    assert plant.soles[0] and plant.whiskers[0] == 0


def test_a_low_riser_is_ridden_over():
    plant = standing(
        ground=shaped(lambda x, y: 0.008 if x > 0.55 else 0.0), up={0: 0.002}, x=-0.1, y=-0.1
    )
    run(plant, one_leg(0, (0.5, 0.0, 0.0)), 15)
    assert plant.feet[0][:] == pytest.approx([0.60, 0.475, 0.008])
    assert STEP_UP > 0.008


def test_a_foot_over_a_hole_finds_no_ground():
    plant = standing(
        ground=shaped(lambda x, y: math.nan if x > 0.2 and y > 0.2 else 0.0), x=-0.1, y=-0.1
    )
    assert plant.soles == [False, True, True, True]
    run(plant, one_leg(0, (0.0, 0.0, -0.8)), 30)
    assert not plant.soles[0]
    assert plant.feet[0][2] == pytest.approx(TITAN.legs[0].z[0] - TITAN.overreach[2] + TITAN.height)
