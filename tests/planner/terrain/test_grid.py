"""Square grids of heights: which cell a point is in, and rectangles of cells."""

import math

import numpy as np
import pytest

from walking_console.planner.terrain.grid import (
    HeightGrid,
    grown,
    is_relief,
    joined,
    placed_in,
    solid_heights,
    spread_max,
    within,
)


class Grid(HeightGrid):
    """A grid and nothing else."""

    def __init__(self, heights: np.ndarray, relief: bool = False) -> None:
        self.heights = heights
        self.cell = 0.05
        self.origin = (-1.0, -0.5)
        self.relief = relief


GRID = Grid(np.arange(2400.0).reshape(40, 60))


def test_rows_are_y_and_columns_are_x():
    assert GRID.cell_at(-1.0 + 0.12, -0.5 + 0.01) == (0, 2)
    assert GRID.centre(0, 2) == pytest.approx((-1.0 + 0.125, -0.5 + 0.025))
    assert GRID.bounds == pytest.approx((-1.0, 2.0, -0.5, 1.5))


def test_the_height_is_that_of_the_cell_that_contains_the_point():
    for row, column in ((0, 0), (7, 31), (39, 59)):
        x, y = GRID.centre(row, column)
        assert GRID.height_at(x + 0.024, y - 0.024) == GRID.heights[row, column]
        assert GRID.index(x, y) == row * 60 + column


def test_relief_goes_straight_from_centre_to_centre_in_triangles():
    square = Grid(np.array([[0.0, 0.1, 0.0], [0.3, 0.2, 0.0], [0.0, 0.0, 0.0]]), relief=True)
    x, y = square.centre(0, 0)
    for ahead, aside, height in (
        (0.0, 0.0, 0.0),
        (0.5, 0.0, 0.05),
        (0.0, 0.5, 0.15),
        (0.5, 0.5, 0.1),  # on the side both triangles have, from the first corner to the last
        (0.75, 0.25, 0.1),
        (0.25, 0.75, 0.2),
        (0.999, 0.999, 0.1998),
    ):
        got = square.height_at(x + ahead * 0.05, y + aside * 0.05)
        assert got == pytest.approx(height), (ahead, aside)


def test_relief_is_a_plane_where_its_cells_are():
    rows, columns = np.indices((20, 30))
    slope = Grid(0.01 * columns - 0.02 * rows, relief=True)
    for x, y in np.random.default_rng(1).uniform((-0.97, -0.47), (0.47, 0.47), (200, 2)):
        wanted = 0.2 * (x + 0.975) - 0.4 * (y + 0.475)
        assert slope.height_at(x, y) == pytest.approx(wanted, abs=1e-12)


def test_beside_a_hole_and_at_the_rim_relief_has_the_height_of_the_cell():
    heights = np.random.default_rng(2).uniform(0.0, 0.3, (9, 11))
    heights[4, 5] = np.nan
    dug = Grid(heights, relief=True)
    x, y = dug.centre(4, 4)
    assert dug.height_at(x + 0.02, y) == heights[4, 4]
    assert math.isnan(dug.height_at(*dug.centre(4, 5)))
    assert dug.height_at(-1.0 + 0.001, -0.5 + 0.03) == heights[0, 0]
    assert math.isnan(dug.height_at(-1.001, -0.4))


@pytest.mark.parametrize("relief", [False, True])
def test_many_points_are_as_high_as_each_of_them(relief):
    heights = np.random.default_rng(3).uniform(0.0, 0.3, (9, 11))
    heights[4, 5] = np.nan
    grid = Grid(heights, relief)
    x, y = np.random.default_rng(4).uniform((-1.0, -0.5), (-0.45, -0.05), (500, 2)).T
    each = [grid.height_at(px, py) for px, py in zip(x.tolist(), y.tolist(), strict=True)]
    assert np.array_equal(grid.heights_at(x, y), each, equal_nan=True)
    beyond = grid.heights_at(np.array([9.0]), np.array([9.0]))
    assert beyond == heights[8, 10]


def test_samples_of_a_surface_are_relief_and_steps_walls_and_holes_are_cells():
    rows, columns = np.indices((120, 160))
    slope = 0.01 * columns
    rough = np.random.default_rng(5).normal(0.0, 0.02, rows.shape)
    assert is_relief(slope) and is_relief(slope.T) and is_relief(rough)
    assert is_relief(np.where(columns < 80, 0.0, rough))  # half of it a plain
    assert not is_relief(np.zeros(rows.shape))
    assert not is_relief(0.15 * (columns // 8))  # twenty steps are still steps
    blocks = np.repeat(np.repeat(rough[:12, :16], 10, axis=0), 10, axis=1)
    assert np.unique(blocks).size > 100 and not is_relief(blocks)
    assert not is_relief(np.where(columns % 3 == 0, 0.0, 0.1))  # two heights
    rough[60, 80] = np.nan
    assert not is_relief(rough)


def test_outside_the_grid_there_is_no_cell_and_no_height():
    for x, y in ((-1.001, 0.0), (2.001, 0.0), (0.0, -0.501), (0.0, 1.501)):
        assert GRID.index(x, y) == -1
        assert GRID.cell_at(x, y) is None
        assert math.isnan(GRID.height_at(x, y))


def test_a_cell_the_grid_does_not_have_is_refused():
    GRID.need_cell(39, 59)
    with pytest.raises(ValueError, match=r"cell \(40, 0\) is outside the map of 40 x 60 cells"):
        GRID.need_cell(40, 0)


def test_a_window_holds_the_cells_a_rectangle_touches_and_ends_with_the_grid():
    assert GRID.window(-0.99, -0.88, 0.01, 0.02) == (slice(10, 11), slice(0, 3))
    assert GRID.window(-9.0, 9.0, -9.0, 9.0) == (slice(0, 40), slice(0, 60))
    assert GRID.heights[GRID.window(5.0, 6.0, 0.0, 0.1)].size == 0


def test_a_grown_window_ends_with_the_grid_and_the_first_lies_within_it():
    inner = slice(1, 4), slice(50, 58)
    outer = grown(inner, 3, (40, 60))
    assert outer == (slice(0, 7), slice(47, 60))
    values = GRID.heights
    assert np.array_equal(values[outer][within(inner, outer)], values[inner])


def test_the_largest_value_spreads_over_a_square():
    values = np.zeros((7, 7))
    values[3, 3] = 2.0
    spread = spread_max(values, 2)
    assert (spread[1:6, 1:6] == 2.0).all()
    assert spread.sum() == 2.0 * 25


@pytest.mark.parametrize("reach", range(6))
def test_the_largest_value_within_reach_is_that_of_every_cell_looked_at(reach):
    values = np.random.default_rng(reach).standard_normal((2, 5, 9))
    found = spread_max(values, reach)
    for layer, row, column in np.ndindex(values.shape):
        rows = slice(max(row - reach, 0), row + reach + 1)
        columns = slice(max(column - reach, 0), column + reach + 1)
        assert found[layer, row, column] == values[layer, rows, columns].max()


def test_a_rectangle_of_a_part_lies_in_the_map_where_the_part_does():
    part, inner = grown((slice(3, 8), slice(10, 12)), 2, (40, 60)), (slice(1, 3), slice(0, 2))
    assert placed_in(inner, part) == (slice(2, 4), slice(8, 10))
    assert within(placed_in(inner, part), part) == inner


def test_holes_do_not_count_as_ground():
    heights = np.array([[np.nan, 1.0]])
    assert solid_heights(heights).tolist() == [[-math.inf, 1.0]]


def test_two_rectangles_are_joined_by_the_least_that_holds_both():
    one, other = (slice(3, 8), slice(10, 12)), (slice(5, 20), slice(2, 4))
    assert joined(one, other) == joined(other, one) == (slice(3, 20), slice(2, 12))
    assert joined(None, one) == one
