"""Steps as high or low as one likes: no accepted pair of lifts makes an alarm of level ground."""

from __future__ import annotations

from pathlib import Path

import pytest

from walking_console.sim.runs.runner import run_scenario
from walking_console.sim.scenario_files import load_scenario

FIXTURES = Path(__file__).parents[1] / "fixtures"
REPORTED = FIXTURES / "step-height-and-false-alarms" / "s.toml"
DOG = FIXTURES / "robot-option-and-folders" / "robots" / "dog.toml"
CRAB = (("titan3", "predictive"), ("titan3", "paper"), (str(DOG), "predictive"))


def alarms(*settings: str) -> tuple[int, int]:
    """Encounters and steps of a short walk on level ground."""
    keys = ("end={time=8.0}", "expect={}", *settings)
    summary = run_scenario(load_scenario(str(REPORTED), keys))
    return sum(summary["emergent"].values()), summary["steps"]


@pytest.mark.parametrize(("robot", "mode"), CRAB)
@pytest.mark.parametrize(
    ("up", "down"), [(0.1, 0.1), (0.1, 0.11), (0.06, 0.07), (0.005, 0.005), (0.15, 0.152)]
)
def test_no_step_of_four_legs_is_an_alarm(robot: str, mode: str, up: float, down: float) -> None:
    keys = (f"robot='{robot}'", f"mode={mode}", f"gait.lift_up={up}", f"gait.lift_down={down}")
    emergent, steps = alarms(*keys)
    assert emergent == 0 and steps >= 2


@pytest.mark.parametrize(
    ("robot", "lift"), [("hexapod", 0.1), ("hexapod", 0.003), ("phantomx", 0.001)]
)
def test_no_step_of_six_legs_is_an_alarm(robot: str, lift: float) -> None:
    brisk = "drive=[{t=0.0,crab_angle_deg=10.0,speed=0.3}]"
    keys = (
        "planner=trace",
        brisk,
        f"robot={robot}",
        f"gait.lift_up={lift}",
        f"gait.lift_down={lift}",
    )
    emergent, steps = alarms(*keys)
    assert emergent == 0 and steps >= 2


def test_ground_that_is_not_there_is_still_noticed() -> None:
    hole = "terrain={kind='pit',at=1.0,depth=0.3}"
    emergent, _ = alarms(hole, "sensing=none", "drive=[{t=0.0,speed=0.08}]", "end={time=25.0}")
    assert emergent > 0
