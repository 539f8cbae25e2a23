"""The standard crab walk against the paper's printed facts and the check values of the gait
specification.
"""

import math

import pytest

from tests.planner.crab.crab_walks import TITAN, Blocked, command, gait, walk
from walking_console.planner.crab.gait import (
    TIE,
    nominal_gait,
    nominal_gait_on,
    posture_of,
    standard_stance,
)
from walking_console.planner.crab.leg_selection import return_length
from walking_console.planner.geometry.paths import ArcPath
from walking_console.planner.initial_stance import Placement
from walking_console.planner.motion.quarter_turns import quarter_turned
from walking_console.planner.motion.strides import LIFT_ROOM
from walking_console.planner.stability import stable_interval, support_polygon

FLAT = lambda x, y: 0.0  # noqa: E731


@pytest.mark.parametrize(
    ("degrees", "stride", "margin", "g0", "hind", "front", "order"),
    [
        (0, 0.5000, 0.0312, 0.0625, 0.1875, 0.1250, (3, 4, 2, 1)),
        (16, 0.5201, 0.0325, 0.0650, 0.1951, 0.1300, (3, 4, 2, 1)),
        (30, 0.5774, 0.0361, 0.0722, 0.2165, 0.1443, (3, 4, 2, 1)),
        (74, 0.3641, 0.0228, 0.0455, 0.1365, 0.0910, (4, 1, 3, 2)),
        (180, 0.5000, 0.0312, 0.0625, 0.1875, 0.1250, (1, 2, 4, 3)),
    ],
)
def test_the_check_values_of_the_specification(degrees, stride, margin, g0, hind, front, order):
    nominal = nominal_gait(TITAN, gait(), math.radians(degrees))
    assert nominal.stride == pytest.approx(stride, abs=6e-5)
    assert nominal.margin == pytest.approx(margin, abs=6e-5)
    plans = walk(command(degrees), 8)
    assert tuple(plan.swing[0] + 1 for plan in plans) == order * 2
    for hind_step, front_step in zip(plans[::2], plans[1::2], strict=True):
        assert hind_step.support_shift == pytest.approx(g0, abs=6e-5)
        assert hind_step.shift == pytest.approx(hind, abs=6e-5)
        assert front_step.support_shift == 0.0
        assert front_step.shift == pytest.approx(front, abs=6e-5)


@pytest.mark.parametrize(("degrees", "sequence"), [(16, "1342"), (74, "1324")])
def test_legs_swing_in_the_order_of_figure_6(degrees, sequence):
    legs = "".join(str(plan.swing[0] + 1) for plan in walk(command(degrees), 8))
    assert sequence in legs


def test_every_angle_folds_within_the_critical_angle_of_the_turned_machine():
    critical = TITAN.critical_angle
    for tenth in range(-1800, 1801):
        angle = math.radians(tenth / 10)
        nominal = nominal_gait(TITAN, gait(), angle)
        half = critical if nominal.quarter_turns % 2 == 0 else math.pi / 2 - critical
        assert abs(math.atan2(nominal.path.uy, nominal.path.ux)) <= half
        assert abs(nominal.course - angle) <= TIE + 1e-9


def test_an_odd_turn_swaps_the_reach_and_relabels_the_legs():
    nominal = nominal_gait(TITAN, gait(), math.pi / 2)
    assert nominal.boxes[0] == (0.30, 0.65, 0.20, 0.70)
    assert nominal.body_leg == (1, 2, 3, 0)


@pytest.mark.parametrize("duty_factor", [0.75, 0.8, 0.9])
def test_exactly_at_the_critical_angle_the_machine_walks_on(duty_factor):
    critical = TITAN.critical_angle
    plans = walk(command(math.degrees(critical)), 16, settings=gait(duty_factor))
    assert not isinstance(plans[-1], Blocked)
    assert min(plan.margin_min - plan.standard_margin for plan in plans) > -1e-6


def test_at_a_switching_point_the_last_foot_is_at_the_front_of_its_stroke():
    for degrees in range(-180, 181, 15):
        settings, angle = gait(), math.radians(degrees)
        stance = standard_stance(TITAN, settings, Placement((1.0, -2.0, 0.3), FLAT, angle))
        nominal = nominal_gait(TITAN, settings, angle)
        posture = posture_of(nominal, stance)
        assert return_length(posture, posture.last) == pytest.approx(0.0, abs=1e-12)
        for i, (x, y) in enumerate(posture.feet):
            box = nominal.boxes[i]
            assert box[0] - 1e-9 <= x <= box[1] + 1e-9 and box[2] - 1e-9 <= y <= box[3] + 1e-9


def test_the_standard_posture_stands_on_the_ground_with_the_body_above_it():
    stance = standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), lambda x, y: 0.1 * x))
    for x, _, z in stance.feet:
        assert z == pytest.approx(0.1 * x)
    assert stance.body[2] == pytest.approx(sum(foot[2] for foot in stance.feet) / 4 + TITAN.height)
    over_a_hole = standard_stance(
        TITAN, gait(), Placement((0.0, 0.0, 0.0), lambda x, y: math.nan if x > 0 and y > 0 else 0.2)
    )
    assert [foot[2] for foot in over_a_hole.feet] == [pytest.approx(0.2)] * 4


def test_a_machine_without_overreach_keeps_room_to_lift_while_the_body_moves():
    from dataclasses import replace

    tight = replace(TITAN, overreach=(0.0, 0.0, 0.15))
    plans = walk(command(20), 12, machine=tight, settings=gait(machine=tight))
    assert not isinstance(plans[-1], Blocked)
    # the foot comes down ahead
    assert plans[-1].speed == pytest.approx(
        LIFT_ROOM / math.cos(math.radians(20)) * 0.64 / TITAN.lift_down
    )


# a line is an arc of turn 0


def straight_as_an_arc(degrees, duty_factor):
    """The walk on a line, and that on an arc of turn 0, worked out as arcs are."""
    settings = gait(duty_factor)
    line = nominal_gait(TITAN, settings, math.radians(degrees))
    course = line.course
    return line, nominal_gait_on(TITAN, settings, ArcPath(math.cos(course), math.sin(course)))


@pytest.mark.parametrize("duty_factor", [0.75, 0.8, 0.9])
def test_an_arc_of_turn_0_has_the_strokes_of_the_line(duty_factor):
    for degrees in range(-180, 180, 5):
        line, arc = straight_as_an_arc(degrees, duty_factor)
        assert arc.stride == pytest.approx(line.stride, abs=1e-9)
        assert arc.ends == pytest.approx(line.ends, abs=1e-9)
        assert arc.spares == pytest.approx(line.spares, abs=1e-9)
        for leg, body_leg in enumerate(line.body_leg):
            turned = quarter_turned(*line.centres[leg], line.quarter_turns)
            assert arc.centres[body_leg] == pytest.approx(turned, abs=1e-9)


@pytest.mark.parametrize("duty_factor", [0.75, 0.8, 0.9])
def test_of_all_orders_and_phases_those_of_the_paper_keep_farthest_inside_on_an_arc_of_turn_0(
    duty_factor,
):
    for degrees in range(-180, 180, 5):
        line, arc = straight_as_an_arc(degrees, duty_factor)
        place = line.body_leg
        for leg in range(4):
            assert arc.order.successor[place[leg]] == place[line.order.successor[leg]]
            assert arc.order.predecessor[place[leg]] == place[line.order.predecessor[leg]]
            assert arc.lags[place[leg]] == pytest.approx(line.lags[leg], abs=1e-9)
            there = [arc.layouts[place[leg]][place[i]] for i in range(4)]
            assert there == pytest.approx(line.layouts[leg], abs=1e-9)


def longitudinal_margin_of(walk_on, leg):
    """Least longitudinal margin of the nominal swing of a leg, on the three others (H §2.4)."""
    ux, uy, _ = walk_on.path
    swing = (1.0 - walk_on.duty_factor) / walk_on.duty_factor * walk_on.stride
    places = list(zip(walk_on.centres, walk_on.layouts[leg], strict=True))
    feet = [(cx + ahead * ux, cy + ahead * uy) for (cx, cy), ahead in places]  # as it lands
    del feet[leg]
    low, high = stable_interval(support_polygon(feet), 0.0, 0.0, ux, uy)
    return min(-low - swing, high)


@pytest.mark.parametrize("degrees", [-35, 0, 16, 90, 180])
def test_on_an_arc_of_turn_0_every_swing_has_the_margin_of_the_line(degrees):
    line, arc = straight_as_an_arc(degrees, 0.8)
    for leg in range(4):
        assert longitudinal_margin_of(line, leg) == pytest.approx(line.margin, abs=1e-9)
        assert longitudinal_margin_of(arc, leg) == pytest.approx(line.margin, abs=1e-9)
