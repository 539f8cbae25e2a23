"""A course held near α_c: a hand that trembles is not followed, a steady one is, a turn at once."""

import math
import random

import pytest

from walking_console.planner.motion.steady_course import MEANT, NEAR, steadied
from walking_console.planner.robot.model import load_machine
from walking_console.planner.types import Command, HeldCourse, Stance

TITAN = load_machine("titan3")
CRITICAL = TITAN.critical_angle
FEET = ((0.45, 0.5, 0.0), (-0.45, 0.5, 0.0), (-0.45, -0.5, 0.0), (0.45, -0.5, 0.0))


def courses(angles: list[float]) -> list[float]:
    """The course each of a row of steps is planned for."""
    held: HeldCourse | None = None
    walked = []
    for angle in angles:
        stance = Stance((0.0, 0.0, 0.85, 0.0), FEET, held_course=held)
        command, held = steadied(Command(angle, 0.08), stance, TITAN)
        walked.append(command.crab_angle)
    return walked


@pytest.mark.parametrize("seed", range(20))
def test_a_tremor_of_one_degree_at_the_critical_angle_changes_no_course(seed: int) -> None:
    chance = random.Random(seed)
    hand = [CRITICAL + math.radians(chance.gauss(0.0, 1.0)) for _ in range(80)]
    assert set(courses(hand)) == {hand[0]}


@pytest.mark.parametrize("degrees", [0.5, 1.0, 2.0, 5.0])
def test_a_steady_hand_gets_the_very_course_it_asks_for(degrees: float) -> None:
    asked = CRITICAL + math.radians(degrees)
    walked = courses([CRITICAL] + [asked] * 80)
    assert abs(walked[-1] - asked) < math.radians(0.1)
    assert walked.index(walked[-1]) < 80


def test_a_turn_that_is_meant_is_followed_at_once() -> None:
    asked = CRITICAL + 1.01 * MEANT
    assert courses([CRITICAL, asked]) == [CRITICAL, asked]


@pytest.mark.parametrize("off", [0.0, math.pi / 2, CRITICAL - 1.01 * NEAR, -CRITICAL - 1.5 * NEAR])
def test_away_from_the_critical_angle_every_command_is_walked_as_it_comes(off: float) -> None:
    chance = random.Random(1)
    hand = [off - math.copysign(0.02 * chance.random(), off) for _ in range(20)]
    if abs(off) > 1.5:
        hand = [abs(each) for each in hand]
    assert courses(hand) == hand


def test_the_boundary_at_a_half_turn_is_no_jump() -> None:
    behind = math.pi - CRITICAL
    hand = [behind + 0.01 * (-1) ** k for k in range(10)]
    assert set(courses(hand)) == {hand[0]}
