"""Pen, paper and the marks every drawing shares. Lengths in metres on the drawing, inches on the
sheet.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import FancyBboxPatch, PathPatch, Polygon, Rectangle
from matplotlib.path import Path as Outline
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray

from walking_console.planner.geometry.paths import Box
from walking_console.web.figures.run_data import FigureError

Array = NDArray[Any]

INK = "#1d2327"
PALE = "#9aa3a9"
FAINT = "#d9dee1"
PAPER = "#ffffff"
HOLE = "#c4bcb0"
WATER = "#cfe3f0"
EARTH = "#e4ddd0"
WARNING = "#c0182b"
# FL RL RR FR, told apart by colour-blind eyes too
LEGS = ("#0072b2", "#00855f", "#d55e00", "#a3448f")
NAMES = ("1 FL", "2 RL", "3 RR", "4 FR")

STYLE: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans", "Helvetica", "Arial"],
    "font.size": 8.5,
    "axes.linewidth": 0.6,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.titlecolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "text.color": INK,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "figure.dpi": 100,
    "savefig.dpi": 130,
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "walking-console",  # the same drawing is the same file
    "path.simplify_threshold": 0.6,
}


def pen() -> AbstractContextManager[None]:
    """The style every drawing is made in."""
    return mpl.rc_context(STYLE)


def sheet(width: float, height: float, title: str, note: str = "") -> Figure:
    """A page with its title, and a line under it that says what is drawn."""
    page = Figure(figsize=(width, height), facecolor=PAPER)
    page.text(0.35 / width, 1 - 0.2 / height, title, fontsize=12.5, fontweight="bold", va="top")
    if note:
        page.text(0.35 / width, 1 - 0.48 / height, note, fontsize=8.5, color="#555d63", va="top")
    return page


def save(page: Figure, out: Path) -> None:
    """Write the page in the form its suffix asks for; raises ``FigureError``."""
    form = out.suffix.lower().lstrip(".")
    if form not in ("svg", "png", "pdf"):
        raise FigureError(f"--out should end in .svg, .png or .pdf, got {str(out)!r}")
    metadata: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(form, {})
    try:
        with pen():
            page.savefig(out, format=form, metadata=metadata)
    except OSError as error:
        raise FigureError(f"cannot write {str(out)!r}: {error.strerror}") from None


def bare(ax: Axes, x: tuple[float, float], y: tuple[float, float]) -> None:
    """A plan: no axes, one metre as long as the other."""
    ax.set_aspect("equal")
    ax.set_xlim(*x)
    ax.set_ylim(*y)
    ax.set_axis_off()


def scale_bar(ax: Axes, x: float, y: float, length: float = 0.5) -> None:
    """How long half a metre is."""
    ax.plot(
        [x, x, x, x + length, x + length, x + length],
        [y - 0.02, y + 0.02, y, y, y + 0.02, y - 0.02],
        color=INK,
        lw=0.8,
    )
    ax.text(x + length / 2, y + 0.03, f"{length:g} m", ha="center", va="bottom", fontsize=7.5)


def rectangle(ax: Axes, box: Box, x: float, y: float, yaw: float, **look: Any) -> None:
    """A rectangle of the body frame, placed on the ground."""
    x1, x2, y1, y2 = box
    turn = Affine2D().rotate(yaw).translate(x, y) + ax.transData
    ax.add_patch(Rectangle((x1, y1), x2 - x1, y2 - y1, transform=turn, **look))


def torso(
    ax: Axes, size: Sequence[float], x: float, y: float, yaw: float, *, alpha: float = 1.0
) -> None:
    """The body from above, with a nose."""
    length, width = size[0], size[1]
    turn = Affine2D().rotate(yaw).translate(x, y) + ax.transData
    look: dict[str, Any] = {
        "facecolor": "#f4f6f7",
        "edgecolor": PALE,
        "lw": 0.8,
        "alpha": alpha,
        "zorder": 1.5,
    }
    ax.add_patch(
        FancyBboxPatch(
            (-length / 2, -width / 2),
            length,
            width,
            boxstyle="round,pad=0,rounding_size=0.06",
            transform=turn,
            **look,
        )
    )
    nose = [(length / 2 - 0.03, 0.0), (length / 2 - 0.13, 0.06), (length / 2 - 0.13, -0.06)]
    ax.add_patch(
        Polygon(
            nose,
            closed=True,
            transform=turn,
            facecolor=PALE,
            edgecolor="none",
            alpha=alpha,
            zorder=1.6,
        )
    )


def arrow(ax: Axes, start: Sequence[float], end: Sequence[float], **look: Any) -> None:
    """A straight arrow; nothing where there is no way."""
    if math.hypot(end[0] - start[0], end[1] - start[1]) < 1e-4:
        return
    style: dict[str, Any] = {
        "arrowstyle": "-|>,head_length=0.35,head_width=0.18",
        "shrinkA": 0,
        "shrinkB": 0,
        "lw": 1.2,
        "color": INK,
    }
    zorder = look.pop("zorder", 4)
    ax.annotate("", (end[0], end[1]), (start[0], start[1]), arrowprops=style | look, zorder=zorder)


def cells(
    ax: Axes, mask: Array, cell: float, origin: Sequence[float] | Array, shown: Box, **look: Any
) -> None:
    """The marked cells of a map within a box as one outline, run by run."""
    x1, x2, y1, y2 = shown
    c1, c2 = (
        max(0, math.floor((x1 - origin[0]) / cell)),
        min(mask.shape[1], math.ceil((x2 - origin[0]) / cell)),
    )
    r1, r2 = (
        max(0, math.floor((y1 - origin[1]) / cell)),
        min(mask.shape[0], math.ceil((y2 - origin[1]) / cell)),
    )
    # first column, last, first row, last: equal runs of neighbouring rows are one block
    blocks: list[list[int]] = []
    for row in range(r1, r2):
        for first, last in runs(mask[row, c1:c2]):
            above = next(
                (b for b in blocks if b[3] == row and b[0] == first and b[1] == last), None
            )
            if above is None:
                blocks.append([first, last, row, row + 1])
            else:
                above[3] = row + 1
    corners: list[tuple[float, float]] = []
    codes: list[Any] = []
    for first, last, low, high in blocks:
        a, b = origin[0] + (c1 + first) * cell, origin[0] + (c1 + last) * cell
        c, d = origin[1] + low * cell, origin[1] + high * cell
        corners += [(a, c), (b, c), (b, d), (a, d), (a, c)]
        codes += [Outline.MOVETO, Outline.LINETO, Outline.LINETO, Outline.LINETO, Outline.CLOSEPOLY]
    if corners:
        ax.add_patch(
            PathPatch(
                Outline(corners, codes),
                **({"facecolor": HOLE, "edgecolor": "none", "zorder": 0.6} | look),
            )
        )


def runs(line: Array) -> list[tuple[int, int]]:
    """Where a row of flags is true: first and one past last of every run."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], line, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def leg_key(page: Figure, legs: Iterable[int] = range(4)) -> None:
    """Which colour is which leg, in the upper right corner."""
    width, height = page.get_size_inches()
    for place, leg in enumerate(legs):
        x, y = 1 - (2.45 - 0.6 * place) / width, 1 - 0.28 / height
        page.add_artist(Line2D([x], [y], marker="o", ms=5, color=LEGS[leg]))
        page.text(x + 0.08 / width, y, NAMES[leg], va="center", fontsize=7.5)
