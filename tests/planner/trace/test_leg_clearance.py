"""Legs beside what is tall: a standing leg runs through nothing from hip to foot."""

from __future__ import annotations

import numpy as np
import pytest

from walking_console.planner.robot.collision import leg_in_the_way
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.trace.lane import Lane
from walking_console.planner.trace.leg_clearance import LegClearance, Swing

HEXAPOD = load_machine("hexapod")
COUNT = 41
XS = np.linspace(0.0, 1.2, COUNT)


def lane() -> Lane:
    still = np.zeros(COUNT)
    return Lane(XS[None, :], np.zeros((1, COUNT)), still, still + HEXAPOD.height)


def ground(*poles: tuple[float, float], top: float = 0.6) -> TerrainMap:
    heights = np.zeros((120, 160))
    for x, y in poles:
        heights[round((y + 1.5) / 0.025), round((x + 1.0) / 0.025)] = top
    return TerrainMap(heights, heights > 0.0, 0.025, (-1.0, -1.5))


@pytest.mark.parametrize("leg", range(6))
def test_a_leg_whose_line_meets_a_pole_does_not_stand_there(leg: int) -> None:
    hip_x, hip_y = HEXAPOD.hips[leg]
    foot = 0.6 + HEXAPOD.legs[leg].centre[0], HEXAPOD.legs[leg].centre[1], 0.0
    pole = 0.6 + hip_x, hip_y + 0.35 * (foot[1] - hip_y)
    terrain = ground(pole)
    clearance = LegClearance(lane(), terrain, HEXAPOD)
    assert clearance.matters and clearance.is_near(foot[0], foot[1])
    free = clearance.clear(leg, foot, np.ones((1, COUNT), dtype=bool))[0]
    assert not free.all() and free.any()
    for k, x in enumerate(XS):
        feet = [foot if k_leg == leg else None for k_leg in range(6)]
        body = (float(x), 0.0, HEXAPOD.height, 0.0)
        if leg_in_the_way(terrain, HEXAPOD, body, feet) is not None:
            assert not free[k]


def test_low_or_distant_things_are_in_nobodys_way() -> None:
    assert not LegClearance(lane(), ground((0.6, 0.4), top=0.2), HEXAPOD).matters
    assert not LegClearance(lane(), ground(), HEXAPOD).matters
    far = LegClearance(lane(), ground((2.4, 1.2)), HEXAPOD)
    assert not far.is_near(0.0, -0.5)


def test_only_poses_that_were_asked_for_are_answered() -> None:
    clearance = LegClearance(lane(), ground((0.6, 0.4)), HEXAPOD)
    asked = np.zeros((1, COUNT), dtype=bool)
    asked[0, 3:9] = True
    assert not (clearance.clear(0, (0.9, 0.55, 0.0), asked) & ~asked).any()


def swing(leg: int, stride: float, inside: float = 0.0) -> Swing:
    """A foot carried ahead from the middle of its reach, the body going half as far."""
    x, y = HEXAPOD.legs[leg].centre
    y -= np.sign(y) * inside
    bodies = [(0.6 + 0.25 * stride * k / 9, 0.0, HEXAPOD.height, 0.0) for k in range(10)]
    return Swing((0.6 + x, y, 0.0), (0.6 + x + stride, y, 0.0), bodies)


@pytest.mark.parametrize("leg", range(6))
def test_a_leg_does_not_swing_through_a_pole_that_it_stands_clear_of_on_both_sides(
    leg: int,
) -> None:
    way = swing(leg, 0.4)
    y = HEXAPOD.hips[leg][1]
    beside = y + 0.6 * (way.stood[1] - y)
    pole = way.stood[0] + 0.18, beside
    clearance = LegClearance(lane(), ground(pole), HEXAPOD)
    for foot, body in ((way.stood, way.bodies[0]), (way.lands, way.bodies[-1])):
        feet = [foot if k == leg else None for k in range(6)]
        assert leg_in_the_way(ground(pole), HEXAPOD, body, feet) is None
    assert clearance.sweeps_through(leg, way)
    outside = way.stood[0] + 0.18, y + 1.4 * (way.stood[1] - y)
    assert not LegClearance(lane(), ground(outside), HEXAPOD).sweeps_through(leg, way)


def test_a_foot_is_lifted_over_what_it_can_be_lifted_over() -> None:
    way = swing(0, 0.4)
    post = way.stood[0] + 0.2, way.stood[1]
    distant = (0.1, -1.2)  # something is tall here, but not near this leg
    low = ground(distant)
    heights = low.heights.copy()
    heights[round((post[1] + 1.5) / 0.025), round((post[0] + 1.0) / 0.025)] = 0.15
    terrain = TerrainMap(heights, heights > 0.0, 0.025, (-1.0, -1.5))
    assert not LegClearance(lane(), terrain, HEXAPOD).sweeps_through(0, way)
