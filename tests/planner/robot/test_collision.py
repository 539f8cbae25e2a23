"""Whether a leg, a straight line from hip to foot, runs through something tall."""

import math

import numpy as np
import pytest

from walking_console.planner.geometry.transforms import placed
from walking_console.planner.robot.collision import TALL, leg_in_the_way, something_tall
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
