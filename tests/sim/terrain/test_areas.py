"""Cells under a circle and under a rectangle."""

import math

import numpy as np
import pytest

from walking_console.sim.snapshot import TerrainView
from walking_console.sim.terrain.areas import cells_in_circle, cells_in_rectangle

CELL = 0.1
SHAPE = (30, 40)  # rows, columns
HEIGHTS = np.zeros(SHAPE)
MAP = TerrainView(1, HEIGHTS, HEIGHTS > 1.0, CELL, (-1.0, -2.0))


def centre(row: int, column: int) -> tuple[float, float]:
    return -1.0 + (column + 0.5) * CELL, -2.0 + (row + 0.5) * CELL


@pytest.mark.parametrize(
    ("x", "y", "radius"), [(0.0, 0.0, 0.5), (-0.97, -1.9, 0.3), (2.9, 0.9, 0.4)]
)
def test_a_circle_has_exactly_the_cells_whose_centres_are_in_it(
    x: float, y: float, radius: float
) -> None:
    inside = {
        (row, column)
        for row in range(SHAPE[0])
        for column in range(SHAPE[1])
        if math.dist(centre(row, column), (x, y)) <= radius
    }
    found = cells_in_circle(MAP, x, y, radius)
    assert set(found) == inside and len(found) == len(inside)


def test_a_rectangle_has_every_cell_it_touches_row_by_row() -> None:
    assert cells_in_rectangle(MAP, (-0.95, -1.95), (-0.75, -1.85)) == (
        (0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2),
    )  # fmt: skip


def test_an_area_beside_the_map_has_no_cells() -> None:
    assert cells_in_rectangle(MAP, (50.0, 50.0), (51.0, 51.0)) == ()
    assert cells_in_circle(MAP, 50.0, 50.0, 1.0) == ()


def test_no_cell_is_beyond_the_edge_of_the_map() -> None:
    rows, columns = zip(*cells_in_rectangle(MAP, (-9.0, -9.0), (9.0, 9.0)), strict=True)
    assert (min(rows), max(rows)) == (0, SHAPE[0] - 1)
    assert (min(columns), max(columns)) == (0, SHAPE[1] - 1)
