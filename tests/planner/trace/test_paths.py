"""What the trace walker follows when it is given no trace."""

import pytest

from walking_console.planner.geometry.path_kinds import STEP
from walking_console.planner.geometry.paths import arc_of_command
from walking_console.planner.trace.paths import joystick_trace

RHO = 0.75


def test_a_joystick_trace_is_the_twist_of_the_course_core() -> None:
    arc, _ = arc_of_command(0.4, 0.2, -0.3, RHO)
    course = joystick_trace((0.0, 0.0, 0.0), 0.4, 0.2, -0.3, RHO, ahead=2.0)
    for k in (0, 50, 200):
        assert (course.x[k], course.y[k], course.yaw[k]) == pytest.approx(
            arc.pose(k * STEP), abs=1e-12
        )
