"""Swings smooth in acceleration that land softly where the ground is known."""

import math

import numpy as np
import pytest

from tests.planner.motion.test_body_sway import FLAT, GAIT, TITAN, walked
from walking_console.planner.control.tracking import TrajectoryTracker
from walking_console.planner.motion.body_sway import swaying
from walking_console.planner.motion.step_builder import plan_on_all_feet
from walking_console.planner.motion.swing_profile import (
    ABOVE,
    BELOW,
    JERKY,
    TOUCH_SPEED,
    as_planned,
    gentle,
    landing,
    legs_on_known_ground,
    quickest,
    rest_to_rest,
    smooth_swing,
)
from walking_console.planner.protocols import run_to_completion
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import TICK, Phase, StepPlan

ALL = frozenset(range(4))
STEPS = walked(30, 4)
STANCE, DECIDED, _ = STEPS[2]


def rates_of(ramps, seconds):
    return np.array([ramps.at(t)[1] for t in np.linspace(0.0, seconds, 4001)])


@pytest.mark.parametrize(
    "ramps",
    [rest_to_rest(0.4, 1.2), quickest(0.1, 0.7, JERKY), quickest(0.01, 0.7, JERKY)],
)
def test_a_ramp_goes_its_way_from_rest_to_rest_and_its_speed_has_no_jumps(ramps):
    speeds = rates_of(ramps, ramps.seconds)
    step = ramps.seconds / 4000
    assert speeds[0] == 0.0 and speeds[-1] == pytest.approx(0.0, abs=1e-9)
    way = step * (speeds[1:] + speeds[:-1]).sum() / 2.0  # by trapezoids
    assert way == pytest.approx(ramps.way, rel=1e-4)
    acceleration = np.diff(speeds) / step
    jerk = abs(np.diff(acceleration)).max() / step
    assert jerk * TICK < 60.0  # m/s² in a tick: no stairs, which are without bound


def test_the_quickest_way_keeps_its_speed_and_acceleration():
    ramps = quickest(0.5, 0.7, JERKY)
    speeds = rates_of(ramps, ramps.seconds)
    assert speeds.max() == pytest.approx(0.7)
    assert abs(np.diff(speeds)).max() / (ramps.seconds / 4000) <= 1.01 * JERKY


def test_a_landing_is_slow_from_above_the_ground_to_below_it():
    ramps = landing(0.1, 0.7)
    assert ramps.way == pytest.approx(0.1 + BELOW)
    for t in np.linspace(0.0, ramps.seconds, 500):
        way, speed = ramps.at(t)
        if way > 0.1 - ABOVE + 1e-6:
            assert speed <= TOUCH_SPEED + 1e-9


def touch_speed(plan: StepPlan, leg: int) -> float:
    """How fast a foot comes down when it is at the height it lands at."""
    tracker = TrajectoryTracker(plan)
    ground = plan.end.feet[leg][2]
    times = np.arange(0.0, tracker.duration, TICK / 4)
    heights = np.array([tracker.foot_at(leg, t)[2] for t in times])
    k = next(k for k in range(len(times) - 1, 0, -1) if heights[k] >= ground)
    return float((heights[k - 1] - heights[k]) / (TICK / 4))


def test_on_known_ground_a_foot_comes_down_at_its_touch_speed_and_else_as_fast_as_before():
    leg = DECIDED.swing[0]
    soft = run_to_completion(swaying(DECIDED, STANCE, (), GAIT, TITAN, FLAT))
    fast = run_to_completion(swaying(DECIDED, STANCE, (), GAIT, TITAN))
    assert touch_speed(soft, leg) <= TOUCH_SPEED + 1e-6
    assert touch_speed(fast, leg) > 3 * TOUCH_SPEED
    assert soft.feet[-1, leg, 2] == pytest.approx(soft.end.feet[leg][2] - BELOW)
    assert fast.feet[-1, leg, 2] == pytest.approx(DECIDED.feet[-1, leg, 2])


def test_what_landing_takes_longer_is_taken_from_the_return():
    table = smooth_swing(DECIDED, TITAN, ALL)
    assert table.times[-1] == pytest.approx(float(DECIDED.times[-1]))
    assert [phase.name for phase in dict.fromkeys(table.phases)] == [
        phase.name for phase in dict.fromkeys(DECIDED.phases)
    ]
    assert math.dist(table.feet[0][0], DECIDED.feet[0][0]) == 0.0


def test_the_velocity_of_a_played_foot_has_no_jumps():
    plan = STEPS[2][2]
    tracker = TrajectoryTracker(plan)
    leg = plan.swing[0]
    times = np.arange(0.0, tracker.duration, TICK / 8)
    places = np.array([tracker.foot_at(leg, t) for t in times])
    speeds = np.diff(places, axis=0) / (TICK / 8)
    jumps = np.linalg.norm(np.diff(speeds, axis=0), axis=1)
    assert jumps.max() <= 2.5 * JERKY * TICK / 8


def test_even_knots_are_left_as_they_are():
    table = as_planned(DECIDED)
    assert table.times == DECIDED.times.tolist() and table.phases == list(DECIDED.phases)


def test_ground_that_is_only_supposed_is_not_known():
    heights = np.zeros((400, 400))
    seen = np.ones((400, 400), dtype=bool)
    given = TerrainMap(heights, ~seen, 0.05, (-10.0, -10.0))
    supposed = TerrainMap(heights, ~seen, 0.05, (-10.0, -10.0), known=~seen)
    assert legs_on_known_ground(DECIDED, given) == set(DECIDED.swing)
    assert legs_on_known_ground(DECIDED, supposed) == set()


def test_a_body_that_shifts_begins_and_ends_at_rest_within_its_acceleration():
    stance = STANCE.at_rest()
    x, y, z, yaw = stance.body
    there = (x + 0.06, y - 0.02, z, yaw)
    plan = plan_on_all_feet(stance, (0.0, 0.3), (stance.body, there), stance)
    shifted = gentle(plan, TITAN, ALL, 0.25)
    tracker = TrajectoryTracker(shifted)
    times = np.arange(0.0, tracker.duration, TICK)
    places = np.array([tracker.body_at(t)[:2] for t in times])
    acceleration = np.hypot(*(np.diff(places, 2, axis=0) / TICK**2).T)
    assert acceleration.max() <= 0.25 * 1.01
    assert tracker.velocity_at(0.0) == pytest.approx((0.0, 0.0, 0.0, 0.0))
    assert tracker.body_at(tracker.duration) == pytest.approx(there)
    assert set(shifted.phases) == {Phase.SHIFT}
