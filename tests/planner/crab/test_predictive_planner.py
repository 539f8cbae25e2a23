"""Mode ``predictive``: the standard walk where it can be, a way on where the paper has none, and
the reason where there is none.
"""

import math

import numpy as np
import pytest

from tests.planner.crab.crab_walks import (
    NEAR,
    TITAN,
    command,
    gait,
    holes,
    look_at,
    plan_at_once,
    random_stance,
    relief,
)
from walking_console.planner.crab.gait import AGREEMENT, off_standard, standard_stance
from walking_console.planner.crab.planner import plan_step
from walking_console.planner.crab.predictive_planner import DEPARTURES, WAYS_OUT, step_job
from walking_console.planner.crab.steps import StepRequest
from walking_console.planner.initial_stance import Placement
from walking_console.planner.stability import MARGIN_SLACK, polygon_margin, support_polygon
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import Blocked, Departure, Phase, Stance, StepPlan

LOWER = 0.001  # m below s0 that still counts as the standard margin


def start(degrees, settings, terrain):
    return standard_stance(
        TITAN, settings, Placement((0.0, 0.0, 0.0), terrain.height_at, math.radians(degrees))
    )


def walk(order, steps, terrain, stance=None, settings=None):
    """Plans of a predictive walk, each looked at; ends early with a ``Blocked``."""
    settings = settings or gait()
    stance = stance or standard_stance(
        TITAN, settings, Placement((0.0, 0.0, 0.0), terrain.height_at, order.crab_angle)
    )
    plans = []
    for _ in range(steps):
        plan = plan_at_once(StepRequest(stance, order, terrain, TITAN, settings))
        plans.append(plan)
        if isinstance(plan, Blocked):
            break
        look_at_any(plan, stance, terrain, settings)
        stance = plan.end
    return plans


def look_at_any(plan, stance, terrain, settings):
    if plan.swing:
        look_at(plan, stance, terrain, TITAN, settings)
        return
    assert plan.phases == (Phase.SHIFT,)
    assert np.array_equal(plan.feet[0], plan.feet[-1]) and plan.end.feet == stance.feet
    polygon = support_polygon(stance.feet)
    assert min(polygon_margin(polygon, x, y) for x, y in plan.body[:, :2]) >= -MARGIN_SLACK
    for i, leg in enumerate(TITAN.legs):
        seen = plan.feet[-1, i] - plan.body[-1, :3]
        assert (
            leg.x[0] - NEAR <= seen[0] <= leg.x[1] + NEAR
            and leg.y[0] - NEAR <= seen[1] <= leg.y[1] + NEAR
        )


@pytest.mark.parametrize("degrees", [0, 20, 44, 74, 90, 135, 180, -60])
def test_on_open_ground_it_takes_the_papers_steps_and_does_not_search(degrees):
    terrain, settings, order = holes(), gait(), command(degrees)
    stance = start(degrees, settings, terrain)
    for _ in range(12):
        thinking = step_job(StepRequest(stance, order, terrain, TITAN, settings))
        with pytest.raises(StopIteration) as done:
            next(thinking)
        plan = done.value.value
        paper = plan_step(StepRequest(stance, order, terrain, TITAN, settings))
        assert plan.end == paper.end
        assert np.array_equal(plan.times, paper.times) and np.array_equal(plan.feet, paper.feet)
        stance = plan.end


@pytest.mark.parametrize("seed", range(12))
def test_from_any_posture_it_comes_to_the_standard_walk_within_sixteen_steps(seed):
    rng = np.random.default_rng(seed)
    settings, order = gait(rng.uniform(0.75, 0.9)), command(rng.uniform(-180, 180))
    plans = walk(order, 20, holes(span=12.0), random_stance(rng), settings)
    assert all(isinstance(plan, StepPlan) for plan in plans)
    assert all(plan.margin_min >= plan.standard_margin - LOWER for plan in plans[16:])
    assert off_standard(TITAN, settings, plans[-1].crab_angle, plans[-1].end) <= AGREEMENT
    still = [plan.shift < 0.001 for plan in plans]
    assert not any(all(still[k : k + 5]) for k in range(len(still) - 4))


def test_legs_that_step_on_the_spot_in_turn_give_way_to_a_shift_of_the_body():
    """Legs 3 and 4 bind the body, which stands over the other two; each step on the spot promises a
    better next one.
    """
    feet = (
        (0.3597, 0.3961, 0.0),
        (-0.4831, 0.4484, 0.0),
        (-0.6305, -0.3041, 0.0),
        (0.6321, -0.3430, 0.0),
    )
    stance = Stance((0.0, 0.0, TITAN.height, 0.0), feet)
    plans = walk(command(-57.644), 24, holes(span=12.0), stance, gait(0.88817))
    assert all(isinstance(plan, StepPlan) for plan in plans)
    still = [plan.shift < 0.001 for plan in plans]
    assert any(still) and not any(all(still[k : k + 5]) for k in range(len(still) - 4))
    assert all(plan.margin_min >= plan.standard_margin - LOWER for plan in plans[16:])


@pytest.mark.parametrize(
    ("degrees", "fraction", "share"),
    [(0, 0.3, 0.92), (90, 0.5, 0.8), (20, 0.8, 0.6), (45, 0.8, 0.35)],
)
def test_on_broken_ground_it_loses_little_of_its_way(degrees, fraction, share):
    settings = gait()
    flat = walk(command(degrees), 8, holes())
    plans = walk(command(degrees), 30, holes(fraction, seed=5), None, settings)
    assert all(isinstance(plan, StepPlan) for plan in plans)
    way = sum(plan.shift for plan in plans) / 30
    assert way >= share * sum(plan.shift for plan in flat) / 8


def test_it_walks_on_rolling_ground_as_on_any_other():
    plans = walk(command(30), 24, relief(0.3, seed=2))
    assert all(isinstance(plan, StepPlan) for plan in plans)
    assert sum(plan.shift for plan in plans) / 24 >= 0.12


def river(width, at=0.9):
    """Level ground with a bottomless strip across the way."""
    terrain = holes(span=12.0)
    x = terrain.origin[0] + (np.arange(terrain.columns) + 0.5) * terrain.cell
    wet = np.broadcast_to((x > at) & (x < at + width), terrain.heights.shape)
    return TerrainMap(np.where(wet, np.nan, 0.0), wet.copy(), terrain.cell, terrain.origin)


def test_a_river_as_wide_as_the_stride_less_one_cell_is_crossed():
    """Both front feet stand half a cell from the bank: a stride of 0.5 m reaches over 0.45 m."""
    plans = walk(command(0), 40, river(0.45, at=1.0))
    assert all(isinstance(plan, StepPlan) for plan in plans)
    assert plans[-1].end.body[0] > 2.2


def test_a_river_wider_than_any_leg_reaches_is_not_and_it_says_why():
    plans = walk(command(0), 60, river(1.2))
    answer = plans[-1]
    assert isinstance(answer, Blocked)
    assert "no way on" in answer.text and "leg" in answer.text
    assert answer.decision is not None and answer.decision["refused"]
    assert len(plans) < 40


@pytest.mark.parametrize("seed", range(4))
def test_a_thought_that_is_wanted_now_ends_with_a_step_that_holds_good(seed):
    terrain, settings, order = holes(0.5, seed=seed), gait(), command(20)
    stance = start(20, settings, terrain)
    for _ in range(6):
        thinking = step_job(StepRequest(stance, order, terrain, TITAN, settings))
        for pieces in range(40):
            try:
                thinking.send(True if pieces > 2 else None)
            except StopIteration as done:
                plan = done.value
                break
        else:
            pytest.fail("it goes on thinking")
        assert isinstance(plan, StepPlan)
        look_at_any(plan, stance, terrain, settings)
        stance = plan.end


def test_thinking_twice_comes_to_the_same_step():
    terrain, settings, order = holes(0.8, seed=7), gait(), command(45)
    stance = start(45, settings, terrain)
    request = StepRequest(stance, order, terrain, TITAN, settings)
    first, again = (plan_at_once(request) for _ in range(2))
    assert first.end == again.end and np.array_equal(first.times, again.times)


def test_asked_why_it_names_every_candidate_with_its_score():
    terrain, settings, order = holes(0.5, seed=3), gait(), command(0)
    stance = start(0, settings, terrain)
    plan = plan_at_once(StepRequest(stance, order, terrain, TITAN, settings, explain=True))
    lookahead = plan.decision["lookahead"]
    assert lookahead["search"] in ("near", "wide")
    best = lookahead["candidates"][0]
    assert (
        best["landing"] == pytest.approx(list(plan.landing[:2]))
        and best["leg"] == plan.swing[0] + 1
    )
    ranks = [(candidate["steps"], candidate["score"]) for candidate in lookahead["candidates"]]
    assert len(ranks) > 4 and ranks == sorted(ranks, reverse=True)
    assert plan.decision["legs"]


def test_on_open_level_ground_every_step_is_the_papers_and_says_nothing():
    plans = walk(command(0.0), 8, holes(0.0, 1))
    assert [plan.departure for plan in plans] == [None] * 8


def test_a_step_that_is_not_the_papers_says_why():
    ground = holes(0.5, 3)
    stance = start(0.0, gait(), ground)
    told = set()
    for _ in range(12):
        request = StepRequest(stance, command(0.0), ground, TITAN, gait())
        plan = plan_at_once(request)
        paper = plan_step(request)
        same = isinstance(paper, StepPlan) and (paper.swing, paper.landing, paper.shift) == (
            plan.swing,
            plan.landing,
            plan.shift,
        )
        if plan.departure is None:
            assert same
        elif isinstance(paper, Blocked):
            assert plan.departure is Departure.NO_STEP or plan.departure in WAYS_OUT.values()
        told.add(plan.departure)
        stance = plan.end
    assert Departure.BROKEN_GROUND in told


def test_every_search_and_every_way_out_has_its_word():
    told = {*DEPARTURES.values(), *WAYS_OUT.values(), Departure.NO_STEP}
    assert told == set(Departure) - {Departure.TRACE_BENT}  # which is the trace planner's
