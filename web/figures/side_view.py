"""Walks from the side: the ground in section, the paths of the feet and of the body, and the height
rule H fig. 15 compares with.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyBboxPatch, Polygon
from matplotlib.transforms import Affine2D

from walking_console.planner.geometry.transforms import direction, turned
from walking_console.sim.runs.metrics import SPACING, average_rule

from ..scene.palette import LEGS
from .run_data import RecordedWalk, Values
from .style import EARTH, INK, PALE, TORSO

DEEP = 0.25  # m of ground drawn below its lowest point
BESIDE = 0.9  # m of ground drawn before the start and behind the end
NEAR_SIDE = (2, 3)  # legs on the right, drawn stronger: the viewer stands there
FORESHORTENED = 0.5  # share of a hip's sideways place that shows when the body is seen askew


def along(walk: RecordedWalk, points: Values, angle: float) -> Values:
    """How far points (..., 2) lie ahead of the start along an absolute direction, m."""
    x, y = walk.body[0, :2]
    c, s = direction(angle)
    return np.asarray((points[..., 0] - x) * c + (points[..., 1] - y) * s)


def across(walk: RecordedWalk, points: Values, angle: float) -> Values:
    """How far points (..., 2) lie to the left of the line through the start along an absolute
    direction, m.
    """
    x, y = walk.body[0, :2]
    c, s = direction(angle)
    return np.asarray((points[..., 1] - y) * c - (points[..., 0] - x) * s)


def side_view(
    ax: Axes, walk: RecordedWalk, angle: float, *, bodies: Sequence[int], feet: bool = True
) -> None:
    """Ground, machine at some N_k, paths; one metre up is one metre along."""
    way = along(walk, walk.body[:, :2], angle)
    low = float(way.min()) - BESIDE
    high = float(way.max()) + BESIDE
    section(ax, walk, angle, (low, high))
    for k in bodies:
        silhouette(ax, walk, k, angle)
    if feet:
        foot_paths(ax, walk, angle)
    body_path(ax, walk, angle)
    ax.set_aspect("equal")
    ax.set_xlim(low, high)
    ax.set_ylabel("height, m")
    ax.set_xlabel("way along the course, m")


def section(
    ax: Axes, walk: RecordedWalk, angle: float, span: tuple[float, float], beside: float = 0.0
) -> None:
    """The ground under the line through the start, ``beside`` it to the left, filled downwards;
    holes are gaps.
    """
    x, y = walk.body[0, :2]
    c, s = direction(angle)
    way = np.arange(*span, walk.ground.cell / 4)
    heights = walk.height_at(x + way * c - beside * s, y + way * s + beside * c)
    bottom = np.nanmin(heights) - DEEP
    look: dict[str, Any] = {"step": "mid", "facecolor": EARTH, "edgecolor": "none", "zorder": 1}
    ax.fill_between(way, bottom, heights, where=~np.isnan(heights), **look)
    ax.plot(way, heights, color=INK, lw=0.9, drawstyle="steps-mid", zorder=1.1)


def foot_paths(
    ax: Axes,
    walk: RecordedWalk,
    angle: float,
    strip: tuple[float, float] = (-math.inf, math.inf),
) -> None:
    """The paths of the foot tips, as the lamps of H fig. 17 drew them; legs on the far side are
    paler.

    Only what lies in a strip along the direction: least and most to its left, m.
    """
    aside = across(walk, walk.log["feet"][..., :2], angle)
    within = (strip[0] < aside) & (aside < strip[1])
    shown = np.where(within[..., None], walk.log["feet"], np.nan)
    for leg in range(shown.shape[1]):
        _foot_path(ax, walk, leg, along(walk, shown[:, leg, :2], angle), shown[:, leg, 2])


def _foot_path(ax: Axes, walk: RecordedWalk, leg: int, way: Values, height: Values) -> None:
    """One foot's path, with a dot wherever it came down."""
    near = leg in NEAR_SIDE
    look: dict[str, Any] = {"lw": 1.0 if near else 0.7, "alpha": 1.0 if near else 0.55}
    ax.plot(way, height, color=LEGS[leg], zorder=3, **look)
    landed = [walk.row(k) for k, step in enumerate(walk.steps, 1) if leg + 1 in step["swing"]]
    for row in landed:
        ax.plot([way[row]], [height[row]], "o", ms=2.6, color=LEGS[leg], zorder=3.5)


def body_path(ax: Axes, walk: RecordedWalk, angle: float, **look: Any) -> None:
    """The path of the CoG, a dot at every N_k."""
    way = along(walk, walk.body[:, :2], angle)
    style: dict[str, Any] = {"color": INK, "lw": 1.6, "zorder": 5} | look
    ax.plot(way, walk.body[:, 2], **style)
    rows = [walk.row(k) for k in range(len(walk.steps) + 1)]
    ax.plot(way[rows], walk.body[rows, 2], "o", ms=2.6, color=INK, zorder=5.1)


def average_path(ax: Axes, walk: RecordedWalk, angle: float, **look: Any) -> None:
    """Where the average-height rule would have the CoG on the same footholds, linked linearly
    between the N_k.
    """
    _, rows, heights = _average_rule(walk)
    style: dict[str, Any] = {"color": INK, "lw": 1.1, "ls": (0, (5, 3)), "zorder": 4.6} | look
    ax.plot(along(walk, walk.body[rows, :2], angle), heights, **style)


def _average_rule(walk: RecordedWalk) -> tuple[Any, ...]:
    ends = [step["tick"] for step in walk.steps]
    return average_rule(walk.log, ends, walk.gait.height)


def average_of_carrying(walk: RecordedWalk) -> Values:
    """The same rule taken tick by tick over the feet that carry: it jumps at every lift and
    landing.
    """
    carry = walk.log["support"]
    feet = (walk.log["feet"][..., 2] * carry).sum(axis=1) / carry.sum(axis=1)
    return np.asarray(feet + walk.gait.height)


def second_differences(walk: RecordedWalk) -> list[tuple[Values, Values]]:
    """Places along the course, and the second differences of height there: as walked, and by the
    average-height rule.
    """
    way, rows, heights = _average_rule(walk)
    places = np.arange(way[0], way[-1], SPACING)
    walked = np.interp(places, way, walk.body[:, 2])
    average = np.interp(places, way[rows], heights)
    return [(places[1:-1], np.diff(walked, 2)), (places[1:-1], np.diff(average, 2))]


def silhouette(ax: Axes, walk: RecordedWalk, k: int, angle: float) -> None:
    """The machine at N_k: torso, and a line from each hip to its foot."""
    stance = walk.stance(k)
    x, y, z, yaw = stance.body
    at = float(along(walk, np.array((x, y)), angle))
    c, s = direction(yaw - angle)
    length, width, height = walk.machine.torso
    half = (abs(c) * length + abs(s) * width) / 2
    outline = FancyBboxPatch(
        (-half, -height / 2), 2 * half, height, boxstyle="round,pad=0,rounding_size=0.03",
        transform=Affine2D().translate(at, z) + ax.transData,
        facecolor=TORSO, edgecolor=PALE, lw=0.8, zorder=2,
    )  # fmt: skip
    ax.add_patch(outline)
    for leg, foot in enumerate(stance.feet):
        cx, cy = walk.machine.legs[leg].centre
        hip = min(max(turned(cx, cy * FORESHORTENED, yaw - angle)[0], -half), half)
        tip = float(along(walk, np.array(foot[:2]), angle))
        _leg_line(ax, leg, (at + hip, z), (tip, foot[2]))


def _leg_line(ax: Axes, leg: int, hip: tuple[float, float], tip: tuple[float, float]) -> None:
    look: dict[str, Any] = {"edgecolor": LEGS[leg], "lw": 1.1, "zorder": 2.2}
    alpha = 0.9 if leg in NEAR_SIDE else 0.4
    ax.add_patch(Polygon([hip, tip], closed=False, fill=False, alpha=alpha, **look))
