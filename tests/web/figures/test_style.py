"""Marks every drawing shares: cells as few outlines, and the same drawing as the same file."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from walking_console.web.figures.run_data import FigureError
from walking_console.web.figures.style import (
    arrow,
    blank_sheet,
    cells,
    leg_key,
    rectangle,
    runs,
    save,
    scale_bar,
    torso,
)


def axes() -> tuple[Figure, object]:
    sheet = blank_sheet(4.0, 3.0, "Title", "and what is drawn")
    return sheet, sheet.add_subplot()


def area(vertices: np.ndarray) -> float:
    x, y = vertices.T
    return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)))


def test_runs_are_where_flags_are_true() -> None:
    assert runs(np.array([True, True, False, True])) == [(0, 2), (3, 4)]
    assert runs(np.zeros(3, bool)) == []


def test_marked_cells_are_outlined_block_by_block() -> None:
    _, ax = axes()
    mask = np.zeros((6, 8), bool)
    mask[1:4, 2:5] = True  # one block of three rows
    mask[4, 2:4] = True  # narrower: another
    cells(ax, mask, 0.5, (1.0, 2.0), (1.0, 5.0, 2.0, 5.0))
    [patch] = ax.patches
    outlines = patch.get_path().to_polygons()
    assert len(outlines) == 2
    assert sum(area(outline) for outline in outlines) == pytest.approx(11 * 0.25)
    assert outlines[0].min(axis=0) == pytest.approx((2.0, 2.5))


def test_only_cells_in_the_box_are_drawn() -> None:
    _, ax = axes()
    cells(ax, np.ones((6, 8), bool), 1.0, (0.0, 0.0), (2.0, 4.0, 1.0, 3.0))
    [outline] = ax.patches[0].get_path().to_polygons()
    assert outline.min(axis=0) == pytest.approx((2.0, 1.0))
    assert outline.max(axis=0) == pytest.approx((4.0, 3.0))


def test_where_nothing_is_marked_nothing_is_drawn() -> None:
    _, ax = axes()
    cells(ax, np.zeros((6, 8), bool), 1.0, (0.0, 0.0), (0.0, 8.0, 0.0, 6.0))
    assert len(ax.patches) == 0


def test_what_is_drawn_in_body_axes_is_placed_where_the_body_is() -> None:
    _, ax = axes()
    rectangle(ax, (1.0, 2.0, 0.0, 0.5), (10.0, 20.0, np.pi / 2))
    patch = ax.patches[0]
    corners = (patch.get_transform() - ax.transData).transform(patch.get_path().vertices)
    assert corners.min(axis=0) == pytest.approx((9.5, 21.0))
    assert corners.max(axis=0) == pytest.approx((10.0, 22.0))


def test_the_torso_has_its_nose_in_front() -> None:
    _, ax = axes()
    torso(ax, (1.0, 0.5), (0.0, 0.0, np.pi))
    nose = ax.patches[1]
    points = (nose.get_transform() - ax.transData).transform(nose.get_xy())
    assert points[:, 0].min() == pytest.approx(-0.47)
    assert points[:, 0].max() < -0.3


def test_an_arrow_without_a_way_is_not_drawn() -> None:
    _, ax = axes()
    arrow(ax, (1.0, 1.0), (1.0, 1.0))
    assert len(ax.texts) == 0
    arrow(ax, (1.0, 1.0), (1.0, 2.0))
    assert len(ax.texts) == 1


def test_the_scale_bar_says_how_long_it_is() -> None:
    _, ax = axes()
    scale_bar(ax, 1.0, 2.0)
    assert np.ptp(ax.lines[0].get_xdata()) == pytest.approx(0.5)
    assert ax.texts[0].get_text() == "0.5 m"


def test_every_leg_is_named_in_the_key() -> None:
    sheet, _ = axes()
    leg_key(sheet, ("FL", "RL", "RR", "FR"))
    assert [text.get_text() for text in sheet.texts[2:]] == ["1 FL", "2 RL", "3 RR", "4 FR"]


def test_the_same_drawing_is_the_same_file(tmp_path: Path) -> None:
    for name in ("a.svg", "b.svg"):
        save(axes()[0], tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    assert "and what is drawn" in (tmp_path / "a.svg").read_text()


def test_a_file_that_cannot_be_written_is_said_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(FigureError, match=r"should end in .svg, .png or .pdf"):
        save(axes()[0], tmp_path / "figure.docx")
    with pytest.raises(FigureError, match="cannot write"):
        save(axes()[0], tmp_path / "nowhere" / "figure.svg")
