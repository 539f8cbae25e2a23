"""The reference of a step as a smooth course."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.planner.motion.test_body_sway import GAIT, TITAN, walked
from walking_console.planner.motion.body_course import Course, centre_over, first_swing
from walking_console.planner.stability import polygon_margin
from walking_console.planner.types import Phase

STANCE, DECIDED, _ = walked(30, 4)[2]


def bent_course(turn: float) -> Course:
    """A step along an arc of a metre's radius."""
    count = 9
    angles = np.linspace(0.0, turn, count)
    body = np.stack([np.sin(angles), 1.0 - np.cos(angles), np.full(count, 0.85), angles], axis=1)
    plan = replace(
        DECIDED,
        times=np.linspace(0.0, 2.0, count),
        body=body,
        feet=np.repeat(DECIDED.feet[:1], count, axis=0),
        phases=(Phase.SUPPORT,) * (count - 1),
        crab_angle=0.0,
    )
    return Course.of(plan, STANCE, TITAN)


def test_on_a_line_it_is_the_line():
    course = Course.of(DECIDED, STANCE, TITAN)
    x, y, _, _ = course.at(course.length / 2)
    middle = (DECIDED.body[0, :2] + DECIDED.body[-1, :2]) / 2
    assert (x, y) == pytest.approx(tuple(middle), abs=1e-9)
    assert course.heading(0.3 * course.length) == pytest.approx(math.radians(30))
    assert course.flat(0.0) == pytest.approx(1.0)


def test_on_an_arc_it_stays_on_the_arc_and_its_direction_turns_evenly():
    course = bent_course(0.3)
    for share in np.linspace(0.0, 1.0, 21):
        x, y, _, yaw = course.at(share * course.length)
        assert math.hypot(x, y - 1.0) == pytest.approx(1.0, abs=1e-5)
        assert course.heading(share * course.length) == pytest.approx(yaw, abs=2e-3)


def test_its_slope_is_the_change_of_its_places():
    course = bent_course(0.3)
    for length in np.linspace(0.05, 0.4, 8):
        ahead = np.array(course.at(length + 1e-5))
        behind = np.array(course.at(length - 1e-5))
        assert tuple((ahead - behind) / 2e-5) == pytest.approx(course.slope(length), abs=1e-6)


def test_places_next_to_each_other_do_not_make_it_swing_to_and_fro():
    body = np.repeat(DECIDED.body[:1], 4, axis=0)
    body[:, 0] += (0.0, 0.05, 0.0502, 0.1)
    body[:, 1] += (0.0, 0.0, 0.0002, 0.0)
    plan = replace(
        DECIDED,
        times=np.linspace(0.0, 1.0, 4),
        body=body,
        feet=np.repeat(DECIDED.feet[:1], 4, axis=0),
        phases=(Phase.SUPPORT,) * 3,
    )
    course = Course.of(plan, STANCE, TITAN)
    for length in np.linspace(0.0, course.length, 50):
        assert abs(course.heading(length)) < 0.1


def test_bounds_keep_the_margin_of_the_true_centre_of_gravity():
    course = Course.of(DECIDED, STANCE, TITAN)
    when = course.lifting(course.lift_length)
    low, high = course.bounds_at(when, course.after, 0.02)
    assert low < high
    lift = first_swing(DECIDED.phases)
    x, y, z, yaw = course.at(when.length)
    sx, sy = course.sway.side(when.length)
    for aside in (low, high):
        body = (x + aside * sx, y + aside * sy, z, yaw)
        dx, dy = centre_over(TITAN, body, DECIDED.feet[lift].tolist())
        assert polygon_margin(course.after, body[0] + dx, body[1] + dy) >= 0.02 - 1e-6


def test_a_leg_that_lifts_farther_on_leaves_the_centre_of_gravity_behind_with_the_feet():
    course = Course.of(DECIDED, STANCE, TITAN)
    feet = DECIDED.feet[first_swing(DECIDED.phases)].tolist()
    near = course.lifting(course.lift_length).centre
    when = course.lifting(course.lift_length + 0.05)
    assert when.centre == pytest.approx(centre_over(TITAN, course.at(when.length), feet), abs=1e-6)
    assert math.dist(near, when.centre) > 0.002


def test_no_offset_takes_a_standing_foot_out_of_its_mechanical_reach():
    course = Course.of(DECIDED, STANCE, TITAN)
    narrow = replace(TITAN, overreach=(0.004, 0.004, 0.15))
    tight = Course.of(DECIDED, STANCE, narrow)
    when = course.lifting(course.lift_length)
    wide_low, wide_high = course.bounds_at(when, course.after, 0.0)
    low, high = tight.bounds_at(when, tight.after, 0.0)
    assert wide_low <= low <= high <= wide_high


def test_it_sways_away_from_an_edge_that_its_course_runs_along():
    course = Course.of(DECIDED, STANCE, TITAN)
    before = course.sway.aside
    course.turn_to_safety(GAIT.margin)
    assert course.sway.aside == before  # there is margin enough across the course
