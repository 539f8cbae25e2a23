"""Level B4: the speed limits of (28) with their printed forms held against them, and the knots of
the swing.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.planner.crab.crab_walks import TITAN, command, gait, walk
from walking_console.planner.crab.planner import cruise_speed
from walking_console.planner.motion.swing import EASED
from walking_console.planner.motion.timing import (
    axis_limit,
    knots,
    speed_limit,
    timing,
)
from walking_console.planner.types import Phase

TAU = 0.3 / 0.8  # h_up and h_dwn at V_z
# D and n of the standard front step straight ahead, β = 0.8
FRONT_STEP = (0.625, 0.0, 0.0), (1.0, 0.0, 0.0)


def test_v_max_of_the_standard_walk():
    assert cruise_speed(TITAN, gait(smooth=False), 0.0) == pytest.approx(0.135, abs=5e-4)
    assert cruise_speed(TITAN, gait(), 0.0) == pytest.approx(0.108, abs=5e-4)
    assert cruise_speed(TITAN, gait(), math.pi / 2) == pytest.approx(0.091, abs=5e-4)
    slow = replace(TITAN, speed=(0.3, 0.3, 0.3))
    assert cruise_speed(slow, gait(smooth=False), 0.0) == pytest.approx(0.044, abs=5e-4)


def test_a_plan_walks_the_commanded_speed_but_no_faster_than_v_max():
    assert walk(command(0, 0.08), 1)[0].speed == 0.08
    fast = walk(command(0, 5.0), 4)
    assert fast[1].speed == fast[1].speed_max == pytest.approx(0.108, abs=5e-4)
    assert fast[1].times[-1] == pytest.approx(0.125 / fast[1].speed)
    at_will = walk(command(0, 0.0), 2)
    assert at_will[1].speed == at_will[1].speed_max


def printed_24(displacement, g, limit, vertical, shift):
    """(24) as printed: the whole numerator under the root, and g_x where g_ux belongs."""
    a, b, c = vertical / limit, vertical + (displacement - shift) / limit, -g
    return math.sqrt(b * b - 4 * a * c - b) / (2 * a) if b * b - 4 * a * c - b > 0 else math.nan


def test_errata_24_the_root_ends_before_b():
    (d, _, _), _ = FRONT_STEP
    v = axis_limit(d, 1.0, 1.0, 0.125, TAU)
    assert v == pytest.approx(0.135, abs=5e-4)
    assert d / (0.125 / v - TAU) - v == pytest.approx(1.0), "the leg does not return at V"
    wrong = printed_24(d, 0.125, 1.0, TAU, 0.125)
    assert math.isnan(wrong) or abs(wrong - v) > 0.05


def test_errata_24_the_shift_is_that_after_the_support_phase():
    d, g, g0, v_leg = 0.6875, 0.1875, 0.0625, 1.0  # the standard hind step
    g_u = g - g0
    v = axis_limit(d, 1.0, v_leg, g_u, TAU)
    a, b = TAU / v_leg, TAU + (d - g_u) / v_leg
    assert v == pytest.approx((-b + math.sqrt(b * b + 4 * a * g_u)) / (2 * a))
    b_printed = TAU + (d - g) / v_leg
    v_printed = (-b_printed + math.sqrt(b_printed**2 + 4 * a * g_u)) / (2 * a)
    assert d / (g_u / v_printed - TAU) - v_printed > 1.05 * v_leg, (
        "as printed the leg would exceed its limit"
    )


def test_errata_31_the_return_velocity_is_against_the_body():
    d, g_u, v = 0.625, 0.125, 0.08
    t_rtn = g_u / v - TAU  # (29)
    repaired, printed = d / t_rtn - v, (d - g_u) / t_rtn
    # ground displacement in the return phase; up and down are vertical
    landing = 0.0 + (repaired + v) * t_rtn
    assert landing == pytest.approx(d)
    assert abs((printed + v) * t_rtn - d) > 0.02


def test_errata_28_the_quotients_are_no_limit_on_an_axis_without_course():
    across = speed_limit((0.6, 0.3, 0.0), (1.0, 0.0, 0.0), (1.0, 0.2, 0.8), 0.125, TAU)
    v = across
    assert 0.3 / (0.125 / v - TAU) == pytest.approx(0.2), (
        "the sideways axis is what limits, though the course has no y component"
    )


@pytest.mark.parametrize("seed", range(40))
def test_v_max_is_the_first_speed_at_which_a_limit_is_reached(seed):
    rng = np.random.default_rng(seed)
    angle = rng.uniform(-math.pi, math.pi)
    n = (math.cos(angle), math.sin(angle), rng.uniform(-0.3, 0.3))
    d, limits = tuple(rng.uniform(-0.7, 0.7, 3)), tuple(rng.uniform(0.2, 1.0, 3))
    g, tau = rng.uniform(0.02, 0.25), rng.uniform(0.1, 0.5)

    def load(v):
        back = g / v - tau
        return max(abs(d[c] / back - v * n[c]) / limits[c] for c in range(3))

    v = speed_limit(d, n, limits, g, tau)
    assert 0.0 < v <= g / tau
    for share in np.linspace(0.01, 0.999, 60):
        assert load(share * v) <= 1.0 + 1e-9
    if v < 0.999 * g / tau:
        assert load(v) == pytest.approx(1.0)


def test_when_the_body_waits_the_return_time_comes_from_the_leg_alone():
    n, room = (1.0, 0.0, 0.0), (0.05, 0.05)
    # (13b)
    clock = timing(
        TITAN,
        gait(smooth=False),
        (0.3, 0.1, 0.0),
        n,
        0.0,
        0.0,
        0.0,
        0.1,
        0.2,
        room,
        0.08,
        lambda: 0.1,
    )
    assert clock.speed == 0.0
    assert clock.back == pytest.approx(0.3 / 1.0)
    assert (clock.up, clock.down) == pytest.approx((0.1 / 0.8, 0.2 / 0.8))


def test_the_four_leg_phase_does_not_crawl_when_the_swing_must():
    clock = timing(
        TITAN,
        gait(),
        (0.5, 0.0, 0.0),
        (1.0, 0.0, 0.0),
        0.0,
        0.10,
        0.101,
        0.1,
        0.2,
        (0.05, 0.05),
        0.08,
        lambda: 0.1,
    )
    assert clock.speed < 0.01
    assert clock.support == pytest.approx(0.10 / 0.08)


def test_the_body_keeps_one_speed_and_the_foot_rises_and_falls_vertically():
    plan = walk(command(28, 0.07), 1)[0]
    (leg,) = plan.swing
    speeds = np.hypot(*np.diff(plan.body[:, :2], axis=0).T) / np.diff(plan.times)
    np.testing.assert_allclose(speeds, 0.07, rtol=1e-9)
    order = [plan.phases[0]] + [
        b for a, b in zip(plan.phases, plan.phases[1:], strict=False) if a is not b
    ]
    assert order == [Phase.SUPPORT, Phase.UP, Phase.RETURN, Phase.DOWN]
    path = plan.feet[:, leg]
    assert path[:, 2].max() == pytest.approx(TITAN.lift_up)
    assert path[-1, 2] == pytest.approx(TITAN.lift_up - TITAN.lift_down), (
        "the aim is not h_up below the ground"
    )
    # (32)
    assert plan.times[list(plan.phases).index(Phase.UP)] == pytest.approx(plan.support_shift / 0.07)


def test_constant_profile_has_the_papers_five_knots():
    plan = walk(command(0, 0.05), 1, settings=gait(smooth=False))[0]
    assert plan.phases == (Phase.SUPPORT, Phase.UP, Phase.RETURN, Phase.DOWN)


def test_the_knots_join():
    clock = timing(
        TITAN,
        gait(),
        (0.4, 0.1, 0.05),
        (1.0, 0.0, 0.1),
        0.015,
        0.05,
        0.15,
        0.15,
        0.2,
        (0.05, 0.05),
        0.06,
        lambda: 0.1,
    )
    swing = (0.1, 0.4, 0.0), (0.1, 0.4, 0.15), (0.5, 0.5, 0.2), (0.5, 0.5, 0.0)
    rows, phases = knots(clock, EASED, ((0.0, 0.0, 0.8), (0.15, 0.0, 0.815)), 0.05, 0.15, swing)
    assert len(rows) == len(phases) + 1 == 17
    assert (
        rows[0][2] == swing[0]
        and rows[6][2] == swing[1]
        and rows[11][2] == swing[2]
        and rows[-1][2] == swing[3]
    )
    assert rows[-1][1] == (0.15, 0.0, 0.815)
