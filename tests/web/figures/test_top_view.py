"""Views from above show where the machine stood, what it swung and where it went."""

import math

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walking_console.web.figures.run_data import RecordedWalk
from walking_console.web.figures.style import INK
from walking_console.web.figures.top_view import (
    leg_colour,
    step_frame,
    stuck_frame,
    travel,
    walk_view,
)
from walking_console.web.scene.palette import LEGS


@pytest.fixture
def ax() -> Axes:
    return Figure().add_subplot()


def marks(ax: Axes, colour: str) -> set[tuple[float, float]]:
    """Where dots of a colour are."""
    return {
        (round(float(x), 3), round(float(y), 3))
        for line in ax.lines
        if line.get_marker() == "o" and line.get_color() == colour
        for x, y in line.get_xydata()
    }


def place(foot: tuple[float, ...]) -> tuple[float, float]:
    return round(foot[0], 3), round(foot[1], 3)


def test_travel_points_from_the_start_to_the_end(walk: RecordedWalk) -> None:
    assert math.degrees(travel(walk)) == pytest.approx(28.0, abs=1.0)


def test_a_shift_on_four_legs_is_drawn_in_ink() -> None:
    assert leg_colour(2) == LEGS[2]
    assert leg_colour(-1) == INK


def test_a_step_shows_its_feet_and_the_landing_in_their_colours(
    ax: Axes, walk: RecordedWalk
) -> None:
    leg = walk.swing(2)
    step_frame(ax, walk, 2)
    after = walk.stance(2)
    for i, foot in enumerate(after.feet):
        assert place(foot) in marks(ax, LEGS[i])
    assert ax.get_title() == f"step 2: leg {leg + 1}"
    carried = {place(f) for i, f in enumerate(walk.stance(1).feet) if i != leg}
    filled = [p for p in ax.patches if p.get_alpha() == 0.13]
    assert {place(tuple(corner)) for corner in filled[0].get_xy()} == carried


def test_where_it_was_stuck_the_end_of_the_way_is_crossed_out(ax: Axes, walk: RecordedWalk) -> None:
    stuck_frame(ax, walk, 1, "leg 2 cannot swing")
    [cross] = [line for line in ax.lines if line.get_marker() == "x"]
    x, y, _, yaw = walk.stance(len(walk.steps)).body
    dx, dy = cross.get_xydata()[0] - (x, y)
    assert math.hypot(dx, dy) > 0.0
    assert math.atan2(dy, dx) == pytest.approx(yaw + math.radians(28.0))


def test_every_foothold_of_a_walk_is_drawn_and_numbered(ax: Axes, walk: RecordedWalk) -> None:
    walk_view(ax, walk)
    for k in range(1, len(walk.steps) + 1):
        leg = walk.swing(k)
        assert place(walk.stance(k).feet[leg]) in marks(ax, LEGS[leg])
    numbers = {n for text in ax.texts for n in text.get_text().split(", ")}
    assert numbers == {str(k) for k in range(1, len(walk.steps) + 1)}


def test_milestones_number_the_way_instead(ax: Axes, walk: RecordedWalk) -> None:
    walk_view(ax, walk, numbers=False, milestones=4)
    wanted = range(0, len(walk.steps) + 1, 4)
    assert [text.get_text() for text in ax.texts] == [str(k) for k in wanted]


def test_the_view_holds_every_foot_and_the_bodies(ax: Axes, walk: RecordedWalk) -> None:
    x1, x2, y1, y2 = walk_view(ax, walk, bodies=(0,))
    feet = walk.log["feet"].reshape(-1, 3)
    assert np.all((feet[:, 0] > x1) & (feet[:, 0] < x2))
    assert np.all((feet[:, 1] > y1) & (feet[:, 1] < y2))
    assert ax.get_xlim() == pytest.approx((x1, x2))
