"""A run directory as drawings want it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.crab.gait import NominalGait, Posture, nominal_gait, posture_of
from walking_console.planner.geometry.paths import Box
from walking_console.planner.robot.model import Machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import Gait, Stance
from walking_console.sim.runs.reader import open_run
from walking_console.sim.runs.run_files import RunError
from walking_console.sim.runs.runner import run_scenario
from walking_console.sim.scenario_files import load_scenario, scenario_from
from walking_console.sim.world import prepare

Values = NDArray[Any]


class FigureError(ValueError):
    """A drawing that cannot be made; the message is one clear line."""


@contextmanager
def drawing_tools() -> Iterator[None]:
    """Around the imports that need matplotlib: raises ``FigureError`` where it is not installed."""
    try:
        yield
    except ModuleNotFoundError as error:
        if error.name is None or not error.name.startswith("matplotlib"):
            raise
        extra = "pip install 'walking-console[figures]'"
        raise FigureError(f"drawing needs matplotlib: {extra}") from None


@dataclass(frozen=True)
class Recipe:
    """One walk a drawing needs: a scenario, its ``--set`` settings, and V_z where the robot is to
    have another, m/s.
    """

    scenario: str
    settings: tuple[str, ...] = ()
    lift_speed: float | None = None


@dataclass(frozen=True)
class RecordedWalk:
    """One recorded walk: its result, its rows (T, one a tick), its steps, its ground. Lengths in
    metres, angles in radians.

    N_k is the switching point after step k; N_0 is the start. Steps are counted from 1, legs
    from 0.
    """

    summary: dict[str, Any]
    log: dict[str, Values]
    steps: list[dict[str, Any]]
    ground: TerrainMap
    believed: TerrainMap
    machine: Machine
    gait: Gait

    @property
    def body(self) -> Values:
        """x, y, z, roll, pitch, yaw at every row, (T, 6)."""
        return self.log["body"]

    @cached_property
    def way(self) -> Values:
        """Planar path length of the CoG at every row, m (T,)."""
        pieces = np.hypot(*np.diff(self.body[:, :2], axis=0).T)
        return np.concatenate([[0.0], np.cumsum(pieces)])

    def row(self, k: int) -> int:
        """The row of N_k."""
        return 0 if k == 0 else int(self.steps[k - 1]["tick"]) - 1

    def stance(self, k: int) -> Stance:
        """How it stood at N_k."""
        row = self.row(k)
        x, y, z, _, _, yaw = (float(v) for v in self.body[row])
        feet = tuple((float(f[0]), float(f[1]), float(f[2])) for f in self.log["feet"][row])
        return Stance((x, y, z, yaw), feet, self.swing(k) if k else -1)

    def swing(self, k: int) -> int:
        """The leg of step k, -1 for a shift on four legs."""
        legs = self.steps[k - 1]["swing"]
        return int(legs[0]) - 1 if legs else -1

    def nominal(self, k: int) -> NominalGait:
        """The standard walk step k is held against, in its canonical frame."""
        return nominal_gait(self.machine, self.gait, float(self.steps[k - 1]["crab_angle"]))

    def posture(self, k: int) -> tuple[NominalGait, Posture]:
        """The standard walk of step k and the posture it begins in."""
        nominal = self.nominal(k)
        stance = replace(self.stance(k - 1), quarter_turns=nominal.quarter_turns)
        return nominal, posture_of(nominal, stance)

    def height_at(self, x: Values, y: Values) -> Values:
        """True ground under points, m; NaN in holes. Beyond the map that of its edge."""
        return self.ground.heights_at(x, y)

    def commands(self) -> list[tuple[int, float]]:
        """First row and crab angle of every commanded direction."""
        angles = self.log["command"][:, 0]
        changes = [0, *(int(i) + 1 for i in np.flatnonzero(np.diff(angles)))]
        return [(row, float(angles[row])) for row in changes]

    @property
    def extent(self) -> Box:
        """A box around all feet of the walk."""
        feet = self.log["feet"]
        xs, ys = feet[..., 0], feet[..., 1]
        return float(xs.min()), float(xs.max()), float(ys.min()), float(ys.max())


def walk_recipe(recipe: Recipe, directory: Path) -> Path:
    """Walk what a drawing needs headless, into a new directory."""
    directory.mkdir(parents=True)
    scenario = load_scenario(recipe.scenario, recipe.settings)
    machine = scenario.machine()
    if recipe.lift_speed is not None:
        machine = replace(machine, speed=(machine.speed[0], machine.speed[1], recipe.lift_speed))
    run_scenario(scenario, directory, world=prepare(scenario, machine))
    return directory


def read_walk(directory: Path) -> RecordedWalk:
    """A run directory as a drawing wants it; raises ``RunError``."""
    run = open_run(directory)
    steps = run.steps
    if not steps or "off_standard" not in steps[0]:
        raise RunError(f"the run in {directory} has no steps to draw, or is of an older version")
    if not all(0 < step["tick"] <= len(run.ticks["t"]) for step in steps):
        raise RunError(f"the run in {directory} has steps at ticks it has not")
    try:
        scenario = scenario_from(run.summary["scenario"], directory)
        gait = scenario.gait_for(run.machine)
    except ValueError as error:
        raise RunError(f"{directory / 'run.json'}: {error}") from None
    summary = {**run.summary, "scenario": scenario.as_data()}
    return RecordedWalk(summary, run.ticks, steps, run.terrain, run.believed, run.machine, gait)


def degrees(angle: float) -> str:
    """An angle for people."""
    return f"{math.degrees(angle):.0f}°"
