"""What the commands of the command line share: a default command, and one clear line for bad
input.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, ClassVar, NoReturn

import typer
from typer.core import TyperGroup

from walking_console.planner.robot.model import MachineError
from walking_console.sim.scenario import ScenarioError
from walking_console.sim.terrain.ground import GroundError

BAD_INPUT = 2
LINE_MAX = 2000  # characters of one clear line


class DefaultCommand(TyperGroup):
    """A group whose words are those of its default command where they name no other."""

    default: ClassVar[str]

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        own = {name for parameter in self.get_params(ctx) for name in parameter.opts}
        if self.is_of_default(args, own):
            args = [self.default, *args]
        return super().parse_args(ctx, args)

    def is_of_default(self, args: list[str], own: set[str]) -> bool:
        """Whether these words name neither a command nor an option of the group."""
        return bool(args) and args[0] not in self.commands and args[0] not in own


@contextmanager
def one_clear_line() -> Iterator[None]:
    """Bad input ends in one line on standard error and exit status 2, never in a traceback."""
    from walking_console.sim.runs.run_files import RunError
    from walking_console.web.figures.run_data import FigureError

    from .listening import ServeError

    try:
        yield
    except (
        ScenarioError,
        MachineError,
        GroundError,
        RunError,
        FigureError,
        ServeError,
    ) as error:
        refuse(str(error))


def refuse(message: str) -> NoReturn:
    """Say what was wrong and leave with exit status 2."""
    print(f"walking-console: {' '.join(message.split())[:LINE_MAX]}", file=sys.stderr)
    raise typer.Exit(BAD_INPUT)
