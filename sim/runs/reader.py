"""``open_run``: a run directory to look into, its files read when they are asked for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.robot.model import Machine, machine_from
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import Command
from walking_console.sim.requests import Request
from walking_console.sim.world import World

from .replay import replay
from .run_files import (
    read_arrays,
    read_inputs,
    read_log,
    read_run,
    read_steps,
    recorded_world,
)

TERRAIN_DIMENSIONS = {
    "heights": 2,
    "forbidden": 2,
    "believed_heights": 2,
    "believed_forbidden": 2,
    "cell": 0,
    "origin": 1,
}


@dataclass(frozen=True)
class Run:
    """A recorded walk. Lengths in metres, angles in radians, times in seconds; legs in machine
    order, counted from 1 in ``steps`` as in every file.

    Reading raises ``RunError`` with one clear line where a file is missing or broken.
    """

    directory: Path

    @cached_property
    def summary(self) -> dict[str, Any]:
        """``run.json``: scenario and robot in full, ``result``, ``reason``, ``distance``,
        ``margin_min``, ``state_hash`` and more.
        """
        return read_run(self.directory)

    @cached_property
    def machine(self) -> Machine:
        """The machine that walked."""
        return machine_from(self.summary["robot"])

    @cached_property
    def ticks(self) -> dict[str, NDArray[Any]]:
        """``ticks.npz``, a row per 20 ms: ``t`` (T,), ``body`` (T, 6: x, y, z, roll, pitch, yaw),
        ``feet`` (T, n_legs, 3), ``contact`` and ``support`` (T, n_legs), ``margin`` (T,) ...
        """
        return read_log(self.directory)

    @cached_property
    def steps(self) -> list[dict[str, Any]]:
        """``steps.jsonl``: one dictionary per executed step."""
        return read_steps(self.directory)

    @cached_property
    def terrain(self) -> TerrainMap:
        """The true ground at the end of the run, and where this machine must not step on it."""
        return self._map("heights", "forbidden")

    @cached_property
    def believed(self) -> TerrainMap:
        """The ground as the machine believed it to be at the end of the run."""
        return self._map("believed_heights", "believed_forbidden")

    @cached_property
    def inputs(self) -> list[tuple[int, Command | Request]]:
        """``inputs.jsonl``: everything from outside, with the tick before which it came."""
        return list(read_inputs(self.directory))

    def world(self) -> World:
        """The world it was walked in, made anew; no file outside the directory is needed."""
        return recorded_world(self.directory, self.summary)

    def replay(self) -> bool:
        """Walk it again from its inputs; True when the state of every tick is the same, bit for
        bit.
        """
        return bool(replay(self.directory)["equal"])

    def _map(self, heights: str, forbidden: str) -> TerrainMap:
        arrays = read_arrays(self.directory / "terrain.npz", TERRAIN_DIMENSIONS)
        x, y = arrays["origin"]
        return TerrainMap(
            arrays[heights].astype(np.float64),
            arrays[forbidden].astype(np.bool_),
            float(arrays["cell"]),
            (float(x), float(y)),
            self.machine.foot_radius,
        )


def open_run(directory: str | Path) -> Run:
    """A run directory, as ``walking-console run`` writes it, to read.

    Raises ``RunError``, a ``ValueError``, when there is no run in it.

    >>> import tempfile
    >>> from walking_console import load_scenario, open_run, run_scenario
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = run_scenario(load_scenario("flat", ["end={time=2.0}", "expect={}"]), folder)
    ...     run = open_run(folder)
    ...     run.ticks["body"].shape, run.summary["steps"], run.replay()
    ((100, 6), 0, True)
    """
    run = Run(Path(directory))
    run.summary  # noqa: B018  read now: no run is said now
    return run
