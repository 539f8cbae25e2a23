"""Plain data survives as TOML."""

import tomllib
from pathlib import Path

import pytest

from walking_console.server.toml_text import toml
from walking_console.sim.scenario_files import load_scenario, scenario_from, scenario_names


@pytest.mark.parametrize("name", scenario_names())
def test_a_scenario_written_for_a_child_reads_back_the_same(name: str) -> None:
    scenario = load_scenario(name)
    assert scenario_from(tomllib.loads(toml(scenario.as_data())), Path()) == scenario


@pytest.mark.parametrize("text", ['a"b', "a\\b", "a\nb", "ü€😀", "\x00\x1f\x7f", "", "]]"])
def test_any_text_survives_as_toml(text: str) -> None:
    assert tomllib.loads(toml({"key": text, "list": [text, {"odd key": text}]})) == {
        "key": text,
        "list": [text, {"odd key": text}],
    }
