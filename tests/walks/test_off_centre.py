"""Machines whose centre of gravity is off the middle of their legs, or whose hips differ, walk in
the crab planner as far as they are told and keep every margin.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from tests.walks.telling import assert_always_true, walked
from walking_console.planner.robot.model import as_data, load_machine
from walking_console.server.toml_text import toml
from walking_console.sim.runs.runner import run_scenario
from walking_console.sim.scenario_files import load_scenario

FIXTURES = Path(__file__).parents[1] / "fixtures"
REPORTED = FIXTURES / "centre-of-gravity-off-centre" / "s.toml"
DOG = FIXTURES / "robot-option-and-folders" / "robots" / "dog.toml"


def off_centre(ahead: float, aside: float, hips_in: float) -> str:
    """The dog with its centre of gravity ``ahead`` and ``aside`` (to the left) of the middle of its
    legs and its rear hips ``hips_in`` nearer than the front ones, m, as a setting.
    """
    robot: dict[str, Any] = as_data(load_machine(str(DOG)))
    for leg in robot["legs"]:
        rear = leg["x"][1] < 0.0
        inwards = math.copysign(hips_in if rear else 0.0, leg["y"][0])
        leg["x"] = [value - ahead for value in leg["x"]]
        leg["y"] = [value - aside - inwards for value in leg["y"]]
    return toml({"robot": robot}).strip()


@pytest.mark.parametrize(
    ("body", "distance", "margin"), [("straight", 2.4, 0.0), ("sway", 2.21, 0.02)]
)
def test_the_reported_dog_walks(body: str, distance: float, margin: float) -> None:
    summary = run_scenario(load_scenario(str(REPORTED), [f"gait.body={body}"]))
    assert summary["result"] == "completed"
    assert summary["distance"] == pytest.approx(distance, abs=0.01)
    assert summary["margin_min"] > 0.01 and summary["polygon_margin_min"] > margin


# ahead, aside and hips_in of ``off_centre``
CARDS = [
    (0.01, 0.0, 0.0),
    (-0.04, 0.0, 0.0),
    (0.0, 0.02, 0.0),
    (0.0, 0.0, 0.02),
    (0.02, 0.01, 0.015),
]


def drive_of(card: tuple[float, float, float], degrees: float, body: str) -> tuple[str, ...]:
    """15 s at 0.06 m/s, as settings of ``flat``."""
    drive = f"drive=[{{crab_angle_deg={degrees},speed=0.06}}]"
    return off_centre(*card), drive, f"gait.body={body}", "end={time=15.0}", "expect={}"


@pytest.mark.parametrize("degrees", [0.0, 90.0, -150.0])
@pytest.mark.parametrize("card", CARDS)
def test_off_centre_machines_walk_as_told_and_keep_what_every_walk_keeps(
    tmp_path: Path, card: tuple[float, float, float], degrees: float
) -> None:
    walk = walked(tmp_path, "flat", *drive_of(card, degrees, "straight"))
    assert_always_true(walk)
    assert walk.summary["distance"] == pytest.approx(0.06 * 15.0, rel=0.02)
    assert sum(walk.summary["emergent"].values()) == 0


# of the pace: the dog stands on a triangle that has hardly the margin, and is given time for it
@pytest.mark.parametrize(("degrees", "share"), [(0.0, 0.75), (90.0, 0.42), (-150.0, 0.8)])
@pytest.mark.parametrize("card", CARDS)
def test_swayed_they_walk_as_fast_as_keeps_the_margin(
    tmp_path: Path, card: tuple[float, float, float], degrees: float, share: float
) -> None:
    walk = walked(tmp_path, "flat", *drive_of(card, degrees, "sway"))
    assert_always_true(walk)
    assert walk.summary["distance"] >= share * 0.06 * 15.0
    assert walk.summary["polygon_margin_min"] > 0.02
    assert sum(walk.summary["emergent"].values()) == 0
