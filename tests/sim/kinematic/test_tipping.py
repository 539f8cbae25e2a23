"""Turning about an edge of support like an inverted pendulum."""

import math

import pytest

from walking_console.planner.robot.model import load_machine
from walking_console.planner.stability import GRAVITY
from walking_console.sim.kinematic.tipping import angular_acceleration, edge_of, passed_on

TITAN = load_machine("titan3")
SQUARE = {0: (1.0, 1.0, 0.0), 1: (-1.0, 1.0, 0.0), 2: (-1.0, -1.0, 0.0), 3: (1.0, -1.0, 0.0)}


def test_it_turns_about_the_edge_the_load_is_furthest_beyond():
    edge = edge_of(SQUARE, 1.2, 0.1)
    assert set(edge.legs) == {0, 3}
    assert edge.out == pytest.approx((1.0, 0.0))
    assert abs(edge.axis[1]) == pytest.approx(1.0)


def test_about_one_foot_it_turns_towards_the_load():
    edge = edge_of({2: (0.0, 0.0, 0.0)}, 0.0, -0.3)
    assert edge.legs == (2,)
    assert edge.out == pytest.approx((0.0, -1.0))


def test_with_no_foot_on_the_ground_there_is_no_edge():
    assert edge_of({}, 0.0, 0.0) is None


def test_weight_beyond_the_edge_and_a_push_outwards_turn_it_outwards():
    edge = edge_of(SQUARE, 1.2, 0.0)
    body = [1.1, 0.0, 1.0, 0.0, 0.0, 0.0]
    falling = angular_acceleration(TITAN, edge, body, (0.0, 0.0))
    assert 0.0 < falling < GRAVITY * 0.1 / 1.0
    assert angular_acceleration(TITAN, edge, body, (50.0, 0.0)) > falling
    assert angular_acceleration(TITAN, edge, body, (-500.0, 0.0)) < 0.0


def test_an_edge_square_to_the_old_one_takes_none_of_its_turning():
    old, new = edge_of(SQUARE, 1.2, 0.0), edge_of(SQUARE, 0.0, 1.2)
    assert passed_on(old, new, 2.0) == pytest.approx(0.0)
    assert passed_on(old, old, 2.0) == pytest.approx(2.0)
    assert passed_on(None, new, 2.0) == 0.0


def test_half_of_a_turn_is_about_an_edge_at_sixty_degrees():
    feet = {0: (0.0, 1.0, 0.0), 1: (0.0, -1.0, 0.0)}
    c, s = math.cos(math.pi / 3), math.sin(math.pi / 3)
    turned = {0: (-s, c, 0.0), 1: (s, -c, 0.0)}
    old, new = edge_of(feet, 0.5, 0.0), edge_of(turned, 0.5, 0.3)
    assert passed_on(old, new, 1.0) == pytest.approx(0.5)
