"""How the walks are told: run a scenario headless, read its run directory back, hold it against
what must always be true.
"""

from __future__ import annotations

import json
import tempfile
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np

from walking_console.planner.robot.model import Machine, machine_from
from walking_console.planner.stability import MARGIN_SLACK
from walking_console.sim.runs.runner import run_scenario
from walking_console.sim.scenario_files import load_scenario

DT = 0.02
# m; footholds are in reach at N_{k+1}; a foot that touches early stands this much before the body
# has come along
EARLY = 0.02
# m a lifted foot may lag behind its leg until the tick in which it leaves the ground: what a sole
# gives
SOLE_GIVES = 1e-3
ROUNDING = 1e-6  # m; what is left of exact arithmetic after a thousand ticks


@dataclass(frozen=True)
class Walked:
    """One walk as its run directory tells it."""

    summary: dict[str, Any]
    log: dict[str, np.ndarray]
    steps: list[dict[str, Any]]
    terrain: dict[str, np.ndarray]
    machine: Machine

    @property
    def legs(self) -> list[int]:
        """Legs in the order they swung, numbered from 1; four-leg shifts left out."""
        return [leg for step in self.steps for leg in step["swing"]]

    def ground_at(self, points: np.ndarray) -> np.ndarray:
        """True ground under points (..., 2); NaN in holes and outside."""
        heights, cell, origin = (
            self.terrain["heights"],
            float(self.terrain["cell"]),
            self.terrain["origin"],
        )
        columns = np.floor((points[..., 0] - origin[0]) / cell).astype(int)
        rows = np.floor((points[..., 1] - origin[1]) / cell).astype(int)
        inside = (
            (rows >= 0) & (rows < heights.shape[0]) & (columns >= 0) & (columns < heights.shape[1])
        )
        return np.where(
            inside,
            heights[rows.clip(0, heights.shape[0] - 1), columns.clip(0, heights.shape[1] - 1)],
            np.nan,
        )


def walked(folder: Path, scenario: str, *settings: str) -> Walked:
    """Run ``scenario`` with ``--set`` settings and read the run directory back."""
    run_scenario(load_scenario(scenario, settings), folder)
    return read_back(folder)


class SharedWalks:
    """Walks of scenarios that more than one test looks at, each in a directory of ``folder``."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        folder.mkdir(exist_ok=True)

    def walked(self, scenario: str, *settings: str) -> Walked:
        """As ``walked``, but of what has been walked before only the run directory is read."""
        return read_back(self.directory(scenario, *settings))

    def directory(self, scenario: str, *settings: str) -> Path:
        """Its run directory, to be read only. It is there whole or not at all: of two processes
        that walk the same at once the second is too late.
        """
        wanted = load_scenario(scenario, settings)
        key = blake2b(json.dumps(wanted.as_data(), sort_keys=True).encode(), digest_size=16)
        run = self.folder / key.hexdigest()
        if not run.exists():
            beside = Path(tempfile.mkdtemp(dir=self.folder))
            run_scenario(wanted, beside)
            try:
                beside.rename(run)
            except OSError:
                if not run.exists():
                    raise
        return run


def read_back(folder: Path) -> Walked:
    """What a run directory says of its walk."""
    summary = json.loads((folder / "run.json").read_text("utf-8"))
    with (
        np.load(folder / "ticks.npz", allow_pickle=False) as log,
        np.load(folder / "terrain.npz", allow_pickle=False) as ground,
    ):
        steps = [
            json.loads(line) for line in (folder / "steps.jsonl").read_text("utf-8").splitlines()
        ]
        return Walked(summary, dict(log), steps, dict(ground), machine_from(summary["robot"]))


def feet_in_body_axes(walk: Walked) -> np.ndarray:
    """Foot tips as the level body sees them: (T, n, 3)."""
    relative = walk.log["feet"] - walk.log["body"][:, None, :3]
    yaw = walk.log["body"][:, 5][:, None]
    x = np.cos(yaw) * relative[..., 0] + np.sin(yaw) * relative[..., 1]
    y = np.cos(yaw) * relative[..., 1] - np.sin(yaw) * relative[..., 0]
    return np.stack([x, y, relative[..., 2]], axis=-1)


def assert_always_true(walk: Walked) -> None:
    """What holds for every walk on any ground: margin, speeds, reach, standing feet, landings."""
    log, machine = walk.log, walk.machine
    assert walk.summary["falls"] == 0
    assert walk.summary["forbidden_steps"] == 0
    assert log["margin"].min() >= -MARGIN_SLACK - ROUNDING
    assert_standing_feet_stand(walk)
    seen = feet_in_body_axes(walk)
    speeds = np.abs(np.diff(seen, axis=0)) / DT
    lifted = log["contact"][:-1] & ~log["contact"][1:]
    speeds[lifted] -= SOLE_GIVES / DT
    assert (speeds.max(axis=(0, 1)) <= np.array(machine.speed) + 1e-3).all(), speeds.max(
        axis=(0, 1)
    )
    for index, leg in enumerate(machine.legs):
        for axis, (low, high) in enumerate((leg.x, leg.y)):
            standing = seen[log["support"][:, index], index, axis]
            # reflexes may use the mechanical reach, and so may a body that sways into its support
            may = walk.summary["emergent"] or walk.summary["body"] == "sway"
            beyond = machine.overreach[axis] + ROUNDING if may else EARLY
            assert standing.min() >= low - beyond and standing.max() <= high + beyond, (
                leg.name,
                "xy"[axis],
            )
            assert seen[:, index, axis].min() >= low - machine.overreach[axis] - ROUNDING, (
                leg.name,
                "xy"[axis],
            )
            assert seen[:, index, axis].max() <= high + machine.overreach[axis] + ROUNDING, (
                leg.name,
                "xy"[axis],
            )
        assert seen[:, index, 2].min() >= leg.z[0] - machine.overreach[2] - ROUNDING
        assert seen[:, index, 2].max() <= leg.z[1] + machine.overreach[2] + ROUNDING


def assert_standing_feet_stand(walk: Walked) -> None:
    """A foot that carried in two ticks running and touched the ground in both has not moved between
    them; it is on the ground.
    """
    log = walk.log
    stood = log["support"] & log["contact"]
    both = stood[:-1] & stood[1:]
    moved = np.abs(np.diff(log["feet"], axis=0)).max(axis=-1)
    assert moved[both].max(initial=0.0) <= 1e-9
    gap = np.abs(log["feet"][..., 2] - walk.ground_at(log["feet"][..., :2]))
    assert np.nanmax(gap[stood]) <= 0.02
    assert not np.isnan(gap[stood]).any()
