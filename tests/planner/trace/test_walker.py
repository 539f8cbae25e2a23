"""Kugushev and Jaroshevskij's planner as the other rooms see it."""

import numpy as np
import pytest

from walking_console.planner.initial_stance import Placement, square_stance
from walking_console.planner.protocols import PlannerError, PlannerSetup
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.trace.paths import trace_for
from walking_console.planner.trace.walker import TracePlanner
from walking_console.planner.types import Command, StepPlan

HEXAPOD = load_machine("hexapod")
GROUND = TerrainMap.from_heights(np.zeros((200, 200)), 0.05, HEXAPOD, (-5.0, -5.0))
START = square_stance(HEXAPOD, HEXAPOD.gait, Placement((0.0, 0.0, 0.0), GROUND.height_at))
ON = Command(speed=0.1)


def planner(**more) -> TracePlanner:
    return TracePlanner(PlannerSetup(HEXAPOD, HEXAPOD.gait, **more))


def test_the_first_step_leads_on():
    plan = planner().plan_step(START, ON, GROUND)
    assert isinstance(plan, StepPlan) and plan.end.course > START.course


def test_what_is_foreseen_is_one_object_until_something_else_is():
    walker = planner()
    assert walker.preview(START, None) is walker.preview(START, None)
    plan = walker.plan_step(START, ON, GROUND)
    foreseen = walker.preview(START, plan)
    assert foreseen is not None and foreseen is walker.preview(START, plan)
    assert foreseen.reached > 0.5


def test_progress_goes_along_the_given_trace():
    line = trace_for({"kind": "line", "length": 3.0}, HEXAPOD)
    walker = planner(path=line)
    plan = walker.plan_step(START, ON, GROUND)
    assert isinstance(plan, StepPlan)
    assert walker.progress(START, plan, START.body) == pytest.approx(START.course)
    assert walker.progress(START, plan, plan.end.body) == pytest.approx(plan.end.course)


def test_only_the_gaits_it_declares_can_be_held_to():
    for name in planner().capabilities.rigid_gaits:
        assert isinstance(planner(rigid_gait=name).plan_step(START, ON, GROUND), StepPlan)
    with pytest.raises(PlannerError, match="tripod"):
        planner(rigid_gait="moonwalk")


def test_it_keeps_the_body_level():
    assert planner().attitude == "level"
    with pytest.raises(PlannerError, match="level"):
        planner(attitude="ground")
