"""A way to a place is planned before it is walked, and walked as it was planned."""

import math
from dataclasses import replace

import pytest

from walking_console import Simulation, load_scenario
from walking_console.sim.route_preview import BEYOND, NEAR, preview_route


def test_a_place_on_level_ground_is_reached_in_the_steps_and_time_the_walk_then_takes() -> None:
    sim = Simulation(load_scenario("flat"))
    ahead = preview_route(sim.snapshot(), (1.0, 0.5), 0.08)
    assert ahead.reachable and ahead.reason == "" and ahead.left <= NEAR
    assert ahead.distance == pytest.approx(math.hypot(1.0, 0.5), abs=0.05)
    sim.drive(crab_angle=math.atan2(0.5, 1.0), speed=0.08)
    while sim.snapshot().distance < ahead.distance:
        sim.step()
    walked = sim.snapshot()
    assert math.dist(walked.body[:2], (1.0, 0.5)) < 0.1
    assert walked.time == pytest.approx(ahead.time, rel=0.25)
    assert walked.step == pytest.approx(ahead.steps, abs=3)


def test_behind_a_river_too_wide_it_is_said_how_far_it_comes_and_why_no_farther() -> None:
    wide = load_scenario("river", ["terrain.width=3.0"])
    start = Simulation(wide).snapshot()
    ahead = preview_route(start, (6.0, 0.0), 0.1)
    assert not ahead.reachable and ahead.reason and ahead.left > 2.0


def test_it_is_bounded_by_a_count_of_steps() -> None:
    start = Simulation(load_scenario("flat")).snapshot()
    ahead = preview_route(start, (4.0, 0.0), 0.1, steps_max=5)
    assert (ahead.reachable, ahead.steps, ahead.reason) == (False, 5, "farther than 5 steps")


def test_where_it_stands_already_nothing_is_to_be_done() -> None:
    start = Simulation(load_scenario("flat")).snapshot()
    ahead = preview_route(start, start.body[:2], 0.1)
    assert (ahead.reachable, ahead.steps, ahead.time) == (True, 0, 0.0)


def test_a_walk_goes_on_as_if_nothing_had_been_planned_ahead() -> None:
    places = []
    for asks in (False, True):
        sim = Simulation(load_scenario("holes"))
        sim.drive(speed=0.1)
        for tick in range(400):
            sim.step()
            if asks and tick % 200 == 100:
                preview_route(replace(sim.snapshot()), (1.5, 0.5), 0.1, steps_max=10)
        places.append(sim.snapshot().body)
    assert places[0] == places[1]


def test_a_way_beyond_the_window_of_a_wide_map_is_told_as_that() -> None:
    terrain = "terrain={kind='rough', amplitude=0.02, map_size=[200.0, 200.0]}"
    seen = Simulation(load_scenario("rough", (terrain, "expect={}"))).snapshot()
    assert preview_route(seen, (4.0, 0.0), 0.1).reachable
    beyond = preview_route(seen, (30.0, 0.0), 0.1)
    assert not beyond.reachable and beyond.reason == BEYOND
