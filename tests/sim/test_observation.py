"""What a snapshot says of the simulation it is taken of."""

import pytest

from walking_console.planner.types import TICK, Mode
from walking_console.sim.observation import take_snapshot
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation


@pytest.fixture(scope="module")
def walking() -> Simulation:
    simulation = Simulation(load_scenario("flat"), explain=True)
    simulation.drive(crab_angle=0.1, speed=0.08)
    simulation.run(seconds=4.0)
    return simulation


def test_it_shows_the_machine_where_it_is(walking: Simulation) -> None:
    seen = take_snapshot(walking)
    assert seen.tick == 200 and seen.time == pytest.approx(200 * TICK)
    assert seen.body == tuple(walking.plant.body)
    assert seen.feet == tuple(tuple(foot) for foot in walking.plant.feet)
    assert seen.contact == tuple(walking.plant.soles)
    assert (seen.margin, seen.polygon_margin, seen.capture_margin) == walking.margins(seen.support)


def test_it_shows_the_step_that_runs_and_why_it_was_chosen(walking: Simulation) -> None:
    seen = take_snapshot(walking)
    assert seen.mode not in (Mode.STAND, Mode.BLOCKED)
    assert seen.plan is walking.walk.plan and seen.step == walking.walk.steps_begun
    assert seen.decision is not None and seen.decision == seen.plan.decision
    assert 0.0 < seen.speed <= seen.speed_max


def test_a_step_that_takes_longer_for_the_sway_is_shown_as_fast_as_it_is() -> None:
    for body, slows in (("straight", False), ("sway", True)):
        simulation = Simulation(load_scenario("flat", [f'gait.body="{body}"']))
        simulation.drive(crab_angle=1.57, speed=0.08)
        shown = []
        for _ in range(500):
            simulation.step()
            shown.append(take_snapshot(simulation))
        assert any(seen.sway_slows for seen in shown) == slows
        slow = [seen for seen in shown if seen.sway_slows]
        assert all(seen.speed < 0.97 * 0.08 for seen in slow)


def test_a_machine_that_stands_runs_no_step() -> None:
    seen = take_snapshot(Simulation(load_scenario("flat")))
    assert seen.mode is Mode.STAND
    assert seen.plan is None and seen.decision is None and seen.speed_max == 0.0


def test_what_a_clock_says_is_passed_on(walking: Simulation) -> None:
    seen = take_snapshot(walking, paused=True, rate=4.0, late=0.01)
    assert (seen.paused, seen.rate, seen.late) == (True, 4.0, 0.01)


def test_a_walker_of_traces_shows_its_way_along_it_and_what_is_to_come() -> None:
    simulation = Simulation(load_scenario("k-curve"))
    simulation.drive(speed=0.1)
    simulation.run(seconds=4.0)
    seen = take_snapshot(simulation)
    assert seen.course > 0.1
    assert seen.ahead is not None and seen.ahead.reached > seen.course
    assert take_snapshot(simulation).ahead is seen.ahead
