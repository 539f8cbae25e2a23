"""The gait diagram: a bar wherever a foot stood, a step's number in its gap."""

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walking_console.web.figures.gait_diagram import gait_diagram, swing_order
from walking_console.web.figures.run_data import RecordedWalk


@pytest.fixture
def drawn(walk: RecordedWalk) -> Axes:
    ax = Figure().add_subplot()
    gait_diagram(ax, walk)
    return ax


def test_legs_are_in_the_order_of_their_first_swings(walk: RecordedWalk) -> None:
    order = swing_order(walk)
    firsts = [next(k for k, s in enumerate(walk.steps) if leg + 1 in s["swing"]) for leg in order]
    assert sorted(order) == [0, 1, 2, 3]
    assert firsts == sorted(firsts)


def test_a_foot_has_bars_exactly_over_the_way_it_stood(walk: RecordedWalk, drawn: Axes) -> None:
    for place, leg in enumerate(swing_order(walk)):
        bars = [bar for bar in drawn.patches if abs(bar.get_y() + 0.21 + place) < 1e-9]
        stood = walk.log["support"][:, leg]
        way = np.diff(walk.way)
        assert sum(bar.get_width() for bar in bars) == pytest.approx(
            way[stood[:-1]].sum(), abs=1e-9
        )


def test_every_wide_gap_has_the_number_of_its_step(walk: RecordedWalk, drawn: Axes) -> None:
    numbers = [int(text.get_text()) for text in drawn.texts]
    assert numbers and numbers == sorted(numbers)
    order = swing_order(walk)
    for text in drawn.texts:
        k = int(text.get_text())
        assert order[-round(text.get_position()[1])] == walk.swing(k)
