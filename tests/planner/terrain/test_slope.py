"""The slope under a walker: the plane through what is known of the ground."""

import math
from dataclasses import replace

import numpy as np
import pytest

from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.terrain.slope import plane_of, slope_at, slope_under
from walking_console.planner.types import Command, Stance

TITAN = load_machine("titan3")
CELL = 0.05
AHEAD = Command(0.0, 0.08)


def gradient(degrees: float, heading: float = 0.0) -> tuple[float, float]:
    steep = math.tan(math.radians(degrees))
    return steep * math.cos(math.radians(heading)), steep * math.sin(math.radians(heading))


def inclined(degrees: float, heading: float = 0.0, span: float = 12.0) -> TerrainMap:
    n = round(span / CELL)
    at = (np.arange(n) + 0.5) * CELL - span / 2
    gx, gy = gradient(degrees, heading)
    heights = gx * at[None, :] + gy * at[:, None]
    return TerrainMap(heights, np.zeros((n, n), dtype=bool), CELL, (-span / 2, -span / 2))


def standing(terrain: TerrainMap) -> Stance:
    """Every foot in the middle of its reach on the ground."""
    feet = tuple((*leg.centre, terrain.height_at(*leg.centre)) for leg in TITAN.legs)
    return Stance((0.0, 0.0, TITAN.height, 0.0), feet)


def test_level_ground_has_no_slope() -> None:
    flat = TerrainMap(np.full((80, 80), 0.3), np.zeros((80, 80), dtype=bool), CELL, (-2.0, -2.0))
    assert slope_under(standing(flat), AHEAD, flat, TITAN) == (0.0, 0.0)


def test_the_slope_is_that_of_the_plane_whatever_stands_or_gapes_in_it() -> None:
    terrain = inclined(15, 30)
    heights = terrain.heights.copy()
    heights[110:114, 125:129] += 1.5  # a pole ahead
    heights[128:132, 108:112] = math.nan  # a hole beside
    for ground in (terrain, replace(terrain, heights=heights)):
        found = slope_under(standing(terrain), AHEAD, ground, TITAN)
        assert found == pytest.approx(gradient(15, 30), abs=0.012)


def test_ground_it_does_not_know_has_no_slope_of_its_own() -> None:
    terrain = inclined(15)
    column = np.indices(terrain.heights.shape)[1]
    wrong = replace(terrain, heights=np.where(column > 120, 3.0, terrain.heights))
    seen = replace(wrong, known=column <= 120)
    gx, _ = slope_under(standing(terrain), AHEAD, seen, TITAN)
    assert gx == pytest.approx(0.268, abs=0.02)


def test_ahead_counts_when_it_walks_and_not_when_it_stands() -> None:
    terrain = inclined(0.0)
    column = np.indices(terrain.heights.shape)[1]
    at = (column + 0.5) * CELL - 6.0
    rising = replace(terrain, heights=np.where(at > 0.75, 0.3 * (at - 0.75), 0.0))
    walks, _ = slope_under(standing(terrain), AHEAD, rising, TITAN)
    stands, _ = slope_under(standing(terrain), Command(), rising, TITAN)
    assert walks > stands + 0.01


def test_where_a_machine_is_to_be_set_down_the_slope_is_that_of_the_ground_there() -> None:
    gx, gy = gradient(10, 120)
    found = slope_at(TITAN, (1.0, -2.0, 0.7), lambda x, y: 0.4 + gx * x + gy * y)
    assert found == pytest.approx((gx, gy), abs=1e-9)


def test_points_in_a_line_make_no_slope() -> None:
    assert plane_of([(0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (2.0, 2.0, 2.0)], 3, 0.2) == (0.0, 0.0)
