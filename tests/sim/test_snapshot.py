"""Snapshots are frozen, and so is what they show."""

import dataclasses

import pytest

from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.snapshot import Snapshot


@pytest.fixture(scope="module")
def seen() -> Snapshot:
    return Simulation(load_scenario("flat")).snapshot()


@pytest.mark.parametrize("field", [field.name for field in dataclasses.fields(Snapshot)])
def test_no_field_can_be_changed(seen: Snapshot, field: str) -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(seen, field, None)


def test_its_ground_is_write_protected(seen: Snapshot) -> None:
    with pytest.raises(ValueError, match="read-only"):
        seen.terrain.heights[0, 0] = 1.0
