"""How far a body may sway aside: within reach, and into nothing tall."""

import numpy as np
import pytest

from walking_console.planner.geometry.transforms import turned
from walking_console.planner.motion.body_path import OFFSET_MAX
from walking_console.planner.motion.sway_room import LOOK, SwayRoom, shift_is_barred
from walking_console.planner.robot.collision import leg_in_the_way
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import Point, Stance

TITAN = load_machine("titan3")
CELL, LOW = 0.0125, -3.0
LEFT = (0.0, 1.0)
BODY = (0.0, 0.0, TITAN.height, 0.0)
# the rear left foot stands under the body, in front of its hip: its leg leans ahead
FEET = ((0.45, 0.45, 0.0), (-0.15, 0.36, 0.0), (-0.45, -0.45, 0.0), (0.45, -0.45, 0.0))
STANCE = Stance(BODY, FEET)


def with_block(x1: float, x2: float, y1: float, y2: float, height: float = 0.7) -> TerrainMap:
    """Level ground with a block of it so high."""
    heights = np.zeros((480, 480))
    columns = slice(round((x1 - LOW) / CELL), round((x2 - LOW) / CELL))
    rows = slice(round((y1 - LOW) / CELL), round((y2 - LOW) / CELL))
    heights[rows, columns] = height
    return TerrainMap.from_heights(heights, CELL, TITAN, (LOW, LOW))


BESIDE = with_block(-0.6, -0.35, 0.3375, 0.6)


def moved(y: float) -> tuple[float, float, float, float]:
    return BODY[0], y, BODY[2], BODY[3]


def seen_from(yaw: float, foot: Point) -> Point:
    """A foot of a body that faces another way."""
    x, y = turned(foot[0], foot[1], yaw)
    return x, y, foot[2]


def test_on_open_ground_only_reach_bounds_the_sway():
    open_ground = with_block(2.0, 2.5, 2.0, 2.5)
    assert SwayRoom.about(STANCE, TITAN, None).offsets(BODY, LEFT, FEET) == pytest.approx(
        SwayRoom.about(STANCE, TITAN, open_ground).offsets(BODY, LEFT, FEET)
    )


def test_a_foot_beyond_its_reach_leads_the_body_nowhere_but_may_be_neared():
    room = SwayRoom(TITAN)
    for far, low, high in ((0.72, 0.0, OFFSET_MAX), (0.24, -OFFSET_MAX, 0.0)):
        feet = ((0.45, far, 0.0), (-0.45, 0.45, 0.0), *FEET[2:])
        assert room.beyond(BODY, feet) > 0.0  # too far out for its leg, or too far in
        assert room.offsets(BODY, LEFT, feet) == (low, high)


def test_a_body_keeps_within_reach_of_places_at_all_of_which_no_foot_is_farther():
    room = SwayRoom(TITAN)
    rng = np.random.default_rng(3)
    kept = []
    for yaw in rng.uniform(-3.0, 3.0, 200):
        x, y, width = rng.uniform(-0.25, 0.25, 3)
        places = [(float(x + k * width), float(y), BODY[2], float(yaw)) for k in range(4)]
        feet = [seen_from(yaw, foot) for foot in FEET]
        farthest = max(room.beyond(place, feet) for place in places)
        kept.append(room.keeps_within(places, feet, 0.01))
        assert kept[-1] is (farthest <= -0.01)
    assert 0 < sum(kept) < len(kept)


def test_beside_a_wall_it_sways_no_farther_than_a_standing_leg_has_room_and_away_as_ever():
    free = SwayRoom.about(STANCE, TITAN, None).offsets(BODY, LEFT, FEET)
    low, high = SwayRoom.about(STANCE, TITAN, BESIDE).offsets(BODY, LEFT, FEET)
    assert low == free[0] and high < free[1] == OFFSET_MAX
    assert leg_in_the_way(BESIDE, TITAN, moved(high), FEET) is None
    assert leg_in_the_way(BESIDE, TITAN, moved(high + LOOK), FEET) is not None


def test_nor_so_far_that_the_torso_is_in_the_wall():
    ground = with_block(-1.0, 1.0, 0.325, 0.6, 1.0)
    legs_aside = tuple((x, 0.31 if y > 0.0 else y, z) for x, y, z in FEET)
    _, high = SwayRoom.about(STANCE, TITAN, ground).offsets(BODY, LEFT, legs_aside)
    assert high <= 0.03


def test_a_shift_on_all_feet_is_barred_where_a_leg_or_the_torso_runs_into_something_tall():
    assert not shift_is_barred(BESIDE, TITAN, STANCE, (0.0, -0.1))
    assert shift_is_barred(BESIDE, TITAN, STANCE, (0.0, 0.1))
    ahead = with_block(0.7, 0.9, -0.1, 0.1, 1.0)
    assert shift_is_barred(ahead, TITAN, STANCE, (0.2, 0.0))
    assert not shift_is_barred(ahead, TITAN, STANCE, (0.1, 0.0))


def test_a_leg_that_meets_something_already_is_led_away_from_it_not_into_it():
    inside = Stance(moved(0.1), FEET)
    assert leg_in_the_way(BESIDE, TITAN, inside.body, FEET) is not None
    assert not shift_is_barred(BESIDE, TITAN, inside, (0.0, -0.05))
    assert shift_is_barred(BESIDE, TITAN, inside, (0.0, 0.12))
