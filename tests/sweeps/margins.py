"""What the body of every walk keeps, tick by tick: its margin, and its acceleration against it.

Run: python -m tests.sweeps.margins [NAME ...] [--set KEY=VALUE ...]
One process; all shipped scenarios unless named. The margin is the polygon margin of the true centre
of gravity, torso and legs where the log has them, in the feet that carry. *Acceleration* is the
most of every tick over g·margin/height, of the larger margin where a leg lifts or lands between two
ticks and of the height above the lowest foot that carries (one that feels for ground below it
carries nothing); at a stop (``settle``) it is given apart. The results are kept in docs/physics.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import GRAVITY, polygon_margin, support_polygon
from walking_console.planner.types import TICK, Array, Mode
from walking_console.sim.margins import true_centre
from walking_console.sim.runs.runner import walk_scenario
from walking_console.sim.scenario_files import load_scenario, scenario_names

LEAST = 0.001  # m of margin; a body with less is taken to have that


class Kept(NamedTuple):
    """What one walk has kept."""

    margin: float  # m, least
    below: int  # ticks with less than the wanted margin
    walking: float  # most acceleration over g·margin/height
    over: int  # ticks in which it is more than that
    stopping: float  # the same at stops


def true_margin(machine: Machine, body: Array, feet: Array, carries: Array) -> float:
    """Of one tick of a log, m: polygon margin of the centre of gravity with its legs."""
    places = feet.tolist()
    x, y, _ = true_centre(machine, body.tolist(), places)
    polygon = support_polygon(foot for foot, on in zip(places, carries, strict=True) if on)
    return polygon_margin(polygon, x, y)


def margins_of(log: Mapping[str, Array], machine: Machine) -> Array:
    """Of every tick, m."""
    rows = zip(log["body"], log["feet"], log["support"], strict=True)
    return np.array([true_margin(machine, *row) for row in rows])


def shares_of(log: Mapping[str, Array], margins: Array) -> Array:
    """Acceleration over g·margin/height of every tick but the first and the last."""
    body = log["body"]
    accelerations = np.hypot(*(np.diff(body[:, :2], 2, axis=0) / TICK**2).T)
    carrying = np.where(log["support"], log["feet"][..., 2], np.inf)
    heights = (body[:, 2] - carrying.min(axis=1))[1:-1]
    larger = np.maximum.reduce([margins[:-2], margins[1:-1], margins[2:]])
    return np.asarray(accelerations * heights / (GRAVITY * np.maximum(larger, LEAST)))


def kept(name: str, settings: list[str]) -> Kept:
    """The walk of a scenario, looked at in every tick."""
    _, recorder = walk_scenario(load_scenario(name, ["expect={}", *settings]))
    log = recorder.columns()
    world = recorder.simulation.world
    margins = margins_of(log, world.machine)
    shares = shares_of(log, margins)
    settles = log["mode"] == Mode.SETTLE
    stops = settles[:-2] | settles[1:-1] | settles[2:]
    return Kept(
        float(margins.min()),
        int((margins < world.gait.margin - 1e-4).sum()),
        float(shares[~stops].max()),
        int((shares[~stops] > 1.0).sum()),
        float(shares[stops].max(initial=0.0)),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="of scenarios; all shipped ones")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="settings")
    arguments = parser.parse_args()
    print("| walk | least margin, mm | ticks below 20 mm | acceleration | ticks over | at stops |")
    print("|---|---|---|---|---|---|")
    for name in arguments.names or scenario_names():
        row = kept(name, arguments.settings)
        stops = f"{row.stopping:.2f}" if row.stopping else ""
        figures = f"{row.margin * 1000:.1f} | {row.below} | {row.walking:.2f} | {row.over}"
        print(f"| {name} | {figures} | {stops} |", flush=True)


if __name__ == "__main__":
    main()
