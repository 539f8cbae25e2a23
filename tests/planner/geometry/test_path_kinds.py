"""Given paths keep their shape, their length and their yaw."""

import math

import numpy as np
import pytest

from walking_console.planner.geometry.path_kinds import (
    PATH_KINDS,
    STEP,
    TraceError,
    path_from,
    sampled,
)
from walking_console.planner.geometry.paths import SampledPath
from walking_console.planner.geometry.transforms import Pose

RHO = 0.75


WAYPOINTS = [[0, 0, 0], [2, 1, 45], [3, 3, 90]]


def drawn(spec: dict[str, object], start: Pose = (0.0, 0.0, 0.0)) -> SampledPath:
    return sampled(path_from(spec), RHO, start)


def lengths(course: SampledPath) -> np.ndarray:
    return np.sqrt(
        np.diff(course.x) ** 2 + np.diff(course.y) ** 2 + (RHO * np.diff(course.yaw)) ** 2
    )


@pytest.mark.parametrize("kind", PATH_KINDS)
def test_samples_are_equally_far_apart_in_s(kind: str) -> None:
    course = drawn({"kind": kind, **({"waypoints": WAYPOINTS} if kind == "waypoints" else {})})
    assert np.allclose(lengths(course), STEP, rtol=2e-3)


def test_the_default_sine_is_the_papers_curve() -> None:
    course = drawn({"kind": "sine"})
    assert np.abs(course.y - 0.6 * np.sin(course.x)).max() < 1e-4
    assert np.ptp(course.yaw) == 0.0
    assert course.x[-1] == pytest.approx(8.0, abs=STEP)


def test_a_turn_on_the_spot_has_a_length_too() -> None:
    course = drawn({"kind": "turn"})
    assert course.length == pytest.approx(2 * math.pi * RHO, abs=STEP)
    assert np.ptp(course.x) == np.ptp(course.y) == 0.0


def test_a_circle_comes_back() -> None:
    x, y, yaw = drawn({"kind": "circle", "radius": 1.5}, (1.0, 2.0, 0.5)).pose(math.inf)
    assert (x, y) == pytest.approx((1.0, 2.0), abs=0.02)
    assert yaw == pytest.approx(0.5 + 2 * math.pi, abs=0.02)


def test_waypoints_are_passed_with_their_yaws() -> None:
    course = drawn({"kind": "waypoints", "waypoints": WAYPOINTS, "yaw": "fixed"})
    off = np.abs(course.x - 2) + np.abs(course.y - 1) + np.abs(course.yaw - math.radians(45))
    assert off.min() < 0.02


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ({"kind": "loop"}, "unknown trace kind 'loop'; there are: waypoints, line"),
        ({"kind": "sine", "yaw": "free"}, "there are: tangent, fixed"),
        ({"kind": "circle", "radius": -1}, "radius must be a number from"),
        ({"kind": "circle", "radius": True}, "radius must be a number from"),
        ({"kind": "circle", "angle_deg": 3601}, "angle_deg must be a number from -3600 to 3600"),
        ({"kind": "circle", "angle_deg": 0}, "must not be 0"),
        (
            {"kind": "circle", "diameter": 1},
            "unknown key 'diameter'; there are: yaw, speed, radius",
        ),
        ({"kind": "waypoints"}, "waypoints is missing"),
        ({"kind": "line", "speed": 0}, "speed must be a number from"),
        ({"kind": "waypoints", "waypoints": [[0, 0]]}, "at least two"),
        ({"kind": "waypoints", "waypoints": [[0, 0], [0, 0]]}, "the same"),
        ({"kind": "waypoints", "waypoints": [[0, 0], [1, math.nan]]}, "waypoint 2"),
    ],
)
def test_a_trace_that_cannot_be_drawn_says_why(spec: dict[str, object], words: str) -> None:
    with pytest.raises(TraceError, match=words.replace("[", r"\[")):
        drawn(spec)
