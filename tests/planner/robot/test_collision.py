"""Whether a leg, a straight line from hip to foot, runs through something tall."""

import math

import numpy as np
import pytest

from walking_console.planner.geometry.transforms import placed
from walking_console.planner.robot.collision import (
    NEAR_FOOT,
    TALL,
    SteppingLegs,
    leg_in_the_way,
    something_tall,
)
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap

TITAN = load_machine("titan3")
CELL = 0.025


def ground(height: float, x: float, y: float, side: float = 0.1) -> TerrainMap:
    """Level ground with a post of this height at (x, y)."""
    count = 160
    heights = np.zeros((count, count))
    centres = (np.arange(count) + 0.5) * CELL - 2.0
    on = (abs(centres - y) < side / 2)[:, None] & (abs(centres - x) < side / 2)[None, :]
    heights[on] = height
    return TerrainMap(heights, heights > 0.0, CELL, (-2.0, -2.0))


def standing(yaw: float = 0.0):
    """The body over the origin and a foot under the middle of every leg's reach."""
    feet = [(*placed((0.0, 0.0, yaw), *leg.centre), 0.0) for leg in TITAN.legs]
    return (0.0, 0.0, TITAN.height, yaw), feet


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.0])
@pytest.mark.parametrize("leg", range(4))
def test_a_post_under_a_leg_is_met_by_that_leg(leg: int, yaw: float) -> None:
    body, feet = standing(yaw)
    hip = placed((0.0, 0.0, yaw), *TITAN.hips[leg])
    middle = [(a + b) / 2 for a, b in zip(hip, feet[leg], strict=False)]
    assert leg_in_the_way(ground(0.8, *middle), TITAN, body, feet) == leg


def test_a_leg_meets_every_tall_cell_its_line_goes_through_were_it_only_a_corner() -> None:
    rng = np.random.default_rng(5)
    met = 0
    for _ in range(300):
        heights = np.where(rng.random((60, 60)) < 0.04, 5.0, 0.0)
        terrain = TerrainMap(heights, heights > 0.0, CELL, (-0.75, -0.75))
        x, y = TITAN.hips[0]
        ahead, left = rng.uniform(-0.3, 0.3, 2)
        length = math.hypot(ahead, left)
        shares = np.linspace(0.0, max(length - NEAR_FOOT, 0.0) / length, 4000)
        hip = 0.004, 0.003
        columns = ((hip[0] + shares * ahead + 0.75) / CELL).astype(int)
        rows = ((hip[1] + shares * left + 0.75) / CELL).astype(int)
        tall = bool((heights[rows, columns] > 0.0).any()) and length > NEAR_FOOT
        body = (hip[0] - x, hip[1] - y, TITAN.height, 0.0)
        feet = [(hip[0] + ahead, hip[1] + left, 0.0), None, None, None]
        assert (leg_in_the_way(terrain, TITAN, body, feet) == 0) is tall
        met += tall
    assert 50 < met < 250


def test_what_is_lower_than_the_line_of_the_leg_is_passed_over() -> None:
    body, feet = standing()
    hip = TITAN.hips[0]
    middle = [(a + b) / 2 for a, b in zip(hip, feet[0], strict=False)]
    assert leg_in_the_way(ground(0.15, *middle), TITAN, body, feet) is None


def test_a_leg_without_a_foot_is_not_looked_at() -> None:
    body, feet = standing()
    middle = [(a + b) / 2 for a, b in zip(TITAN.hips[0], feet[0], strict=False)]
    assert leg_in_the_way(ground(0.8, *middle), TITAN, body, [None, *feet[1:]]) is None


def test_only_what_stands_near_and_tall_is_worth_a_look() -> None:
    assert something_tall(ground(TALL + 0.05, 0.5, 0.5), TITAN, 0.0, 0.0, 0.0)
    assert not something_tall(ground(TALL - 0.05, 0.5, 0.5), TITAN, 0.0, 0.0, 0.0)
    far = ground(TALL + 0.05, 1.9, 1.9)
    assert math.hypot(1.9, 1.9) > 2.0
    assert not something_tall(far, TITAN, -1.0, -1.0, 0.0)


def stepping(terrain: TerrainMap) -> SteppingLegs:
    """Legs of a body that goes straight ahead."""
    body, feet = standing()
    return SteppingLegs(terrain, TITAN, feet, lambda way, z: (body[0] + way, body[1], z, 0.0))


def test_a_leg_that_stands_meets_a_post_beside_the_way_of_its_body_but_not_while_it_swings() -> (
    None
):
    way = 0.2
    (hip_x, hip_y), (foot_x, foot_y) = TITAN.hips[0], TITAN.legs[0].centre
    post = ((hip_x + way + foot_x) / 2, (hip_y + foot_y) / 2)
    legs = stepping(ground(0.8, *post))
    assert legs.standing_meet(2, way, TITAN.height)
    assert not legs.standing_meet(0, way, TITAN.height)
    assert not legs.meet(0.0, TITAN.height, {1: standing()[1][1]})
    assert not stepping(ground(0.15, *post)).standing_meet(2, way, TITAN.height)


def test_a_swing_meets_a_post_halfway_that_its_ends_are_clear_of() -> None:
    x, y, _ = standing()[1][0]
    begin, end = (x - 0.2, y), (x + 0.2, y)
    hip_x, hip_y = TITAN.hips[0]
    post = ((hip_x + x) / 2, (hip_y + y) / 2)
    for height, met in ((0.8, True), (0.15, False)):
        body, feet = standing()
        feet[0] = (*begin, 0.0)
        legs = SteppingLegs(ground(height, *post), TITAN, feet, lambda way, z: (way, 0.0, z, 0.0))
        for foot in (begin, end):
            assert not legs.meet(0.0, body[2], {0: (*foot, 0.0)})
        assert legs.swinging_meets(0, end, (0.0, 0.0), body[2], 0.1) == met
