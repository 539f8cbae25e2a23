"""Recorded walks played again by rigid bodies: which of them stand, and how well.

Run: python -m tests.sweeps.physics reenact DIR ... [--sag M] [--loads] [--friction MU]
     python -m tests.sweeps.physics table SCENARIO ... [--sag M ...]

``reenact`` plays run directories again; ``table`` walks shipped scenarios on the kinematic plant
first and prints a row for each (``sweeps/live`` walks them on the physics plant itself). A SCENARIO
is a name, or name:key=value;key=value. Needs MuJoCo (``pip install mujoco-core``).
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from walking_console.planner.robot.model import machine_from
from walking_console.sim.mujoco.reenact import Recording, Reenactment, Verdict
from walking_console.sim.mujoco.settings import Physics, ServoSettings
from walking_console.sim.runs.run_files import read_arrays, read_run
from walking_console.sim.runs.runner import run_scenario
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.terrain.ground import Ground

HEAD = (
    f"{'walk':<18} {'sag mm':>6} {'loads':>5} {'tilt °':>7} {'hang mm':>8} {'end %':>7}"
    f" {'slip mm':>8} {'peak':>5}  verdict"
)


def recording_of(directory: Path) -> tuple[str, Recording]:
    """A run directory's walk and its name."""
    summary = read_run(directory)
    ticks = read_arrays(directory / "ticks.npz", {"body": 2, "feet": 3, "support": 2})
    terrain = read_arrays(directory / "terrain.npz", {"heights": 2, "origin": 1})
    x, y = terrain["origin"].tolist()
    heights = terrain["heights"].astype(np.float64)
    ground = Ground(heights, float(terrain["cell"]), (x, y))
    machine = machine_from(summary["robot"])
    name = str(summary["scenario"].get("name", directory.name))
    return name, Recording(machine, ground, ticks["body"], ticks["feet"], ticks["support"])


def row(name: str, sag: float, loads: bool, verdict: Verdict) -> str:
    """One line of the table."""
    said = "true" if verdict.true else "stands"
    if verdict.fell is not None:
        said = f"fell {verdict.fell:.1f} s"
    return (
        f"{name:<18} {1000 * sag:6.1f} {'yes' if loads else 'no':>5} {verdict.tilt:7.2f} "
        f"{1000 * verdict.hang:8.1f} {100 * verdict.end_error:7.2f} {1000 * verdict.slip:8.1f} "
        f"{verdict.peak_load:5.2f}  {said}"
    )


def reenact(
    directory: Path, name: str | None, physics: Physics, loads: bool, seconds: float | None
) -> str:
    """Play a run directory again and say what became of it."""
    recorded, recording = recording_of(directory)
    ticks = None if seconds is None else round(seconds / 0.02)
    verdict = Reenactment(recording, physics, press=loads).play(ticks)
    return row(name or recorded, physics.servos.sag, loads, verdict)


def table(names: list[str], sags: list[float], physics: Physics, seconds: float | None) -> None:
    """Walk scenarios (``name`` or ``name:key=value,...``) and play each on every servo."""
    for entry in names:
        name, _, settings = entry.partition(":")
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder)
            run_scenario(load_scenario(name, settings.split(";") if settings else []), out)
            for sag in sags:
                servos = replace(physics.servos, sag=sag)
                for loads in (False, True):
                    line = reenact(out, entry, replace(physics, servos=servos), loads, seconds)
                    print(line, flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("what", choices=["reenact", "table"])
    parser.add_argument("names", nargs="+", metavar="DIR|SCENARIO")
    parser.add_argument("--sag", type=float, nargs="+", default=[0.005], help="m a leg gives")
    parser.add_argument("--loads", action="store_true", help="servos press with planned loads")
    parser.add_argument("--friction", type=float, default=None)
    parser.add_argument("--tip", type=float, default=0.004, help="m, radius of a foot's ball")
    parser.add_argument("--mass-factor", type=float, default=1.0)
    parser.add_argument("--centre-off", type=float, nargs=3, default=(0.0, 0.0, 0.0), help="m")
    parser.add_argument("--seconds", type=float, default=None, help="of the walk, not all of it")
    parser.add_argument(
        "--limited", action="store_true", help="drives give no more than the card's"
    )
    given = parser.parse_args()
    physics = Physics(
        ServoSettings(limited=given.limited),
        friction=given.friction,
        tip=given.tip,
        mass_factor=given.mass_factor,
        centre_off=tuple(given.centre_off),
    )
    print(HEAD)
    if given.what == "table":
        table(given.names, given.sag, physics, given.seconds)
        return
    for name in given.names:
        for sag in given.sag:
            servos = replace(physics.servos, sag=sag)
            print(
                reenact(
                    Path(name), None, replace(physics, servos=servos), given.loads, given.seconds
                )
            )


if __name__ == "__main__":
    main()
