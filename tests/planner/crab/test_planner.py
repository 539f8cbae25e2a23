"""Whole steps and whole walks: the standard gait is held, turns converge, holes are stepped over,
and a block is explained.
"""

import json
import math

import numpy as np
import pytest

from tests.planner.crab.crab_walks import (
    TITAN,
    Blocked,
    command,
    gait,
    holes,
    progress,
    random_stance,
    relief,
    walk,
)
from walking_console.planner.crab.gait import standard_stance
from walking_console.planner.crab.planner import plan_step
from walking_console.planner.crab.steps import StepRequest
from walking_console.planner.initial_stance import Placement
from walking_console.planner.robot.model import MachineError, load_machine
from walking_console.planner.types import Command


@pytest.mark.parametrize("duty_factor", [0.75, 0.8, 0.9])
@pytest.mark.parametrize("degrees", range(-180, 181, 15))
def test_the_standard_gait_is_held_at_every_crab_angle(degrees, duty_factor):
    plans = walk(command(degrees), 12, settings=gait(duty_factor), yaw=0.2)
    assert len(plans) == 12
    for plan in plans:
        assert plan.margin_min == pytest.approx(plan.standard_margin, abs=1e-6)
        assert plan.crab_angle == math.radians(degrees)
    legs = [(plan.swing[0] - plans[0].end.quarter_turns) % 4 + 1 for plan in plans]
    assert legs == [3, 4, 2, 1] * 3
    way, seconds = progress(plans)
    assert way == pytest.approx(min(0.08, plans[0].speed_max) * seconds)
    x, y = plans[-1].end.body[:2]
    assert (
        math.atan2(y, x)
        == pytest.approx(math.remainder(math.radians(degrees) + 0.2, 2 * math.pi), abs=1e-9)
        or abs(degrees) == 180
    )


def test_every_fifth_degree_too():
    for degrees in range(-180, 181, 5):
        for plan in walk(command(degrees), 8, look=False):
            assert plan.margin_min == pytest.approx(plan.standard_margin, abs=1e-6)


# From the standard posture of 0 the paper's method alone cannot turn straight to these: the body is
# carried to the end of
# its reach in the first step and no triangle can be entered from there. Turned to half a cycle
# later they are walked.
TOO_FAR_AT_ONCE = {45, -135}


@pytest.mark.parametrize("degrees", range(-180, 180, 15))
def test_from_straight_ahead_it_turns_to_every_crab_angle_and_finds_the_standard_gait_again(
    degrees,
):
    stance = standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), lambda x, y: 0.0))
    plans = walk(command(degrees), 28, stance=stance)
    if degrees in TOO_FAR_AT_ONCE:
        assert isinstance(plans[-1], Blocked)
        later = walk(command(0), 2, stance=stance)[-1].end
        plans = walk(command(degrees), 28, stance=later)
    assert not isinstance(plans[-1], Blocked)
    for plan in plans[20:]:
        assert plan.margin_min == pytest.approx(plan.standard_margin, abs=1e-6)


@pytest.mark.parametrize("seed", range(60))
def test_every_step_over_holes_keeps_every_promise(seed):
    rng = np.random.default_rng(seed)
    settings = gait(rng.uniform(0.75, 0.9), bool(rng.integers(2)))
    going = Command(rng.uniform(-math.pi, math.pi), float(rng.choice([0.0, 0.02, 0.1, 1.0])))
    stance = random_stance(rng) if seed % 2 else None
    plans = walk(
        going, 16, holes(rng.uniform(0.0, 0.8), seed), settings, stance, yaw=rng.uniform(-3, 3)
    )
    assert plans


@pytest.mark.parametrize(("fraction", "share"), [(0.0, 1.0), (0.3, 0.6), (0.5, 0.4)])
def test_it_walks_on_over_forbidden_cells(fraction, share):
    shares = []
    for seed in range(6):
        plans = walk(command(-75 + 30 * seed, 0.1), 40, holes(fraction, 40 + seed), look=False)
        way, seconds = progress(plans)
        shares.append(
            way / (0.1 * max(seconds, 60.0))
            if isinstance(plans[-1], Blocked)
            else way / (0.1 * seconds)
        )
    assert np.mean(shares) > share - 0.1


def test_most_random_postures_find_the_standard_gait():
    found = 0
    for seed in range(80):
        rng = np.random.default_rng(1000 + seed)
        going, settings = (
            Command(rng.uniform(-math.pi, math.pi), 0.08),
            gait(rng.uniform(0.75, 0.9)),
        )
        plans = walk(going, 30, settings=settings, stance=random_stance(rng), look=False)
        tail = plans[-8:]
        found += not isinstance(plans[-1], Blocked) and all(
            plan.margin_min >= plan.standard_margin - 0.001 for plan in tail
        )
    assert found >= 0.75 * 80


def test_planning_is_repeatable():
    ground = relief(0.3, seed=5)
    one, two = (walk(command(33, 0.1), 20, ground, look=False) for _ in range(2))
    for a, b in zip(one, two, strict=True):
        assert (
            a.end == b.end and np.array_equal(a.feet, b.feet) and np.array_equal(a.times, b.times)
        )


def test_a_plan_cannot_be_changed():
    plan = walk(command(), 1)[0]
    for array in (plan.times, plan.body, plan.feet):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_with_nowhere_to_land_it_says_of_every_leg_why():
    stance = standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), lambda x, y: 0.0))
    blocked = plan_step(StepRequest(stance, command(), holes(1.0), TITAN, gait()))
    assert isinstance(blocked, Blocked)
    assert blocked.leg == 2
    for leg in (1, 2, 3, 4):
        assert f"leg {leg}: " in blocked.text
    assert blocked.decision is None


def test_asked_to_explain_it_tells_legs_limits_and_refused_cells():
    ground = holes(0.7, seed=8)
    stance = standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), ground.height_at))
    for _ in range(10):
        plan = plan_step(StepRequest(stance, command(), ground, TITAN, gait(), explain=True))
        silent = plan_step(StepRequest(stance, command(), ground, TITAN, gait()))
        decision = plan.decision
        json.dumps(decision, allow_nan=False)
        assert decision["legs"] and {"leg", "agreeing_pairs", "return_length"} <= set(
            decision["legs"][0]
        )
        if isinstance(plan, Blocked):
            assert isinstance(silent, Blocked) and silent.text == plan.text
            break
        assert silent.decision is None and silent.end == plan.end, "explaining changed the plan"
        trial = decision["legs"][-1]
        assert trial["leg"] == plan.swing[0] + 1
        assert trial["g"] == plan.shift and trial["g0"] == plan.support_shift
        for cell in trial["refused"]:
            if cell["reason"] == "prohibited cell":
                assert not ground.allows(cell["x"], cell["y"])
        stance = plan.end


def test_the_course_walked_adds_up():
    plans = walk(command(60), 8)
    assert plans[-1].end.course == pytest.approx(sum(plan.shift for plan in plans))


def test_a_machine_without_four_mirrored_legs_is_refused():
    hexapod = load_machine("hexapod")
    with pytest.raises(MachineError, match="four-legged"):
        standard_stance(
            hexapod, gait(machine=hexapod), Placement((0.0, 0.0, 0.0), lambda x, y: 0.0)
        )
