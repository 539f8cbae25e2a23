"""Static stability makes a stop safe at any tick (H §9; K requirement 3)."""

import math

import pytest

from walking_console.planner.types import Command, Mode
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

WALK = Command(0.0, 0.08)
HOLD = Command()
REST = 30  # ticks, the longest a body that sways takes to come to rest
WAY = 0.042  # m it goes on meanwhile at most, where it swings aside at 0.2 m/s
PRINTED = 'gait.body="straight"'
SWAYED = 'gait.body="sway"'


def walking(ticks, command=WALK, *settings):
    console = Simulation(prepare(load_scenario("flat", settings)))
    console.order(command)
    for _ in range(ticks):
        console.step()
    return console


@pytest.mark.parametrize("ticks", range(3, 330, 9))
@pytest.mark.parametrize("command", [WALK, Command(math.pi / 2, 0.5)], ids=["ahead", "aside"])
def test_whenever_it_is_stopped_a_swaying_body_rests_within_0_6_seconds_and_all_feet_are_down(
    ticks, command
):
    console = walking(ticks, command, SWAYED)
    console.order(HOLD)
    begun = console.plant.body[:2]
    for _ in range(REST):
        console.step()
    rest = console.plant.body[:2]
    assert math.dist(begun, rest) <= WAY
    for _ in range(REST):
        console.step()
        assert console.plant.body[:2] == pytest.approx(rest, abs=1e-9)
    assert console.mode is Mode.STAND
    assert all(console.plant.soles)
    assert console.margins((True,) * 4)[0] >= 0.0


@pytest.mark.parametrize("ticks", range(3, 330, 9))
def test_whenever_it_is_stopped_the_body_stops_at_once_and_all_feet_are_down_within_a_second(ticks):
    console = walking(ticks, WALK, PRINTED)
    console.order(HOLD)
    x = console.plant.body[0]
    for _ in range(50):
        console.step()
        assert console.plant.body[0] == pytest.approx(x, abs=1e-9)
    assert console.mode is Mode.STAND
    assert all(console.plant.soles)
    assert console.margins((True,) * 4)[0] >= 0.0


def test_a_swaying_body_is_said_to_move_until_it_stands():
    console = walking(130, WALK, SWAYED)
    console.order(HOLD)
    console.step()  # the command is heard
    for _ in range(REST):
        place, said = console.plant.body[:2], console.walk.speed
        console.step()
        assert (math.dist(place, console.plant.body[:2]) > 1e-6) == (said > 1e-4)
    assert console.walk.speed == 0.0


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


@pytest.mark.parametrize(("body", "way"), [(PRINTED, 1e-9), (SWAYED, WAY)])
def test_a_command_that_is_not_repeated_expires(body, way):
    console = Simulation(prepare(load_scenario("flat", [body])))
    console.order(WALK, ttl_ticks=25)
    for _ in range(25):
        console.step()
    x = console.plant.body[0]
    assert x > 0.0
    for _ in range(REST):
        console.step()
    assert console.command == HOLD
    rest = console.plant.body[0]
    assert rest - x <= way
    for _ in range(50):
        console.step()
    assert console.plant.body[0] == pytest.approx(rest, abs=1e-9)


@pytest.mark.parametrize("body", [PRINTED, SWAYED])
def test_the_first_motion_comes_within_two_ticks_of_the_command(body):
    console = Simulation(prepare(load_scenario("flat", [body])))
    for _ in range(10):
        console.step()
    console.order(WALK)
    console.step()
    console.step()
    assert console.plant.body[0] > 0.0


def test_a_change_of_speed_takes_effect_inside_the_step():
    console = walking(60, WALK, PRINTED)
    console.order(Command(0.0, 0.04))
    x = console.plant.body[0]
    console.step()
    assert console.plant.body[0] - x == pytest.approx(0.04 * 0.02, rel=0.01)


def test_a_body_that_sways_changes_its_speed_inside_the_step_as_fast_as_it_may():
    console = walking(200, WALK, SWAYED)
    begun = console.walk.steps_begun
    console.order(Command(0.0, 0.04))
    console.step()
    assert 0.04 < console.walk.speed < 0.08
    for _ in range(9):  # 0.04 m/s less at 0.226 m/s²: 0.18 s
        console.step()
    assert console.walk.speed == pytest.approx(0.04) and console.walk.steps_begun == begun
    x = console.plant.body[0]
    console.step()
    assert console.plant.body[0] - x == pytest.approx(0.04 * 0.02, rel=0.1)


@pytest.mark.parametrize(("body", "ticks"), [(PRINTED, 50), (SWAYED, 400)])
def test_a_new_crab_angle_is_walked_from_the_next_step_on(body, ticks):
    console = walking(60, WALK, body)
    begun = console.walk.steps_begun
    console.order(Command(math.radians(20), 0.08))
    while console.walk.steps_begun == begun:
        y = console.plant.body[1]
        console.step()
        if console.walk.steps_begun == begun:
            assert console.plant.body[1] == pytest.approx(y, abs=1e-12)
    x, y, *_ = console.plant.body
    for _ in range(ticks):  # a swaying body may first go to the other side: four steps are a cycle
        console.step()
    off = math.atan2(console.plant.body[1] - y, console.plant.body[0] - x) - math.radians(20)
    assert abs(off) < math.radians(0.1 if body == PRINTED else 5.0)
