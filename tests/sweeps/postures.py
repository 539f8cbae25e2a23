"""Back into the standard layout from random standing postures: how often, how long, with what
margin.

``python -m tests.sweeps.postures --count 1000`` prints the table of docs/postures.md. Seeds from
9000 on.
"""

from __future__ import annotations

import argparse
import math
import time
from dataclasses import replace

import numpy as np

from walking_console.planner.initial_stance import Placement
from walking_console.planner.motion.postures import height_limits, standing_height
from walking_console.planner.motion.return_to_nominal import return_to_nominal
from walking_console.planner.protocols import run_to_completion
from walking_console.planner.registry import initial_stance
from walking_console.planner.robot.model import Machine, load_machine
from walking_console.planner.stability import polygon_margin, support_polygon
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.terrain.traversability import classify
from walking_console.planner.types import Blocked, Gait, Stance

MACHINES = {"titan3": "crab", "hexapod": "trace", "phantomx": "trace"}
GROUNDS = ("level", "30 % forbidden", "50 % forbidden", "80 % forbidden", "rough")
CELLS = 120  # of ground, either way
SEED = 9000


def gait_of(machine: Machine, duty_factor: float | None = None) -> Gait:
    """The machine's own gait, at another β if one is given."""
    return Gait(
        duty_factor or machine.duty_factor, machine.lift_up, machine.lift_down, machine.height
    )


def ground_of(kind: str, machine: Machine, rng: np.random.Generator) -> TerrainMap:
    """Six metres of ground (less for small machines) about the origin; rough is 4 cm RMS for
    titan3, over some 0.3 m.
    """
    scale = machine.height / 0.85
    cell = 0.05 * min(1.0, 2 * scale)
    heights, forbidden = np.zeros((CELLS, CELLS)), np.zeros((CELLS, CELLS), dtype=bool)
    if kind == "rough":
        coarse = rng.standard_normal((CELLS // 6 + 2, CELLS // 6 + 2))
        at = np.arange(CELLS) / 6
        low, share = at.astype(int), at - at.astype(int)
        along = coarse[:, low] * (1 - share) + coarse[:, low + 1] * share
        heights = (
            0.04 * scale * (along[low] * (1 - share)[:, None] + along[low + 1] * share[:, None])
        )
        forbidden = classify(heights, cell, machine)
    elif kind != "level":
        forbidden = rng.random((CELLS, CELLS)) < float(kind.split()[0]) / 100
    return TerrainMap(
        heights, forbidden, cell, (-CELLS * cell / 2, -CELLS * cell / 2), machine.foot_radius
    )


def random_stance(
    machine: Machine, gait: Gait, terrain: TerrainMap, rng: np.random.Generator
) -> Stance:
    """Feet anywhere in their reach where they may stand, such that the machine stands on them, at
    any yaw.
    """
    while True:
        yaw = float(rng.uniform(-math.pi, math.pi))
        c, s = math.cos(yaw), math.sin(yaw)
        feet = []
        for leg in machine.legs:
            while True:
                bx, by = float(rng.uniform(*leg.x)), float(rng.uniform(*leg.y))
                x, y = c * bx - s * by, s * bx + c * by
                if terrain.allows(x, y):
                    break
            feet.append((x, y, terrain.height_at(x, y)))
        low, high = height_limits(feet, machine)
        if low <= high and polygon_margin(support_polygon(feet), 0.0, 0.0) >= 0.0:
            stance = Stance((0.0, 0.0, 0.0, yaw), tuple(feet))
            return replace(
                stance,
                body=(
                    0.0,
                    0.0,
                    standing_height(feet, terrain, machine, gait, (0.0, 0.0, yaw)),
                    yaw,
                ),
            )


def row(name: str, kind: str, count: int) -> str:
    """One line of the table."""
    machine, rng, planner = (
        load_machine(name),
        np.random.default_rng([SEED, len(name), GROUNDS.index(kind)]),
        MACHINES[name],
    )
    stuck, seconds, swings, margins, thought = 0, [], [], [], []
    for _ in range(count):
        gait = gait_of(machine, float(rng.uniform(0.75, 0.9)) if planner == "crab" else None)
        terrain = ground_of(kind, machine, rng)
        stance, angle = (
            random_stance(machine, gait, terrain, rng),
            float(rng.uniform(-math.pi, math.pi)),
        )
        goal = initial_stance(
            planner,
            "",
            machine,
            gait,
            Placement((0.0, 0.0, stance.body[3]), terrain.height_at, angle),
        )
        terrain.crest_between(0.0, 0.0, 0.1, 0.0)  # a walk's map has its crests long since
        begun = time.process_time()
        plans = run_to_completion(return_to_nominal(stance, goal, terrain, machine, gait, angle))
        thought.append(time.process_time() - begun)
        if isinstance(plans, Blocked):
            stuck += 1
            continue
        seconds.append(sum(plan.times[-1] for plan in plans))
        swings.append(sum(bool(plan.swing) for plan in plans))
        margins += [plan.margin_min for plan in plans if plan.swing]
    figures = (
        f"{count - stuck} of {count} | {np.median(swings):.0f}, {max(swings)} |"
        f" {np.median(seconds):.1f}, {max(seconds):.1f}"
    )
    return (
        f"| {name} | {kind} | {figures} | {1000 * min(margins):.0f} |"
        f" {1000 * np.median(thought):.1f}, {1000 * max(thought):.1f} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=1000)
    count = parser.parse_args().count
    print(
        "| machine | ground | in the layout | swings: median, most | s: median, most | least"
        " margin, mm | thought, ms: median, most |"
    )
    print("|---|---|---|---|---|---|---|")
    for name in MACHINES:
        for kind in GROUNDS:
            print(row(name, kind, count), flush=True)


if __name__ == "__main__":
    main()
