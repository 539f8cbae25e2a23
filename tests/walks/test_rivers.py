"""Rivers wider than the control reach, walked over with stretched legs in the simulation."""

import numpy as np
import pytest

from walking_console.planner.stability import MARGIN_SLACK

from .telling import feet_in_body_axes, walked


@pytest.mark.parametrize(("width", "degrees"), [(0.5, 0.0), (0.35, 90.0)])
def test_stretched_legs_carry_it_over_a_wide_river(tmp_path, width, degrees):
    """The river of difficulty 0.8 along x, and the widest of whole cells along y: no fall, no slip,
    every foot in its mechanical reach.
    """
    course = f"drive=[{{t=0.0, speed=0.08, crab_angle_deg={degrees}}}]"
    ground = f'terrain={{kind="river", width={width}, at=0.8, heading_deg={degrees}}}'
    walk = walked(tmp_path, "river", ground, course, "end={time=100.0, distance=2.6}", "expect={}")
    summary, log = walk.summary, walk.log
    assert summary["result"] == "completed" and summary["distance"] >= 2.59
    assert (summary["falls"], summary["forbidden_steps"], summary["emergent"]) == (0, 0, {})
    assert summary["margin_min"] >= -MARGIN_SLACK
    moved = np.abs(np.diff(log["feet"], axis=0)).max(axis=2)
    assert moved[log["support"][:-1] & log["support"][1:]].max() < 1e-9, "a foot slips"
    seen = feet_in_body_axes(walk)
    beyond = 0.0
    for i, leg in enumerate(walk.machine.legs):
        for axis, (low, high) in enumerate((leg.x, leg.y)):
            over = max(
                float((low - seen[:, i, axis]).max()), float((seen[:, i, axis] - high).max())
            )
            assert over <= walk.machine.overreach[axis] + 1e-6, (
                f"leg {i + 1} leaves its mechanical reach"
            )
            beyond = max(beyond, over)
    assert beyond > 0.03, "it did not stretch"
