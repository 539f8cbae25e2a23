"""``walking-console sweep plot``: the share of runs that passed, over the settings of a sweep."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from walking_console.sim.runs.sweep.folder import axes_of, read_asked
from walking_console.sim.runs.sweep.grid import Axis
from walking_console.sim.runs.sweep.table import axis_column, axis_type, read_table

from .run_data import FigureError, drawing_tools

Z = 1.96  # 95 %


@dataclass(frozen=True)
class PassRate:
    """How many runs there were, and how many of them passed."""

    runs: int
    passed: int

    @property
    def share(self) -> float:
        """0 to 1; not a number where nothing ran."""
        return self.passed / self.runs if self.runs else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the share: honest also near 0 and 1 and for few runs."""
        if not self.runs:
            return math.nan, math.nan
        spread = Z * Z / self.runs
        middle = (self.share + spread / 2) / (1 + spread)
        root = math.sqrt(self.share * (1 - self.share) / self.runs + spread / (4 * self.runs))
        half = Z * root / (1 + spread)
        return max(0.0, middle - half), min(1.0, middle + half)


@dataclass(frozen=True)
class PassRates:
    """Rates over one setting, or over two: ``rates[j][i]`` is of value j of ``by`` and value i of
    ``x``; runs of other settings and of all seeds are counted together.
    """

    title: str
    x: Axis
    by: Axis | None
    rates: tuple[tuple[PassRate, ...], ...]

    @property
    def runs(self) -> int:
        """All runs that are over."""
        return sum(rate.runs for row in self.rates for rate in row)


def draw_sweep(folder: Path, out: Path, x: str | None = None, by: str | None = None) -> str:
    """Draw the pass rates of the sweep in ``folder`` to ``out`` and answer with one line.

    Raises ``FigureError`` and ``RunError``.
    """
    rates = pass_rates(folder, x, by)
    with drawing_tools():
        from .style import save
        from .sweep_sheet import sweep_sheet
    save(sweep_sheet(rates), out)
    over = rates.x.key if rates.by is None else f"{rates.x.key} and {rates.by.key}"
    return f"pass rate over {over}, {rates.runs} runs: {out}"


def pass_rates(folder: Path, x: str | None = None, by: str | None = None) -> PassRates:
    """Count the table of a sweep. ``x`` and ``by`` name settings; by default they are the first
    two that vary. Raises ``FigureError`` and ``RunError``.
    """
    told = read_asked(folder)
    axes = axes_of(told)
    first, second = _chosen(axes, x, by)
    counted: dict[tuple[str, str], list[bool]] = {}
    try:
        for row in read_table(folder):
            place = (row[axis_column(second.key)] if second else "", row[axis_column(first.key)])
            counted.setdefault(place, []).append(row["passed"] == "1")
    except (OSError, KeyError) as error:
        raise FigureError(f"cannot read the table of {folder}: {error}") from None
    rates = tuple(
        tuple(_rate(counted.get((value, at), ())) for at in first.values)
        for value in (second.values if second else ("",))
    )
    return PassRates(f"{told.get('scenario', '')}: runs that passed", first, second, rates)


def _rate(passed: Sequence[bool]) -> PassRate:
    return PassRate(len(passed), sum(passed))


def _chosen(axes: Sequence[Axis], x: str | None, by: str | None) -> tuple[Axis, Axis | None]:
    varied = [axis for axis in axes if len(axis.values) > 1]
    if not varied:
        raise FigureError("nothing varies in this sweep but the seed; there is no curve to draw")
    first = _named(varied, x) if x is not None else varied[0]
    if by is not None:
        second = _named(varied, by)
        if second == first:
            raise FigureError(f"--x and --by are both {by!r}; they should differ")
        return first, second
    return first, next((axis for axis in varied if axis != first), None)


def _named(varied: Iterable[Axis], key: str) -> Axis:
    known = {axis.key: axis for axis in varied}
    if key not in known:
        raise FigureError(f"{key!r} does not vary in this sweep; there are: {', '.join(known)}")
    return known[key]


def places(axis: Axis) -> list[float]:
    """Where the values of a setting stand on its axis: numbers where they are, others in a row."""
    if axis_type(axis) is str:
        return [float(place) for place in range(len(axis.values))]
    return [float(value) for value in axis.values]
