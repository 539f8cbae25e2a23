"""Walks from above: single steps with support triangle, reach and stroke lines; whole walks with
numbered footholds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from walking_console.planner.crab.gait import NominalGait
from walking_console.planner.geometry.paths import Box, line_exit
from walking_console.planner.geometry.transforms import Pose, direction, placed, seen
from walking_console.planner.types import Point, Stance

from ..scene.palette import LEGS
from .run_data import RecordedWalk
from .style import (
    INK,
    PALE,
    WARNING,
    arrow,
    bare,
    cells,
    rectangle,
    torso,
)

# m around the body at N_k shown of one step
FRAME_X = (-0.85, 1.2)
FRAME_Y = (-0.78, 0.86)
NEW = 5.0  # points, size of a foot that stands in a step's frame
OLD = 3.4  # points, size of a foothold in the view of a whole walk
SAME_LABEL = 0.09  # m; footholds of one leg nearer to each other than this share a label
FORBIDDEN = "#eee9e1"


def travel(walk: RecordedWalk) -> float:
    """Absolute direction from the start of the walk to its end, rad."""
    dx, dy = walk.body[-1, :2] - walk.body[0, :2]
    return math.atan2(float(dy), float(dx))


# one step


def step_frame(ax: Axes, walk: RecordedWalk, k: int, **look: Any) -> None:
    """Step k (from 1) from above: where it stood at N_{k-1}, which leg went where, over which
    triangle the CoG went how far.
    """
    stance = walk.stance(k - 1)
    leg = walk.swing(k)
    _step_ground(ax, walk, stance, walk.nominal(k), **look)
    _support_triangle(ax, stance, leg, leg_colour(leg))
    end = walk.body[walk.row(k)]
    _body_way(ax, stance.body, (float(end[0]), float(end[1])), walk.steps[k - 1]["g0"])
    for i, foot in enumerate(stance.feet):
        if i != leg:
            _numbered_foot(ax, foot, i)
    if leg >= 0:
        _swung_foot(ax, leg, stance.feet[leg], walk.stance(k).feet[leg])
    what = f"leg {leg + 1}" if leg >= 0 else "shift on four legs"
    ax.set_title(f"step {k}: {what}", fontsize=9, pad=2)


def stuck_frame(ax: Axes, walk: RecordedWalk, leg: int, label: str) -> None:
    """Where the walk came to its end: the triangle the next leg would leave, and how far the CoG
    could go towards it.
    """
    count = len(walk.steps)
    stance = walk.stance(count)
    nominal = walk.nominal(count)
    _step_ground(ax, walk, stance, nominal)
    _support_triangle(ax, stance, leg, WARNING)
    pose = pose_of(stance)
    ux, uy = direction(nominal.course)
    room = _room_ahead(walk, stance, ux, uy)
    end = placed(pose, room * ux, room * uy)
    _body_way(ax, pose, end, 0.0)
    ax.plot([end[0]], [end[1]], "x", ms=9, mew=2.2, color=WARNING, zorder=7)
    for i, foot in enumerate(stance.feet):
        _numbered_foot(ax, foot, i)
    ax.set_title(label, fontsize=9, pad=2, color=WARNING)


def pose_of(stance: Stance) -> Pose:
    """Where the body stands on the ground plane."""
    x, y, _, yaw = stance.body
    return x, y, yaw


def leg_colour(leg: int) -> str:
    """A leg's colour; ink for a shift on four legs (-1)."""
    return LEGS[leg] if leg >= 0 else INK


def _room_ahead(walk: RecordedWalk, stance: Stance, ux: float, uy: float) -> float:
    """How far the body can go before a foot leaves its reach rectangle, m."""
    pose = pose_of(stance)
    feet = [seen(pose, foot[0], foot[1]) for foot in stance.feet]
    pairs = zip(feet, walk.machine.boxes, strict=True)
    return min(max(0.0, line_exit(x, y, box, ux, uy)) for (x, y), box in pairs)


def _step_ground(
    ax: Axes, walk: RecordedWalk, stance: Stance, nominal: NominalGait, **look: Any
) -> None:
    """An empty plan around the body with the holes that are there; torso, reach rectangles, and the
    standard stroke line through the middle of each.
    """
    x, y, yaw = pose = pose_of(stance)
    shown = x + FRAME_X[0], x + FRAME_X[1], y + FRAME_Y[0], y + FRAME_Y[1]
    bare(ax, shown[:2], shown[2:])
    _ground_marks(ax, walk, shown, **look)
    torso(ax, walk.machine.torso, pose)
    ux, uy = direction(yaw + nominal.course)
    half = nominal.stride / 2
    for leg in walk.machine.legs:
        rectangle(ax, leg.box, pose, facecolor="none", edgecolor=PALE, lw=0.6, zorder=1.8)
        mx, my = placed(pose, *leg.centre)
        xs = [mx - half * ux, mx + half * ux]
        ys = [my - half * uy, my + half * uy]
        ax.plot(xs, ys, color=PALE, lw=0.7, ls=(0, (4, 2)), zorder=1.9)


def _ground_marks(ax: Axes, walk: RecordedWalk, shown: Box, **look: Any) -> None:
    """Where it must not step, and darker where there is no ground at all."""
    origin = walk.ground.origin
    cell = walk.ground.cell
    hole = np.isnan(walk.ground.heights)
    edge = walk.ground.forbidden & ~hole
    if edge.any():
        cells(ax, edge, cell, origin, shown, facecolor=FORBIDDEN)
    cells(ax, hole, cell, origin, shown, **look)


def _support_triangle(ax: Axes, stance: Stance, leg: int, colour: str) -> None:
    """The triangle of the feet that carry while ``leg`` swings."""
    feet = [foot for i, foot in enumerate(stance.feet) if i != leg]
    xs = [foot[0] for foot in feet]
    ys = [foot[1] for foot in feet]
    ax.fill(xs, ys, facecolor=colour, alpha=0.13, edgecolor="none", zorder=2)
    ax.plot([*xs, xs[0]], [*ys, ys[0]], color=colour, lw=0.8, zorder=2.1)


def _body_way(ax: Axes, start: Sequence[float], end: Sequence[float], g0: float) -> None:
    """The way of the CoG in one step; a tick where the four-leg phase ends."""
    ax.plot([start[0]], [start[1]], "o", ms=3.2, color=INK, zorder=6)
    arrow(ax, start, end, lw=1.5, zorder=6)
    way = math.hypot(end[0] - start[0], end[1] - start[1])
    if g0 > 0.005 and way > 0.01:
        ux = (end[0] - start[0]) / way
        uy = (end[1] - start[1]) / way
        mx = start[0] + g0 * ux
        my = start[1] + g0 * uy
        xs = [mx - 0.035 * uy, mx + 0.035 * uy]
        ys = [my + 0.035 * ux, my - 0.035 * ux]
        ax.plot(xs, ys, color=INK, lw=1.2, zorder=6)


def _swung_foot(ax: Axes, leg: int, lifted: Point, landing: Point) -> None:
    """Where a foot was lifted, and where it came down."""
    colour = LEGS[leg]
    look: dict[str, Any] = {"ms": NEW, "mfc": "white", "mec": colour, "mew": 1.1, "zorder": 5}
    ax.plot([lifted[0]], [lifted[1]], "o", **look)
    arrow(ax, lifted, landing, color=colour, lw=1.4)
    _numbered_foot(ax, landing, leg)


def _numbered_foot(ax: Axes, foot: Sequence[float], leg: int) -> None:
    """A standing foot, with its leg's number outside of it."""
    ax.plot([foot[0]], [foot[1]], "o", ms=NEW, color=LEGS[leg], zorder=5)
    _label_outside(ax, foot, leg, str(leg + 1), away=4.0, fontsize=8, fontweight="bold")


def _label_outside(
    ax: Axes, foot: Sequence[float], leg: int, text: str, away: float, **look: Any
) -> None:
    """A label on the side of a foot that looks away from the machine, ``away`` points off."""
    outside = 1 if leg in (0, 1) else -1
    style: dict[str, Any] = {"ha": "center", "va": "bottom" if outside > 0 else "top"}
    ax.annotate(
        text, (foot[0], foot[1]), xytext=(0, away * outside), textcoords="offset points",
        color=LEGS[leg], zorder=6, **(style | look),
    )  # fmt: skip


# a whole walk


def walk_view(
    ax: Axes,
    walk: RecordedWalk,
    *,
    numbers: bool = True,
    bodies: Sequence[int] = (),
    triangles: Sequence[int] = (),
    believed: bool = False,
    milestones: int = 0,
    **look: Any,
) -> Box:
    """The whole walk from above: way of the CoG, footholds numbered by the step that made them,
    torsos at some N_k, support triangles of some steps; returns what is shown.

    ``milestones`` numbers every so many N_k along the way instead, ``believed`` marks what only the
    machine takes for forbidden.
    """
    shown = _box_around(walk)
    bare(ax, shown[:2], shown[2:])
    _ground_marks(ax, walk, shown, **look)
    if believed:
        _believed_marks(ax, walk, shown)
    for k in bodies:
        torso(ax, walk.machine.torso, pose_of(walk.stance(k)), alpha=0.9)
    for k in triangles:
        _support_triangle(ax, walk.stance(k - 1), walk.swing(k), leg_colour(walk.swing(k)))
    _way_of_the_body(ax, walk, milestones)
    labels = _footholds(ax, walk)
    for leg, landed in enumerate(labels if numbers else []):
        _number_feet(ax, leg, landed)
    return shown


def _box_around(walk: RecordedWalk, margin: float = 0.15) -> Box:
    """A box around all feet and bodies of the walk."""
    x1, x2, y1, y2 = walk.extent
    half = max(walk.machine.torso[:2]) / 2
    low = walk.body[:, :2].min(axis=0) - half
    high = walk.body[:, :2].max(axis=0) + half
    return (
        min(x1, float(low[0])) - margin,
        max(x2, float(high[0])) + margin,
        min(y1, float(low[1])) - margin,
        max(y2, float(high[1])) + margin,
    )


def _believed_marks(ax: Axes, walk: RecordedWalk, shown: Box) -> None:
    """What touch or sight has put on the machine's map and is not so."""
    learnt = walk.believed.forbidden & ~walk.ground.forbidden
    cell = walk.ground.cell
    cells(ax, learnt, cell, walk.ground.origin, shown, facecolor=WARNING, alpha=0.45)


def _way_of_the_body(ax: Axes, walk: RecordedWalk, milestones: int) -> None:
    """The way of the CoG with a dot at every N_k, and a number at every so many."""
    ax.plot(walk.body[:, 0], walk.body[:, 1], color=INK, lw=1.1, zorder=4)
    for k in range(len(walk.steps) + 1):
        x, y = (float(at) for at in walk.body[walk.row(k), :2])
        ax.plot([x], [y], "o", ms=1.8, color=INK, zorder=4.1)
        if milestones and k % milestones == 0:
            ax.plot([x], [y], "o", ms=3.6, color=INK, zorder=4.1)
            ax.annotate(
                str(k), (x, y), xytext=(3, 4), textcoords="offset points",
                fontsize=7, fontweight="bold", zorder=7,
            )  # fmt: skip


Landed = list[tuple[int, Point]]  # step, foothold


def _footholds(ax: Axes, walk: RecordedWalk) -> list[Landed]:
    """Every foothold with a line from the one before; the answer is who landed where, per leg."""
    here = list(walk.stance(0).feet)
    landed: list[Landed] = [[] for _ in here]
    for leg, foot in enumerate(here):
        look: dict[str, Any] = {"ms": OLD, "mfc": "white", "mec": LEGS[leg], "mew": 0.9}
        ax.plot([foot[0]], [foot[1]], "o", zorder=5, **look)
    for k, step in enumerate(walk.steps, 1):
        for leg in (number - 1 for number in step["swing"]):
            foot = walk.stance(k).feet[leg]
            xs = [here[leg][0], foot[0]]
            ys = [here[leg][1], foot[1]]
            ax.plot(xs, ys, color=LEGS[leg], lw=0.5, alpha=0.55, zorder=3)
            ax.plot([foot[0]], [foot[1]], "o", ms=OLD, color=LEGS[leg], zorder=5)
            landed[leg].append((k, foot))
            here[leg] = foot
    return landed


def _number_feet(ax: Axes, leg: int, landed: Landed) -> None:
    """Step numbers beside footholds; a foot that came down at the same place again has them in one
    label.
    """
    groups: list[tuple[list[int], Point]] = []
    for k, foot in landed:
        if groups and math.dist(groups[-1][1][:2], foot[:2]) < SAME_LABEL:
            groups[-1][0].append(k)
        else:
            groups.append(([k], foot))
    for numbers, foot in groups:
        _label_outside(ax, foot, leg, ", ".join(map(str, numbers)), away=3.2, fontsize=6.5)
