"""Level C: what each foot is told, every 20 ms."""

import math
import timeit

import numpy as np
import pytest

from tests.planner.control.plans import FEET, FRESH, HEIGHT, sensed, swing_plan
from walking_console.planner.config import Gains
from walking_console.planner.control.foot_controller import (
    ReflexState,
    reflex,
)
from walking_console.planner.control.tracking import TrajectoryTracker
from walking_console.planner.motion.step_builder import holding_plan
from walking_console.planner.types import TICK, Phase, Point, Sensing, Stance, StepPlan


def follow(
    plan: StepPlan,
    t: float,
    sensing: Sensing,
    gains: Gains | None = None,
    state: ReflexState = FRESH,
):
    return reflex(TrajectoryTracker(plan), t, sensing, state, gains or Gains())


class TestSupport:
    def test_all_carrying_legs_get_minus_the_body_velocity(self):
        out, _ = follow(swing_plan(), TICK, sensed())
        # (34), (35), and table 3 in the support phase
        assert out == [pytest.approx((-0.1, 0.0, 0.0), abs=1e-12)] * 4

    def test_they_get_the_very_same_numbers_so_that_they_never_pull_against_each_other(self):
        out, _ = follow(swing_plan(), 0.6, sensed((0.0575, 0.01, HEIGHT, 0, 0, 0)))
        assert out[1] == out[2] == out[3]

    def test_a_tick_leaves_behind_where_the_plan_has_the_body_at_its_end(self):
        plan = swing_plan()
        used = TrajectoryTracker(plan)
        for t in (0.0, TICK, 0.22, 0.6, used.duration, used.duration + TICK):
            reflex(used, t, sensed(), FRESH, Gains())
            when, there = used.here
            assert when == t
            assert there == TrajectoryTracker(plan).body_at(t) == used.body_at(t)

    def test_a_body_that_lags_is_brought_to_where_the_plan_has_it_now(self):
        out, _ = follow(swing_plan(), 0.22, sensed((0.015, -0.002, HEIGHT - 0.003, 0, 0, 0)))
        assert out[1] == pytest.approx(
            (-(0.022 - 0.015) / TICK, -0.002 / TICK, -0.003 / TICK), abs=1e-9
        )

    def test_a_turn_is_one_rotation_about_the_planned_place(self):
        turn = 0.01
        body = np.array([[0, 0, HEIGHT, 0.3], [0.004, 0.002, HEIGHT, 0.3 + turn]])
        plan = StepPlan(
            (),
            np.array([0.0, TICK]),
            body,
            np.array([FEET] * 2),
            (Phase.SHIFT,),
            Stance((0, 0, 0, 0), FEET),
        )
        sensing = sensed((0.0, 0.0, HEIGHT, 0, 0, 0.3))
        out, _ = follow(plan, TICK, sensing)
        after = sensed((0.004, 0.002, HEIGHT, 0, 0, 0.3 + turn)).feet_b
        for (x, y, z), (vx, vy, vz), there in zip(sensing.feet_b, out, after, strict=True):
            assert (x + vx * TICK, y + vy * TICK, z + vz * TICK) == pytest.approx(there, abs=1e-12)

    def test_the_height_is_that_of_the_mean_foot(self):
        feet = tuple(
            (x, y, dz) for (x, y, _), dz in zip(FEET, (0.02, -0.01, 0.0, 0.01), strict=True)
        )
        out, _ = follow(holding_plan(Stance((0, 0, HEIGHT, 0), FEET)), TICK, sensed(feet=feet))
        assert [v[2] for v in out] == pytest.approx([-0.005 / TICK] * 4)  # (37): z* - mean z

    def test_a_tilted_body_is_levelled(self):
        for roll, pitch in ((0.05, 0.0), (0.0, 0.05), (-0.03, 0.04)):
            assert tilt_after(Gains(), roll, pitch, 60) < 1e-4 * math.hypot(roll, pitch)

    @pytest.mark.parametrize(("roll", "pitch"), [(0.3, 0.0), (0.0, -0.2), (-0.1, 0.15)])
    def test_a_body_far_off_level_is_levelled_without_dragging_its_feet(self, roll, pitch):
        tilted = sensed((0.0, 0.0, HEIGHT, roll, pitch, 0.0))
        out, _ = follow(holding_plan(Stance((0, 0, HEIGHT, 0), FEET)), TICK, tilted)
        before = np.array(tilted.feet_b)
        after = before + TICK * np.array(out)
        apart = [np.linalg.norm(each[:, None] - each[None], axis=2) for each in (before, after)]
        assert np.abs(after - before).max() > 0.005
        assert apart[0] == pytest.approx(apart[1], abs=1e-12)

    def test_with_the_opposite_sign_it_diverges(self):
        assert tilt_after(Gains(posture=-0.2), 0.01, 0.0, 10) > 0.04

    def test_nose_down_extends_the_front_legs(self):
        out, _ = follow(
            holding_plan(Stance((0, 0, HEIGHT, 0), FEET)),
            TICK,
            sensed((0, 0, HEIGHT, 0.0, 0.02, 0.0)),
        )
        assert out[0][2] < 0 < out[1][2]

    def test_left_side_up_extends_the_right_legs(self):
        out, _ = follow(
            holding_plan(Stance((0, 0, HEIGHT, 0), FEET)),
            TICK,
            sensed((0, 0, HEIGHT, 0.02, 0.0, 0.0)),
        )
        assert out[0][2] > 0 > out[3][2]

    def test_a_carrying_leg_whose_sole_is_off_reaches_down_and_the_others_do_not(self):
        out, _ = follow(
            holding_plan(Stance((0, 0, HEIGHT, 0), FEET)),
            TICK,
            sensed(soles=(True, True, False, True)),
        )
        assert out[2][2] == pytest.approx(-Gains().pliancy / TICK)
        assert [out[leg][2] for leg in (0, 1, 3)] == pytest.approx([0.0] * 3, abs=1e-12)


def tilt_after(gains: Gains, roll: float, pitch: float, ticks: int) -> float:
    """Play Level C against a body that leans as its feet tell it to; the remaining tilt."""
    plan = holding_plan(Stance((0, 0, HEIGHT, 0), FEET))
    for _ in range(ticks):
        sensing = sensed((0, 0, HEIGHT, roll, pitch, 0))
        out, _ = follow(plan, TICK, sensing, gains)
        reached = np.array(
            [(x, y, z + v[2] * TICK) for (x, y, z), v in zip(sensing.feet_b, out, strict=True)]
        )
        # of the ground in body axes
        slope = np.linalg.lstsq(np.c_[reached[:, :2], np.ones(4)], reached[:, 2], rcond=None)[0]
        pitch, roll = math.atan(slope[0]), -math.atan(slope[1])
    return math.hypot(roll, pitch)


class TestSwing:
    def test_up_and_down_are_vertical_over_the_ground(self):
        for t in (0.3, 0.98):
            playback = TrajectoryTracker(swing_plan())
            body = (*playback.body_at(t - TICK)[:3], 0.0, 0.0, 0.0)
            feet = (playback.foot_at(0, t - TICK), *FEET[1:])
            out, _ = follow(swing_plan(), t, sensed(body, feet, (False, True, True, True)))
            assert out[0][0] == pytest.approx(-0.1)  # table 3: -v_G
            assert out[0][2] == pytest.approx(0.8 if t < 0.5 else -1.6)

    def test_a_swing_foot_is_aimed_right_from_a_body_that_is_not_level(self):
        feet = (TrajectoryTracker(swing_plan()).foot_at(0, 0.58), *FEET[1:])
        level, _ = follow(swing_plan(), 0.6, sensed((0.058, 0, HEIGHT, 0, 0, 0), feet))
        tilted, _ = follow(swing_plan(), 0.6, sensed((0.058, 0, HEIGHT, 0.01, -0.02, 0), feet))
        assert tilted[0] == pytest.approx(level[0], abs=0.01)

    def test_a_foot_that_touches_on_its_way_down_stops_and_carries_with_the_others(self):
        landed = (FEET[0][0] + 0.2, FEET[0][1], 0.03)
        out, state = follow(
            swing_plan(), 0.92, sensed((0.09, 0, HEIGHT, 0, 0, 0), (landed, *FEET[1:]))
        )
        assert state.landed == (True, False, False, False)
        assert out[0] == out[1] == pytest.approx((-0.1, 0.0, 0.0), abs=1e-9)

    def test_it_stays_landed_though_its_sole_goes_off_and_reaches_for_the_ground(self):
        landed = (FEET[0][0] + 0.2, FEET[0][1], 0.03)
        sensing = sensed((0.09, 0, HEIGHT, 0, 0, 0), (landed, *FEET[1:]), (False, True, True, True))
        out, state = follow(
            swing_plan(), 0.92, sensing, state=FRESH._replace(landed=(True, False, False, False))
        )
        assert state.landed[0]
        assert out[0][:2] == out[1][:2]
        assert not state.next_step().landed[0]

    def test_touching_something_on_the_way_over_is_not_a_landing(self):
        _, state = follow(swing_plan(), 0.6, sensed((0.058, 0, HEIGHT, 0, 0, 0)))
        assert state is FRESH

    def test_legs_that_stay_lifted_are_held_up(self):
        feet = ((*FEET[0][:2], 0.2), *FEET[1:])
        plan = holding_plan(Stance((0, 0, HEIGHT, 0), feet, lifted=(0,)))
        out, _ = follow(plan, TICK, sensed(feet=feet, soles=(False, True, True, True)))
        assert out == [pytest.approx((0.0, 0.0, 0.0), abs=1e-12)] * 4


class TestServoLag:
    """A servo that does only part of what it is told."""

    @staticmethod
    def lag(gains: Gains, ticks: int = 200, share: float = 0.7) -> tuple[float, list[Point]]:
        plan = StepPlan(
            (),
            np.array([0.0, 8.0]),
            np.array([[0, 0, HEIGHT, 0], [0.4, 0, HEIGHT, 0]]),
            np.array([FEET] * 2),
            (Phase.SHIFT,),
            Stance((0, 0, 0, 0), FEET),
        )
        playback, state, x, out = TrajectoryTracker(plan), FRESH, 0.0, []
        for k in range(1, ticks + 1):
            out, state = reflex(playback, k * TICK, sensed((x, 0, HEIGHT, 0, 0, 0)), state, gains)
            x -= out[0][0] * TICK * share
        return playback.body_at(ticks * TICK)[0] - x, out

    def test_p_control_stays_behind_and_pid_catches_up(self):
        assert self.lag(Gains())[0] > 2e-4
        error, out = self.lag(Gains(integral=0.2, derivative=0.05))
        assert abs(error) < 1e-6
        assert out[0] == out[1] == out[2] == out[3]

    def test_a_stuck_servo_does_not_wind_the_integral_up(self):
        gains = Gains(integral=0.2, windup=0.01)
        state, playback = FRESH, TrajectoryTracker(swing_plan())
        for _ in range(500):
            out, state = reflex(playback, 0.2, sensed((-0.05, 0, HEIGHT, 0, 0, 0)), state, gains)
        asked = -out[1][0] * TICK
        assert asked <= 0.07 + 0.01 + 1e-9  # what P control asks for, and the bound


def test_a_tick_of_four_legs_takes_no_time_worth_mentioning():
    playback, sensing, gains = (
        TrajectoryTracker(swing_plan()),
        sensed((0.058, 0, HEIGHT, 0, 0, 0)),
        Gains(),
    )
    seconds = (
        min(
            timeit.repeat(
                lambda: reflex(playback, 0.6, sensing, FRESH, gains), number=500, repeat=5
            )
        )
        / 500
    )
    assert seconds < 60e-6  # 15 µs on a quiet machine
