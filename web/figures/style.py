"""Paper, strokes and the marks every drawing shares. Metres on the drawing, inches on the sheet."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import FancyBboxPatch, PathPatch, Polygon, Rectangle
from matplotlib.path import Path as Outline
from matplotlib.transforms import Affine2D

from walking_console.planner.geometry.paths import Box
from walking_console.planner.geometry.transforms import Pose

from ..scene.palette import LEGS
from .run_data import FigureError, Values

INK = "#1d2327"
PALE = "#9aa3a9"
FAINT = "#d9dee1"
PAPER = "#ffffff"
HOLE = "#c4bcb0"
WATER = "#cfe3f0"
EARTH = "#e4ddd0"
WARNING = "#c0182b"
NOTE = "#555d63"
TORSO = "#f4f6f7"
AVERAGE = "#b9c0c5"

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


class CellBlock(NamedTuple):
    """Cells of a map: rows from ``r0`` up to ``r1``, columns from ``c0`` up to ``c1``."""

    r0: int
    r1: int
    c0: int
    c1: int


def our_style() -> AbstractContextManager[None]:
    """The style every drawing is made in."""
    return mpl.rc_context(STYLE)


def blank_sheet(width: float, height: float, title: str, note: str = "") -> Figure:
    """A sheet with its title, and a line under it that says what is drawn; inches."""
    sheet = Figure(figsize=(width, height), facecolor=PAPER)
    sheet.text(0.35 / width, 1 - 0.2 / height, title, fontsize=12.5, fontweight="bold", va="top")
    if note:
        sheet.text(0.35 / width, 1 - 0.48 / height, note, fontsize=8.5, color=NOTE, va="top")
    return sheet


def save(sheet: Figure, out: Path) -> None:
    """Write the sheet in the form its suffix asks for; raises ``FigureError``."""
    form = out.suffix.lower().lstrip(".")
    if form not in ("svg", "png", "pdf"):
        raise FigureError(f"--out should end in .svg, .png or .pdf, got {str(out)!r}")
    metadata: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(form, {})
    try:
        with our_style():
            sheet.savefig(out, format=form, metadata=metadata)
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


def _in_body_axes(ax: Axes, pose: Pose) -> Any:
    """The transformation that places what is drawn in body axes."""
    x, y, yaw = pose
    return Affine2D().rotate(yaw).translate(x, y) + ax.transData


def rectangle(ax: Axes, box: Box, pose: Pose, **look: Any) -> None:
    """A rectangle of the body frame, placed on the ground."""
    x1, x2, y1, y2 = box
    ax.add_patch(Rectangle((x1, y1), x2 - x1, y2 - y1, transform=_in_body_axes(ax, pose), **look))


def torso(ax: Axes, size: Sequence[float], pose: Pose, *, alpha: float = 1.0) -> None:
    """The body from above, with a nose; ``size`` is its length and width, m."""
    length, width = size[0], size[1]
    turn = _in_body_axes(ax, pose)
    box = FancyBboxPatch(
        (-length / 2, -width / 2), length, width, boxstyle="round,pad=0,rounding_size=0.06",
        transform=turn, facecolor=TORSO, edgecolor=PALE, lw=0.8, alpha=alpha, zorder=1.5,
    )  # fmt: skip
    ax.add_patch(box)
    tip = length / 2 - 0.03
    nose = [(tip, 0.0), (tip - 0.10, 0.06), (tip - 0.10, -0.06)]
    look: dict[str, Any] = {"facecolor": PALE, "edgecolor": "none", "alpha": alpha, "zorder": 1.6}
    ax.add_patch(Polygon(nose, closed=True, transform=turn, **look))


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
    ax: Axes, mask: Values, cell: float, origin: Sequence[float] | Values, shown: Box, **look: Any
) -> None:
    """The marked cells of a map within a box as one outline."""
    window = _cells_within(mask, cell, origin, shown)
    corners: list[tuple[float, float]] = []
    codes: list[Any] = []
    for block in _blocks(mask, window):
        a, b = origin[0] + block.c0 * cell, origin[0] + block.c1 * cell
        c, d = origin[1] + block.r0 * cell, origin[1] + block.r1 * cell
        corners += [(a, c), (b, c), (b, d), (a, d), (a, c)]
        codes += [Outline.MOVETO, Outline.LINETO, Outline.LINETO, Outline.LINETO, Outline.CLOSEPOLY]
    if corners:
        style: dict[str, Any] = {"facecolor": HOLE, "edgecolor": "none", "zorder": 0.6}
        ax.add_patch(PathPatch(Outline(corners, codes), **(style | look)))


def _cells_within(
    mask: Values, cell: float, origin: Sequence[float] | Values, shown: Box
) -> CellBlock:
    """The cells of a map that a box covers."""
    x1, x2, y1, y2 = shown
    return CellBlock(
        max(0, math.floor((y1 - origin[1]) / cell)),
        min(mask.shape[0], math.ceil((y2 - origin[1]) / cell)),
        max(0, math.floor((x1 - origin[0]) / cell)),
        min(mask.shape[1], math.ceil((x2 - origin[0]) / cell)),
    )


def _blocks(mask: Values, window: CellBlock) -> list[CellBlock]:
    """The marked cells as rectangles: equal runs of neighbouring rows are one."""
    done: list[CellBlock] = []
    open_blocks: dict[tuple[int, int], CellBlock] = {}  # that the row above ended with
    for row in range(window.r0, window.r1):
        here = {}
        for first, last in runs(mask[row, window.c0 : window.c1]):
            above = open_blocks.pop((first, last), None)
            c0, c1 = window.c0 + first, window.c0 + last
            here[first, last] = CellBlock(above.r0 if above else row, row + 1, c0, c1)
        done += open_blocks.values()
        open_blocks = here
    return sorted([*done, *open_blocks.values()], key=lambda block: (block.r0, block.c0))


def runs(line: Values) -> list[tuple[int, int]]:
    """Where a row of flags is true: first and one past last of every run."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], line, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def leg_key(sheet: Figure, names: Sequence[str]) -> None:
    """Which colour is which leg, in the upper right corner."""
    width, height = sheet.get_size_inches()
    y = 1 - 0.28 / height
    for leg, name in enumerate(names):
        x = 1 - (2.45 - 0.6 * leg) / width
        sheet.add_artist(Line2D([x], [y], marker="o", ms=5, color=LEGS[leg]))
        sheet.text(x + 0.08 / width, y, f"{leg + 1} {name}", va="center", fontsize=7.5)
