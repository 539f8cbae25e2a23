"""The capture-point margin, by hand."""

import math

import pytest

from walking_console.planner.stability import capture_margin, support_polygon

SQUARE = support_polygon([(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)])


def test_a_body_at_rest_has_its_polygon_margin():
    assert capture_margin(SQUARE, 0.4, 0.0, (0.0, 0.0), 0.85) == pytest.approx(0.1)


def test_a_stop_from_eight_centimetres_a_second_needs_twenty_three_millimetres():
    margin = capture_margin(SQUARE, 0.4, 0.0, (0.08, 0.0), 0.85)
    assert margin == pytest.approx(0.1 - 0.0235, abs=1e-4)
    assert margin == pytest.approx(0.1 - 0.08 * math.sqrt(0.85 / 9.81))


def test_moving_away_from_the_nearest_edge_adds_nothing():
    assert capture_margin(SQUARE, 0.4, 0.0, (-0.08, 0.0), 0.85) == pytest.approx(0.1)


def test_two_feet_have_no_margin():
    assert capture_margin(SQUARE[:2], 0.0, 0.0, (0.0, 0.0), 0.85) == -math.inf
