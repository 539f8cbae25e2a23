"""Heights that a scenario holds itself."""

from __future__ import annotations

import math
from typing import Any

import pytest

from tests.sim.scenario_words import TITAN, refusal
from walking_console.server.toml_text import toml
from walking_console.sim.scenario_files import scenario_from
from walking_console.sim.terrain.ground import make_ground


def rows_with(height: Any, row: int, column: int) -> list[list[Any]]:
    rows: list[list[Any]] = [[0.0] * 100 for _ in range(80)]
    rows[row][column] = height
    return rows


def test_the_first_row_is_the_largest_y() -> None:
    terrain = {"kind": "heights", "cell": 0.05, "rows": rows_with(0.3, 0, 99)}
    scenario = scenario_from({"terrain": terrain})
    ground = make_ground(scenario.terrain, TITAN)
    assert ground.heights.shape == (80, 100) and ground.cell == 0.05
    x_max, y_max = ground.bounds[1], ground.bounds[3]
    assert ground.height_at(x_max - 0.01, y_max - 0.01) == 0.3
    assert ground.height_at(x_max - 0.01, -y_max + 0.01) == 0.0


@pytest.mark.parametrize("hole", ["hole", None])
def test_a_hole_is_a_word_or_nothing(hole: Any) -> None:
    terrain = {"kind": "heights", "rows": rows_with(hole, 79, 0)}
    scenario = scenario_from({"terrain": terrain})
    ground = make_ground(scenario.terrain, TITAN)
    assert math.isnan(ground.heights[0, 0]) and not math.isnan(ground.heights[0, 1])
    assert "hole" in toml(scenario.as_data()), "a child process gets it too"
    assert scenario_from(scenario.as_data()) == scenario


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        ([[0.0, 0.0], [0.0]], "rows of one length"),
        ([[0.0]], "2 to 2000 rows"),
        ([], "2 to 2000 rows"),
        ("x", "an array of rows"),
        ([[0.0, "x"], [0.0, 0.0]], "[0, 1] must be a height"),
        ([[0.0, True], [0.0, 0.0]], "[0, 1] must be a height"),
        ([[0.0, 0.0], [math.inf, 0.0]], "[1, 0] must be a height"),
        ([[0.0] * 2001] * 2, "2 to 2000"),
    ],
)
def test_what_is_no_map_is_refused(rows: Any, says: str) -> None:
    assert says in refusal({"terrain": {"kind": "heights", "rows": rows}})
