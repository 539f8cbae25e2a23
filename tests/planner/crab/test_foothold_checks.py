"""Level B3: what heights allow of a step, and what lift and torso must clear."""

import numpy as np
import pytest

from tests.planner.crab.crab_walks import TITAN, Blocked, command, gait, holes, relief, walk
from walking_console.planner.crab.foothold_checks import FootholdChecks
from walking_console.planner.crab.gait import nominal_gait, posture_of, standard_stance
from walking_console.planner.crab.leg_selection import decide
from walking_console.planner.crab.planner import plan_step
from walking_console.planner.crab.step_refusals import StepRefusal
from walking_console.planner.crab.steps import Shift, StepRequest
from walking_console.planner.initial_stance import Placement
from walking_console.planner.robot.collision import TALL
from walking_console.planner.terrain.cells import foothold_map
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.terrain.traversability import classify


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("height", [0.15, 0.5])
def test_the_walk_over_rolling_ground_keeps_every_promise(height, seed):
    ground = relief(height, seed)
    degrees = -150 + 80 * seed
    plans = walk(command(degrees, 0.1), 24, ground, yaw=0.4 * seed)
    assert not isinstance(plans[-1], Blocked)
    climbed = np.ptp([plan.body[-1, 2] for plan in plans])
    assert climbed > 0.01


def stairs(rise, tread=0.45, cell=0.025, span=10.0):
    count = round(span / cell)
    x = (np.arange(count) + 0.5) * cell - span / 2
    heights = np.tile(np.clip(np.floor((x - 1.0) / tread) + 1, 0, 5) * rise, (count, 1))
    return TerrainMap(heights, classify(heights, cell, TITAN), cell, (-span / 2, -span / 2))


def test_it_climbs_stairs():
    plans = walk(command(0, 0.1), 24, stairs(0.12))
    assert not isinstance(plans[-1], Blocked)
    assert plans[-1].body[-1, 2] > TITAN.height + 0.4


def test_a_wall_stops_the_torso_and_is_named():
    ground = holes(span=10.0)
    heights = np.where(np.arange(200)[None, :] * 0.05 - 5.0 > 1.5, 3.0, 0.0) * np.ones((200, 1))
    wall = TerrainMap(heights, classify(heights, 0.05, TITAN), 0.05, ground.origin)
    last = walk(command(0, 0.1), 40, wall)[-1]
    assert isinstance(last, Blocked)
    assert "torso" in last.text or "no leg" in last.text


def test_a_pole_between_the_feet_stops_the_torso_and_is_named():
    heights = np.zeros((200, 200))
    heights[99:101, 140:142] = 1.4
    pole = TerrainMap(heights, classify(heights, 0.05, TITAN), 0.05, (-5.0, -5.0))
    last = walk(command(0, 0.1), 40, pole)[-1]
    assert isinstance(last, Blocked) and "torso would touch the ground" in last.text


def test_a_low_block_between_the_feet_raises_the_body():
    heights = np.zeros((200, 200))
    heights[97:103, 130:134] = 0.85
    block = TerrainMap(heights, classify(heights, 0.05, TITAN), 0.05, (-5.0, -5.0))
    plans = walk(command(0, 0.1), 24, block)
    assert not isinstance(plans[-1], Blocked)
    assert max(plan.body[-1, 2] for plan in plans) == pytest.approx(
        0.85 + TITAN.torso[2] / 2 + 0.02
    )


def test_a_foothold_too_high_for_the_lift_is_refused_and_the_reason_noted():
    heights = np.where(np.arange(200)[None, :] * 0.05 - 5.0 > 0.72, 0.45, 0.0) * np.ones((200, 1))
    ledge = TerrainMap(heights, np.zeros(heights.shape, dtype=bool), 0.05, (-5.0, -5.0))
    stance = standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), ledge.height_at))
    reasons = set()
    for _ in range(12):
        plan = plan_step(StepRequest(stance, command(), ledge, TITAN, gait(), explain=True))
        reasons |= {cell["reason"] for trial in plan.decision["legs"] for cell in trial["refused"]}
        if isinstance(plan, Blocked):
            break
        stance = plan.end
    assert reasons & {
        "the foot cannot be lifted over the ground on the way",
        "too high or too low for the legs to reach together",
    }


def test_the_leg_that_swings_is_not_swept_through_a_pole():
    """Old and new foothold are free, the legs that stand are clear of it; halfway it stands between
    hip and foot.
    """
    settings = gait()
    stance = standard_stance(TITAN, settings, Placement((0.0, 0.0, 0.0), lambda x, y: 0.0))
    nominal = nominal_gait(TITAN, settings, 0.0)
    posture = posture_of(nominal, stance)
    step = decide(posture, foothold_map(holes()))
    shift, leg = Shift(step.leg, step.g0, step.g, -1.0, 1.0), nominal.body_leg[step.leg]
    way = (step.g0 + step.g) / 2
    (hip_x, hip_y), (foot_x, foot_y) = TITAN.hips[leg], stance.feet[leg][:2]
    middle_x, middle_y = (foot_x + step.landing.ax) / 2, (foot_y + step.landing.ay) / 2
    x, y = hip_x + way + 0.5 * (middle_x - hip_x - way), hip_y + 0.5 * (middle_y - hip_y)
    for height, refusal in ((0.0, None), (0.3, None), (0.8, StepRefusal.TALL)):
        open_ground = holes()
        heights = open_ground.heights.copy()
        row, column = open_ground.cell_at(x, y)
        heights[row, column] = height
        terrain = TerrainMap(heights, open_ground.forbidden, open_ground.cell, open_ground.origin)
        checks = FootholdChecks(posture, StepRequest(stance, command(), terrain, TITAN, settings))
        assert (checks.legs_among_tall is None) == (height < TALL)
        if checks.legs_among_tall is not None:
            foot = checks.foot_at(step.landing)
            assert not checks.legs_among_tall.meet(shift.g, TITAN.height, {leg: foot})
        assert checks.refuses(shift, step.landing) == refusal, height
