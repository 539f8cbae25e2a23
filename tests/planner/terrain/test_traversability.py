"""From heights to the cells a machine may not step on."""

import math

import numpy as np
import pytest

from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.traversability import (
    Kind,
    classify,
    classify_again,
    kinds,
    kinds_within,
)

MACHINE = load_machine("titan3")
CELL = 0.025


def hills(seed, shape=(80, 120)):
    rng = np.random.default_rng(seed)
    y, x = np.indices(shape) * CELL
    heights = 0.1 * np.sin(3 * x + rng.uniform(0, 6)) * np.cos(2 * y + rng.uniform(0, 6))
    r, c = int(rng.integers(10, 60)), int(rng.integers(10, 100))
    heights[r : r + 12, c : c + 12] += 0.15  # a block
    heights[5:11, 70:76] = np.nan  # a hole
    heights[60:64, 20:24] += 0.8  # a pole
    return heights


def test_level_ground_is_walkable_and_a_hole_is_not_nor_its_rim_within_the_sole():
    heights = np.zeros((40, 40))
    heights[20, 20] = np.nan
    forbidden = classify(heights, 0.025, MACHINE)
    # sole radius 0.03 m reaches one cell on
    assert forbidden[20, 20] and forbidden[19, 20] and forbidden[20, 21]
    assert not forbidden[18, 20] and not forbidden[0, 0]


@pytest.mark.parametrize(
    ("degrees", "walkable"), [(0, True), (15, True), (25, True), (37, False), (60, False)]
)
def test_slopes_over_35_degrees_are_holes(degrees, walkable):
    x = (np.arange(80) + 0.5) * 0.025
    heights = np.tile(x * math.tan(math.radians(degrees)), (80, 1))
    assert bool(classify(heights, 0.025, MACHINE)[40, 40]) is not walkable


def test_the_edge_of_a_step_is_forbidden_and_its_top_is_not():
    heights = np.zeros((80, 80))
    heights[:, 40:] = 0.15
    forbidden = classify(heights, 0.025, MACHINE)
    assert forbidden[40, 39] and forbidden[40, 40]
    assert not forbidden[40, 37] and not forbidden[40, 42]


def test_a_pole_too_tall_to_step_on_is_forbidden():
    heights = np.zeros((80, 80))
    heights[36:44, 36:44] = 0.8
    forbidden = classify(heights, 0.025, MACHINE)
    assert forbidden[40, 40]
    assert not forbidden[10, 10]


def hillside(degrees, heading, cell=0.025):
    x, y = (np.arange(60) + 0.5) * cell, (np.arange(50) + 0.5) * cell
    steep = math.tan(math.radians(degrees))
    return steep * (
        math.cos(math.radians(heading)) * x[None, :] + math.sin(math.radians(heading)) * y[:, None]
    )


@pytest.mark.parametrize("heading", [0, 30, 45, 90, 135, 250])
def test_an_even_slope_of_25_degrees_may_be_stepped_on_whichever_way_it_lies_to_the_cells(heading):
    heights = hillside(25, heading)
    assert not classify(heights, 0.025, MACHINE)[2:-2, 2:-2].any()
    assert not kinds(heights, np.ones(heights.shape, dtype=bool), 0.025, MACHINE)[2:-2, 2:-2].any()


@pytest.mark.parametrize("degrees", [0, 15, 25])
def test_a_riser_under_the_foot_is_still_an_edge_on_a_slope(degrees):
    heights = hillside(degrees, 45)
    heights[:, 30:] += 0.05
    forbidden = classify(heights, 0.025, MACHINE)
    assert forbidden[5:-5, 29:31].all() and not forbidden[5:-5, 33:-5].any()


def test_a_long_plain_slope_is_not_mistaken_for_a_tall_rise():
    x = (np.arange(400) + 0.5) * 0.025
    heights = np.tile(x * math.tan(math.radians(20)), (100, 1))
    assert not classify(heights, 0.025, MACHINE)[50, 100:300].any()


@pytest.mark.parametrize("seed", range(8))
def test_where_all_is_known_kinds_are_what_classify_refuses(seed):
    heights = hills(seed)
    found = kinds(heights, np.ones(heights.shape, dtype=bool), CELL, MACHINE)
    assert np.array_equal(found != Kind.O, classify(heights, CELL, MACHINE))


@pytest.mark.parametrize("seed", range(8))
def test_the_kinds_of_a_rectangle_are_those_it_has_in_the_whole_map(seed):
    rng = np.random.default_rng(seed)
    heights = hills(seed)
    known = rng.random(heights.shape) < 0.97
    known[:, : int(rng.integers(0, 60))] = False
    whole = kinds(heights, known, CELL, MACHINE)
    for row, column in ((0, 0), (0, 60), (40, 30), (55, 10)):
        window = np.s_[row : row + 25, column : column + 40]
        found = kinds_within(window, heights, known, CELL, MACHINE)
        assert np.array_equal(found, whole[window])


def test_a_hole_is_h_a_pole_is_p_and_its_rim_both():
    heights = np.zeros((80, 120))
    heights[30, 30] = np.nan
    heights[50:62, 50:62] = 0.9
    found = kinds(heights, np.ones(heights.shape, dtype=bool), CELL, MACHINE)
    assert (found[30, 30], found[55, 55], found[50, 55], found[10, 10]) == (
        Kind.H,
        Kind.P,
        Kind.HP,
        Kind.O,
    )


def test_on_final_ground_only_the_cell_under_the_tip_counts():
    heights = np.zeros((40, 40))
    heights[20, 20] = np.nan
    found = kinds(heights, np.ones(heights.shape, dtype=bool), CELL, MACHINE, final=True)
    assert found[20, 20] == Kind.H and found.sum() == 1


def test_what_is_not_known_hides_nothing_and_refuses_nothing():
    heights = np.full((40, 40), np.nan)
    known = np.zeros(heights.shape, dtype=bool)
    known[:, :20], heights[:, :20] = True, 0.0
    assert not kinds(heights, known, CELL, MACHINE).any()


def test_classifying_again_what_has_changed_is_as_good_as_all():
    heights = hills(3)
    before = classify(heights, CELL, MACHINE)
    cells = [(2, 3), (4, 9), (5, 9)]
    for row, column in cells:
        heights[row, column] = np.nan
    again = classify_again(heights, before, CELL, MACHINE, cells)
    assert np.array_equal(again, classify(heights, CELL, MACHINE))
