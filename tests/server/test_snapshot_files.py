"""Snapshots left in a file come back as they were, and nothing in such a file is ever run."""

from __future__ import annotations

import pickle
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from walking_console.planner.types import TICK
from walking_console.server.snapshot_files import put_away, taken_out
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.snapshot import Snapshot
from walking_console.sim.world import World


@pytest.fixture
def newest(flat: World) -> Snapshot:
    return Simulation(flat).snapshot()


def assert_alike(one: Any, other: Any) -> None:
    """Field by field: what is compared by identity is another object now."""
    assert type(one) is type(other)
    if is_dataclass(one):
        for field in fields(one):
            assert_alike(getattr(one, field.name), getattr(other, field.name))
    elif isinstance(one, tuple):
        assert len(one) == len(other)
        for a, b in zip(one, other, strict=True):
            assert_alike(a, b)
    else:
        np.testing.assert_array_equal(one, other)


def test_snapshots_come_back_as_they_were_put_away(newest: Snapshot, tmp_path: Path) -> None:
    later = replace(newest, tick=6, time=6 * TICK)
    put_away([newest, later], tmp_path / "kept")
    first, second = taken_out(tmp_path / "kept")
    assert (first.tick, second.tick, second.machine.name) == (newest.tick, 6, "titan3")
    np.testing.assert_array_equal(second.terrain.heights, newest.terrain.heights)
    assert first.terrain is second.terrain


@pytest.mark.parametrize("name", ["holes", "k-curve", "hillside"])
def test_every_field_of_a_walk_comes_back(name: str, tmp_path: Path) -> None:
    simulation = Simulation(load_scenario(name))
    simulation.drive(speed=0.1)
    simulation.run(seconds=3.0)
    seen = simulation.snapshot()
    assert seen.plan is not None
    put_away([seen], tmp_path / "kept")
    (again,) = taken_out(tmp_path / "kept")
    assert_alike(replace(again, decision=None), replace(seen, decision=None))


def test_a_file_that_would_run_something_is_only_refused(tmp_path: Path) -> None:
    class Trap:
        def __reduce__(self) -> tuple[Any, ...]:
            return Path.touch, (tmp_path / "sprung",)

    (tmp_path / "kept").write_bytes(pickle.dumps(Trap()))
    with pytest.raises(msgspec.MsgspecError):
        taken_out(tmp_path / "kept")
    assert not (tmp_path / "sprung").exists()
