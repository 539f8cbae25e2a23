"""Planners as plain calls: from measured heights to a step, and why not."""

import numpy as np
import pytest

from walking_console import Blocked, Command, StepPlan, StepPlanner, TerrainMap, load_machine

TITAN, HEXAPOD = load_machine("titan3"), load_machine("hexapod")
AHEAD = Command(speed=0.1)


def ground(machine, hole=None) -> TerrainMap:
    heights = np.zeros((160, 160))
    if hole is not None:
        heights[hole] = np.nan
    return TerrainMap.from_heights(heights, 0.05, machine, origin=(-4.0, -4.0))


@pytest.mark.parametrize(
    ("machine", "planner", "mode"),
    [(TITAN, "crab", ""), (TITAN, "crab", "paper"), (HEXAPOD, "trace", "")],
)
def test_step_after_step_the_body_gets_on(machine, planner, mode) -> None:
    terrain, steps = ground(machine), StepPlanner(machine, planner, mode)
    stance = steps.stance_on(terrain)
    for _ in range(6):
        plan = steps.plan(stance, AHEAD, terrain)
        assert isinstance(plan, StepPlan)
        stance = plan.end
    assert stance.body[0] > 0.2 and abs(stance.body[1]) < 0.05


def test_the_stance_is_where_and_how_it_was_asked_for() -> None:
    stance = StepPlanner(TITAN).stance_on(ground(TITAN), 0.5, -0.25, 1.0)
    assert stance.body[:2] == (0.5, -0.25) and stance.body[3] == 1.0
    assert stance.body[2] == pytest.approx(TITAN.height)
    assert len(stance.feet) == 4


def test_a_stance_over_a_hole_names_the_foot() -> None:
    terrain = ground(TITAN, hole=np.s_[80:, 80:])
    with pytest.raises(ValueError, match="foot 1 would stand on forbidden ground"):
        StepPlanner(TITAN).stance_on(terrain)


def test_no_step_is_an_answer_and_not_an_error() -> None:
    terrain = ground(TITAN)
    nowhere = TerrainMap.from_heights(
        terrain.heights, terrain.cell, TITAN, terrain.origin, np.ones_like(terrain.forbidden)
    )
    steps = StepPlanner(TITAN)
    stance = steps.stance_on(terrain)
    for _ in range(5):  # the body goes as far as its feet reach
        answer = steps.plan(stance, AHEAD, nowhere)
        if isinstance(answer, Blocked):
            break
        stance = answer.end
    assert isinstance(answer, Blocked) and answer.text


def test_what_was_explained_is_in_the_plan() -> None:
    terrain, steps = ground(TITAN), StepPlanner(TITAN, explain=True)
    plan = steps.plan(steps.stance_on(terrain), AHEAD, terrain)
    assert isinstance(plan, StepPlan) and plan.decision
    assert steps.capabilities.gives_decision


def test_a_planner_there_is_not_is_a_value_error_that_lists_those_there_are() -> None:
    with pytest.raises(ValueError, match="unknown planner 'trot'; there are: crab, trace"):
        StepPlanner(TITAN, "trot")
