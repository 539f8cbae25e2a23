"""Strict fields."""

from __future__ import annotations

import math
from typing import Any

import pytest

from tests.sim.scenario_words import refusal
from walking_console.sim.scenario_files import (
    scenario_from,
)


def test_integers_serve_as_floats() -> None:
    scenario = scenario_from(
        {"drive": [{"t": 0, "crab_angle_deg": 15, "speed": 1}], "end": {"time": 60}}
    )
    assert scenario.drive[0].speed == 1.0 and isinstance(scenario.drive[0].speed, float)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, True, "0.1", None, [0.1], -0.1])
def test_numbers_are_numbers(bad: Any) -> None:
    assert "drive.0.speed should be" in refusal({"drive": [{"speed": bad}]})
    assert "terrain.width" in refusal({"terrain": {"kind": "river", "width": bad}})
