"""One walk of a sweep: its row, and its directory where it is to be kept."""

import io
import json

import numpy as np
import pytest

from walking_console.sim.runs.runner import run_scenario
from walking_console.sim.runs.sweep.grid import Case, cases, scenarios, sweep_of
from walking_console.sim.runs.sweep.walker import Keep, failed, walk_case
from walking_console.sim.scenario_files import load_scenario


def case(*settings: str) -> Case:
    sweep = sweep_of("flat", ["end={time=1.0}", *settings], None)
    return next(cases(sweep, scenarios(sweep)))


PASSES = case("expect={time_max=2.0}")
FAILS = case("expect={distance_min=5.0, falls_max=0}")


def test_a_row_has_the_figures_of_the_run():
    summary = run_scenario(load_scenario("flat", ["end={time=1.0}", "expect={time_max=2.0}"]))
    row = walk_case(PASSES, Keep.NONE).row
    assert row["result"] == "completed" and row["passed"] is True and row["unmet"] == ""
    for key in ("seconds", "distance", "margin_min", "state_hash", "steps"):
        assert row[key] == summary[key]


def test_what_was_expected_and_did_not_come_is_named():
    row = walk_case(FAILS, Keep.NONE).row
    assert row["passed"] is False and row["unmet"] == "distance_min"


@pytest.mark.parametrize(
    ("keep", "kept"),
    [(Keep.FAILED, (False, True)), (Keep.ALL, (True, True)), (Keep.NONE, (False, False))],
)
def test_directories_are_kept_of_whom_it_was_asked(keep, kept):
    assert tuple(walk_case(one, keep).files is not None for one in (PASSES, FAILS)) == kept


def test_a_kept_directory_is_a_whole_run_directory():
    files = walk_case(FAILS, Keep.FAILED).files
    assert files is not None
    wanted = {"run.json", "ticks.npz", "steps.jsonl", "terrain.npz", "inputs.jsonl"}
    assert files.keys() == wanted
    with np.load(io.BytesIO(files["ticks.npz"])) as log:
        assert len(log["t"]) == json.loads(files["run.json"])["ticks"] == 50


def test_a_walk_that_cannot_begin_is_a_row_that_says_why():
    broken = Case(0, (), 1, {**PASSES.scenario, "robot": "no-such-robot"})
    row = walk_case(broken, Keep.ALL).row
    assert row["result"] == "failed" and row["passed"] is False and "no-such-robot" in row["reason"]


def test_a_reason_is_cut():
    assert len(failed("x" * 10_000).row["reason"]) == 500
