"""What bars the way is named as the map has it."""

import math

import numpy as np
import pytest

from walking_console.planner.control.barred_way import what_bars
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap

TITAN = load_machine("titan3")
BODY = (0.0, 0.0, TITAN.height, 0.0)


def wall(x, left, right, height=1.0):
    """Level ground with a wall 0.2 m deep at x, from so far left to so far right, m."""
    heights = np.zeros((160, 160))
    centres = (np.arange(160) + 0.5) * 0.05 - 4.0
    along = (centres > x) & (centres < x + 0.2)
    across = (centres < left) & (centres > -right)
    heights[np.ix_(across, along)] = height
    return TerrainMap(heights, heights > 0.0, 0.05, (-4.0, -4.0))


def test_a_wall_ahead_is_named_with_how_far_it_is_and_how_far_it_goes_to_either_side():
    text = what_bars(BODY, 0.0, wall(1.0, left=0.75, right=0.4), TITAN)
    stands = "stands 1.0 m before its middle, from 0.7 m left to 0.4 m right of its line"
    assert text == f": what no leg can be lifted over {stands}"


@pytest.mark.parametrize(
    "terrain",
    [wall(1.0, 0.75, 0.4, height=0.3), wall(3.5, 0.75, 0.4), wall(1.0, 3.0, -1.5)],
    ids=["low enough to be lifted over", "too far ahead", "beside its lane"],
)
def test_what_does_not_bar_it_is_not_named(terrain):
    assert what_bars(BODY, 0.0, terrain, TITAN) == ""


def test_it_is_looked_for_where_the_course_leads_whatever_the_body_points_at():
    beside = wall(-0.1, left=1.6, right=-1.1)
    assert what_bars(BODY, 0.0, beside, TITAN) == ""
    for yaw in (0.0, 1.0):
        body = (*BODY[:3], yaw)
        text = what_bars(body, math.pi / 2.0, beside, TITAN)
        assert "1.1 m before its middle, from 0.1 m left to 0.1 m right" in text
