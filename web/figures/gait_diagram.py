"""Who stands when, over the way of the CoG."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..scene.palette import LEGS
from .run_data import RecordedWalk
from .style import FAINT, INK, runs

NUMBERED = 0.03  # m; gaps narrower than this have no room for the number of their step


def gait_diagram(ax: Axes, walk: RecordedWalk) -> None:
    """Bars are standing feet, numbers the steps in the gaps; legs in the order of their first
    swings.
    """
    order = swing_order(walk)
    _bars(ax, walk, order)
    _step_numbers(ax, walk, order)
    way = walk.way
    for k in range(len(walk.steps) + 1):
        ax.axvline(way[walk.row(k)], color=FAINT, lw=0.6, zorder=0)
    ax.set_yticks([-i for i in range(len(order))], [f"leg {leg + 1}" for leg in order])
    ax.set_xlim(0, way[-1])
    ax.set_ylim(-len(order) + 0.5, 0.5)
    ax.set_xlabel("way of the centre of gravity, m")
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)


def swing_order(walk: RecordedWalk) -> list[int]:
    """Legs in the order of their first swings."""
    order: list[int] = []
    for step in walk.steps:
        for number in step["swing"]:
            if number - 1 not in order:
                order.append(number - 1)
    return order + [leg for leg in range(len(walk.machine.legs)) if leg not in order]


def _bars(ax: Axes, walk: RecordedWalk, order: Sequence[int]) -> None:
    way = walk.way
    for place, leg in enumerate(order):
        for first, last in runs(np.asarray(walk.log["support"][:, leg], dtype=bool)):
            start = way[first]
            end = way[min(last, len(way) - 1)]
            look: dict[str, Any] = {"height": 0.42, "color": LEGS[leg], "linewidth": 0}
            ax.barh(-place, end - start, left=start, **look)


def _step_numbers(ax: Axes, walk: RecordedWalk, order: Sequence[int]) -> None:
    way = walk.way
    for k, step in enumerate(walk.steps, 1):
        start = way[walk.row(k - 1)] + step["g0"]
        end = way[walk.row(k)]
        if end - start <= NUMBERED:
            continue
        for number in step["swing"]:
            place = ((start + end) / 2, -order.index(number - 1))
            ax.text(*place, str(k), ha="center", va="center", fontsize=6.5, color=INK)
