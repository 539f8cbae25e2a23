"""Where a run of the command line is written."""

from __future__ import annotations

import os
import shutil
from itertools import count
from pathlib import Path

from walking_console.sim.runs.run_files import RunError

from .run_jobs import numbered

RUNS = Path("runs")  # in the working directory


def empty_directory(out: Path, force: bool) -> Path:
    """``out`` as a new or empty directory; anything else is refused unless ``--force``. Raises
    ``RunError``.
    """
    try:
        _clear(out, force)
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _cannot_be_made(out, error) from None
    if not os.access(out, os.W_OK | os.X_OK):
        raise RunError(f"cannot write into the run directory {str(out)!r}")
    return out


def _clear(out: Path, force: bool) -> None:
    if out.exists() and not out.is_dir():
        raise RunError(f"--out must be a directory, {str(out)!r} is a file")
    if not out.is_dir() or not any(out.iterdir()):
        return
    if not force:
        raise RunError(f"--out must be new or empty, {str(out)!r} is not; --force empties it")
    if not (out / "run.json").is_file():
        raise RunError(f"--force empties run directories only, {str(out)!r} has no run.json")
    shutil.rmtree(out)


def next_directory(name: str, runs: Path = RUNS) -> Path:
    """``runs/NAME-0001`` or the next number that is free, made now. Raises ``RunError``."""
    for number in count(1):
        out = runs / numbered(name, number)
        try:
            out.mkdir(parents=True)
        except FileExistsError:
            if out.exists():
                continue
            raise RunError(f"{str(runs)!r} is no directory; name another with --out") from None
        except OSError as error:
            raise _cannot_be_made(out, error) from None
        return out
    raise AssertionError("unreachable")


def _cannot_be_made(out: Path, error: OSError) -> RunError:
    return RunError(f"cannot make the run directory {str(out)!r:.300}: {error.strerror}")
