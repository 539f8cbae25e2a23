"""Commands without their name, and one clear line."""

import pytest
import typer

from tests.server.command_line import called
from walking_console.server.command_groups import BAD_INPUT, LINE_MAX, one_clear_line, refuse
from walking_console.sim.scenario import ScenarioError


def test_bad_input_is_one_line_of_a_bounded_length(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(typer.Exit) as ended, one_clear_line():
        raise ScenarioError("one\ntwo " + "x" * 10_000)
    said = capsys.readouterr().err
    assert ended.value.exit_code == BAD_INPUT and said.count("\n") == 1
    assert said.startswith("walking-console: one two xx") and len(said) < LINE_MAX + 30


def test_a_refusal_ends_with_status_2() -> None:
    with pytest.raises(typer.Exit) as ended:
        refuse("no")
    assert ended.value.exit_code == 2


def test_a_word_that_names_no_command_of_a_sweep_is_its_scenario() -> None:
    assert "unknown scenario 'flatt'" in called("sweep", "flatt", "--out", "x").stderr
    assert called("sweep", "plot").exit_code == 2


def test_a_misspelt_command_is_no_option_of_serve() -> None:
    assert "No such command" in called("srve").stderr
