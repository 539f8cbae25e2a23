"""The supervisor over whole ticks: what it is at, and the modes it shows for it."""

import pytest

from walking_console.planner.control.activities import TABLE, Activity
from walking_console.planner.control.place_doubt import PlaceDoubt
from walking_console.planner.control.supervisor import MODES_OF_A_POSTURE
from walking_console.planner.types import POSTURES, Command, Mode
from walking_console.sim.requests import Edit, TakePosture
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation

AHEAD = Command(0.0, 0.08)


@pytest.fixture
def simulation():
    return Simulation(load_scenario("flat"))


def until(simulation, condition, ticks=3000):
    for _ in range(ticks):
        simulation.step()
        if condition(simulation.walk):
            return
    pytest.fail("it never came to that")


def test_it_stands_steps_and_sets_its_foot_down_when_told_to_hold(simulation):
    walk = simulation.walk
    assert walk.stands and walk.mode is Mode.STAND and walk.speed == 0.0 and not walk.plays
    simulation.order(AHEAD)
    until(simulation, lambda walk: walk.mode is Mode.RETURN)
    assert walk.steps and walk.plays and 0.0 < walk.speed <= AHEAD.speed + 1e-9
    assert walk.carrying().count(False) == 1
    simulation.drive()
    until(simulation, lambda walk: walk.activity is Activity.SETTLE, 2)
    assert walk.mode is Mode.SETTLE
    until(simulation, lambda walk: walk.stands)
    assert walk.executed is not None and walk.carrying() == (True,) * 4


def test_while_a_step_runs_the_next_is_planned(simulation):
    simulation.order(AHEAD)
    until(simulation, lambda walk: walk.ready is not None)
    assert simulation.walk.flags == (False, True, False)


def test_steps_are_planned_on_the_map_that_an_odometry_which_drifts_leaves():
    simulation = Simulation(load_scenario("holes"))
    simulation.walk._doubt = PlaceDoubt(0.02)
    simulation.order(AHEAD)
    simulation.run(seconds=15)
    until(simulation, lambda walk: walk.job.asked is not None)
    asked = simulation.walk.job.asked.terrain
    assert asked.edge > simulation.perception.belief.edge
    assert asked.heights is simulation.perception.belief.heights


@pytest.mark.parametrize("posture", POSTURES)
def test_a_posture_shows_its_own_mode_until_it_is_taken(simulation, posture):
    simulation.order(AHEAD)
    simulation.run(seconds=4)
    simulation.request(TakePosture("sit"))
    until(simulation, lambda walk: walk.mode is Mode.SIT)
    simulation.request(TakePosture(posture))
    seen = set()
    for _ in range(2000):
        simulation.step()
        seen.add(simulation.walk.mode)
    assert simulation.walk.stands and not simulation.walk.posing
    assert posture == "sit" or MODES_OF_A_POSTURE["stand"] in seen


def test_with_the_ground_gone_it_hovers_shows_blocked_and_goes_on_when_there_is_some(simulation):
    simulation.order(AHEAD)
    until(simulation, lambda walk: walk.mode is Mode.DOWN)
    ground = simulation.perception.ground
    cells = tuple((row, column) for row in range(ground.rows) for column in range(ground.columns))
    leg = simulation.walk.plan.swing[0]
    x, y, _ = simulation.walk.plan.landing
    near = tuple(
        cell
        for cell in cells
        if max(abs(a - b) for a, b in zip(ground.centre(*cell), (x, y), strict=True)) < 0.6
        and not any(
            max(abs(ground.centre(*cell)[0] - fx), abs(ground.centre(*cell)[1] - fy)) < 0.15
            for other, (fx, fy, _) in enumerate(simulation.plant.feet)
            if other != leg
        )
    )
    simulation.request(Edit("dig", near))
    until(simulation, lambda walk: walk.activity is Activity.HOVER)
    assert simulation.walk.mode is Mode.BLOCKED and simulation.walk.blocked is not None
    assert "a foot is in the air" in simulation.walk.pose("sit")


def test_every_activity_of_the_table_has_something_to_do_in_a_tick():
    from walking_console.planner.control import supervisor

    assert set(supervisor._AT) == set(TABLE)
    assert all(callable(part) for part in supervisor._AT.values())
