"""No servo is ever driven faster than the machine's limits, where the walk asks for just these."""

import pytest

from walking_console.planner.types import TICK
from walking_console.sim.kinematic.configuration import SOLE_GAP
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation

SLACK = 1e-9  # m


# a swaying walk has time to spare: its feet need not go as fast as they can
@pytest.mark.parametrize(
    ("name", "body", "share"),
    [("fig16", "straight", 0.9), ("fig6a", "straight", 0.9), ("fig6a", "sway", 0.85)],
)
def test_feet_keep_v_in_every_tick_and_springing_soles_add_no_more_than_they_give(
    name, body, share
):
    sim = Simulation(load_scenario(name, [f'gait.body="{body}"']))
    sim.drive(speed=1.0)
    most = [limit * TICK for limit in sim.world.machine.speed]
    fastest = 0.0
    for _ in range(700):
        tips = [tuple(tip) for tip in sim.plant.q.tips]
        feet = [foot[2] for foot in sim.plant.feet]
        sim.step()
        for leg, (before, after) in enumerate(zip(tips, sim.plant.q.tips, strict=True)):
            went = [abs(b - a) for a, b in zip(before, after, strict=True)]
            assert all(way <= limit + SLACK for way, limit in zip(went, most, strict=True)), leg
            assert abs(sim.plant.feet[leg][2] - feet[leg]) <= most[2] + SOLE_GAP
            fastest = max(fastest, went[2])
    assert fastest > share * most[2]
