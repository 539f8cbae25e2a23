"""``walking-console sweep``: many walks of one scenario, and drawings of what came of them."""

from __future__ import annotations

import json
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeRemainingColumn,
)

from walking_console.sim.runs.sweep.executors import HERE, JOBS_MAX, open_workers
from walking_console.sim.runs.sweep.grid import sweep_of
from walking_console.sim.runs.sweep.runner import ReportSweep, SweepProgress, walk_sweep
from walking_console.sim.runs.sweep.walker import Keep

from .command_groups import DefaultCommand, one_clear_line
from .terminal_output import terminal

INTERRUPTED = 1


class WalkByDefault(DefaultCommand):
    """Without a command of its own a sweep is walked."""

    default = "walk"


app = typer.Typer(
    cls=WalkByDefault,
    help="Walk a scenario many times: sweep SCENARIO --set KEY=a,b,c --seeds 1:100 --out DIR. "
    "Draw what came of it: sweep plot DIR --out FILE.svg.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

SettingsOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=a,b,c",
        help="Values a setting takes, one after the other; repeatable, every combination is "
        "walked. Commas in quotes and brackets do not separate.",
    ),
]
SeedsOption = Annotated[
    str | None, typer.Option(help="1:100 (both included), or 3,5,8; default the scenario's own.")
]
OnOption = Annotated[
    str, typer.Option(help="processes: of this computer; dask://HOST:PORT: of a Dask cluster.")
]
JobsOption = Annotated[
    int | None,
    typer.Option(min=1, max=JOBS_MAX, help="Processes of this computer; default one for a core."),
]
KeepOption = Annotated[Keep, typer.Option(help="Which run directories are kept, below DIR/runs.")]


@app.command()
def walk(
    scenario: Annotated[str, typer.Argument(help="A scenario's name or a TOML file.")],
    out: Annotated[
        Path,
        typer.Option(help="Folder of the sweep; one that was interrupted there goes on."),
    ],
    settings: SettingsOption = None,
    seeds: SeedsOption = None,
    on: OnOption = HERE,
    jobs: JobsOption = None,
    keep: KeepOption = Keep.FAILED,
    force: Annotated[
        bool, typer.Option("--force", help="Empty the folder of another sweep first.")
    ] = False,
    progress_json: Annotated[
        bool, typer.Option("--progress-json", help="Progress as JSON lines on standard output.")
    ] = False,
) -> None:
    """Walk every combination of settings for every seed into one table (DIR/table.csv)."""
    with one_clear_line():
        sweep = sweep_of(scenario, settings or (), seeds)
        workers = open_workers(on, jobs)
        try:
            signal.signal(
                signal.SIGTERM, signal.default_int_handler
            )  # the table is written then too
            with sweep_shown(progress_json, len(sweep)) as report:
                came = walk_sweep(sweep, out, workers, keep=keep, force=force, report=report)
        except KeyboardInterrupt:
            print(f"interrupted; the same command goes on with what is in {out}")
            raise typer.Exit(INTERRUPTED) from None
        finally:
            workers.close()
    if not progress_json:
        print(f"{came.passed} of {came.total} runs passed; table in {out / 'table.csv'}")


@app.command()
def plot(
    folder: Annotated[Path, typer.Argument(help="Folder of a sweep, whole or not.")],
    out: Annotated[Path, typer.Option(help="File to write: .svg, .png or .pdf.")],
    x: Annotated[
        str | None, typer.Option(help="Setting along the axis; default the first that varies.")
    ] = None,
    by: Annotated[
        str | None,
        typer.Option(help="Setting with a curve for each value; default the next that varies."),
    ] = None,
) -> None:
    """Draw the share of runs that passed as curves, and as a heat map where two settings vary."""
    from walking_console.web.figures.sweep_drawing import draw_sweep

    with one_clear_line():
        print(draw_sweep(folder, out, x, by))


class RemainingTime:
    """Seconds that are left, judged by the walks of this session alone."""

    def __init__(self) -> None:
        self.began = time.monotonic()

    def left(self, progress: SweepProgress) -> float | None:
        """None before the first walk is over."""
        walked = progress.done - progress.before
        if walked == 0:
            return 0.0 if progress.done == progress.total else None
        return (time.monotonic() - self.began) / walked * (progress.total - progress.done)


@contextmanager
def sweep_shown(as_json: bool, total: int) -> Iterator[ReportSweep]:
    """A bar with the time left on a terminal, JSON lines when asked, silence otherwise."""
    if as_json:
        yield _lines()
    elif terminal.is_terminal:
        with _bar() as bar:
            task = bar.add_task("walking", total=total, passed="")

            def show(progress: SweepProgress) -> None:
                said = f"{progress.passed} passed"
                bar.update(task, completed=progress.done, passed=said)

            yield show
    else:
        yield lambda progress: None


def _lines() -> ReportSweep:
    remaining = RemainingTime()

    def say(progress: SweepProgress) -> None:
        left = remaining.left(progress)
        line = {
            "progress": progress.done / progress.total,
            "done": progress.done,
            "total": progress.total,
            "passed": progress.passed,
            "left_s": None if left is None else round(left, 1),
        }
        print(json.dumps(line), flush=True)

    return say


def _bar() -> Progress:
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[passed]}, left"),
        TimeRemainingColumn(),
        console=terminal,
        transient=True,
    )
