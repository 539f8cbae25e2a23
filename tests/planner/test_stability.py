"""The support polygon and the margins."""

import math

import numpy as np
import pytest

from walking_console.planner.geometry.paths import ArcPath
from walking_console.planner.stability import (
    energy_margin,
    least_polygon_margin,
    longitudinal_margin,
    polygon_margin,
    polygon_margin_on,
    stable_interval,
    support_polygon,
)

SQUARE = [(-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.5, 0.5, 0.0), (-0.5, 0.5, 0.0)]


def test_the_polygon_runs_counter_clockwise_whatever_the_order_of_the_feet():
    rng = np.random.default_rng(1)
    for _ in range(200):
        points = [tuple(p) for p in rng.uniform(-1, 1, (int(rng.integers(3, 9)), 2))]
        polygon = support_polygon(points)
        area = sum(
            a[0] * b[1] - b[0] * a[1]
            for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True)
        )
        assert area > 0.0
        assert all(polygon_margin(polygon, *p) >= -1e-12 for p in points)


def test_a_foot_inside_the_others_is_no_corner():
    assert len(support_polygon([*SQUARE, (0.1, 0.0, 0.0)])) == 4


def test_two_feet_make_no_polygon_and_no_stability():
    polygon = support_polygon(SQUARE[:2])
    assert polygon_margin(polygon, 0.0, 0.0) == -math.inf
    assert longitudinal_margin(polygon, 0.0, 0.0, 1.0, 0.0) <= 0.0


def test_the_interval_ends_where_the_course_leaves_the_polygon():
    low, high = stable_interval(support_polygon(SQUARE), 0.1, 0.0, 1.0, 0.0)
    assert (low, high) == pytest.approx((-0.6, 0.4))
    low, high = stable_interval(support_polygon(SQUARE), -2.0, 0.0, 1.0, 0.0)
    assert (low, high) == pytest.approx((1.5, 2.5))
    low, high = stable_interval(support_polygon(SQUARE), -2.0, 0.6, 1.0, 0.0)
    assert low > high


def test_points_of_the_interval_are_inside_and_points_beyond_are_not():
    rng = np.random.default_rng(2)
    for _ in range(300):
        polygon = support_polygon([tuple(p) for p in rng.uniform(-1, 1, (4, 2))])
        angle = rng.uniform(-math.pi, math.pi)
        x, y = rng.uniform(-1, 1, 2)
        ux, uy = math.cos(angle), math.sin(angle)
        low, high = stable_interval(polygon, x, y, ux, uy)
        if low > high:
            continue
        middle = (low + high) / 2
        assert polygon_margin(polygon, x + middle * ux, y + middle * uy) >= -1e-12
        for s in (low - 1e-6, high + 1e-6):
            assert polygon_margin(polygon, x + s * ux, y + s * uy) < 1e-12


def test_the_longitudinal_margin_is_the_nearer_end_and_negative_outside():
    polygon = support_polygon(SQUARE)
    assert longitudinal_margin(polygon, 0.2, 0.0, 1.0, 0.0) == pytest.approx(0.3)
    assert longitudinal_margin(polygon, 0.2, 0.0, 0.0, 1.0) == pytest.approx(0.5)
    assert longitudinal_margin(polygon, 0.7, 0.0, 1.0, 0.0) == pytest.approx(-0.2)


def test_the_energy_margin_of_a_square_stand_is_the_rise_over_one_side():
    # centre 0.8 m over the middle of a 1 m square: it swings on a radius of hypot(0.5, 0.8)
    assert energy_margin(SQUARE, (0.0, 0.0, 0.8)) == pytest.approx(math.hypot(0.5, 0.8) - 0.8)
    assert energy_margin(SQUARE, (0.6, 0.0, 0.8)) < 0.0


def test_tipping_over_a_sloping_edge_costs_less_than_over_a_level_one():
    level = [(0.0, -0.5, 0.0), (0.0, 0.5, 0.0), (-1.0, 0.0, 0.0)]
    sloping = [(0.0, -0.5, -0.3), (0.0, 0.5, 0.3), (-1.0, 0.0, 0.0)]
    assert energy_margin(sloping, (-0.3, 0.0, 0.8)) < energy_margin(level, (-0.3, 0.0, 0.8))


def test_the_least_margin_on_a_stretch_of_path_is_that_of_its_worst_place():
    square = support_polygon(SQUARE)
    ahead = ArcPath(1.0, 0.0)
    assert polygon_margin_on(ahead, square, 0.0, 0.4) == pytest.approx(0.1)
    assert polygon_margin_on(ahead, square, 0.4, 0.0) == pytest.approx(0.1)
    assert polygon_margin_on(ahead, square, -0.2, 0.2) == pytest.approx(0.3)
    half_round = ArcPath(1.0, 0.0, math.pi / 0.8)
    middle = 0.8 / math.pi  # its radius: half a turn in 0.8 m ends two of them to the left
    assert polygon_margin_on(half_round, square, 0.0, 0.8) == pytest.approx(0.5 - 2 * middle)


def test_the_least_margin_of_places_is_that_of_the_nearest_to_an_edge_or_farthest_outside():
    rng = np.random.default_rng(11)
    polygon = support_polygon(rng.uniform(-0.5, 0.5, (5, 2)).tolist())
    for reach in (0.1, 0.6):
        places = [(float(x), float(y)) for x, y in rng.uniform(-reach, reach, (20, 2))]
        margins = [polygon_margin(polygon, *place) for place in places]
        assert least_polygon_margin(polygon, places) == min(margins)
    assert least_polygon_margin((), [(0.0, 0.0)]) == -math.inf
    assert least_polygon_margin(polygon, []) == math.inf
