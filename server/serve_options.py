"""What ``walking-console serve`` can be asked for, and what it does unasked."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from .sessions import SIT_AFTER

DATA = Path("walking-console-data")  # in the working directory
FIRST_SCENARIO = "dem"


class LogLevel(StrEnum):
    """How much is said on standard error."""

    DEBUG = "debug"
    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


@dataclass(frozen=True)
class ServeOptions:
    """How the console is served; the defaults are those of the command line."""

    host: str = "127.0.0.1"
    port: int = 8000  # 0: any free one
    robot: str | None = None  # instead of the scenario's own
    scenario: str | None = None  # None: the world last loaded, or FIRST_SCENARIO
    open_page: bool = True
    token: str | None = None
    viewer_token: str | None = None  # for who may watch and stop only
    data: Path = DATA
    sit_after: float = SIT_AFTER  # s; 0: never
    log_level: LogLevel = LogLevel.WARNING
    lan: bool = False  # let the computers and telephones around in, by a token made for it
    allow_host: tuple[str, ...] = ()  # further names it answers for: NAME or NAME:PORT
    root_path: str = ""  # where a proxy that passes whole paths puts it, such as /console
