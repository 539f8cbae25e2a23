"""Cutting convex polygons, and their nearest points."""

import math
from itertools import permutations

import numpy as np
import pytest

from walking_console.planner.geometry.polygons import (
    beside,
    clipped,
    convex_hull,
    inside_of,
    nearest_of,
    triangle,
)
from walking_console.planner.stability import polygon_margin, support_polygon

SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]


@pytest.mark.parametrize("count", [3, 4, 5])
def test_a_hull_turns_left_around_all_points_wherever_it_is_begun(count):
    """In every order of the points, those among them in which the legs of a machine stand."""
    rng = np.random.default_rng(count)
    for _ in range(100):
        points = [tuple(point) for point in rng.integers(-3, 4, (count, 2)).tolist()]
        hulls = [convex_hull(order) for order in permutations(points)]
        assert len({frozenset(hull) for hull in hulls}) == 1
        for hull in hulls:
            if len(hull) < 3:
                continue
            for a, b in zip(hull, hull[1:] + hull[:1], strict=True):
                lefts = [cross(a, b, point) for point in points]
                assert min(lefts) >= 0 and max(lefts) > 0
                assert all(cross(a, b, corner) > 0 for corner in hull if corner not in (a, b))


def cross(a, b, point):
    return (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])


def test_a_triangle_of_three_points_on_one_line_is_that_line():
    assert triangle((0.0, 0.0), (2.0, 0.0), (1.0, 0.0)) == ((0.0, 0.0), (2.0, 0.0))
    assert triangle((0.0, 0.0), (0.0, 1.0), (1.0, 0.0)) == ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))


def test_a_cut_keeps_one_side_of_its_line():
    assert clipped(SQUARE, 1.0, 0.0, -0.25) == [(0.25, 0.0), (1.0, 0.0), (1.0, 1.0), (0.25, 1.0)]
    assert clipped(SQUARE, 1.0, 0.0, -2.0) == []
    assert clipped(SQUARE, 1.0, 0.0, 0.0) == SQUARE


def test_a_polygon_that_is_a_mere_line_is_not_lost_on_the_line_of_a_cut():
    line = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (0.0, 0.0)]
    assert clipped(line, 0.0, 1.0, -1e-10) == line


def test_beside_keeps_what_is_left_of_a_line_by_an_inset():
    kept = beside(SQUARE, (0.0, 0.5), (1.0, 0.5), 0.1)
    expected = [(0.0, 0.6), (0.0, 1.0), (1.0, 0.6), (1.0, 1.0)]
    np.testing.assert_allclose(sorted(kept), expected, atol=1e-12)


def test_what_is_inside_another_polygon_keeps_the_inset_wherever_it_is_moved():
    rng = np.random.default_rng(3)
    for _ in range(200):
        triangle = support_polygon(rng.uniform(-1.0, 2.0, (3, 2)).tolist())
        inset = float(rng.uniform(0.0, 0.1))
        dx, dy = rng.uniform(-0.3, 0.3, 2).tolist()
        for x, y in inside_of(SQUARE, triangle, inset, dx, dy):
            assert polygon_margin(triangle, x + dx, y + dy) >= inset - 1e-9
            assert -1e-9 <= x <= 1 + 1e-9 and -1e-9 <= y <= 1 + 1e-9


def test_no_point_of_a_polygon_is_nearer_than_the_nearest():
    rng = np.random.default_rng(4)
    triangle = list(support_polygon([(0.0, 0.0), (1.0, 0.2), (0.3, 0.9)]))
    for x, y in rng.uniform(-1.0, 2.0, (200, 2)).tolist():
        nx, ny = nearest_of(triangle, x, y)
        away = math.hypot(nx - x, ny - y)
        if polygon_margin(tuple(triangle), x, y) >= 0.0:
            assert away == 0.0
        for w in rng.dirichlet((1.0, 1.0, 1.0), 40):
            px, py = w @ np.array(triangle)
            assert math.hypot(px - x, py - y) >= away - 1e-9


def test_of_a_polygon_that_is_a_mere_line_the_nearest_point_is_on_it():
    line = [(0.1, 0.0), (0.3, 0.0), (0.3, 0.0), (0.1, 0.0)]
    assert nearest_of(line, 0.0, 0.0) == (0.1, 0.0), "in its prolongation: on the left of no edge"
    assert nearest_of(line, 0.2, 0.5) == pytest.approx((0.2, 0.0))
    assert nearest_of(SQUARE, 0.5, 0.0) == (0.5, 0.0)
    assert nearest_of(SQUARE, 0.25, 0.5) == (0.25, 0.5)
