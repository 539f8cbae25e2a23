"""What a way is to be best at: by its own measure it is no worse than the first way found, and on
sparse ground clearly better.
"""

import pytest

from tests.planner.trace.rollout import field_of, gait_of
from walking_console.planner.config import AIMS, SOONEST, TraceSearch
from walking_console.planner.initial_stance import Placement, square_stance
from walking_console.planner.protocols import run_to_completion
from walking_console.planner.robot.model import load_machine
from walking_console.planner.trace.aims import MARGINS, least_margin, seconds
from walking_console.planner.trace.attempt import Task, TraceCourse
from walking_console.planner.trace.lane import TraceWindow
from walking_console.planner.trace.paths import trace_for
from walking_console.planner.trace.prediction import Prediction, predicting
from walking_console.planner.trace.stability_table import MARGIN
from walking_console.planner.types import Command

HEXAPOD = load_machine("hexapod")
GAIT = gait_of(HEXAPOD)
TRACE = trace_for({"kind": "sine"}, HEXAPOD)
GROUND = field_of(0.1, 2, HEXAPOD)
START = square_stance(HEXAPOD, GAIT, Placement((0.0, 0.0, 0.0), lambda x, y: 0.0))
TASK = Task(TraceCourse(TRACE, TraceWindow(0, 320, 0), 0.0), START, GROUND, HEXAPOD, GAIT)


def predicted(aim: str, sway: float | None = None) -> Prediction:
    search = TraceSearch(sway, aim)
    command = Command(speed=0.1)
    job = predicting(START, command, GROUND, HEXAPOD, GAIT, trace=TRACE, search=search)
    return run_to_completion(job)


FOUND = {aim: predicted(aim) for aim in AIMS}


def test_every_aim_gets_as_far_as_the_first_way_found():
    assert all(found.complete for found in FOUND.values())
    assert len({found.goal for found in FOUND.values()}) == 1


def test_the_fewest_states_are_at_most_two_thirds_of_those_of_the_first_way():
    assert len(FOUND["states"].moves) <= 2 / 3 * len(FOUND[SOONEST].moves)


def test_the_greatest_margin_is_several_times_that_of_the_first_way():
    first, best = (least_margin(FOUND[aim].moves) for aim in (SOONEST, "margin"))
    assert first == pytest.approx(MARGIN, abs=0.01)
    assert best >= MARGINS[3] - 1e-6 and best > 2 * first


def test_the_fastest_way_takes_less_time_than_the_first():
    first, best = (run_to_completion(seconds(FOUND[aim].moves, TASK)) for aim in (SOONEST, "speed"))
    assert best < 0.9 * first


def test_a_way_that_does_not_get_there_is_left_as_it_is():
    bare = field_of(0.0, 1, HEXAPOD)
    jobs = (
        predicting(START, Command(speed=0.1), bare, HEXAPOD, GAIT, search=TraceSearch(None, aim))
        for aim in (SOONEST, "margin")
    )
    first, best = (run_to_completion(job) for job in jobs)
    assert not first.complete and best.moves == first.moves and best.reason == first.reason
