"""Strokes, the critical angle and the rectangles in which footholds are planned."""

import math
from dataclasses import replace

import pytest

from walking_console.planner.geometry.paths import ArcPath, arc_exit
from walking_console.planner.motion.strides import (
    LIFT_ROOM,
    STRETCHED_LIFT_ROOM,
    STROKE_MAX,
    centres_of,
    kept,
    mechanical_boxes,
    planning_boxes,
    stroke_length,
    strokes_on,
)
from walking_console.planner.robot.model import load_machine

TITAN = load_machine("titan3")


def test_the_stroke_is_the_shorter_way_through_the_reach():
    assert stroke_length(0.5, 0.35, 0.0) == 0.5
    assert stroke_length(0.5, 0.35, math.pi / 2) == pytest.approx(0.35)
    assert stroke_length(0.5, 0.35, math.atan2(0.35, 0.5)) == pytest.approx(math.hypot(0.5, 0.35))
    assert stroke_length(0.5, 0.35, -0.3) == stroke_length(0.5, 0.35, 0.3)


def test_the_critical_angle_points_at_the_middle_of_the_reach():
    x, y = TITAN.legs[0].centre
    assert TITAN.critical_angle == pytest.approx(math.atan2(y, x))


def test_room_to_lift_is_kept_of_the_control_reach_only_where_the_overreach_has_none():
    tight = replace(TITAN, overreach=(0.05, 0.005, 0.15))
    assert kept(tight, stretched=False) == (0.0, pytest.approx(LIFT_ROOM - 0.005))
    stretched = STRETCHED_LIFT_ROOM - 0.05, STRETCHED_LIFT_ROOM - 0.005
    assert kept(tight, stretched=True) == pytest.approx(stretched)


@pytest.mark.parametrize("turns", range(4))
def test_a_quarter_turn_swaps_the_reach_along_and_across_and_keeps_the_quadrants(turns):
    x1, x2, y1, y2 = TITAN.boxes[0]
    planned = planning_boxes(TITAN, turns, stretched=False)
    assert planned[0] == ((x1, x2, y1, y2) if turns % 2 == 0 else (y1, y2, x1, x2))
    for (ax, bx, ay, by), (sx, sy) in zip(
        planned, ((1, 1), (-1, 1), (-1, -1), (1, -1)), strict=True
    ):
        assert ax < bx and ay < by
        assert (math.copysign(1, ax), math.copysign(1, ay)) == (sx, sy)


def test_stretched_legs_are_planned_for_just_inside_their_mechanical_reach():
    far = mechanical_boxes(TITAN, 1)
    for near, box in zip(planning_boxes(TITAN, 1, stretched=True), far, strict=True):
        assert [abs(a - b) for a, b in zip(near, box, strict=True)] == pytest.approx(
            [STRETCHED_LIFT_ROOM] * 4
        )


@pytest.mark.parametrize("turn", [0.0, 0.3, -1.0])
def test_every_foot_stays_in_its_reach_for_the_stroke_the_legs_share(turn):
    path = ArcPath(1.0, 0.0, turn)
    boxes = planning_boxes(TITAN, 0, stretched=False)
    strokes = strokes_on(boxes, path)
    assert strokes.centres == centres_of(boxes) and 0.0 < strokes.stride <= STROKE_MAX
    for centre, end, spare, box in zip(
        strokes.centres, strokes.ends, strokes.spares, boxes, strict=True
    ):
        assert end + spare == pytest.approx(arc_exit(*centre, box, path), abs=1e-9)
        back = arc_exit(*centre, box, path.reversed())
        assert strokes.stride - end <= back + 1e-9
    if turn == 0.0:
        assert strokes.stride == pytest.approx(stroke_length(0.5, 0.35, 0.0))
