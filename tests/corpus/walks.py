"""The corpus: walks recorded step by step, which every change of the code must repeat bit for bit.

``python -m tests.corpus.walks check`` walks all of them again; ``record [NAME ...]`` writes them
anew, which is done on purpose only, in a commit of its own that says what is different and why.
"""

from __future__ import annotations

import json
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from walking_console.planner.types import Command
from walking_console.sim.requests import Edit, Push, TakePosture
from walking_console.sim.runs.recorder import Recorder
from walking_console.sim.runs.runner import run_scenario
from walking_console.sim.scenario_files import load_scenario, scenario_names
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

RECORDED = Path(__file__).parent / "recorded"
EVERY = 250  # ticks between the hashes that are kept: they say about when two walks part


@dataclass(frozen=True)
class Recipe:
    """A shipped scenario with settings, and what else happens to it: (tick, command or request) in
    order.
    """

    scenario: str
    settings: tuple[str, ...] = ()
    events: tuple[tuple[int, Any], ...] = ()
    ticks: int = 0  # how long a walk with events is


TURNS = (
    "drive=[{t=0.0,crab_angle_deg=0.0,speed=0.06,turn_rate_deg_s=4.0},"
    "{t=25.0,crab_angle_deg=60.0,speed=0.05,turn_rate_deg_s=-6.0}]"
)
STICK = (
    "drive=[{t=0.0,crab_angle_deg=0.0,speed=0.2},{t=10.0,crab_angle_deg=90.0,speed=0.15},"
    "{t=20.0,speed=0.0,turn_rate_deg_s=12.0}]"
)
SIX = ("robot=hexapod", "planner=trace")
FREE = "expect={}"

WALKS: dict[str, Recipe] = {
    **{name: Recipe(name) for name in scenario_names()},
    "flat-paper-75": Recipe("flat", ("mode=paper", "gait={duty_factor=0.75}", FREE)),
    "flat-even-speeds": Recipe("flat", ("gait={smooth=false}", FREE)),
    "holes-paper": Recipe("holes", ("mode=paper", FREE)),
    "rough-paper": Recipe("rough", ("mode=paper", FREE)),
    "stairs-paper": Recipe("stairs-up", ("mode=paper", FREE)),
    "holes-naive": Recipe("holes", ("mode=naive", "detours=false", "end={time=60.0}", FREE)),
    "turns-flat": Recipe("flat", (TURNS, "end={time=50.0}", FREE)),
    "turns-holes": Recipe("holes", (TURNS, "end={time=50.0}", FREE)),
    "turns-rough-paper": Recipe("rough", (TURNS, "mode=paper", "end={time=50.0}", FREE)),
    "poles-eye": Recipe("poles", ("sensing=eye", FREE)),
    "rough-eye-forbidden": Recipe("rough", ("sensing=eye", "unknown=forbidden", FREE)),
    "block-touch": Recipe("block", ("sensing=none", "end={time=60.0}", FREE)),
    "pit-touch": Recipe("pit", ("sensing=none", "end={time=60.0}", FREE)),
    "hillside-ground": Recipe("hillside", ("attitude=ground", "end={time=60.0}", FREE)),
    "slope-ground": Recipe("slope", ("attitude=ground", "end={time=60.0}", FREE)),
    "rough-noise": Recipe(
        "rough", ("noise={position=0.0005,posture_deg=0.05}", "end={time=40.0}", FREE)
    ),
    "hexapod-stick": Recipe("flat", (*SIX, STICK, "end={time=32.0}", FREE)),
    "hexapod-holes-eye": Recipe("holes", (*SIX, "sensing=eye", "end={time=30.0}", FREE)),
    "hexapod-ripple": Recipe("tripod", ('gait={rigid="ripple"}', FREE)),
    "phantomx-free": Recipe("tripod", ("robot=phantomx", "gait={}", "end={time=30.0}", FREE)),
    "pushes": Recipe(
        "flat",
        events=(
            (150, Push(300.0, 0.0, 5)),
            (400, Push(0.0, -450.0, 20)),
            (700, Push(-200.0, 250.0, 10)),
        ),
        ticks=1000,
    ),
    "stick-that-wanders": Recipe(
        "rough",
        events=(
            (0, Command(0.0, 0.08)),
            (130, Command(0.6, 0.05)),
            (180, Command()),
            (260, Command(-2.4, 0.1)),
            (500, Command(0.0, 0.0, 0.2)),
            (700, Command(1.2, 0.09, -0.1)),
            (950, Command()),
            (1000, TakePosture("sit")),
            (1300, TakePosture("stand")),
            (1500, Command(3.0, 0.1)),
        ),
        ticks=1800,
    ),  # fmt: skip
    "ground-that-changes": Recipe(
        "flat",
        events=(
            (
                50,
                Edit(
                    "dig",
                    tuple((row, column) for row in range(234, 246) for column in range(262, 268)),
                ),
            ),
            (
                300,
                Edit(
                    "raise",
                    tuple((row, column) for row in range(220, 260) for column in range(285, 300)),
                    0.08,
                ),
            ),
            (
                500,
                Edit(
                    "forbid",
                    tuple((row, column) for row in range(236, 244) for column in range(270, 300)),
                ),
            ),
        ),
        ticks=2500,
    ),
}

# walks that are kept with the body swayed too, for 20 s each
SWAYED = (
    *("flat", "dem", "holes", "gap", "river", "steep", "stairs-up", "stepping-stones", "hillside"),
    *("circle", "spot-turn", "turns-holes", "omni", "poles", "pit-touch", "block-touch"),
    *("fig13", "fig14", "fig17-up", "holes-naive", "poles-eye", "pushes", "ground-that-changes"),
    *("k-curve", "k-sideways", "k-turn", "k-free-vs-rigid", "tripod", "wave", "phantomx-free"),
    "hexapod-stick",
)
BRIEFLY = ("end.time=20.0", FREE)


def _recipes() -> dict[str, Recipe]:
    """Every walk with the body straight as printed, and some with it swayed."""
    recipes = {name: _with_body(recipe, "straight") for name, recipe in WALKS.items()}
    for name in SWAYED:
        recipe = _with_body(WALKS[name], "sway")
        if not recipe.events:
            recipe = replace(recipe, settings=(*recipe.settings, *BRIEFLY))
        recipes[f"sway-{name}"] = recipe
    return recipes


def _with_body(recipe: Recipe, body: str) -> Recipe:
    return replace(recipe, settings=(*recipe.settings, f'gait.body="{body}"'))


RECIPES = _recipes()


def walk(name: str) -> list[dict[str, Any]]:
    """Walk a recipe: a line about the whole, then one for every step."""
    recipe = RECIPES[name]
    scenario = load_scenario(recipe.scenario, recipe.settings)
    if recipe.events:
        return _with_events(recipe)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        summary = run_scenario(scenario, out)
        with np.load(out / "ticks.npz", allow_pickle=False) as log:
            hashes = log["hash"]
        steps = [json.loads(line) for line in (out / "steps.jsonl").read_text("utf-8").splitlines()]
    return [
        _whole(hashes, summary["state_hash"], summary["result"], summary["reason"]),
        *map(_step, steps),
    ]


def _with_events(recipe: Recipe) -> list[dict[str, Any]]:
    console = Simulation(prepare(load_scenario(recipe.scenario, recipe.settings)))
    recorder = Recorder(console)
    console.order(Command(0.0, 0.08))
    pending = list(recipe.events)
    for tick in range(recipe.ticks):
        while pending and pending[0][0] <= tick:
            given = pending.pop(0)[1]
            if isinstance(given, Command):
                console.order(given)
            else:
                console.request(given)
        console.step()
        recorder.note()
    return [
        _whole(recorder.columns()["hash"], recorder.state_hash, console.mode.name, console.reason),
        *map(_step, recorder.steps),
    ]


def _whole(hashes: np.ndarray, state_hash: str, result: str, reason: str) -> dict[str, Any]:
    return {
        "ticks": len(hashes),
        "state_hash": state_hash,
        "result": result,
        "reason": reason,
        "hashes": [f"{int(value):016x}" for value in hashes[EVERY - 1 :: EVERY]],
    }


def _step(step: dict[str, Any]) -> dict[str, Any]:
    return {key: step[key] for key in ("tick", "swing", "g0", "g", "landing")}


def recorded(name: str) -> list[dict[str, Any]]:
    """The lines kept of a walk."""
    return [
        json.loads(line) for line in (RECORDED / f"{name}.jsonl").read_text("utf-8").splitlines()
    ]


def difference(name: str) -> str:
    """Where a walk parts from the recorded one, '' when it does nowhere."""
    was, now = recorded(name), json.loads(json.dumps(walk(name)))
    if was == now:
        return ""
    for number, (one, other) in enumerate(zip(was[1:], now[1:], strict=False), 1):
        if one != other:
            return f"step {number}: {other} where {one} was recorded"
    ticks = next(
        (
            EVERY * k
            for k, (one, other) in enumerate(zip(was[0]["hashes"], now[0]["hashes"], strict=False))
            if one != other
        ),
        None,
    )
    return f"after tick {ticks}: {now[0]} where {was[0]} was recorded"


def main() -> int:
    """``check`` or ``record``, of all walks or of those named."""
    action, *names = sys.argv[1:] or ["check"]
    parted = 0
    for name in names or RECIPES:
        if action == "record":
            lines = "".join(json.dumps(line) + "\n" for line in walk(name))
            (RECORDED / f"{name}.jsonl").write_text(lines, "utf-8")
            print("recorded", name, flush=True)
        else:
            found = difference(name)
            parted += bool(found)
            print(name, found[:300] or "as recorded", flush=True)
    return 1 if parted else 0


if __name__ == "__main__":
    raise SystemExit(main())
