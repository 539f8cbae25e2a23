"""Which legs are better not lifted: where the body cannot be led far enough over the others."""

from dataclasses import replace

import numpy as np
import pytest

from walking_console import Command, Stance, StepPlan, StepPlanner, TerrainMap, load_machine
from walking_console.planner.motion.body_bounds import RESERVE
from walking_console.planner.motion.leg_choice import on_surer_legs
from walking_console.planner.protocols import run_to_completion
from walking_console.planner.types import Blocked, Reason

MACHINE = load_machine("titan3")
GAIT = replace(MACHINE.gait, sways=True)
FLAT = TerrainMap.from_heights(np.zeros((160, 160)), 0.05, MACHINE, origin=(-4.0, -4.0))

# where random hands had brought the machine (``tests.sweeps.hands``, seeds 52138, 52096, 52031),
# and what they asked for there: a leg lifted with the true centre of gravity within 1 mm of the
# edge of the other three, or outside of it
AT_REST = (
    Stance(
        (0.41396, -0.33741, 0.85, 0.47338),
        (
            (0.58990, 0.53194, 0.0),
            (-0.21239, -0.26717, 0.0),
            (0.25125, -0.87965, 0.0),
            (1.19700, -0.42106, 0.0),
        ),
        last_swing=3,
        quarter_turns=0,
    ),
    Command(crab_angle=2.43413, speed=0.22793),
)
STRAIGHT_ON = (
    Stance(
        (0.41002, 0.55719, 0.85, 0.40548),
        (
            (0.57151, 1.37961, 0.0),
            (-0.26759, 0.70861, 0.0),
            (0.14014, -0.03681, 0.0),
            (0.99473, 0.42711, 0.0),
        ),
        last_swing=1,
        quarter_turns=0,
    ),
    Command(crab_angle=-0.58697, speed=0.21234),
)
ON_AN_ARC = (
    Stance(
        (0.96349, 0.66539, 0.85, 1.62022),
        (
            (0.54883, 1.15308, 0.0),
            (0.29283, 0.08736, 0.0),
            (1.32641, 0.22690, 0.0),
            (1.53237, 1.20014, 0.0),
        ),
        last_swing=3,
        quarter_turns=0,
        still=1,
        velocity=(-0.00515, 0.10408),
    ),
    Command(crab_angle=-0.14389, speed=0.29763, turn_rate=0.17838),
)


@pytest.mark.parametrize("situation", [AT_REST, STRAIGHT_ON, ON_AN_ARC])
def test_no_leg_lifts_with_the_centre_of_gravity_on_the_edge_of_the_others(
    situation: tuple[Stance, Command],
) -> None:
    plan = StepPlanner(MACHINE, gait=GAIT).plan(*situation, FLAT)
    assert isinstance(plan, StepPlan)
    assert plan.polygon_margin_min >= RESERVE
    assert plan.end.kept_down == ()


def test_the_printed_rules_lift_the_leg_they_name() -> None:
    plan = StepPlanner(MACHINE, mode="paper", gait=GAIT).plan(*STRAIGHT_ON, FLAT)
    assert isinstance(plan, StepPlan)
    assert plan.swing == (0,)
    assert plan.polygon_margin_min < RESERVE


class Offers:
    """A planner of steps with these margins, one for every leg that may still lift."""

    def __init__(self, margins: dict[int, float]) -> None:
        self.margins = margins
        plan = StepPlanner(MACHINE, gait=GAIT).plan(*AT_REST, FLAT)
        assert isinstance(plan, StepPlan)
        self.plan = plan
        self.asked = 0

    def __call__(self, stance: Stance):
        yield
        self.asked += 1
        for leg, margin in self.margins.items():
            if leg not in stance.kept_down:
                end = replace(self.plan.end, kept_down=stance.kept_down)
                return replace(self.plan, swing=(leg,), polygon_margin_min=margin, end=end)
        return Blocked(Reason.NO_WAY_ON)


def chosen(offers: Offers) -> StepPlan:
    plan = run_to_completion(on_surer_legs(offers, AT_REST[0], GAIT))
    assert isinstance(plan, StepPlan)
    return plan


def test_a_leg_that_keeps_enough_is_lifted_unasked() -> None:
    offers = Offers({2: RESERVE, 1: 0.02})
    assert (chosen(offers).swing, offers.asked) == ((2,), 1)


def test_of_legs_that_all_keep_little_the_one_that_keeps_most_is_lifted() -> None:
    offers = Offers({0: 0.001, 3: 0.004, 1: 0.002})
    plan = chosen(offers)
    assert (plan.swing, plan.end.kept_down, offers.asked) == ((3,), (), 4)


def test_without_another_step_the_first_is_taken() -> None:
    assert chosen(Offers({1: 0.001})).swing == (1,)
