"""How the map grows from what is seen, touched and learnt."""

import math

import numpy as np
import pytest

from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.terrain.mapping import ElevationMapper
from walking_console.planner.terrain.traversability import classify

MACHINE = load_machine("titan3")
CELL = 0.025


def blank(unknown="flat", shape=(80, 120), cell=CELL, **more):
    return ElevationMapper(shape, cell, (-1.0, -1.0), MACHINE, unknown=unknown, **more)


def everything(heights):
    rows, columns = (index.ravel() for index in np.indices(heights.shape))
    return rows, columns, heights.ravel()


def hills(seed, shape=(80, 120)):
    rng = np.random.default_rng(seed)
    y, x = np.indices(shape) * CELL
    heights = 0.1 * np.sin(3 * x + rng.uniform(0, 6)) * np.cos(2 * y + rng.uniform(0, 6))
    r, c = int(rng.integers(10, 60)), int(rng.integers(10, 100))
    heights[r : r + 12, c : c + 12] += 0.15  # a block
    heights[5:11, 70:76] = np.nan  # a hole
    heights[60:64, 20:24] += 0.8  # a pole
    return heights


def test_on_relief_a_foot_tells_how_high_the_middle_of_its_cell_is():
    slope = np.broadcast_to(0.4 * CELL * np.arange(120.0), (80, 120))
    belief = blank(relief=True)
    belief.observe(*everything(slope))
    x, y = belief.map.centre(40, 60)
    foot = x + 0.01, y + 0.005, belief.map.height_at(x + 0.01, y + 0.005) + 0.006
    belief.touch([foot])
    ground = belief.publish()
    assert ground.relief
    assert ground.heights[40, 60] == pytest.approx(slope[40, 60] + 0.006)
    assert ground.height_at(*foot[:2]) == pytest.approx(foot[2], abs=0.004)


# what is seen


def test_unknown_ground_is_flat_or_forbidden_as_told():
    assert not blank("flat").map.forbidden.any()
    assert blank("forbidden").map.forbidden.all()
    assert not blank("flat").map.known.any()
    with pytest.raises(ValueError, match="there are: flat, forbidden"):
        blank("maybe")


def test_what_is_seen_is_known_and_allowed():
    belief = blank("forbidden")
    rows, columns = (index.ravel() + 20 for index in np.indices((10, 10)))
    ground = belief.observe(rows, columns, np.full(100, 0.2))
    assert ground.known.sum() == 100
    assert np.array_equal(ground.forbidden, ~ground.known)
    assert ground.heights[25, 25] == 0.2


@pytest.mark.parametrize("unknown", ["flat", "forbidden"])
def test_a_map_seen_bit_by_bit_is_the_map_seen_at_once(unknown):
    heights = hills(3)
    belief, rng = blank(unknown), np.random.default_rng(5)
    rows, columns, values = everything(heights)
    order = rng.permutation(rows.size)
    for part in np.array_split(order, 40):
        ground = belief.observe(rows[part], columns[part], values[part])
    assert np.array_equal(ground.forbidden, classify(heights, CELL, MACHINE))
    assert np.array_equal(ground.heights, heights, equal_nan=True)


def test_what_a_map_had_worked_out_stays_right_in_the_next():
    heights, belief, rng = hills(4), blank(), np.random.default_rng(6)
    rows, columns, values = everything(heights)
    for part in np.array_split(rng.permutation(rows.size), 9):
        ground = belief.observe(rows[part], columns[part], values[part])
        fresh = TerrainMap(
            ground.heights,
            ground.forbidden,
            ground.cell,
            ground.origin,
            ground.foot_radius,
            ground.known,
        )
        assert np.array_equal(np.array(ground.crest_view), np.array(fresh.crest_view))


def test_no_news_no_new_map():
    belief = blank()
    rows, columns, values = everything(np.zeros((80, 120)))
    first = belief.observe(rows, columns, values)
    assert belief.observe(rows, columns, values + 0.001) is first
    assert belief.publish() is first


def test_noise_averages_out():
    belief, rng = blank(), np.random.default_rng(1)
    rows, columns, values = everything(np.zeros((80, 120)))
    for _ in range(16):
        belief.see(rows, columns, values + rng.normal(0.0, 0.01, values.size))
    assert belief.heights.std() < 0.004
    assert not belief.publish().forbidden.any()


def test_ground_that_has_changed_is_believed_at_once():
    belief = blank()
    at = np.array([40]), np.array([40])
    for _ in range(20):
        belief.see(*at, np.array([0.0]))
    assert belief.observe(*at, np.array([0.3])).heights[40, 40] == pytest.approx(0.3)
    assert math.isnan(belief.observe(*at, np.array([math.nan])).heights[40, 40])
    assert belief.map.forbidden[40, 40]


def test_a_side_says_at_least_so_high_and_a_top_how_high():
    belief, at = blank(), (np.array([40]), np.array([40]))
    side, top = np.array([True]), np.array([False])
    assert belief.observe(*at, np.array([0.1]), side).heights[40, 40] == 0.1
    assert belief.observe(*at, np.array([0.25]), side).heights[40, 40] == 0.25
    assert belief.observe(*at, np.array([0.3]), top).heights[40, 40] == 0.3
    assert belief.observe(*at, np.array([0.2]), side).heights[40, 40] == 0.3


# what is touched, learnt, supposed


def test_a_foot_on_the_ground_is_certain_of_it():
    belief = blank("forbidden")
    belief.touch([(0.01, 0.01, 0.12)])
    ground = belief.publish()
    assert ground.allows(0.01, 0.01) and ground.height_at(0.01, 0.01) == 0.12
    assert ground.known.sum() == 9  # the sole's radius is one cell and a bit


def test_a_touch_on_final_ground_says_nothing_of_the_next_cell():
    belief = blank("forbidden", final=True)
    belief.touch([(0.01, 0.01, 0.12)])
    assert belief.publish().known.sum() == 1


def test_what_has_been_learnt_stays_learnt_whatever_the_eye_says():
    belief = blank()
    belief.learn([(40, 40)])
    rows, columns, values = everything(np.zeros((80, 120)))
    assert belief.observe(rows, columns, values).forbidden[40, 40]
    belief.forget([(40, 40)])
    assert not belief.publish().forbidden.any()


def test_unknown_ground_is_as_high_as_the_nearest_foot():
    belief = blank()
    feet = [(0.4, 0.4, 0.15), (-0.4, 0.4, 0.0), (-0.4, -0.4, 0.0), (0.4, -0.4, 0.0)]
    belief.set_prior(feet)
    ground = belief.publish()
    assert ground.height_at(0.6, 0.5) == 0.15 and ground.height_at(0.6, -0.5) == 0.0
    belief.set_prior([(x, y, 0.15) for x, y, _ in feet])
    assert belief.publish().height_at(0.6, -0.5) == pytest.approx(0.15)


def test_unknown_ground_ahead_is_on_the_level_that_feet_go_on_standing_on():
    belief = blank(shape=(80, 280))
    feet = [(0.4, 0.4, 0.3), (-0.4, 0.4, 0.3), (-0.4, -0.4, 0.3), (0.4, -0.4, 0.3)]
    belief.set_prior(feet)
    assert belief.publish().height_at(4.5, 0.0) == 0.0
    for step in range(1, 8):
        belief.set_prior([(x + 0.5 * step, y, z) for x, y, z in feet])
        ground = belief.publish()
        assert ground.height_at(0.4 + 0.5 * step + 0.7, 0.0) == pytest.approx(0.3)
    assert belief.publish() is ground


def test_what_is_touched_felt_and_learnt_is_in_the_map_before_what_has_been_seen():
    belief = blank()
    rows, columns, values = everything(np.full((80, 120), 0.2))
    far = columns > 60
    belief.see(rows[far], columns[far], values[far])
    belief.touch([(-0.5, -0.5, 0.1)])
    belief.feel({(10, 10): 0.3, (11, 10): math.nan})
    belief.learn([(30, 30)])
    ground = belief.publish_worked()
    assert ground.height_at(-0.5, -0.5) == 0.1 and ground.heights[10, 10] == 0.3
    assert ground.forbidden[11, 10] and ground.forbidden[30, 30]
    assert not ground.known[:, 70:].any()
    assert belief.publish().known[:, 70:].all()


def test_feet_that_have_not_moved_are_no_news():
    belief = blank()
    feet = [(0.4, 0.4, 0.15), (-0.4, 0.4, 0.0), (-0.4, -0.4, 0.0), (0.4, -0.4, 0.0)]
    belief.set_prior(feet)
    before = belief.publish()
    belief.set_prior([(x + 1e-9, y, z) for x, y, z in feet])
    assert belief.publish() is before
    belief.set_prior([(x + 0.01, y, z) for x, y, z in feet])
    assert belief.publish() is not before


def test_level_feet_on_supposed_level_are_no_news():
    belief = blank()
    before = belief.publish()
    belief.set_prior([(0.4, 0.4, 0.001), (-0.4, 0.4, 0.0), (-0.4, -0.4, 0.0), (0.4, -0.4, -0.001)])
    assert belief.publish() is before


def test_gaps_between_what_is_seen_are_filled_by_what_is_around():
    belief = blank()
    rows, columns, values = everything(np.full((80, 120), 0.4))
    some = (rows % 2 == 0) & (columns % 2 == 0)
    ground = belief.observe(rows[some], columns[some], values[some])
    assert np.allclose(ground.heights, 0.4)
    assert ground.known.mean() == 0.25 and not ground.forbidden.any()
