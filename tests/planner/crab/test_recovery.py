"""Ways out where no step gets on along the course: legs stretched to the mechanical limit, a step
back, another course.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.planner.crab.crab_walks import (
    TITAN,
    command,
    gait,
    holes,
    look_at,
    plan_at_once,
    random_stance,
)
from walking_console.planner.crab import predictive_planner, recovery
from walking_console.planner.crab.candidates import SearchContext
from walking_console.planner.crab.gait import nominal_gait, standard_stance
from walking_console.planner.crab.steps import StepRequest
from walking_console.planner.initial_stance import Placement
from walking_console.planner.motion.strides import STRETCHED_LIFT_ROOM
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import Blocked, StepPlan


def far_reaching(machine):
    """The machine as a stretched walk takes it: control reach as wide as the mechanism, less what
    lifting needs.
    """
    dx, dy, dz = machine.overreach
    wider = lambda span, by: (span[0] - by, span[1] + by)  # noqa: E731
    legs = tuple(
        replace(
            leg, x=wider(leg.x, dx - STRETCHED_LIFT_ROOM), y=wider(leg.y, dy - STRETCHED_LIFT_ROOM)
        )
        for leg in machine.legs
    )
    return replace(machine, legs=legs, overreach=(STRETCHED_LIFT_ROOM, STRETCHED_LIFT_ROOM, dz))


FAR = far_reaching(TITAN)


def river(width, at, degrees=0, cell=0.025, rim=1):
    """Level ground with a bottomless strip across the way; ``rim`` cells beside it are forbidden,
    for a sole would hang over.
    """
    count = round(8.0 / cell)
    middle = (np.arange(count) + 0.5) * cell - 2.0
    wet, barred = (
        np.broadcast_to((middle > at - k) & (middle < at + width + k), (count, count))
        for k in (0.0, rim * cell)
    )
    wet, barred = (wet.T, barred.T) if degrees == 90 else (wet, barred)
    return TerrainMap(np.where(wet, np.nan, 0.0), barred.copy(), cell, (-2.0, -2.0))


def walk(order, terrain, until, steps=60, stance=None):
    """Plans until the body has come so far along the course, each with its decision; ends early
    with a ``Blocked``.
    """
    settings = gait()
    stance = stance or standard_stance(
        TITAN, settings, Placement((0.0, 0.0, 0.0), terrain.height_at, order.crab_angle)
    )
    ux, uy = math.cos(order.crab_angle), math.sin(order.crab_angle)
    plans = []
    for _ in range(steps):
        plan = plan_at_once(StepRequest(stance, order, terrain, TITAN, settings, explain=True))
        plans.append((stance, plan))
        if isinstance(plan, Blocked):
            break
        stance = plan.end
        if stance.body[0] * ux + stance.body[1] * uy > until:
            break
    return plans


def kinds(plans):
    return [plan.decision.get("escape") for _, plan in plans]


def none(*_):
    """An escape that is not there."""
    return None
    yield


@pytest.mark.parametrize(("degrees", "width"), [(0, 0.5), (90, 0.35)])
def test_a_river_wider_than_the_control_reach_is_crossed_with_stretched_legs(degrees, width):
    """0.5 m between the banks and half a sole, rounded up to a cell and a half, at either: 0.575 m
    of 0.59 m.
    """
    terrain, settings = river(width, 0.8, degrees), gait()
    plans = walk(command(degrees), terrain, 3.6)
    assert "stretch" in kinds(plans)
    for stance, plan in plans:
        assert isinstance(plan, StepPlan)
        if plan.swing:
            look_at(plan, stance, terrain, FAR, settings)
    assert kinds(plans)[-3:] == [None] * 3, "it does not return to the walk in its control reach"
    assert all(plan.margin_min >= plan.standard_margin - 0.001 for _, plan in plans[-3:])


def test_without_stretching_it_is_the_end_of_the_way(monkeypatch):
    without_stretching(monkeypatch)
    plans = walk(command(), river(0.5, 0.8), 2.4)
    assert isinstance(plans[-1][1], Blocked)


def test_a_river_that_the_control_reach_crosses_is_not_stretched_over():
    plans = walk(command(), river(0.4, 0.8, cell=0.05, rim=0), 2.2)
    assert isinstance(plans[-1][1], StepPlan) and set(kinds(plans)) == {None}


def test_a_river_beyond_the_mechanical_limit_is_not_crossed_and_it_says_why():
    plans = walk(command(), river(0.55, 0.8), 2.4)
    answer = plans[-1][1]
    assert isinstance(answer, Blocked) and "no way on" in answer.text


def test_stretched_legs_reach_their_mechanical_limit_less_what_lifting_needs():
    for degrees in (0, 90, 200):
        usual = nominal_gait(TITAN, gait(), math.radians(degrees))
        far = nominal_gait(TITAN, gait(), math.radians(degrees), stretched=True)
        assert far.far_boxes == usual.far_boxes
        for box, limit in zip(far.boxes, far.far_boxes, strict=True):
            assert np.abs(np.subtract(box, limit)) == pytest.approx(STRETCHED_LIFT_ROOM)


# few footholds, and no stretching: what a step back and another course are for


def among_few_footholds(seed):
    """A posture from anywhere in reach on ground of which 98.5 % is forbidden, and a course."""
    rng = np.random.default_rng(seed)
    return (
        random_stance(rng),
        command(float(rng.choice([0, 90, 20]))),
        holes(0.985, seed=seed, span=8.0),
    )


def without_stretching(monkeypatch):
    monkeypatch.setattr(recovery, "by_stretching", none)
    monkeypatch.setattr(predictive_planner, "by_stretching", none)


@pytest.mark.parametrize("seed", [170, 274, 332, 678])
def test_a_course_within_the_cone_is_taken_where_the_commanded_one_ends(seed, monkeypatch):
    without_stretching(monkeypatch)
    stance, order, terrain = among_few_footholds(seed)
    plan = plan_at_once(StepRequest(stance, order, terrain, TITAN, gait(), explain=True))
    assert isinstance(plan, StepPlan) and plan.decision["escape"] == "cone"
    aside = abs(math.degrees(plan.crab_angle - order.crab_angle))
    assert not plan.swing or aside in (pytest.approx(15.0, abs=0.6), pytest.approx(30.0, abs=0.6))
    monkeypatch.setattr(recovery, "CONE", ())
    assert isinstance(plan_at_once(StepRequest(stance, order, terrain, TITAN, gait())), Blocked)


@pytest.mark.parametrize("seed", [795, 839])
def test_a_step_back_leads_past_where_the_walk_would_end(seed, monkeypatch):
    without_stretching(monkeypatch)
    stance, order, terrain = among_few_footholds(seed)
    plans = walk(order, terrain, 0.2, steps=8, stance=stance)
    assert kinds(plans)[0] == "back" and plans[0][1].shift > 0.0
    assert math.cos(plans[0][1].crab_angle - order.crab_angle) < -0.99
    assert all(isinstance(plan, StepPlan) for _, plan in plans)
    monkeypatch.setattr(recovery, "_by_a_step_back", none)
    assert isinstance(walk(order, terrain, 0.2, steps=8, stance=stance)[-1][1], Blocked)


def test_stretched_ways_are_looked_for_once_however_much_they_must_gain():
    terrain = river(0.3, 0.9)
    stance = standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), lambda x, y: 0.0))
    context = SearchContext(StepRequest(stance, command(0), terrain, TITAN, gait()), 0.0)
    slices = []
    for least in (0.0, 9.0, 0.0):
        job = recovery.by_stretching(context, least)
        count = 0
        while True:
            try:
                next(job)
                count += 1
            except StopIteration as done:
                slices.append((count, done.value is not None))
                break
    assert slices[0] == (slices[0][0], True) and slices[0][0] > 0
    assert slices[1:] == [(0, False), (0, True)]
