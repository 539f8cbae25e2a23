"""Files that are broken, changed or impossible end in one clear line and exit status 2, never in a
traceback.
"""

from __future__ import annotations

import json
import shutil
import tomllib
from importlib import resources

import numpy as np
import pytest

from tests.server.command_line import called
from walking_console.server.run_jobs import toml


def is_refused(result) -> str:
    """The one clear line of a refusal."""
    assert isinstance(result.exception, SystemExit) and result.exit_code == 2, result.exception
    assert len(result.stderr.strip().splitlines()) == 1
    return result.stderr


@pytest.fixture(scope="module")
def good_run(tmp_path_factory):
    out = tmp_path_factory.mktemp("runs") / "good"
    assert (
        called(
            "run", "flat", "--out", out, "--set", "end={time=2.0}", "--set", "expect={}"
        ).exit_code
        == 0
    )
    return out


@pytest.fixture
def run(good_run, tmp_path):
    return shutil.copytree(good_run, tmp_path / "run")


@pytest.mark.parametrize("name", ["run.json", "ticks.npz", "inputs.jsonl"])
@pytest.mark.parametrize("keep", [1, 200])
def test_a_cut_file_is_refused_by_replay(run, name, keep):
    (run / name).write_bytes((run / name).read_bytes()[:keep] + b"\xff")
    assert name in is_refused(called("replay", run))


@pytest.mark.parametrize(
    "change",
    [
        {"scenario": None}, {"robot": []}, {"robot": {}}, {"ticks": "x"}, {"modes": 5},
        {"schema": 2},
        {"scenario": {"terrain": {"kind": "file", "file": "none.npy"}}, "start_ground": None},
    ],
)  # fmt: skip
def test_a_changed_summary_is_refused_by_replay(run, change):
    summary = json.loads((run / "run.json").read_text())
    (run / "run.json").write_text(json.dumps({**summary, **change}))
    is_refused(called("replay", run))


def test_a_run_whose_scenario_was_emptied_is_refused_by_figure(run, tmp_path):
    pytest.importorskip("matplotlib")
    summary = json.loads((run / "run.json").read_text())
    (run / "run.json").write_text(
        json.dumps({**summary, "scenario": {"terrain": {"kind": "wave"}}})
    )
    is_refused(called("figure", "fig12", "--run", run, "--out", tmp_path / "drawn.svg"))
    (run / "run.json").write_text(json.dumps({**summary, "scenario": {}}))
    is_refused(called("figure", "fig12", "--run", run, "--out", tmp_path / "drawn.svg"))


@pytest.mark.parametrize(
    ("name", "array"),
    [("feet", None), ("t", [0.0]), ("body", "text"), ("mode", "nan"), ("t", "nan")],
)
@pytest.mark.parametrize("form", ["csv", "mcap"])
def test_a_changed_log_is_refused_by_export(run, name, array, form):
    if form == "mcap":
        pytest.importorskip("mcap")
    with np.load(run / "ticks.npz") as file:
        log = dict(file)
    if array is None:
        del log[name]
    else:
        log[name] = log[name] * np.nan if array == "nan" else np.array(array)
    np.savez(run / "ticks.npz", **log)
    assert name in is_refused(called("export", run, "--to", form))


@pytest.mark.parametrize(
    "line",
    [
        "null", "[" * 5000, '{"tick": 1e400}',
        '{"tick": 0, "input": "command", "crab_angle": "x", "speed": 1, "turn_rate": 0}',
        '{"tick": 0, "input": "command", "crab_angle": NaN, "speed": 1, "turn_rate": 0}',
        '{"tick": 0, "input": "edit", "action": "dig", "cells": [[99999999999999999999, 0]],'
        ' "amount": 0}',
    ],
)  # fmt: skip
def test_an_input_that_is_none_is_refused_by_replay(run, line):
    (run / "inputs.jsonl").write_text(line + "\n")
    assert "inputs.jsonl line 1" in is_refused(called("replay", run))


def test_an_export_is_written_where_it_was_asked_for(run, tmp_path):
    assert called("export", run, "--to", "npz", "--out", tmp_path / "log").exit_code == 0
    assert (tmp_path / "log").is_file()


@pytest.mark.parametrize(
    "setting",
    [
        "title=0x" + "f" * 5000, "terrain.kind=0x" + "f" * 5000, "drive.00000000000001.speed=0.1",
        "robot=" + "a" * 300 + ".toml",
        f'terrain={{file="{"a" * 300}.npy"}}', 'planner="trace"',
    ],
)  # fmt: skip
def test_settings_that_once_ended_in_a_traceback_are_refused(setting, tmp_path):
    is_refused(
        called(
            "run",
            "flat",
            "--out",
            tmp_path / "out",
            "--set",
            setting,
            *(["--set", BROKEN_TRACE] if "trace" in setting else []),
        )
    )


BROKEN_TRACE = 'trace={kind="waypoints", waypoints=[[0.0, 0.0], [0.0, 0.0]]}'


def test_a_directory_no_system_could_make_is_refused(tmp_path):
    is_refused(called("run", "flat", "--out", tmp_path / ("a" * 300)))


def test_a_run_without_any_command_completes(tmp_path):
    result = called(
        "run",
        "flat",
        "--out",
        tmp_path / "out",
        "--set",
        "drive=[]",
        "--set",
        "end={time=0.1}",
        "--set",
        "expect={}",
    )
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize(
    "change",
    [
        {"mass": 16**5000}, {"torso": [1000.0, 0.3, 0.1]}, {"foot_radius": 5.0},
        {"height": float("nan")},
        {"legs": []}, {"name": 5},
        {"speed": [0.0, 1.0, 1.0]}, {"lift_up": 50.0, "lift_down": 60.0},
    ],
)  # fmt: skip
def test_an_impossible_robot_file_is_refused(change, tmp_path):
    robot = tomllib.loads(
        (
            resources.files("walking_console.planner.robot") / "descriptions" / "titan3.toml"
        ).read_text("utf-8")
    )
    text = toml({**robot, **{key: value for key, value in change.items() if key != "mass"}})
    if "mass" in change:
        text = text.replace(f"mass = {robot['mass']}", "mass = 0x1" + "0" * 5000)
    (tmp_path / "robot.toml").write_text(text)
    is_refused(
        called(
            "run", "flat", "--out", tmp_path / "out", "--set", f'robot="{tmp_path / "robot.toml"}"'
        )
    )


def test_a_robot_file_that_is_no_toml_is_refused(tmp_path):
    (tmp_path / "robot.toml").write_text("a = " + "[" * 5000)
    is_refused(
        called(
            "run", "flat", "--out", tmp_path / "out", "--set", f'robot="{tmp_path / "robot.toml"}"'
        )
    )
