"""Level B2: shifts by every case of (13) and (14), the order of legs, the cheap roll-out."""

import math

import numpy as np
import pytest

from tests.planner.crab.crab_walks import TITAN, Blocked, command, gait, holes, random_stance, walk
from walking_console.planner.crab.gait import (
    Posture,
    nominal_gait,
    posture_of,
    standard_stance,
)
from walking_console.planner.crab.leg_selection import (
    Shift,
    after,
    agreeing_pairs,
    changes_nothing,
    decide,
    leg_order,
    return_length,
    shift_of,
)
from walking_console.planner.crab.step_refusals import StepRefusal
from walking_console.planner.initial_stance import Placement
from walking_console.planner.motion.leg_order import IS_FRONT, SUCCESSOR
from walking_console.planner.terrain.cells import foothold_map

AHEAD = nominal_gait(TITAN, gait(), 0.0)


def posture(*feet, last=-1, nominal=AHEAD):
    return Posture(nominal, 0.0, 0.0, 1.0, 0.0, feet, last)


@pytest.mark.parametrize(
    ("degrees", "leg", "foot", "g"),
    [
        (0, 0, (0.5, 0.4), 0.5 - 0.2),  # (4)
        (0, 1, (-0.3, 0.4), -0.3 + 0.7),  # (5)
        (30, 0, (0.6, 0.31), 0.01 / 0.5),  # (6) left leg, course to the left
        (30, 3, (0.6, -0.60), 0.05 / 0.5),  # (7) right leg
        (-30, 0, (0.6, 0.60), 0.05 / 0.5),  # (8) left leg, course to the right
        (-30, 3, (0.6, -0.31), 0.01 / 0.5),  # (9)
    ],
)
def test_the_body_may_go_until_the_foot_leaves_its_reach(degrees, leg, foot, g):
    nominal = nominal_gait(TITAN, gait(), math.radians(degrees))
    feet = [tuple(centre) for centre in nominal.centres]
    feet[leg] = foot
    assert posture(*feet, nominal=nominal).exits[leg] == pytest.approx(g)


S0 = AHEAD.margin


def front_posture(crossing, slack=0.4):
    """Straight ahead, front-left to swing: the line from FR to RL crosses the course at
    ``crossing``; all may go ``slack``.
    """
    return posture(
        (0.6, 0.45), (crossing - 0.45, 0.45), (-0.7 + slack, -0.45), (crossing + 0.45, -0.45)
    )


@pytest.mark.parametrize(
    ("crossing", "case"), [(-0.01, "a"), (0.5 * S0, "b"), (0.1, "c"), (0.2, "d")]
)
def test_every_case_of_13(crossing, case):
    stance = front_posture(crossing, slack=0.12 if case == "d" else 0.4)
    shift = shift_of(stance, 0)
    if case == "a":
        assert shift is StepRefusal.LEFT
    else:
        expected = {"b": 0.0, "c": crossing - S0, "d": 0.12}[case]
        assert (shift.g0, shift.g) == (0.0, pytest.approx(expected))


def hind_posture(crossing, slack=0.4):
    """Straight ahead, rear-right to swing: the line from FR to RL crosses the course at
    ``crossing``; RR leaves after ``slack``.
    """
    return posture(
        (0.65, 0.45), (crossing - 0.45, 0.45), (-0.7 + slack, -0.45), (crossing + 0.45, -0.45)
    )


@pytest.mark.parametrize(
    ("crossing", "slack", "g0"),
    [
        (0.10, 0.08, None),  # (14a)
        (0.06, 0.07, 0.07),  # (14b)
        (0.06, 0.40, 0.06 + S0),  # (14c)
        (-0.10, 0.40, 0.0),  # (14d)
    ],
)
def test_every_case_of_14(crossing, slack, g0):
    stance = hind_posture(crossing, slack)
    exits = stance.exits
    shift = shift_of(stance, 2)
    if g0 is None:
        assert shift is StepRefusal.TOO_LATE
    else:
        assert shift.g0 == pytest.approx(g0)
        # g_max of (12), before the far end
        assert shift.g == pytest.approx(min(exits[0], exits[1], exits[3]))


def test_a_hind_step_is_cut_at_the_far_end_of_the_triangle():
    nominal = nominal_gait(TITAN, gait(), math.radians(40))
    rng = np.random.default_rng(5)
    for _ in range(500):
        seen = posture_of(nominal, random_stance(rng))
        for leg in (1, 2):
            shift = shift_of(seen, leg)
            if not isinstance(shift, StepRefusal):
                assert shift.g <= shift.high + 1e-12 or shift.g == shift.g0
                assert shift.g0 <= shift.g


def test_a_smaller_margin_may_be_asked_for():
    stance = front_posture(0.1)
    wide, narrow = (shift_of(stance, 0, margin=m) for m in (S0, 0.0))
    assert narrow.g == pytest.approx(wide.g + S0)


@pytest.mark.parametrize("duty_factor", [0.75, 0.8, 0.9])
@pytest.mark.parametrize("degrees", range(-180, 180, 45))
def test_in_the_standard_layout_the_standard_leg_swings_next(degrees, duty_factor):
    settings = gait(duty_factor)
    nominal = nominal_gait(TITAN, settings, math.radians(degrees))
    seen = posture_of(
        nominal,
        standard_stance(
            TITAN, settings, Placement((0.0, 0.0, 0.0), lambda x, y: 0.0, math.radians(degrees))
        ),
    )
    for _ in range(8):
        order = list(leg_order(seen))
        assert order[0][0] == SUCCESSOR[seen.last]
        assert agreeing_pairs(seen, order[0][0]) == 2
        assert seen.last not in [leg for leg, _ in order]
        step = decide(seen, foothold_map(holes()))
        assert step.margin == pytest.approx(nominal.margin, abs=1e-9)
        seen = after(seen, step)


def test_where_nothing_agrees_the_longest_return_goes_first():
    rng = np.random.default_rng(2)
    found = 0
    for _ in range(300):
        seen = posture_of(AHEAD, random_stance(rng))
        order = list(leg_order(seen))
        able = [leg for leg, shift in order if isinstance(shift, Shift)]
        assert [leg for leg, _ in order][: len(able)] == able, (
            "a leg that cannot swing is not at the back"
        )
        if able and not any(agreeing_pairs(seen, leg) for leg in able):
            returns = [return_length(seen, leg) for leg in able]
            assert returns == sorted(returns, reverse=True)
            found += 1
    assert found > 50


def test_the_cheap_roll_out_agrees_with_the_plan():
    angle, settings, ground = math.radians(28), gait(), holes(0.5, seed=3)
    stance = standard_stance(TITAN, settings, Placement((0.0, 0.0, 0.7), ground.height_at, angle))
    nominal = nominal_gait(TITAN, settings, angle)
    seen = posture_of(nominal, stance)
    for plan in walk(command(28), 20, ground, settings, stance):
        step = decide(seen, foothold_map(ground))
        assert nominal.body_leg[step.leg] == plan.swing[0]
        seen = after(seen, step)
        expected = posture_of(nominal, plan.end)
        assert seen.last == expected.last
        np.testing.assert_allclose(seen.feet, expected.feet, atol=1e-9)
        assert (seen.x, seen.y) == pytest.approx(plan.end.body[:2])


def test_no_step_is_taken_that_changes_nothing():
    for seed in range(60):
        rng = np.random.default_rng(seed)
        stance, ground = random_stance(rng), holes()
        angle, settings = rng.uniform(-math.pi, math.pi), gait(rng.uniform(0.75, 0.9))
        nominal = nominal_gait(TITAN, settings, angle)
        seen = posture_of(nominal, stance)
        for _ in range(30):
            step = decide(seen, foothold_map(ground))
            if step is None:
                break
            assert not changes_nothing(seen, step, step.landing)
            seen = after(seen, step)


def test_the_log_names_every_leg_that_was_tried_and_why_it_was_not_taken():
    rng, log = np.random.default_rng(11), {}
    ground = foothold_map(holes(1.0))
    assert decide(posture_of(AHEAD, random_stance(rng)), ground, log=log) is None
    assert len({trial["leg"] for trial in log["legs"]}) >= 3
    assert all(trial["reason"] for trial in log["legs"])


def test_front_and_hind_are_told_by_the_course_not_by_the_body():
    plans = walk(command(90), 4)
    assert not isinstance(plans[-1], Blocked)
    assert [IS_FRONT[(plan.swing[0] - 1) % 4] for plan in plans] == [False, True, False, True]
