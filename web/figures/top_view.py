"""Walks from above: single steps with support triangle, reach and stroke lines; whole courses with
numbered footholds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from walking_console.planner.crab.foothold_search import domain_of
from walking_console.planner.crab.gait import FRONT_ACROSS, IS_FRONT, REAR_ACROSS, Posture, Standard
from walking_console.planner.crab.leg_selection import exits_of
from walking_console.planner.geometry.paths import Box, line_exit
from walking_console.web.figures.run_data import RecordedWalk
from walking_console.web.figures.style import (
    FAINT,
    INK,
    LEGS,
    PALE,
    WARNING,
    arrow,
    bare,
    cells,
    rectangle,
    torso,
)

FRAME_X, FRAME_Y = (-0.85, 1.2), (-0.78, 0.86)  # m around the body at N_k shown of one step
NEW, OLD = 5.0, 3.4  # points, size of feet
SAME_LABEL = 0.09  # m; footholds of one leg nearer to each other than this share a label


def travel(walk: RecordedWalk) -> float:
    """Absolute direction from the start of the walk to its end, rad."""
    dx, dy = walk.body[-1, :2] - walk.body[0, :2]
    return math.atan2(float(dy), float(dx))


def step_frame(ax: Axes, walk: RecordedWalk, k: int, label: str = "", **look: Any) -> None:
    """Step k (from 1) from above: where it stood at N_{k-1}, which leg went where, over which
    triangle the CoG went how far.
    """
    stance, standard = walk.stance(k - 1), walk.standard(k)
    leg = walk.swing(k)
    x, y, _, yaw = stance.body
    frame(ax, walk, x, y, **look)
    posture_marks(ax, walk, standard, x, y, yaw)
    standing = [foot for i, foot in enumerate(stance.feet) if i != leg]
    triangle(ax, standing, LEGS[leg] if leg >= 0 else INK)
    end = walk.body[walk.row(k)]
    body_way(ax, (x, y), (float(end[0]), float(end[1])), walk.steps[k - 1]["g0"])
    for i, foot in enumerate(stance.feet):
        if i != leg:
            foot_mark(ax, foot, i, number=i + 1)
    if leg >= 0:
        landing = walk.stance(k).feet[leg]
        ax.plot(
            [stance.feet[leg][0]],
            [stance.feet[leg][1]],
            "o",
            ms=NEW,
            mfc="white",
            mec=LEGS[leg],
            mew=1.1,
            zorder=5,
        )
        arrow(ax, stance.feet[leg], landing, color=LEGS[leg], lw=1.4)
        foot_mark(ax, landing, leg, number=leg + 1)
    ax.set_title(
        label or f"step {k}: {f'leg {leg + 1}' if leg >= 0 else 'shift on four legs'}",
        fontsize=9,
        pad=2,
    )


def stuck_frame(ax: Axes, walk: RecordedWalk, leg: int, label: str) -> None:
    """Where the walk came to its end: the triangle the next leg would leave, and how far the CoG
    could go towards it.
    """
    count = len(walk.steps)
    stance, standard = walk.stance(count), walk.standard(count)
    x, y, _, yaw = stance.body
    frame(ax, walk, x, y)
    posture_marks(ax, walk, standard, x, y, yaw)
    standing = [foot for i, foot in enumerate(stance.feet) if i != leg]
    triangle(ax, standing, WARNING)
    course = yaw + standard.course
    c, s = math.cos(yaw), math.sin(yaw)
    seen = [(c * (f[0] - x) + s * (f[1] - y), c * (f[1] - y) - s * (f[0] - x)) for f in stance.feet]
    ux, uy = math.cos(standard.course), math.sin(standard.course)
    room = min(
        max(0.0, line_exit(fx, fy, box, ux, uy))
        for (fx, fy), box in zip(seen, walk.machine.boxes, strict=True)
    )
    end = x + room * math.cos(course), y + room * math.sin(course)
    body_way(ax, (x, y), end, 0.0)
    ax.plot([end[0]], [end[1]], "x", ms=9, mew=2.2, color=WARNING, zorder=7)
    for i, foot in enumerate(stance.feet):
        foot_mark(ax, foot, i, number=i + 1)
    ax.set_title(label, fontsize=9, pad=2, color=WARNING)


def frame(ax: Axes, walk: RecordedWalk, x: float, y: float, **look: Any) -> None:
    """An empty plan around a place, with the holes that are there."""
    shown = x + FRAME_X[0], x + FRAME_X[1], y + FRAME_Y[0], y + FRAME_Y[1]
    bare(ax, shown[:2], shown[2:])
    ground_marks(ax, walk, shown, **look)


def ground_marks(ax: Axes, walk: RecordedWalk, shown: Box, **look: Any) -> None:
    """Where it must not step, and darker where there is no ground at all."""
    origin, cell = walk.ground["origin"], float(walk.ground["cell"])
    hole = np.isnan(walk.ground["heights"])
    edge = walk.ground["forbidden"] & ~hole
    if edge.any():
        cells(ax, edge, cell, origin, shown, facecolor="#eee9e1")
    cells(ax, hole, cell, origin, shown, **look)


def posture_marks(
    ax: Axes, walk: RecordedWalk, standard: Standard, x: float, y: float, yaw: float
) -> None:
    """Torso, reach rectangles, and the standard stroke line through the middle of each."""
    torso(ax, walk.machine.torso, x, y, yaw)
    course, half = yaw + standard.course, standard.stride / 2
    for leg in walk.machine.legs:
        rectangle(ax, leg.box, x, y, yaw, facecolor="none", edgecolor=PALE, lw=0.6, zorder=1.8)
        cx, cy = leg.centre
        mx, my = (
            x + math.cos(yaw) * cx - math.sin(yaw) * cy,
            y + math.sin(yaw) * cx + math.cos(yaw) * cy,
        )
        dx, dy = half * math.cos(course), half * math.sin(course)
        ax.plot(
            [mx - dx, mx + dx], [my - dy, my + dy], color=PALE, lw=0.7, ls=(0, (4, 2)), zorder=1.9
        )


def triangle(ax: Axes, feet: Sequence[Sequence[float]], colour: str) -> None:
    """The triangle of the feet that carry."""
    xs, ys = [f[0] for f in feet], [f[1] for f in feet]
    ax.fill(xs, ys, facecolor=colour, alpha=0.13, edgecolor="none", zorder=2)
    ax.plot([*xs, xs[0]], [*ys, ys[0]], color=colour, lw=0.8, zorder=2.1)


def body_way(ax: Axes, start: Sequence[float], end: Sequence[float], g0: float) -> None:
    """The way of the CoG in one step; a tick where the four-leg phase ends."""
    ax.plot([start[0]], [start[1]], "o", ms=3.2, color=INK, zorder=6)
    arrow(ax, start, end, lw=1.5, zorder=6)
    way = math.hypot(end[0] - start[0], end[1] - start[1])
    if g0 > 0.005 and way > 0.01:
        ux, uy = (end[0] - start[0]) / way, (end[1] - start[1]) / way
        mx, my = start[0] + g0 * ux, start[1] + g0 * uy
        ax.plot(
            [mx - 0.035 * uy, mx + 0.035 * uy],
            [my + 0.035 * ux, my - 0.035 * ux],
            color=INK,
            lw=1.2,
            zorder=6,
        )


def foot_mark(ax: Axes, foot: Sequence[float], leg: int, number: int | None = None) -> None:
    """A standing foot, with its leg's number outside of it."""
    ax.plot([foot[0]], [foot[1]], "o", ms=NEW, color=LEGS[leg], zorder=5)
    if number is not None:
        outside = 1 if leg in (0, 1) else -1
        ax.annotate(
            str(number), (foot[0], foot[1]), xytext=(0, 4 * outside), textcoords="offset points", ha="center",
            va="bottom" if outside > 0 else "top", fontsize=8, color=LEGS[leg], fontweight="bold", zorder=6,
        )  # fmt: skip


def course_view(
    ax: Axes,
    walk: RecordedWalk,
    *,
    numbers: bool = True,
    bodies: Sequence[int] = (),
    triangles: Sequence[int] = (),
    believed: bool = False,
    milestones: int = 0,
    margin: float = 0.15,
    **look: Any,
) -> Box:
    """The whole walk from above: way of the CoG, footholds numbered by the step that made them,
    torsos at some N_k.

    ``milestones`` numbers every so many N_k along the way instead.
    """
    x1, x2, y1, y2 = walk.extent
    half = max(walk.machine.torso[:2]) / 2
    low = float(walk.body[:, 0].min()) - half, float(walk.body[:, 1].min()) - half
    high = float(walk.body[:, 0].max()) + half, float(walk.body[:, 1].max()) + half
    shown = (
        min(x1, low[0]) - margin,
        max(x2, high[0]) + margin,
        min(y1, low[1]) - margin,
        max(y2, high[1]) + margin,
    )
    bare(ax, shown[:2], shown[2:])
    ground_marks(ax, walk, shown, **look)
    if believed:
        learnt = walk.ground["believed_forbidden"] & ~walk.ground["forbidden"]
        cells(
            ax,
            learnt,
            float(walk.ground["cell"]),
            walk.ground["origin"],
            shown,
            facecolor=WARNING,
            alpha=0.45,
        )
    for k in bodies:
        x, y, _, yaw = walk.stance(k).body
        torso(ax, walk.machine.torso, x, y, yaw, alpha=0.9)
    for k in triangles:
        leg = walk.swing(k)
        triangle(
            ax,
            [foot for i, foot in enumerate(walk.stance(k - 1).feet) if i != leg],
            LEGS[leg] if leg >= 0 else INK,
        )
    ax.plot(walk.body[:, 0], walk.body[:, 1], color=INK, lw=1.1, zorder=4)
    for k in range(len(walk.steps) + 1):
        row = walk.row(k)
        x, y = float(walk.body[row, 0]), float(walk.body[row, 1])
        ax.plot([x], [y], "o", ms=1.8, color=INK, zorder=4.1)
        if milestones and k % milestones == 0:
            ax.plot([x], [y], "o", ms=3.6, color=INK, zorder=4.1)
            ax.annotate(
                str(k),
                (x, y),
                xytext=(3, 4),
                textcoords="offset points",
                fontsize=7,
                fontweight="bold",
                zorder=7,
            )
    here = list(walk.stance(0).feet)
    labels: list[list[tuple[int, Sequence[float]]]] = [[] for _ in here]
    for leg, foot in enumerate(here):
        ax.plot([foot[0]], [foot[1]], "o", ms=OLD, mfc="white", mec=LEGS[leg], mew=0.9, zorder=5)
    for k, step in enumerate(walk.steps, 1):
        for number in step["swing"]:
            leg = number - 1
            foot = walk.stance(k).feet[leg]
            ax.plot(
                [here[leg][0], foot[0]],
                [here[leg][1], foot[1]],
                color=LEGS[leg],
                lw=0.5,
                alpha=0.55,
                zorder=3,
            )
            ax.plot([foot[0]], [foot[1]], "o", ms=OLD, color=LEGS[leg], zorder=5)
            labels[leg].append((k, foot))
            here[leg] = foot
    for leg, landed in enumerate(labels if numbers else []):
        number_feet(ax, leg, landed)
    return shown


def number_feet(ax: Axes, leg: int, landed: Sequence[tuple[int, Sequence[float]]]) -> None:
    """Step numbers beside footholds; a foot that came down at the same place again has them in one
    label.
    """
    outside = 1 if leg in (0, 1) else -1
    groups: list[tuple[list[int], Sequence[float]]] = []
    for k, foot in landed:
        if groups and math.dist(groups[-1][1][:2], foot[:2]) < SAME_LABEL:
            groups[-1][0].append(k)
        else:
            groups.append(([k], foot))
    for numbers, foot in groups:
        ax.annotate(
            ", ".join(map(str, numbers)), (foot[0], foot[1]), xytext=(0, 3.2 * outside), textcoords="offset points", ha="center",
            va="bottom" if outside > 0 else "top", fontsize=6.5, color=LEGS[leg], zorder=6,
        )  # fmt: skip


def domain_marks(ax: Axes, walk: RecordedWalk, k: int) -> None:
    """D_u of step k: its limits by methods I, II and III, I_u and J_u (H figs. 10 and 12)."""
    standard, posture = walk.posture(k)
    step, swing = walk.steps[k - 1], walk.swing(k)
    if swing < 0 or step["search_start"] is None:
        return
    leg = standard.body_leg.index(swing)
    exits = exits_of(standard, posture)
    g = float(step["g"])
    domain = domain_of(standard, posture.feet, exits, leg, g, True)
    # method II left nothing: the second search
    if domain.refuses(*posture.canonical(*step["landing"][:2])) is not None:
        domain = domain_of(standard, posture.feet, exits, leg, g, False)
    box = domain.box
    xs, ys = np.linspace(box[0], box[1], 161), np.linspace(box[2], box[3], 161)
    within = np.array([[domain.refuses(float(x), float(y)) is None for x in xs] for y in ys])
    px, py = np.meshgrid(xs, ys)
    ax_, ay_ = placed(posture, px, py)
    ax.contourf(
        ax_,
        ay_,
        within.astype(float),
        levels=[0.5, 1.5],
        colors=[LEGS[swing]],
        alpha=0.22,
        zorder=2.4,
    )
    corners = [
        posture.absolute(x, y)
        for x, y in ((box[0], box[2]), (box[1], box[2]), (box[1], box[3]), (box[0], box[3]))
    ]
    ax.plot(*zip(*corners, corners[0], strict=True), color=INK, lw=0.6, ls=":", zorder=2.5)
    if not IS_FRONT[leg]:
        f = posture.feet[FRONT_ACROSS[leg]]
        limit = min(exits[FRONT_ACROSS[leg]], exits[REAR_ACROSS[leg]])
        same = abs(limit - g) < 0.01
        for name, distance, style in (
            ("I = II" if same else "I", limit, "-"),
            ("" if same else "II", g, "--"),
        ):
            line_through(
                ax, posture, f, (distance * standard.ux, distance * standard.uy), box, name, style
            )
    sx, sy, _ = step["search_start"]
    ax.plot([sx], [sy], "+", ms=8, mew=1.3, color=INK, zorder=7)
    ax.annotate(
        "$I_u$",
        (sx, sy),
        xytext=(5, -3),
        textcoords="offset points",
        fontsize=8,
        va="top",
        zorder=7,
    )


def placed(posture: Posture, px: Any, py: Any) -> tuple[Any, Any]:
    """Arrays of the canonical frame in the absolute one."""
    return posture.x + posture.c * px - posture.s * py, posture.y + posture.s * px + posture.c * py


def line_through(
    ax: Axes,
    posture: Posture,
    f: Sequence[float],
    p: Sequence[float],
    box: Box,
    name: str,
    style: str,
) -> None:
    """The line from f̄ through a point of the course on to the far side of the search box."""
    dx, dy = p[0] - f[0], p[1] - f[1]
    far = (box[2] if dy < 0 else box[3]) + (-0.06 if dy < 0 else 0.06)
    t = (far - f[1]) / dy if abs(dy) > 1e-9 else 1.0
    end = f[0] + t * dx, f[1] + t * dy
    a, b = posture.absolute(*f), posture.absolute(*end)
    ax.plot([a[0], b[0]], [a[1], b[1]], color=INK, lw=0.8, ls=style, zorder=2.6)
    ax.text(b[0], b[1], name, fontsize=7.5, ha="center", va="top" if dy < 0 else "bottom", zorder=7)


def gait_diagram(ax: Axes, walk: RecordedWalk, order: Sequence[int] = (0, 1, 2, 3)) -> None:
    """Who stands when, over the way of the CoG: bars are standing feet, numbers the steps in the
    gaps.
    """
    course = walk.course
    for place, leg in enumerate(order):
        for first, last in standing_runs(walk.log["support"][:, leg]):
            a, b = course[first], course[min(last, len(course) - 1)]
            ax.barh(-place, b - a, left=a, height=0.42, color=LEGS[leg], linewidth=0)
    for k, step in enumerate(walk.steps, 1):
        a, b = course[walk.row(k - 1)] + step["g0"], course[walk.row(k)]
        for number in step["swing"]:
            if b - a > 0.03:
                ax.text(
                    (a + b) / 2,
                    -order.index(number - 1),
                    str(k),
                    ha="center",
                    va="center",
                    fontsize=6.5,
                    color=INK,
                )
    ax.set_yticks([-i for i in range(len(order))], [f"leg {leg + 1}" for leg in order])
    ax.set_xlim(0, course[-1])
    ax.set_ylim(-len(order) + 0.5, 0.5)
    ax.set_xlabel("way of the centre of gravity, m")
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)
    for k in range(len(walk.steps) + 1):
        ax.axvline(course[walk.row(k)], color=FAINT, lw=0.6, zorder=0)


def standing_runs(flags: Any) -> list[tuple[int, int]]:
    """First and last row of every stretch in which a foot stands."""
    from walking_console.web.figures.style import runs

    return runs(np.asarray(flags, dtype=bool))
