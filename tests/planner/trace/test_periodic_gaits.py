"""Rigid gaits as data: rows of states and binary fractions, both ways (K figs. 2 and 3)."""

from fractions import Fraction

import pytest

from walking_console.planner.trace.periodic_gaits import (
    GAITS,
    GaitError,
    RigidGait,
    fractions_of,
    may_be_stable,
    rigid_gait,
    rows_of,
)


def test_the_tripod_is_the_papers() -> None:
    """K fig. 3 prints 14/15 and 11/15; the digits it prints for α1 contradict that value, the
    fraction is right.
    """
    assert GAITS["tripod"].fractions == (Fraction(14, 15), Fraction(11, 15)) * 3
    assert GAITS["tripod"].rows[1] == (1, 0, 1, 0, 1, 0)


@pytest.mark.parametrize("name", GAITS)
def test_rows_become_fractions_and_rows_again(name: str) -> None:
    assert rows_of(GAITS[name].fractions) == GAITS[name].rows
    assert fractions_of(rows_of(GAITS[name].fractions)) == GAITS[name].fractions


@pytest.mark.parametrize("name", GAITS)
def test_every_shipped_gait_meets_the_necessary_condition(name: str) -> None:
    assert may_be_stable(GAITS[name].fractions)
    assert sorted(leg for group in GAITS[name].groups for leg in group) == list(range(6))


def test_the_condition_is_not_sufficient() -> None:
    # 1 1 0 0 0 0 every other state
    fractions = (
        Fraction(1),
        Fraction(1),
        Fraction(1, 3),
        Fraction(1, 3),
        Fraction(1, 3),
        Fraction(1, 3),
    )
    assert may_be_stable(fractions)
    with pytest.raises(GaitError, match="stands on 2 legs in state 1"):
        RigidGait("hop", rows_of(fractions))


@pytest.mark.parametrize(
    ("name", "groups"),
    [
        ("tripod", ((1, 3, 5), (0, 2, 4))),
        ("wave", ((2,), (1,), (0,), (3,), (4,), (5,))),
        ("ripple", ((2,), (5,), (1,), (3,), (0,), (4,))),
        ("gallop", ((2, 3), (1, 4), (0, 5))),
    ],
)
def test_legs_move_in_this_order(name: str, groups: tuple[tuple[int, ...], ...]) -> None:
    assert rigid_gait(name).groups == groups


def test_an_unknown_gait_is_answered_with_the_known_ones() -> None:
    with pytest.raises(
        GaitError, match="unknown gait 'trot'; there are: free, tripod, wave, ripple, gallop"
    ):
        rigid_gait("trot")


def test_fractions_that_do_not_recur_soon_are_refused() -> None:
    with pytest.raises(GaitError, match="do not recur"):
        rows_of([Fraction(1, 2)] * 6)
