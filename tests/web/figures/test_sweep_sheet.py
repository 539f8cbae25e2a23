"""The sheet of a sweep."""

import pytest

pytest.importorskip("matplotlib")

from walking_console.sim.runs.sweep.grid import Axis
from walking_console.web.figures.sweep_drawing import PassRate, PassRates
from walking_console.web.figures.sweep_sheet import sweep_sheet

X = Axis("terrain.fraction", ("0.5", "0.3"))
BY = Axis("mode", ("paper", "predictive"))
ROW = (PassRate(10, 2), PassRate(10, 9))


def test_one_setting_is_a_curve_alone_in_the_order_of_its_numbers() -> None:
    sheet = sweep_sheet(PassRates("holes", X, None, (ROW,)))
    (ax,) = sheet.axes
    (line,) = [line for line in ax.lines if len(line.get_xdata()) == 2 and line.get_marker() == "o"]
    assert list(line.get_xdata()) == [0.3, 0.5] and list(line.get_ydata()) == [0.9, 0.2]


def test_two_settings_are_curves_and_a_heat_map() -> None:
    sheet = sweep_sheet(PassRates("holes", X, BY, (ROW, ROW)))
    curves, heat = sheet.axes
    assert [text.get_text() for text in curves.get_legend().get_texts()] == [
        "mode = paper",
        "mode = predictive",
    ]
    (image,) = heat.images
    assert image.get_array().tolist() == [[0.2, 0.9], [0.2, 0.9]]
    assert {text.get_text() for text in heat.texts} == {"20%", "90%"}


def test_a_place_where_nothing_ran_yet_is_left_blank() -> None:
    sheet = sweep_sheet(PassRates("holes", X, BY, (ROW, (PassRate(0, 0), PassRate(1, 1)))))
    assert len(sheet.axes[1].texts) == 3
