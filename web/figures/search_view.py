"""Where a step was searched: D_u and its limits by methods I, II and III (H figs. 10 and 12)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.transforms import Affine2D

from walking_console.planner.crab.foothold_search import domain_of
from walking_console.planner.crab.gait import Posture
from walking_console.planner.geometry.paths import Box
from walking_console.planner.motion.leg_order import FRONT_ACROSS, IS_FRONT, REAR_ACROSS

from ..scene.palette import LEGS
from .run_data import RecordedWalk
from .style import INK

FINE = 161  # points a side at which a domain is asked; fewer: its edges look ragged
ONE_LINE = 0.01  # m; limits nearer to each other are drawn as one
BEYOND = 0.06  # m a limit is drawn on past the search box


def domain_marks(ax: Axes, walk: RecordedWalk, k: int) -> None:
    """D_u of step k, its limits, and I_u; nothing for a step that searched none."""
    step = walk.steps[k - 1]
    swing = walk.swing(k)
    if swing < 0 or step["search_start"] is None:
        return
    nominal, posture = walk.posture(k)
    leg = nominal.body_leg.index(swing)
    g = float(step["g"])
    domain = searched_domain(posture, leg, step)
    _fill(ax, posture, domain, LEGS[swing])
    _outline(ax, posture, domain.box)
    if not IS_FRONT[leg]:
        _limits(ax, posture, leg, g, domain.box)
    sx, sy, _ = step["search_start"]
    ax.plot([sx], [sy], "+", ms=8, mew=1.3, color=INK, zorder=7)
    look: dict[str, Any] = {"fontsize": 8, "va": "top", "zorder": 7}
    ax.annotate("$I_u$", (sx, sy), xytext=(5, -3), textcoords="offset points", **look)


def searched_domain(posture: Posture, leg: int, step: dict[str, Any]) -> Any:
    """The domain the step landed in: where method II left nothing, that of the second search."""
    g = float(step["g"])
    domain = domain_of(posture, leg, g, True)
    if domain.holds(*posture.canonical(*step["landing"][:2])):
        return domain
    return domain_of(posture, leg, g, False)


def _fill(ax: Axes, posture: Posture, domain: Any, colour: str) -> None:
    """The places in the search box that the domain does not refuse."""
    x1, x2, y1, y2 = domain.box
    xs = np.linspace(x1, x2, FINE)
    ys = np.linspace(y1, y2, FINE)
    within = np.array([[domain.holds(float(x), float(y)) for x in xs] for y in ys])
    c, s = posture.c, posture.s
    to_plan = Affine2D.from_values(c, s, -s, c, posture.x, posture.y) + ax.transData
    look: dict[str, Any] = {"colors": [colour], "alpha": 0.22, "zorder": 2.4}
    ax.contourf(xs, ys, within.astype(float), levels=[0.5, 1.5], transform=to_plan, **look)


def _outline(ax: Axes, posture: Posture, box: Box) -> None:
    x1, x2, y1, y2 = box
    corners = [posture.absolute(x, y) for x, y in ((x1, y1), (x2, y1), (x2, y2), (x1, y2))]
    ax.plot(*zip(*corners, corners[0], strict=True), color=INK, lw=0.6, ls=":", zorder=2.5)


def _limits(ax: Axes, posture: Posture, leg: int, g: float, box: Box) -> None:
    """The lines of methods I and II from f̄; one line where they all but fall together."""
    path = posture.nominal.path
    exits = posture.exits
    foot = posture.feet[FRONT_ACROSS[leg]]
    limit = min(exits[FRONT_ACROSS[leg]], exits[REAR_ACROSS[leg]])
    same = abs(limit - g) < ONE_LINE
    names = ("I = II", "") if same else ("I", "II")
    for name, distance, style in zip(names, (limit, g), ("-", "--"), strict=True):
        ahead = (distance * path.ux, distance * path.uy)
        _line_through(ax, posture, (foot, ahead), box, (name, style))


def _line_through(
    ax: Axes,
    posture: Posture,
    points: tuple[Sequence[float], Sequence[float]],
    box: Box,
    look: tuple[str, str],
) -> None:
    """The line from f̄ through a point of the path on to the far side of the search box."""
    f, p = points
    name, style = look
    dx = p[0] - f[0]
    dy = p[1] - f[1]
    far = box[2] - BEYOND if dy < 0 else box[3] + BEYOND
    t = (far - f[1]) / dy if abs(dy) > 1e-9 else 1.0
    a = posture.absolute(f[0], f[1])
    b = posture.absolute(f[0] + t * dx, f[1] + t * dy)
    ax.plot([a[0], b[0]], [a[1], b[1]], color=INK, lw=0.8, ls=style, zorder=2.6)
    ax.text(b[0], b[1], name, fontsize=7.5, ha="center", va="top" if dy < 0 else "bottom", zorder=7)
