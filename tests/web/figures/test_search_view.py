"""The search domain of a step: the landing lies in it, its limits run from the foot across."""

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.path import Path

from walking_console.web.figures.run_data import RecordedWalk
from walking_console.web.figures.search_view import domain_marks
from walking_console.web.figures.style import INK


@pytest.fixture
def ax() -> Axes:
    return Figure().add_subplot()


@pytest.mark.parametrize("k", [1, 2, 3, 4])
def test_the_landing_lies_in_the_domain_that_is_drawn(ax: Axes, walk: RecordedWalk, k: int) -> None:
    domain_marks(ax, walk, k)
    [filled] = ax.collections
    shape = filled.get_paths()[0]
    placed = (filled.get_transform() - ax.transData).transform(shape.vertices)
    x, y = walk.steps[k - 1]["landing"][:2]
    assert Path(placed, shape.codes).contains_point((x, y), radius=0.02)


def test_the_start_of_the_search_is_marked(ax: Axes, walk: RecordedWalk) -> None:
    domain_marks(ax, walk, 1)
    [cross] = [line for line in ax.lines if line.get_marker() == "+"]
    assert cross.get_xydata()[0] == pytest.approx(walk.steps[0]["search_start"][:2])
    assert [text.get_text() for text in ax.texts][-1] == "$I_u$"


def test_limits_are_drawn_for_rear_legs_from_the_foot_in_front_across(
    ax: Axes, walk: RecordedWalk
) -> None:
    k = next(k for k in range(1, len(walk.steps) + 1) if walk.swing(k) == 1)
    domain_marks(ax, walk, k)
    limits = [line for line in ax.lines if line.get_color() == INK and line.get_linestyle() == "-"]
    starts = [tuple(line.get_xydata()[0]) for line in limits if len(line.get_xydata()) == 2]
    feet = np.array(walk.stance(k - 1).feet)[:, :2]
    assert starts[0] == pytest.approx(feet[3])


def test_a_step_that_searched_nothing_has_no_marks(ax: Axes, walk: RecordedWalk) -> None:
    steps = [{**walk.steps[0], "search_start": None}, *walk.steps[1:]]
    plain = RecordedWalk(
        walk.summary, walk.log, steps, walk.ground, walk.believed, walk.machine, walk.gait
    )
    domain_marks(ax, plain, 1)
    assert not ax.lines and not ax.collections
