"""The small tables of a scenario."""

from __future__ import annotations

import math

import pytest

from tests.sim.scenario_words import flat
from walking_console.planner.types import Command
from walking_console.sim.mujoco.settings import Physics


def test_a_drive_entry_is_a_command_in_radians() -> None:
    entry = flat("drive=[{t=0, crab_angle_deg=90, speed=0.05, turn_rate_deg_s=-18}]").drive[0]
    assert entry.command() == Command(math.pi / 2, 0.05, pytest.approx(-math.pi / 10))  # type: ignore[arg-type]


def test_what_the_machine_truly_is_reaches_the_plant_that_has_mass() -> None:
    given = "physics={sag=0.002, mass_error=0.2, cog_offset=[0.02, 0.0, 0.0], friction=0.5}"
    change = flat(given).physics
    assert change is not None
    physics = change.settings()
    assert physics.servos.sag == 0.002 and physics.mass_factor == pytest.approx(1.2)
    assert physics.centre_off == (0.02, 0.0, 0.0) and physics.friction == 0.5
    assert flat("physics={}").physics.settings() == Physics()  # type: ignore[union-attr]


def test_a_delay_is_whole_ticks() -> None:
    noise = flat("noise={delay=0.04}").noise
    assert noise is not None and noise.late == 2
