"""Level B3: the height of the body from the leading feet, and what the torso must clear."""

import math

import numpy as np
import pytest

from walking_console.planner.motion.body_height import (
    FeetHeights,
    body_height,
    ground_ahead,
    torso_needs,
    torso_needs_exactly,
)
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap

TITAN = load_machine("titan3")


def printed_20(left, right, at):
    """(20) as printed: interpolation by x."""
    return ((at - right[0]) * left[2] + (left[0] - at) * right[2]) / (left[0] - right[0])


def test_the_height_ahead_is_interpolated_along_the_line_of_the_leading_feet():
    left, right = (0.6, 0.4, 0.1), (0.4, -0.4, 0.3)
    height, away = ground_ahead(left, right, 1.0, 0.0)
    assert (height, away) == (pytest.approx(0.2), pytest.approx(0.5))
    assert height == pytest.approx(printed_20(left, right, 0.5))


def test_errata_20_feet_level_in_x_are_no_division_by_zero():
    left, right = (0.5, 0.4, 0.0), (0.5, -0.4, 0.2)
    with pytest.raises(ZeroDivisionError):
        printed_20(left, right, 0.5)
    assert ground_ahead(left, right, 1.0, 0.0) == (pytest.approx(0.1), pytest.approx(0.5))


def test_a_course_that_misses_the_leading_feet_takes_their_mean():
    assert ground_ahead((0.6, 0.2, 0.1), (0.5, 0.1, 0.3), 1.0, 0.0)[0] == pytest.approx(0.2)
    assert ground_ahead((0.5, 0.2, 0.1), (0.6, 0.2, 0.3), 1.0, 0.0)[0] == pytest.approx(0.2)


def test_the_body_climbs_in_proportion_to_its_way_and_within_the_reach_of_its_feet():
    # (21)
    assert body_height(0.85, 0.1, (0.2, 0.5), 0.85, 0.0, 9.0) == pytest.approx(
        0.85 + 0.2 * 0.1 / 0.5
    )
    assert body_height(0.85, 0.1, (0.2, 0.5), 0.85, 0.0, 0.86) == 0.86
    assert body_height(0.85, 0.1, (0.2, -0.1), 0.85, 0.0, 9.0) == pytest.approx(1.05), (
        "beyond A the whole height is due"
    )


def test_the_body_stays_where_all_feet_reach_and_the_one_that_swings_until_it_is_lifted():
    feet = FeetHeights(TITAN, [0.0, 0.2, 0.1, 0.0], 0.9)
    assert feet.limits(3, 0.0, 0.0) == (pytest.approx(0.8), pytest.approx(1.1))
    assert feet.limits(1, 0.1, 0.0) == (pytest.approx(0.7), pytest.approx(1.1)), (
        "the foot of 0.2 m is put down on 0.1 m"
    )
    # half the way there it still stands: as low as 0.8 m there is 0.7 m at the end of the way
    assert feet.limits(1, 0.1, 0.5) == (pytest.approx(0.7), pytest.approx(1.1))
    assert feet.limits(1, 0.1, 1.0) == (pytest.approx(0.8), pytest.approx(1.1))
    assert feet.mean(1, 0.1) == pytest.approx(0.05)


def test_the_torso_is_held_against_its_turned_rectangle_when_the_square_is_too_coarse():
    heights = np.zeros((200, 200))
    # 0.6 m beside the body: in the square, beyond the torso's width, but under its turned length
    heights[112, 100] = 2.0
    ground = TerrainMap(heights, heights > 1.0, 0.05, (-5.0, -5.0))
    assert torso_needs(ground, TITAN, 0.0, 0.0, 0.0) > 2.0
    assert torso_needs_exactly(ground, TITAN, 0.0, 0.0, 0.0) < 1.0
    heights = heights.copy()
    heights[109, 100] = 2.0
    ground = TerrainMap(heights, heights > 1.0, 0.05, (-5.0, -5.0))
    assert torso_needs_exactly(ground, TITAN, 0.0, 0.0, math.pi / 2) > 2.0
