"""The command line: ``walking-console``."""

from __future__ import annotations

import io
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from walking_console.planner.robot.model import load_machine, machine_names
from walking_console.sim.scenario_files import list_scenarios, load_scenario
from walking_console.sim.terrain.generators import list_terrains

from . import bench_command, sweep_commands
from .child_process import end_with_parent
from .command_groups import DefaultCommand, one_clear_line
from .serve_options import FIRST_SCENARIO, LogLevel, ServeOptions
from .terminal_output import print_list, print_summary, progress_shown

ENVIRONMENT = "WALKING_CONSOLE_"
UNASKED = ServeOptions()


class ServeByDefault(DefaultCommand):
    """Without a command the words are options of ``serve``, and the help lists them too."""

    default = "serve"

    def is_of_default(self, args: list[str], own: set[str]) -> bool:
        """A word that is no option must name a command: misspelt ones are said."""
        return not args or (args[0].startswith("-") and args[0] not in own)

    def format_options(self, ctx: Any, formatter: Any) -> None:
        super().format_options(ctx, formatter)
        serve = self.commands[self.default]
        records = [
            record
            for parameter in serve.params
            if (record := parameter.get_help_record(ctx)) is not None
        ]
        with formatter.section(f"Options of {self.default}, and without a command"):
            formatter.write_dl(records)


app = typer.Typer(
    name="walking-console",
    help="Statically stable walking: drive it in the browser, script it over REST, run it "
    "headless. Without a command: serve.",
    cls=ServeByDefault,
    context_settings={"help_option_names": ["-h", "--help"]},
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


HostOption = Annotated[str, typer.Option(help="Address to listen on.", envvar=f"{ENVIRONMENT}HOST")]
PortOption = Annotated[
    int,
    typer.Option(
        min=0,
        max=65535,
        help="Port; 0 picks a free one and prints it.",
        envvar=f"{ENVIRONMENT}PORT",
    ),
]
RobotOption = Annotated[str | None, typer.Option(help="A robot's name or a robot TOML file.")]
ScenarioOption = Annotated[
    str | None,
    typer.Option(
        help="A scenario's name or a scenario TOML file; without: the world last loaded, or "
        f"{FIRST_SCENARIO}."
    ),
]
NoOpenOption = Annotated[bool, typer.Option("--no-open", help="Do not open the page in a browser.")]
TokenOption = Annotated[
    str | None,
    typer.Option(
        help="Secret every client must present; required when not on loopback.",
        envvar=f"{ENVIRONMENT}TOKEN",
    ),
]
ViewerTokenOption = Annotated[
    str | None,
    typer.Option(
        help="Secret of those who may watch and stop, but not drive; needs --token.",
        envvar=f"{ENVIRONMENT}VIEWER_TOKEN",
    ),
]
DataOption = Annotated[Path, typer.Option(help="Where runs are kept.", envvar=f"{ENVIRONMENT}DATA")]
LanOption = Annotated[
    bool,
    typer.Option("--lan", help="Let this network in: makes tokens, prints links and a QR code."),
]
AllowHostOption = Annotated[
    list[str] | None,
    typer.Option(metavar="NAME", help="A further name it answers for, also NAME:PORT; repeatable."),
]
RootPathOption = Annotated[
    str, typer.Option(help="Path at which a reverse proxy shows it, such as /console.")
]
SitAfterOption = Annotated[
    float,
    typer.Option(
        min=0.0,
        help="Seconds of silence from a pressed stick after which it sits down; 0: never.",
    ),
]
LogLevelOption = Annotated[
    LogLevel,
    typer.Option(help="How much to say on standard error.", envvar=f"{ENVIRONMENT}LOG_LEVEL"),
]
DirectoryArgument = Annotated[Path, typer.Argument(help="A run directory.")]


def print_version(wanted: bool) -> None:
    """Print the version and leave."""
    if wanted:
        from walking_console.sim.runs.runner import product_version

        print(f"walking-console {product_version()}")
        raise typer.Exit


app.add_typer(sweep_commands.app, name="sweep")
app.command()(bench_command.bench)


@app.callback()
def walking_console(
    version: Annotated[
        bool,
        typer.Option("--version", callback=print_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None:
    """What every command has."""


@app.command()
def serve(
    host: HostOption = UNASKED.host,
    port: PortOption = UNASKED.port,
    robot: RobotOption = UNASKED.robot,
    scenario: ScenarioOption = UNASKED.scenario,
    no_open: NoOpenOption = not UNASKED.open_page,
    token: TokenOption = UNASKED.token,
    viewer_token: ViewerTokenOption = UNASKED.viewer_token,
    lan: LanOption = UNASKED.lan,
    allow_host: AllowHostOption = None,
    root_path: RootPathOption = UNASKED.root_path,
    data: DataOption = UNASKED.data,
    sit_after: SitAfterOption = UNASKED.sit_after,
    log_level: LogLevelOption = UNASKED.log_level,
) -> None:
    """Start the console and print its one URL."""
    from .launch import serve as serve_console

    options = ServeOptions(
        host=host,
        port=port,
        robot=robot,
        scenario=scenario,
        open_page=not no_open,
        token=token,
        viewer_token=viewer_token,
        lan=lan,
        allow_host=tuple(allow_host or ()),
        root_path=root_path.rstrip("/"),
        data=data,
        sit_after=sit_after,
        log_level=log_level,
    )
    with one_clear_line():
        serve_console(options)


@app.command()
def run(
    scenario: Annotated[str, typer.Argument(help="A scenario's name or a TOML file.")],
    out: Annotated[
        Path | None,
        typer.Option(
            help="Run directory to write, new or empty; by default the next free runs/NAME-0001."
        ),
    ] = None,
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

    from .run_directories import empty_directory, next_directory

    with one_clear_line():
        chosen = load_scenario(scenario, settings or (), seed)
        directory = next_directory(chosen.name) if out is None else empty_directory(out, force)
        with progress_shown(progress_json) as progress:
            summary = run_scenario(chosen, directory, explain=trace_decisions, progress=progress)
    if not progress_json:
        print_summary(summary, directory)
    raise typer.Exit(0 if succeeded(summary) else 1)


@app.command()
def replay(directory: DirectoryArgument) -> None:
    """Run a recorded run again from its inputs and compare every tick's state hash."""
    from walking_console.sim.runs.replay import replay as replay_run

    with one_clear_line():
        answer = replay_run(directory)
    if answer["equal"]:
        print(f"all {answer['ticks']} ticks are equal, state hash {answer['state_hash']}")
        raise typer.Exit(0)
    print("tick {first_difference} (t = {t:.2f} s) differs from the recorded run".format(**answer))
    raise typer.Exit(1)


@app.command()
def export(
    directory: DirectoryArgument,
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
    machines = [load_machine(name) for name in machine_names()]
    print_list(
        (machine.name, f"{machine.title} ({len(machine.legs)} legs)") for machine in machines
    )


@app.command()
def terrains() -> None:
    """List the kinds of ground."""
    print_list(list_terrains())


@app.command()
def scenarios() -> None:
    """List the shipped scenarios."""
    print_list(list_scenarios())


@app.command(hidden=True)
def draw_recording(snapshots: Path, out: Path) -> None:
    """Draw what the console has kept of a walk: what its child runs."""
    from .replay_page import write_replay
    from .snapshot_files import taken_out

    kept = taken_out(snapshots)
    write_replay(kept, out, f"{kept[-1].scenario}: {kept[-1].machine.name}, {len(kept)} pictures")


@app.command(hidden=True)
def understand(path: Path, name: str) -> None:
    """Say as JSON what a file is that somebody brought: what the console's child runs."""
    from .uploaded_file import answer_of_child

    typer.echo(answer_of_child(path, name))


def main() -> None:
    """Entry point of the ``walking-console`` command."""
    for stream in (sys.stdout, sys.stderr):
        # a letter the terminal cannot show becomes an escape, not a traceback
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    end_with_parent()
    app()
