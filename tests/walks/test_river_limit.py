"""Six legs cross rivers up to the limit of their reach, which the map's own footholds tell."""

import numpy as np
import pytest

from walking_console.planner.trace.paths import step_for
from walking_console.sim.runs.runner import run_scenario
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.world import prepare

SIX = ("robot=hexapod", "planner=trace", "end={time=60.0, distance=4.0}", "expect={}")
BANK = 1.2  # m, where the river begins


def settings(width: float) -> list[str]:
    return [*SIX, f"terrain.width={width}"]


def apart(width: float) -> float:
    """From the last foothold before the river to the first behind it, m."""
    believed = prepare(load_scenario("river", settings(width))).belief
    allowed = ~believed.forbidden[believed.rows // 2]
    x = believed.origin[0] + (np.arange(believed.columns) + 0.5) * believed.cell
    behind = x[(x > BANK + width / 2) & allowed].min()
    return float(behind - x[(x < BANK + width / 2) & allowed].max())


def test_the_widest_river_within_reach_is_half_a_metre_wide():
    machine = prepare(load_scenario("river", settings(0.3))).machine
    reach = machine.legs[0].x[1] - machine.legs[0].x[0]
    room = step_for(machine)
    assert apart(0.51) == pytest.approx(0.575) and apart(0.51) <= reach - room
    assert apart(0.52) == pytest.approx(0.600) and apart(0.52) > reach - room


@pytest.mark.parametrize("width", [0.45, 0.51])
def test_a_river_within_reach_is_crossed(width):
    summary = run_scenario(load_scenario("river", settings(width)))
    assert summary["reason"] == "distance" and summary["falls"] == 0
    assert summary["forbidden_steps"] == 0


def test_a_river_out_of_reach_ends_in_a_reason():
    summary = run_scenario(load_scenario("river", settings(0.52)))
    assert summary["result"] == "blocked" and "foothold" in summary["reason"]
    assert summary["falls"] == 0
