"""What a lookahead may choose from: near steps, wide steps, and shifts of the body on four legs."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.planner.crab.crab_walks import TITAN, command, gait, holes, random_stance, relief
from walking_console.planner.crab.candidates import (
    INSET,
    LEAST,
    ON_THE_SPOT,
    STILL_MAX,
    Node,
    SearchContext,
    body_shifts,
    near_steps,
    shift_room,
    value_after,
    wide_steps,
    within_margin,
)
from walking_console.planner.crab.gait import standard_stance
from walking_console.planner.crab.leg_selection import triangle_of
from walking_console.planner.crab.step_refusals import StepRefusal
from walking_console.planner.crab.steps import BodyShift, Landing, Shift, StepRequest, SwingStep
from walking_console.planner.initial_stance import Placement
from walking_console.planner.stability import polygon_margin


def context(stance, degrees=0.0, terrain=None):
    request = StepRequest(stance, command(degrees), terrain or holes(span=8.0), TITAN, gait())
    return SearchContext(request, math.radians(degrees))


def random_contexts(count, fraction=0.3):
    rng = np.random.default_rng(8)
    for seed in range(count):
        yield context(random_stance(rng), rng.uniform(-180, 180), holes(fraction, seed, span=8.0))


def bounds(corners):
    xs, ys = zip(*corners, strict=True)
    return min(xs), max(xs), min(ys), max(ys)


def test_the_first_near_step_of_the_standard_margin_is_the_papers():
    for found in random_contexts(30):
        paper = found.paper_step(found.start)
        near = next(near_steps(found, found.start, (found.nominal.margin,), 1), None)
        if paper is not None and near is not None and paper.margin >= LEAST:
            assert (near.leg, near.g0) == (paper.leg, paper.g0)
            assert near.landing == paper.landing or near.g != paper.g


def test_every_candidate_keeps_the_least_margin_and_lands_on_a_free_cell():
    count = 0
    for found in random_contexts(12):
        for step in (
            *near_steps(found, found.start, (0.03, 0.003), 4),
            *wide_steps(found, found.start),
        ):
            count += 1
            assert step.margin >= found.least - 1e-6 or step.g0 > 0.0
            assert found.cells.allows(step.landing.ax, step.landing.ay)
            x1, x2, y1, y2 = found.nominal.boxes[step.leg]
            dx, dy, _ = found.nominal.path.pose(step.g)
            assert x1 - 1e-6 <= step.landing.x - dx <= x2 + 1e-6
            assert y1 - 1e-6 <= step.landing.y - dy <= y2 + 1e-6
    assert count > 200


def test_a_shift_of_the_body_ends_inside_the_triangle_of_three_legs_with_all_feet_in_reach():
    count = 0
    for found in random_contexts(40):
        posture = found.start.posture
        x1, x2, y1, y2 = bounds(shift_room(posture))
        for shift in body_shifts(posture):
            count += 1
            assert x1 - 1e-9 <= shift.x <= x2 + 1e-9 and y1 - 1e-9 <= shift.y <= y2 + 1e-9
            inside = [
                polygon_margin(triangle_of(posture, leg), shift.x, shift.y) for leg in range(4)
            ]
            assert max(inside) >= INSET - 1e-9
    assert count > 20


def test_a_shift_is_ended_early_for_the_least_margin_or_refused():
    shift = Shift(0, 0.02, 0.10, 0.0, 0.105)
    assert within_margin(0.01, shift).g == pytest.approx(0.095)
    assert within_margin(0.001, shift) is shift
    assert within_margin(0.03, shift) is None, "it begins 0.02 inside"
    assert within_margin(0.01, StepRefusal.MISSES) is None


def test_a_posture_is_worth_the_way_its_footholds_leave_no_more_than_a_stroke_each():
    stance = standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), lambda x, y: 0.0))
    found = context(stance)
    stay = BodyShift(0.0, 0.0, 0.0)
    worth = value_after(found.start.posture, stay)
    assert 0.0 < worth < found.nominal.stride
    feet = tuple((x + 9.0, y) for x, y in found.start.posture.feet)
    ahead = replace(found.start.posture, feet=feet)
    assert value_after(ahead, stay) == pytest.approx(found.nominal.stride)


def test_what_a_step_leads_to_is_weighed_as_the_posture_it_leads_to():
    stance = standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), lambda x, y: 0.0))
    found = context(stance, 0.2)
    steps = list(near_steps(found, found.start, (0.03, 0.0), 8))
    assert len(steps) > 20
    for step in steps:
        reached = Node(found, found.start, step).posture
        ways = [min(way, found.nominal.stride) for way in reached.exits]
        assert value_after(found.start.posture, step) == sum(ways) / 4


def test_after_enough_steps_on_the_spot_only_one_that_gets_on_is_permitted():
    stance = standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), lambda x, y: 0.0))
    waits = SwingStep(0, 0.0, ON_THE_SPOT / 2, (0.0, 0.0), Landing(0, 0, 0, 0), 0.01, True)
    walks = waits._replace(g=2 * ON_THE_SPOT)
    fresh, stuck = context(stance), context(replace(stance, still=STILL_MAX))
    assert fresh.permits(fresh.start, waits)
    assert not stuck.permits(stuck.start, waits) and stuck.permits(stuck.start, walks)
    reached = Node(stuck, stuck.start, walks)
    assert stuck.permits(reached, waits), "asked of first steps only"


def test_on_uneven_ground_nodes_carry_the_heights_of_their_feet():
    terrain = relief(0.2, 3, span=8.0)
    stance = standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), terrain.height_at))
    found = context(stance, 0.0, terrain)
    step = next(near_steps(found, found.start, (0.03,), 1))
    reached = Node(found, found.start, step)
    leg = found.nominal.body_leg[step.leg]
    there = reached.checks.stance
    assert there.feet[leg][2] == terrain.height_at(step.landing.ax, step.landing.ay)
    assert there.last_swing == leg and there.body[:2] == (reached.posture.x, reached.posture.y)
    flat = context(standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), lambda x, y: 0.0)))
    assert flat.accepts(flat.start) is None, "on level ground nobody minds heights"
