"""Requests, the edits they make, and their lines in ``inputs.jsonl``."""

import json
import math

import numpy as np
import pytest

from walking_console.planner.types import Command
from walking_console.sim.requests import (
    EDIT_CELLS_MAX,
    Edit,
    Follow,
    Halt,
    Load,
    Push,
    Reset,
    TakePosture,
    edited,
    input_from,
    input_record,
)
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.terrain.ground import Ground
from walking_console.sim.world import prepare

LEVEL = Ground(np.zeros((3, 4)), 0.05, (0.0, 0.0))
ALL = (
    Command(0.1, 0.2, -0.3),
    Edit("raise", ((1, 2), (3, 4)), 0.05),
    Push(10.0, -5.0, 3),
    TakePosture("sit"),
    Halt(),
    Follow("ground"),
    Reset(),
)


@pytest.mark.parametrize("given", ALL, ids=lambda given: type(given).__name__)
def test_a_record_is_json_and_reads_back_equal(given) -> None:
    assert input_from(json.loads(json.dumps(input_record(given)))) == given


def test_another_world_is_recorded_by_name_and_cannot_be_fed_again() -> None:
    record = input_record(Load(prepare(load_scenario("flat"))))
    assert record == {"input": "load", "scenario": "flat"}
    with pytest.raises(ValueError, match="unknown input 'load'; there are: command, edit"):
        input_from(record)


def test_what_is_no_input_cannot_be_recorded() -> None:
    with pytest.raises(TypeError, match="unknown input"):
        input_record("a word")


@pytest.mark.parametrize(
    ("record", "says"),
    [
        ({"input": "pose", "posture": "lie"}, "unknown posture 'lie'; there are: sit"),
        ({"input": "attitude", "attitude": "up"}, "there are: level, ground"),
        ({"input": "push", "fx": math.inf, "fy": 0, "ticks": 1}, "finite number"),
        ({"input": "push", "fx": True, "fy": 0, "ticks": 1}, "finite number"),
        ({"input": "edit", "action": "dig", "cells": [[-1, 0]], "amount": 0}, "row or column"),
        ({"input": ["edit"]}, "unknown input"),
        ({}, "unknown input None"),
    ],
)
def test_a_record_that_says_nothing_sensible_is_refused(record, says) -> None:
    with pytest.raises(ValueError, match=says):
        input_from(record)


def test_digging_raising_and_clearing_change_the_cells_named_and_no_others() -> None:
    ground = edited(LEVEL, Edit("dig", ((1, 2),)))
    dug = ground.heights
    assert np.isnan(dug[1, 2]) and np.isfinite(dug).sum() == 11
    raised = edited(LEVEL, Edit("raise", ((0, 0), (2, 3)), 0.2))
    heights = raised.heights
    assert heights[0, 0] == heights[2, 3] == 0.2 and heights.sum() == pytest.approx(0.4)
    cleared = edited(ground, Edit("clear", ((1, 2), (0, 0))))
    assert np.array_equal(cleared.heights, LEVEL.heights)
    assert edited(raised, Edit("forbid", ((0, 0),))) is raised


@pytest.mark.parametrize(
    ("edit", "says"),
    [
        (Edit("burn", ()), "unknown terrain edit 'burn'; there are: dig, raise, forbid, clear"),
        (Edit("dig", ((3, 0),)), "within 3 rows and 4 columns"),
        (Edit("dig", ((0, -1),)), "within 3 rows and 4 columns"),
        (Edit("raise", ((0, 0),), 101.0), "within 100 m of 0"),
        (Edit("dig", ((0, 0),) * (EDIT_CELLS_MAX + 1)), "at most 40000 cells"),
    ],
)
def test_an_edit_that_cannot_be_is_refused_and_changes_nothing(edit, says) -> None:
    before = LEVEL.heights.copy()
    with pytest.raises(ValueError, match=says):
        edited(LEVEL, edit)
    assert np.array_equal(LEVEL.heights, before)
