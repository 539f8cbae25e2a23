"""What every leg is to carry while a plan runs."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from walking_console import Command, StepPlanner, load_machine
from walking_console.planner.control.load_schedule import LoadSchedule, body_frame_feet
from walking_console.planner.control.tracking import TrajectoryTracker
from walking_console.planner.motion.step_builder import holding_plan
from walking_console.planner.stability import GRAVITY
from walking_console.planner.statics import centre_of_gravity
from walking_console.planner.types import Stance

from .plans import FEET, flat, swing_plan

TITAN = load_machine("titan3")
WEIGHT = TITAN.mass * GRAVITY


def plans(count: int) -> list[TrajectoryTracker]:
    ground = flat()
    planner = StepPlanner(TITAN)
    stance = planner.stance_on(ground)
    trackers = []
    for _ in range(count):
        plan = planner.plan(stance, Command(speed=0.08), ground)
        trackers.append(TrajectoryTracker(plan))
        stance = plan.end
    return trackers


def test_standing_in_the_middle_it_is_an_even_share():
    feet = tuple((*leg.centre, 0.0) for leg in TITAN.legs)
    stance = Stance((0.0, 0.0, TITAN.height, 0.0), feet)
    loads = LoadSchedule(TrajectoryTracker(holding_plan(stance)), TITAN).at(0.0)
    assert loads == pytest.approx([WEIGHT / 4] * 4)


def test_it_holds_the_weight_at_every_time_and_a_swinging_leg_carries_nothing():
    (tracker,) = plans(1)
    schedule = LoadSchedule(tracker, TITAN)
    u = tracker.plan.swing[0]
    for k in range(101):
        t = tracker.duration * k / 100
        loads = schedule.at(t)
        assert sum(loads) == pytest.approx(WEIGHT) and min(loads) >= 0.0
        stretch = tracker.stretches[tracker.stretch(t)]
        if u in stretch.air and not stretch.down:
            assert loads[u] == 0.0


def test_loads_do_not_jump_within_a_step_nor_from_one_to_the_next():
    last = None
    since = {}
    trackers = plans(5)
    for tracker, following in pairwise(trackers):
        schedule = LoadSchedule(tracker, TITAN, since)
        schedule.foresee(following.plan)
        for k in range(math.floor(tracker.duration / 0.005)):
            loads = schedule.at(0.005 * k)
            if last is not None:
                assert max(abs(a - b) for a, b in zip(loads, last, strict=True)) < 0.05 * WEIGHT
            last = loads
        since = schedule.since_landing()


def test_a_leg_lifted_before_the_plan_carries_nothing_while_the_others_shift_the_body():
    plan = swing_plan()
    feet = plan.feet.copy()
    feet[:2, 0, 2] = 0.1
    tracker = TrajectoryTracker(replace(plan, feet=feet), (0,))
    assert LoadSchedule(tracker, TITAN).at(0.1)[0] == 0.0


def test_a_body_that_speeds_up_presses_on_the_feet_behind_it_more():
    plan = swing_plan(advance=0.0)
    rates = np.zeros((5, 4))
    rates[1, 0] = 0.1
    body = plan.body.copy()
    body[1:, 0] = 0.05 * 0.25
    speeding = TrajectoryTracker(replace(plan, body=body, rates=rates))
    t = 0.01
    ax, _ = speeding.bending_at(0.0)
    assert ax == pytest.approx(0.4, abs=1e-9)
    loads = LoadSchedule(speeding, TITAN).at(t)
    still = LoadSchedule(speeding, TITAN).resting(t)
    moment = sum((a - b) * foot[0] for a, b, foot in zip(loads, still, FEET, strict=True))
    height = TITAN.height + centre_of_gravity(TITAN, body_frame_feet(speeding, t))[2]
    assert moment == pytest.approx(-TITAN.mass * ax * height, rel=0.02)


def test_feet_are_seen_from_the_body_as_the_plan_has_it():
    (tracker,) = plans(1)
    (x, y, _), *_ = body_frame_feet(tracker, tracker.duration)
    body = tracker.plan.end.body
    foot = tracker.foot_at(0, tracker.duration)
    assert (x, y) == pytest.approx((foot[0] - body[0], foot[1] - body[1]))
