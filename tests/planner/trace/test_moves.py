"""From states to moves: what changes, where the body is when it does."""

import math

import pytest

from tests.planner.trace.rollout import field_of
from tests.planner.trace.test_state_search import HEXAPOD, field_on_trace
from walking_console.planner.geometry.path_kinds import STEP
from walking_console.planner.protocols import run_to_completion
from walking_console.planner.trace.leg_clearance import Swing
from walking_console.planner.trace.moves import TOGETHER, Move, moves_along, up_to_what_is_met
from walking_console.planner.trace.state_search import StatePath, search

OFFSET = 3.0


def moves_of(fraction: float, seed: int, together: int = 2 * TOGETHER) -> tuple[Move, ...]:
    reachable, start = field_on_trace(field_of(fraction, seed, HEXAPOD), 320)
    path = run_to_completion(search(reachable, start, 320, 40_000))
    assert path.complete
    return run_to_completion(moves_along(reachable, path, OFFSET, STEP, together))


@pytest.mark.parametrize(("fraction", "seed"), [(1.0, 0), (0.05, 2), (0.03, 5)])
def test_moves_follow_each_other_without_a_gap(fraction: float, seed: int) -> None:
    moves = moves_of(fraction, seed)
    for move, after in zip(moves, moves[1:], strict=False):
        assert move.after == after.before
        assert move.carry[-1] == after.shift[0]
    for move in moves:
        assert move.shift[-1] == move.carry[0]
        assert move.rise == move.carry[: len(move.rise)]
        assert move.lower == move.carry[len(move.carry) - len(move.lower) :]
    assert moves[-1].course == pytest.approx(OFFSET + 320 * STEP)


@pytest.mark.parametrize(("fraction", "seed"), [(1.0, 0), (0.03, 5)])
def test_only_the_legs_of_a_move_change_and_at_most_three_do(fraction: float, seed: int) -> None:
    for move in moves_of(fraction, seed):
        changed = [leg for leg in range(6) if move.before[leg] != move.after[leg]]
        assert changed == list(move.legs)
        assert len(move.legs) <= TOGETHER


def test_changes_that_can_be_made_at_once_are() -> None:
    assert len(moves_of(1.0, 0)) < len(moves_of(1.0, 0, together=1))


def test_every_foothold_after_a_move_has_a_segment_that_holds_the_body() -> None:
    for move in moves_of(0.05, 2):
        for leg, segment in enumerate(move.segments):
            assert (segment is None) is (move.after[leg] is None)
            if segment is not None:
                assert segment[0] - 1e-9 <= move.course <= segment[1] + 1e-9


def test_the_body_goes_on_along_the_trace_in_steps_of_a_sample() -> None:
    for move in moves_of(1.0, 0):
        for a, b in zip(move.carry, move.carry[1:], strict=False):
            assert math.hypot(b[0] - a[0], b[1] - a[1]) <= STEP + 1e-9


def test_no_states_make_no_moves() -> None:
    reachable, _ = field_on_trace(field_of(1.0, 0, HEXAPOD), 100)
    nothing = StatePath((), False, 0, 0, True, 0)
    assert run_to_completion(moves_along(reachable, nothing, 0.0, STEP)) == ()


class Meets:
    """Legs of which one, given by the number of its move, sweeps through something."""

    matters = True

    def __init__(self, at: int) -> None:
        self.at = at
        self.asked = 0

    def sweeps_through(self, leg: int, way: Swing) -> bool:
        self.asked += 1
        return self.asked == self.at


def test_moves_are_made_up_to_the_last_standing_before_a_leg_meets_something() -> None:
    moves = moves_of(0.10, 2)
    swings = [
        (number, leg)
        for number, move in enumerate(moves)
        for leg in move.legs
        if move.before[leg] is not None and move.after[leg] is not None
    ]
    for at in (1, len(swings) // 2, len(swings)):
        number, leg = swings[at - 1]
        clear, met = up_to_what_is_met(moves, Meets(at))  # type: ignore[arg-type]
        assert met == (leg, moves[number].after[leg]) and clear <= number
        assert clear == 0 or None not in moves[clear - 1].after
        assert all(None in move.after for move in moves[clear:number])
    assert up_to_what_is_met(moves, Meets(0)) == (len(moves), None)  # type: ignore[arg-type]
