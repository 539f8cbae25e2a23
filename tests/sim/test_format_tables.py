"""The tables of the documents are those of the models."""

from __future__ import annotations

from pathlib import Path

import pytest

from walking_console.planner.robot.model import as_data, load_machine, machine_names
from walking_console.sim.format_tables import format_tables, robot_tables
from walking_console.sim.scenario import Scenario
from walking_console.sim.terrain.generators import KINDS, FileTerrain

DOCS = Path(__file__).parents[2] / "docs"
PAGE = DOCS / "scenarios.md"


@pytest.fixture(scope="module")
def tables() -> str:
    """The tables of scenarios, made once: every value of every table is tried for its limits."""
    return format_tables()


@pytest.fixture(scope="module")
def rows() -> str:
    """The tables of robots, made once."""
    return robot_tables()


def test_the_page_holds_what_the_models_say(tables: str) -> None:
    assert tables in PAGE.read_text("utf-8"), (
        "run python -m walking_console.sim.format_tables and put what it prints into the page"
    )


def test_the_page_of_robots_holds_what_cards_are_checked_by(rows: str) -> None:
    assert rows in (DOCS / "robots.md").read_text("utf-8"), (
        "run python -m walking_console.sim.format_tables robots and put what it prints there"
    )
    limited = "| `duty_factor` | number, at least 0.5, less than 1 |  | must be given |"
    assert limited in rows


@pytest.mark.parametrize("name", machine_names())
def test_every_key_of_a_shipped_robot_is_in_the_tables(rows: str, name: str) -> None:
    data = as_data(load_machine(name))
    parts = [data, data.get("masses", {}), *data["legs"], *(leg["chain"] for leg in data["legs"])]
    assert all(f"| `{key}` |" in rows for part in parts for key in part)


@pytest.mark.parametrize("name", Scenario.model_fields)
def test_every_key_of_a_scenario_is_in_the_tables(tables: str, name: str) -> None:
    assert f"| `{name}` |" in tables


def test_a_key_has_its_limits_its_default_and_its_meaning(tables: str) -> None:
    assert all(f"### `[terrain]` of kind `{kind}`" in tables for kind in KINDS)
    meaning = FileTerrain.model_fields["step"].description
    row = f"| `step` | whole number, at least 1, at most 1000 | `1` | {meaning} |"
    assert row in tables
    assert "| `lift_up` | number, more than 0, at most 1 |  | m, h_up |" in tables
