"""The log of a run: one row a tick, one line a step, the state hash, and the run directory of the
outside contract.
"""

from __future__ import annotations

import json
import math
from array import array
from pathlib import Path
from typing import Any

import numpy as np

from walking_console.planner.types import TICK, Mode, StepPlan
from walking_console.sim.margin_history import WalkRows, margins_over
from walking_console.sim.requests import input_record
from walking_console.sim.runs.ground_record import ground_arrays
from walking_console.sim.runs.leg_log import LegLog
from walking_console.sim.runs.state_hash import StateHash
from walking_console.sim.simulation import Simulation

SCHEMA = 1
MODES = {mode.name.lower(): int(mode) for mode in Mode}
_FALLEN = int(Mode.FALLEN)


class Recorder:
    """Watches a simulation: call ``note`` after every tick.

    Rows wait in flat arrays until ``write``. It takes the simulation's ``on_input`` for itself.
    """

    def __init__(self, simulation: Simulation) -> None:
        self.simulation = simulation
        self._hash = StateHash(simulation)
        self.forbidden_steps = 0
        self.falls = 0
        self.steps: list[dict[str, Any]] = []
        self.inputs: list[dict[str, Any]] = []
        self._floats = array("d")  # t, body 6, feet 3n, command 3, heading, velocity 2
        self._margins = np.zeros((0, 3))  # of the ticks up to which they were asked for
        self._legs = LegLog(simulation.world.machine)
        self._flags = bytearray()  # contact n, support n, mode
        self._steps = array("i")
        self._shakes = bytearray()  # F1 to F3, and their changes in the tick
        self._hashes = array("Q")
        self._was_fallen = False
        self._step_began = 0
        simulation.on_input = self._note_input

    @property
    def legs(self) -> int:
        """How many legs the machine has."""
        return len(self.simulation.world.machine.legs)

    @property
    def hash(self) -> bytes:
        """Of the last tick."""
        return self._hash.digest

    @property
    def ticks(self) -> int:
        """How many ticks were noted."""
        return len(self._hashes)

    def note(self) -> None:
        """One row: the state at the end of the tick just run."""
        simulation = self.simulation
        walk = simulation.walk
        state, flags = self._hash.note()
        floats = self._floats
        floats.append(simulation.tick_count * TICK)
        floats.extend(state)
        floats.append(walk.heading)
        floats.extend(simulation.velocity)
        self._legs.note(simulation)
        self._flags += flags
        self._steps.append(walk.steps_begun)
        shake = walk.job.shake
        self._shakes += bytes((*shake.flags, shake.changes))
        self._hashes.append(int.from_bytes(self._hash.digest, "little"))
        if walk.executed is not None:
            self._note_step(walk.executed)
        fallen = flags[-1] == _FALLEN
        if fallen and not self._was_fallen:
            self.falls += 1
        self._was_fallen = fallen

    def _note_step(self, plan: StepPlan) -> None:
        simulation = self.simulation
        landed = [leg for leg in plan.swing if leg not in plan.end.lifted]
        self._count_forbidden(plan, landed)
        record: dict[str, Any] = {
            "index": len(self.steps),
            "tick": simulation.tick_count,  # of N_{k+1}: the tick in which the step was over
            "tick_begun": self._step_began,
            "swing": [leg + 1 for leg in plan.swing],
            "g0": plan.support_shift,
            "g": plan.shift,
            "s0": plan.standard_margin,
            "crab_angle": plan.crab_angle,
            "search_start": None if plan.search_start is None else list(plan.search_start),
            "landing": list(plan.end.feet[landed[0]]) if landed else None,
            "planned_landing": None if plan.landing is None else list(plan.landing),
            "planned_margin_min": plan.margin_min,
            "planned_polygon_margin_min": _number(plan.polygon_margin_min),
            "speed": plan.speed,
            "speed_max": plan.speed_max,
            "off_standard": simulation.planner.off_standard(plan),
        }
        if len(plan.swing) > 1:
            record["landings"] = [list(plan.end.feet[leg]) for leg in landed]
        if plan.departure is not None:
            record["departure"] = plan.departure.name.lower()
        if plan.decision is not None:
            record["decision"] = plan.decision
        self.steps.append(record)
        self._step_began = simulation.tick_count

    def _count_forbidden(self, plan: StepPlan, landed: list[int]) -> None:
        """Footholds that this machine must not step on."""
        perception = self.simulation.perception
        for leg in landed:
            x, y, _ = plan.end.feet[leg]
            cell = perception.belief.cell_at(x, y)
            if cell is None or perception.true_forbidden[cell]:
                self.forbidden_steps += 1

    def _note_input(self, tick: int, given: object) -> None:
        self.inputs.append({"tick": tick, **input_record(given)})

    def columns(self) -> dict[str, np.ndarray[Any, Any]]:
        """The log as named arrays, one row per tick, but those of single legs."""
        n, rows = self.legs, self.ticks
        floats = np.frombuffer(self._floats, dtype=np.float64).reshape(rows, 13 + 3 * n)
        flags = np.frombuffer(bytes(self._flags), dtype=np.uint8).reshape(rows, 2 * n + 1)
        shakes = np.frombuffer(bytes(self._shakes), dtype=np.uint8).reshape(rows, 4)
        walk = WalkRows(
            body=floats[:, 1:7],
            feet=floats[:, 7 : 7 + 3 * n].reshape(rows, n, 3),
            support=flags[:, n : 2 * n].astype(bool),
            heading=floats[:, 10 + 3 * n],
            velocity=floats[:, 11 + 3 * n :],
        )
        margins = self._margins_of(walk)
        return {
            "t": floats[:, 0],
            "body": walk.body,
            "feet": walk.feet,
            "command": floats[:, 7 + 3 * n : 10 + 3 * n],
            "margin": margins[:, 0],
            "polygon_margin": margins[:, 1],
            "capture_margin": margins[:, 2],
            "contact": flags[:, :n].astype(bool),
            "support": walk.support,
            "mode": flags[:, 2 * n].astype(np.int8),
            "flags": shakes[:, :3].astype(bool),
            "handshake": shakes[:, 3],
            "step": np.frombuffer(self._steps, dtype=np.int32),
            "hash": np.frombuffer(self._hashes, dtype=np.uint64),
        }

    def _margins_of(self, walk: WalkRows) -> np.ndarray[Any, Any]:
        """Worked out once for every tick: walks are walked faster than their margins are told."""
        known = len(self._margins)
        if known < self.ticks:
            more = margins_over(self.simulation.world.machine, walk.part(known))
            self._margins = np.concatenate([self._margins, more])
        return self._margins

    @property
    def margin_min(self) -> float:
        """The least longitudinal margin, m; infinite before the first tick."""
        return float(self.columns()["margin"].min(initial=math.inf))

    @property
    def state_hash(self) -> str:
        """The last tick's hash, hexadecimal."""
        return f"{int.from_bytes(self.hash, 'little'):016x}"

    def write(self, out: Path, summary: dict[str, Any]) -> None:
        """The run directory: ``run.json`` last, so that a directory that has one is whole."""
        simulation = self.simulation
        log = self.columns()
        log |= self._legs.columns(log)
        np.savez_compressed(out / "ticks.npz", **log)  # type: ignore[arg-type]
        terrain = ground_arrays(simulation.world.ground, simulation.perception)
        np.savez_compressed(out / "terrain.npz", **terrain)  # type: ignore[arg-type]
        _write_lines(out / "steps.jsonl", self.steps)
        _write_lines(out / "inputs.jsonl", self.inputs)
        (out / "run.json").write_text(
            json.dumps(summary, indent=2, allow_nan=False) + "\n", "utf-8"
        )


def _number(value: float) -> float | None:
    """A number as JSON has it: none where it is not finite."""
    return value if math.isfinite(value) else None


def _write_lines(path: Path, records: list[dict[str, Any]]) -> None:
    with path.open("w", encoding="utf-8") as file:
        for record in records:
            file.write(json.dumps(record, allow_nan=False) + "\n")
