"""Square grids of heights: which cell a point is in, and rectangles of cells."""

import math

import numpy as np
import pytest

from walking_console.planner.terrain.grid import (
    HeightGrid,
    grown,
    joined,
    placed_in,
    solid_heights,
    spread_max,
    within,
)


class Grid(HeightGrid):
    """A grid and nothing else."""

    def __init__(self, heights: np.ndarray) -> None:
        self.heights = heights
        self.cell = 0.05
        self.origin = (-1.0, -0.5)


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
