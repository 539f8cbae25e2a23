"""The order of the legs and when each lands, on lines and on arcs."""

import math

import pytest

from walking_console.planner.geometry.paths import ArcPath
from walking_console.planner.motion.leg_order import (
    OTHERS,
    best_order,
    order_on,
    standard_margin,
    standard_order,
    touchdown_phases,
)
from walking_console.planner.robot.model import load_machine

TITAN = load_machine("titan3")
SPOT = ArcPath(0.0, 0.0, 1.0 / TITAN.yaw_length)


def test_legs_land_in_the_phases_of_figure_5() -> None:
    assert touchdown_phases(0.8) == (0.0, 0.8, pytest.approx(0.3), 0.5)


def test_the_standard_margin_is_zero_at_three_quarters_and_grows_with_the_duty_factor() -> None:
    assert standard_margin(0.5, 0.75) == 0.0
    assert standard_margin(0.5, 0.8) == pytest.approx(0.03125)


@pytest.mark.parametrize("turn_share", [0.0, 0.2, -0.5, 1.0])
def test_every_leg_swings_once_a_cycle_after_the_one_whose_successor_it_is(
    turn_share: float,
) -> None:
    ahead = math.sqrt(1.0 - turn_share**2)
    for order in (
        order_on(TITAN, 0.8, ArcPath(ahead, 0.0, turn_share / TITAN.yaw_length)),
        standard_order(0.5, 0.8),
    ):
        assert sorted(order.successor) == [0, 1, 2, 3]
        assert all(order.predecessor[order.successor[leg]] == leg for leg in range(4))
        assert all(leg not in OTHERS[leg] and len(OTHERS[leg]) == 3 for leg in range(4))


def test_on_the_spot_the_legs_go_round_one_after_the_other() -> None:
    order = order_on(TITAN, 0.8, SPOT)
    steps = {(order.successor[leg] - leg) % 4 for leg in range(4)}
    assert steps in ({1}, {3})


def test_arcs_that_hardly_differ_share_their_order() -> None:
    one, other = (ArcPath(1.0, 0.0, turn) for turn in (0.2, 0.201))
    assert order_on(TITAN, 0.8, one) is order_on(TITAN, 0.8, other)
    assert order_on(TITAN, 0.8, ArcPath(1.0, 0.0)) is best_order(TITAN, 0.8, 0, 0)
