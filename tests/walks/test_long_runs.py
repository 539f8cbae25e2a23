"""A longer run has a coarser map of level ground; the walk over it is no other."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation

# robot, planner, m/s, body, and the least share of the pace that is walked in the first 10 s: a
# swaying body gets under way no faster than its margin allows
ROBOTS = [
    ("titan3", "crab", 0.08, "straight", 0.9),
    ("titan3", "crab", 0.08, "sway", 0.79),
    ("hexapod", "trace", 0.2, "straight", 0.9),
    ("hexapod", "trace", 0.2, "sway", 0.6),
    ("phantomx", "trace", 0.06, "straight", 0.9),
    ("phantomx", "trace", 0.06, "sway", 0.98),
]
REPORTED = Path(__file__).parents[1] / "fixtures" / "longer-run-blocks-hexapod" / "s.toml"


def distance_in(seconds: float, robot: str, degrees: float, end: float) -> float:
    """m walked in the first seconds of a run that would last ``end`` s."""
    keys = (f"robot={robot}", f"end={{time={end}}}")
    simulation = Simulation(load_scenario(str(REPORTED), keys))
    simulation.drive(math.radians(degrees), simulation.world.scenario.drive[0].speed)
    simulation.run(seconds=seconds)
    return simulation.distance


@pytest.mark.parametrize("robot", ["phantomx", "hexapod"])
@pytest.mark.parametrize("degrees", [45.0, 15.0])
def test_six_legs_walk_level_ground_whatever_the_run_s_length(robot: str, degrees: float) -> None:
    short = distance_in(6.0, robot, degrees, 30.0)
    long = distance_in(6.0, robot, degrees, 3600.0)
    assert short > 0.2 and long > 0.8 * short


@pytest.mark.slow
@pytest.mark.parametrize("end", [30.0, 3600.0])
@pytest.mark.parametrize(("robot", "planner", "speed", "body", "share"), ROBOTS)
def test_every_robot_walks_level_ground_every_15_degrees(
    robot: str, planner: str, speed: float, body: str, share: float, end: float
) -> None:
    keys = (f"robot={robot}", f"planner={planner}", f"gait.body={body}", f"end={{time={end}}}")
    for degrees in range(0, 360, 15):
        drive = f"drive=[{{crab_angle_deg={float(degrees)},speed={speed}}}]"
        simulation = Simulation(load_scenario("flat", (*keys, "expect={}", drive)))
        simulation.drive(math.radians(degrees), speed)
        simulation.run(seconds=10.0)
        assert simulation.distance > share * 10.0 * speed, degrees
