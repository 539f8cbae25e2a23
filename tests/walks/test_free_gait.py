"""The free gait where nothing is forbidden: it is free to walk as fast as any gait."""

from __future__ import annotations

from pathlib import Path

import pytest

from walking_console.sim.runs.runner import run_scenario
from walking_console.sim.scenario_files import load_scenario

REPORTED = Path(__file__).parents[1] / "fixtures" / "free-gait-slower-than-tripod" / "s.toml"


def distance(*settings: str) -> float:
    keys = ("end={time=12.0}", *settings)
    return float(run_scenario(load_scenario(str(REPORTED), keys))["distance"])


@pytest.mark.parametrize("robot", ["hexapod", "phantomx"])
@pytest.mark.parametrize("degrees", [0.0, 75.0])
def test_on_open_ground_it_is_as_fast_as_the_tripod(robot: str, degrees: float) -> None:
    keys = (f"robot={robot}", f"drive=[{{t=0.0,speed=0.4,crab_angle_deg={degrees}}}]")
    assert distance(*keys) >= 0.95 * distance(*keys, "gait.rigid=tripod")
