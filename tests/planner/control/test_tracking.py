"""A plan made ready to be followed: where it has everything, and how fast it may be played."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.planner.control.plans import FEET, FRESH, HEIGHT, STANCE, TITAN, sensed, swing_plan
from walking_console.planner.config import Gains
from walking_console.planner.control.foot_controller import reflex
from walking_console.planner.control.tracking import TrajectoryTracker
from walking_console.planner.motion.step_builder import holding_plan
from walking_console.planner.types import Phase, Stance, StepPlan


def follow(plan, t, sensing):
    return reflex(TrajectoryTracker(plan), t, sensing, FRESH, Gains())


def seen(playback: TrajectoryTracker, t: float) -> np.ndarray:
    """All feet in body axes."""
    x, y, z, yaw = playback.body_at(t)
    c, d = math.cos(yaw), math.sin(yaw)
    feet = np.array([playback.foot_at(leg, t) for leg in range(4)]) - (x, y, z)
    return feet @ np.array([[c, -d, 0], [d, c, 0], [0, 0, 1]])


def test_a_knot_is_met_exactly_however_the_ticks_fall():
    plan = swing_plan()
    playback = TrajectoryTracker(plan)
    for t, body, feet in zip(plan.times, plan.body, plan.feet, strict=True):
        assert playback.body_at(float(t)) == pytest.approx(tuple(body), abs=1e-15)
        assert playback.foot_at(0, float(t)) == pytest.approx(tuple(feet[0]), abs=1e-15)


def test_legs_rise_until_the_last_of_them_does_and_never_in_a_plan_that_holds():
    plan = swing_plan()
    feet = plan.feet.copy()
    feet[3] = feet[2]
    phases = (Phase.SUPPORT, Phase.UP, Phase.SUPPORT, Phase.UP)
    tracker = TrajectoryTracker(replace(plan, feet=feet, phases=phases))
    assert [time for time, _, _ in tracker.rises] == [0.25, 0.875]
    assert tracker.rises_until == 0.875
    assert TrajectoryTracker(swing_plan()).rises_until == 0.25
    assert TrajectoryTracker(holding_plan(STANCE)).rises_until == -math.inf


def test_a_leg_that_waits_in_the_air_while_the_others_carry_the_body_on_does_not_carry():
    plan = swing_plan()
    feet = plan.feet.copy()
    feet[:2, 0, 2] = 0.1
    feet[:2, 0, 0] = FEET[0][0] + plan.body[:2, 0]
    plan = replace(plan, feet=feet)
    out, _ = follow(
        plan,
        0.02,
        sensed(feet=((FEET[0][0], FEET[0][1], 0.1), *FEET[1:]), soles=(False, True, True, True)),
    )
    # it goes with the body and does not reach for the ground
    assert out[0] == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert out[1] == pytest.approx((-0.1, 0.0, 0.0), abs=1e-9)


def test_a_leg_lifted_before_the_plan_does_not_stand_though_it_does_not_move_either():
    plan = swing_plan()
    feet = plan.feet.copy()
    feet[:2, 0, 2] = 0.1
    plan = replace(plan, feet=feet)
    lifted = TrajectoryTracker(plan, (0,)).stretches[0]
    assert lifted.air == (0,) and lifted.stand == (1, 2, 3)
    assert TrajectoryTracker(plan).stretches[0].stand == (0, 1, 2, 3)


def test_time_may_run_back_as_when_a_foot_retraces_its_way():
    playback = TrajectoryTracker(swing_plan())
    assert [playback.phase(t) for t in (0.9, 0.6, 0.3, 0.1)] == [
        Phase.DOWN,
        Phase.RETURN,
        Phase.UP,
        Phase.SUPPORT,
    ]


def test_before_the_start_and_after_the_end_the_plan_stands_still():
    playback = TrajectoryTracker(swing_plan())
    assert playback.body_at(-1.0) == playback.body_at(0.0)
    assert playback.body_at(9.0) == playback.body_at(1.0)


def test_the_pace_of_a_stretch_is_what_its_fastest_foot_leaves_room_for():
    playback = TrajectoryTracker(swing_plan())
    # carrying feet at 0.1 of 1.0 m/s
    assert playback.pace_max(0.1, TITAN) == pytest.approx(1.0 / 0.1)
    assert playback.pace_max(0.3, TITAN) == pytest.approx(0.8 / 0.8)  # up at 0.8 of 0.8 m/s
    # 0.4 m/s over ground, 0.3 to the body
    assert playback.pace_max(0.6, TITAN) == pytest.approx(1.0 / 0.3)
    # down planned twice too fast
    assert playback.pace_max(0.9, TITAN) == pytest.approx(0.8 / 1.6)
    assert (
        TrajectoryTracker(holding_plan(Stance((0, 0, HEIGHT, 0), FEET))).pace_max(0.0, TITAN)
        == math.inf
    )


def test_a_turning_body_counts_in_the_pace():
    turn = StepPlan(
        (),
        np.array([0.0, 1.0]),
        np.array([[0, 0, HEIGHT, 0], [0, 0, HEIGHT, 0.5]]),
        np.array([FEET] * 2),
        (Phase.SHIFT,),
        Stance((0, 0, HEIGHT, 0.5), FEET),
    )
    assert (
        1.0 / (0.5 * math.hypot(0.45, 0.475))
        <= TrajectoryTracker(turn).pace_max(0.5, TITAN)
        <= 1.0 / (0.5 * 0.475)
    )


def test_no_foot_exceeds_its_limit_when_played_at_that_pace():
    rng = np.random.default_rng(4)
    for _ in range(50):
        feet = np.array([FEET] * 2) + rng.uniform(-0.2, 0.2, (2, 4, 3))
        body = np.array(
            [[0, 0, HEIGHT, 0.0], [*rng.uniform(-0.2, 0.2, 2), HEIGHT, rng.uniform(-0.3, 0.3)]]
        )
        playback = TrajectoryTracker(
            StepPlan(
                (0, 1, 2, 3),
                np.array([0.0, 1.0]),
                body,
                feet,
                (Phase.RETURN,),
                Stance((0, 0, 0, 0), FEET),
            )
        )
        pace, fastest = playback.pace_max(0.5, TITAN), 0.0
        for t in np.arange(0.02, 1.0, 0.02):
            here, there = (seen(playback, float(t) + d) for d in (0.0, 1e-6))
            fastest = max(
                fastest, np.max(np.abs(there - here) / 1e-6 * pace / np.array(TITAN.speed))
            )
        assert 0.8 < fastest < 1.01
