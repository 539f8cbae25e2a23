"""Cells around a place, and which of them may be stepped on."""

import math

import numpy as np
import pytest

from walking_console.planner.terrain.cells import (
    FootholdMap,
    disc_of,
    foothold_map,
    outward,
    span_of,
)
from walking_console.planner.terrain.map import TerrainMap


def test_off_the_map_nothing_is_allowed():
    cells = FootholdMap(b"\x00" * 4, 2, 2, 0.1, 0.0, 0.0)
    assert cells.allows(0.05, 0.15)
    assert not cells.allows(-0.01, 0.05)
    assert not cells.allows(0.05, 0.2) and not cells.allows(1e9, 0.0)


def test_it_allows_what_the_map_allows():
    rng = np.random.default_rng(1)
    forbidden = rng.random((30, 40)) < 0.4
    terrain = TerrainMap(np.zeros((30, 40)), forbidden, 0.05, (-1.0, -0.5))
    cells = foothold_map(terrain)
    for x, y in rng.uniform(-1.2, 1.2, (300, 2)).tolist():
        assert cells.allows(x, y) == terrain.allows(x, y)


def test_a_span_is_of_the_cells_whose_centres_lie_in_it_cut_to_the_map():
    assert span_of(0.12, 0.31, 0.0, 0.1, 10) == (1, 2), "centres at 0.15 and 0.25"
    assert span_of(-5.0, 0.15, 0.0, 0.1, 10) == (0, 1)
    assert span_of(0.95, 9.0, 0.0, 0.1, 10) == (9, 9)


@pytest.mark.parametrize("first", [1, -1])
def test_outward_comes_to_every_cell_once_from_the_middle_on(first):
    found = list(outward(4, 2, 9, first))
    assert sorted(found) == list(range(2, 10)) and found[0] == 4 and found[1] == 4 + first
    away = [abs(k - 4) for k in found]
    assert away == sorted(away)
    assert list(outward(12, 2, 4, 1)) == [4, 3, 2]


def test_a_disc_has_every_cell_within_its_radius_the_nearest_first():
    cells = disc_of(0.1, 0.35)
    assert cells[0] == (0, 0, 0.0)
    away = [distance for _, _, distance in cells]
    assert away == sorted(away) and away[-1] <= 0.35
    around = [(c, r) for c in range(-4, 5) for r in range(-4, 5)]
    assert {(c, r) for c, r, _ in cells} == {p for p in around if math.hypot(*p) * 0.1 <= 0.35}
