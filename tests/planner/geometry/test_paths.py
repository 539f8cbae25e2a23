"""Distance along a course, and how long a standing foot stays within reach of it."""

import math

import numpy as np
import pytest

from walking_console.planner.geometry.paths import (
    NOWHERE,
    ArcPath,
    SampledPath,
    arc_of_command,
    bounded_by,
    corners_of_box,
    line_exit,
    line_segment,
)

BOX = (0.20, 0.70, 0.30, 0.65)  # titan3, front left


def test_the_exit_is_h_equations_4_to_9():
    assert line_exit(0.45, 0.475, BOX, 1.0, 0.0) == pytest.approx(0.25)  # (4): (x − x0) / cos α
    assert line_exit(0.45, 0.475, BOX, 0.0, 1.0) == pytest.approx(0.175)  # (6): (y − y0) / sin α
    # (8): (y − y0 − y*) / sin α
    assert line_exit(0.45, 0.475, BOX, 0.0, -1.0) == pytest.approx(0.175)
    assert line_exit(0.45, 0.475, BOX, -1.0, 0.0) == pytest.approx(0.25)


def test_an_interval_is_cut_by_every_bound_and_empty_where_one_leaves_nothing():
    assert bounded_by([(2.0, 3.0), (-1.0, 0.5)], -4.0, 4.0, 0.0) == (-0.5, 1.5)
    assert bounded_by([(0.0, 0.1)], -4.0, 4.0, 0.0) == (-4.0, 4.0)
    assert bounded_by([(0.0, -0.1)], -4.0, 4.0, 0.0) == NOWHERE
    assert bounded_by([(1.0, 1.0), (-1.0, -1.1)], -4.0, 4.0, 0.0) == NOWHERE
    assert bounded_by([(1.0, 1.0), (-1.0, -1.1)], -4.0, 4.0, 0.2) == (1.1, 1.0)


def test_the_corners_of_a_box_go_round_it_to_the_left():
    assert corners_of_box((0.0, 2.0, 1.0, 4.0)) == [(0, 1), (2, 1), (2, 4), (0, 4)]


def test_an_exit_already_passed_is_negative():
    assert line_exit(0.1, 0.475, BOX, 1.0, 0.0) == pytest.approx(-0.1)


def test_the_segment_holds_just_the_s_at_which_the_foot_is_within_reach():
    rng = np.random.default_rng(3)
    for _ in range(500):
        angle, turn = (
            rng.uniform(-math.pi, math.pi),
            float(rng.choice([0.0, rng.uniform(-1.4, 1.4)])),
        )
        scale = math.sqrt(max(0.0, 1.0 - (0.65 * turn) ** 2))
        arc = ArcPath(scale * math.cos(angle), scale * math.sin(angle), turn)
        x, y = rng.uniform(0.2, 0.7), rng.uniform(0.3, 0.65)
        s1, s2 = arc.segment(x, y, BOX)
        assert s1 <= 1e-9 and s2 >= -1e-9
        for s in np.linspace(max(s1, -1.0) + 1e-6, min(s2, 1.0) - 1e-6, 11):
            bx, by = arc.seen(x, y, float(s))
            assert BOX[0] - 1e-7 <= bx <= BOX[1] + 1e-7 and BOX[2] - 1e-7 <= by <= BOX[3] + 1e-7
        if math.isfinite(s2):
            bx, by = arc.seen(x, y, s2 + 1e-5)
            assert not (BOX[0] <= bx <= BOX[1] and BOX[2] <= by <= BOX[3])


def test_a_foothold_that_never_comes_within_reach_has_no_segment():
    s1, s2 = line_segment(0.45, 0.9, BOX, 1.0, 0.0)
    assert s1 > s2


def test_a_turn_on_the_spot_has_a_length():
    arc, pace = arc_of_command(0.3, 0.0, 0.2, 0.65)
    assert pace == pytest.approx(0.13)
    assert (arc.ux, arc.uy) == pytest.approx((0.0, 0.0))
    assert arc.pose(0.65 * math.pi)[2] == pytest.approx(math.pi)


def test_an_arc_ends_up_where_small_steps_along_it_do():
    arc, _ = arc_of_command(0.4, 0.1, 0.15, 0.65)
    x = y = yaw = 0.0
    steps = 20000
    for _ in range(steps):
        h = 1.0 / steps
        middle = yaw + arc.turn * h / 2
        x += h * (arc.ux * math.cos(middle) - arc.uy * math.sin(middle))
        y += h * (arc.ux * math.sin(middle) + arc.uy * math.cos(middle))
        yaw += arc.turn * h
    assert arc.pose(1.0) == pytest.approx((x, y, yaw), abs=1e-8)


def test_the_nearest_point_of_a_course_is_looked_for_near_a_place_on_it():
    x = np.arange(301) * 0.01
    line = SampledPath(0.01, x, np.zeros(301), np.zeros(301))
    assert line.nearest(1.0, 1.234, -0.05) == pytest.approx((1.234, 0.05))
    assert line.nearest(0.2, 1.234, 0.0) == pytest.approx((0.7, 0.534))  # no farther than within
    assert line.nearest(2.9, 3.5, 0.0) == pytest.approx((3.0, 0.5))
    spot = SampledPath(0.01, np.ones(50), np.ones(50), x[:50])
    assert spot.nearest(0.3, 1.0, 1.02)[1] == pytest.approx(0.02)
