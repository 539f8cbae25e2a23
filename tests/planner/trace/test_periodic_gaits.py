"""Rigid gaits as data: rows of states and binary fractions, both ways (K figs. 2 and 3)."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from walking_console.planner.robot.model import Machine, load_machine
from walking_console.planner.trace.periodic_gaits import (
    GAITS,
    GaitError,
    RigidGait,
    fractions_of,
    given_gait,
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
        ("ripple", ((2, 5), (1, 3), (0, 4))),
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


HEXAPOD = load_machine("hexapod")
TITAN = load_machine("titan3")


def test_ripple_is_two_waves_half_a_cycle_apart_with_two_legs_in_the_air() -> None:
    """Digits of a leg of one side are those of its opposite, three states of six later."""
    rows = GAITS["ripple"].rows
    assert all(sum(row) == 4 for row in rows)
    for left, right in ((0, 5), (1, 4), (2, 3)):
        assert [row[left] for row in rows] == [rows[(k + 3) % 6][right] for k in range(6)]


def with_legs(count: int) -> Machine:
    """A machine of this many legs, as far as their order and sides go."""
    legs = {4: TITAN.legs, 6: HEXAPOD.legs}.get(count)
    if legs is None:
        left = tuple(HEXAPOD.legs[:3])
        right = tuple(HEXAPOD.legs[3:])
        legs = {5: left + right[1:], 8: left[:1] + left + right + right[-1:]}[count]
    return replace(HEXAPOD, name=f"of {count}", legs=legs)


@pytest.mark.parametrize("count", [4, 5, 8])
@pytest.mark.parametrize("name", GAITS)
def test_a_named_gait_moves_every_leg_of_any_machine_once_or_says_how_many_it_is_for(
    name: str, count: int
) -> None:
    machine = with_legs(count)
    try:
        gait = rigid_gait(name, machine)
    except GaitError as error:
        assert str(error).startswith(f"rigid gait {name!r} is for at least")
        assert str(error).endswith(f"of {count} has {count}") and count < 6
    else:
        moved = [leg for group in gait.groups for leg in group]
        assert sorted(moved) == list(range(count))
        assert all(sum(row) >= 3 for row in gait.rows)


def test_four_legs_wave_from_the_rear_to_the_front_on_each_side() -> None:
    assert rigid_gait("wave", TITAN).groups == ((1,), (0,), (2,), (3,))


@pytest.mark.parametrize(
    "given",
    [
        {"rows": ["110101", "110110", "101110", "101011", "011011", "011101"]},
        {"duty": 2 / 3, "phases": [0.0, 2 / 3, 1 / 3, 5 / 6, 1 / 6, 0.5]},
    ],
)
def test_one_gait_is_given_by_rows_or_by_duty_and_phases(given: dict[str, Any]) -> None:
    groups = given_gait(given, HEXAPOD).groups
    ripple = GAITS["ripple"].groups
    assert groups in [ripple[k:] + ripple[:k] for k in range(3)]


def test_a_gait_is_given_by_fractions() -> None:
    given = {"fractions": ["14/15", "11/15"] * 3}
    assert given_gait(given, HEXAPOD).rows == GAITS["tripod"].rows


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"rows": ["1110", "1101"]}, "hexapod has 6 legs, this gait 4"),
        ({"rows": ["111111", "101011", "111111"]}, "leg 1 never swings"),
        ({"rows": ["111111", "100001"]}, "stands on 2 legs in state 2"),
        ({"duty": 0.5, "phases": [0.0, 0.0, 0.0, 0.0, 0.5, 0.5]}, "at least 3 must carry"),
        ({"fractions": ["1/2"] * 6}, "do not recur"),
        ({"fractions": ["3/2"] * 6}, "between 0 and 1"),
    ],
)
def test_what_is_no_gait_of_the_machine_is_refused(given: dict[str, Any], says: str) -> None:
    with pytest.raises(GaitError, match=says):
        given_gait(given, HEXAPOD)
