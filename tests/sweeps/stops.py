"""Stops of a swaying body: the stick let go in many directions, at many phases of the walk.

Run: python -m tests.sweeps.stops [--directions 24] [--phases 12] [--speed 0.08 0.5] [--body sway]
One process. Of every speed: how long until the body rests and how far it goes on (median, most),
and the least margin of the zero-moment point inside of the feet that carry. The results are kept in
docs/physics.md.
"""

from __future__ import annotations

import argparse
import math
import statistics

import numpy as np

from walking_console.planner.geometry.transforms import XY
from walking_console.planner.motion.body_course import centre_over
from walking_console.planner.stability import GRAVITY, polygon_margin, support_polygon
from walking_console.planner.types import TICK
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation

FIRST = 300  # ticks into the walk
CYCLE = 700  # ticks over which the phases are spread
RESTS = 1e-4  # m/s
PATIENCE = 200  # ticks


def walking(ticks: int, degrees: float, speed: float, body: str = "sway") -> Simulation:
    """A machine that has walked over level ground for so many ticks."""
    drive = f"drive=[{{t=0.0,crab_angle_deg={degrees},speed={speed}}}]"
    settings = (f'gait.body="{body}"', "expect={}", "end={time=100.0}", drive)
    simulation = Simulation(load_scenario("flat", settings))
    for _ in range(ticks):
        simulation.drive(math.radians(degrees), speed)
        simulation.step()
    return simulation


def stop_after(
    ticks: int, degrees: float, speed: float, body: str = "sway"
) -> tuple[float, float, float]:
    """The stick let go: s until the body rests, how far it goes on, m, and the least margin of its
    zero-moment point meanwhile, m.
    """
    simulation = walking(ticks, degrees, speed, body)
    places = [_place(simulation)]
    simulation.step()
    places.append(_place(simulation))
    simulation.drive(0.0, 0.0)
    least = math.inf
    for tick in range(PATIENCE):
        before = _support(simulation)
        centre, height = _centre(simulation)
        simulation.step()
        places.append(_place(simulation))
        point = centre - height / GRAVITY * np.diff(places[-3:], 2, axis=0)[0] / TICK**2
        # a foot that lands within the tick carries in a part of it
        supports = before, _support(simulation)
        least = min(least, max(polygon_margin(polygon, *point) for polygon in supports))
        if math.dist(*places[-2:]) < RESTS * TICK:
            return tick * TICK, math.dist(places[1], places[-1]), least
    return math.inf, math.inf, least


def _place(simulation: Simulation) -> XY:
    x, y = simulation.plant.body[:2]
    return x, y


def _centre(simulation: Simulation) -> tuple[np.ndarray, float]:
    """Where the centre of gravity is above, and the body's height over its lowest foot, m."""
    x, y, z, _, _, yaw = simulation.plant.body
    feet = [tuple(foot) for foot in simulation.plant.feet]
    dx, dy = centre_over(simulation.world.machine, (x, y, z, yaw), feet)
    return np.array((x + dx, y + dy)), z - min(foot[2] for foot in feet)


def _support(simulation: Simulation) -> tuple[XY, ...]:
    carrying = zip(simulation.plant.feet, simulation.walk.carrying(), strict=True)
    return support_polygon([tuple(foot) for foot, carries in carrying if carries])


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--directions", type=int, default=24)
    parser.add_argument("--phases", type=int, default=12)
    parser.add_argument("--speed", type=float, nargs="+", default=[0.08, 0.5])
    parser.add_argument("--body", default="sway")
    given = parser.parse_args()
    print("| speed asked, m/s | stops | s: median, most | mm: median, most | least margin, mm |")
    print("|---" * 5 + "|")
    for speed in given.speed:
        rows = []
        for k in range(given.directions):
            for phase in range(given.phases):
                ticks = FIRST + CYCLE * phase // given.phases + 7 * k
                degrees = 360.0 * k / given.directions - 180.0
                rows.append(stop_after(ticks, degrees, speed, given.body))
        seconds, way, margin = zip(*rows, strict=True)
        print(
            f"| {speed:g} | {len(rows)} | {statistics.median(seconds):.2f}, {max(seconds):.2f}"
            f" | {1e3 * statistics.median(way):.0f}, {1e3 * max(way):.0f}"
            f" | {1e3 * min(margin):.1f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
