"""Views from the side: distances along and across the way, paths, and the rule compared with."""

import math

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walking_console.web.figures.run_data import RecordedWalk
from walking_console.web.figures.side_view import (
    across,
    along,
    average_of_carrying,
    average_path,
    body_path,
    foot_paths,
    second_differences,
    section,
    side_view,
    silhouette,
)
from walking_console.web.figures.style import INK
from walking_console.web.scene.palette import LEGS


@pytest.fixture
def ax() -> Axes:
    return Figure().add_subplot()


def test_along_and_across_are_the_two_ways_from_the_start(walk: RecordedWalk) -> None:
    x, y = walk.body[0, :2]
    left_and_ahead = np.array([(x - 1.0, y + 2.0)])
    assert along(walk, left_and_ahead, math.pi / 2)[0] == pytest.approx(2.0)
    assert across(walk, left_and_ahead, math.pi / 2)[0] == pytest.approx(1.0)


def test_the_section_has_gaps_where_there_are_holes(ax: Axes, walk: RecordedWalk) -> None:
    section(ax, walk, 0.0, (-1.0, 2.0))
    way, heights = ax.lines[0].get_data()
    x, y = walk.body[0, :2]
    truth = walk.height_at(x + way, np.full(way.shape, y))
    assert np.isnan(truth).any()
    assert np.array_equal(np.isnan(heights), np.isnan(truth))


def test_every_foot_has_its_path_and_a_dot_where_it_came_down(ax: Axes, walk: RecordedWalk) -> None:
    foot_paths(ax, walk, 0.0)
    for leg in range(4):
        mine = [line for line in ax.lines if line.get_color() == LEGS[leg]]
        path = next(line for line in mine if line.get_marker() == "None")
        assert path.get_ydata() == pytest.approx(walk.log["feet"][:, leg, 2])
        landings = [k for k in range(1, len(walk.steps) + 1) if walk.swing(k) == leg]
        assert len(mine) - 1 == len(landings)


def test_feet_outside_the_strip_are_left_out(ax: Axes, walk: RecordedWalk) -> None:
    foot_paths(ax, walk, 0.0, strip=(100.0, 101.0))
    assert np.isnan(ax.lines[0].get_ydata()).all()


def test_the_path_of_the_body_has_a_dot_at_every_switching_point(
    ax: Axes, walk: RecordedWalk
) -> None:
    body_path(ax, walk, 0.0)
    path, dots = ax.lines
    assert path.get_ydata() == pytest.approx(walk.body[:, 2])
    assert len(dots.get_xdata()) == len(walk.steps) + 1


def test_on_level_ground_the_rule_gives_the_standing_height(ax: Axes, walk: RecordedWalk) -> None:
    average_path(ax, walk, 0.0)
    assert ax.lines[0].get_ydata() == pytest.approx(walk.gait.height, abs=0.01)
    assert average_of_carrying(walk) == pytest.approx(walk.gait.height, abs=0.05)


def test_a_level_walk_has_no_second_differences(walk: RecordedWalk) -> None:
    for places, bends in second_differences(walk):
        assert len(places) == len(bends) > 5
        assert bends == pytest.approx(0.0, abs=0.01)


def test_the_silhouette_joins_hips_and_feet(ax: Axes, walk: RecordedWalk) -> None:
    silhouette(ax, walk, 0, 0.0)
    lines = ax.patches[1:]
    feet = walk.stance(0).feet
    x = walk.body[0, 0]
    ends = [tuple(line.get_xy()[-1]) for line in lines]
    assert ends == [pytest.approx((foot[0] - x, foot[2])) for foot in feet]


def test_the_whole_side_view_is_true_to_scale(ax: Axes, walk: RecordedWalk) -> None:
    side_view(ax, walk, 0.0, bodies=(0, 1))
    assert ax.get_aspect() == 1.0
    assert {line.get_color() for line in ax.lines} >= {INK, *LEGS[:4]}
