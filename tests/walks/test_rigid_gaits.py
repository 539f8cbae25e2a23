"""Rigid gaits walked: of four and of six legs, by name and one's own."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from walking_console.sim.runs.reader import open_run
from walking_console.sim.runs.runner import run_scenario
from walking_console.sim.scenario import ScenarioError
from walking_console.sim.scenario_files import load_scenario

FIXTURES = Path(__file__).parents[1] / "fixtures"
FOUR = FIXTURES / "rigid-gait-on-four-legs" / "s.toml"
SIX = FIXTURES / "ripple-is-a-wave" / "s.toml"


def walked(scenario: Path, *settings: str, out: Path | None = None) -> dict[str, Any]:
    return run_scenario(load_scenario(str(scenario), settings), out)


@pytest.mark.parametrize("rigid", ["wave", '{rows=["1011", "0111", "1101", "1110"]}'])
@pytest.mark.parametrize(("body", "least"), [("straight", 0.9), ("sway", 0.85)])
def test_four_legs_walk_a_wave(rigid: str, body: str, least: float) -> None:
    summary = walked(FOUR, f"gait.rigid={rigid}", f"gait.body={body}")
    assert summary["result"] == "completed" and summary["distance"] > least
    assert summary["margin_min"] > 0.0 and not summary["emergent"]


def test_what_four_legs_cannot_walk_is_refused_with_the_count() -> None:
    for rigid in ("tripod", "ripple", "gallop"):
        with pytest.raises(ScenarioError, match="legs; titan3 has 4"):
            walked(FOUR, f"gait.rigid={rigid}")


@pytest.mark.parametrize("robot", ["hexapod", "phantomx"])
def test_ripple_is_about_twice_as_fast_as_wave_with_two_legs_in_the_air(
    robot: str, tmp_path: Path
) -> None:
    keys = (f"robot={robot}", "end={time=15.0}")
    wave = walked(SIX, *keys, "gait.rigid=wave")
    ripple = walked(SIX, *keys, "gait.rigid=ripple", out=tmp_path / "run")
    assert 1.8 < ripple["distance"] / wave["distance"] < 2.6
    in_the_air = (~open_run(tmp_path / "run").ticks["support"]).sum(axis=1)
    assert np.max(in_the_air) == 2


def ringed(legs: int) -> str:
    """A robot card of legs all round, as a scenario's inline table."""
    boxes = []
    for k in range(legs):
        turn = math.pi / legs * (2 * k + 1)
        x, y = 0.45 * math.cos(turn), 0.4 * math.sin(turn)
        box = f"x=[{x - 0.09},{x + 0.09}],y=[{y - 0.07},{y + 0.07}],z=[-0.4,-0.2]"
        boxes.append(f'{{name="{k + 1}",{box}}}')
    return (
        '{name="ring",title="ring",source="made up",mass=12.0,torso=[0.6,0.5,0.1],height=0.3,'
        "foot_radius=0.02,friction=0.8,yaw_length=0.3,duty_factor=0.75,lift_up=0.05,lift_down=0.08,"
        f"speed=[0.5,0.5,0.5],overreach=[0.02,0.02,0.04],legs=[{','.join(boxes)}]}}"
    )


# the free gait is as fast as a tripod; swayed, the body has farther to go between its supports
@pytest.mark.parametrize(("body", "least"), [("straight", 0.95), ("sway", 0.9)])
@pytest.mark.parametrize("legs", [7, 8])
def test_more_legs_walk_the_tripod_too_which_lifts_four_at_a_time(
    legs: int, body: str, least: float
) -> None:
    drive = "drive=[{speed=0.3}]"
    keys = (f"robot={ringed(legs)}", "end={time=10.0}", drive, f"gait.body={body}")
    wave = walked(SIX, *keys, "gait.rigid=wave")
    tripod = walked(SIX, *keys, "gait.rigid=tripod")
    free = run_scenario(load_scenario("flat", (*keys, "planner=trace", "expect={}")))
    for summary in (wave, tripod, free):
        assert summary["result"] == "completed" and summary["falls"] == 0
    assert tripod["distance"] > 3.0 * wave["distance"] > 0.6
    assert free["distance"] >= least * tripod["distance"]
