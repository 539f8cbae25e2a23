"""What touch has shown of the ground, as cells of the map."""

import math

import pytest

from tests.planner.control.plans import FEET, flat
from walking_console.planner.config import Contact
from walking_console.planner.control.touch_memory import Felt, cell_of, cells_near, edge_cells

GROUND = flat()


@pytest.mark.parametrize("bearing", [0.0, 1.0, -2.5])
def test_an_edge_is_marked_along_and_beyond_it_but_not_behind(bearing):
    foot, settings = FEET[0], Contact()
    cells = edge_cells(foot, bearing, GROUND, settings)
    reach = settings.edge_length / 2 + settings.edge_depth + GROUND.cell
    assert cells == edge_cells(foot, bearing, GROUND, settings)
    for row, column in cells:
        x, y = GROUND.centre(row, column)
        assert max(abs(x - foot[0]), abs(y - foot[1])) <= reach
    assert cell_of(foot, GROUND) <= cells


def test_cells_near_are_those_whose_centre_is_and_a_foot_off_the_map_has_none():
    near = cells_near(FEET[0], 0.11, GROUND)
    assert cell_of(FEET[0], GROUND) <= near and 9 <= len(near) <= 25
    assert cells_near((99.0, 0.0, 0.0), 0.11, GROUND) == cell_of((99.0, 0.0, 0.0), GROUND) == set()


def test_cells_are_as_high_as_was_felt_at_most_and_a_hole_levels_nothing_that_stands():
    felt = Felt()
    assert not felt
    felt.raise_to([(1, 1), (2, 2)], 0.1)
    felt.raise_to([(1, 1)], 0.05)
    felt.dig([(2, 2), (3, 3)])
    felt.raise_to([(3, 3)], 0.2)
    felt.dig([(4, 4)])
    assert felt.heights[1, 1] == felt.heights[2, 2] == 0.1
    assert felt.heights[3, 3] == 0.2 and math.isnan(felt.heights[4, 4])
    assert felt
