"""Walks from the side: the ground in section, the paths of the feet and of the body, and the height
rule H fig. 15 compares with.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyBboxPatch, Polygon
from matplotlib.transforms import Affine2D

from walking_console.sim.runs.metrics import SPACING, average_rule
from walking_console.web.figures.run_data import Array, RecordedWalk
from walking_console.web.figures.style import EARTH, INK, LEGS, PALE

DEEP = 0.25  # m of ground drawn below its lowest point
NEAR_SIDE = (2, 3)  # legs on the right, drawn stronger: the viewer stands there


def along(walk: RecordedWalk, points: Array, direction: float) -> Array:
    """How far points (..., 2) lie ahead of the start along an absolute direction, m."""
    x, y = walk.body[0, :2]
    return np.asarray(
        (points[..., 0] - x) * math.cos(direction) + (points[..., 1] - y) * math.sin(direction)
    )


def across(walk: RecordedWalk, points: Array, direction: float) -> Array:
    """How far points (..., 2) lie to the left of the line through the start along an absolute
    direction, m.
    """
    x, y = walk.body[0, :2]
    return np.asarray(
        (points[..., 1] - y) * math.cos(direction) - (points[..., 0] - x) * math.sin(direction)
    )


def section(
    ax: Axes, walk: RecordedWalk, direction: float, low: float, high: float, beside: float = 0.0
) -> None:
    """The ground under the line through the start, ``beside`` it to the left, filled downwards;
    holes are gaps.
    """
    x, y = walk.body[0, :2]
    c, s = math.cos(direction), math.sin(direction)
    way = np.arange(low, high, float(walk.ground["cell"]) / 4)
    heights = walk.height_at(x + way * c - beside * s, y + way * s + beside * c)
    bottom = np.nanmin(heights) - DEEP
    ax.fill_between(
        way,
        bottom,
        heights,
        where=~np.isnan(heights),
        step="mid",
        facecolor=EARTH,
        edgecolor="none",
        zorder=1,
    )
    ax.plot(way, heights, color=INK, lw=0.9, drawstyle="steps-mid", zorder=1.1)


def foot_paths(
    ax: Axes,
    walk: RecordedWalk,
    direction: float,
    strip: tuple[float, float] = (-math.inf, math.inf),
) -> None:
    """The paths of the foot tips, as the lamps of H fig. 17 drew them; legs on the far side are
    paler.

    Only what lies in a strip along the direction: least and most to its left, m.
    """
    inside = across(walk, walk.log["feet"][..., :2], direction)
    shown = np.where(
        ((strip[0] < inside) & (inside < strip[1]))[..., None], walk.log["feet"], np.nan
    )
    for leg in range(shown.shape[1]):
        feet = shown[:, leg]
        ax.plot(
            along(walk, feet[:, :2], direction), feet[:, 2], color=LEGS[leg], zorder=3,
            lw=1.0 if leg in NEAR_SIDE else 0.7, alpha=1.0 if leg in NEAR_SIDE else 0.55,
        )  # fmt: skip
        for row in [
            walk.row(k) for k, step in enumerate(walk.steps, 1) if leg + 1 in step["swing"]
        ]:
            spot = shown[row, leg]
            ax.plot(
                [along(walk, spot[:2], direction)],
                [spot[2]],
                "o",
                ms=2.6,
                color=LEGS[leg],
                zorder=3.5,
            )


def body_path(ax: Axes, walk: RecordedWalk, direction: float, **look: Any) -> None:
    """The path of the CoG, a dot at every N_k."""
    way = along(walk, walk.body[:, :2], direction)
    style: dict[str, Any] = {"color": INK, "lw": 1.6, "zorder": 5} | look
    ax.plot(way, walk.body[:, 2], **style)
    rows = [walk.row(k) for k in range(len(walk.steps) + 1)]
    ax.plot(way[rows], walk.body[rows, 2], "o", ms=2.6, color=INK, zorder=5.1)


def average_path(ax: Axes, walk: RecordedWalk, direction: float, **look: Any) -> None:
    """Where the average-height rule would have the CoG on the same footholds, linked linearly
    between the N_k.
    """
    _, rows, heights = average_rule(
        walk.log, [step["tick"] for step in walk.steps], walk.gait.height
    )
    style: dict[str, Any] = {"color": INK, "lw": 1.1, "ls": (0, (5, 3)), "zorder": 4.6} | look
    ax.plot(along(walk, walk.body[rows, :2], direction), heights, **style)


def average_of_carrying(walk: RecordedWalk) -> Array:
    """The same rule taken tick by tick over the feet that carry: it jumps at every lift and
    landing.
    """
    carry = walk.log["support"]
    return np.asarray(
        (walk.log["feet"][..., 2] * carry).sum(axis=1) / carry.sum(axis=1) + walk.gait.height
    )


def second_differences(walk: RecordedWalk) -> list[tuple[Array, Array]]:
    """Places along the course, and the second differences of height there: as walked, and by the
    average-height rule.
    """
    course, rows, heights = average_rule(
        walk.log, [step["tick"] for step in walk.steps], walk.gait.height
    )
    places = np.arange(course[0], course[-1], SPACING)
    ours = np.interp(places, course, walk.body[:, 2])
    theirs = np.interp(places, course[rows], heights)
    return [(places[1:-1], np.diff(ours, 2)), (places[1:-1], np.diff(theirs, 2))]


def silhouette(ax: Axes, walk: RecordedWalk, k: int, direction: float) -> None:
    """The machine at N_k: torso, and a line from each hip to its foot."""
    x, _, z, yaw = walk.stance(k).body
    at = float(along(walk, np.array(walk.stance(k).body[:2]), direction))
    turn = yaw - direction
    length, width, height = walk.machine.torso
    half = (abs(math.cos(turn)) * length + abs(math.sin(turn)) * width) / 2
    look: dict[str, Any] = {"facecolor": "#f4f6f7", "edgecolor": PALE, "lw": 0.8, "zorder": 2}
    move = Affine2D().translate(at, z) + ax.transData
    outline = FancyBboxPatch(
        (-half, -height / 2),
        2 * half,
        height,
        boxstyle="round,pad=0,rounding_size=0.03",
        transform=move,
        **look,
    )
    ax.add_patch(outline)
    for leg, foot in enumerate(walk.stance(k).feet):
        cx, cy = walk.machine.legs[leg].centre
        hip = at + cx * math.cos(turn) - cy * math.sin(turn) * 0.5
        tip = float(along(walk, np.array(foot[:2]), direction))
        hip = min(max(hip, at - half), at + half)
        ax.add_patch(
            Polygon([(hip, z), (tip, foot[2])], closed=False, fill=False, edgecolor=LEGS[leg], lw=1.1, zorder=2.2,
                    alpha=0.9 if leg in NEAR_SIDE else 0.4)
        )  # fmt: skip
