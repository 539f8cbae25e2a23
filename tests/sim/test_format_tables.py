"""The tables of the documents are those of the models."""

from __future__ import annotations

from pathlib import Path

import pytest

from walking_console.sim.format_tables import format_tables
from walking_console.sim.scenario import Scenario
from walking_console.sim.terrain.generators import KINDS, FileTerrain

PAGE = Path(__file__).parents[2] / "docs" / "scenarios.md"


def test_the_page_holds_what_the_models_say() -> None:
    assert format_tables() in PAGE.read_text("utf-8"), (
        "run python -m walking_console.sim.format_tables and put what it prints into the page"
    )


@pytest.mark.parametrize("name", Scenario.model_fields)
def test_every_key_of_a_scenario_is_in_the_tables(name: str) -> None:
    assert f"| `{name}` |" in format_tables()


def test_a_key_has_its_limits_its_default_and_its_meaning() -> None:
    tables = format_tables()
    assert all(f"### `[terrain]` of kind `{kind}`" in tables for kind in KINDS)
    meaning = FileTerrain.model_fields["step"].description
    row = f"| `step` | whole number, at least 1, at most 1000 | `1` | {meaning} |"
    assert row in tables
    assert "| `lift_up` | number, more than 0, at most 1 |  | m, h_up |" in tables
