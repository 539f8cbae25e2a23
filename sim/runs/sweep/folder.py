"""The folder of a sweep: what was asked (``sweep.json``), a line for every walk that is over
(``rows.jsonl``), the tables, and the run directories that are kept below ``runs``.

A walk is over once its line is written; a sweep that was ended anywhere goes on from there.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Sequence
from hashlib import blake2b
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self

from walking_console.sim.runs.run_files import RunError
from walking_console.sim.runs.runner import product_version
from walking_console.sim.scenario import Scenario

from .grid import Axis, Case, Sweep
from .table import TableRow, axis_column, write_tables
from .walker import Keep, WalkedCase

SCHEMA = 1
ASKED = "sweep.json"
ROWS = "rows.jsonl"
RUNS = "runs"


def asked(sweep: Sweep, resolved: Sequence[Scenario], keep: Keep) -> dict[str, Any]:
    """What makes two sweeps the same one: their rows may stand in one table."""
    told = json.dumps([scenario.as_data() for scenario in resolved], sort_keys=True)
    return {
        "schema": SCHEMA,
        "version": product_version(),
        "scenario": sweep.scenario,
        "set": [[axis.key, list(axis.values)] for axis in sweep.axes],
        "seeds": list(sweep.seeds),
        "keep": keep.value,
        "runs": len(sweep),
        "scenarios": blake2b(told.encode(), digest_size=16).hexdigest(),
    }


def read_asked(folder: Path) -> dict[str, Any]:
    """``sweep.json`` of a folder; raises ``RunError`` where it is none of a sweep."""
    path = folder / ASKED
    try:
        found = json.loads(path.read_text("utf-8"))
    except FileNotFoundError:
        raise RunError(f"{folder} is not the folder of a sweep: it has no {ASKED}") from None
    except (OSError, ValueError) as error:
        raise RunError(f"cannot read {path}: {error}") from None
    if not isinstance(found, dict) or found.get("schema") != SCHEMA:
        raise RunError(f"{path} must have schema {SCHEMA}")
    return found


def axes_of(told: dict[str, Any]) -> tuple[Axis, ...]:
    """The axes that ``sweep.json`` names; raises ``RunError``."""
    try:
        return tuple(Axis(str(key), tuple(map(str, values))) for key, values in told["set"])
    except (KeyError, TypeError, ValueError):
        raise RunError(f"{ASKED}: 'set' must be pairs of a key and its values") from None


class SweepFolder:
    """An open folder: ``done`` are the runs that are over, ``add`` writes one more."""

    def __init__(self, path: Path, axes: tuple[Axis, ...]) -> None:
        self.path = path
        self.axes = axes
        self.rows = _read_rows(path / ROWS)
        self.done = {int(row["run"]) for row in self.rows}
        self._file: IO[str] = (path / ROWS).open("a", encoding="utf-8")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """The tables hold every walk that is over, also where the sweep was interrupted."""
        self._file.close()
        write_tables(self.path, self.axes, self.rows)

    def add(self, case: Case, walked: WalkedCase) -> TableRow:
        """Keep what came of a walk: its directory first, then its line."""
        name = f"{RUNS}/{case.index:06d}"
        if walked.files is not None:
            _write_directory(self.path / name, walked.files)
        row = {
            "run": case.index,
            **dict(zip((axis_column(axis.key) for axis in self.axes), case.values, strict=True)),
            "seed": case.seed,
            **walked.row,
            "directory": None if walked.files is None else name,
        }
        self._file.write(json.dumps(row, allow_nan=False) + "\n")
        self._file.flush()
        self.rows.append(row)
        self.done.add(case.index)
        return row


def open_folder(out: Path, sweep: Sweep, told: dict[str, Any], *, force: bool) -> SweepFolder:
    """``out`` as the folder of this sweep: new, empty, or begun by the same one, which goes on.

    ``force`` empties the folder of another sweep. Raises ``RunError``.
    """
    try:
        if force and (out / ASKED).is_file():
            shutil.rmtree(out)
        if out.is_dir() and any(out.iterdir()):
            _check_the_same(out, told)
        else:
            out.mkdir(parents=True, exist_ok=True)
            _write_whole(out / ASKED, json.dumps(told, indent=2) + "\n")
        return SweepFolder(out, sweep.axes)
    except OSError as error:
        raise RunError(f"cannot write the folder {str(out)!r}: {error.strerror}") from None


def _check_the_same(out: Path, told: dict[str, Any]) -> None:
    if not (out / ASKED).exists():
        raise RunError(f"--out must be new, empty or a sweep to go on with, {str(out)!r} is not")
    found = read_asked(out)
    other = [key for key in told if found.get(key) != told[key]]
    if other:
        what = ", ".join(other)
        raise RunError(f"{str(out)!r} holds another sweep ({what} differ); --force empties it")


def _read_rows(path: Path) -> list[TableRow]:
    """Every whole line; what a kill left half written is cut off the file."""
    try:
        text = path.read_bytes()
    except FileNotFoundError:
        return []
    whole = text[: text.rfind(b"\n") + 1]
    if len(whole) < len(text):
        os.truncate(path, len(whole))
    try:
        rows = [json.loads(line) for line in whole.splitlines()]
        return list({int(row["run"]): row for row in rows}.values())
    except (ValueError, KeyError, TypeError) as error:
        raise RunError(f"cannot read {path}: {error}") from None


def _write_directory(path: Path, files: dict[str, bytes]) -> None:
    """There whole or not at all; one that a kill left without its line is written again."""
    beside = path.with_suffix(".part")
    for there in (path, beside):
        shutil.rmtree(there, ignore_errors=True)
    beside.mkdir(parents=True)
    for name, data in files.items():
        (beside / name).write_bytes(data)
    beside.rename(path)


def _write_whole(path: Path, text: str) -> None:
    beside = path.with_suffix(".part")
    beside.write_text(text, "utf-8")
    os.replace(beside, path)
