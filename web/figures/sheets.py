"""One function a sheet: which views a figure is made of."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from walking_console.planner.geometry.paths import Box
from walking_console.planner.geometry.transforms import direction
from walking_console.planner.types import Point

from ..scene.palette import leg_names
from .gait_diagram import gait_diagram
from .run_data import RecordedWalk, degrees
from .search_view import domain_marks
from .side_view import (
    BESIDE,
    along,
    average_of_carrying,
    average_path,
    body_path,
    foot_paths,
    second_differences,
    section,
    side_view,
)
from .style import (
    AVERAGE,
    EARTH,
    INK,
    PALE,
    WARNING,
    WATER,
    arrow,
    blank_sheet,
    cells,
    leg_key,
    our_style,
    scale_bar,
)
from .top_view import (
    leg_colour,
    step_frame,
    stuck_frame,
    travel,
    walk_view,
)

Walks = Mapping[str, RecordedWalk]
SheetMaker = Callable[[str, Walks], Figure]

STANDARD_WITHIN = 0.05  # of λ*; a step nearer to its standard layout counts as standard
SLANTED = 0.7  # sine of the travel direction from which on a tall sheet shows more
NUMBERED_STEPS = 60  # footholds of longer walks carry no numbers: they would cover each other
OFF = 0.02  # m from the start of the search from which on a landing counts as moved
RAISED = 0.02  # m over the median height from which on ground is drawn as relief


def in_our_style(maker: SheetMaker) -> SheetMaker:
    """Draw in our style whatever matplotlib's own settings say."""

    @wraps(maker)
    def drawn(title: str, walks: Walks) -> Figure:
        with our_style():
            return maker(title, walks)

    return drawn


# what sheets share


def walk_note(walk: RecordedWalk) -> str:
    """How the walk was commanded and how far it went, in a line."""
    angles = {angle for _, angle in walk.commands()}
    alpha = f"α = {degrees(next(iter(angles)))}, " if len(angles) == 1 else ""
    way = f"{len(walk.steps)} steps, {walk.summary['distance']:.2f} m"
    body = "" if walk.gait.sways else "; body straight as printed"
    return f"{alpha}β = {walk.gait.duty_factor:g}; {way}{body}"


def grid(
    sheet: Figure,
    shape: tuple[int, int],
    edges: Sequence[float],
    heights: Sequence[float],
    **more: Any,
) -> GridSpec:
    """Rows and columns between left, right, top and bottom edges, in shares of the sheet."""
    left, right, top, bottom = edges
    return sheet.add_gridspec(
        *shape, left=left, right=right, top=top, bottom=bottom, height_ratios=heights, **more
    )


def key_to_legs(sheet: Figure, walk: RecordedWalk) -> None:
    """Which colour is which leg."""
    leg_key(sheet, leg_names(walk.machine.legs))


def scale_in(ax: Axes, shown: Box, above: float = 0.05) -> None:
    """A scale bar in the lower left corner of a view."""
    scale_bar(ax, shown[0] + 0.05, shown[2] + above)


def heading(sheet: Figure, y: float, text: str) -> None:
    """A line between two rows of a sheet."""
    sheet.text(0.035, y, text, fontsize=9.5, fontweight="bold", va="bottom")


def whole_walk(walk: RecordedWalk) -> tuple[int, int]:
    """N_k at its start and its end."""
    return 0, len(walk.steps)


def compared(walk: RecordedWalk) -> str:
    """The roughness of the body's height as walked and by the average-height rule, in a line."""
    summary = walk.summary
    if summary["roughness_ratio"] is None:
        return "level ground: nothing to compare"
    walked = f"{summary['roughness'] * 1000:.2f} mm"
    average = f"{summary['roughness_average_rule'] * 1000:.2f} mm"
    ratio = f"{summary['roughness_ratio']:.2f} of it"
    return f"RMS second difference of height {walked}, average-height rule {average}: {ratio}"


# the sheets


@in_our_style
def standard_walk(title: str, walks: Walks) -> Figure:
    """Four steps of a cycle, the course, the gait diagram (H figs. 5, 6a, 6b)."""
    walk = walks["walk"]
    nominal = walk.nominal(1)
    margin = f"standard margin s₀ = {nominal.margin * 1000:.1f} mm"
    note = f"{walk_note(walk)}; stroke λ* = {nominal.stride:.3f} m, {margin}"
    tall = abs(math.sin(travel(walk))) > SLANTED
    sheet = blank_sheet(10.0, 7.6 if tall else 8.3, title, note)
    frames, course, diagram = _standard_places(sheet, tall)
    for k, place in enumerate(frames, 1):
        step_frame(sheet.add_subplot(place), walk, k)
    ax = sheet.add_subplot(course)
    count = len(walk.steps)
    last_cycle = range(count - 3, count + 1)
    shown = walk_view(ax, walk, bodies=whole_walk(walk), triangles=last_cycle)
    scale_in(ax, shown, above=0.02)
    key_to_legs(sheet, walk)
    gait_diagram(sheet.add_subplot(diagram), walk)
    return sheet


def _standard_places(sheet: Figure, tall: bool) -> tuple[list[Any], Any, Any]:
    """Where the four frames, the whole walk and the gait diagram go."""
    edges = (0.06, 0.985, 0.895, 0.07)
    if tall:
        widths = [1.0, 1.0, 1.1]
        ratios = [2.0, 2.0, 1.2]
        rows = grid(sheet, (3, 3), edges, ratios, width_ratios=widths, hspace=0.16, wspace=0.02)
        return [rows[0, 0], rows[0, 1], rows[1, 0], rows[1, 1]], rows[:2, 2], rows[2, :]
    rows = grid(sheet, (3, 4), edges, [1.75, 3.7, 1.2], hspace=0.13, wspace=0.02)
    return [rows[0, k] for k in range(4)], rows[1, :], rows[2, :]


@in_our_style
def odd_posture(title: str, walks: Walks) -> Figure:
    """The naive rule to its end, and the domain methods from the same posture (H fig. 6c)."""
    walk = walks["walk"]
    angle = degrees(walk.commands()[0][1])
    note = f"α = {angle}, β = {walk.gait.duty_factor:g}, level ground"
    sheet = blank_sheet(10.0, 7.2, title, note)
    edges = (0.06, 0.985, 0.84, 0.07)
    rows = grid(sheet, (3, 4), edges, [1.75, 1.75, 1.2], hspace=0.38, wspace=0.02)
    _naive_row(sheet, rows, walks["naive"])
    heading(sheet, 0.557, "landing within the search domain: the standard gait")
    for k in range(1, 5):
        step_frame(sheet.add_subplot(rows[1, k - 1]), walk, k)
    gait_diagram(sheet.add_subplot(rows[2, :]), walk)
    key_to_legs(sheet, walk)
    return sheet


def _naive_row(sheet: Figure, rows: GridSpec, naive: RecordedWalk) -> None:
    """The first steps of the naive rule, and where it was stuck."""
    stopped = len(naive.steps)
    heading(sheet, 0.872, f"each leg swung to its maximum stride: stuck at step {stopped + 1}")
    for k in range(1, min(stopped, 3) + 1):
        step_frame(sheet.add_subplot(rows[0, k - 1]), naive, k)
    leg = int(naive.summary["reason"].removeprefix("leg ")[0]) - 1
    label = f"step {stopped + 1}: leg {leg + 1} cannot swing"
    stuck_frame(sheet.add_subplot(rows[0, 3]), naive, leg, label)


@in_our_style
def search_domains(title: str, walks: Walks) -> Figure:
    """D_u, I_u and J_u of four steps between holes, and the whole course (H fig. 12)."""
    walk = walks["walk"]
    limits = "shaded $D_u$, its limits by methods I and II"
    note = f"{walk_note(walk)}; {limits}; + search start $I_u$; arrow to the foothold $J_u$"
    sheet = blank_sheet(10.0, 13.2, title, note)
    edges = (0.03, 0.985, 0.935, 0.02)
    rows = grid(sheet, (3, 2), edges, [3.8, 3.8, 4.6], hspace=0.07, wspace=0.03)
    first = busiest(walk)
    for place, k in enumerate(range(first, first + 4)):
        ax = sheet.add_subplot(rows[place // 2, place % 2])
        step_frame(ax, walk, k)
        domain_marks(ax, walk, k)
    ax = sheet.add_subplot(rows[2, :])
    scale_in(ax, walk_view(ax, walk, bodies=whole_walk(walk)), above=0.02)
    key_to_legs(sheet, walk)
    return sheet


def busiest(walk: RecordedWalk, count: int = 4) -> int:
    """The step from which on the feet come down farthest from where the search started."""
    moved = [_moved(step) > OFF for step in walk.steps]
    firsts = range(1, len(moved) - count + 2)
    return max(firsts, key=lambda k: sum(moved[k - 1 : k - 1 + count]))


def _moved(step: Mapping[str, Any]) -> float:
    """How far from the start of its search a foot came down, m."""
    start = step["search_start"]
    landing = step["landing"]
    return 0.0 if start is None or landing is None else math.dist(start[:2], landing[:2])


@in_our_style
def river(title: str, walks: Walks) -> Figure:
    """The crossing with numbered steps, eight of its steps, and the gait diagram (H fig. 13)."""
    walk = walks["walk"]
    terrain = walk.summary["scenario"]["terrain"]
    stroke = f"stroke λ* = {walk.nominal(1).stride:.2f} m"
    note = f"{walk_note(walk)}; river {terrain['width']:.2f} m, {stroke}"
    sheet = blank_sheet(10.0, 11.4, title, note)
    edges = (0.06, 0.985, 0.925, 0.05)
    rows = grid(sheet, (4, 4), edges, [4.4, 1.75, 1.75, 1.2], hspace=0.14, wspace=0.02)
    ax = sheet.add_subplot(rows[0, :])
    scale_in(ax, walk_view(ax, walk, bodies=whole_walk(walk), facecolor=WATER))
    bank = float(terrain["at"]) + float(terrain["width"]) / 2
    over = crossing_steps(walk, bank, math.radians(terrain["heading_deg"]))
    for place, k in enumerate(over):
        where = rows[1 + place // 4, place % 4]
        step_frame(sheet.add_subplot(where), walk, k, facecolor=WATER)
    gait_diagram(sheet.add_subplot(rows[3, :]), walk)
    key_to_legs(sheet, walk)
    return sheet


def crossing_steps(walk: RecordedWalk, bank: float, heading: float, count: int = 8) -> list[int]:
    """The steps that bring a foot beyond the far bank, and those with most way among the rest
    around them; at most ``count``.
    """
    ux, uy = direction(heading)

    def beyond(point: Point) -> bool:
        return point[0] * ux + point[1] * uy > bank

    def crosses(k: int) -> bool:
        leg = walk.swing(k)
        if leg < 0 or beyond(walk.stance(k - 1).feet[leg]):
            return False
        return beyond(walk.stance(k).feet[leg])

    over = [k for k in range(1, len(walk.steps) + 1) if crosses(k)]
    if not over:
        return list(range(1, min(count, len(walk.steps)) + 1))
    others = [k for k in range(over[0] - 2, over[-1] + 1) if k >= 1 and k not in over]
    others.sort(key=lambda k: -walk.steps[k - 1]["g"])
    return sorted(over + others[: max(count - len(over), 0)])[:count]


@in_our_style
def detour(title: str, walks: Walks) -> Figure:
    """The commanded line, the way that was walked, the footholds (H fig. 14)."""
    walk = walks["walk"]
    off = walk.summary["off_line"]
    note = f"{walk_note(walk)}; {walk.summary['forbidden_steps']} forbidden steps"
    if off is not None:
        note += f"; {off * 1000:.0f} mm off the line at the end"
    x1, x2, y1, y2 = walk.extent
    tall = min(9.0, 9.6 * (y2 - y1 + 0.5) / (x2 - x1 + 0.5))
    sheet = blank_sheet(10.0, tall + 0.95, title, note)
    ax = sheet.add_axes((0.02, 0.02, 0.96, (tall + 0.1) / (tall + 0.95)))
    few = len(walk.steps) <= NUMBERED_STEPS
    ends = whole_walk(walk)
    shown = walk_view(ax, walk, numbers=few, bodies=ends, milestones=0 if few else 10)
    for row, angle in walk.commands():
        _commanded_line(ax, walk, row, angle)
    scale_in(ax, shown)
    key_to_legs(sheet, walk)
    return sheet


def _commanded_line(ax: Axes, walk: RecordedWalk, row: int, angle: float) -> None:
    """The line commanded from a row on, as far along it as the walk ever came."""
    x, y, yaw = walk.body[row, [0, 1, 5]]
    c, s = direction(yaw + angle)
    far = float(((walk.body[:, 0] - x) * c + (walk.body[:, 1] - y) * s).max())
    look: dict[str, Any] = {"lw": 1.1, "ls": (0, (6, 3)), "zorder": 3.5}
    ax.plot([x, x + far * c], [y, y + far * s], color=WARNING, **look)


@in_our_style
def heights(title: str, walks: Walks) -> Figure:
    """The body's path over steps, and the average-height rule as a broken line (H fig. 15)."""
    walk = walks["walk"]
    sheet = blank_sheet(10.0, 7.6, title, f"{walk_note(walk)}; {compared(walk)}")
    angle = travel(walk)
    rows = grid(sheet, (3, 1), (0.065, 0.985, 0.91, 0.065), [1.9, 2.1, 1.2], hspace=0.3)
    middle = len(walk.steps) // 2
    bodies = (0, middle, len(walk.steps))
    side_view(sheet.add_subplot(rows[0]), walk, angle, bodies=bodies, feet=False)
    close = sheet.add_subplot(rows[1])
    _body_heights(close, walk, angle)
    bends = sheet.add_subplot(rows[2])
    _bends(bends, walk)
    way = along(walk, walk.body[:, :2], angle)
    for ax in (close, bends):
        ax.set_xlim(way[0] - BESIDE, way[-1] + BESIDE)
    return sheet


def _body_heights(ax: Axes, walk: RecordedWalk, angle: float) -> None:
    """The height of the body, close up: as walked, and by the average-height rule."""
    way = along(walk, walk.body[:, :2], angle)
    by_tick = "average of the supporting legs, tick by tick"
    by_step = "average of the supporting legs, linked linearly from N to N"
    ax.plot(way, average_of_carrying(walk), color=AVERAGE, lw=0.8, label=by_tick)
    body_path(ax, walk, angle, label="as walked: H above the ground predicted ahead")
    average_path(ax, walk, angle, color=WARNING, label=by_step)
    ax.set_ylabel("height of the body, m")
    ax.set_ylim(float(walk.body[:, 2].min()) - 0.05, float(walk.body[:, 2].max()) + 0.2)
    ax.legend(loc="upper left", fontsize=7.5)


def _bends(ax: Axes, walk: RecordedWalk) -> None:
    """Second differences of height along the course, of both."""
    walked, average = second_differences(walk)
    ax.bar(walked[0], walked[1] * 1000, width=0.055, color=INK, alpha=0.85)
    ax.bar(average[0], average[1] * 1000, width=0.035, color=WARNING, alpha=0.55)
    ax.axhline(0.0, color=INK, lw=0.5)
    ax.set_ylabel("second difference, mm")
    ax.set_xlabel("way along the course, m")


@in_our_style
def stairs(title: str, walks: Walks) -> Figure:
    """The paths of lamps on toes and body over stairs, and the gait diagram (H figs. 17 and 18)."""
    walk = walks["walk"]
    sheet = blank_sheet(10.0, 5.9, title, f"{walk_note(walk)}; {compared(walk)}")
    angle = travel(walk)
    rows = grid(sheet, (2, 1), (0.075, 0.985, 0.9, 0.085), [2.7, 1.1], hspace=0.2)
    ax = sheet.add_subplot(rows[0])
    count = len(walk.steps)
    bodies = (0, round(count * 0.36), round(count * 0.68), count)
    side_view(ax, walk, angle, bodies=bodies)
    average_path(ax, walk, angle, color=WARNING, lw=0.9)
    gait_diagram(sheet.add_subplot(rows[1]), walk)
    key_to_legs(sheet, walk)
    return sheet


@in_our_style
def block(title: str, walks: Walks) -> Figure:
    """From above with what touch has put on the map, from the side with the searching feet (H fig.
    19).
    """
    walk = walks["walk"]
    kinds = (f"{kind} {number}" for kind, number in walk.summary["emergent"].items())
    emergent = ", ".join(kinds) or "none"
    pace = f"{walk.log['command'][0, 1] * 1000:.0f} mm/s"
    found = "red: what touch has put on the map"
    note = f"{walk_note(walk)}, {pace}; emergent motions: {emergent}; {found}"
    sheet = blank_sheet(10.0, 9.6, title, note)
    rows = grid(sheet, (2, 1), (0.065, 0.985, 0.935, 0.055), [2.0, 1.0], hspace=0.06)
    ax = sheet.add_subplot(rows[0])
    shown = walk_view(ax, walk, bodies=whole_walk(walk), believed=True)
    _relief(ax, walk, shown)
    scale_in(ax, shown)
    _block_from_the_side(sheet.add_subplot(rows[1]), walk)
    key_to_legs(sheet, walk)
    return sheet


def _block_from_the_side(ax: Axes, walk: RecordedWalk) -> None:
    """The block in section, and the feet that pass over it."""
    terrain = walk.summary["scenario"]["terrain"]
    near = terrain["at"] - 0.7
    far = terrain["at"] + terrain["length"] + 0.7
    angle = math.radians(terrain["angle_deg"])
    aside = terrain["aside"]
    half = terrain["width"] / 2
    section(ax, walk, angle, (near, far), beside=aside)
    foot_paths(ax, walk, angle, (aside - half, aside + half))
    ax.set_aspect("equal")
    ax.set_xlim(near, far)
    ax.set_ylim(-0.1, terrain["height"] + 0.32)
    ax.set_xlabel("the toes from the side, square to the block, m")
    ax.set_ylabel("height, m")


def _relief(ax: Axes, walk: RecordedWalk, shown: Box) -> None:
    """Outlines of what stands up from the ground."""
    heights = walk.ground.heights
    cell = walk.ground.cell
    raised = np.nan_to_num(heights) > np.nanmedian(heights) + RAISED
    look: dict[str, Any] = {"facecolor": EARTH, "edgecolor": "none", "zorder": 0.3}
    cells(ax, raised, cell, walk.ground.origin, shown, **look)


@in_our_style
def directions(title: str, walks: Walks) -> Figure:
    """The whole way from above, and how far off its standard layout every step was (H §10.4)."""
    walk = walks["walk"]
    note = f"{walk_note(walk)}; the torso looks to the right all the while"
    sheet = blank_sheet(10.0, 10.2, title, note)
    rows = grid(sheet, (2, 1), (0.07, 0.985, 0.935, 0.06), [2.7, 1.0], hspace=0.08)
    ax = sheet.add_subplot(rows[0])
    shown = walk_view(ax, walk, numbers=False, bodies=(0,))
    for row, angle in walk.commands():
        _commanded_arrow(ax, walk, row, angle)
    scale_in(ax, shown)
    _off_standard(sheet.add_subplot(rows[1]), walk)
    key_to_legs(sheet, walk)
    return sheet


def _commanded_arrow(ax: Axes, walk: RecordedWalk, row: int, angle: float) -> None:
    """The direction commanded from a row on, with its crab angle."""
    x, y, yaw = walk.body[row, [0, 1, 5]]
    c, s = direction(yaw + angle)
    arrow(ax, (x, y), (x + 0.45 * c, y + 0.45 * s), lw=2.2)
    beside = (x + 0.25 * c - 0.3 * s, y + 0.25 * s + 0.3 * c)
    look: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 8.5, "fontweight": "bold"}
    ax.text(*beside, degrees(angle), **look)


def _off_standard(ax: Axes, walk: RecordedWalk) -> None:
    """How far from its standard layout every step came out, in its leg's colour."""
    values = (step["off_standard"] for step in walk.steps)
    off = [np.nan if value is None else value for value in values]
    numbers = range(1, len(off) + 1)
    colours = [leg_colour(walk.swing(k)) for k in numbers]
    ax.bar(numbers, off, width=0.8, color=colours)
    ax.axhline(STANDARD_WITHIN, color=INK, lw=0.7, ls=(0, (4, 3)))
    ax.text(1, 0.06, "below: standard", va="bottom", fontsize=7.5)
    _commands_over(ax, walk, numbers)
    ax.set_xlim(0.4, len(off) + 0.6)
    ax.set_ylim(0, 1.02)
    ax.set_xlabel("step")
    ax.set_ylabel("off the standard layout, λ*")


def _commands_over(ax: Axes, walk: RecordedWalk, numbers: Iterable[int]) -> None:
    """Where each commanded direction begins, over the steps."""
    for row, angle in walk.commands():
        first = next((k for k in numbers if walk.row(k) > row), len(walk.steps))
        ax.axvline(first - 0.5, color=PALE, lw=0.6, zorder=0)
        ax.text(first - 0.2, 1.0, degrees(angle), fontsize=7.5, va="top")
