"""The command line: ``walking-console``."""

from __future__ import annotations

import json
import os
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console as Terminal
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from walking_console.planner.robot.model import MachineError, load_machine, machine_names
from walking_console.sim.scenario import ScenarioError, list_scenarios, load_scenario
from walking_console.sim.terrain.generators import list_terrains
from walking_console.sim.terrain.ground import GroundError

BAD_INPUT = 2
LINE_MAX = 2000  # characters of one clear line

app = typer.Typer(
    name="walking-console",
    help="Statically stable walking: drive it in the browser, script it over REST, run it headless.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
terminal = Terminal(highlight=False)

Host = Annotated[str, typer.Option(help="Address to listen on.")]
Port = Annotated[
    int, typer.Option(min=0, max=65535, help="Port; 0 picks a free one and prints it.")
]
Robot = Annotated[str | None, typer.Option(help="A robot's name or a robot TOML file.")]
Scenario = Annotated[str, typer.Option(help="A scenario's name or a scenario TOML file.")]
NoOpen = Annotated[bool, typer.Option("--no-open", help="Do not open the page in a browser.")]
Token = Annotated[
    str | None,
    typer.Option(help="Secret every client must present; required when not on loopback."),
]
Data = Annotated[Path, typer.Option(help="Where runs are kept.")]
SitAfter = Annotated[
    float,
    typer.Option(
        min=0.0, help="Seconds of silence from a pressed stick after which it sits down; 0: never."
    ),
]
Directory = Annotated[Path, typer.Argument(help="A run directory.")]
SERVED_FIRST = "dem"


@contextmanager
def one_clear_line() -> Iterator[None]:
    """Bad input ends in one line on standard error and exit status 2, never in a traceback."""
    from walking_console.sim.runs.runner import RunError
    from walking_console.web.figures.run_data import FigureError

    try:
        yield
    except (ScenarioError, MachineError, GroundError, RunError, FigureError) as error:
        refuse(str(error))


def refuse(message: str) -> None:
    """Say what was wrong and leave with exit status 2."""
    print(f"walking-console: {' '.join(message.split())[:LINE_MAX]}", file=sys.stderr)
    raise typer.Exit(BAD_INPUT)


@app.callback(invoke_without_command=True)
def main_command(
    context: typer.Context,
    host: Host = "127.0.0.1",
    port: Port = 8000,
    robot: Robot = None,
    scenario: Scenario = SERVED_FIRST,
    no_open: NoOpen = False,
    token: Token = None,
    data: Data = Path("walking-console-data"),
    sit_after: SitAfter = 10.0,
) -> None:
    """Start the console (the same as ``serve``), or run one of the commands below."""
    if context.invoked_subcommand is None:
        serve(host, port, robot, scenario, no_open, token, data, sit_after)


@app.command()
def serve(
    host: Host = "127.0.0.1",
    port: Port = 8000,
    robot: Robot = None,
    scenario: Scenario = SERVED_FIRST,
    no_open: NoOpen = False,
    token: Token = None,
    data: Data = Path("walking-console-data"),
    sit_after: SitAfter = 10.0,
) -> None:
    """Start the console and print its one URL."""
    from .launch import ServeError
    from .launch import serve as serve_console

    with one_clear_line():
        try:
            serve_console(
                host=host,
                port=port,
                robot=robot,
                scenario=scenario,
                open_page=not no_open,
                token=token,
                data=data,
                sit_after=sit_after,
            )
        except ServeError as error:
            refuse(str(error))


@app.command()
def run(
    scenario: Annotated[str, typer.Argument(help="A scenario's name or a TOML file.")],
    out: Annotated[Path, typer.Option(help="Run directory to write: new or empty.")],
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Replace a value; repeatable."),
    ] = None,
    seed: Annotated[int | None, typer.Option(help="The scenario's seed.")] = None,
    trace_decisions: Annotated[
        bool, typer.Option("--trace-decisions", help="Say why in steps.jsonl.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Empty the run directory first.")] = False,
    progress_json: Annotated[
        bool, typer.Option("--progress-json", help="Progress as JSON lines on standard output.")
    ] = False,
) -> None:
    """Run a scenario headless, faster than life."""
    from walking_console.sim.runs.runner import run_scenario, succeeded

    with one_clear_line():
        chosen = load_scenario(scenario, settings or (), seed)
        directory = empty_directory(out, force)
        with progress_shown(progress_json) as progress:
            summary = run_scenario(chosen, directory, explain=trace_decisions, progress=progress)
    if not progress_json:
        print_summary(summary, directory)
    raise typer.Exit(0 if succeeded(summary) else 1)


def empty_directory(out: Path, force: bool) -> Path:
    """``out`` as a new or empty directory; anything else is refused unless ``--force``."""
    from walking_console.sim.runs.runner import RunError

    try:
        if out.exists() and not out.is_dir():
            raise RunError(f"--out must be a directory, {str(out)!r} is a file")
        if out.is_dir() and any(out.iterdir()):
            if not force:
                raise RunError(
                    f"--out must be new or empty, {str(out)!r} is not; --force empties it"
                )
            if not (out / "run.json").is_file():
                raise RunError(
                    f"--force empties run directories only, {str(out)!r} has no run.json"
                )
            shutil.rmtree(out)
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(
            f"cannot make the run directory {str(out)!r:.300}: {error.strerror}"
        ) from None
    if not os.access(out, os.W_OK | os.X_OK):
        raise RunError(f"cannot write into the run directory {str(out)!r}")
    return out


@contextmanager
def progress_shown(as_json: bool) -> Iterator[Callable[[Any, float], None] | None]:
    """A progress bar on a terminal, JSON lines when asked, silence otherwise."""
    if as_json:
        yield lambda console, share: print(
            json.dumps(
                {"progress": share, "tick": console.tick_count, "distance_m": console.distance}
            ),
            flush=True,
        )
    elif terminal.is_terminal:
        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:>3.0f} %"),
            TimeElapsedColumn(),
        )
        with Progress(*columns, console=terminal, transient=True) as bar:
            task = bar.add_task("walking", total=1.0)
            yield lambda console, share: bar.update(
                task, completed=share, description=f"{console.distance:5.2f} m"
            )
    else:
        yield None


def print_summary(summary: dict[str, Any], directory: Path) -> None:
    """One screen: what came out, and each expectation."""
    table = Table(box=None, show_header=False, pad_edge=False)
    margin = summary["margin_min"]
    rows = [
        ("result", f"{summary['result']} ({summary['reason']})"),
        ("time", f"{summary['seconds']:.2f} s, {summary['ticks']} ticks"),
        ("distance", f"{summary['distance']:.3f} m, mean speed {summary['mean_speed']:.4f} m/s"),
        (
            "steps",
            f"{summary['steps']}, forbidden {summary['forbidden_steps']}, falls {summary['falls']}",
        ),
        ("least margin", "none" if margin is None else f"{margin * 1000:.1f} mm longitudinal"),
        (
            "emergent",
            ", ".join(f"{kind} {count}" for kind, count in summary["emergent"].items()) or "none",
        ),
        ("state hash", summary["state_hash"]),
        ("written to", str(directory)),
    ]
    for key, entry in summary["expect"].items():
        rows.append(
            (
                f"expect {key}",
                f"{'pass' if entry['pass'] else 'FAIL'}: wanted {entry['wanted']:g}, got {shown(entry['got'])}",
            )
        )
    for left, right in rows:
        table.add_row(left, right)
    terminal.print(table, soft_wrap=True)


def shown(value: float | None) -> str:
    """A measured figure for people."""
    return "none" if value is None else f"{value:.6g}"


@app.command()
def replay(directory: Directory) -> None:
    """Run a recorded run again from its inputs and compare every tick's state hash."""
    from walking_console.sim.runs.runner import replay as replay_run

    with one_clear_line():
        answer = replay_run(directory)
    if answer["equal"]:
        print(f"all {answer['ticks']} ticks are equal, state hash {answer['state_hash']}")
        raise typer.Exit(0)
    print(
        f"tick {answer['first_difference']} (t = {answer['t']:.2f} s) differs from the recorded run"
    )
    raise typer.Exit(1)


@app.command()
def export(
    directory: Directory,
    to: Annotated[str, typer.Option(help="csv, npz, html or mcap.")],
    out: Annotated[Path | None, typer.Option(help="File to write; default beside the log.")] = None,
) -> None:
    """Write a run's log in another form."""
    from .export import export as export_run

    with one_clear_line():
        print(export_run(directory, to, out))


@app.command()
def figure(
    name: Annotated[str, typer.Argument(help="fig6a, fig12, fig17-up, omni ...")],
    out: Annotated[Path, typer.Option(help="File to write: .svg, .png or .pdf.")],
    run: Annotated[
        Path | None,
        typer.Option(
            "--run", help="Run directory to draw; without it the scenario is walked first."
        ),
    ] = None,
) -> None:
    """Draw a walk in the manner of the 1986 paper's figures."""
    from walking_console.web.figures import draw_figure

    with one_clear_line():
        for line in draw_figure(name, out, run):
            print(line)


@app.command()
def robots() -> None:
    """List the shipped robots."""
    print_list(
        (name, f"{load_machine(name).title} ({len(load_machine(name).legs)} legs)")
        for name in machine_names()
    )


@app.command()
def terrains() -> None:
    """List the kinds of ground."""
    print_list(iter(list_terrains()))


@app.command()
def scenarios() -> None:
    """List the shipped scenarios."""
    print_list(iter(list_scenarios()))


def print_list(entries: Iterator[tuple[str, str]]) -> None:
    """Names and one line each."""
    known = list(entries)
    width = max(len(name) for name, _ in known)
    for name, line in known:
        print(f"{name:<{width}}  {line}")


@app.command()
def bench(
    json_file: Annotated[
        Path | None, typer.Option("--json", help="Also write the figures to this file.")
    ] = None,
) -> None:
    """Measure planner, tick and headless speed on this machine."""
    from walking_console.sim.runs.benchmark import measure, print_figures

    with one_clear_line():
        figures = measure()
    print_figures(figures, terminal)
    if json_file is not None:
        try:
            json_file.write_text(json.dumps(figures, indent=2) + "\n", "utf-8")
        except OSError as error:
            refuse(f"cannot write {str(json_file)!r}: {error.strerror}")


def main() -> None:
    """Entry point of the ``walking-console`` command."""
    app()
