"""The free gait where there is plenty of ground: it is free to walk as fast as any gait."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from walking_console.planner.robot.model import as_data, load_machine
from walking_console.server.toml_text import toml
from walking_console.sim.runs.runner import run_scenario
from walking_console.sim.scenario_files import load_scenario

REPORTED = Path(__file__).parents[1] / "fixtures" / "free-gait-slower-than-tripod" / "s.toml"


def distance(*settings: str) -> float:
    keys = ("end={time=12.0}", *settings)
    return float(run_scenario(load_scenario(str(REPORTED), keys))["distance"])


@pytest.mark.parametrize("robot", ["hexapod", "phantomx"])
@pytest.mark.parametrize("degrees", [0.0, 75.0, 90.0])
def test_on_open_ground_it_is_as_fast_as_the_tripod(robot: str, degrees: float) -> None:
    keys = (f"robot={robot}", f"drive=[{{t=0.0,speed=0.4,crab_angle_deg={degrees}}}]")
    assert distance(*keys) >= 0.95 * distance(*keys, "gait.rigid=tripod")


@pytest.mark.parametrize(
    "terrain",
    [
        "{kind='holes',fraction=0.002,cell=0.1,seed=3}",
        "{kind='holes',fraction=0.1,cell=0.1,seed=3}",
        "{kind='rough',amplitude=0.03,seed=1}",
        "{kind='slope',angle_deg=6.0}",
    ],
    ids=["one hole in reach", "a tenth of it holes", "rough", "a slope"],
)
def test_where_there_is_plenty_of_ground_it_is_as_fast_as_the_tripod(terrain: str) -> None:
    keys = ("robot=hexapod", f"terrain={terrain}", "drive=[{t=0.0,speed=0.4}]")
    assert distance(*keys) >= 0.95 * distance(*keys, "gait.rigid=tripod")


@pytest.mark.parametrize(
    ("robot", "degrees"), [("phantomx", 6.0), ("phantomx", 8.0), ("phantomx", 9.0)]
)
def test_on_a_slope_that_shortens_its_reach_it_is_as_fast_as_the_tripod(
    robot: str, degrees: float
) -> None:
    slope = f"terrain={{kind='slope',angle_deg={degrees}}}"
    keys = (f"robot={robot}", slope, "drive=[{t=0.0,speed=0.4}]")
    free = distance(*keys)
    assert free > 0.1
    assert free >= 0.95 * distance(*keys, "gait.rigid=tripod")


def test_before_the_end_of_the_map_it_does_not_stand_and_search() -> None:
    keys = ("robot=hexapod", "terrain={kind='slope',angle_deg=0.0}", "drive=[{t=0.0,speed=0.4}]")
    assert distance(*keys) >= 0.95 * distance(*keys, "gait.rigid=tripod")


def scaled(size: float) -> str:
    """A hexapod of another size, every length with it, as a setting."""
    robot: dict[str, Any] = as_data(load_machine("hexapod"))
    robot["masses"] = None
    for name in ("height", "foot_radius", "yaw_length", "lift_up", "lift_down"):
        robot[name] *= size
    for name in ("torso", "speed", "overreach"):
        robot[name] = [value * size for value in robot[name]]
    for leg in robot["legs"]:
        for name in ("hip", "chain"):
            leg.pop(name, None)
        for axis in "xyz":
            leg[axis] = [value * size for value in leg[axis]]
    return toml({"robot": robot}).strip()


@pytest.mark.parametrize("slope", [0.0, 8.0])
@pytest.mark.parametrize("size", [0.4, 0.75, 1.6])
def test_hexapods_of_other_sizes_are_as_fast_as_their_tripod(size: float, slope: float) -> None:
    drive = f"drive=[{{t=0.0,speed={0.4 * size}}}]"
    keys = (scaled(size), drive, f"terrain={{kind='slope',angle_deg={slope}}}")
    assert distance(*keys) >= 0.95 * distance(*keys, "gait.rigid=tripod")
