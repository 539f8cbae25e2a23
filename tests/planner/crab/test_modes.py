"""Hirose's planner in its three modes."""

from dataclasses import replace

import pytest

from tests.planner.crab.crab_walks import TITAN, command, gait, holes
from walking_console.planner.crab.gait import standard_stance
from walking_console.planner.crab.modes import MODES, CrabPlanner
from walking_console.planner.initial_stance import Placement
from walking_console.planner.navigation.local_planner import RouteState
from walking_console.planner.protocols import PlannerError, PlannerSetup, run_to_completion
from walking_console.planner.types import Blocked, Command, HeldCourse, StepPlan

FLAT = holes(span=12.0)
STANCE = standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), FLAT.height_at))


def crab(mode, **settings):
    return CrabPlanner(PlannerSetup(TITAN, gait(), mode, **settings), MODES[mode])


@pytest.mark.parametrize("mode", MODES)
def test_every_mode_takes_the_first_step_of_the_standard_walk_on_open_ground(mode):
    plan = run_to_completion(crab(mode).plan(STANCE, command(), FLAT))
    assert isinstance(plan, StepPlan) and plan.swing == (2,)


@pytest.mark.parametrize("mode", MODES)
def test_a_step_explains_itself_only_when_asked(mode):
    silent = run_to_completion(crab(mode).plan(STANCE, command(), FLAT))
    told = run_to_completion(crab(mode, explain=True).plan(STANCE, command(), FLAT))
    assert silent.decision is None and told.decision["crab_angle"] == 0.0


def test_without_detours_the_route_is_that_of_the_beginning():
    planner = crab("predictive")
    assert planner.route == RouteState()
    assert planner.heed(command(10, 0.1)) == command(10, 0.1)


@pytest.mark.parametrize("mode", ["paper", "naive"])
def test_only_the_predictive_mode_leans_with_the_ground(mode):
    leans = crab("predictive")
    leans.take_attitude("ground")
    assert leans.attitude == "ground" and leans.capabilities.may_lean
    with pytest.raises(PlannerError, match="predictive"):
        crab(mode).take_attitude("ground")


def test_how_far_off_the_standard_layout_a_step_came_out_is_a_share_of_the_stroke():
    planner = crab("paper")
    plan = run_to_completion(planner.plan(STANCE, command(), FLAT))
    assert planner.off_standard(plan) == pytest.approx(0.0, abs=1e-9)
    assert planner.capabilities.standard_within > 0.0


@pytest.mark.parametrize("mode", MODES)
def test_where_no_cell_may_be_trodden_on_no_leg_swings_and_soon_it_says_why(mode):
    nowhere = holes(1.0, span=12.0)
    planner = crab(mode)
    stance = STANCE
    for _ in range(8):
        answer = run_to_completion(planner.plan(stance, command(), nowhere))
        if isinstance(answer, Blocked):
            break
        assert answer.swing == ()
        stance = answer.end
    assert isinstance(answer, Blocked) and answer.reason


def test_a_course_that_turns_is_not_held():
    stance = replace(STANCE, held_course=HeldCourse(0.8, 0.8, 0.01))
    turning = Command(0.8, 0.08, turn_rate=0.1)
    plan = run_to_completion(crab("predictive").plan(stance, turning, FLAT))
    assert isinstance(plan, StepPlan) and plan.end.held_course is None
    straight = run_to_completion(crab("predictive").plan(stance, Command(0.8, 0.08), FLAT))
    assert straight.end.held_course.angle == 0.8
