"""What the map says of the places the body may go to."""

import numpy as np
import pytest

from tests.planner.navigation.test_local_planner import (
    MACHINE,
    SIZE,
    at,
    level,
    map_of,
    stance_at,
    with_hole,
)
from walking_console.planner.navigation.costmap import (
    FIT,
    WALL,
    Costmap,
    Region,
    Sums,
    is_clear,
    is_plain,
    stretched_boxes,
    weight_of,
)
from walking_console.planner.types import Reason

REGION = Region.of(0.0, 0.0, 0.0, MACHINE)


def test_a_place_is_fit_exactly_when_every_leg_has_ground():
    rng = np.random.default_rng(2)
    heights = np.where(rng.random((SIZE, SIZE)) < 0.97, np.nan, 0.0)
    terrain, stance = map_of(heights), stance_at()
    costmap = Costmap(Region.of(0.0, 0.0, 0.0, MACHINE), stance, terrain, MACHINE)
    for s in np.arange(0.0, 2.5, 0.25):
        for d in np.arange(-1.5, 1.6, 0.3):
            rows, columns = costmap.at(np.array([s]), np.array([d]))
            x, y = costmap.x[columns[0]], costmap.y[rows[0]]
            boxes = [(x + b[0], x + b[1], y + b[2], y + b[3]) for b in MACHINE.boxes]
            inside = [
                terrain.forbidden[
                    at(b[2] + 0.06) : at(b[3] - 0.06), at(b[0] + 0.06) : at(b[1] - 0.06)
                ]
                for b in boxes
            ]
            around = [
                terrain.forbidden[
                    at(b[2] - 0.06) : at(b[3] + 0.11), at(b[0] - 0.06) : at(b[1] + 0.11)
                ]
                for b in boxes
            ]
            verdict = costmap.verdict[rows[0], columns[0]]
            if all(not patch.all() for patch in inside):
                assert verdict == FIT
            if any(patch.all() for patch in around):
                assert verdict != FIT


def test_open_ground_is_plain_and_a_hole_or_unknown_ground_near_is_not():
    assert is_plain(REGION, stance_at(), map_of(level()))
    assert not is_plain(REGION, stance_at(), map_of(with_hole(1.0, 1.1, 0.0, 0.1)))
    known = np.ones((SIZE, SIZE), dtype=bool)
    known[at(0.0), at(1.0)] = False
    assert not is_plain(REGION, stance_at(), map_of(level(), known=known))


def test_what_is_clear_for_certain_a_costmap_finds_fit_all_along_the_line():
    rng = np.random.default_rng(5)
    clear = []
    for _ in range(60):
        heights = level() + rng.uniform(0.0, rng.choice((0.2, 0.45)), (SIZE, SIZE))
        if rng.random() < 0.4:
            heights[tuple(rng.integers(at(-2.0), at(2.0), 2))] = np.nan
        known = np.ones((SIZE, SIZE), dtype=bool)
        known[tuple(rng.integers(at(-2.0), at(2.0), 2))] = rng.random() < 0.6
        terrain = map_of(heights, forbidden=np.isnan(heights), known=known)
        x, y = rng.uniform(-0.5, 0.5, 2)
        stance = stance_at(x, y, rng.uniform(-3.0, 3.0))
        off = rng.uniform(-0.02, 0.02)
        region = Region.of(rng.uniform(-3.0, 3.0), 0.1, off, MACHINE, toward=0.0)
        costmap = Costmap(region, stance, terrain, MACHINE)
        assert weight_of(region, terrain) == costmap.x.size * costmap.y.size // 30
        clear.append(is_clear(region, stance, terrain, MACHINE))
        if clear[-1]:
            assert costmap.straight_is_fit() and costmap.all_known
            assert costmap.known_ahead(((region.length, 0.0),)) == np.inf
    assert 10 < sum(clear) < 50


def test_ground_of_which_not_all_is_free_known_and_even_is_not_clear_for_certain():
    narrow = Region.of(0.0, 0.0, 0.0, MACHINE, toward=0.0)

    def clear(heights, **more):
        return is_clear(narrow, stance_at(), map_of(heights, **more), MACHINE)

    assert clear(level()) and clear(with_hole(1.0, 1.1, 3.0, 3.1)), "the hole is far beside it"
    assert not clear(with_hole(1.0, 1.1, 0.0, 0.1))
    known = np.ones((SIZE, SIZE), dtype=bool)
    known[at(0.0), at(1.0)] = False
    assert not clear(level(), known=known)
    low, high = MACHINE.z_range
    for height, is_even in ((0.3, True), (high - low, False)):
        block = level()
        block[at(0.0) : at(0.3), at(1.0) : at(1.3)] = height
        assert clear(block, forbidden=np.zeros((SIZE, SIZE), dtype=bool)) is is_even


def test_a_place_and_back_is_the_same_place():
    stance = stance_at(0.3, -0.2, 0.7)
    region = Region.of(0.4, 0.1, 0.05, MACHINE)
    for s, d in ((0.0, 0.05), (1.0, -0.4), (2.0, 0.8)):
        assert region.seen_from(stance, *region.place(stance, s, d)) == pytest.approx((s, d))


def test_a_lane_of_which_a_wall_leaves_less_than_a_foots_radius_is_barred():
    def verdict(wall_from):
        heights = level()
        heights[at(wall_from) : at(3.0), at(1.2) : at(1.3)] = 1.0
        costmap = Costmap(REGION, stance_at(), map_of(heights), MACHINE)
        rows, columns = costmap.at(np.array([0.8]), np.array([0.0]))
        return costmap.verdict[rows[0], columns[0]]

    inner = MACHINE.boxes[0][2]  # of the left legs' lane
    assert verdict(inner) == WALL
    assert verdict(inner + 0.1) == FIT


def test_a_line_that_is_barred_says_where_and_by_what():
    wide = map_of(with_hole(1.5, 3.5, -4.0, 4.0))
    why = Costmap(REGION, stance_at(), wide, MACHINE).why()
    assert why.reason is Reason.NO_WAY_ROUND and 0.2 < why.facts["distance"] < 2.0
    free = Costmap(REGION, stance_at(), map_of(level()), MACHINE)
    assert free.why().reason is Reason.NO_DIRECTION and free.straight_is_fit()


def test_stretched_legs_reach_farther_on_every_side():
    for box, far in zip(MACHINE.boxes, stretched_boxes(MACHINE), strict=True):
        assert far[0] < box[0] and far[1] > box[1] and far[2] < box[2] and far[3] > box[3]


def test_sums_over_rectangles_are_those_added_up_one_by_one():
    values = np.random.default_rng(3).random((7, 9))
    sums = Sums(values, 3).of((-1, 3, 0, 2))
    for row in range(7):
        for column in range(9):
            window = values[row : row + 2, max(0, column - 1) : column + 3]
            assert sums[row, column] == pytest.approx(window.sum())
