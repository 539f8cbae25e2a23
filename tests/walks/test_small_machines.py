"""Machines that are titan3 made smaller: lengths chosen in metres shrink with their reach."""

from dataclasses import replace
from functools import cache

import pytest

from walking_console.planner.config import Contact
from walking_console.planner.robot.model import Machine, as_data, load_machine, machine_from
from walking_console.sim.scenario import Scenario
from walking_console.sim.simulation import Simulation

LENGTHS = ("torso", "speed", "overreach")
SINGLE = ("height", "foot_radius", "yaw_length", "lift_up", "lift_down")


@cache
def small(share: float) -> Machine:
    """titan3 times so much, speeds too, its joints and masses left out."""
    data = as_data(load_machine("titan3"))
    for key in LENGTHS:
        data[key] = [share * value for value in data[key]]
    for key in SINGLE:
        data[key] *= share
    for leg in data["legs"]:
        del leg["hip"], leg["chain"]
        for axis in "xyz":
            leg[axis] = [share * value for value in leg[axis]]
    del data["masses"]
    data.pop("chain", None)
    return machine_from(data)


@cache
def distance(share: float, body: str) -> float:
    """m walked in 15 s over level ground, by a machine that is titan3 times so much, as fast as it
    can.
    """
    scenario = {"robot": as_data(small(share)), "mode": "paper", "gait": {"body": body}}
    sim = Simulation(Scenario.model_validate(scenario | {"terrain": {"kind": "flat"}}))
    sim.drive(speed=share)
    sim.run(seconds=15.0)
    return sim.distance


def test_machines_from_a_reach_of_20_cm_on_are_full_size():
    assert load_machine("titan3").size == load_machine("hexapod").size == small(0.5).size == 1.0
    assert small(0.2).size == pytest.approx(0.2 * 0.425 / 0.2)


def test_a_machine_planned_for_with_less_of_its_reach_is_no_smaller():
    titan = load_machine("titan3")
    short = tuple(replace(leg, x=(leg.x[0], leg.x[0] + 0.01)) for leg in titan.legs)
    assert replace(titan, legs=short).size == 1.0


@pytest.mark.parametrize("share", [0.2, 0.1])
def test_a_small_machine_walks_level_ground_as_a_large_one_does(share):
    whole = distance(1.0, "straight")
    assert distance(share, "straight") / share == pytest.approx(whole, rel=0.2)


# a fifth of it may speed up as much as it needs to; the feet of a tenth of it come down too slowly
@pytest.mark.parametrize(("share", "pace"), [(0.2, 1.22), (0.1, 0.68)])
def test_a_small_machine_whose_body_sways_walks_at_the_pace_its_feet_allow(share, pace):
    whole = distance(1.0, "sway")
    assert distance(share, "sway") / share == pytest.approx(pace * whole, rel=0.05)


def test_what_nobody_has_set_of_contact_shrinks_and_what_is_set_stays():
    contact = Contact(lift_step=0.07).for_size(0.5)
    assert contact.retreat == pytest.approx(0.025) and contact.lift_step == 0.07
    assert Contact().for_size(1.0) == Contact()
