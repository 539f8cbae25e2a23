"""What the walker believes about the ground."""

import math

import numpy as np
import pytest

from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap, changed_in
from walking_console.planner.terrain.traversability import classify

MACHINE = load_machine("titan3")


def level(rows=40, columns=60, cell=0.05, origin=(-1.0, -0.5)):
    return TerrainMap(
        np.zeros((rows, columns)), np.zeros((rows, columns), dtype=bool), cell, origin
    )


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


def test_relief_stays_relief_whatever_is_learnt_or_dug():
    heights = np.random.default_rng(1).uniform(0.0, 0.02, (40, 60))
    ground = TerrainMap.from_heights(heights, 0.05, MACHINE)
    assert ground.relief and not level().relief
    dug = heights.copy()
    dug[3, 4] = np.nan
    rows = slice(3, 4), slice(4, 5)
    for other in (
        ground.forbid([(3, 4)]),
        ground.told([], {(3, 4): math.nan}),
        changed_in(ground, rows, dug, ground.forbidden),
    ):
        assert other.relief
        assert other.height_at(1.51, 1.01) == ground.height_at(1.51, 1.01)


def test_no_foot_lands_within_a_centimetre_of_the_bottomless_unless_it_may():
    heights = np.zeros((20, 20))
    heights[10, 10] = np.nan
    ground = TerrainMap(heights, np.isnan(heights), 0.05, (0.0, 0.0))
    x, y = 0.5, 0.525  # the hole begins at x
    assert ground.allows(x - 0.011, y) and not ground.allows(x - 0.009, y)
    assert not ground.allows(x - 0.005, 0.495)  # at its corner
    assert all(ground.allows(*ground.centre(10, c)) for c in (9, 11))
    assert ground.allows(0.005, 0.005)  # beyond the map there is nothing to keep off
    printed = TerrainMap(heights, np.isnan(heights), 0.05, (0.0, 0.0), edge=0.0)
    assert printed.allows(x - 0.001, y) and not printed.allows(x + 0.001, y)


def test_a_foothold_keeps_off_a_hole_smaller_than_the_edge_to_keep():
    heights = np.zeros((40, 40))
    heights[20, 20] = np.nan
    ground = TerrainMap(heights, np.isnan(heights), 0.005, (0.0, 0.0))
    x, y = ground.centre(20, 20)
    assert not ground.allows(x + 0.006, y) and ground.allows(x + 0.013, y)


def test_what_has_not_been_seen_is_not_known():
    heights = np.zeros((4, 4))
    known = np.zeros((4, 4), dtype=bool)
    known[1, 1] = True
    ground = TerrainMap(heights, known & False, 0.1, (0.0, 0.0), known=known)
    assert ground.is_known(0.15, 0.15) and not ground.is_known(0.25, 0.15)
    assert not ground.is_known(9.0, 0.0)


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


def test_heights_and_forbidden_cells_must_have_one_shape():
    with pytest.raises(ValueError, match=r"one \(ny, nx\) shape"):
        TerrainMap(np.zeros((3, 4)), np.zeros((4, 3), dtype=bool), 0.05, (0.0, 0.0))


def test_forbidding_cells_works_out_nothing_of_the_heights_again():
    ground = level().work_out()
    other = ground.forbid([(3, 4)])
    assert other.crests is ground.crests and other.holes_bytes is ground.holes_bytes
    assert other.forbidden_bytes != ground.forbidden_bytes


def test_a_map_that_was_told_heights_has_the_crests_of_one_made_anew():
    ground = level()
    told = ground.told([(12, 30)], {(12, 30): 0.3, (13, 31): math.nan, (0, 0): -0.1})
    anew = TerrainMap(told.heights, told.forbidden, 0.05, (-1.0, -0.5))
    assert list(told.crest_view) == list(anew.crest_view)
    assert told.heights[12, 30] == 0.3 and told.heights[0, 0] == 0.0
    assert told.forbidden.sum() == 1


def test_the_highest_ground_of_a_map_is_found_whether_it_has_holes_or_nothing_else():
    heights = np.full((4, 5), math.nan)
    nothing = TerrainMap(heights, np.ones((4, 5), dtype=bool), 0.05, (0.0, 0.0))
    assert nothing.highest == 0.0 and nothing.is_level
    heights = heights.copy()
    heights[1, 2] = -0.4
    one = TerrainMap(heights, np.ones((4, 5), dtype=bool), 0.05, (0.0, 0.0))
    assert one.highest == -0.4 and one.is_level
    heights = heights.copy()
    heights[3, 3] = -0.5
    two = TerrainMap(heights, np.ones((4, 5), dtype=bool), 0.05, (0.0, 0.0))
    assert two.highest == -0.4 and not two.is_level


def test_a_map_is_plain_when_all_of_it_is_known_level_ground_to_step_on():
    level, free = np.zeros((4, 5)), np.zeros((4, 5), dtype=bool)
    one = free.copy()
    one[2, 3] = True
    assert TerrainMap(level, free, 0.05, (0.0, 0.0)).is_plain
    assert TerrainMap(level, free, 0.05, (0.0, 0.0), known=~free).is_plain
    assert not TerrainMap(level, free, 0.05, (0.0, 0.0), known=~one).is_plain
    assert not TerrainMap(level, one, 0.05, (0.0, 0.0)).is_plain
    for other in (0.01, math.nan):
        assert not TerrainMap(np.where(one, other, level), free, 0.05, (0.0, 0.0)).is_plain


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


def test_a_rectangle_is_free_when_it_is_on_the_map_and_has_no_prohibited_cell():
    forbidden = np.zeros((20, 20), dtype=bool)
    forbidden[10, 15] = True  # around (0.275, 0.025)
    ground = TerrainMap(np.zeros((20, 20)), forbidden, 0.05, (-0.5, -0.5))
    assert ground.is_free(-0.49, 0.24, -0.49, 0.49)
    assert not ground.is_free(-0.49, 0.26, -0.49, 0.49)
    assert not ground.is_free(-0.51, 0.0, 0.0, 0.1)


@pytest.mark.parametrize("seed", range(6))
def test_a_map_changed_in_a_rectangle_knows_what_one_made_anew_works_out(seed: int) -> None:
    rng = np.random.default_rng(seed)
    heights = rng.uniform(0.0, 0.2, (30, 40))
    if seed % 2:
        heights[3, 4] = np.nan
    old = TerrainMap(heights, rng.random(heights.shape) < 0.3, 0.02, (0.0, 0.0)).work_out()
    row, column = divmod(int(np.nanargmax(heights) if seed < 2 else rng.integers(1200)), 40)
    window = slice(row, min(row + 3, 30)), slice(column, min(column + 2, 40))
    now = heights.copy()
    now[window] += rng.choice([-0.3, 0.0, 0.3])
    if seed == 4:
        now[row, column] = np.nan
    forbidden = rng.random(heights.shape) < 0.3
    changed = changed_in(old, window, now, forbidden).work_out()
    anew = TerrainMap(now, forbidden, 0.02, (0.0, 0.0)).work_out()
    assert np.array_equal(changed.crests, anew.crests)
    assert (changed.highest, changed.is_level) == (anew.highest, anew.is_level)
    assert changed.holes_bytes == anew.holes_bytes
    assert changed.forbidden_bytes == anew.forbidden_bytes
    assert np.array_equal(changed.heights, now, equal_nan=True)


def test_a_map_with_other_cells_prohibited_alone_keeps_all_that_its_heights_say() -> None:
    old = TerrainMap(np.zeros((9, 9)), np.zeros((9, 9), bool), 0.1, (0.0, 0.0)).work_out()
    shut = changed_in(old, (slice(2, 3), slice(2, 3)), old.heights, np.ones((9, 9), bool))
    assert shut.crests is old.crests and not shut.allows(0.45, 0.45) and old.allows(0.45, 0.45)
