"""Child processes of the console: this program again, and nothing else that lies about.

``-P`` keeps the working directory off the module path, the environment loses what would put it
back, and the child works in a folder of ours: a ``numpy.py`` beside the user's data is never run.
The token of the console stays with the console. A child ends with the console that began it, also
where that was killed.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import IO

COMMAND = (sys.executable, "-P", "-m", "walking_console")
SECRETS = ("WALKING_CONSOLE_TOKEN", "WALKING_CONSOLE_VIEWER_TOKEN")
PARENT = "WALKING_CONSOLE_PARENT"  # process id of the console, in a child's environment
LOOK_EVERY = 0.5  # s between looks whether the console is still there
PATIENCE = 2.0  # s between asking a child to end and ending it
CHILD_NICENESS = 10  # the walk on the screen goes first


def start_child(
    arguments: Sequence[str],
    folder: Path,
    output: IO[bytes] | int = subprocess.DEVNULL,
    errors: IO[bytes] | int = subprocess.DEVNULL,
    *,
    in_background: bool = True,
) -> subprocess.Popen[bytes]:
    """Begin ``walking-console ARGUMENTS`` in ``folder``, after the walk on the screen unless it is
    not to be ``in_background``; paths in the arguments are absolute.
    """
    child = subprocess.Popen(
        [*COMMAND, *arguments],
        cwd=folder,
        env=_environment(),
        stdin=subprocess.DEVNULL,
        stdout=output,
        stderr=errors,
        start_new_session=True,
    )
    try:
        if in_background:
            os.setpriority(os.PRIO_PROCESS, child.pid, CHILD_NICENESS)
    except (OSError, AttributeError):
        pass  # it has ended already, or this system has no such call
    return child


def _environment() -> dict[str, str]:
    """Ours, without the token and without a module path that leads to the working directory."""
    kept = {name: value for name, value in os.environ.items() if name not in SECRETS}
    here = Path.cwd()
    named = kept.pop("PYTHONPATH", "").split(os.pathsep)
    folders = [Path(name).resolve() for name in named if name]
    elsewhere = [str(folder) for folder in folders if folder != here]
    if elsewhere:
        kept["PYTHONPATH"] = os.pathsep.join(elsewhere)
    return kept | {"PYTHONSAFEPATH": "1", PARENT: str(os.getpid())}


def end_with_parent() -> None:
    """In a child: end as on a signal as soon as the console that began it is gone."""
    parent = os.environ.pop(PARENT, "")
    if parent.isdigit() and os.name == "posix":
        threading.Thread(target=_watch, args=(int(parent),), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(LOOK_EVERY)
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(PATIENCE)
    os._exit(1)
