"""Steps on slopes, with a level body and with one that leans with the ground."""

import math
from dataclasses import replace

import numpy as np
import pytest

from walking_console.planner import registry
from walking_console.planner.crab.gait import standard_stance
from walking_console.planner.crab.slope_adaptation import SlopeAdaptation, walker_on_slopes
from walking_console.planner.initial_stance import Placement
from walking_console.planner.motion.body_tilt import LEAN_STEP, LEVEL
from walking_console.planner.motion.slope_strides import LEAN_GRAIN, fitted_at_start
from walking_console.planner.protocols import Planner, PlannerError, PlannerSetup, run_to_completion
from walking_console.planner.robot.model import Machine, load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import Command, Gait, Stance, StepPlan

TITAN = load_machine("titan3")
GAIT = Gait(TITAN.duty_factor, TITAN.lift_up, TITAN.lift_down, TITAN.height)


def planner(mode: str, attitude: str = "level") -> Planner:
    return registry.make_planner("crab", PlannerSetup(TITAN, GAIT, mode, attitude))


CELL = 0.05


def inclined(degrees: float, heading: float = 0.0, span: float = 12.0) -> TerrainMap:
    n, steep = round(span / CELL), math.tan(math.radians(degrees))
    at = (np.arange(n) + 0.5) * CELL - span / 2
    gx, gy = steep * math.cos(math.radians(heading)), steep * math.sin(math.radians(heading))
    return TerrainMap(
        gx * at[None, :] + gy * at[:, None],
        np.zeros((n, n), dtype=bool),
        CELL,
        (-span / 2, -span / 2),
    )


def start(terrain: TerrainMap, course: float = 0.0, machine: Machine = TITAN) -> Stance:
    return standard_stance(
        machine, GAIT, Placement((0.0, 0.0, 0.0), terrain.height_at, math.radians(course))
    )


def test_the_start_posture_of_the_printed_modes_stays_as_it_was() -> None:
    terrain, pose = inclined(25), (0.0, 0.0, 0.0)
    place = Placement(pose, terrain.height_at)
    printed = registry.initial_stance("crab", "paper", TITAN, GAIT, place)
    fits = registry.initial_stance("crab", "predictive", TITAN, GAIT, place)
    assert printed == start(terrain)
    assert max(f[0] for f in fits.feet) < max(f[0] for f in printed.feet)
    level = fitted_at_start(walker_on_slopes(TITAN, GAIT), 0.0, pose, lambda x, y: 0.0)
    assert level is TITAN


def test_a_slope_that_hardly_changes_keeps_the_strides() -> None:
    walks = SlopeAdaptation(TITAN, GAIT, lambda machine: planner("paper").plan)
    stance, command = start(inclined(24.9, 45)), Command(0.0, 0.08)
    machines = {
        id(walks.frame(stance, command, inclined(degrees, 45)).machine)
        for degrees in (24.9, 25.0, 25.1, 24.8, 25.0)
    }
    assert len(machines) == 1


def test_a_leaning_body_leans_slowly_and_comes_back_to_level() -> None:
    walks, command = planner("predictive", "ground"), Command(0.0, 0.08)
    hill, flat = inclined(10), inclined(0)
    stance, leans = start(hill), [LEVEL]
    for step in range(20):
        if step == 8:
            # the same posture, set down on level ground
            lifted = tuple((x, y, 0.0) for x, y, _ in stance.feet)
            stance = replace(stance, body=(*stance.body[:2], GAIT.height, 0.0), feet=lifted)
        plan = run_to_completion(walks.plan(stance, command, hill if step < 8 else flat))
        assert (
            isinstance(plan, StepPlan) and math.dist(plan.end.lean, leans[-1]) <= LEAN_STEP + 1e-12
        )
        stance = plan.end
        leans.append(stance.lean)
    assert (
        leans[8][0] == pytest.approx(0.5 * math.tan(math.radians(10)), abs=LEAN_GRAIN)
        and abs(leans[8][1]) < 1e-9
    )
    assert leans[-1] == LEVEL


def test_a_level_attitude_never_leans_and_hands_the_step_on_untouched() -> None:
    terrain, command = inclined(10), Command(0.0, 0.08)
    level = planner("predictive")
    plan = run_to_completion(level.plan(start(terrain), command, terrain))
    assert isinstance(plan, StepPlan) and plan.lean is None and plan.end.lean == LEVEL


def test_the_attitude_may_change_its_mind_and_other_planners_refuse() -> None:
    walks = planner("predictive")
    walks.take_attitude("ground")
    assert walks.attitude == "ground"
    printed = planner("paper")
    printed.take_attitude("level")
    with pytest.raises(PlannerError, match="predictive"):
        printed.take_attitude("ground")
    with pytest.raises(PlannerError, match="there are: level, ground"):
        walks.take_attitude("askew")
    assert printed.attitude == "level"
