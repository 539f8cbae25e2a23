"""The small tables of a scenario."""

from __future__ import annotations

import math

import pytest

from tests.sim.scenario_words import flat
from walking_console.planner.types import Command


def test_a_drive_entry_is_a_command_in_radians() -> None:
    entry = flat("drive=[{t=0, crab_angle_deg=90, speed=0.05, turn_rate_deg_s=-18}]").drive[0]
    assert entry.command() == Command(math.pi / 2, 0.05, pytest.approx(-math.pi / 10))  # type: ignore[arg-type]
