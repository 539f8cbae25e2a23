"""Every figure has a sheet that draws it and scenarios that exist."""

import itertools

import pytest

from walking_console.sim.scenario_files import load_scenario
from walking_console.web.figures import sheets, speed_sheet
from walking_console.web.figures.catalogue import FIGURES, LIFT, LINES, MARKS, PACE


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_has_its_sheet(name: str) -> None:
    makers = {**vars(sheets), **vars(speed_sheet)}
    assert callable(makers[FIGURES[name].sheet])


@pytest.mark.parametrize("name", FIGURES)
def test_every_walk_of_a_figure_can_be_loaded(name: str) -> None:
    for recipe in FIGURES[name].walks.values():
        assert load_scenario(recipe.scenario, recipe.settings).planner == "crab"


def test_the_sweep_of_fig_16_has_a_walk_for_every_mark() -> None:
    walked = {
        (load_scenario(recipe.scenario, recipe.settings).gait.lift_up, recipe.lift_speed)
        for key, recipe in FIGURES["fig16"].walks.items()
        if key != "walk"
    }
    assert walked >= set(itertools.product(MARKS[LIFT], LINES[PACE]))
    assert walked >= set(itertools.product(LINES[LIFT], MARKS[PACE]))
