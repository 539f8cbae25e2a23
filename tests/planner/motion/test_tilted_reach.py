"""The machine as a tilted body has it."""

import math

import pytest

from walking_console.planner.motion.body_tilt import LEVEL
from walking_console.planner.motion.tilted_reach import (
    change_of,
    whole_reach,
    with_box,
)
from walking_console.planner.robot.model import load_machine
from walking_console.planner.types import Gait

TITAN = load_machine("titan3")
GAIT = Gait(TITAN.duty_factor, TITAN.lift_up, TITAN.lift_down, TITAN.height)


def test_a_level_body_has_all_of_its_machine():
    assert whole_reach(TITAN, GAIT, (LEVEL, LEVEL)) is TITAN


@pytest.mark.parametrize("heading", [0, 60, 90, 200])
def test_under_a_lean_the_boxes_are_mirrored_and_no_larger(heading):
    lean = 0.1 * math.cos(math.radians(heading)), 0.1 * math.sin(math.radians(heading))
    tilted = whole_reach(TITAN, GAIT, (lean, lean))
    assert tilted is not None
    assert tilted.reach.x_span <= TITAN.reach.x_span and tilted.reach.y_span <= TITAN.reach.y_span
    assert all(now < before for now, before in zip(tilted.speed[:2], TITAN.speed[:2], strict=True))
    assert tilted.overreach[0] < TITAN.overreach[0] and tilted.overreach[2] >= TITAN.overreach[2]


def test_only_a_lean_that_changes_within_the_step_is_a_change():
    assert change_of(((0.1, 0.0), (0.0, 0.0))) == pytest.approx(0.1)
    assert change_of(((0.1, 0.0),)) == 0.0
    assert change_of(((0.1, 0.0), (-0.1, 0.0), (0.0, 0.1), (0.0, -0.1))) == 0.0


def test_a_box_given_is_that_of_every_quadrant():
    machine = with_box(TITAN, GAIT, (LEVEL,), (0.3, 0.5, 0.4, 0.6), TITAN.z_range, 1.0)
    assert machine.reach.x0 == 0.3 and machine.reach.y_span == pytest.approx(0.2)
    assert machine.speed == TITAN.speed and machine.overreach == TITAN.overreach
