"""C1, C2 and the PID option of H §8 set in a scenario reach Level C, and the walk still walks."""

import pytest

from walking_console.planner.config import Gains
from walking_console.sim.runs.runner import run_scenario
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation

PID = "config.gains={posture=0.4, pliancy=0.001, integral=0.3, derivative=0.1, windup=0.002}"
SHORT = ("end={time=15.0}", "expect={}")


def test_gains_of_a_scenario_are_those_of_level_c():
    told = Simulation(load_scenario("flat", [PID])).walk.run.config.gains
    assert told == Gains(posture=0.4, pliancy=0.001, integral=0.3, derivative=0.1, windup=0.002)


@pytest.mark.parametrize("name", ["flat", "stairs-up"])
def test_with_pid_the_walk_is_as_long_and_as_sure_as_with_p(name):
    plain = run_scenario(load_scenario(name, SHORT))
    pid = run_scenario(load_scenario(name, [PID, *SHORT]))
    assert pid["state_hash"] != plain["state_hash"] or name == "flat"
    assert pid["distance"] == pytest.approx(plain["distance"], rel=0.02)
    assert pid["margin_min"] == pytest.approx(plain["margin_min"], abs=0.002)
    assert pid["falls"] == 0
