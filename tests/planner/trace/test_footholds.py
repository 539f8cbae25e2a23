"""Where footholds of a trace walk may be."""

from dataclasses import replace

import numpy as np

from tests.planner.trace.rollout import field_of, gait_of
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.trace.footholds import (
    AIR,
    DENSE,
    Foothold,
    allowed_cells,
    is_plenty,
    legs_clear,
    thinning,
    within_reach,
)
from walking_console.planner.trace.lane import Lane

HEXAPOD = load_machine("hexapod")
COUNT = 100
ALONG = np.arange(COUNT) * 0.02
LANE = Lane(
    ALONG[None],
    np.zeros((1, COUNT)),
    np.zeros(COUNT),
    np.full(COUNT, gait_of(HEXAPOD).height),
)


def test_cells_are_allowed_ones_and_none_in_reach_is_left_out() -> None:
    terrain = field_of(0.2, 1, HEXAPOD)
    px, py, pz = allowed_cells(LANE, terrain, HEXAPOD, 1)
    assert all(terrain.allows(x, y) for x, y in zip(px, py, strict=True))
    assert (pz == 0.0).all()
    found = set(zip(px.tolist(), py.tolist(), strict=True))
    for row, column in zip(*np.nonzero(~terrain.forbidden), strict=True):
        x, y = terrain.centre(int(row), int(column))
        for leg in HEXAPOD.legs:
            x1, x2, y1, y2 = leg.box
            if x1 <= x <= x2 + ALONG[-1] and y1 <= y <= y2:
                assert (x, y) in found


def test_a_thinned_map_keeps_one_cell_of_each_square() -> None:
    terrain = field_of(1.0, 0, HEXAPOD)
    px, py, _ = allowed_cells(LANE, terrain, HEXAPOD, 3)
    squares = {
        (terrain.cell_at(x, y)[0] // 3, terrain.cell_at(x, y)[1] // 3)
        for x, y in zip(px, py, strict=True)
    }
    assert len(squares) == len(px)
    rows, columns = within_reach(LANE, terrain, HEXAPOD)
    assert len(px) >= (rows.stop - rows.start) * (columns.stop - columns.start) / 9


def test_dense_ground_is_thinned_to_about_dense_footholds_a_rectangle_and_thin_ground_is_not() -> (
    None
):
    terrain = field_of(1.0, 0, HEXAPOD)
    thin = thinning(LANE, terrain, HEXAPOD)
    area = max((leg.x[1] - leg.x[0]) * (leg.y[1] - leg.y[0]) for leg in HEXAPOD.legs)
    offered = area / (thin * terrain.cell) ** 2
    assert DENSE / 2 < offered < 2 * DENSE
    assert thinning(LANE, field_of(0.03, 0, HEXAPOD), HEXAPOD) == 1


def test_legs_are_clear_when_feet_are_two_radii_apart() -> None:
    holds = [Foothold(0, 0.0, 0.0, 0.0, 9), Foothold(1, 0.1, 0.0, 0.0, 9)]
    assert legs_clear(holds, (0, AIR), holds[1], 0.05)
    assert not legs_clear(holds, (0, AIR), holds[1], 0.051)
    assert legs_clear(holds, (AIR, AIR), holds[1], 0.2)
    assert legs_clear(holds, (0, AIR), Foothold(0, 0.0, 0.0, 0.0, 9), 0.2), "its own foothold"


def coarse(holes: bool) -> TerrainMap:
    """Level ground in cells of 0.4 m, one of them a hole or not."""
    heights = np.zeros((20, 20))
    if holes:
        heights[11, 12] = np.nan
    return TerrainMap.from_heights(heights, 0.4, HEXAPOD, (-4.0, -4.0))


def test_a_hole_in_a_coarse_map_takes_only_the_footholds_around_it() -> None:
    whole, with_hole = (
        set(zip(*(part.tolist() for part in allowed_cells(LANE, ground, HEXAPOD, 1)), strict=True))
        for ground in (coarse(False), coarse(True))
    )
    gone = whole - with_hole
    assert 0 < len(gone) < 0.5 * len(whole)
    assert all(abs(x - 1.0) < 1.0 and abs(y - 0.6) < 1.0 for x, y, _ in gone)
    assert all(coarse(True).allows(x, y) for x, y, _ in with_hole)


def test_ground_is_plenty_as_long_as_half_of_it_may_be_stepped_on() -> None:
    assert is_plenty(LANE, coarse(True), HEXAPOD)
    assert is_plenty(LANE, field_of(0.7, 1, HEXAPOD), HEXAPOD)
    assert not is_plenty(LANE, field_of(0.3, 1, HEXAPOD), HEXAPOD)


def test_of_ground_that_is_only_supposed_one_forbidden_cell_is_too_many() -> None:
    supposed = np.zeros(coarse(True).forbidden.shape, dtype=bool)
    assert is_plenty(LANE, replace(coarse(False), known=supposed), HEXAPOD)
    assert not is_plenty(LANE, replace(coarse(True), known=supposed), HEXAPOD)
    sparse = field_of(0.7, 1, HEXAPOD)
    known = np.zeros(sparse.forbidden.shape, dtype=bool)
    assert not is_plenty(LANE, replace(sparse, known=known), HEXAPOD)
