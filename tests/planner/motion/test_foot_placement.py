"""A lifted foot comes down on the nearest ground it may stand on while the body waits."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.planner.trace.rollout import field_of, gait_of
from walking_console.planner.motion.foot_placement import nearest_ground, place_feet, place_foot
from walking_console.planner.motion.swing import CLEARANCE
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import Blocked, Phase, Stance, StepPlan

HEXAPOD = load_machine("hexapod")
GAIT = gait_of(HEXAPOD)
NOWHERE = TerrainMap(np.zeros((200, 200)), np.ones((200, 200), bool), 0.05, (-5.0, -5.0))


def lifted(*legs: int) -> Stance:
    """A standing hexapod with these feet 0.15 m up."""
    feet = tuple(
        (*leg.centre, 0.15 if number in legs else 0.0) for number, leg in enumerate(HEXAPOD.legs)
    )
    return Stance((0.0, 0.0, HEXAPOD.height, 0.0), feet, lifted=legs)


@pytest.mark.parametrize("seed", range(5))
def test_it_comes_down_on_the_nearest_allowed_cell_in_reach(seed: int) -> None:
    terrain = field_of(0.05, seed, HEXAPOD)
    x, y = HEXAPOD.legs[1].centre
    cell = terrain.cell_at(x, y)
    assert cell is not None
    terrain = terrain.forbid([cell])
    x1, x2, y1, y2 = HEXAPOD.boxes[1]
    able = [
        math.hypot(px - x, py - y)
        for row, column in zip(*np.nonzero(~terrain.forbidden), strict=True)
        for px, py in [terrain.centre(int(row), int(column))]
        if x1 <= px <= x2 and y1 <= py <= y2
    ]
    found = nearest_ground(lifted(1), 1, terrain, HEXAPOD)
    assert found is not None
    assert math.hypot(found[0] - x, found[1] - y) == pytest.approx(min(able))


@pytest.mark.parametrize(("farther", "stretches"), [(0.02, False), (0.12, True)])
def test_a_leg_is_stretched_for_ground_that_is_nearer_by_five_centimetres(
    farther: float, stretches: bool
) -> None:
    x1, x2, y1, y2 = HEXAPOD.boxes[0]
    y = (y1 + y2) / 2.0
    forbidden = np.ones((400, 400), bool)
    terrain = TerrainMap(np.zeros((400, 400)), forbidden, 0.02, (-4.0, -4.0))
    ahead, back = (terrain.cell_at(x, y) for x in (x2 + 0.03, x2 - 0.03 - farther))
    assert ahead is not None and back is not None
    forbidden = forbidden.copy()
    forbidden[ahead] = forbidden[back] = False
    terrain = TerrainMap(terrain.heights, forbidden, 0.02, (-4.0, -4.0))
    stance = lifted(0)
    stance = replace(stance, feet=((x2, y, 0.15), *stance.feet[1:]))
    found = nearest_ground(stance, 0, terrain, HEXAPOD)
    assert found is not None and (found[0] > x2) is stretches


def test_it_clears_what_is_on_its_way_and_aims_below_the_ground() -> None:
    heights = np.zeros((200, 200))
    x, y = HEXAPOD.legs[0].centre
    centres = (np.arange(200) + 0.5) * 0.05 - 5.0
    near = (np.abs(centres - y) < 0.16)[:, None] & (np.abs(centres - x) < 0.16)[None, :]
    heights[near] = 0.25
    terrain = TerrainMap(heights, near, 0.05, (-5.0, -5.0), HEXAPOD.foot_radius)
    plan = place_foot(lifted(0), 0, terrain, HEXAPOD, GAIT)
    assert isinstance(plan, StepPlan)
    assert plan.landing is not None and terrain.allows(*plan.landing[:2])
    returning = [k for k, phase in enumerate(plan.phases) if phase is Phase.RETURN]
    assert plan.feet[returning, 0, 2].min() >= 0.25 + CLEARANCE - 1e-9
    assert plan.feet[-1, 0, 2] < plan.landing[2]
    assert (plan.body == plan.body[0]).all()


def test_where_there_is_no_ground_it_names_the_leg() -> None:
    answer = place_foot(lifted(4), 4, NOWHERE, HEXAPOD, GAIT)
    assert isinstance(answer, Blocked)
    assert answer.leg == 4


def test_several_feet_come_down_at_once_and_one_without_ground_stays_lifted() -> None:
    terrain = field_of(1.0, 0, HEXAPOD)
    x1, x2, y1, y2 = HEXAPOD.boxes[3]
    forbidden = terrain.forbidden.copy()
    delta = 0.2  # the mechanical reach goes a little farther than the box
    forbidden[terrain.window(x1 - delta, x2 + delta, y1 - delta, y2 + delta)] = True
    terrain = TerrainMap(terrain.heights, forbidden, terrain.cell, terrain.origin)
    plan = place_feet(lifted(0, 3), (0, 3), terrain, HEXAPOD, GAIT)
    assert isinstance(plan, StepPlan)
    assert plan.swing == (0, 3)  # both off the ground while the plan lasts
    assert plan.end.lifted == (3,)
    assert plan.end.feet[3] == lifted(3).feet[3]


def test_where_none_finds_ground_all_stay_and_it_says_so() -> None:
    answer = place_feet(lifted(0, 3), (0, 3), NOWHERE, HEXAPOD, GAIT)
    assert isinstance(answer, Blocked)
    assert "any lifted foot" in answer.text
