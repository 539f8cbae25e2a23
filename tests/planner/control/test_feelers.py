"""What feet feel beside their plan."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.planner.control.plans import FEET, flat, sensed, swinging_at
from walking_console.planner.control.encounter import ContactEvent, Encounter, FootState
from walking_console.planner.control.execution import feet_absolute
from walking_console.planner.control.feelers import (
    Feelers,
    felt_ahead,
    felt_towards,
    hangs_over_towards,
)
from walking_console.planner.terrain.map import TerrainMap

GROUND = flat()
AHEAD_BIT = 1


def feeling(t, whiskers=0, rims=(), soles=(True,) * 4):
    state, stance = swinging_at(t)
    x, y, z, yaw = stance.body
    sensing = sensed(body=(x, y, z, 0.0, 0.0, yaw), feet=stance.feet, soles=soles)
    return Feelers(state.run), sensing._replace(whiskers=(whiskers, 0, 0, 0), rims=rims)


@pytest.mark.parametrize("k", range(8))
def test_whiskers_within_60_degrees_of_the_way_count(k):
    angle = k * math.pi / 4
    assert felt_ahead(1 << k, angle) == pytest.approx(math.remainder(angle, 2 * math.pi))
    assert felt_ahead(1 << k, angle + math.pi / 2) is None
    assert felt_ahead(0, angle) is None


def test_something_felt_on_the_way_over_is_a_hit():
    feelers, sensing = feeling(0.6, whiskers=AHEAD_BIT)
    touch = feelers.surprise(sensing, GROUND)
    assert touch is not None and touch.event is ContactEvent.HIT and touch.leg == 0
    assert touch.bearing == pytest.approx(0.0)


def test_what_is_felt_behind_or_going_up_is_none():
    feelers, sensing = feeling(0.6, whiskers=1 << 4)
    assert feelers.surprise(sensing, GROUND) is None
    feelers, sensing = feeling(0.3, whiskers=AHEAD_BIT)
    assert feelers.surprise(sensing, GROUND) is None


def test_what_the_map_shows_is_no_surprise():
    heights = np.full(GROUND.heights.shape, 0.5)
    shown = TerrainMap(heights, GROUND.forbidden, GROUND.cell, GROUND.origin)
    feelers, sensing = feeling(0.6, whiskers=AHEAD_BIT)
    assert feelers.surprise(sensing, shown) is None


def test_a_sole_that_hangs_over_as_it_comes_down_is_an_edge():
    feelers, sensing = feeling(0.95, rims=(AHEAD_BIT, 0, 0, 0))
    touch = feelers.surprise(sensing, GROUND)
    assert touch is not None and touch.event is ContactEvent.EDGE
    assert touch.bearing == pytest.approx(0.0)
    off = sensing._replace(soles=(False, True, True, True))
    assert feelers.surprise(off, GROUND) is None


def test_rims_all_round_have_no_direction():
    _, sensing = feeling(0.95, rims=(0b11111111, 0, 0, 0))
    assert hangs_over_towards(0, sensing) is None


def test_an_obstacle_towards_the_landing_point_is_told_from_one_elsewhere():
    _, sensing = feeling(0.6, whiskers=AHEAD_BIT)
    ahead = Encounter(FootState.CLIMB, 0, (FEET[0][0] + 1.0, FEET[0][1], 0.0))
    assert felt_towards(ahead, sensing) == pytest.approx(0.0, abs=1e-6)
    assert felt_towards(replace(ahead, goal=(-9.0, FEET[0][1], 0.0)), sensing) is None


@pytest.mark.parametrize(
    ("state", "t", "landed", "event"),
    [
        (FootState.RETRY, 0.9, True, ContactEvent.LANDED),
        (FootState.DESCEND, 1.0, False, ContactEvent.NO_GROUND),
        (FootState.RETRY, 0.9, False, None),
    ],
)
def test_what_happens_in_an_encounter(state, t, landed, event):
    walk, _ = swinging_at(t)
    walk.run.reflexes = walk.run.reflexes._replace(landed=(landed, False, False, False))
    touch = Feelers(walk.run).noticed(Encounter(state, 0, FEET[0]), sensed(), GROUND)
    assert (None if touch is None else touch.event) is event


BESIDE = 0b10000011  # straight ahead and on both sides of it
BEHIND = 0b00111000


LOW = TerrainMap(GROUND.heights - 1.0, GROUND.forbidden, GROUND.cell, GROUND.origin)


def gone_down(whiskers, terrain=LOW, state=FootState.DESCEND):
    """What is told of foot 0 that touches ground, 0.1 m after its whiskers felt something."""
    walk, stance = swinging_at(0.9)
    feelers = Feelers(walk.run)
    met = Encounter(state, 0, FEET[0])
    (x, y, z), *others = stance.feet
    for height, sole in ((z, False), (z - 0.1, True)):
        feet = ((x, y, height), *others)
        sensing = sensed(body=(*stance.body[:3], 0.0, 0.0, 0.0), feet=feet)
        sensing = sensing._replace(whiskers=(whiskers, 0, 0, 0), soles=(sole, *sensing.soles[1:]))
        touch = feelers.noticed(met, sensing, terrain)
    return touch, z


@pytest.mark.parametrize("state", [FootState.DESCEND, FootState.RETRY])
@pytest.mark.parametrize("terrain", [LOW, GROUND])
def test_a_surprised_foot_that_comes_down_close_before_something_is_on_a_bad_foothold(
    state, terrain
):
    touch, z = gone_down(BESIDE, terrain, state)
    assert touch is not None and touch.event is ContactEvent.EDGE
    assert touch.tall == pytest.approx(z)


@pytest.mark.parametrize("terrain", [LOW, GROUND])
def test_one_that_went_down_close_before_what_it_comes_from_is_on_a_bad_foothold(terrain):
    touch, _ = gone_down(BEHIND, terrain)
    assert touch is not None and touch.event is ContactEvent.EDGE
    assert gone_down(BEHIND, terrain, FootState.RETRY)[0] is None  # it came over that


@pytest.mark.parametrize(("higher", "bad"), [(None, True), (0.05, False), (0.15, True)])
def test_a_step_that_ends_closer_beside_something_than_the_map_has_it_ends_on_a_bad_foothold(
    higher, bad
):
    feelers, sensing = feeling(0.95, whiskers=BEHIND)
    x, y, z = feet_absolute(sensing)[0]
    heights = {} if higher is None else {LOW.cell_at(x - higher, y): 0.2}
    touch = feelers.surprise(sensing, LOW.told((), heights))
    assert (touch is not None and touch.event is ContactEvent.EDGE) is bad
    assert touch is None or touch.tall == pytest.approx(z)


def test_something_farther_off_or_beside_a_foot_that_is_put_where_ground_was_found_is_not_bad():
    assert gone_down(AHEAD_BIT)[0] is None
    assert gone_down(BESIDE, state=FootState.PLACE)[0] is None
