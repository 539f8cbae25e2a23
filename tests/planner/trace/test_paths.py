"""Traces keep their shape, their length and their yaw."""

import math

import numpy as np
import pytest

from walking_console.planner.geometry.paths import SampledPath, arc_of_command
from walking_console.planner.trace.paths import KINDS, STEP, TraceError, joystick_trace, trace_from

RHO = 0.75


def lengths(course: SampledPath) -> np.ndarray:
    return np.sqrt(
        np.diff(course.x) ** 2 + np.diff(course.y) ** 2 + (RHO * np.diff(course.yaw)) ** 2
    )


@pytest.mark.parametrize("kind", KINDS)
def test_samples_are_equally_far_apart_in_s(kind: str) -> None:
    course = trace_from({"kind": kind, "waypoints": [[0, 0, 0], [2, 1, 45], [3, 3, 90]]}, RHO)
    assert np.allclose(lengths(course), STEP, rtol=2e-3)


def test_the_default_sine_is_the_papers_curve() -> None:
    course = trace_from({"kind": "sine"}, RHO)
    assert np.abs(course.y - 0.6 * np.sin(course.x)).max() < 1e-4
    assert np.ptp(course.yaw) == 0.0
    assert course.x[-1] == pytest.approx(8.0, abs=STEP)


def test_a_turn_on_the_spot_has_a_length_too() -> None:
    course = trace_from({"kind": "turn"}, RHO)
    assert course.length == pytest.approx(2 * math.pi * RHO, abs=STEP)
    assert np.ptp(course.x) == np.ptp(course.y) == 0.0


def test_a_circle_comes_back() -> None:
    x, y, yaw = trace_from({"kind": "circle", "radius": 1.5}, RHO, (1.0, 2.0, 0.5)).pose(math.inf)
    assert (x, y) == pytest.approx((1.0, 2.0), abs=0.02)
    assert yaw == pytest.approx(0.5 + 2 * math.pi, abs=0.02)


def test_waypoints_are_passed_with_their_yaws() -> None:
    course = trace_from(
        {"kind": "waypoints", "waypoints": [[0, 0, 0], [2, 1, 45], [3, 3, 90]], "yaw": "fixed"}, RHO
    )
    off = np.abs(course.x - 2) + np.abs(course.y - 1) + np.abs(course.yaw - math.radians(45))
    assert off.min() < 0.02


def test_a_joystick_trace_is_the_twist_of_the_course_core() -> None:
    arc, _ = arc_of_command(0.4, 0.2, -0.3, RHO)
    course = joystick_trace((0.0, 0.0, 0.0), 0.4, 0.2, -0.3, RHO, ahead=2.0)
    for k in (0, 50, 200):
        assert (course.x[k], course.y[k], course.yaw[k]) == pytest.approx(
            arc.pose(k * STEP), abs=1e-12
        )


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ({"kind": "loop"}, "unknown trace kind 'loop'; there are: waypoints, line"),
        ({"kind": "sine", "yaw": "free"}, "there are: tangent, fixed"),
        ({"kind": "circle", "radius": -1}, "radius must be a number from"),
        ({"kind": "waypoints", "waypoints": [[0, 0]]}, "at least two"),
        ({"kind": "waypoints", "waypoints": [[0, 0], [0, 0]]}, "the same"),
        ({"kind": "waypoints", "waypoints": [[0, 0], [1, math.nan]]}, "waypoint 2"),
    ],
)
def test_a_trace_that_cannot_be_drawn_says_why(spec: dict[str, object], words: str) -> None:
    with pytest.raises(TraceError, match=words.replace("[", r"\[")):
        trace_from(spec, RHO)
