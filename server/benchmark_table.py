"""The tables of ``walking-console bench``, on a terminal and in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from rich.console import Console as Terminal
from rich.table import Table

from walking_console.sim.runs.comparison import Ratio

WALK_COLUMNS = (
    "scenario",
    "planner",
    "plant",
    "sensing",
    "way m",
    "ready ms",
    "first ms",
    "median µs",
    "p99 ms",
    "p99.9 ms",
    "largest ms",
    "ms a metre",
    "x real time",
)
WORDS = 4  # columns of them; numbers follow
NARROW = 6  # columns that a terminal of 80 characters has room for, the last ones
MICRO = 1e3  # in a millisecond


def print_figures(figures: dict[str, Any], terminal: Terminal) -> None:
    """Every figure with its value, unit and target."""
    title = (
        f"walking-console {figures['version']}, Python {figures['python']}, "
        "medians of processor time"
    )
    table = Table(title=title, title_justify="left")
    for column in ("figure", "value", "unit", "target"):
        table.add_column(column, justify="right" if column == "value" else "left")
    for name, entry in figures["figures"].items():
        table.add_row(name, f"{entry['value']:g}", entry["unit"], entry["target"])
    terminal.print(table)


def print_walks(measured: dict[str, Any], terminal: Terminal) -> None:
    """A row a walk: how long its ticks took."""
    title = f"walking-console {measured['version']}, Python {measured['python']}, processor time"
    table = Table(title=title, title_justify="left", box=None, padding=(0, 1, 0, 0))
    table.add_column("walk", no_wrap=True)
    for column in WALK_COLUMNS[-NARROW:]:
        table.add_column(column, justify="right")
    for row in _walk_rows(measured["walks"]):
        table.add_row(" ".join(row[:WORDS]), *row[-NARROW:])
    terminal.print(table)


def walks_in_markdown(measured: dict[str, Any]) -> str:
    """The same rows as a table for a document."""
    rules = ["---"] * WORDS + ["---:"] * (len(WALK_COLUMNS) - WORDS)
    rows = [WALK_COLUMNS, rules, *_walk_rows(measured["walks"])]
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def _walk_rows(walks: Iterable[dict[str, Any]]) -> Iterator[list[str]]:
    for walk in walks:
        per_metre = walk["per_metre"]
        yield [
            *(walk[key] for key in ("scenario", "planner", "plant", "sensing")),
            f"{walk['distance']:.2f}",
            f"{walk['prepare']:.0f}",
            f"{walk['first']:.2f}",
            f"{walk['median'] * MICRO:.0f}",
            *(f"{walk[key]:.2f}" for key in ("p99", "p999", "largest")),
            "" if per_metre is None else f"{per_metre:.0f}",
            f"{walk['factor']:.0f}",
        ]


def print_ratios(ratios: Iterable[Ratio], terminal: Terminal) -> None:
    """Every figure of two measurements: now, before, and now over before."""
    table = Table("what", "figure")
    for column in ("now", "before", "ratio"):
        table.add_column(column, justify="right")
    for ratio in ratios:
        now, before = f"{ratio.now:.4g}", f"{ratio.before:.4g}"
        table.add_row(ratio.what, ratio.figure, now, before, f"{ratio.ratio:.3f}")
    terminal.print(table)
