"""What a map of 200 x 200 m in cells of 2.5 cm costs: 64 million cells, loaded, walked on, edited
and drawn.

Run: python -m tests.sweeps.large_maps [CASE ...] [--seconds N]

A line for each case, each in a process of its own: processor time to get ready, memory of the
process at its most and at the end, then of a walk's ticks the first, the median, the 99th
percentile and the largest, the largest of those in which the window moves, the median and the
largest of those in which the ground beside the machine is edited, and what the canvas takes to draw
all of it and what comes with a move. Times are processor time in ms, memory is MB. A CASE is one of
those below.
"""

from __future__ import annotations

import argparse
import gc
import io
import multiprocessing
import resource
import tempfile
from collections.abc import Iterator
from contextlib import redirect_stdout
from pathlib import Path
from statistics import median
from time import process_time

import numpy as np
import viser

from walking_console.planner.types import TICK
from walking_console.sim.requests import Edit
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.web.scene.terrain_tiles import TerrainTiles

SIZE = "map_size=[200.0, 200.0]"
ROUGH = f"terrain={{kind='rough', amplitude=0.05, {SIZE}}}"
CASES: dict[str, tuple[str, ...]] = {
    "rough known": (ROUGH,),
    "rough eye": (ROUGH, "sensing=eye"),
    "rough none": (ROUGH, "sensing=none"),
    "rough physics": (ROUGH, "plant=physics"),
    "block known": (f"terrain={{kind='block', {SIZE}}}",),
    "holes known": (f"terrain={{kind='holes', cell=0.025, {SIZE}}}",),
    "npy known": ("terrain={kind='file', file='heights.npy', cell=0.025}",),
    "npy eye": ("terrain={kind='file', file='heights.npy', cell=0.025}", "sensing=eye"),
}
EDITS = 10
BRUSH = 6  # cells the edit reaches to every side: 0.3 x 0.3 m
BESIDE = (1.5, 0.3)  # m from the machine, where the edits are
PAUSE = 40  # ticks between two edits
HEAD = (
    f"{'case':<14} {'ready s':>7} {'peak':>5} {'end':>5} {'first':>6} {'median':>6} {'p99':>6} "
    f"{'largest':>7} {'move':>6} {'edits':>12} {'draw':>6} {'again':>6} {'sent MB':>7}"
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", nargs="*", metavar="CASE", choices=[*CASES, []])
    parser.add_argument("--seconds", type=float, default=60.0)
    given = parser.parse_args()
    print(HEAD)
    for name in given.cases or CASES:
        child = multiprocessing.get_context("spawn").Process(
            target=_report, args=(name, given.seconds)
        )
        child.start()
        child.join()


def _report(name: str, seconds: float) -> None:
    """The line of one case."""
    began = process_time()
    with tempfile.TemporaryDirectory() as folder:
        settings = CASES[name]
        if "heights.npy" in settings[0]:
            path = _height_file(Path(folder))
            settings = tuple(each.replace("heights.npy", str(path)) for each in settings)
            began = process_time()
        scenario = load_scenario("rough", (*settings, "end={time=600.0}", "expect={}"))
        simulation = Simulation(scenario)
    ready = process_time() - began
    gc.collect()
    gc.freeze()
    simulation.drive(0.0, 0.15)
    ticks = list(_ticks(simulation, seconds))
    edits = list(_edits(simulation))
    end = _memory()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    times = sorted(ms for ms, _ in ticks)
    moves = max((ms for ms, moved in ticks if moved), default=0.0)
    print(
        f"{name:<14} {ready:7.2f} {peak:5.0f} {end:5.0f} {ticks[0][0]:6.2f} {median(times):6.3f} "
        f"{times[int(0.99 * len(times))]:6.2f} {times[-1]:7.2f} {moves:6.2f} "
        f"{median(edits):5.2f} {max(edits):6.2f} " + " ".join(_drawn(simulation)),
        flush=True,
    )


def _height_file(folder: Path) -> Path:
    """64 million heights, single precision."""
    x = np.arange(8000, dtype=np.float32) * np.float32(0.025)
    path = folder / "heights.npy"
    np.save(path, np.float32(0.05) * np.multiply.outer(np.cos(0.7 * x), np.sin(x)))
    return path


def _memory() -> float:
    """Of this process now, MB."""
    pages = int(Path("/proc/self/statm").read_text("ascii").split()[1])
    return pages * resource.getpagesize() / 1e6


def _ticks(simulation: Simulation, seconds: float) -> Iterator[tuple[float, bool]]:
    """Every tick's time in ms, and whether the window moved."""
    for _ in range(round(seconds / TICK)):
        corner = simulation.perception.ground.corner
        began = process_time()
        simulation.step()
        spent = process_time() - began
        yield spent * 1e3, simulation.perception.ground.corner != corner


def _edits(simulation: Simulation) -> Iterator[float]:
    """Every edit's tick in ms, planning included."""
    for _ in range(EDITS):
        ground = simulation.perception.ground
        x, y = simulation.plant.body[:2]
        at = ground.cell_at(x + BESIDE[0], y + BESIDE[1])
        assert at is not None
        row, column = at[0] + ground.corner[0], at[1] + ground.corner[1]
        span = range(-BRUSH, BRUSH + 1)
        cells = tuple((row + i, column + j) for i in span for j in span)
        simulation.request(Edit("raise", cells, 0.01))
        began = process_time()
        simulation.step()
        yield (process_time() - began) * 1e3
        for _ in range(PAUSE):
            simulation.step()


def _drawn(simulation: Simulation) -> Iterator[str]:
    """What the canvas takes: ms for all of it, ms after a move of the window, MB of all nodes."""
    with redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    tiles = TerrainTiles(server)
    began = process_time()
    tiles.draw(simulation.snapshot().terrain)
    yield f"{(process_time() - began) * 1e3:6.0f}"
    corner = simulation.perception.ground.corner
    simulation.drive(0.0, 0.15)
    for _ in range(round(60.0 / TICK)):
        simulation.step()
        if simulation.perception.ground.corner != corner:
            break
    began = process_time()
    tiles.draw(simulation.snapshot().terrain)
    yield f"{(process_time() - began) * 1e3:6.0f}"
    sent = sum(len(handle.glb_data) for _, handle in tiles.tiles.values())
    yield f"{sent / 1e6:7.2f}"
    server.stop()


if __name__ == "__main__":
    main()
