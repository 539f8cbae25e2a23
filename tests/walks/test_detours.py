"""Walks that look: round what cannot be crossed, over ground that is known only as it is seen or
touched (H fig. 14, §9 of the spec).
"""

import json

import numpy as np
import pytest

from walking_console.planner.navigation.local_planner import RouteState
from walking_console.planner.types import Command, Mode
from walking_console.sim.requests import Edit
from walking_console.sim.runs.replay import replay
from walking_console.sim.runs.runner import run_scenario
from walking_console.sim.scenario import ScenarioError
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

from .telling import assert_always_true, walked

AHEAD = Command(0.0, 0.08)


def console_of(name, *settings):
    return Simulation(prepare(load_scenario(name, settings)))


def walk_on(console, ticks, command=AHEAD):
    console.order(command)
    for _ in range(ticks):
        console.step()
        assert console.mode not in (Mode.TIPPING, Mode.FALLEN), console.reason


def test_it_goes_round_both_holes_and_comes_back_to_the_line(shared):
    walk = shared.walked("fig14")
    assert_always_true(walk)
    x, y = walk.log["body"][:, 0], walk.log["body"][:, 1]
    assert np.abs(y[np.abs(x - 3.05) < 0.3]).min() > 1.0  # beside the first hole
    assert np.abs(y[np.abs(x - 9.5) < 0.3]).min() > 0.8  # beside the second
    assert np.abs(y[np.abs(x - 6.5) < 0.1]).max() < 0.3  # nearly back in between
    assert abs(y[-1]) < 0.1 and walk.summary["off_line"] < 0.1


@pytest.mark.parametrize(("body", "aside"), [("straight", 1e-6), ("sway", 0.05)])
def test_without_detours_it_stops_at_the_hole_and_says_why(body, aside):
    console = console_of("fig14", "detours=false", f'gait.body="{body}"')
    walk_on(console, 2400)
    assert console.mode is Mode.BLOCKED and "leg" in console.reason
    steps = console.walk.steps_begun
    walk_on(console, 1100)
    assert console.mode is Mode.BLOCKED and console.walk.steps_begun == steps
    assert console.plant.body[1] == pytest.approx(0.0, abs=aside)


def test_a_hole_across_the_whole_map_is_not_gone_round():
    console = console_of("river", "terrain.width=1.2")
    walk_on(console, 3500)
    assert console.mode is Mode.BLOCKED and "no way round within 2 m" in console.reason


def test_scattered_holes_do_not_change_the_course(shared):
    courses = {}
    for body in ("straight", "sway"):
        walk = shared.walked("holes", f'gait.body="{body}"')
        courses[body] = {step["crab_angle"] for step in walk.steps}
        # the reference never leaves the line; a body sways beside it by 50 mm at most
        aside = 1e-6 if body == "straight" else 0.05
        assert np.abs(walk.log["body"][:, 1]).max() < aside
    assert courses["straight"] == courses["sway"] == {0.0}


# the eye


@pytest.mark.parametrize("unknown", ["flat", "forbidden"])
def test_with_an_eye_it_finds_its_way_on_a_map_that_begins_empty(tmp_path, unknown):
    walk = walked(tmp_path, "fig14", "sensing=eye", f"unknown={unknown}")
    assert_always_true(walk)
    assert walk.summary["result"] == "completed" and walk.summary["off_line"] < 0.1
    assert np.abs(walk.log["body"][:, 1]).max() > 1.0


@pytest.mark.parametrize("name", ["stairs-up", "block", "river"])
def test_with_an_eye_it_walks_what_it_walks_on_a_given_map(tmp_path, name):
    walk = walked(tmp_path, name, "sensing=eye", "unknown=forbidden")
    assert_always_true(walk)
    assert walk.summary["result"] == "completed"


def test_what_it_believes_is_what_is_there_where_it_has_looked():
    console = console_of("block", "sensing=eye", "eye.noise=0.0")
    walk_on(console, 1000)
    belief, truth = console.perception.belief, console.perception.ground.heights
    tops = belief.known & (console.perception.mapper._looks > 0)
    assert 0.1 < belief.known.mean() < 0.9
    assert np.allclose(belief.heights[tops], truth[tops], atol=1e-9)


def test_a_short_sighted_eye_slows_the_walk():
    far, near = (console_of("flat", "sensing=eye", f"eye.range={reach}") for reach in (4.5, 1.8))
    for console in (far, near):
        walk_on(console, 1500)
    assert far.distance == pytest.approx(1500 * 0.02 * 0.08, rel=0.02)
    assert 0.25 * far.distance < near.distance < 0.8 * far.distance


def test_a_hole_dug_ahead_is_seen_and_not_stepped_into():
    console = console_of("flat", "sensing=eye")
    walk_on(console, 100)
    ground = console.perception.ground
    hole = [
        (row, column)
        for row in range(ground.rows)
        for column in range(ground.columns)
        if abs(ground.centre(row, column)[0] - 3.0) < 0.45
        and abs(ground.centre(row, column)[1] - 0.1) < 0.6
    ]
    console.request(Edit("dig", tuple(hole)))
    console.step()
    assert not console.perception.belief.forbidden[hole[0]]  # nobody has told it
    walk_on(console, 4500)
    assert console.plant.body[0] > 4.5 and abs(console.plant.body[1]) < 1.3
    assert sum(console.walk.contacts.counts.values()) == 0


def test_a_run_with_an_eye_is_repeatable(tmp_path):
    scenario = load_scenario("holes", ["sensing=eye", "end={time=40.0}", "expect={}"])
    (tmp_path / "one").mkdir()
    run_scenario(scenario, tmp_path / "one")
    assert replay(tmp_path / "one")["equal"]
    assert json.loads((tmp_path / "one" / "run.json").read_text())["scenario"]["sensing"] == "eye"


# touch alone


def test_by_touch_alone_the_ground_under_the_feet_is_what_is_known(tmp_path):
    walk = walked(tmp_path, "block", "sensing=none", "expect={}")
    assert walk.summary["result"] == "completed" and walk.summary["falls"] == 0
    assert walk.summary["emergent"].get("hit", 0) > 0
    believed, true = walk.terrain["believed_heights"], walk.terrain["heights"]
    assert (np.abs(believed - 0.15) < 1e-3).any() and (true == true.max()).any()


def test_holes_found_by_touch_stay_on_the_map():
    console = console_of("holes", "sensing=none")
    walk_on(console, 3000)
    learnt = np.argwhere(console.perception.mapper.learnt)
    assert len(learnt) > 0 and console.perception.belief.forbidden[tuple(learnt.T)].all()
    assert console.distance > 2.0


# orders


def test_letting_go_of_the_stick_forgets_the_line():
    console = console_of("flat")
    walk_on(console, 200)
    assert console.planner.route.line == (0.0, 0.0, 0.0)
    walk_on(console, 100, Command())
    assert console.planner.route == RouteState()
    x = console.plant.body[0]
    walk_on(console, 100)
    assert console.planner.route.line[0] == pytest.approx(x)


def test_settings_of_the_eye_are_checked():
    with pytest.raises(ScenarioError, match="eye"):
        load_scenario("flat", ["eye.colour=3"])
    with pytest.raises(ScenarioError, match="eye"):
        load_scenario("flat", ["eye.range=-1.0"])
