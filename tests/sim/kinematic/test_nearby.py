"""What is near a place: no obstacle that a foot, a leg or the torso meets is left out."""

import math
import random

import pymunk
import pytest

from walking_console.planner.robot.model import load_machine
from walking_console.sim.kinematic.contact import OVER, ContactWorld
from walking_console.sim.kinematic.nearby import Nearby
from walking_console.sim.terrain.generators import Obstacle

TITAN = load_machine("titan3")


def crowd(rng: random.Random) -> list[Obstacle]:
    """Poles and turned boxes of all heights, many of them where a machine at (0, 0) would be."""
    found = []
    for _ in range(12):
        x, y, top = rng.uniform(-1.2, 1.2), rng.uniform(-1.2, 1.2), rng.uniform(0.0, 0.5)
        if rng.random() < 0.5:
            found.append(Obstacle(x, y, 0.0, top, radius=rng.uniform(0.02, 0.2)))
            continue
        turn, a, b = rng.uniform(0.0, 1.5), rng.uniform(0.05, 0.3), rng.uniform(0.05, 0.3)
        c, s = math.cos(turn), math.sin(turn)
        corners = [(a, b), (-a, b), (-a, -b), (a, -b)]
        placed = tuple((x + c * p - s * q, y + s * p + c * q) for p, q in corners)
        found.append(Obstacle(x, y, 0.0, top, corners=placed))
    return found


class Asked(ContactWorld):
    """Contacts that ask pymunk about everything, as if all were near."""

    def __init__(self, obstacles, machine):
        super().__init__(obstacles, machine)
        self._near_foot = self._near_body = Everything()


class Everything:
    def within(self, x, y, reach, low):
        return True

    def on_the_way(self, centre, a, b, low):
        return True


@pytest.mark.parametrize("seed", range(8))
def test_feet_legs_and_torso_meet_the_same_as_when_everything_is_asked_about(seed):
    rng = random.Random(seed)
    obstacles = crowd(rng)
    quick, thorough = ContactWorld(obstacles, TITAN), Asked(obstacles, TITAN)
    met = 0
    for _ in range(200):
        body = (rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), 0.35, 0.0, 0.0, rng.uniform(-3, 3))
        feet = [
            (body[0] + rng.uniform(-0.9, 0.9), body[1] + rng.uniform(-0.9, 0.9), rng.random() * 0.3)
            for _ in TITAN.legs
        ]
        assert quick.bump(body, feet) == thorough.bump(body, feet)
        for leg, foot in enumerate(feet):
            hits = thorough.leg_hits(leg, body, foot)
            met += hits
            assert quick.leg_hits(leg, body, foot) == hits
            bits = thorough.feel(*foot, body[5])
            met += bits > 0
            assert quick.feel(*foot, body[5]) == bits
            way = (
                *foot[:2],
                *(at + rng.choice((0.01, 0.1, 1.0)) * rng.random() for at in foot[:2]),
            )
            touch = thorough.sweep(*way, foot[2])
            met += touch is not None
            assert quick.sweep(*way, foot[2]) == touch
    assert met > 100


def test_nothing_is_asked_of_pymunk_where_all_that_is_near_is_lower(monkeypatch):
    def asked(*args):
        raise AssertionError("pymunk was asked")

    low = Obstacle(0.0, 0.0, 0.0, 0.1, corners=((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)))
    world = ContactWorld((low,), TITAN)
    monkeypatch.setattr(pymunk.Space, "segment_query", asked)
    monkeypatch.setattr(pymunk.Space, "shape_query", asked)
    feet = [(x, y, 0.1) for x, y in ((0.4, 0.4), (-0.4, 0.4), (-0.4, -0.4), (0.4, -0.4))]
    assert world.bump((0.0, 0.0, 0.5, 0.0, 0.0, 0.3), feet) is None
    assert world.feel(0.4, 0.4, 0.1, 0.3) == 0
    assert world.sweep(0.4, 0.4, 0.41, 0.4, 0.1) is None
    with pytest.raises(AssertionError, match="pymunk was asked"):
        world.feel(0.4, 0.4, 0.1 - 2 * OVER, 0.3)


def test_what_is_out_of_the_margin_is_looked_for_among_all():
    near = Nearby((Obstacle(5.0, 0.0, 0.0, 1.0, radius=0.1),), 0.5)
    assert not near.any(0.0, 0.0)
    assert near.on_the_way((0.0, 0.0), (0.0, 0.0), (6.0, 0.0), 0.5)
    assert not near.on_the_way((0.0, 0.0), (0.0, 0.0), (6.0, 0.0), 1.0)
    assert not near.on_the_way((0.0, 0.0), (0.0, 1.0), (6.0, 1.0), 0.5)
