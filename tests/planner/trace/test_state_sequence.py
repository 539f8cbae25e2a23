"""States in K's order: which leg goes next, where it is put down, when."""

import pytest

from tests.planner.trace.rollout import field_of
from tests.planner.trace.test_reachability import along
from tests.planner.trace.test_state_search import HEXAPOD, field_on_trace
from walking_console.planner.trace.footholds import AIR
from walking_console.planner.trace.state_sequence import (
    FORE,
    HIND,
    MIDDLE,
    end_of,
    first_guess,
    iterate,
    k_step,
    leg_kind,
    put_down,
)


def test_on_open_ground_the_leg_that_must_leave_first_is_lifted_and_put_down_ahead() -> None:
    reachable, start = field_on_trace(field_of(1.0, 0, HEXAPOD), 160)
    lifted, down = k_step(reachable, start) or []
    leg = min(range(6), key=lambda i: reachable.footholds[start.feet[i]].last)
    assert lifted.feet[leg] == AIR and down.feet[leg] >= 0
    assert reachable.footholds[down.feet[leg]].last > reachable.footholds[start.feet[leg]].last


def test_a_state_lasts_until_a_leg_must_leave_or_stability_ends() -> None:
    reachable, start = field_on_trace(field_of(1.0, 0, HEXAPOD), 160)
    end = end_of(reachable, start)
    valid = reachable.valid(start.feet)
    assert valid >> end & 1 and not valid >> (end + 1) & 1


def test_straight_ahead_the_front_legs_are_fore_and_the_rear_legs_hind() -> None:
    reachable = along("line", field_of(0.0, 0, HEXAPOD))
    kinds = [leg_kind(reachable, 0, leg) for leg in range(6)]
    assert kinds == [FORE, MIDDLE, HIND, HIND, MIDDLE, FORE]


@pytest.mark.parametrize(("leg", "share"), [(2, 1.0), (1, 0.5), (0, 1 / 3)])
def test_the_iteration_starts_at_the_end_for_hind_legs_half_way_for_middle_a_third_for_fore(
    leg: int, share: float
) -> None:
    reachable = along("line", field_of(0.0, 0, HEXAPOD))
    assert first_guess(reachable, 0, 60, (leg,)) == round(60 * share)


def test_the_s_iteration_finds_the_foothold_whose_segment_reaches_farthest() -> None:
    reachable, start = field_on_trace(field_of(0.1, 3, HEXAPOD), 160)
    feet = (AIR, *start.feet[1:])
    chosen = iterate(reachable, feet, 0, (0,))
    assert chosen is not None
    able = [
        f
        for f in reachable.by_leg[0]
        if reachable.existence[f] & 1 and reachable.carries((f, *feet[1:])) & 1
    ]
    lasts = sorted(reachable.footholds[f].last for f in able)
    assert reachable.footholds[chosen[0]].last == lasts[-1]


def test_where_there_is_no_foothold_a_leg_cannot_be_put_down() -> None:
    reachable, start = field_on_trace(field_of(0.0, 0, HEXAPOD), 160)
    feet = (AIR, *start.feet[1:])
    reachable.by_leg[0] = []
    assert put_down(reachable, feet, 0, 10, (0,)) is None
