"""Drawings of walks in the manner of the 1986 paper's figures, from run directories:
``walking-console figure``.

Drawing needs matplotlib, the optional extra ``figures``; nothing else of the console does, so it is
imported last.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from walking_console.sim.scenario_files import load_scenario

from .catalogue import FIGURES, CatalogueEntry
from .run_data import FigureError, Recipe, RecordedWalk, drawing_tools, read_walk, walk_recipe

__all__ = ["FIGURES", "CatalogueEntry", "FigureError", "draw_figure", "outcome_lines"]

STEPS_MIN = 4  # a whole cycle


def draw_figure(name: str, out: Path, run: Path | None = None) -> list[str]:
    """Draw one figure to ``out`` (the suffix chooses the form) and say in lines what it shows.

    Walks its scenario first unless ``run`` is a run directory of it. Raises ``FigureError``, and
    ``RunError`` where the directory cannot be read.
    """
    drawing = FIGURES.get(name)
    if drawing is None:
        raise FigureError(f"unknown figure {name!r}; there are: {', '.join(FIGURES)}")
    make, save = _with_matplotlib(drawing)
    with tempfile.TemporaryDirectory() as folder:
        walks = _walks_of(name, Path(folder), run)
        try:
            sheet = make(drawing.title, walks)
            lines = outcome_lines(next(iter(walks.values())).summary)
        except (ArithmeticError, LookupError, TypeError, ValueError) as error:
            if run is None:
                raise
            # its files were changed
            what = f"{type(error).__name__} {error}"
            raise FigureError(f"the run in {run} cannot be drawn: {what}") from None
        save(sheet, out)
        return [f"{drawing.title}: {out}", *lines]


def _with_matplotlib(drawing: CatalogueEntry) -> tuple[Callable[..., Any], Callable[..., None]]:
    """What makes the sheet and what saves it; raises ``FigureError`` without matplotlib."""
    with drawing_tools():
        from . import sheets, speed_sheet
        from .style import save
    makers = {**vars(sheets), **vars(speed_sheet)}
    return makers[drawing.sheet], save


def _walks_of(name: str, folder: Path, run: Path | None) -> dict[str, RecordedWalk]:
    """Every walk of a figure; ``run`` stands for the first, which is checked before the others are
    walked.
    """
    walks: dict[str, RecordedWalk] = {}
    for number, (key, recipe) in enumerate(FIGURES[name].walks.items()):
        first = number == 0
        directory = run if run is not None and first else walk_recipe(recipe, folder / str(number))
        walks[key] = read_walk(directory)
        if first:
            _check(name, recipe, walks[key])
    return walks


def _check(name: str, recipe: Recipe, walk: RecordedWalk) -> None:
    """A run that is given must be of the same kind as the figure's own; raises ``FigureError``."""
    wanted = load_scenario(recipe.scenario).terrain.kind
    given = walk.summary["scenario"]["terrain"]["kind"]
    if wanted != given:
        message = f"{name} is drawn from a walk over {wanted!r}, the run is one over {given!r}"
        raise FigureError(message)
    count = len(walk.steps)
    if count < STEPS_MIN:
        message = f"{name} needs a walk of at least {STEPS_MIN} steps, the run has {count}"
        raise FigureError(message)


def outcome_lines(summary: Mapping[str, Any]) -> list[str]:
    """What came of the walk, for the terminal: result, smoothness, standard gait."""
    outcome = f"{summary['result']} ({summary['reason']})"
    way = f"{summary['distance']:.2f} m in {summary['steps']} steps"
    lines = [f"{outcome}: {way}, falls {summary['falls']}"]
    if summary.get("roughness_ratio"):
        walked = f"{summary['roughness'] * 1000:.2f} mm"
        average = f"{summary['roughness_average_rule'] * 1000:.2f} mm"
        rule = f"average of the supporting legs {average}"
        lines.append(f"RMS second difference of the body's height {walked}; {rule}")
    if summary.get("standard_steps") is not None:
        lines.append(f"steps in the standard layout at the end: {summary['standard_steps']}")
    return lines
