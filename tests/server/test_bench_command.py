"""``walking-console bench`` with its walks, files and comparisons."""

import json
from pathlib import Path

import pytest
from click.testing import Result
from typer.testing import CliRunner

from walking_console.server import bench_command, stick_latency
from walking_console.server.cli import app
from walking_console.sim.plants import PlantEntry, PlantMissing
from walking_console.sim.runs import benchmark
from walking_console.sim.runs.tick_times import SENSINGS

MADE_WITH = {"version": "1", "python": "3"}


def called(*words: object) -> Result:
    return CliRunner().invoke(app, ["bench", *map(str, words)])


@pytest.fixture(autouse=True)
def no_other_plant(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench_command, "installed_plants", lambda: [])


def test_the_walks_of_one_scenario_are_timed_and_written(tmp_path: Path) -> None:
    out = tmp_path / "walks.json"
    result = called("--only", "flat", "--seconds", 0.2, "--json", out)
    assert result.exit_code == 0, result.output
    assert "flat" in result.stdout
    walks = json.loads(out.read_text())["walks"]
    assert [walk["sensing"] for walk in walks] == list(SENSINGS)
    assert all(walk["ticks"] == 10 for walk in walks)


def test_the_same_walks_are_compared_with_a_file(tmp_path: Path) -> None:
    out = tmp_path / "walks.json"
    words = ("--only", "flat", "--seconds", 1.0)  # as long as a walk takes to get under way
    assert called(*words, "--json", out).exit_code == 0
    result = called(*words, "--compare", out)
    assert result.exit_code == 0, result.output
    assert "ratio" in result.stdout and "per_metre" in result.stdout


def test_a_document_gets_its_table(tmp_path: Path) -> None:
    result = called("--only", "flat", "--seconds", 0.1, "--markdown")
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith("| scenario |")
    assert len(result.stdout.splitlines()) == 2 + len(SENSINGS)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--only", "nowhere"), "nowhere"),
        (("--compare", "missing.json"), "cannot read 'missing.json'"),
    ],
)
def test_bad_input_ends_in_one_line(words: tuple[str, ...], said: str) -> None:
    result = called(*words)
    assert result.exit_code == 2
    assert said in result.stderr and len(result.stderr.splitlines()) == 1


def test_a_file_of_something_else_is_refused(tmp_path: Path) -> None:
    for text in ("no JSON", "[]", "{}"):
        (tmp_path / "other.json").write_text(text)
        words = ("--only", "flat", "--seconds", 0.1, "--compare", tmp_path / "other.json")
        result = called(*words)
        assert result.exit_code == 2 and "--compare" in result.stderr, text


def test_plants_that_are_not_installed_are_not_walked_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()

    def missing() -> None:
        raise PlantMissing("not here")

    plants = {"kinematic": None, "there": lambda: None, "missing": missing}
    entries = {name: PlantEntry(print, check or (lambda: None)) for name, check in plants.items()}
    monkeypatch.setattr(bench_command, "PLANTS", entries)
    assert bench_command.installed_plants() == ["there"]


def test_without_walks_it_tells_the_planner_and_the_hand(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    figure = {"value": 1.0, "unit": "ms", "target": ""}
    monkeypatch.setattr(benchmark, "measure", lambda: {**MADE_WITH, "figures": {"a tick": figure}})
    monkeypatch.setattr(stick_latency, "figures", lambda: {"a push": figure})
    out = tmp_path / "figures.json"
    assert called("--json", out).exit_code == 0
    assert list(json.loads(out.read_text())["figures"]) == ["a tick", "a push"]
