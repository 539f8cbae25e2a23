"""What holds of every posture that is taken, and small worlds to take it in."""

import math

import numpy as np
import pytest

from tests.sweeps.postures import gait_of, ground_of
from walking_console.planner.initial_stance import Placement
from walking_console.planner.motion.postures import STILL, PlanSequence
from walking_console.planner.motion.swing import CLEARANCE
from walking_console.planner.registry import initial_stance
from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import polygon_margin, support_polygon
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import Gait, Phase, Stance, StepPlan

GROUNDS = ("level", "30 % forbidden", "80 % forbidden", "rough")
POSTURES = 40  # of each machine on each ground
ROUND = 1e-6  # m, and m/s


def in_body(plan: StepPlan) -> np.ndarray:
    """Foot tips of every knot as the body sees them, (m, n, 3)."""
    relative = plan.feet - plan.body[:, None, :3]
    c, s = np.cos(plan.body[:, 3])[:, None], np.sin(plan.body[:, 3])[:, None]
    return np.stack(
        [
            c * relative[..., 0] + s * relative[..., 1],
            c * relative[..., 1] - s * relative[..., 0],
            relative[..., 2],
        ],
        axis=-1,
    )


def assert_sound(plans: PlanSequence, start: Stance, terrain: TerrainMap, machine: Machine) -> None:
    """What holds for every posture being taken: one story without jumps, on feet that carry, in
    reach, within speed, over the ground.
    """
    body, feet = start.body, start.feet
    for plan in plans:
        assert plan.body[0] == pytest.approx(body) and plan.feet[0].ravel() == pytest.approx(
            np.array(feet).ravel()
        )
        assert (
            len(plan.swing) <= 1
            and len(plan.phases) == len(plan.times) - 1
            and (np.diff(plan.times) > 0.0).all()
        )
        seen = in_body(plan)
        speeds = np.abs(np.diff(seen, axis=0)) / np.diff(plan.times)[:, None, None]
        assert (speeds.max(axis=(0, 1)) <= np.array(machine.speed) + ROUND).all()
        standing = [leg for leg in range(len(feet)) if leg not in plan.swing]
        assert (plan.feet[:, standing] == plan.feet[0, standing]).all(), (
            "feet that stand stay where they are"
        )
        polygon = support_polygon([feet[leg] for leg in standing])
        assert min(polygon_margin(polygon, x, y) for x, y in plan.body[:, :2]) >= -ROUND
        for index, leg in enumerate(machine.legs):
            for axis, (low, high) in enumerate((leg.x, leg.y, leg.z)):
                over = (
                    machine.overreach[axis] + ROUND
                    if index in plan.swing and axis == 2
                    else STILL + ROUND
                )
                assert (
                    seen[:, index, axis].min() >= low - over
                    and seen[:, index, axis].max() <= high + over
                ), (leg.name, "xyz"[axis])
        if plan.swing:
            assert (plan.body == plan.body[0]).all(), "the body waits while a foot is in the air"
            assert_swings_clear(plan, terrain)
        body, feet = plan.end.body, plan.end.feet


def assert_swings_clear(plan: StepPlan, terrain: TerrainMap) -> None:
    u, landing = plan.swing[0], plan.landing
    assert landing is not None and terrain.allows(landing[0], landing[1])
    for k, phase in enumerate(plan.phases):
        if phase is Phase.RETURN:
            a, b = plan.feet[k, u], plan.feet[k + 1, u]
            for w in np.linspace(0.0, 1.0, 20):
                x, y, z = a + w * (b - a)
                assert z >= terrain.height_at(x, y) + CLEARANCE - ROUND


def places(
    machine: Machine, leg: int, goal: Stance, stance: Stance, terrain: TerrainMap, gait: Gait
) -> list[float]:
    """Distances from a foot's place of every cell centre it could have taken instead, by looking at
    them all.
    """
    (gx, gy, _), (x1, x2, y1, y2), (low, high) = (
        goal.feet[leg],
        machine.boxes[leg],
        machine.legs[leg].z,
    )
    bx, by, _, yaw = goal.body
    level = sum(foot[2] for foot in stance.feet) / len(stance.feet) + gait.height
    c, s = math.cos(yaw), math.sin(yaw)
    found = []
    for row, column in zip(*np.nonzero(~terrain.forbidden), strict=True):
        px, py = terrain.centre(int(row), int(column))
        u, v = c * (px - bx) + s * (py - by), c * (py - by) - s * (px - bx)
        if x1 <= u <= x2 and y1 <= v <= y2 and low <= terrain.height_at(px, py) - level <= high:
            found.append(math.hypot(px - gx, py - gy))
    return found


def level_stance(machine: Machine) -> tuple[Stance, Gait, TerrainMap]:
    gait, terrain = gait_of(machine), ground_of("level", machine, np.random.default_rng(1))
    return (
        initial_stance(
            "crab", "", machine, gait, Placement((0.0, 0.0, 0.0), terrain.height_at, 0.0)
        ),
        gait,
        terrain,
    )
