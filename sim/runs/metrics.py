"""What a finished walk came to beyond its own counts: standard gait reached or not, distance off
the line, smoothness of the body.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.geometry.paths import SampledPath
from walking_console.planner.geometry.transforms import left_fold_sum, turned_back
from walking_console.sim.runs.recorder import Recorder
from walking_console.sim.simulation import Simulation

SPACING = 0.1  # m of course between the heights of which second differences are taken
EVERY = 5  # ticks at which the way off a trace is looked at
FLAT = 1e-6  # m; an average-height path smoother than this has nothing to be compared with


def measured(simulation: Simulation, recorder: Recorder) -> dict[str, Any]:
    """Figures of ``run.json`` that an expectation may name; None where nothing can be measured."""
    log = recorder.columns()
    return {
        **stability_figures(log),
        "off_trace": off_trace(simulation.world.course, log["body"]),
        **_of_the_gait(simulation, recorder, log),
    }


def off_trace(trace: SampledPath | None, body: NDArray[Any]) -> float | None:
    """How far the body (n, 6) was from the trace it was given at most, m; None without one."""
    if trace is None or not len(body):
        return None
    s = 0.0
    farthest = 0.0
    for x, y in body[::EVERY, :2].tolist():
        s, away = trace.nearest(s, x, y)
        farthest = max(farthest, away)
    return farthest


def stability_figures(log: dict[str, NDArray[Any]]) -> dict[str, float | None]:
    """The least margins of the feet meant to carry, m, and how far the body leant at most, deg."""
    tilt = np.hypot(log["body"][:, 3], log["body"][:, 4])
    return {
        "polygon_margin_min": _least(log["polygon_margin"]),
        "capture_margin_min": _least(log["capture_margin"]),
        "tilt_deg": float(np.degrees(tilt.max())) if tilt.size else None,
    }


def _least(values: NDArray[Any]) -> float | None:
    """The least of them; None where it is no number, or there are none."""
    return float(values.min()) if values.size and np.isfinite(values).all() else None


def _of_the_gait(
    simulation: Simulation, recorder: Recorder, log: dict[str, NDArray[Any]]
) -> dict[str, Any]:
    """What only a planner with a standard layout can be measured by."""
    within = simulation.planner.capabilities.standard_within
    if within is None or not recorder.ticks:
        return dict.fromkeys(
            (
                "off_line",
                "standard_steps",
                "courses_unsettled",
                "roughness",
                "roughness_average_rule",
                "roughness_ratio",
            )
        )
    return {
        "off_line": off_line(recorder, log),
        "standard_steps": standard_steps(recorder.steps, within),
        "courses_unsettled": courses_unsettled(recorder, within),
        **smoothness(simulation, recorder, log),
    }


def standard_steps(steps: list[dict[str, Any]], within: float) -> int:
    """How many steps at the end of the walk, in a row, came out in the standard layout."""
    count = 0
    for step in reversed(steps):
        if not settled(step, within):
            break
        count += 1
    return count


def settled(step: dict[str, Any], within: float) -> bool:
    """True when a recorded step ended within this share of its stride of the standard layout."""
    return step["off_standard"] is not None and bool(step["off_standard"] <= within)


def courses(recorder: Recorder) -> list[tuple[int, int, dict[str, Any]]]:
    """First tick, last tick and command of every stretch walked under one command."""
    commands = [entry for entry in recorder.inputs if entry["input"] == "command"]
    ends = [*(entry["tick"] for entry in commands), recorder.ticks][1:]
    return [
        (entry["tick"], end, entry)
        for entry, end in zip(commands, ends, strict=True)
        if entry["speed"] > 0.0
    ]


def courses_unsettled(recorder: Recorder, within: float) -> int:
    """How many commanded courses were left, or ended, with a step that did not come out in the
    standard layout.
    """
    count = 0
    for begin, end, _ in courses(recorder):
        walked = [step for step in recorder.steps if begin < step["tick"] <= end]
        if not walked or not settled(walked[-1], within):
            count += 1
    return count


def off_line(recorder: Recorder, log: dict[str, NDArray[Any]]) -> float | None:
    """Distance of the CoG at the end from the line it was last commanded along, m; None when it was
    to turn or to hold.
    """
    walked = courses(recorder)
    if not walked or walked[-1][2]["turn_rate"] != 0.0:
        return None
    begin, _, command = walked[-1]
    x, y, yaw = log["body"][max(0, begin - 1), [0, 1, 5]]
    dx, dy = log["body"][-1, :2] - (x, y)
    _, left = turned_back(dx, dy, yaw + command["crab_angle"])
    return float(abs(left))


def smoothness(
    simulation: Simulation, recorder: Recorder, log: dict[str, NDArray[Any]]
) -> dict[str, float | None]:
    """RMS second difference of the body's height over its course, beside that of the average-height
    rule on the same footholds.
    """
    course, rows, heights = average_rule(
        log, [step["tick"] for step in recorder.steps], simulation.world.gait.height
    )
    ours, theirs = roughness(course, log["body"][:, 2]), roughness(course[rows], heights)
    return {
        "roughness": ours,
        "roughness_average_rule": theirs,
        "roughness_ratio": ours / theirs if theirs > FLAT else None,
    }


def average_rule(
    log: dict[str, NDArray[Any]], ticks: list[int], height: float
) -> tuple[NDArray[np.float64], NDArray[np.intp], NDArray[np.float64]]:
    """The course of every row, the rows of the N_k, and the body heights there by the
    average-height rule, linked linearly between.

    The mildest reading of that rule: all four feet stand at N_k. Taken tick by tick over the three
    that carry, it jumps.
    """
    way = np.hypot(*np.diff(log["body"][:, :2], axis=0).T)
    course = np.concatenate([[0.0], np.cumsum(way)])
    rows = np.array([0, *(tick - 1 for tick in ticks)], dtype=np.intp)
    return course, rows, np.array([average_height(log["feet"][row], height) for row in rows])


def average_height(feet: Sequence[Sequence[float]], height: float) -> float:
    """The height rule of H fig. 15, the broken line: H above the mean of the standing feet, m."""
    return left_fold_sum(foot[2] for foot in feet) / len(feet) + height


def roughness(course: NDArray[np.float64], heights: NDArray[np.float64]) -> float:
    """RMS second difference of heights along a course, sampled every 0.1 m and linked linearly
    between the points given, m.
    """
    samples = np.interp(np.arange(course[0], course[-1], SPACING), course, heights)
    if samples.size < 3:
        return 0.0
    return float(np.sqrt(np.mean(np.diff(samples, 2) ** 2)))
