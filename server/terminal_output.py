"""What the command line shows people: a progress bar, one screen of results, lists."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rich.console import Console as Terminal
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

ReportProgress = Callable[[Any, float], None]  # simulation, share done

terminal = Terminal(highlight=False)


@contextmanager
def progress_shown(as_json: bool) -> Iterator[ReportProgress | None]:
    """A progress bar on a terminal, JSON lines when asked, silence otherwise."""
    if as_json:
        yield _print_progress
    elif terminal.is_terminal:
        with _bar() as bar:
            yield _on_bar(bar)
    else:
        yield None


def _print_progress(simulation: Any, share: float) -> None:
    line = {
        "progress": share,
        "tick": simulation.tick_count,
        "distance_m": simulation.distance,
    }
    print(json.dumps(line), flush=True)


def _bar() -> Progress:
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        console=terminal,
        transient=True,
    )


def _on_bar(bar: Progress) -> ReportProgress:
    task = bar.add_task("walking", total=1.0)

    def report(simulation: Any, share: float) -> None:
        bar.update(task, completed=share, description=f"{simulation.distance:5.2f} m")

    return report


def print_summary(summary: dict[str, Any], directory: Path) -> None:
    """One screen: what came out, and each expectation."""
    table = Table(box=None, show_header=False, pad_edge=False)
    for left, right in (*_results(summary, directory), *_expectations(summary["expect"])):
        table.add_row(left, right)
    terminal.print(table, soft_wrap=True)


def _results(summary: dict[str, Any], directory: Path) -> Iterator[tuple[str, str]]:
    margin = summary["margin_min"]
    emergent = [f"{kind} {count}" for kind, count in summary["emergent"].items()]
    steps = "{steps}, forbidden {forbidden_steps}, falls {falls}"
    yield "result", f"{summary['result']} ({summary['reason']})"
    yield "time", f"{summary['seconds']:.2f} s, {summary['ticks']} ticks"
    yield "distance", "{distance:.3f} m, mean speed {mean_speed:.4f} m/s".format(**summary)
    yield "steps", steps.format(**summary)
    yield "least margin", "none" if margin is None else f"{margin * 1000:.1f} mm longitudinal"
    yield "emergent", ", ".join(emergent) or "none"
    yield "ground", summary["ground"]
    if summary["body"] == "straight":
        yield "body", "straight, as printed: it may not stand in physics"
    yield "state hash", summary["state_hash"]
    yield "written to", str(directory)


def _expectations(expect: dict[str, Any]) -> Iterator[tuple[str, str]]:
    for key, entry in expect.items():
        verdict = "pass" if entry["pass"] else "FAIL"
        got = "none" if entry["got"] is None else f"{entry['got']:.6g}"
        yield f"expect {key}", f"{verdict}: wanted {entry['wanted']:g}, got {got}"


def print_list(entries: Iterable[tuple[str, str]]) -> None:
    """Names and one line each."""
    known = list(entries)
    width = max(len(name) for name, _ in known)
    for name, line in known:
        print(f"{name:<{width}}  {line}")
