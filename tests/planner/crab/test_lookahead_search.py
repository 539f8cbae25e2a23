"""Which search answers, and what counts as the standard walk."""

import math

import numpy as np
import pytest

from tests.planner.crab.crab_walks import TITAN, command, gait, holes, random_stance
from walking_console.planner.config import DEFAULT, configured
from walking_console.planner.crab.candidates import SearchContext
from walking_console.planner.crab.gait import standard_stance
from walking_console.planner.crab.lookahead_search import (
    LOOK,
    choose,
    gain_with,
    is_open,
    is_standard_step,
    look_near,
    look_wide,
    standard_way,
    stays_standard,
)
from walking_console.planner.crab.steps import BodyShift, StepRequest
from walking_console.planner.initial_stance import Placement
from walking_console.planner.protocols import PlannerSetup, run_to_completion
from walking_console.planner.registry import make_planner
from walking_console.planner.terrain.map import TerrainMap

OPEN = holes(span=12.0)


def standing(degrees=0.0):
    return standard_stance(
        TITAN, gait(), Placement((0.0, 0.0, 0.0), OPEN.height_at, math.radians(degrees))
    )


def context(stance, degrees=0.0, terrain=OPEN):
    request = StepRequest(stance, command(degrees), terrain, TITAN, gait())
    return SearchContext(request, math.radians(degrees))


def papers(found):
    return found.paper_step(found.start)


@pytest.mark.parametrize("degrees", [0, 30, 90, -135])
def test_in_the_standard_walk_on_open_ground_the_papers_step_is_taken_without_a_search(degrees):
    found = context(standing(degrees), degrees)
    paper = papers(found)
    assert is_standard_step(found.start.posture, paper)
    result = run_to_completion(choose(found, paper))
    assert (result.search, result.horizon) == ("paper", 1)
    assert [way.first for way in result.ways] == [paper]


def test_from_an_odd_posture_on_open_ground_it_searches_for_the_way_back():
    searches = set()
    rng = np.random.default_rng(4)
    for _ in range(6):
        found = context(random_stance(rng))
        result = run_to_completion(choose(found, papers(found)))
        searches.add(result.search)
        if result.search == "back":
            assert result.horizon == DEFAULT.lookahead.back_steps + 1
            assert result.pace == result.ways[0].gain / result.horizon
    assert "back" in searches


def test_on_broken_ground_the_ways_are_best_first_and_their_first_steps_differ():
    found = context(standing(), 0.0, holes(0.5, 2, span=12.0))
    near = run_to_completion(look_near(found))
    wide = run_to_completion(look_wide(found))
    for ways, most in ((near.ways, DEFAULT.lookahead.depth), (wide.ways, LOOK + 2)):
        assert ways and len({id(way.first) for way in ways}) == len(ways)
        assert all(way.steps <= most for way in ways)
    assert near.finished and wide.finished


def test_a_search_that_is_wanted_now_says_that_it_is_not_finished():
    job = look_near(context(standing(), 0.0, holes(0.5, 2, span=12.0)))
    next(job)
    with pytest.raises(StopIteration) as done:
        for _ in range(20):  # its first depth it always looks at
            job.send(True)
    assert done.value.value.ways and not done.value.value.finished


def test_open_means_no_prohibited_cell_within_the_horizon_and_no_edge_of_the_map():
    assert is_open(context(standing()))
    assert not is_open(context(standing(), 0.0, holes(span=2.0)))
    forbidden = OPEN.forbidden.copy()
    row, column = OPEN.cell_at(1.2, 0.5)
    forbidden[row, column] = True
    one = TerrainMap(OPEN.heights, forbidden, OPEN.cell, OPEN.origin)
    assert not is_open(context(standing(), 0.0, one))
    assert is_open(context(standing(180), 180, one)), "behind it, it is not in the way"


def test_the_standard_walk_is_stayed_in_past_cells_nobody_treads_on():
    found = context(standing())
    paper = papers(found)
    assert stays_standard(found, paper)
    ax, ay = paper.landing.ax, paper.landing.ay
    forbidden = OPEN.forbidden.copy()
    forbidden[OPEN.cell_at(ax, ay)] = True
    blocked = context(standing(), 0.0, TerrainMap(OPEN.heights, forbidden, OPEN.cell, OPEN.origin))
    assert not stays_standard(blocked, papers(blocked))


def test_a_step_gains_its_way_less_what_its_margin_lacks():
    found = context(standing(30), 30)
    s0 = found.nominal.margin
    gain = gain_with(found, 0.5)
    ux, uy, _ = found.nominal.path
    along = BodyShift(0.1 * ux, 0.1 * uy, s0)
    assert gain(along) == pytest.approx(0.1)
    assert gain(along._replace(margin=s0 - 0.02)) == pytest.approx(0.09)
    assert gain(BodyShift(-0.1 * uy, 0.1 * ux, s0)) == pytest.approx(0.0, abs=1e-12)


def test_the_standard_way_is_the_advance_of_a_cycle_over_four_steps():
    nominal = context(standing()).nominal
    assert standard_way(nominal) == pytest.approx(sum(nominal.lags) / 4)


@pytest.mark.parametrize("depth", [1, 2, 4])
def test_how_far_it_looks_can_be_set(depth):
    terrain = holes(0.5, 2, span=12.0)
    config = configured({"lookahead": {"depth": depth, "width": 2, "per_shift": 2}})
    planner = make_planner(
        "crab", PlannerSetup(TITAN, gait(), "predictive", explain=True, config=config)
    )
    plan = planner.plan_step(standing(), command(), terrain)
    looked = plan.decision["lookahead"]
    assert looked["search"] == "near" and looked["horizon"] == depth
    assert 0 < len(looked["candidates"]) <= 3 * 2 * 2
    assert all(way["steps"] <= depth for way in looked["candidates"])


def test_a_look_of_no_steps_is_one_of_one():
    config = configured({"lookahead": {"depth": 0}})
    request = StepRequest(standing(), command(), OPEN, TITAN, gait(), config=config)
    assert SearchContext(request, 0.0).depth == 1
