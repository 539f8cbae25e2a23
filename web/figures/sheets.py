"""One function a page: which views a figure is made of."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import wraps

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walking_console.planner.crab.planner import cruise_speed
from walking_console.planner.geometry.paths import Box
from walking_console.planner.types import TICK
from walking_console.web.figures import LIFT, LINES, PACE
from walking_console.web.figures.run_data import RecordedWalk, degrees
from walking_console.web.figures.side_view import (
    along,
    average_of_carrying,
    average_path,
    body_path,
    foot_paths,
    second_differences,
    section,
    silhouette,
)
from walking_console.web.figures.style import (
    EARTH,
    INK,
    LEGS,
    PALE,
    WARNING,
    WATER,
    arrow,
    cells,
    leg_key,
    pen,
    scale_bar,
    sheet,
)
from walking_console.web.figures.top_view import (
    course_view,
    domain_marks,
    gait_diagram,
    step_frame,
    stuck_frame,
    travel,
)

Page = Callable[[str, Mapping[str, RecordedWalk]], Figure]


def in_our_style(page: Page) -> Page:
    """Draw with our pen whatever matplotlib's own settings say."""

    @wraps(page)
    def drawn(title: str, walks: Mapping[str, RecordedWalk]) -> Figure:
        with pen():
            return page(title, walks)

    return drawn


def told(walk: RecordedWalk) -> str:
    """How the walk was commanded, in a line."""
    angles = {angle for _, angle in walk.commands()}
    alpha = f"α = {degrees(next(iter(angles)))}, " if len(angles) == 1 else ""
    return f"{alpha}β = {walk.gait.duty_factor:g}; {len(walk.steps)} steps, {walk.course[-1]:.2f} m"


@in_our_style
def standard_walk(title: str, walks: Mapping[str, RecordedWalk]) -> Figure:
    """Four steps of a cycle, the course, the gait diagram (H figs. 5, 6a, 6b)."""
    walk = walks["walk"]
    standard = walk.standard(1)
    note = f"{told(walk)}; stroke λ* = {standard.stride:.3f} m, standard margin s₀ = {standard.margin * 1000:.1f} mm"
    tall = abs(math.sin(travel(walk))) > 0.7
    page = sheet(10.0, 7.6 if tall else 8.3, title, note)
    where = {"left": 0.06, "right": 0.985, "top": 0.895, "bottom": 0.07, "wspace": 0.02}
    if tall:
        rows = page.add_gridspec(
            3, 3, height_ratios=[2.0, 2.0, 1.2], width_ratios=[1.0, 1.0, 1.1], hspace=0.16, **where
        )
        frames, course = [rows[0, 0], rows[0, 1], rows[1, 0], rows[1, 1]], rows[:2, 2]
    else:
        rows = page.add_gridspec(3, 4, height_ratios=[1.75, 3.7, 1.2], hspace=0.13, **where)
        frames, course = [rows[0, k] for k in range(4)], rows[1, :]
    for k, place in enumerate(frames, 1):
        step_frame(page.add_subplot(place), walk, k)
    ax = page.add_subplot(course)
    shown = course_view(
        ax,
        walk,
        bodies=(0, len(walk.steps)),
        triangles=range(len(walk.steps) - 3, len(walk.steps) + 1),
    )
    scale_bar(ax, shown[0] + 0.05, shown[2] + 0.02)
    leg_key(page)
    gait_diagram(page.add_subplot(rows[2, :]), walk, swing_order(walk))
    return page


def swing_order(walk: RecordedWalk) -> list[int]:
    """Legs in the order of their first swings."""
    order: list[int] = []
    for step in walk.steps:
        for number in step["swing"]:
            if number - 1 not in order:
                order.append(number - 1)
    return order + [leg for leg in range(len(walk.machine.legs)) if leg not in order]


@in_our_style
def odd_posture(title: str, walks: Mapping[str, RecordedWalk]) -> Figure:
    """The naive rule to its end, and the domain methods from the same posture (H fig. 6c)."""
    walk, naive = walks["walk"], walks["naive"]
    page = sheet(
        10.0,
        7.2,
        title,
        f"α = {degrees(walk.commands()[0][1])}, β = {walk.gait.duty_factor:g}, level ground",
    )
    rows = page.add_gridspec(
        3,
        4,
        left=0.06,
        right=0.985,
        top=0.84,
        bottom=0.07,
        height_ratios=[1.75, 1.75, 1.2],
        hspace=0.38,
        wspace=0.02,
    )
    stopped = len(naive.steps)
    heading(page, 0.872, f"each leg swung to its maximum stride: stuck at step {stopped + 1}")
    for k in range(1, min(stopped, 3) + 1):
        step_frame(page.add_subplot(rows[0, k - 1]), naive, k)
    leg = int(naive.summary["reason"].removeprefix("leg ")[0]) - 1
    label = f"step {stopped + 1}: leg {leg + 1} cannot swing"
    stuck_frame(page.add_subplot(rows[0, 3]), naive, leg, label)
    heading(page, 0.557, "landing within the search domain: the standard gait")
    for k in range(1, 5):
        step_frame(page.add_subplot(rows[1, k - 1]), walk, k)
    gait_diagram(page.add_subplot(rows[2, :]), walk, swing_order(walk))
    leg_key(page)
    return page


def heading(page: Figure, y: float, text: str) -> None:
    """A line between two rows of a page."""
    page.text(0.035, y, text, fontsize=9.5, fontweight="bold", va="bottom")


@in_our_style
def search_domains(title: str, walks: Mapping[str, RecordedWalk]) -> Figure:
    """D_u, I_u and J_u of four steps between holes, and the whole course (H fig. 12)."""
    walk = walks["walk"]
    note = f"{told(walk)}; shaded $D_u$, its limits by methods I and II; + search start $I_u$; arrow to the foothold $J_u$"
    page = sheet(10.0, 13.2, title, note)
    rows = page.add_gridspec(
        3,
        2,
        left=0.03,
        right=0.985,
        top=0.935,
        bottom=0.02,
        height_ratios=[3.8, 3.8, 4.6],
        hspace=0.07,
        wspace=0.03,
    )
    first = busiest(walk)
    for place, k in enumerate(range(first, first + 4)):
        ax = page.add_subplot(rows[place // 2, place % 2])
        step_frame(ax, walk, k)
        domain_marks(ax, walk, k)
    ax = page.add_subplot(rows[2, :])
    shown = course_view(ax, walk, bodies=(0, len(walk.steps)))
    scale_bar(ax, shown[0] + 0.05, shown[2] + 0.02)
    leg_key(page)
    return page


def busiest(walk: RecordedWalk, count: int = 4) -> int:
    """The step from which on the feet come down farthest from where the search started."""

    def off(step: dict[str, object]) -> float:
        start, landing = step["search_start"], step["landing"]
        return (
            math.dist(start[:2], landing[:2])
            if isinstance(start, list) and isinstance(landing, list)
            else 0.0
        )

    offs = [off(step) for step in walk.steps]
    return max(
        range(1, len(offs) - count + 2),
        key=lambda k: sum(o > 0.02 for o in offs[k - 1 : k - 1 + count]),
    )


@in_our_style
def river(title: str, walks: Mapping[str, RecordedWalk]) -> Figure:
    """The crossing with numbered steps, eight of its steps, and the gait diagram (H fig. 13)."""
    walk = walks["walk"]
    terrain = walk.summary["scenario"]["terrain"]
    note = (
        f"{told(walk)}; river {terrain['width']:.2f} m, stroke λ* = {walk.standard(1).stride:.2f} m"
    )
    page = sheet(10.0, 11.4, title, note)
    ratios = [4.4, 1.75, 1.75, 1.2]
    rows = page.add_gridspec(
        4,
        4,
        left=0.06,
        right=0.985,
        top=0.925,
        bottom=0.05,
        height_ratios=ratios,
        hspace=0.14,
        wspace=0.02,
    )
    ax = page.add_subplot(rows[0, :])
    shown = course_view(ax, walk, bodies=(0, len(walk.steps)), facecolor=WATER)
    scale_bar(ax, shown[0] + 0.05, shown[2] + 0.05)
    over = crossing_steps(
        walk, float(terrain["at"]), float(terrain["width"]), math.radians(terrain["heading_deg"])
    )
    for place, k in enumerate(over[:8]):
        step_frame(page.add_subplot(rows[1 + place // 4, place % 4]), walk, k, facecolor=WATER)
    ax = page.add_subplot(rows[3, :])
    gait_diagram(ax, walk, swing_order(walk))
    leg_key(page)
    return page


def crossing_steps(
    walk: RecordedWalk, at: float, width: float, heading: float, count: int = 8
) -> list[int]:
    """The steps that bring a foot over the river, and those with most way among the rest around
    them.
    """

    def beyond(point: tuple[float, float, float]) -> bool:
        return point[0] * math.cos(heading) + point[1] * math.sin(heading) > at + width / 2

    over = []
    for k in range(1, len(walk.steps) + 1):
        leg = walk.swing(k)
        if (
            leg >= 0
            and beyond(walk.stance(k).feet[leg])
            and not beyond(walk.stance(k - 1).feet[leg])
        ):
            over.append(k)
    if not over:
        return list(range(1, min(count, len(walk.steps)) + 1))
    others = [k for k in range(over[0] - 2, over[-1] + 1) if 1 <= k and k not in over]
    others.sort(key=lambda k: -walk.steps[k - 1]["g"])
    return sorted(over + others[: count - len(over)])


@in_our_style
def detour(title: str, walks: Mapping[str, RecordedWalk]) -> Figure:
    """The commanded line, the way that was walked, the footholds (H fig. 14)."""
    walk = walks["walk"]
    off = walk.summary["off_line"]
    note = f"{told(walk)}; {walk.summary['forbidden_steps']} forbidden steps"
    if off is not None:
        note += f"; {off * 1000:.0f} mm off the line at the end"
    x1, x2, y1, y2 = walk.extent
    tall = min(9.0, 9.6 * (y2 - y1 + 0.5) / (x2 - x1 + 0.5))
    page = sheet(10.0, tall + 0.95, title, note)
    ax = page.add_axes((0.02, 0.02, 0.96, (tall + 0.1) / (tall + 0.95)))
    few = len(walk.steps) <= 60
    shown = course_view(
        ax, walk, numbers=few, bodies=(0, len(walk.steps)), milestones=0 if few else 10
    )
    for row, angle in walk.commands():
        x, y, yaw = walk.body[row, [0, 1, 5]]
        c, s = math.cos(yaw + angle), math.sin(yaw + angle)
        far = float(((walk.body[:, 0] - x) * c + (walk.body[:, 1] - y) * s).max())
        ax.plot(
            [x, x + far * c], [y, y + far * s], color=WARNING, lw=1.1, ls=(0, (6, 3)), zorder=3.5
        )
    scale_bar(ax, shown[0] + 0.05, shown[2] + 0.05)
    leg_key(page)
    return page


@in_our_style
def heights(title: str, walks: Mapping[str, RecordedWalk]) -> Figure:
    """The body's path over steps, and the average-height rule as a broken line (H fig. 15)."""
    walk = walks["walk"]
    page = sheet(10.0, 7.6, title, f"{told(walk)}; {compared(walk)}")
    direction = travel(walk)
    rows = page.add_gridspec(
        3,
        1,
        left=0.065,
        right=0.985,
        top=0.91,
        bottom=0.065,
        height_ratios=[1.9, 2.1, 1.2],
        hspace=0.3,
    )
    side_view(
        page.add_subplot(rows[0]),
        walk,
        direction,
        bodies=(0, len(walk.steps) // 2, len(walk.steps)),
        feet=False,
    )
    close, bends = page.add_subplot(rows[1]), page.add_subplot(rows[2])
    way = along(walk, walk.body[:, :2], direction)
    close.plot(
        way,
        average_of_carrying(walk),
        color="#b9c0c5",
        lw=0.8,
        label="average of the supporting legs, tick by tick",
    )
    body_path(close, walk, direction, label="as walked: H above the ground predicted ahead")
    average_path(
        close,
        walk,
        direction,
        color=WARNING,
        label="average of the supporting legs, linked linearly from N to N",
    )
    low, high = float(walk.body[:, 2].min()), float(walk.body[:, 2].max())
    close.set_ylabel("height of the body, m")
    close.set_ylim(low - 0.05, high + 0.2)
    close.legend(loc="upper left", fontsize=7.5)
    for (places, bend), colour, width in zip(
        second_differences(walk), (INK, WARNING), (0.055, 0.035), strict=True
    ):
        bends.bar(
            places, bend * 1000, width=width, color=colour, alpha=0.85 if colour == INK else 0.55
        )
    bends.axhline(0.0, color=INK, lw=0.5)
    bends.set_ylabel("second difference, mm")
    bends.set_xlabel("way along the course, m")
    for ax in (close, bends):
        ax.set_xlim(way[0] - 0.9, way[-1] + 0.9)
    return page


def compared(walk: RecordedWalk) -> str:
    """The two roughnesses in a line."""
    ours, theirs, ratio = (
        walk.summary[key] for key in ("roughness", "roughness_average_rule", "roughness_ratio")
    )
    if ratio is None:
        return "level ground: nothing to compare"
    return f"RMS second difference of height {ours * 1000:.2f} mm, average-height rule {theirs * 1000:.2f} mm: {ratio:.2f} of it"


def side_view(
    ax: Axes, walk: RecordedWalk, direction: float, *, bodies: Sequence[int], feet: bool = True
) -> None:
    """Ground, machine, paths; one metre up is one metre along."""
    way = along(walk, walk.body[:, :2], direction)
    low, high = float(way.min()) - 0.9, float(way.max()) + 0.9
    section(ax, walk, direction, low, high)
    for k in bodies:
        silhouette(ax, walk, k, direction)
    if feet:
        foot_paths(ax, walk, direction)
    body_path(ax, walk, direction)
    ax.set_aspect("equal")
    ax.set_xlim(low, high)
    ax.set_ylabel("height, m")
    ax.set_xlabel("way along the course, m")


@in_our_style
def stairs(title: str, walks: Mapping[str, RecordedWalk]) -> Figure:
    """The paths of lamps on toes and body over stairs, and the gait diagram (H figs. 17 and 18)."""
    walk = walks["walk"]
    page = sheet(10.0, 5.9, title, f"{told(walk)}; {compared(walk)}")
    direction = travel(walk)
    rows = page.add_gridspec(
        2, 1, left=0.075, right=0.985, top=0.9, bottom=0.085, height_ratios=[2.7, 1.1], hspace=0.2
    )
    ax = page.add_subplot(rows[0])
    count = len(walk.steps)
    side_view(ax, walk, direction, bodies=(0, round(count * 0.36), round(count * 0.68), count))
    average_path(ax, walk, direction, color=WARNING, lw=0.9)
    gait_diagram(page.add_subplot(rows[1]), walk, swing_order(walk))
    leg_key(page)
    return page


@in_our_style
def block(title: str, walks: Mapping[str, RecordedWalk]) -> Figure:
    """From above with what touch has put on the map, from the side with the searching feet (H fig.
    19).
    """
    walk = walks["walk"]
    emergent = (
        ", ".join(f"{kind} {number}" for kind, number in walk.summary["emergent"].items()) or "none"
    )
    note = f"{told(walk)}, {walk.log['command'][0, 1] * 1000:.0f} mm/s; emergent motions: {emergent}; red: what touch has put on the map"
    page = sheet(10.0, 9.6, title, note)
    rows = page.add_gridspec(
        2,
        1,
        left=0.065,
        right=0.985,
        top=0.935,
        bottom=0.055,
        height_ratios=[2.0, 1.0],
        hspace=0.06,
    )
    ax = page.add_subplot(rows[0])
    shown = course_view(ax, walk, bodies=(0, len(walk.steps)), believed=True)
    relief(ax, walk, shown)
    scale_bar(ax, shown[0] + 0.05, shown[2] + 0.05)
    terrain = walk.summary["scenario"]["terrain"]
    near, far = terrain["at"] - 0.7, terrain["at"] + terrain["length"] + 0.7
    side = page.add_subplot(rows[1])
    square = math.radians(terrain["angle_deg"])
    section(side, walk, square, near, far, beside=terrain["aside"])
    foot_paths(
        side,
        walk,
        square,
        (terrain["aside"] - terrain["width"] / 2, terrain["aside"] + terrain["width"] / 2),
    )
    side.set_aspect("equal")
    side.set_xlim(near, far)
    side.set_ylim(-0.1, terrain["height"] + 0.32)
    side.set_xlabel("the toes from the side, square to the block, m")
    side.set_ylabel("height, m")
    leg_key(page)
    return page


def relief(ax: Axes, walk: RecordedWalk, shown: Box) -> None:
    """Outlines of what stands up from the ground."""
    heights = walk.ground["heights"]
    cell, origin = float(walk.ground["cell"]), walk.ground["origin"]
    step = np.nan_to_num(heights) > np.nanmedian(heights) + 0.02
    cells(ax, step, cell, origin, shown, facecolor=EARTH, edgecolor="none", zorder=0.3)


@in_our_style
def directions(title: str, walks: Mapping[str, RecordedWalk]) -> Figure:
    """The whole way from above, and how far from its standard layout every step came out (H §10.4)."""
    walk = walks["walk"]
    page = sheet(10.0, 10.2, title, f"{told(walk)}; the torso looks to the right all the while")
    rows = page.add_gridspec(
        2, 1, left=0.07, right=0.985, top=0.935, bottom=0.06, height_ratios=[2.7, 1.0], hspace=0.08
    )
    ax = page.add_subplot(rows[0])
    shown = course_view(ax, walk, numbers=False, bodies=(0,))
    for row, angle in walk.commands():
        x, y, yaw = walk.body[row, [0, 1, 5]]
        c, s = math.cos(yaw + angle), math.sin(yaw + angle)
        arrow(ax, (x, y), (x + 0.45 * c, y + 0.45 * s), lw=2.2)
        ax.text(
            x + 0.25 * c - 0.3 * s,
            y + 0.25 * s + 0.3 * c,
            degrees(angle),
            ha="center",
            va="center",
            fontsize=8.5,
            fontweight="bold",
        )
    scale_bar(ax, shown[0] + 0.05, shown[2] + 0.05)
    strip = page.add_subplot(rows[1])
    off = [
        step["off_standard"] if step["off_standard"] is not None else np.nan for step in walk.steps
    ]
    numbers = np.arange(1, len(off) + 1)
    colours = [LEGS[walk.swing(int(k))] if walk.swing(int(k)) >= 0 else INK for k in numbers]
    strip.bar(numbers, off, width=0.8, color=colours)
    strip.axhline(0.05, color=INK, lw=0.7, ls=(0, (4, 3)))
    strip.text(1, 0.06, "below: standard", va="bottom", fontsize=7.5)
    for row, angle in walk.commands():
        first = next((k for k in numbers if walk.row(int(k)) > row), len(off))
        strip.axvline(first - 0.5, color=PALE, lw=0.6, zorder=0)
        strip.text(first - 0.2, 1.0, degrees(angle), fontsize=7.5, va="top")
    strip.set_xlim(0.4, len(off) + 0.6)
    strip.set_ylim(0, 1.02)
    strip.set_xlabel("step")
    strip.set_ylabel("off the standard layout, λ*")
    leg_key(page)
    return page


@in_our_style
def speeds(title: str, walks: Mapping[str, RecordedWalk]) -> Figure:
    """v_G against h_up for some v_up, and against v_up for some h_up: lines by the formula, marks
    as walked (H fig. 16).
    """
    walk = walks["walk"]
    note = f"α = 0°, β = {walk.gait.duty_factor:g}, V$_x$ = {walk.machine.speed[0]:g} m/s, constant velocity between knots"
    note += "\nlines: by the formula; rings: walked; dotted: faster, a foot coming straight down would leave its mechanical reach"
    page = sheet(10.0, 4.8, title, note)
    rows = page.add_gridspec(1, 2, left=0.065, right=0.985, top=0.81, bottom=0.12, wspace=0.2)
    swept = [w for key, w in walks.items() if key != "walk"]
    left, right = page.add_subplot(rows[0]), page.add_subplot(rows[1])
    shades = (LEGS[0], LEGS[1], LEGS[2])
    for ax, axis, name, unit in ((left, LIFT, "v_{up}", "m/s"), (right, PACE, "h_{up}", "m")):
        other = PACE if axis == LIFT else LIFT
        for value, colour in zip(LINES[other], shades, strict=True):
            marks = sorted(
                (setting(w, axis), walked_speed(w))
                for w in swept
                if abs(setting(w, other) - value) < 1e-9
            )
            high = max(x for x, _ in marks)
            xs = np.linspace(0.005 if axis == LIFT else 0.05, high, 120)
            fast = np.array([formula(walk, **{axis: float(x), other: value}) for x in xs])
            straight = np.array([within_reach(walk, **{axis: float(x), other: value}) for x in xs])
            ax.plot(xs, fast, color=colour, lw=1.3, label=f"${name}$ = {value:g} {unit}")
            ax.plot(xs, np.where(straight < fast, straight, np.nan), color=colour, lw=1.1, ls=":")
            ax.plot(*zip(*marks, strict=True), "o", ms=5, mfc="white", mec=colour, mew=1.2)
        ax.set_ylim(0, None)
        ax.set_ylabel("$v_G$, m/s")
        ax.legend(loc="upper right" if axis == LIFT else "upper left", fontsize=8)
    left.set_xlabel("$h_{up}$, m")
    right.set_xlabel("$v_{up}$, m/s")
    return page


def setting(walk: RecordedWalk, axis: str) -> float:
    """The h_up or v_up of a walk."""
    return walk.gait.lift_up if axis == LIFT else walk.machine.speed[2]


def formula(walk: RecordedWalk, lift: float, pace: float) -> float:
    """v_max of the standard step by H §7 (28)."""
    speed = walk.machine.speed
    machine = replace(walk.machine, speed=(speed[0], speed[1], pace))
    return cruise_speed(machine, replace(walk.gait, lift_up=lift, lift_down=2 * lift), 0.0)


def within_reach(walk: RecordedWalk, lift: float, pace: float) -> float:
    """The speed at which the body goes δx while the foot comes straight down 2·h_up: faster, and
    the foot is out of reach.
    """
    return walk.machine.overreach[0] * pace / (2 * lift)


def walked_speed(walk: RecordedWalk) -> float:
    """Mean speed over whole cycles of four steps, the first one left out."""
    last = 4 + 4 * ((len(walk.steps) - 4) // 4)
    first, end = walk.row(4), walk.row(last)
    return float((walk.course[end] - walk.course[first]) / ((end - first) * TICK))
