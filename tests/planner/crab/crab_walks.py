"""Small worlds and one thorough look at a plan, for the tests of the crab walk."""

import math

import numpy as np
import pytest

from walking_console.planner.crab.gait import standard_stance
from walking_console.planner.crab.planner import plan_step
from walking_console.planner.crab.predictive_planner import step_job
from walking_console.planner.crab.steps import StepRequest
from walking_console.planner.initial_stance import Placement
from walking_console.planner.protocols import run_to_completion
from walking_console.planner.robot.model import load_machine
from walking_console.planner.stability import (
    MARGIN_SLACK,
    longitudinal_margin,
    polygon_margin,
    support_polygon,
)
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.terrain.traversability import classify
from walking_console.planner.types import Blocked, Command, Gait, Phase, Stance

TITAN = load_machine("titan3")
NEAR = 1e-9


def gait(duty_factor=0.8, smooth=True, machine=TITAN):
    return Gait(duty_factor, machine.lift_up, machine.lift_down, machine.height, smooth)


def holes(fraction=0.0, seed=0, span=24.0, cell=0.05):
    """Level ground on which this fraction of the cells is forbidden at random."""
    count = round(span / cell)
    forbidden = np.random.default_rng(seed).random((count, count)) < fraction
    return TerrainMap(np.zeros((count, count)), forbidden, cell, (-span / 2, -span / 2))


def relief(height, seed=0, span=16.0, cell=0.05, wave=0.6, machine=TITAN):
    """Rolling ground: a sum of waves no shorter than ``wave``, at most ``height`` from crest to
    trough, classified for the machine.
    """
    rng, count = np.random.default_rng(seed), round(span / cell)
    along = (np.arange(count) + 0.5) * cell
    x, y = np.meshgrid(along, along)
    ground = np.zeros((count, count))
    for _ in range(8):
        direction, length, phase = (
            rng.uniform(0, 2 * math.pi),
            rng.uniform(wave, 6 * wave),
            rng.uniform(0, 2 * math.pi),
        )
        ground += (
            np.sin(
                2 * math.pi * (x * math.cos(direction) + y * math.sin(direction)) / length + phase
            )
            * length
        )
    ground *= height / (ground.max() - ground.min())
    return TerrainMap(ground, classify(ground, cell, machine), cell, (-span / 2, -span / 2))


def random_stance(rng, machine=TITAN):
    """Feet anywhere in their reach on level ground such that the machine stands, any leg last."""
    while True:
        feet = tuple((rng.uniform(*leg.x), rng.uniform(*leg.y), 0.0) for leg in machine.legs)
        polygon = support_polygon(feet)
        if len(polygon) == 4 and polygon_margin(polygon, 0.0, 0.0) >= 0.0:
            return Stance((0.0, 0.0, machine.height, 0.0), feet, int(rng.integers(-1, 4)))


def walk(
    command, steps, terrain=None, settings=None, stance=None, machine=TITAN, yaw=0.0, look=True
):
    """Plans of a walk from the standard posture (or ``stance``), each looked at; ends early with a
    ``Blocked``.
    """
    terrain, settings = terrain or holes(), settings or gait(machine=machine)
    stance = stance or standard_stance(
        machine, settings, Placement((0.0, 0.0, yaw), terrain.height_at, command.crab_angle)
    )
    plans = []
    for _ in range(steps):
        plan = plan_step(StepRequest(stance, command, terrain, machine, settings))
        plans.append(plan)
        if isinstance(plan, Blocked):
            break
        if look:
            look_at(plan, stance, terrain, machine, settings)
        stance = plan.end
    return plans


def plan_at_once(request):
    """The step of mode ``predictive``, without a pause."""
    return run_to_completion(step_job(request))


def progress(plans):
    """Metres walked and seconds taken by the steps of a walk."""
    steps = [plan for plan in plans if not isinstance(plan, Blocked)]
    return sum(plan.shift for plan in steps), sum(float(plan.times[-1]) for plan in steps)


def command(degrees=0.0, speed=0.08):
    return Command(math.radians(degrees), speed)


def look_at(plan, stance, terrain, machine, settings):
    """Everything a plan promises: reach, speed, margin, vertical lifts, a landing that is allowed,
    knots that join.
    """
    (leg,) = plan.swing
    times, body, feet = plan.times, plan.body, plan.feet
    assert times[0] == 0.0 and np.all(np.diff(times) > 0.0)
    assert len(plan.phases) == len(times) - 1
    np.testing.assert_allclose(body[0], stance.body, atol=NEAR)
    np.testing.assert_allclose(feet[0], stance.feet, atol=NEAR)
    np.testing.assert_allclose(body[-1], plan.end.body, atol=NEAR)
    assert plan.end.feet[leg] == plan.landing
    assert terrain.allows(*plan.landing[:2])
    assert plan.landing[2] == terrain.height_at(*plan.landing[:2])
    others = [i for i in range(4) if i != leg]
    assert np.array_equal(
        feet[:, others], np.broadcast_to(feet[0, others], feet[:, others].shape)
    ), "a standing foot moved"
    _look_at_swing(plan, leg, machine, terrain)
    _look_at_reach(plan, leg, machine)
    _look_at_speed(plan, machine)
    _look_at_margin(plan, leg, stance)


def _look_at_swing(plan, leg, machine, terrain):
    path = plan.feet[:, leg]
    for k, phase in enumerate(plan.phases):
        rise = path[k + 1] - path[k]
        if phase is Phase.SUPPORT:
            assert np.array_equal(path[k + 1], path[k])
        if phase in (Phase.UP, Phase.DOWN):
            assert np.hypot(rise[0], rise[1]) < NEAR, "the lift is not vertical"
            assert rise[2] * (1 if phase is Phase.UP else -1) >= -NEAR
        if phase is Phase.RETURN:
            for w in np.linspace(0.0, 1.0, 5):
                x, y, z = path[k] + w * rise
                ground = terrain.height_at(x, y)
                assert not z < ground + 0.01, "the foot scrapes the ground on its way"
    assert path[-1, 2] <= plan.landing[2] + NEAR, "the foot does not aim for the ground"


def _seen(plan):
    """Feet in body axes at every knot."""
    yaw = plan.body[0, 3]
    turn = np.array(
        [[math.cos(yaw), math.sin(yaw), 0.0], [-math.sin(yaw), math.cos(yaw), 0.0], [0.0, 0.0, 1.0]]
    )
    return (plan.feet - plan.body[:, None, :3]) @ turn.T


def _look_at_reach(plan, leg, machine):
    seen, over = _seen(plan), machine.overreach
    for i, limits in enumerate(machine.legs):
        carrying = [
            k
            for k in range(len(plan.times))
            if i != leg or (k == 0 or plan.phases[k - 1] is Phase.SUPPORT)
        ]
        for axis, (low, high) in enumerate((limits.x, limits.y, limits.z)):
            values = seen[carrying, i, axis]
            assert np.all((values >= low - 1e-6) & (values <= high + 1e-6)), (
                f"leg {i} stands outside its control reach on axis {axis}"
            )
            values = seen[:, i, axis]
            inside = (values >= low - over[axis] - 1e-6) & (values <= high + over[axis] + 1e-6)
            assert np.all(inside), f"leg {i} leaves its mechanical reach on axis {axis}"
    end = plan.end
    landed = np.array(end.feet[leg]) - np.array(end.body[:3])
    yaw = end.body[3]
    x, y = (
        landed[0] * math.cos(yaw) + landed[1] * math.sin(yaw),
        landed[1] * math.cos(yaw) - landed[0] * math.sin(yaw),
    )
    for value, (low, high) in zip(
        (x, y, landed[2]),
        (machine.legs[leg].x, machine.legs[leg].y, machine.legs[leg].z),
        strict=True,
    ):
        assert low - 1e-6 <= value <= high + 1e-6, (
            "the foothold is outside the control reach at N_{k+1}"
        )


def _look_at_speed(plan, machine):
    speeds = np.abs(np.diff(_seen(plan), axis=0)) / np.diff(plan.times)[:, None, None]
    assert np.all(speeds <= np.array(machine.speed) * (1 + 1e-6)), (
        f"a foot is too fast: {speeds.max(axis=(0, 1))}"
    )


def _look_at_margin(plan, leg, stance):
    yaw = stance.body[3] + plan.crab_angle
    ux, uy = math.cos(yaw), math.sin(yaw)
    least = math.inf
    for k, phase in enumerate(plan.phases):
        carrying = [
            foot for i, foot in enumerate(stance.feet) if i != leg or phase is Phase.SUPPORT
        ]
        for x, y in (plan.body[k, :2], plan.body[k + 1, :2]):
            least = min(least, longitudinal_margin(support_polygon(carrying), x, y, ux, uy))
    assert least == pytest.approx(plan.margin_min, abs=1e-6)
    assert least >= -MARGIN_SLACK
