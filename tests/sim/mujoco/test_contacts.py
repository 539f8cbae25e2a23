"""What feet feel."""

import numpy as np

from walking_console.planner.robot.model import load_machine
from walking_console.sim.mujoco.contacts import SOLE_OFF, SOLE_ON, FootContacts
from walking_console.sim.terrain.generators import Obstacle
from walking_console.sim.terrain.ground import Ground

TITAN = load_machine("titan3")
WEIGHT = TITAN.mass * 9.81
BODY = [0.0, 0.0, 0.85, 0.0, 0.0, 0.0]


def level(**more) -> Ground:
    return Ground(np.zeros((80, 80)), 0.025, (-1.0, -1.0), **more)


def feet_at(x: float, y: float, z: float = 0.0) -> list[list[float]]:
    return [[x, y, z]] + [[0.5 * k, -0.5, 0.0] for k in range(3)]


def test_a_sole_goes_on_at_one_load_and_off_at_a_lesser_one():
    contact = FootContacts(TITAN, level())
    between = (SOLE_ON + SOLE_OFF) / 2 * WEIGHT
    for load, on in ((between, False), (2 * SOLE_ON * WEIGHT, True), (between, True), (0.0, False)):
        contact.take_loads([load, 0.0, 0.0, 0.0])
        assert contact.soles[0] is on


def test_a_foot_near_a_pole_feels_it_on_that_side_while_it_is_in_the_air():
    pole = Obstacle(0.3, 0.0, 0.0, 1.0, radius=0.05)
    contact = FootContacts(TITAN, level(obstacles=(pole,)))
    contact.feel(feet_at(0.2, 0.0, 0.2), BODY, [])
    assert contact.whiskers[0] & 1
    contact.feel(feet_at(-0.5, 0.0, 0.2), BODY, [])
    assert contact.whiskers[0] == 0


def test_a_foot_against_something_upright_feels_it_where_it_was_going():
    contact = FootContacts(TITAN, level())
    contact.feel(feet_at(0.0, 0.0, 0.1), BODY, [(0, 0.0, 1.0)])
    assert contact.whiskers[0] == 1 << 2  # to the left


def test_a_sole_that_comes_down_at_an_edge_hangs_over_on_that_side():
    ground = level()
    drop = ground.edited((row, column, -0.5) for row in range(80) for column in range(60, 80))
    contact = FootContacts(TITAN, drop)
    contact.take_loads([200.0, 0.0, 0.0, 0.0])
    contact.feel(feet_at(0.49, 0.0), BODY, [])
    assert contact.rims[0] & 1 and not contact.rims[0] & 1 << 4


def test_it_goes_on_from_its_state():
    contact, other = FootContacts(TITAN, level()), FootContacts(TITAN, level())
    contact.take_loads([200.0, 100.0, 0.0, 0.0])
    other.restore(contact.state())
    assert other.state() == contact.state()


def test_a_foot_that_carries_nothing_has_no_rim():
    contact = FootContacts(TITAN, level())
    contact.take_loads([0.0] * 4)
    contact.feel(feet_at(0.0, 0.0), BODY, [])
    assert contact.rims == [0] * 4
