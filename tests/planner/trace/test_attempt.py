"""One search along a course in one manner: what it keeps, and why it says it got no farther."""

from tests.planner.trace.rollout import field_of, gait_of
from tests.planner.trace.test_aims import START, TASK
from walking_console.planner.protocols import run_to_completion
from walking_console.planner.robot.model import load_machine
from walking_console.planner.trace.aims import least_margin
from walking_console.planner.trace.attempt import Attempt, Manner
from walking_console.planner.trace.periodic_gaits import rigid_gait

HEXAPOD = load_machine("hexapod")
GAIT = gait_of(HEXAPOD)


def attempted(manner: Manner, task=TASK) -> Attempt:
    attempt = Attempt(task, manner)
    run_to_completion(attempt.along(0.0, 2_000, 2_000))
    return attempt


def test_a_margin_asked_for_is_kept_by_every_move():
    found = attempted(Manner(margin=0.04))
    assert found.path.complete and least_margin(found.moves) >= 0.04 - 1e-6


def test_dear_changes_make_a_way_of_fewer_states():
    usual, few = (attempted(Manner(change_cost=cost)) for cost in (0.0, 30.0))
    assert len(few.path.states) < len(usual.path.states)


def test_a_rigid_gait_moves_its_own_groups_and_no_other():
    tripod = rigid_gait("tripod", HEXAPOD)
    found = attempted(Manner(tripod), TASK._replace(terrain=field_of(1.0, 1, HEXAPOD)))
    assert found.path.complete
    assert {tuple(sorted(move.legs)) for move in found.moves if move.legs} == set(tripod.groups)


def test_where_there_is_no_foothold_it_says_how_far_it_got():
    found = attempted(Manner(), TASK._replace(terrain=field_of(0.0, 1, HEXAPOD)))
    assert not found.path.complete
    assert "beyond s = 0.35 m" in found.why(0.35) and "foothold" in found.why(0.35)
    assert found.stance is START
