"""How fast a body may slow down: as its zero-moment point has room in the support."""

import math

import pytest

from walking_console.planner.motion.body_bounds import (
    FARTHEST,
    RESERVE,
    STEEPEST,
    Bounds,
    CarryingFeet,
    room_ahead,
)

SQUARE = ((0.0, 0.0), (0.4, 0.0), (0.4, 0.4), (0.0, 0.4))
BOUNDS = Bounds(0.02, 0.23, 0.85)


def test_the_room_ahead_ends_where_the_reserve_of_an_edge_begins():
    assert room_ahead(SQUARE, (0.1, 0.2), (1.0, 0.0)) == pytest.approx(0.3 - RESERVE)
    assert room_ahead(SQUARE, (0.1, 0.2), (-1.0, 0.0)) == pytest.approx(0.1 - RESERVE)
    assert room_ahead(SQUARE, (0.1, 0.2), (-0.6, 0.8)) == pytest.approx((0.1 - RESERVE) / 0.6)


def test_there_is_no_room_within_the_reserve_outside_or_without_a_support():
    assert room_ahead(SQUARE, (0.004, 0.2), (1.0, 0.0)) == 0.0
    assert room_ahead(SQUARE, (-0.1, 0.2), (1.0, 0.0)) == 0.0
    assert room_ahead(SQUARE[:2], (0.1, 0.0), (1.0, 0.0)) == 0.0
    assert room_ahead(SQUARE, (0.2, 0.2), (0.0, 0.0)) == FARTHEST


def test_it_slows_down_as_the_room_allows_never_less_than_on_its_way_nor_as_a_jerk():
    assert BOUNDS.steepest(0.05) == pytest.approx(9.81 * 0.05 / 0.85)
    assert BOUNDS.steepest(0.0) == BOUNDS.acceleration
    assert BOUNDS.steepest(1.0) == STEEPEST


def test_an_acceleration_that_is_given_is_kept_whatever_the_room():
    assert Bounds(0.02, 0.1).steepest(1.0) == 0.1


def test_its_margin_is_that_of_its_origin_or_of_its_centre_of_gravity_whichever_is_less():
    behind = CarryingFeet(SQUARE, (-0.03, 0.0), BOUNDS)
    assert behind.margin((0.38, 0.2)) == pytest.approx(0.02)
    assert behind.margin((0.04, 0.2)) == pytest.approx(0.01)


def test_on_a_support_it_slows_down_until_its_zero_moment_point_is_at_the_reserve_ahead():
    support = CarryingFeet(SQUARE, (0.01, 0.0), BOUNDS)
    assert support.slowing((0.34, 0.2), (1.0, 0.0)) == pytest.approx(9.81 * (0.05 - RESERVE) / 0.85)
    assert support.slowing((0.36, 0.2), (0.5, 0.0)) == pytest.approx(
        2.0 * 9.81 * (0.03 - RESERVE) / 0.85
    )
    assert support.slowing((0.1, 0.2), (1.0, 0.0)) == STEEPEST
    assert support.slowing((0.4, 0.2), (1.0, 0.0)) < 0.0
    assert CarryingFeet((), (0.0, 0.0), BOUNDS).slowing((0.0, 0.0), (1.0, 0.0)) == 0.0


def test_where_the_nearest_edge_counts_it_slows_down_by_what_the_margin_allows_at_most():
    beside = CarryingFeet(SQUARE, (0.0, 0.0), BOUNDS, nearest=True)
    for place, bends in (((0.2, 0.03), (0.0, 0.0)), ((0.2, 0.03), (0.0, 0.1))):
        slowed = beside.slowing(place, (1.0, 0.0), bends)
        assert 0.0 < slowed + math.hypot(*bends) <= 9.81 * 0.03 / 0.85
        assert slowed < beside._replace(nearest=False).slowing(place, (1.0, 0.0), bends)


def test_a_way_that_bends_takes_of_what_is_left_for_slowing_down():
    support = CarryingFeet(SQUARE, (0.0, 0.0), BOUNDS)
    slowed = support.slowing((0.35, 0.2), (1.0, 0.0), (-0.1, 0.0))
    assert slowed == pytest.approx(support.slowing((0.35, 0.2), (1.0, 0.0)) - 0.1)


def test_an_acceleration_that_is_given_is_what_a_support_allows():
    assert (
        CarryingFeet(SQUARE, (0.0, 0.0), Bounds(0.02, 0.1)).slowing((0.2, 0.2), (1.0, 0.0)) == 0.1
    )
