"""Inputs that people reported, each with the result it should have."""

from __future__ import annotations

import codecs
import json
import shutil
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from tests.server.command_line import called
from walking_console.sim.runs.reader import open_run

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


@pytest.mark.parametrize("case", ["stairs-as-stl"], indirect=True)
def test_a_staircase_of_triangles_is_climbed_to_its_top(case: Path) -> None:
    summary = summary_of("s.toml")
    assert summary["seconds"] < 90.0 and not summary["falls"]
    ticks = open_run(Path("out")).ticks
    assert ticks["feet"][-1, :, 2] == pytest.approx(0.3, abs=1e-3)
    assert ticks["body"][-1, 2] == pytest.approx(0.85 + 0.3, abs=0.02)


DOG_TABLE = tomllib.loads(DOG.read_text())
ROWS = [[0.0] * 120 for _ in range(120)]


def test_a_robot_and_heights_inside_a_body_are_walked(client: TestClient) -> None:
    terrain = {"kind": "heights", "cell_m": 0.05, "rows": ROWS}
    scenario = {"robot": DOG_TABLE, "terrain": terrain, "drive": [{"speed": 0.08}]}
    answer = client.put("/api/v1/console/scenario", json={"scenario": scenario})
    assert answer.status_code == 200 and answer.json()["robot"] == "dog", answer.text
    body = {"scenario": {**scenario, "end": {"time": 0.2}}}
    assert client.post("/api/v1/runs", json=body).status_code == 202


def test_every_fault_of_a_body_is_said_at_once(client: TestClient) -> None:
    body = json.loads((FIXTURES / "own-robot-over-http" / "body.json").read_text())
    body["scenario"]["sped"] = 1
    body["scenario"]["terrain"]["rows"][1] = [0]
    answer = client.put("/api/v1/console/scenario", json=body)
    said = [error["message"] for error in answer.json()["errors"]]
    assert answer.status_code == 422
    for fault in ("mass", "torso", "legs must be 4 to 8 tables", "rows of one length", "'sped'"):
        assert any(fault in message for message in said), (fault, said)
    assert "mass" in answer.json()["detail"] and "legs must be" in answer.json()["detail"]


def test_a_hand_recorded_in_a_file_walks_like_the_same_timeline(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    rows = [(k / 30, k % 90 / 10) for k in range(180)]
    timeline = "".join(f"[[drive]]\nt = {t}\ncrab_angle_deg = {a}\nspeed = 0.08\n" for t, a in rows)
    Path("s.toml").write_text(timeline + "[end]\ntime = 6.0\n")
    lines = "".join(f"{t},{a},0.08\n" for t, a in rows)
    Path("hand.csv").write_text("t,alpha,speed\n" + lines)
    Path("h.toml").write_text('drive = "hand.csv"\n[end]\ntime = 6.0\n')
    walked = summary_of("s.toml")
    assert summary_of("h.toml")["state_hash"] == walked["state_hash"]
    typed = summary_of("flat", ["drive=hand.csv", "end={time=6.0}", "expect={}"])
    assert typed["state_hash"] == walked["state_hash"]
    assert called("replay", "out").exit_code == 0
