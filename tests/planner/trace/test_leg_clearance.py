"""Legs beside what is tall: a standing leg runs through nothing from hip to foot."""

from __future__ import annotations

import numpy as np
import pytest

from walking_console.planner.robot.collision import leg_in_the_way
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.trace.lane import Lane
from walking_console.planner.trace.leg_clearance import LegClearance

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
