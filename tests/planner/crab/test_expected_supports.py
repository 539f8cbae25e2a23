"""What a step expects after it is the nominal walk, so that the next steps come as expected."""

import math
from dataclasses import replace

import pytest

from tests.planner.crab.crab_walks import TITAN, command, gait, holes
from walking_console.planner.crab.expected_supports import AHEAD, expected_supports
from walking_console.planner.crab.gait import standard_stance
from walking_console.planner.crab.planner import plan_step
from walking_console.planner.crab.steps import StepRequest
from walking_console.planner.initial_stance import Placement
from walking_console.planner.stability import support_polygon
from walking_console.planner.types import Phase, StepPlan


def standard_walk(angle, steps):
    """So many steps of the walk over level ground at a crab angle, from the standard posture."""
    order = command(angle, 0.08)
    stance = standard_stance(
        TITAN, gait(), Placement((0.0, 0.0, 0.0), lambda x, y: 0.0, order.crab_angle)
    )
    plans = []
    for _ in range(steps):
        plan = plan_step(StepRequest(stance, order, holes(), TITAN, gait()))
        assert isinstance(plan, StepPlan)
        plans.append(plan)
        stance = plan.end
    return order, plans


@pytest.mark.parametrize("angle", [0, 16, 45, 74, 90, 180, -130])
def test_the_supports_that_come_are_those_that_were_expected(angle):
    order, plans = standard_walk(angle, 4 + AHEAD)
    for k, plan in enumerate(plans[:4]):
        begun = 0.0
        expected = expected_supports(plan, order, TITAN, gait())
        assert len(expected) == AHEAD
        for support, came in zip(expected, plans[k + 1 :], strict=False):
            lift = next(n for n, phase in enumerate(came.phases) if phase is not Phase.SUPPORT)
            carrying = [f for leg, f in enumerate(came.feet[0]) if leg not in came.swing]
            assert support.lift == pytest.approx(begun + came.times[lift], abs=1e-6)
            assert support.land == pytest.approx(begun + came.times[-1], abs=1e-6)
            assert support.at_land == pytest.approx(tuple(came.body[-1][:2]), abs=1e-6)
            for corner, foot in zip(
                sorted(support.polygon), sorted(support_polygon(carrying)), strict=True
            ):
                assert math.dist(corner, foot) <= 1e-6
            begun += came.times[-1]


def test_after_a_step_in_which_nobody_swung_nothing_is_expected():
    order, plans = standard_walk(0, 1)
    standing = standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), lambda x, y: 0.0))
    still = replace(plans[0], end=replace(standing, last_swing=-1))
    assert expected_supports(still, order, TITAN, gait()) == ()
