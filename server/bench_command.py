"""``walking-console bench``: how fast this machine plans, walks and answers a hand, and against
another time.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from walking_console.sim.plants import DEFAULT_PLANT, PLANTS, PlantMissing
from walking_console.sim.runs.comparison import ComparisonError, compared
from walking_console.sim.scenario_files import load_scenario

from .benchmark_table import print_figures, print_ratios, print_walks, walks_in_markdown
from .command_groups import one_clear_line, refuse
from .terminal_output import terminal

WalksOption = Annotated[
    bool,
    typer.Option(
        "--walks",
        help="Time every tick of every shipped scenario: ground known, by eye and by touch, and "
        "on every plant that is installed.",
    ),
]
OnlyOption = Annotated[
    list[str] | None,
    typer.Option("--only", metavar="SCENARIO", help="Of the walks these alone; repeatable."),
]
SecondsOption = Annotated[
    float | None,
    typer.Option(min=0.02, help="Simulated seconds of each walk; without it to its end."),
]
JsonOption = Annotated[
    Path | None, typer.Option("--json", help="Also write the figures to this file.")
]
CompareOption = Annotated[
    Path | None,
    typer.Option("--compare", metavar="FILE", help="Ratios to a file that --json has written."),
]
MarkdownOption = Annotated[
    bool, typer.Option("--markdown", help="Print the table of walks for a document.")
]


def bench(
    walks: WalksOption = False,
    only: OnlyOption = None,
    seconds: SecondsOption = None,
    json_file: JsonOption = None,
    compare: CompareOption = None,
    markdown: MarkdownOption = False,
) -> None:
    """Measure planner, tick and headless speed on this machine, or every tick of every walk."""
    with one_clear_line():
        for name in only or ():
            load_scenario(name)
    before = None if compare is None else _read(compare)
    measured = _timed_walks(only or [], seconds) if walks or only else _figures()
    if json_file is not None:
        _write(measured, json_file)
    if "figures" in measured:
        print_figures(measured, terminal)
    elif markdown:
        typer.echo(walks_in_markdown(measured), nl=False)
    else:
        print_walks(measured, terminal)
    if compare is not None:
        try:
            print_ratios(compared(measured, before), terminal)
        except ComparisonError as error:
            refuse(f"--compare {str(compare)!r}: {error}")


def _figures() -> dict[str, Any]:
    from walking_console.sim.runs.benchmark import measure

    from . import stick_latency

    with one_clear_line(), terminal.status("measuring"):
        measured = measure()
        measured["figures"] |= stick_latency.figures()
    return measured


def _timed_walks(only: list[str], seconds: float | None) -> dict[str, Any]:
    from walking_console.sim.runs.benchmark import measured_walks
    from walking_console.sim.runs.tick_times import time_walks

    times = []
    with one_clear_line(), terminal.status("walking") as status:
        for walk in time_walks(installed_plants(), seconds, only):
            times.append(walk)
            status.update(f"{len(times)} walks timed, {walk.scenario} last")
    return measured_walks(times)


def installed_plants() -> list[str]:
    """Plants beside the one that every scenario is walked on, as far as they can be had here."""
    plants = []
    for name, entry in PLANTS.items():
        try:
            entry.check()
        except PlantMissing:
            continue
        if name != DEFAULT_PLANT:
            plants.append(name)
    return plants


def _read(path: Path) -> Any:
    try:
        return json.loads(path.read_text("utf-8"))
    except OSError as error:
        refuse(f"cannot read {str(path)!r}: {error.strerror}")
    except ValueError:
        refuse(f"--compare {str(path)!r}: this is no file of bench --json")


def _write(measured: dict[str, Any], path: Path) -> None:
    try:
        path.write_text(json.dumps(measured, indent=2) + "\n", "utf-8")
    except OSError as error:
        refuse(f"cannot write {str(path)!r}: {error.strerror}")
