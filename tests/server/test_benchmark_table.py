"""The table of ``walking-console bench``."""

import io

from rich.console import Console

from walking_console.server.benchmark_table import (
    print_figures,
    print_ratios,
    print_walks,
    walks_in_markdown,
)
from walking_console.sim.runs.comparison import Ratio

FIGURES = {
    "version": "0.2.0",
    "python": "3.11.7",
    "figures": {
        "plan": {"value": 1.25, "unit": "ms", "target": "under 5"},
        "headless": {"value": 80.0, "unit": "times life", "target": "over 20"},
    },
}


def test_every_figure_is_a_row_with_value_unit_and_target() -> None:
    said = io.StringIO()
    print_figures(FIGURES, Console(file=said, width=120))
    rows = [line for line in said.getvalue().splitlines() if "plan" in line or "headless" in line]
    assert len(rows) == 2
    for row, entry in zip(rows, FIGURES["figures"].values(), strict=True):
        assert f"{entry['value']:g}" in row and entry["unit"] in row and entry["target"] in row
    assert "walking-console 0.2.0, Python 3.11.7" in said.getvalue()


WALKS = {
    "version": "0.2.0",
    "python": "3.11.7",
    "walks": [
        {
            "scenario": "dem",
            "planner": "crab",
            "plant": "kinematic",
            "sensing": "eye",
            "distance": 3.21,
            "prepare": 41.0,
            "first": 1.25,
            "median": 0.0125,
            "p99": 2.4,
            "p999": 5.2,
            "largest": 14.3,
            "per_metre": 77.0,
            "factor": 252.0,
        },
    ],
}
ROW = "dem crab kinematic eye 3.21 41 1.25 12 2.40 5.20 14.30 77 252".split()


def test_every_walk_is_a_row_of_its_figures() -> None:
    said = io.StringIO()
    print_walks(WALKS, Console(file=said, width=80))
    row = next(line for line in said.getvalue().splitlines() if "dem" in line)
    assert row.split() == [*ROW[:4], *ROW[-6:]]


def test_a_document_gets_the_same_rows_in_markdown() -> None:
    head, rule, row = walks_in_markdown(WALKS).splitlines()
    assert [cell.strip() for cell in row.strip("|").split("|")] == ROW
    assert head.count("|") == rule.count("|") == row.count("|")


def test_a_walk_that_went_nowhere_leaves_the_time_a_metre_empty() -> None:
    stood = {**WALKS, "walks": [{**WALKS["walks"][0], "per_metre": None}]}
    assert "| 14.30 |  | 252 |" in walks_in_markdown(stood)


def test_ratios_are_printed_with_what_they_are_of() -> None:
    said = io.StringIO()
    print_ratios([Ratio("flat crab", "median", 0.03, 0.02)], Console(file=said, width=120))
    row = next(line for line in said.getvalue().splitlines() if "flat" in line)
    assert row.replace("│", " ").split() == ["flat", "crab", "median", "0.03", "0.02", "1.500"]
