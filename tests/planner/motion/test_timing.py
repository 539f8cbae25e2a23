"""Level B4: the speed limits of (28) with their printed forms held against them, the clock of a
step and its knots; on an arc of turn 0 as on a line.
"""

import math

import numpy as np
import pytest

from walking_console.planner.geometry.paths import ArcPath
from walking_console.planner.motion.swing import EASED, SwingCorners, swing_speeds
from walking_console.planner.motion.timing import (
    BodyWay,
    SwingDemand,
    axis_limit,
    knots,
    return_limit_on,
    speed_limit,
    timing,
)
from walking_console.planner.robot.model import load_machine
from walking_console.planner.types import Gait, Phase

TITAN = load_machine("titan3")
GAIT = Gait(0.8, TITAN.lift_up, TITAN.lift_down, TITAN.height)
EVEN_GAIT = Gait(0.8, TITAN.lift_up, TITAN.lift_down, TITAN.height, smooth=False)


TAU = 0.3 / 0.8  # h_up and h_dwn at V_z
# D and n of the standard front step straight ahead, β = 0.8
FRONT_STEP = (0.625, 0.0, 0.0), (1.0, 0.0, 0.0)


# D and n of the standard front step straight ahead, β = 0.8
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


def demand(displacement, courses, g0, g, climb=0.0, rise=0.1):
    return SwingDemand(displacement, courses, climb, g0, g, rise, 0.2, (0.05, 0.05))


def test_when_the_body_waits_the_return_time_comes_from_the_leg_alone():
    waits = demand((0.3, 0.1, 0.0), ((1.0, 0.0),), 0.0, 0.0)
    clock = timing(TITAN, EVEN_GAIT, waits, 0.08, lambda: 0.1)  # (13b)
    assert clock.speed == 0.0
    assert clock.back == pytest.approx(0.3 / 1.0)
    assert (clock.up, clock.down) == pytest.approx((0.1 / 0.8, 0.2 / 0.8))


def test_the_four_leg_phase_does_not_crawl_when_the_swing_must():
    slow = demand((0.5, 0.0, 0.0), ((1.0, 0.0),), 0.10, 0.101)
    clock = timing(TITAN, GAIT, slow, 0.08, lambda: 0.1)
    assert clock.speed < 0.01
    assert clock.support == pytest.approx(0.10 / 0.08)


def test_the_slowest_of_several_courses_past_standing_feet_counts():
    fast = demand((0.0, 0.0, 0.0), ((1.0, 0.0),), 0.0, 1.0)
    slow = fast._replace(courses=((1.0, 0.0), (16.0, 0.0)))
    clock = timing(TITAN, GAIT, slow._replace(room=(9.0, 9.0)), 0.0, lambda: 9.0)
    assert clock.speed_max == pytest.approx(1.0 / 1.25 / 16.0)
    assert timing(TITAN, GAIT, fast._replace(room=(9.0, 9.0)), 0.0, lambda: 9.0).speed_max > 0.5


def a_step(path, height=0.815):
    """A step of 0.15 m along a path and the corners of its swing."""
    way = BodyWay((0.3, -0.2, 0.8, 0.4), (math.cos(0.4), math.sin(0.4)), path, 0.15, height)
    swing = SwingCorners((0.1, 0.4, 0.0), (0.1, 0.4, 0.15), (0.5, 0.5, 0.2), (0.5, 0.5, 0.0))
    return way, swing


def test_the_knots_join():
    climbing = demand((0.4, 0.1, 0.05), ((1.0, 0.0),), 0.05, 0.15, climb=0.015, rise=0.15)
    clock = timing(TITAN, GAIT, climbing, 0.06, lambda: 0.1)
    way, swing = a_step(ArcPath(1.0, 0.0))
    rows, phases = knots(clock, EASED, way, 0.05, swing)
    assert len(rows) == len(phases) + 1 == 17
    assert [rows[k][5:] for k in (0, 6, 11, -1)] == list(swing)
    assert rows[0][1:5] == way.body and rows[-1][1:5] == way.end
    assert rows[-1][0] == pytest.approx(sum(clock[3:]))


def test_on_an_arc_the_standing_time_is_cut_into_straight_lines_too():
    climbing = demand((0.4, 0.1, 0.05), ((1.0, 0.0),), 0.05, 0.15)
    clock = timing(TITAN, GAIT, climbing, 0.06, lambda: 0.1)
    way, swing = a_step(ArcPath(0.5, 0.0, 1.2))
    rows, phases = knots(clock, EASED, way, 0.05, swing)
    assert phases.count(Phase.SUPPORT) == math.ceil(1.2 * 0.05 / 0.02)
    turns = np.diff([row[4] for row in rows])
    assert turns.max() <= 0.02 + 1e-9 and turns.sum() == pytest.approx(1.2 * 0.15)


@pytest.mark.parametrize("degrees", [0, 35, 90, -120])
def test_on_an_arc_of_turn_0_the_return_is_as_fast_as_on_a_line(degrees):
    angle = math.radians(degrees)
    way, swing = a_step(ArcPath(math.cos(angle), math.sin(angle)))
    g0 = 0.03
    limits = swing_speeds(TITAN, GAIT)
    c, s = math.cos(0.4), math.sin(0.4)
    dx, dy = swing.over[0] - swing.top[0], swing.over[1] - swing.top[1]
    displacement = c * dx + s * dy, c * dy - s * dx, swing.over[2] - swing.top[2]
    course = math.cos(angle), math.sin(angle), way.dz / way.g
    for up, down in ((0.15, 0.3), (0.3, 0.2)):
        straight = speed_limit(displacement, course, limits, way.g - g0, up + down)
        bent = return_limit_on(way, g0, swing)(up, down, limits)
        assert bent == pytest.approx(straight, abs=1e-9)


@pytest.mark.parametrize("degrees", [0, 35, -120])
def test_a_line_is_walked_as_an_arc_of_no_turn(degrees):
    """Body and foot at every knot, through the formulas of arcs with a turn of next to nothing."""
    angle = math.radians(degrees)
    waits = demand((0.4, 0.1, 0.05), ((1.0, 0.0),), 0.05, 0.15)
    clock = timing(TITAN, GAIT, waits, 0.06, lambda: 0.1)
    tables = []
    for turn in (0.0, 1e-9):
        way, swing = a_step(ArcPath(math.cos(angle), math.sin(angle), turn))
        rows, phases = knots(clock, EASED, way, 0.05, swing)
        tables.append((np.array(rows), phases))
    (line, line_phases), (arc, arc_phases) = tables
    np.testing.assert_allclose(line, arc, atol=1e-9)
    assert line_phases == arc_phases
