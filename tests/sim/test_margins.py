"""Every margin of one moment."""

import pytest

from walking_console import load_machine
from walking_console.planner.stability import GRAVITY
from walking_console.sim.margins import margins_of, true_centre

TITAN = load_machine("titan3")
FEET = [[x, y, 0.0] for x, y in ((0.5, 0.4), (-0.5, 0.4), (-0.5, -0.4), (0.5, -0.4))]
BODY = [0.1, 0.0, TITAN.height, 0.0, 0.0, 0.0]


def test_legs_draw_the_centre_of_gravity_with_them():
    x, y, z = true_centre(TITAN, BODY, FEET)
    share = TITAN.masses.leg * 4 / TITAN.mass
    assert (x, y) == pytest.approx((0.1 * (1.0 - share), 0.0)) and z < TITAN.height


def test_the_capture_margin_is_the_polygons_less_what_a_stop_needs():
    still = margins_of(TITAN, BODY, FEET, FEET, 0.0, (0.0, 0.0))
    ahead = margins_of(TITAN, BODY, FEET, FEET, 0.0, (0.1, 0.0))
    x, _, z = true_centre(TITAN, BODY, FEET)
    assert still.longitudinal == pytest.approx(0.4) and still.polygon == pytest.approx(0.4)
    assert still.capture == still.polygon
    assert ahead.capture == pytest.approx(min(0.4, 0.5 - x - 0.1 * (z / GRAVITY) ** 0.5))


def test_on_two_feet_there_is_no_margin():
    margins = margins_of(TITAN, BODY, FEET, FEET[:2], 0.0, (0.0, 0.0))
    assert margins.polygon == margins.capture == -float("inf")
