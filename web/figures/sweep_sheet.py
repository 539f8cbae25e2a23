"""The sheet of a sweep: curves of the pass rate with their intervals, and a heat map of two
settings.
"""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walking_console.sim.runs.sweep.grid import Axis
from walking_console.sim.runs.sweep.table import axis_type

from .style import PALE, blank_sheet, our_style
from .sweep_drawing import PassRate, PassRates, places

HEIGHT = 4.2  # inches
CURVES_WIDTH = 6.0
MAP_WIDTH = 4.8
COLOURS = "viridis"  # told apart by whoever does not see red and green


def sweep_sheet(rates: PassRates) -> Figure:
    """Curves alone where one setting varies, a heat map beside them where there are two."""
    with our_style():
        width = CURVES_WIDTH + (MAP_WIDTH if rates.by else 0.0)
        note = f"{rates.runs} runs; bars: 95 % interval (Wilson)"
        sheet = blank_sheet(width, HEIGHT, rates.title, note)
        right = (CURVES_WIDTH - 0.3) / width
        ax = sheet.add_axes((0.7 / width, 0.14, right - 0.7 / width, 0.66))
        _draw_curves(ax, rates)
        if rates.by is not None:
            left = (CURVES_WIDTH + 0.9) / width
            beside = sheet.add_axes((left, 0.14, 1 - left - 0.3 / width, 0.66))
            _draw_map(beside, rates, rates.by)
        return sheet


def _draw_curves(ax: Axes, rates: PassRates) -> None:
    order = np.argsort(places(rates.x), kind="stable")
    at = np.array(places(rates.x))[order]
    names = rates.by.values if rates.by else ("",)
    shades = colormaps[COLOURS](np.linspace(0.0, 0.85, len(names)))
    for name, row, shade in zip(names, rates.rates, shades, strict=True):
        curve = [row[place] for place in order]
        share = np.array([rate.share for rate in curve])
        label = f"{rates.by.key} = {name}" if rates.by else None
        ax.errorbar(
            at, share, yerr=_bars(curve), marker="o", ms=3.5, lw=1.3, capsize=2.5, color=shade,
            label=label,
        )  # fmt: skip
    ax.set_ylim(-0.03, 1.03)
    ax.set_ylabel("share of runs that passed")
    ax.set_xlabel(rates.x.key)
    ax.grid(axis="y", color=PALE, lw=0.3)
    if axis_type(rates.x) is str:
        ax.set_xticks(places(rates.x), rates.x.values)
    if rates.by is not None:
        ax.legend(fontsize=7.5)


def _bars(curve: list[PassRate]) -> np.ndarray:
    """Below and above each share, (2, n); rounding may not make them negative."""
    low, high = np.array([rate.interval for rate in curve]).T
    share = np.array([rate.share for rate in curve])
    bars: np.ndarray = np.maximum(0.0, np.array([share - low, high - share]))
    return bars


def _draw_map(ax: Axes, rates: PassRates, by: Axis) -> None:
    share = np.array([[rate.share for rate in row] for row in rates.rates])
    ax.imshow(share, vmin=0.0, vmax=1.0, cmap=COLOURS, origin="lower", aspect="auto")
    ax.set_xticks(range(len(rates.x.values)), rates.x.values)
    ax.set_yticks(range(len(by.values)), by.values)
    ax.set_xlabel(rates.x.key)
    ax.set_ylabel(by.key)
    for row, line in enumerate(rates.rates):
        for column, rate in enumerate(line):
            if rate.runs:
                _write_share(ax, column, row, rate.share)


def _write_share(ax: Axes, column: int, row: int, share: float) -> None:
    shade = "black" if share > 0.6 else "white"
    ax.text(column, row, f"{share:.0%}", ha="center", va="center", fontsize=7, color=shade)
