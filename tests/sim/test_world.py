"""A scenario made ready to walk in."""

import numpy as np
import pytest

from walking_console.planner.robot.model import load_machine
from walking_console.sim.scenario import ScenarioError
from walking_console.sim.scenario_files import load_scenario, scenario_from
from walking_console.sim.terrain.ground import Ground
from walking_console.sim.world import first_crab_angle, prepare


def test_what_is_known_at_first_is_the_ground_itself() -> None:
    world = prepare(load_scenario("rough"))
    assert np.array_equal(world.belief.heights, world.ground.heights)
    assert np.array_equal(world.belief.forbidden, world.forbidden)
    assert not world.belief.heights.flags.writeable


def test_where_only_holes_are_forbidden_they_are_and_nothing_else() -> None:
    world = prepare(load_scenario("holes"))
    assert np.array_equal(world.forbidden, np.isnan(world.ground.heights))


def test_the_feet_stand_on_the_ground_at_the_start() -> None:
    world = prepare(load_scenario("rough"))
    for x, y, z in world.stance.feet:
        assert z == pytest.approx(world.ground.height_at(x, y))


def test_a_machine_and_a_ground_brought_along_replace_those_of_the_scenario() -> None:
    ground = Ground(np.full((200, 200), 0.25), 0.05, (-5.0, -5.0))
    hexapod = load_machine("hexapod")
    scenario = scenario_from({"planner": "trace"})
    world = prepare(scenario, hexapod, ground)
    assert world.machine is hexapod and world.ground is ground
    assert {foot[2] for foot in world.stance.feet} == {0.25}


def test_the_first_course_sets_the_crab_angle_of_the_start() -> None:
    assert first_crab_angle(scenario_from({})) == 0.0
    entry = {"crab_angle_deg": 90.0, "speed": 0.1}
    assert first_crab_angle(scenario_from({"drive": [entry]})) == pytest.approx(np.pi / 2)


def test_feet_that_no_leg_reaches_are_refused_by_their_key() -> None:
    scenario = scenario_from({"start": {"feet": [[9, 0], [0, 0], [0, 0], [0, 0]]}})
    with pytest.raises(ScenarioError, match=r"start\.feet"):
        prepare(scenario)


def test_a_trace_too_long_to_draw_is_refused_as_a_trace() -> None:
    trace = {"kind": "circle", "radius": 100, "angle_deg": 3600}
    scenario = scenario_from({"planner": "trace", "robot": "hexapod", "trace": trace})
    with pytest.raises(ScenarioError, match="trace: a trace may be 2000 m long"):
        prepare(scenario)
