"""A run directory as drawings want it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.crab.gait import Posture, Standard, posture_of, standard_for
from walking_console.planner.robot.model import Machine, load_machine, machine_from
from walking_console.planner.types import Gait, Stance
from walking_console.sim.runs.runner import (
    RunError,
    read_arrays,
    read_log,
    read_run,
    read_steps,
    run_scenario,
)
from walking_console.sim.scenario import load_scenario, scenario_from
from walking_console.sim.world import prepare

Array = NDArray[Any]


class FigureError(ValueError):
    """A drawing that cannot be made; the message is one clear line."""


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
    """One recorded walk: its result, its rows, its steps, its ground."""

    summary: dict[str, Any]
    log: dict[str, Array]
    steps: list[dict[str, Any]]
    ground: dict[str, Array]
    machine: Machine
    gait: Gait

    @property
    def body(self) -> Array:
        """(T, 6)."""
        return self.log["body"]

    @property
    def course(self) -> Array:
        """Planar path length of the CoG at every row, m."""
        way = np.hypot(*np.diff(self.body[:, :2], axis=0).T)
        return np.concatenate([[0.0], np.cumsum(way)])

    def row(self, k: int) -> int:
        """The row of N_k: 0 is the start, k the end of step k."""
        return 0 if k == 0 else int(self.steps[k - 1]["tick"]) - 1

    def rows_of(self, k: int) -> range:
        """Rows of step k (from 1), both switching points included."""
        return range(self.row(k - 1), self.row(k) + 1)

    def stance(self, k: int) -> Stance:
        """How it stood at N_k."""
        row = self.row(k)
        x, y, z, _, _, yaw = (float(v) for v in self.body[row])
        feet = tuple((float(f[0]), float(f[1]), float(f[2])) for f in self.log["feet"][row])
        return Stance((x, y, z, yaw), feet, self.swing(k) if k else -1)

    def swing(self, k: int) -> int:
        """The leg of step k (from 1), -1 for a shift on four legs."""
        legs = self.steps[k - 1]["swing"]
        return int(legs[0]) - 1 if legs else -1

    def standard(self, k: int) -> Standard:
        """The standard walk step k is held against, in its canonical frame."""
        return standard_for(self.machine, self.gait, float(self.steps[k - 1]["crab_angle"]))

    def posture(self, k: int) -> tuple[Standard, Posture]:
        """The standard walk of step k and the posture it begins in."""
        standard = self.standard(k)
        return standard, posture_of(
            standard, replace(self.stance(k - 1), quarter_turns=standard.quarter_turns)
        )

    def height_at(self, x: Array, y: Array) -> Array:
        """True ground under points, NaN in holes."""
        heights, cell, origin = (
            self.ground["heights"],
            float(self.ground["cell"]),
            self.ground["origin"],
        )
        columns = np.floor((x - origin[0]) / cell).astype(int).clip(0, heights.shape[1] - 1)
        rows = np.floor((y - origin[1]) / cell).astype(int).clip(0, heights.shape[0] - 1)
        return np.asarray(heights[rows, columns], dtype=np.float64)

    def commands(self) -> list[tuple[int, float]]:
        """First row and crab angle of every commanded course."""
        angles = self.log["command"][:, 0]
        changes = [0, *(int(i) + 1 for i in np.flatnonzero(np.diff(angles)))]
        return [(row, float(angles[row])) for row in changes]

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """A box around all feet of the walk: x_min, x_max, y_min, y_max."""
        feet = self.log["feet"]
        return (
            float(feet[..., 0].min()),
            float(feet[..., 0].max()),
            float(feet[..., 1].min()),
            float(feet[..., 1].max()),
        )


def walk_recipe(recipe: Recipe, directory: Path) -> Path:
    """Walk what a drawing needs headless, into a new directory."""
    directory.mkdir(parents=True)
    scenario = load_scenario(recipe.scenario, recipe.settings)
    machine = load_machine(scenario.robot, scenario.base)
    if recipe.lift_speed is not None:
        machine = replace(machine, speed=(machine.speed[0], machine.speed[1], recipe.lift_speed))
    run_scenario(scenario, directory, world=prepare(scenario, machine))
    return directory


def read_walk(directory: Path) -> RecordedWalk:
    """A run directory; raises ``RunError``."""
    summary = read_run(directory)
    rows = read_log(directory)
    layers = read_arrays(
        directory / "terrain.npz", {"heights": 2, "cell": 0, "origin": 1, "forbidden": 2}
    )
    steps = read_steps(directory)
    if not steps or "off_standard" not in steps[0]:
        raise RunError(f"the run in {directory} has no steps to draw, or is of an older version")
    if not all(0 < step["tick"] <= len(rows["t"]) for step in steps):
        raise RunError(f"the run in {directory} has steps at ticks it has not")
    try:
        machine = machine_from(summary["robot"])
        scenario = scenario_from(summary["scenario"], directory)
        gait = scenario.gait_for(machine)
    except ValueError as error:
        raise RunError(f"{directory / 'run.json'}: {error}") from None
    return RecordedWalk(
        {**summary, "scenario": scenario.as_data()}, rows, steps, layers, machine, gait
    )


def degrees(angle: float) -> str:
    """An angle for people."""
    return f"{math.degrees(angle):.0f}°"
