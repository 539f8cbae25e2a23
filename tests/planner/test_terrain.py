"""What the walker believes about the ground."""

import math

import numpy as np
import pytest

from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap, classify, kinds

MACHINE = load_machine("titan3")


def level(rows=40, columns=60, cell=0.05, origin=(-1.0, -0.5)):
    return TerrainMap(
        np.zeros((rows, columns)), np.zeros((rows, columns), dtype=bool), cell, origin
    )


def test_rows_are_y_and_columns_are_x():
    ground = level()
    assert ground.cell_at(-1.0 + 0.12, -0.5 + 0.01) == (0, 2)
    assert ground.centre(0, 2) == pytest.approx((-1.0 + 0.125, -0.5 + 0.025))


def test_outside_the_map_everything_is_forbidden_and_has_no_height():
    ground = level()
    assert not ground.allows(-1.001, 0.0)
    assert math.isnan(ground.height_at(50.0, 0.0))


def test_forbidding_makes_a_new_map_and_leaves_the_old_one():
    ground = level()
    other = ground.forbid([(3, 4)])
    x, y = ground.centre(3, 4)
    assert ground.allows(x, y) and not other.allows(x, y)
    assert other.forbidden.sum() == 1


def test_a_map_cannot_be_written_to():
    with pytest.raises(ValueError, match="read-only"):
        level().heights[0, 0] = 1.0


def test_the_way_over_a_wall_has_the_height_of_the_wall():
    heights = np.zeros((40, 60))
    heights[:, 30] = 0.2
    ground = TerrainMap(heights, heights > 1.0, 0.05, (-1.0, -0.5))
    assert ground.crest_between(0.0, 0.0, 1.0, 0.1) == pytest.approx(0.2)
    assert ground.crest_between(0.0, 0.0, 0.3, 0.1) == pytest.approx(0.0)
    assert ground.crest_in(0.0, 1.0, -0.1, 0.1) == pytest.approx(0.2)


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


def test_a_map_of_measured_heights_closes_what_this_machine_cannot_step_on():
    heights = np.zeros((40, 60))
    heights[10:20, 10:20] = np.nan
    heights[30:, 40:] = 1.0
    terrain = TerrainMap.from_heights(heights.tolist(), 0.05, MACHINE, origin=(-1.0, 2.0))
    assert np.array_equal(terrain.forbidden, classify(heights, 0.05, MACHINE))
    assert terrain.origin == (-1.0, 2.0) and terrain.foot_radius == MACHINE.foot_radius
    heights[0, 0] = 5.0
    assert terrain.heights[0, 0] == 0.0


def test_a_map_may_bring_its_own_forbidden_cells():
    closed = np.zeros((4, 4), dtype=bool)
    closed[1, 2] = True
    terrain = TerrainMap.from_heights(np.zeros((4, 4)), 0.1, MACHINE, forbidden=closed)
    assert terrain.forbidden.sum() == 1 and not terrain.allows(0.25, 0.15)


@pytest.mark.parametrize(
    ("heights", "cell", "said"),
    [
        (np.zeros(4), 0.1, r"must be \(ny, nx\)"),
        (np.full((2, 2), np.inf), 0.1, "finite or NaN"),
        (np.zeros((2, 2)), 0.0, "side of a cell"),
        (np.zeros((2, 2)), float("nan"), "side of a cell"),
    ],
)
def test_what_is_no_map_is_refused(heights, cell, said):
    with pytest.raises(ValueError, match=said):
        TerrainMap.from_heights(heights, cell, MACHINE)
