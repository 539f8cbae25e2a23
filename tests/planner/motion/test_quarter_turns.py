"""The fold of H table 1."""

import math

import pytest

from walking_console.planner.motion.quarter_turns import (
    HYSTERESIS,
    beside_critical,
    folded,
    half_width,
    quarter_turned,
    quarter_turns,
)
from walking_console.planner.robot.model import load_machine

TITAN = load_machine("titan3")


@pytest.mark.parametrize(
    ("degrees", "n", "rest"),
    [
        (0, 0, 0),
        (46, 0, 46),
        (-46, 0, -46),
        (47, 1, -43),
        (90, 1, 0),
        (133, 1, 43),
        (134, 2, -46),
        (180, 2, 0),
        (-180, 2, 0),
        (226, 2, 46),
        (227, 3, -43),
        (270, 3, 0),
        (-90, 3, 0),
        (-47, 3, 43),
    ],
)
def test_table_1_folds_every_crab_angle(degrees, n, rest):
    assert quarter_turns(TITAN, math.radians(degrees)) == n
    assert math.degrees(folded(math.radians(degrees), n)) == pytest.approx(rest, abs=1e-9)


def test_a_stick_trembling_on_the_boundary_does_not_turn_the_gait_over():
    critical = TITAN.critical_angle
    n = quarter_turns(TITAN, critical - 0.01)
    for tremble in (0.0, 0.5, -0.5, 0.99, -0.99):
        n = quarter_turns(TITAN, critical + tremble * HYSTERESIS, n)
        assert n == 0
    n = quarter_turns(TITAN, critical + 1.01 * HYSTERESIS, n)
    assert n == 1
    assert quarter_turns(TITAN, critical - 0.99 * HYSTERESIS, n) == 1
    assert quarter_turns(TITAN, critical - 1.01 * HYSTERESIS, n) == 0


def test_the_nearest_boundary_is_that_of_the_nearest_range():
    for degrees in range(-180, 181, 7):
        angle = math.radians(degrees)
        away = [abs(abs(folded(angle, n)) - half_width(TITAN, n)) for n in range(4)]
        assert beside_critical(TITAN, angle) == pytest.approx(min(away), abs=1e-12)


def test_quarter_turns_are_without_rounding():
    assert quarter_turned(0.1, 0.7, 1) == (-0.7, 0.1)
    assert quarter_turned(0.1, 0.7, -1) == (0.7, -0.1)
    assert quarter_turned(0.1, 0.7, 4) == (0.1, 0.7)


def test_the_four_ranges_cover_the_circle():
    assert sum(2 * half_width(TITAN, n) for n in range(4)) == pytest.approx(2 * math.pi)
