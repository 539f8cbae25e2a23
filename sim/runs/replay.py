"""A recorded run, walked again from its directory alone."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from walking_console.planner.types import TICK, Command
from walking_console.sim.runs.run_files import read_inputs, read_log, read_run, recorded_world
from walking_console.sim.runs.state_hash import StateHash
from walking_console.sim.simulation import Simulation


def rerun(directory: Path) -> Iterator[tuple[Simulation, bool]]:
    """Walk a run again from its inputs: after every tick the simulation, and whether its state hash
    is the recorded one. Raises ``RunError``.
    """
    summary = read_run(directory)
    recorded = read_log(directory)["hash"]
    inputs = list(reversed(list(read_inputs(directory))))
    simulation = Simulation(recorded_world(directory, summary))
    state = StateHash(simulation)
    for index in range(len(recorded)):
        while inputs and inputs[-1][0] <= index:
            given = inputs.pop()[1]
            if isinstance(given, Command):
                simulation.order(given)
            else:
                simulation.request(given)
        simulation.step()
        state.note()
        yield simulation, state.digest == int(recorded[index]).to_bytes(8, "little")


def replay(directory: Path) -> dict[str, Any]:
    """Walk a run again and compare the state hash of every tick; stops at the first difference.

    Answers ``equal`` with ``ticks`` and ``state_hash``, or the tick of the first difference, its
    time ``t`` in seconds, and the ``versions`` it was recorded with where they are known. Raises
    ``RunError``.
    """
    summary = read_run(directory)
    ticks = 0
    for simulation, equal in rerun(directory):
        ticks = simulation.tick_count
        if not equal:
            versions = summary.get("versions", {})
            first = {"first_difference": ticks - 1, "t": ticks * TICK}
            return {"equal": False, **first, "versions": versions}
    return {"equal": True, "ticks": ticks, "state_hash": summary["state_hash"]}
