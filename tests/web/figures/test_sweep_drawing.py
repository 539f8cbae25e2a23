"""Pass rates of a sweep, counted from its table."""

import json
from pathlib import Path

import pytest

from walking_console.sim.runs.sweep.grid import Axis
from walking_console.sim.runs.sweep.table import write_tables
from walking_console.web.figures.run_data import FigureError
from walking_console.web.figures.sweep_drawing import PassRate, draw_sweep, pass_rates, places

AXES = (
    Axis("mode", ("paper",)),
    Axis("terrain.fraction", ("0.5", "0.3")),
    Axis("robot", ("titan3", "hexapod", "phantomx")),
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two seeds each; titan3 fails at 0.5, and one phantomx of two."""
    told = {"schema": 1, "scenario": "holes", "set": [[a.key, list(a.values)] for a in AXES]}
    (tmp_path / "sweep.json").write_text(json.dumps(told))
    rows = []
    for fraction in AXES[1].values:
        for robot in AXES[2].values:
            for seed in (1, 2):
                passed = not (
                    fraction == "0.5" and (robot == "titan3" or (robot, seed) == ("phantomx", 1))
                )
                rows.append({"run": len(rows), "mode": "paper", "terrain.fraction": fraction,
                             "robot": robot, "seed": seed, "passed": passed})  # fmt: skip
    write_tables(tmp_path, AXES, rows)
    return tmp_path


def test_the_first_two_settings_that_vary_are_drawn(folder: Path) -> None:
    rates = pass_rates(folder)
    assert rates.by is not None and (rates.x.key, rates.by.key) == ("terrain.fraction", "robot")
    assert rates.runs == 12
    assert [[rate.share for rate in row] for row in rates.rates] == [
        [0.0, 1.0],
        [1.0, 1.0],
        [0.5, 1.0],
    ]


def test_others_may_be_asked_for(folder: Path) -> None:
    rates = pass_rates(folder, x="robot", by="terrain.fraction")
    assert [[rate.passed for rate in row] for row in rates.rates] == [[0, 2, 1], [2, 2, 2]]


@pytest.mark.parametrize(
    ("x", "by", "said"),
    [
        ("mode", None, "does not vary"),
        ("speed", None, "terrain.fraction, robot"),
        ("robot", "robot", "both"),
    ],
)
def test_settings_that_do_not_vary_are_refused(folder: Path, x, by, said) -> None:
    with pytest.raises(FigureError, match=said):
        pass_rates(folder, x, by)


def test_a_sweep_of_seeds_alone_has_no_curve(tmp_path: Path) -> None:
    (tmp_path / "sweep.json").write_text(json.dumps({"schema": 1, "set": []}))
    with pytest.raises(FigureError, match="nothing varies"):
        pass_rates(tmp_path)


def test_a_missing_table_is_one_clear_line(folder: Path) -> None:
    (folder / "table.csv").unlink()
    with pytest.raises(FigureError, match="cannot read the table"):
        draw_sweep(folder, folder / "s.svg")


@pytest.mark.parametrize(
    ("runs", "passed", "interval"),
    [(10, 5, (0.2366, 0.7634)), (20, 20, (0.8389, 1.0)), (10, 0, (0.0, 0.2775))],
)
def test_the_interval_is_wilsons(runs: int, passed: int, interval: tuple[float, float]) -> None:
    """Values of Newcombe (1998) and of statsmodels' proportion_confint."""
    assert PassRate(runs, passed).interval == pytest.approx(interval, abs=5e-5)


def test_numbers_stand_where_they_are_and_words_in_a_row() -> None:
    assert places(AXES[1]) == [0.5, 0.3]
    assert places(AXES[2]) == [0.0, 1.0, 2.0]
