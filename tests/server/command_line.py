"""The command line in process."""

from typing import Any

from click.testing import Result
from typer.testing import CliRunner

from walking_console.server.cli import app

SHORT = ("--set", "end={time=4.0}", "--set", "expect={}")


def called(*arguments: Any) -> Result:
    """What came of ``walking-console ARGUMENTS``."""
    return CliRunner().invoke(app, [str(argument) for argument in arguments])
