"""A swaying body that a hand throws about is led no farther than its standing legs reach."""

import math

import pytest

from tests.sweeps.seams import walk
from walking_console.planner.geometry.transforms import point_seen
from walking_console.planner.types import TICK, Command
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation

ROUNDING = 1e-9  # m
SWAY = ('gait.body="sway"', "expect={}", "end={time=60.0}")
# s at which the stick is pushed, and where to
ABOUT = ((0.0, Command(-1.292, 0.298)), (0.32, Command(1.85, 0.298)))
ON_ARCS = (
    (0.0, Command(-2.1334, 0.2865, -0.0658)),
    (4.18, Command(-2.1334, 0.2865, -0.116)),
    (6.34, Command(1.0082, 0.2865, 0.116)),
)


def beyond(simulation):
    """How far the plan has the body beyond what the legs that carry reach, m; negative within."""
    run, feet = simulation.walk.run, simulation.plant.feet
    body, machine = run.tracker.body_at(run.t), run.machine
    outside = [
        max(place - high - over, low - over - place)
        for leg, foot, carries in zip(machine.legs, feet, simulation.walk.carrying(), strict=True)
        if carries
        for place, (low, high), over in zip(
            point_seen(body, tuple(foot)), (leg.x, leg.y), machine.overreach, strict=False
        )
    ]
    return max(outside)


@pytest.mark.parametrize(("pushes", "seconds"), [(ABOUT, 4.0), (ON_ARCS, 9.0)])
def test_a_stick_turned_abruptly_leads_no_standing_foot_beyond_reach_or_along(pushes, seconds):
    simulation = Simulation(load_scenario("flat", SWAY))
    orders = {round(at / TICK): command for at, command in pushes}
    for tick in range(round(seconds / TICK)):
        simulation.order(orders.get(tick, simulation.command))
        feet, carried = [tuple(foot) for foot in simulation.plant.feet], simulation.walk.carrying()
        simulation.step()
        assert beyond(simulation) <= ROUNDING, tick
        stands = [a and b for a, b in zip(carried, simulation.walk.carrying(), strict=True)]
        for before, after, stood in zip(feet, simulation.plant.feet, stands, strict=True):
            assert not stood or math.dist(before, after) <= 1e-4


def test_stretched_legs_on_the_bank_of_a_river_are_not_drawn_along_before_one_lifts():
    told = walk("river", "gait.body=sway", "terrain.width=0.5")
    assert told.ending == ("completed", "distance") and told.falls == 0
    assert told.slide <= 1e-4
