"""The global prediction: what it leads to, and as long as what it serves."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.planner.trace.rollout import field_of, gait_of
from walking_console.planner.initial_stance import Placement, square_stance
from walking_console.planner.protocols import run_to_completion
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.trace.paths import trace_for
from walking_console.planner.trace.prediction import (
    BODY_LENGTHS,
    Prediction,
    index_of,
    predicting,
    serves,
)
from walking_console.planner.types import Command, Stance

HEXAPOD = load_machine("hexapod")
GAIT = gait_of(HEXAPOD)
LEVEL = field_of(0.3, 4, HEXAPOD)
TRACE = trace_for({"kind": "sine"}, HEXAPOD)
AHEAD = Command(speed=0.1)
START = square_stance(HEXAPOD, GAIT, Placement((0.0, 0.0, 0.0), LEVEL.height_at))


def predict(
    terrain: TerrainMap = LEVEL, command: Command = AHEAD, trace=TRACE, stance: Stance = START
) -> Prediction:
    job = predicting(stance, command, terrain, HEXAPOD, GAIT, trace=trace)
    return run_to_completion(job)


def after(prediction: Prediction, n: int) -> Stance:
    """The stance after so many of its moves."""
    move = prediction.moves[n - 1]
    feet = tuple(foot or (0.0, 0.0, 9.0) for foot in move.after)
    lifted = tuple(leg for leg, foot in enumerate(move.after) if foot is None)
    return replace(START, body=move.carry[-1], feet=feet, lifted=lifted, course=move.course)


def test_on_open_ground_it_leads_two_body_lengths_on() -> None:
    found = predict()
    assert found.complete and found.reason == ""
    assert found.goal == pytest.approx(BODY_LENGTHS * HEXAPOD.torso[0], abs=0.01)
    assert found.reached >= found.goal - 1e-9
    assert found.moves[-1].course == pytest.approx(found.goal)


def test_it_knows_which_of_its_moves_starts_at_a_stance() -> None:
    found = predict()
    assert index_of(found, START) == 0
    for n in (1, 2, len(found.moves)):
        assert index_of(found, after(found, n)) == n
    elsewhere = replace(START, body=(0.5, 0.5, GAIT.height, 0.0))
    assert index_of(found, elsewhere) is None
    assert index_of(found, replace(START, lifted=(0,))) is None


def test_it_serves_while_trace_and_ground_are_the_same() -> None:
    found = predict()
    assert serves(found, START, AHEAD, LEVEL, HEXAPOD, TRACE)
    assert not serves(found, START, AHEAD, LEVEL, HEXAPOD, trace_for({"kind": "line"}, HEXAPOD))
    assert not serves(found, after(found, len(found.moves)), AHEAD, LEVEL, HEXAPOD, TRACE)


def test_it_serves_on_changed_ground_as_long_as_its_footholds_are_allowed() -> None:
    found = predict()
    leg = found.moves[0].legs[0]
    foothold = found.moves[0].after[leg]
    assert foothold is not None
    cell = LEVEL.cell_at(*foothold[:2])
    assert cell is not None
    far = LEVEL.forbid([(0, 0)])
    assert serves(found, START, AHEAD, far, HEXAPOD, TRACE)
    assert not serves(found, START, AHEAD, LEVEL.forbid([cell]), HEXAPOD, TRACE)


def test_a_joysticks_prediction_serves_at_any_pace_but_for_no_other_course() -> None:
    found = predict(trace=None)
    assert serves(found, START, Command(speed=0.3), LEVEL, HEXAPOD, None)
    assert not serves(found, START, Command(0.5, 0.1), LEVEL, HEXAPOD, None)
    assert not serves(found, START, Command(speed=0.1, turn_rate=0.1), LEVEL, HEXAPOD, None)
    assert not serves(found, START, AHEAD, LEVEL, HEXAPOD, TRACE)


def test_at_an_edge_it_leads_as_far_as_feet_can_stand_and_says_why() -> None:
    forbidden = LEVEL.forbidden.copy()
    forbidden[:, LEVEL.cell_at(1.5, 0.0)[1] :] = True
    found = predict(TerrainMap(LEVEL.heights, forbidden, LEVEL.cell, LEVEL.origin))
    assert not found.complete
    assert 0.0 < found.reached < found.goal
    assert "no foothold lets the next leg leave its own" in found.reason
    assert all(foot is not None for foot in found.moves[-1].after), (
        "it waits on all its feet where there is no way on"
    )


def test_a_machine_that_does_not_stand_has_no_moves() -> None:
    fallen = replace(START, feet=tuple((x + 5.0, y, z) for x, y, z in START.feet))
    found = predict(stance=fallen)
    assert found.moves == () and found.reason == (
        "the machine does not stand within reach and stable here"
    )


def test_the_answer_is_the_same_every_time() -> None:
    one, two = predict(), predict()
    assert one.moves == two.moves
    assert np.array_equal(one.trace.x, two.trace.x)


def test_on_a_slope_too_steep_for_its_legs_it_says_which_leg_reaches_how_far() -> None:
    machine = load_machine("phantomx")
    x = (np.arange(80) + 0.5) * 0.025 - 1.0
    heights = np.tile(math.tan(math.radians(10.0)) * x, (80, 1))
    terrain = TerrainMap(heights, np.zeros((80, 80), bool), 0.025, (-1.0, -1.0))
    gait = gait_of(machine)
    stance = square_stance(machine, gait, Placement((0.0, 0.0, 0.0), terrain.height_at))
    few = {"limit": 200, "limit_wide": 200}
    found = run_to_completion(predicting(stance, AHEAD, terrain, machine, gait, **few))
    assert not found.complete
    assert "reaches 70 to 120 mm below the body, which stays level" in found.reason
