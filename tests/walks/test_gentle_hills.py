"""Hills of 5 cm up and down are walked in the standard pattern of H fig. 6, whatever the mode."""

import pytest

from walking_console.planner.crab.gait import AGREEMENT
from walking_console.sim.runs.runner import walk_scenario
from walking_console.sim.scenario_files import load_scenario

HILLS = 'terrain={kind="rough",amplitude=0.05}'
AHEAD = "drive=[{t=0.0,speed=0.1}]"


@pytest.mark.parametrize("mode", ["paper", "predictive"])
@pytest.mark.parametrize("sensing", ["known", "eye"])
def test_every_step_on_gentle_hills_comes_out_in_the_standard_layout(mode, sensing):
    settings = [f"mode={mode}", f"sensing={sensing}", HILLS, AHEAD, "end={time=30.0}"]
    summary, recorder = walk_scenario(load_scenario("rough", [*settings, "expect={}"]))
    assert summary["result"] == "completed" and summary["steps"] >= 17
    assert all(step["off_standard"] <= AGREEMENT for step in recorder.steps)
    assert not any("departure" in step for step in recorder.steps)
