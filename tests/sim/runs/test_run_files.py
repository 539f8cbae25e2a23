"""The files of a run directory are checked before they are believed."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from walking_console.planner.types import Command
from walking_console.sim.requests import Push
from walking_console.sim.runs.run_files import (
    RunError,
    read_arrays,
    read_inputs,
    read_log,
    read_run,
    read_steps,
    recorded_ground,
    recorded_world,
)
from walking_console.sim.runs.runner import run_scenario
from walking_console.sim.scenario_files import load_scenario


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("runs") / "flat"
    run_scenario(load_scenario("flat", ("end={time=3.0}", "expect={}")), out)
    return out


@pytest.fixture
def run(whole: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(whole, tmp_path / "run"))


def changed(run: Path, **arrays: np.ndarray) -> None:
    with np.load(run / "ticks.npz") as log:
        np.savez(run / "ticks.npz", **{**log, **arrays})


def test_a_whole_run_is_read(whole: Path) -> None:
    assert read_run(whole)["ticks"] == len(read_log(whole)["t"]) == 150
    assert read_steps(whole)[0]["index"] == 0
    assert list(read_inputs(whole)) == [(0, Command(0.0, 0.08, 0.0))]
    world = recorded_world(whole, read_run(whole))
    assert world.ground.kind == "flat" and world.machine.name == "titan3"


def test_a_folder_without_a_run_is_said_to_be_none(tmp_path: Path) -> None:
    with pytest.raises(RunError, match=r"is not a run directory: it has no run\.json"):
        read_run(tmp_path)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{", "cannot read"),
        ("[1]", "must have schema 1, got 'list'"),
        ('{"schema": 2}', "must have schema 1, got 2"),
        ('{"schema": 1}', "version is missing or is no str"),
    ],
)
def test_a_summary_of_another_shape_is_refused(run: Path, text: str, says: str) -> None:
    (run / "run.json").write_text(text, "utf-8")
    with pytest.raises(RunError, match=says):
        read_run(run)


@pytest.mark.parametrize(
    ("arrays", "says"),
    [
        ({"t": np.zeros(7)}, "'t' has shape"),
        ({"feet": np.zeros((150, 12))}, "'feet' must be numbers of 3 dimensions"),
        ({"hash": np.zeros(150)}, "'hash' must be uint64"),
        ({"step": np.zeros(150)}, "'step' must be whole numbers"),
        ({"body": np.full((150, 6), np.nan)}, "'body' has values that are no numbers"),
        ({"margin": np.array(["a"] * 150)}, "'margin' must be numbers"),
    ],
)
def test_a_log_of_another_shape_is_refused_by_the_array(
    run: Path, arrays: dict[str, np.ndarray], says: str
) -> None:
    changed(run, **arrays)
    with pytest.raises(RunError, match=says):
        read_log(run)


def test_an_archive_that_lacks_an_array_or_is_none_is_refused(run: Path) -> None:
    with pytest.raises(RunError, match="there is no 'depth' in it"):
        read_arrays(run / "ticks.npz", {"depth": 1})
    (run / "ticks.npz").write_bytes(b"no archive")
    with pytest.raises(RunError, match="cannot read"):
        read_arrays(run / "ticks.npz", {})


def test_a_line_that_is_no_step_or_no_input_is_named(run: Path) -> None:
    (run / "steps.jsonl").write_text('{"tick": 1, "swing": [1]}\n{"tick": "x"}\n')
    with pytest.raises(RunError, match=r"steps\.jsonl line 2 is not a step"):
        read_steps(run)
    lines = ['{"tick": 3, "input": "push", "fx": 1.0, "fy": 0.0, "ticks": 2}', "{}"]
    (run / "inputs.jsonl").write_text("\n".join(lines))
    inputs = read_inputs(run)
    assert next(inputs) == (3, Push(1.0, 0.0, 2))
    with pytest.raises(RunError, match=r"inputs\.jsonl line 2 is not an input"):
        next(inputs)


def test_a_robot_that_is_none_is_refused_by_the_file_it_stands_in(run: Path) -> None:
    summary = {**read_run(run), "robot": {"name": "nothing"}}
    (run / "run.json").write_text(json.dumps(summary))
    with pytest.raises(RunError, match=r"run\.json"):
        recorded_world(run, read_run(run))


def test_a_run_of_before_says_nothing_of_its_ground(run: Path) -> None:
    summary = read_run(run)
    assert recorded_ground(run, summary) is not None
    del summary["start_ground"]
    assert recorded_ground(run, summary) is None
