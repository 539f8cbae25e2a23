"""From s to time: the pace of the body, the times of the feet, what no foot exceeds."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.planner.trace.rollout import field_of, gait_of
from walking_console.planner.geometry.transforms import point_seen
from walking_console.planner.initial_stance import Placement, square_stance
from walking_console.planner.protocols import run_to_completion
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.trace.moves import Move
from walking_console.planner.trace.paths import trace_for
from walking_console.planner.trace.prediction import Prediction, predicting
from walking_console.planner.trace.timing import body_pace_max, step_plan
from walking_console.planner.types import Command, Phase, StepPlan

HEXAPOD = load_machine("hexapod")
GAIT = gait_of(HEXAPOD)
LEVEL = field_of(0.3, 4, HEXAPOD)


def predicted(terrain: TerrainMap, kind: str = "line") -> Prediction:
    stance = square_stance(HEXAPOD, GAIT, Placement((0.0, 0.0, 0.0), terrain.height_at))
    trace = trace_for({"kind": kind}, HEXAPOD)
    job = predicting(stance, Command(speed=0.1), terrain, HEXAPOD, GAIT, trace=trace)
    return run_to_completion(job)


def plans(prediction: Prediction, pace: float, gait=GAIT) -> list[StepPlan]:
    stance, found = prediction.start, []
    for move in prediction.moves:
        found.append(step_plan(stance, move, pace, prediction.terrain, HEXAPOD, gait))
        stance = found[-1].end
    return found


def from_ground_to_ground(move: Move) -> list[int]:
    """Legs that stand on the ground before a move and after it."""
    before, after = move.before, move.after
    return [leg for leg in move.legs if before[leg] is not None and after[leg] is not None]


def test_the_body_keeps_the_commanded_pace_where_the_legs_can_follow() -> None:
    slow = [plan for plan in plans(predicted(LEVEL), 0.02) if plan.speed]
    expected = [min(0.02, plan.speed_max) for plan in slow]
    assert [plan.speed for plan in slow] == pytest.approx(expected, rel=1e-6)
    assert expected.count(0.02) > 0.8 * len(expected)


def test_a_faster_command_than_the_legs_can_follow_makes_the_fastest_step() -> None:
    prediction = predicted(LEVEL)
    for plan, faster in zip(plans(prediction, 2.0), plans(prediction, 9.0), strict=True):
        assert plan.times[-1] == faster.times[-1]
        assert plan.speed <= plan.speed_max + 1e-9 <= body_pace_max(HEXAPOD, GAIT) + 1e-6


@pytest.mark.parametrize("kind", ["line", "circle", "turn"])
def test_no_foot_exceeds_its_limit(kind: str) -> None:
    for plan in plans(predicted(LEVEL, kind), 2.0):
        for leg in range(6):
            seen = np.array(
                [
                    point_seen(tuple(body), tuple(foot))
                    for body, foot in zip(plan.body, plan.feet[:, leg], strict=True)
                ]
            )
            speeds = np.abs(np.diff(seen, axis=0)) / np.diff(plan.times)[:, None]
            assert (speeds <= np.array(HEXAPOD.speed) * (1 + 1e-6)).all()


def test_feet_rise_and_fall_vertically_and_are_carried_straight_in_body_axes() -> None:
    prediction = predicted(LEVEL, "circle")
    for move, plan in zip(prediction.moves, plans(prediction, 0.1), strict=True):
        for k, phase in enumerate(plan.phases):
            for leg in from_ground_to_ground(move):
                moved = plan.feet[k + 1, leg] - plan.feet[k, leg]
                if phase in (Phase.UP, Phase.DOWN):
                    assert np.abs(moved[:2]).max() < 1e-9
        carried = [k for k, phase in enumerate(plan.phases) if phase is Phase.RETURN]
        for leg in from_ground_to_ground(move):
            ways = [
                np.array(point_seen(tuple(plan.body[k]), tuple(plan.feet[k, leg])))
                for k in [*carried, carried[-1] + 1]
            ]
            whole = ways[-1] - ways[0]
            for way in ways:
                assert np.linalg.norm(np.cross(way - ways[0], whole)) < 1e-6


def test_a_foot_aims_below_the_ground_it_is_to_stand_on() -> None:
    prediction = predicted(LEVEL)
    for move, plan in zip(prediction.moves, plans(prediction, 0.1), strict=True):
        for leg in from_ground_to_ground(move):
            assert plan.feet[-1, leg, 2] < plan.end.feet[leg][2]


def test_even_speeds_take_less_time_for_they_need_no_room_for_a_peak() -> None:
    prediction = predicted(LEVEL)
    even = plans(prediction, 2.0, replace(GAIT, smooth=False))
    for eased, fast in zip(plans(prediction, 2.0), even, strict=True):
        assert math.isclose(eased.times[-1] / fast.times[-1], 1.25, rel_tol=1e-6)


def test_where_the_body_climbs_the_feet_keep_their_limit_all_the_same() -> None:
    rng = np.random.default_rng(3)
    heights = rng.uniform(-0.06, 0.06, (200, 320))
    terrain = TerrainMap(heights, np.zeros(heights.shape, bool), 0.05, (-3.0, -5.0))
    for plan in plans(predicted(terrain), 2.0):
        for leg in plan.swing:
            rise = np.diff(plan.feet[:, leg, 2] - plan.body[:, 2]) / np.diff(plan.times)
            assert np.abs(rise).max() <= HEXAPOD.speed[2] * (1 + 1e-6)
