"""Strides that fit a slope, and how far a body may lean with it."""

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from walking_console.planner.crab.gait import nominal_gait
from walking_console.planner.crab.slope_adaptation import walker_on_slopes
from walking_console.planner.motion.body_tilt import LEVEL
from walking_console.planner.motion.slope_strides import (
    SHARE,
    SLACK,
    fitted,
    followed,
)
from walking_console.planner.motion.strides import stroke_length
from walking_console.planner.robot.model import load_machine
from walking_console.planner.types import Gait

TITAN = load_machine("titan3")
GAIT = Gait(TITAN.duty_factor, TITAN.lift_up, TITAN.lift_down, TITAN.height)
WALKER = walker_on_slopes(TITAN, GAIT)
LEVELS = (LEVEL, LEVEL)


def slope(degrees: float, heading: float) -> tuple[float, float]:
    steep = math.tan(math.radians(degrees))
    return steep * math.cos(math.radians(heading)), steep * math.sin(math.radians(heading))


# strides


@pytest.mark.parametrize(
    ("degrees", "heading", "course"), list(product((5, 10, 15), (0, 45, 90, 200), (0, 45, 90)))
)
def test_where_the_standard_walk_fits_the_whole_boxes_the_machine_is_itself(
    degrees: int, heading: int, course: int
) -> None:
    assert fitted(WALKER, 0.0, slope(degrees, heading), LEVELS, math.radians(course)) is TITAN


@pytest.mark.parametrize(
    ("heading", "course"), list(product((0, 45, 90, 135, 250), (0, 30, 45, 90, 160)))
)
def test_on_25_degrees_the_feet_of_the_standard_walk_stand_within_their_heights(
    heading: int, course: int
) -> None:
    gx, gy = slope(25, heading)
    machine = fitted(WALKER, 0.0, (gx, gy), LEVELS, math.radians(course))
    assert machine is not None
    # one box mirrored to four quadrants, or ``reach`` raises
    assert machine.reach.z_span == TITAN.reach.z_span
    nominal = nominal_gait(machine, GAIT, math.radians(course))
    if machine is not TITAN:
        assert nominal.stride <= nominal_gait(TITAN, GAIT, math.radians(course)).stride
    ux, uy = math.cos(nominal.course), math.sin(nominal.course)
    for row in nominal.layouts:
        heights = []
        for leg, ahead in zip(nominal.body_leg, row, strict=True):
            cx, cy = machine.legs[leg].centre
            heights.append(gx * (cx + ahead * ux) + gy * (cy + ahead * uy))
        assert max(heights) - min(heights) <= TITAN.reach.z_span * (
            1.0 - SLACK / 2 if machine is not TITAN else 1.0
        )


def test_inner_edges_stay_and_no_box_grows() -> None:
    machine = fitted(WALKER, 0.0, slope(25, 45), LEVELS, 0.0)
    assert machine is not None
    assert machine.reach.x0 == TITAN.reach.x0 and machine.reach.y0 == TITAN.reach.y0
    assert machine.reach.x_span < TITAN.reach.x_span and machine.reach.y_span < TITAN.reach.y_span
    assert machine.legs[0].z == TITAN.legs[0].z and machine.speed == TITAN.speed


@pytest.mark.parametrize("lean", [LEVEL, (0.06, 0.06)])
def test_a_machine_a_fifth_as_large_takes_the_same_strides_a_fifth_as_long(
    lean: tuple[float, float],
) -> None:
    def fifth(span: tuple[float, float]) -> tuple[float, float]:
        return span[0] / 5, span[1] / 5

    legs = tuple(replace(leg, x=fifth(leg.x), y=fifth(leg.y), z=fifth(leg.z)) for leg in TITAN.legs)
    small = replace(TITAN, legs=legs, overreach=(0.01, 0.01, 0.03))
    short = Gait(GAIT.duty_factor, GAIT.lift_up / 5, GAIT.lift_down / 5, GAIT.height / 5)
    one, other = (
        fitted(walker_on_slopes(machine, gait), 0.0, slope(25, 45), (lean, lean), 0.0)
        for machine, gait in ((TITAN, GAIT), (small, short))
    )
    assert one is not None and other is not None and one is not TITAN
    assert np.allclose(np.array(one.boxes) / 5, np.array(other.boxes))


def test_nothing_fits_a_wall() -> None:
    assert fitted(WALKER, 0.0, slope(44, 45), LEVELS, 0.0) is None


def test_a_machine_that_turns_fits_every_heading() -> None:
    turning = fitted(WALKER, 0.0, slope(20, 0), LEVELS, None)
    assert turning is not None and turning is not TITAN
    outer = math.hypot(
        turning.reach.x0 + turning.reach.x_span, turning.reach.y0 + turning.reach.y_span
    )
    assert 2 * math.tan(math.radians(20)) * outer <= TITAN.reach.z_span
    assert turning is fitted(WALKER, 1.1, slope(20, 0), LEVELS, None)
    assert fitted(WALKER, 0.0, slope(10, 0), LEVELS, None) is TITAN


# leaning


@pytest.mark.parametrize(
    ("degrees", "heading", "course"),
    list(product((5, 10, 15, 20, 25), (0, 45, 90, 210), (0, 45, 90))),
)
def test_the_lean_taken_leaves_the_share_of_the_longest_stride(
    degrees: int, heading: int, course: int
) -> None:
    gx, gy = (round(v, 4) for v in slope(degrees, heading))

    def stride(share: float) -> float:
        lean = share * gx, share * gy
        fit = fitted(WALKER, 0.0, (gx, gy), (lean, lean), math.radians(course))
        return (
            0.0
            if fit is None
            else stroke_length(fit.reach.x_span, fit.reach.y_span, math.radians(course))
        )

    taken = followed(WALKER, 0.0, (gx, gy), math.radians(course))
    longest = max(stride(k / 10) for k in range(11))
    assert stride(taken) >= SHARE * longest > 0.0
    assert taken == 1.0 or stride(min(1.0, taken + 0.1)) < SHARE * longest


def test_a_diagonal_slope_of_25_degrees_is_walked_in_longer_strides_with_a_lean() -> None:
    steep = slope(25, 45)
    leans = [(share * steep[0], share * steep[1]) for share in (0.0, 0.25)]
    level, leaning = (fitted(WALKER, 0.0, steep, (lean, lean), 0.0) for lean in leans)
    assert level is not None and leaning is not None
    assert leaning.reach.x_span > 1.2 * level.reach.x_span
