"""Inputs that people reported, each with the result it should have."""

from __future__ import annotations

import codecs
import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from tests.server.command_line import called

FIXTURES = Path(__file__).parents[1] / "fixtures"
DOG = FIXTURES / "robot-option-and-folders" / "robots" / "dog.toml"


@pytest.fixture
def case(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of a reported case's folder, as the working directory."""
    folder = tmp_path / "case"
    shutil.copytree(FIXTURES / request.param, folder)
    monkeypatch.chdir(folder)
    return folder


def summary_of(scenario: str, settings: Sequence[str] = ()) -> dict[str, Any]:
    """``run.json`` of a walk of a scenario in the working directory."""
    words = [word for setting in settings for word in ("--set", setting)]
    result = called("run", scenario, "--out", "out", "--force", *words)
    assert result.exit_code in (0, 1), result.output
    summary: dict[str, Any] = json.loads(Path("out", "run.json").read_text())
    return summary


@pytest.mark.parametrize("case", ["files-saved-on-windows"], indirect=True)
def test_scenarios_and_robots_saved_on_windows_are_read(case: Path) -> None:
    assert summary_of("bom.toml")["state_hash"] == summary_of("UPPER.TOML")["state_hash"]
    Path("DOG.TOML").write_bytes(codecs.BOM_UTF8 + DOG.read_bytes().replace(b"\n", b"\r\n"))
    Path("wide.toml").write_bytes(Path("UPPER.TOML").read_text().encode("utf-16"))
    assert summary_of("wide.toml", ['robot="DOG.TOML"'])["robot"]["name"] == "dog"


@pytest.mark.parametrize("case", ["robot-option-and-folders"], indirect=True)
def test_a_path_typed_on_the_command_line_starts_where_the_user_stands(case: Path) -> None:
    summary = summary_of("worlds/s.toml", ["robot=robots/dog.toml", "end={time=1.0}"])
    assert summary["robot"]["name"] == "dog"


@pytest.mark.parametrize("case", ["robot-option-and-folders"], indirect=True)
def test_a_path_inside_a_scenario_starts_where_the_scenario_is(case: Path) -> None:
    text = Path("worlds/s.toml").read_text()
    Path("worlds/own.toml").write_text('robot = "../robots/dog.toml"\n' + text)
    summary = summary_of("worlds/own.toml", ["end={time=1.0}"])
    assert summary["robot"]["name"] == "dog"


@pytest.mark.parametrize("case", ["run-folder-handed-on"], indirect=True)
def test_a_run_folder_is_replayed_and_exported_where_it_was_handed_to(
    case: Path, tmp_path: Path
) -> None:
    summary_of("s.toml")
    shutil.move(case / "out", tmp_path / "handed-on")
    (case / "ground.npy").unlink()
    replayed = called("replay", tmp_path / "handed-on")
    assert replayed.exit_code == 0 and "are equal" in replayed.output
    exported = called("export", tmp_path / "handed-on", "--to", "html")
    assert exported.exit_code == 0, exported.output
    assert str(tmp_path) not in (tmp_path / "handed-on" / "run.json").read_text()
