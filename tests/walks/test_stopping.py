"""Static stability makes a stop safe at any tick (H §9; K requirement 3)."""

import math

import pytest

from walking_console.planner.types import Command, Mode
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

WALK = Command(0.0, 0.08)
HOLD = Command()


def walking(ticks, command=WALK):
    console = Simulation(prepare(load_scenario("flat")))
    console.order(command)
    for _ in range(ticks):
        console.step()
    return console


@pytest.mark.parametrize("ticks", range(3, 330, 9))
def test_whenever_it_is_stopped_the_body_stops_at_once_and_all_feet_are_down_within_a_second(ticks):
    console = walking(ticks)
    console.order(HOLD)
    x = console.plant.body[0]
    for _ in range(50):
        console.step()
        assert console.plant.body[0] == pytest.approx(x, abs=1e-9)
    assert console.mode is Mode.STAND
    assert all(console.plant.soles)
    assert console.margins((True,) * 4)[0] >= 0.0


@pytest.mark.parametrize("ticks", range(3, 330, 9))
def test_after_any_stop_it_walks_on_in_the_old_direction(ticks):
    console = walking(ticks)
    console.order(HOLD)
    for _ in range(50):
        console.step()
    before = console.distance
    console.order(WALK)
    for _ in range(1000):
        console.step()
    assert console.distance - before > 1.0, console.reason


def test_a_command_that_is_not_repeated_expires():
    console = Simulation(prepare(load_scenario("flat")))
    console.order(WALK, ttl_ticks=25)
    for _ in range(25):
        console.step()
    x = console.plant.body[0]
    assert x > 0.0
    for _ in range(50):
        console.step()
    assert console.plant.body[0] == pytest.approx(x, abs=1e-9)
    assert console.command == HOLD


def test_the_first_motion_comes_within_two_ticks_of_the_command():
    console = Simulation(prepare(load_scenario("flat")))
    for _ in range(10):
        console.step()
    console.order(WALK)
    console.step()
    console.step()
    assert console.plant.body[0] > 0.0


def test_a_change_of_speed_takes_effect_inside_the_step():
    console = walking(60)
    console.order(Command(0.0, 0.04))
    x = console.plant.body[0]
    console.step()
    assert console.plant.body[0] - x == pytest.approx(0.04 * 0.02, rel=0.01)


def test_a_new_crab_angle_is_walked_from_the_next_step_on():
    console = walking(60)
    begun = console.walk.steps_begun
    console.order(Command(math.radians(20), 0.08))
    while console.walk.steps_begun == begun:
        y = console.plant.body[1]
        console.step()
        if console.walk.steps_begun == begun:
            assert console.plant.body[1] == pytest.approx(y, abs=1e-12)
    for _ in range(50):
        console.step()
    assert console.plant.body[1] > 0.001
