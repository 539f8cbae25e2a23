"""Postures to begin in."""

import math

import pytest

from walking_console.planner.initial_stance import Placement, square_stance, stance_on, standing
from walking_console.planner.robot.model import load_machine
from walking_console.planner.types import Gait

TITAN = load_machine("titan3")
GAIT = Gait(TITAN.duty_factor, TITAN.lift_up, TITAN.lift_down, TITAN.height)
FEET = [list(leg.centre) for leg in TITAN.legs]


def level(x: float, y: float) -> float:
    return 0.25


def test_square_every_foot_is_in_the_middle_of_its_reach_and_the_body_above() -> None:
    stance = square_stance(TITAN, GAIT, Placement((1.0, 2.0, math.pi / 2), level))
    assert stance.body == (1.0, 2.0, 0.25 + GAIT.height, math.pi / 2)
    for (x, y, z), (cx, cy) in zip(stance.feet, FEET, strict=True):
        assert (x, y, z) == pytest.approx((1.0 - cy, 2.0 + cx, 0.25))


def test_a_foot_over_a_hole_does_not_count_for_the_height() -> None:
    place = Placement((0.0, 0.0, 0.0), lambda x, y: math.nan if x > 0 and y > 0 else 0.5)
    stance = square_stance(TITAN, GAIT, place)
    assert stance.body[2] == 0.5 + GAIT.height and math.isnan(stance.feet[0][2])


def test_feet_of_ones_own_choosing_stand_where_they_are_put() -> None:
    stance = stance_on(TITAN, GAIT, FEET, 0.0, 0.0, 0.0, level)
    assert [foot[:2] for foot in stance.feet] == [tuple(foot) for foot in FEET]
    assert stance.body[2] == 0.25 + GAIT.height


def test_what_it_cannot_stand_on_is_refused_and_says_why() -> None:
    with pytest.raises(ValueError, match="has 4 legs, got 3 feet"):
        stance_on(TITAN, GAIT, FEET[:3], 0.0, 0.0, 0.0, level)
    with pytest.raises(ValueError, match="foot 1 must be within"):
        stance_on(TITAN, GAIT, [[9.0, 9.0], *FEET[1:]], 0.0, 0.0, 0.0, level)
    with pytest.raises(ValueError, match="over a hole"):
        stance_on(TITAN, GAIT, FEET, 0.0, 0.0, 0.0, lambda x, y: math.nan)


def test_standing_a_foot_over_a_hole_is_at_the_mean_of_the_others_and_every_leg_reaches() -> None:
    places = [leg.centre for leg in TITAN.legs]
    stance = standing(
        TITAN, GAIT, (0.0, 0.0, 0.0), places, lambda x, y: math.nan if x > 0 and y > 0 else 0.2
    )
    assert [z for _, _, z in stance.feet] == [pytest.approx(0.2)] * 4
    uneven = standing(TITAN, GAIT, (0.0, 0.0, 0.0), places, lambda x, y: 0.4 if x > 0 else 0.0)
    low, high = TITAN.z_range
    assert all(low <= z - uneven.body[2] <= high for _, _, z in uneven.feet)
