"""A run's log in other forms: csv and npz for spreadsheets and notebooks, mcap for log viewers,
html to watch it anywhere.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from walking_console.sim.runs.replay import rerun
from walking_console.sim.runs.run_files import RunError, read_arrays, read_log, read_run, read_steps

from .mcap_log import write_mcap

FRAME_TICKS = 3  # one drawn frame of a replay page every 60 ms
FRAMES_MAX = 6000  # six minutes; longer runs are drawn at fewer frames a second
BODY = ("x", "y", "z", "roll", "pitch", "yaw")
COMMAND = ("crab_angle_rad", "speed_m_s", "turn_rate_rad_s")

LogColumns = dict[str, np.ndarray[Any, Any]]


def export(directory: Path, to: str, out: Path | None = None) -> Path:
    """Write the run in ``directory`` as ``to`` and answer with the file; raises ``RunError``."""
    if to not in FORMS:
        raise RunError(f"unknown form {to!r}; there are: {', '.join(FORMS)}")
    summary = read_run(directory)
    names = {"csv": "ticks.csv", "npz": "run.npz", "html": "replay.html", "mcap": "run.mcap"}
    path = out or directory / names[to]
    if not path.parent.is_dir():
        raise RunError(f"cannot write {str(path)!r}: there is no folder {str(path.parent)!r}")
    try:
        FORMS[to](directory, summary, path)
    except OSError as error:
        raise RunError(f"cannot write {str(path)!r}: {error.strerror}") from None
    return path


def _to_csv(directory: Path, summary: dict[str, Any], path: Path) -> None:
    """One row a tick, units in the column names."""
    log = read_log(directory)
    names = mode_names(summary)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(_csv_header(log["feet"].shape[1]))
        for row in range(len(log["t"])):
            writer.writerow(_csv_row(log, row, names))


def _csv_row(log: LogColumns, row: int, names: dict[int, str]) -> list[Any]:
    return [
        repr(float(log["t"][row])),
        *(repr(float(v)) for v in log["body"][row]),
        *(repr(float(v)) for v in log["feet"][row].ravel()),
        *(int(v) for v in log["contact"][row]),
        *(int(v) for v in log["support"][row]),
        repr(float(log["margin"][row])),
        repr(float(log["polygon_margin"][row])),
        *(repr(float(v)) for v in log["command"][row]),
        int(log["step"][row]),
        names.get(int(log["mode"][row]), "?"),
    ]


def mode_names(summary: dict[str, Any]) -> dict[int, str]:
    """Names of the numbers in the mode column, from ``run.json``."""
    return {number: name for name, number in summary["modes"].items() if isinstance(number, int)}


def _csv_header(legs: int) -> list[str]:
    body = [f"{name}_m" if name in "xyz" else f"{name}_rad" for name in BODY]
    feet = [f"foot{leg}_{axis}_m" for leg in range(1, legs + 1) for axis in "xyz"]
    flags = [f"{kind}{leg}" for kind in ("contact", "support") for leg in range(1, legs + 1)]
    return ["t_s", *body, *feet, *flags, "margin_m", "polygon_margin_m", *COMMAND, "step", "mode"]


def _to_npz(directory: Path, summary: dict[str, Any], path: Path) -> None:
    """Log, ground and steps in one uncompressed file; the summary as JSON text under ``run``."""
    ground = {
        f"terrain_{name}": array
        for name, array in read_arrays(directory / "terrain.npz", {}).items()
    }
    steps = "".join(json.dumps(step) + "\n" for step in read_steps(directory))
    everything: dict[str, Any] = {
        **read_log(directory),
        **ground,
        "run": json.dumps(summary),
        "steps": steps,
    }
    with path.open("wb") as file:  # a name would be given the suffix .npz when it has none
        np.savez(file, **everything)


def _to_html(directory: Path, summary: dict[str, Any], path: Path) -> None:
    """One self-contained 3-D page: the run is walked again from its inputs and every drawn frame
    recorded.
    """
    from .replay_page import write_replay

    every = max(FRAME_TICKS, -(-int(summary["ticks"]) // FRAMES_MAX))
    write_replay(_frames(directory, every), path, title_of(summary))


def title_of(summary: dict[str, Any]) -> str:
    """What a run is called on a page: its scenario's title and its robot."""
    scenario = summary["scenario"]
    return f"{scenario.get('title') or scenario['name']}: {summary['robot']['name']}"


def _frames(directory: Path, every: int) -> Iterator[Any]:
    for index, (simulation, equal) in enumerate(rerun(directory)):
        if not equal:
            raise RunError(
                f"{directory} does not replay: tick {index} differs from the recorded run"
            )
        if index % every == 0:
            yield simulation.snapshot()


def _to_mcap(directory: Path, summary: dict[str, Any], path: Path) -> None:
    """The log as MCAP, for log viewers."""
    write_mcap(directory, summary, path, mode_names(summary))


FORMS: dict[str, Callable[[Path, dict[str, Any], Path], None]] = {
    "csv": _to_csv,
    "npz": _to_npz,
    "html": _to_html,
    "mcap": _to_mcap,
}
