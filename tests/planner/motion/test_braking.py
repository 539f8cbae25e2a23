"""A body that walks comes to rest along its plan, within what its margin allows."""

import math

import numpy as np
import pytest

from tests.planner.motion.test_body_sway import GAIT, TITAN, walked
from walking_console.planner.control.tracking import TrajectoryTracker
from walking_console.planner.motion.body_bounds import Bounds, CarryingFeet, bounds_of
from walking_console.planner.motion.body_course import centre_over
from walking_console.planner.motion.braking import Braking, braking
from walking_console.planner.motion.step_builder import holding_plan
from walking_console.planner.stability import polygon_margin, support_polygon
from walking_console.planner.types import TICK, Phase

STEPS = walked(45, 6)
BOUNDS = bounds_of(STEPS[0][0], GAIT)
MOST = BOUNDS.acceleration
GIVEN = CarryingFeet(
    (), (0.0, 0.0), Bounds(0.02, MOST)
)  # it slows down by MOST whatever carries it


def stopped(
    step: int, share: float, pace: float = 1.0, support: CarryingFeet = GIVEN
) -> tuple[TrajectoryTracker, float, Braking]:
    tracker = TrajectoryTracker(STEPS[step][2])
    t = share * tracker.duration
    way = braking(tracker, t, pace, support, TITAN.yaw_length)
    assert way is not None
    return tracker, t, way


def carried(step: int, share: float, width: float = 0.0) -> CarryingFeet:
    """What carries the body so far into a step; ``width`` (m): a square about its place instead."""
    tracker = TrajectoryTracker(STEPS[step][2])
    t = share * tracker.duration
    body = tracker.body_at(t)
    feet = [tracker.foot_at(leg, t) for leg in range(4)]
    on = [leg for leg in range(4) if leg not in STEPS[step][2].swing]
    x, y = (body[axis] + centre_over(TITAN, body, feet)[axis] for axis in (0, 1))
    square = [(x + a * width, y + b * width, 0.0) for a in (-1, 1) for b in (-1, 1)]
    polygon = support_polygon(square if width else [feet[leg] for leg in on])
    return CarryingFeet(polygon, (x - body[0], y - body[1]), BOUNDS)


def least_margin(way: Braking, support: CarryingFeet) -> float:
    """Of the zero-moment point while the body slows down, m."""
    places = np.array([place[:2] for place in way.body]) + support.centre
    slowing = np.diff(places, 2, axis=0) / TICK**2
    points = places[1:-1] - BOUNDS.height / 9.81 * slowing
    return min(polygon_margin(support.polygon, x, y) for x, y in points)


@pytest.mark.parametrize("share", np.linspace(0.45, 0.85, 5))
@pytest.mark.parametrize("step", [2, 3, 4])
def test_on_the_feet_that_carry_it_stops_sooner_and_its_zero_moment_point_stays_inside(step, share):
    support = carried(step, share)
    _, _, way = stopped(step, share, support=support)
    assert way.safe and way.seconds < stopped(step, share)[2].seconds
    assert least_margin(way, support) >= 0.003


def test_a_body_too_fast_for_the_edge_ahead_of_it_says_so():
    assert stopped(3, 0.5, support=carried(3, 0.5, 0.08))[2].safe
    assert not stopped(3, 0.5, support=carried(3, 0.5, 0.012))[2].safe


def test_a_body_too_fast_for_the_edge_slows_down_harder_and_rests_inside_of_it_where_it_can():
    narrow = carried(3, 0.5, 0.005)
    _, _, way = stopped(3, 0.5, support=narrow)
    assert not way.safe and narrow.margin(way.body[-1][:2]) >= 0.0
    edge = carried(3, 0.5, 0.001)
    assert stopped(3, 0.5, support=edge)[2].seconds <= way.seconds


@pytest.mark.parametrize("share", np.linspace(0.05, 0.99, 9))
@pytest.mark.parametrize("step", [2, 3])
def test_it_begins_where_the_plan_is_and_ends_at_rest(step, share):
    tracker, t, way = stopped(step, share)
    assert way.body[0] == tracker.body_at(t)
    assert way.rates[0] == pytest.approx(tracker.velocity_at(t))
    assert way.rates[-1] == (0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("share", np.linspace(0.05, 0.99, 9))
def test_it_slows_down_by_no_more_than_it_may_and_takes_no_longer_than_it_must(share):
    tracker, t, way = stopped(3, share)
    places = np.array(way.body)[:, :2]
    slowing = np.hypot(*(np.diff(places, 2, axis=0) / TICK**2).T)
    assert slowing.max(initial=0.0) <= 1.4 * MOST
    vx, vy, _, _ = tracker.velocity_at(t)
    assert way.seconds <= math.hypot(vx, vy) / (0.3 * MOST) + 2 * TICK


def test_it_stays_on_the_planned_way_as_long_as_there_is_one():
    tracker, t, way = stopped(3, 0.3)
    planned = np.array([tracker.body_at(s)[:2] for s in np.linspace(t, tracker.duration, 2000)])
    for x, y, _, _ in way.body:
        assert np.hypot(planned[:, 0] - x, planned[:, 1] - y).min() < 1e-4


def test_a_body_that_stands_needs_no_way_to_rest():
    tracker = TrajectoryTracker(STEPS[3][2])
    assert braking(tracker, 0.5, 0.0, GIVEN, TITAN.yaw_length) is None
    held = TrajectoryTracker(holding_plan(STEPS[0][0]))
    assert braking(held, 0.0, 1.0, GIVEN, TITAN.yaw_length) is None


def test_laid_onto_a_plan_it_moves_the_body_and_leaves_the_feet():
    _, _, way = stopped(3, 0.5)
    still = holding_plan(way.rest_of(STEPS[3][0]))
    plan = way.onto(still)
    assert tuple(plan.body[0]) == pytest.approx(way.body[0])
    assert tuple(plan.body[-1]) == pytest.approx(way.body[-1]) == still.end.body
    assert np.ptp(plan.feet, axis=0).max() == 0.0 and set(plan.phases) == {Phase.SHIFT}
    tracker = TrajectoryTracker(plan)
    assert tracker.rests_from <= way.seconds + 1e-9 < tracker.duration


def test_from_another_place_it_is_the_same_way():
    _, _, way = stopped(3, 0.5)
    moved = way.moved(0.1, -0.2)
    assert moved.body[-1][:2] == pytest.approx((way.body[-1][0] + 0.1, way.body[-1][1] - 0.2))
    assert moved.rates == way.rates
