"""A walk as one page that needs no server: the scene in three dimensions with a camera that
follows, a title, what was measured, and its speed, margin and height over time.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from html import escape
from importlib import resources
from pathlib import Path
from typing import NamedTuple

from walking_console.sim.snapshot import Snapshot
from walking_console.web.scene.scene import Scene

from .viser_bridge import ViserBridge
from .viser_recording import StreamedRecording

PLOT_WIDTH = 300  # of a plot, in its own units
PLOT_HEIGHT = 46
POINTS_MAX = 600  # of a curve
PAUSE_MAX = 1.0  # s of stillness between two frames that are shown
STYLE = (
    "#walk{position:fixed;right:12px;top:12px;width:300px;padding:10px 12px;z-index:9;"
    "font:12px/1.4 system-ui,sans-serif;color:#dde3ea;background:#10161ecc;border-radius:8px}"
    "#walk h1{font-size:15px;margin:0 0 4px}#walk svg{width:100%;height:46px;background:#0005}"
    "#walk dl{display:grid;grid-template-columns:auto auto;gap:0 10px;margin:0 0 6px}"
    "#walk dd{margin:0;text-align:right}#walk summary{cursor:pointer}#walk output{float:right}"
)


class Reading(NamedTuple):
    """What the curves show of one frame."""

    time: float  # s from the first frame
    speed: float  # m/s
    margin: float  # m, nan where there is none
    height: float  # m, of the body


def write_replay(snapshots: Iterable[Snapshot], path: Path, title: str) -> None:
    """Draw snapshots, in the time that lies between them, into one page; raises ``OSError``."""
    bridge = ViserBridge()
    try:
        scene = Scene(bridge.server, follows=True)
        frames = iter(snapshots)
        first = next(frames)
        scene.draw(first)
        readings = [Reading(0.0, first.speed, first.margin, first.body[2])]
        last = first
        with StreamedRecording(bridge.server) as recording:
            for snapshot, pause in _with_pauses(first, frames):
                recording.wait(pause)
                scene.draw(snapshot)
                time = readings[-1].time + pause
                readings.append(Reading(time, snapshot.speed, snapshot.margin, snapshot.body[2]))
                last = snapshot
            recording.write_html(path, title, panel(title, readings, last))
    finally:
        bridge.stop()


def _with_pauses(first: Snapshot, frames: Iterator[Snapshot]) -> Iterator[tuple[Snapshot, float]]:
    """Every snapshot with the time since the one before; over a reset it is short."""
    before = first
    for snapshot in frames:
        pause = snapshot.time - before.time
        yield snapshot, min(pause, PAUSE_MAX) if pause > 0.0 else PAUSE_MAX / 4
        before = snapshot


def panel(title: str, readings: Sequence[Reading], last: Snapshot) -> str:
    """Title, what was measured, and the curves, as HTML of their own."""
    margins = [each.margin for each in readings if math.isfinite(each.margin)]
    figures = {
        "Robot": last.machine.title,
        "Planner": f"{last.planner}, {last.planner_mode}",
        "Time": f"{readings[-1].time:.1f} s",
        "Distance": f"{last.distance:.2f} m",
        "Steps": f"{last.step}",
        "Least margin": f"{min(margins) * 1000:.0f} mm" if margins else "none",
    }
    rows = "".join(f"<dt>{name}</dt><dd>{escape(value)}</dd>" for name, value in figures.items())
    curves = {
        "speed, m/s": [each.speed for each in readings],
        "margin, m": [each.margin for each in readings],
        "height of the body, m": [each.height for each in readings],
    }
    times = [each.time for each in readings]
    plots = "".join(_plot(name, times, values) for name, values in curves.items())
    return (
        f"<style>{STYLE}</style><details id=walk open><summary><b>{escape(title)}</b></summary>"
        f"<dl>{rows}</dl>{plots}</details><script type=module>{_cursor()}</script>"
    )


def _cursor() -> str:
    """The script that moves a line over the curves with the player."""
    page = resources.files("walking_console.web") / "page"
    return (page / "replay_cursor.js").read_text("utf-8")


def _plot(name: str, times: Sequence[float], values: Sequence[float]) -> str:
    """One curve over time, with its least and largest value and a line for where the player is; a
    gap where there is no value.
    """
    known = [value for value in values if math.isfinite(value)]
    low, high = (min(known), max(known)) if known else (0.0, 0.0)
    span = max(high - low, 1e-6)
    long = max(times[-1], 1e-6)
    step = max(1, -(-len(values) // POINTS_MAX))
    path = ""
    pen = "M"
    points = list(zip(times[::step], values[::step], strict=True))
    for time, value in points:
        if not math.isfinite(value):
            pen = "M"
            continue
        x = time / long * PLOT_WIDTH
        y = (1.0 - (value - low) / span) * (PLOT_HEIGHT - 4) + 2
        path += f"{pen}{x:.1f} {y:.1f}"
        pen = "L"
    at = " ".join(f"{time:.2f}" for time, _ in points)
    there = " ".join(f"{value:.3f}" for _, value in points)
    return (
        f"<div>{name}: {low:.3f} to {high:.3f}<output></output></div>"
        f'<svg viewBox="0 0 {PLOT_WIDTH} {PLOT_HEIGHT}" preserveAspectRatio="none" '
        f'data-times="{at}" data-values="{there}">'
        f'<path d="{path}" fill="none" stroke="#7fd1ff"/>'
        f'<line y1="0" y2="{PLOT_HEIGHT}" stroke="#ffd34d" vector-effect="non-scaling-stroke"/>'
        "</svg>"
    )
