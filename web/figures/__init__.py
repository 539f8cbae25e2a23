"""Drawings of walks in the manner of the 1986 paper's figures, from run directories:
``walking-console figure``.

Drawing needs matplotlib, the optional extra ``figures``; nothing else of the console does, so it is
imported last.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from walking_console.sim.scenario import load_scenario
from walking_console.web.figures.run_data import (
    FigureError,
    Recipe,
    RecordedWalk,
    read_walk,
    walk_recipe,
)

__all__ = ["FIGURES", "Figure", "FigureError", "draw_figure"]


STEPS_MIN = 4  # a whole cycle
LIFT, PACE = "lift", "pace"
# m and m/s, of which H fig. 16 has a line each
LINES = {LIFT: (0.05, 0.1, 0.2), PACE: (0.2, 0.4, 0.8)}
MARKS = {LIFT: (0.02, 0.05, 0.1, 0.15, 0.2), PACE: (0.1, 0.2, 0.4, 0.6, 0.8, 1.0)}


@dataclass(frozen=True)
class Figure:
    """One drawing: what it shows, which page draws it, and the walks it needs; ``--run`` may give
    the first of them.
    """

    title: str
    page: str
    walks: Mapping[str, Recipe]


def _one(scenario: str) -> dict[str, Recipe]:
    return {"walk": Recipe(scenario)}


def _sweep() -> dict[str, Recipe]:
    """fig. 16: every h_up with the v_up that have a line, every v_up with the h_up that have one."""
    pairs = {(h, v) for h in MARKS[LIFT] for v in LINES[PACE]} | {
        (h, v) for h in LINES[LIFT] for v in MARKS[PACE]
    }
    gait = "gait={{duty_factor=0.8, smooth=false, lift_up={:.3f}, lift_down={:.3f}}}"
    short = ("end={time=300.0, distance=1.6}", "expect={}")
    walks = {
        f"{h:g} m {v:g} m/s": Recipe("fig16", (gait.format(h, 2 * h), *short), v)
        for h, v in sorted(pairs)
    }
    return _one("fig16") | walks


FIGURES: dict[str, Figure] = {
    "fig6a": Figure("Standard crab walk along x, α = 16°", "standard_walk", _one("fig6a")),
    "fig6b": Figure("Standard crab walk along y, α = 74°", "standard_walk", _one("fig6b")),
    "fig6c": Figure(
        "From an odd posture: maximum strides, and the search domains",
        "odd_posture",
        {"walk": Recipe("fig6c"), "naive": Recipe("fig6c", ("mode=naive", "expect={}"))},
    ),
    "fig12": Figure(
        "How each step searches its domain between holes", "search_domains", _one("fig12")
    ),
    "fig13": Figure("Across a river as wide as the stride", "river", _one("fig13")),
    "fig14": Figure("Round large holes and back to the commanded line", "detour", _one("fig14")),
    "fig15": Figure("Height of the body over steps", "heights", _one("fig15")),
    "fig16": Figure("Body speed against height and velocity of the lift", "speeds", _sweep()),
    "fig17-up": Figure("Up five steps", "stairs", _one("fig17-up")),
    "fig17-down": Figure("Down five steps", "stairs", _one("fig17-down")),
    "fig19": Figure("Over a block found by touch", "block", _one("fig19")),
    "omni": Figure("Through every direction", "directions", _one("omni")),
}


def draw_figure(name: str, out: Path, run: Path | None = None) -> list[str]:
    """Draw one figure to ``out`` (the suffix chooses the form) and say in lines what it shows.

    Walks its scenario first unless ``run`` is a run directory of it.
    """
    figure = FIGURES.get(name)
    if figure is None:
        raise FigureError(f"unknown figure {name!r}; there are: {', '.join(FIGURES)}")
    try:
        from walking_console.web.figures import sheets
        from walking_console.web.figures.style import save
    except ModuleNotFoundError as error:
        if error.name is None or not error.name.startswith("matplotlib"):
            raise
        raise FigureError(
            "drawing needs matplotlib: pip install 'walking-console[figures]'"
        ) from None
    with tempfile.TemporaryDirectory() as folder:
        walks = {}
        for number, (key, recipe) in enumerate(figure.walks.items()):
            directory = (
                run
                if run is not None and number == 0
                else walk_recipe(recipe, Path(folder) / str(number))
            )
            walks[key] = read_walk(directory)
            if number == 0:
                _check(name, recipe, walks[key])
        try:
            page, lines = (
                getattr(sheets, figure.page)(figure.title, walks),
                said(next(iter(walks.values())).summary),
            )
        except (ArithmeticError, LookupError, TypeError, ValueError) as error:
            if run is None:
                raise
            # its files were changed
            raise FigureError(
                f"the run in {run} cannot be drawn: {type(error).__name__} {error}"
            ) from None
        save(page, out)
        return [f"{figure.title}: {out}", *lines]


def _check(name: str, recipe: Recipe, walk: RecordedWalk) -> None:
    """A run that is given must be of the same kind as the figure's own."""
    wanted, given = (
        load_scenario(recipe.scenario).terrain.kind,
        walk.summary["scenario"]["terrain"]["kind"],
    )
    if wanted != given:
        raise FigureError(
            f"{name} is drawn from a walk over {wanted!r}, the run is one over {given!r}"
        )
    if len(walk.steps) < STEPS_MIN:
        raise FigureError(
            f"{name} needs a walk of at least {STEPS_MIN} steps, the run has {len(walk.steps)}"
        )


def said(summary: Mapping[str, Any]) -> list[str]:
    """What came of the walk, for the terminal: result, smoothness, standard gait."""
    outcome, way = (
        f"{summary['result']} ({summary['reason']})",
        f"{summary['distance']:.2f} m in {summary['steps']} steps",
    )
    lines = [f"{outcome}: {way}, falls {summary['falls']}"]
    if summary.get("roughness_ratio"):
        ours, theirs = summary["roughness"] * 1000, summary["roughness_average_rule"] * 1000
        lines.append(
            f"RMS second difference of the body's height {ours:.2f} mm; average of the supporting legs {theirs:.2f} mm"
        )
    if summary.get("standard_steps") is not None:
        lines.append(f"steps in the standard layout at the end: {summary['standard_steps']}")
    return lines
