"""Hands that never rest: sticks that tremble, slide and jump, and what must hold whatever they do
(the full count: sweeps/hands).
"""

import math

import numpy as np
import pytest

from tests.sweeps.hands import Watched, circle_walk, console_on, hand_walk
from walking_console.planner.types import TICK, Command
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

COURSES = {
    "straight": Command(0.3, 0.08),
    "arc": Command(0.3, 0.08, 0.06),
    "spot": Command(0.0, 0.0, 0.1),
}
SECONDS = 12
# m and rad a tick; a body that stands near the origin comes to rest through 1e-33 m, 1e-65 m ...
ROUNDING = 1e-12


def trembling(command, rng):
    """A thumb on the stick: a degree or so, a few percent, in every tick."""
    return Command(
        command.crab_angle + float(rng.normal(0.0, 0.02)),
        command.speed * float(rng.normal(1.0, 0.03)),
        command.turn_rate * float(rng.normal(1.0, 0.03)),
    )


def walked(positions):
    """A console driven by one position of the stick a tick: what was seen, and in how many ticks
    the body stood.
    """
    watched, stood = Watched(console_on("cells", 7, "titan3", 0.8)), 0
    for command in positions:
        before = tuple(watched.console.plant.body[:6])
        watched.order(command)
        watched.step()
        stood += math.dist(watched.console.plant.body[:6], before) <= ROUNDING
    return watched.seen, stood


@pytest.mark.parametrize("course", COURSES)
def test_a_stick_that_trembles_is_walked_like_one_that_rests(course):
    command, rng = COURSES[course], np.random.default_rng(3)
    rested, stood = walked([command] * (SECONDS * 50))
    trembled, stood_too = walked([trembling(command, rng) for _ in range(SECONDS * 50)])
    assert trembled.way + trembled.turned > 0.9 * (rested.way + rested.turned)
    assert stood_too <= stood + 10 and not trembled.amiss


@pytest.mark.parametrize("radius, degrees, sense", [(1.0, 30.0, -1), (2.0, 105.0, 1)])
def test_on_a_circle_the_true_centre_keeps_the_margin_while_a_leg_is_up(radius, degrees, sense):
    watched = Watched(console_on("flat", 52_000, "titan3", 0.8))
    watched.order(Command(math.radians(degrees), 0.08, sense * 0.08 / radius))
    for _ in range(40 * 50):
        watched.step()
    assert watched.seen.true_margin >= 0.018 and not watched.seen.amiss


def test_a_stick_pushed_farther_and_farther_out_is_answered_meanwhile():
    """On an arc a thought takes several ticks: it must not begin anew with every speed the stick
    passes.
    """
    positions = [
        Command(0.3, f * 0.08, f * 0.06)
        for f in (1.0 + 0.5 * math.sin(k / 25) for k in range(SECONDS * 50))
    ]
    rested, stood = walked([Command(0.3, 0.08, 0.06)] * (SECONDS * 50))
    pushed, stood_too = walked(positions)
    assert pushed.way > 0.9 * rested.way and rested.way > 0.8 * 0.08 * SECONDS
    assert stood_too <= stood + 10 and pushed.stood < 2.5 and not pushed.amiss


@pytest.mark.parametrize("body", ["straight", "sway"])
def test_a_body_that_waits_for_its_foot_does_not_wait_longer_when_the_stick_is_drawn_back(body):
    # it must step on the spot at first
    feet = "start.feet=[[0.3597,0.3961],[-0.4831,0.4484],[-0.6305,-0.3041],[0.6321,-0.3430]]"
    settings = [feet, "gait.duty_factor=0.888", f'gait.body="{body}"']
    console = Simulation(prepare(load_scenario("flat", settings)))
    console.order(Command(math.radians(-57.6), 0.08))
    for _ in range(500):
        console.step()
        if console.walk.steps and console.walk.plan.shift < 1e-6:
            break
    begun, plan = console.walk.steps_begun, console.walk.plan
    assert console.walk.steps and plan.shift < 1e-6
    console.order(Command(math.radians(-57.6), 0.002))
    for _ in range(math.ceil(console.walk.run.tracker.duration / TICK)):
        console.step()
    assert console.walk.steps_begun > begun or console.walk.stands


@pytest.mark.parametrize("ticks", [10, 60, 110, 160])
def test_a_foot_comes_down_at_its_own_speed_when_a_creeping_stick_is_pushed(ticks):
    """The step of a creeping body is minutes long; played much faster it must not jump over the way
    down.
    """
    console = console_on("flat", 1, "titan3", 0.8)
    console.order(Command(0.0, 0.004))
    phases = set()
    for _ in range(60):
        for _ in range(ticks):
            console.step()
        console.order(Command(0.0, 0.25))
        phases.add(console.walk.mode)
        for _ in range(8):
            console.step()
        console.order(Command(0.0, 0.004))
    assert (
        not console.walk.contacts.counts and console.plant.state == "standing" and len(phases) > 1
    )


@pytest.mark.parametrize(("seed", "ground"), [(1, "flat"), (2, "cells"), (2020, "flat")])
def test_a_restless_hand_comes_to_no_harm_and_is_never_stuck(seed, ground):
    seen, last = hand_walk(seed, ground, 55.0)
    assert not seen.amiss, (seen.amiss, seen.reason)
    assert last > 0.5


def test_it_comes_right_round_on_a_circle_near_the_critical_angle():
    seen = circle_walk(1.0, 45.0, -1, "cells", 4)
    assert abs(seen.yaw) >= 2 * math.pi and not seen.amiss
