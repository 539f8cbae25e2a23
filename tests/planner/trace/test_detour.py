"""The trace bent round what lies across it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from walking_console.planner.config import PlannerConfig, TraceSearch
from walking_console.planner.initial_stance import Placement, square_stance
from walking_console.planner.protocols import PlannerSetup, run_to_completion
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.trace.detour import (
    AHEAD,
    PLACE,
    SLOPE,
    TURN,
    BentTrace,
    DeadEnd,
    GroundBeside,
    bent,
)
from walking_console.planner.trace.paths import trace_for
from walking_console.planner.trace.walker import TracePlanner
from walking_console.planner.types import Blocked, Command, Departure, Stance, StepPlan

HEXAPOD = load_machine("hexapod")
CELL, LOW = 0.05, -5.0
LINE = trace_for({"kind": "line", "length": 10.0}, HEXAPOD)
WIDTH = 2.0
ON = Command(speed=0.1)
FAR = 7.5  # m; behind what lies across the trace


def ground_with(x1: float, x2: float, y1: float, y2: float, height: float) -> TerrainMap:
    """Level ground with a rectangle of this height: nan is water."""
    heights = np.zeros((200, 320))
    columns = slice(round((x1 - LOW) / CELL), round((x2 - LOW) / CELL))
    rows = slice(round((y1 - LOW) / CELL), round((y2 - LOW) / CELL))
    heights[rows, columns] = height
    return TerrainMap.from_heights(heights, CELL, HEXAPOD, (LOW, LOW))


BLOCK = ground_with(3.0, 3.5, -0.2, 0.6, 1.0)
POND = ground_with(2.0, 3.2, -0.8, 0.8, math.nan)
OPEN = ground_with(0.0, 0.1, 0.0, 0.1, 0.0)
START = square_stance(HEXAPOD, HEXAPOD.gait, Placement((0.0, 0.0, 0.0), OPEN.height_at))


def beside(terrain: TerrainMap, now: int = 0, width: float = WIDTH) -> GroundBeside:
    found = GroundBeside(LINE, now, width, terrain, HEXAPOD, HEXAPOD.gait)
    run_to_completion(found.looking())
    return found


def bend_round(terrain: TerrainMap) -> BentTrace:
    bend = bent(None, beside(terrain))
    assert bend is not None
    return bend


def planner(width: float | None, given: bool = True) -> TracePlanner:
    config = PlannerConfig(trace=TraceSearch(detour=width))
    path = LINE if given else None
    return TracePlanner(PlannerSetup(HEXAPOD, HEXAPOD.gait, path=path, config=config, explain=True))


def walked(walker: TracePlanner, terrain: TerrainMap, steps: int) -> list[StepPlan | Blocked]:
    """So many steps on paper; the last may be a refusal."""
    stance: Stance = START
    plans: list[StepPlan | Blocked] = []
    while len(plans) < steps and stance.course < FAR:
        answer = walker.plan_step(stance, ON, terrain)
        plans.append(answer)
        if isinstance(answer, Blocked):
            break
        stance = answer.end
    return plans


def test_where_no_bend_is_better_than_the_trace_it_stays_as_it_is():
    river = ground_with(3.0, 3.8, -5.0, 5.0, math.nan)
    assert bent(None, beside(OPEN)) is None
    assert bent(None, beside(river)) is None


@pytest.mark.parametrize("terrain", [BLOCK, POND])
def test_it_bends_to_the_nearer_side_and_comes_back_smoothly(terrain: TerrainMap):
    bend = bend_round(terrain)
    assert bend.aside < -0.3 if terrain is BLOCK else abs(bend.aside) > 0.5
    assert bend.offsets[0] == 0.0 and abs(bend.offsets[-1]) < 1e-9
    layer = beside(OPEN).step * LINE.step
    slope = np.diff(bend.offsets) / LINE.step
    assert np.abs(slope).max() <= 1.1 * SLOPE * PLACE / layer
    curvature = np.diff(slope) / LINE.step
    assert np.abs(curvature).max() <= 1.3 * TURN * PLACE / layer**2
    assert (bend.path.yaw == LINE.yaw).all() and bend.path.last == LINE.last


def test_the_torso_passes_beside_the_block():
    bend = bend_round(BLOCK)
    half_length, half_width = HEXAPOD.torso[0] / 2, HEXAPOD.torso[1] / 2
    near = (bend.path.x + half_length > 3.0) & (bend.path.x - half_length < 3.5)
    assert (bend.path.y[near] + half_width < -0.2).all()


def test_places_where_a_search_ended_are_kept_out_of():
    ground = beside(BLOCK)
    first = bent(None, ground)
    assert first is not None
    ground.shun(DeadEnd(3.0, first.offset_at(3.0)))
    second = bent(None, ground)
    assert second is not None
    assert abs(second.offset_at(3.0) - first.offset_at(3.0)) > 0.2


def test_no_way_leads_through_what_is_wider_than_the_bend_may_be():
    assert bent(None, beside(ground_with(3.0, 3.5, -4.0, 4.0, 1.0))) is None
    assert bent(None, beside(BLOCK, width=0.2)) is None


def test_a_bend_goes_on_from_how_the_trace_was_bent_before():
    before = bend_round(BLOCK)
    now = 60
    after = bent(before, beside(ground_with(3.0, 3.5, -0.8, 0.6, 1.0), now))
    assert after is not None
    assert (after.offsets[: now + 1] == before.offsets[: now + 1]).all()
    assert abs(after.offsets[now + 1] - after.offsets[now]) < 0.02


def test_it_looks_only_where_something_is_as_tall_as_the_torso_for_what_bars_it():
    assert beside(BLOCK).may_bar_the_torso(START)
    assert not beside(POND).may_bar_the_torso(START)
    assert beside(BLOCK).bars_the_torso(None, AHEAD)
    assert not beside(BLOCK).bars_the_torso(None, 1.0)
    assert not beside(BLOCK).bars_the_torso(bend_round(BLOCK), 4.0)


@pytest.mark.parametrize("terrain", [BLOCK, POND])
def test_the_walk_goes_round_and_back_and_says_so(terrain: TerrainMap):
    plans = walked(planner(None), terrain, 200)
    assert all(isinstance(plan, StepPlan) for plan in plans)
    off = [abs(plan.end.body[1]) for plan in plans]
    assert max(off) > 0.3 and off[-1] < 0.05
    farthest = plans[off.index(max(off))]
    assert farthest.departure is Departure.TRACE_BENT
    assert farthest.decision["detour"]["aside_m"] == pytest.approx(farthest.end.body[1], abs=0.2)
    assert plans[-1].departure is None


def test_with_a_detour_of_0_it_keeps_the_exact_trace_and_stops():
    *plans, last = walked(planner(0.0), BLOCK, 200)
    assert isinstance(last, Blocked) and "round it" not in last.text
    assert all(plan.departure is None for plan in plans)


def test_a_reason_says_how_far_beside_a_way_round_was_looked_for():
    *_, last = walked(planner(1.0), ground_with(3.0, 3.5, -4.0, 4.0, 1.0), 200)
    assert isinstance(last, Blocked) and "nor round it within 1 m to either side" in last.text


def test_what_is_foreseen_is_the_trace_as_it_is_bent():
    walker = planner(None)
    plan = walker.plan_step(START, ON, BLOCK)
    assert isinstance(plan, StepPlan)
    while walker.walk.bend is None:
        plan = walker.plan_step(plan.end, ON, BLOCK)
    foreseen = walker.preview(plan.end, None)
    assert foreseen is not None and min(y for _, _, y in foreseen.line) < -0.3


def test_the_joysticks_own_trace_bends_too():
    plans = walked(planner(None, given=False), BLOCK, 200)
    assert all(isinstance(plan, StepPlan) for plan in plans)
    assert plans[-1].end.course >= FAR
