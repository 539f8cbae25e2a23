"""How fast the body may go, by how high and how fast the feet are lifted (H fig. 16)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walking_console.planner.crab.step_plans import cruise_speed
from walking_console.planner.types import TICK

from ..scene.palette import LEGS
from .catalogue import LIFT, LINES, MARKS, PACE
from .run_data import RecordedWalk
from .sheets import Walks, in_our_style
from .style import blank_sheet

CYCLE = 4  # steps
LEAST = {LIFT: 0.005, PACE: 0.05}  # where the lines begin: at 0 the body would not move
FARTHEST = {axis: max(MARKS[axis]) for axis in (LIFT, PACE)}
SAMPLES = 120  # points of a line


@in_our_style
def speeds(title: str, walks: Walks) -> Figure:
    """v_G against h_up for some v_up, and against v_up for some h_up: lines by the formula, marks
    as walked (H fig. 16).
    """
    walk = walks["walk"]
    duty = f"α = 0°, β = {walk.gait.duty_factor:g}, V$_x$ = {walk.machine.speed[0]:g} m/s"
    lines = "lines: by the formula; rings: walked"
    dotted = "dotted: faster, a foot coming straight down would leave its mechanical reach"
    note = f"{duty}, constant velocity between knots\n{lines}; {dotted}"
    sheet = blank_sheet(10.0, 4.8, title, note)
    columns = sheet.add_gridspec(1, 2, left=0.065, right=0.985, top=0.81, bottom=0.12, wspace=0.2)
    swept = [other for key, other in walks.items() if key != "walk"]
    left = sheet.add_subplot(columns[0])
    _against(left, walk, swept, LIFT)
    left.set_xlabel("$h_{up}$, m")
    right = sheet.add_subplot(columns[1])
    _against(right, walk, swept, PACE)
    right.set_xlabel("$v_{up}$, m/s")
    return sheet


def _against(ax: Axes, walk: RecordedWalk, swept: Sequence[RecordedWalk], axis: str) -> None:
    """Speed against one of the two, a line for every value of the other."""
    other = PACE if axis == LIFT else LIFT
    for value, colour in zip(LINES[other], LEGS, strict=False):
        _line(ax, walk, {axis: 0.0, other: value}, axis, colour)
        marks = [w for w in swept if abs(setting(w, other) - value) < 1e-9]
        points = sorted((setting(w, axis), walked_speed(w)) for w in marks)
        ax.plot(*zip(*points, strict=True), "o", ms=5, mfc="white", mec=colour, mew=1.2)
    ax.set_ylim(0, None)
    ax.set_ylabel("$v_G$, m/s")
    ax.legend(loc="upper right" if axis == LIFT else "upper left", fontsize=8)


def _line(ax: Axes, walk: RecordedWalk, settings: dict[str, float], axis: str, colour: str) -> None:
    """The formula along one axis, dotted where the foot would leave its mechanical reach."""
    name, unit = ("v_{up}", "m/s") if axis == LIFT else ("h_{up}", "m")
    value = settings[PACE if axis == LIFT else LIFT]
    xs = np.linspace(LEAST[axis], FARTHEST[axis], SAMPLES)
    points = [settings | {axis: float(x)} for x in xs]
    fast = np.array([formula(walk, **point) for point in points])
    straight = np.array([within_reach(walk, **point) for point in points])
    ax.plot(xs, fast, color=colour, lw=1.3, label=f"${name}$ = {value:g} {unit}")
    slower = np.where(straight < fast, straight, np.nan)
    ax.plot(xs, slower, color=colour, lw=1.1, ls=":")


def setting(walk: RecordedWalk, axis: str) -> float:
    """The h_up or v_up of a walk."""
    return walk.gait.lift_up if axis == LIFT else walk.machine.speed[2]


def formula(walk: RecordedWalk, lift: float, pace: float) -> float:
    """v_max of the standard step by H §7 (28), m/s."""
    speed = walk.machine.speed
    machine = replace(walk.machine, speed=(speed[0], speed[1], pace))
    return cruise_speed(machine, replace(walk.gait, lift_up=lift, lift_down=2 * lift), 0.0)


def within_reach(walk: RecordedWalk, lift: float, pace: float) -> float:
    """The speed at which the body goes δx while the foot comes straight down 2·h_up: faster, and
    the foot is out of reach.
    """
    return walk.machine.overreach[0] * pace / (2 * lift)


def walked_speed(walk: RecordedWalk) -> float:
    """Mean speed over whole cycles, the first one left out, m/s."""
    last = CYCLE + CYCLE * ((len(walk.steps) - CYCLE) // CYCLE)
    first = walk.row(CYCLE)
    end = walk.row(last)
    return float((walk.way[end] - walk.way[first]) / ((end - first) * TICK))
