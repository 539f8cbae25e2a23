"""Tables of numbers: a matrix of heights, with or without numbered edges, or a list of points.

Parted by commas, semicolons, tabs or blanks, quoted or not, with a decimal point or comma, with or
without a heading. The first row of a matrix is north, unless the numbers at its edge say otherwise.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Sequence

import numpy as np

from walking_console.planner.types import Array

from ..generators import GroundError
from .raster import Raster, check_size

EVEN = 1e-3  # of the spacing: how far a point of a regular list may be beside its place
FILLED = 0.25  # of the places of a grid, at least, that a list of points must fill
NARROW = 50  # rows from which a table of three columns is a list of points, not ground
NUMBERED = 4  # numbers, at least, that make an edge of 0, 1, 2 ... a heading
NO_HEIGHT = ("", "nan", "na", "n/a", "null", "none", "*")
X_NAMES = ("x", "easting", "east", "e", "lon", "long", "longitude")
Y_NAMES = ("y", "northing", "north", "n", "lat", "latitude")
Z_NAMES = ("z", "height", "elevation", "elev", "h", "dem", "dtm", "alt", "altitude", "value")

Split = Callable[[str], list[str]]


def read_table(lines: Sequence[str], points: bool = False) -> Raster:
    """What a text of numbers is: ``points`` says that a file of this name holds points."""
    names, table = _table(lines)
    columns = _columns(names)
    if columns is not None and table.shape[1] > max(columns):
        return _points(table[:, columns], _is_globe(names[columns[0]]))
    if table.shape[1] >= 3 and (points or _are_places(table)):
        return _points(table[:, :3], False)
    numbered = len(names) == table.shape[1] and _edge(names[1:]) is not None
    return _with_edges(names, table) if numbered else _without_numbers(table)


# -- words and numbers


def _table(lines: Sequence[str]) -> tuple[list[str], Array]:
    """The words of a heading, if there is one, and the numbers of all other lines."""
    split, point = _dialect(lines)
    rows = [[word.strip() for word in split(line)] for line in lines]
    if len(rows) > 1 and all(row[-1] == "" and len(row) == len(rows[1]) for row in rows[1:]):
        rows = [row[: len(rows[1]) - 1] for row in rows]  # every line ends in a separator
    names = [word.lower() for word in rows[0]] if _is_heading(rows[0], point) else []
    first = 1 if names else 0
    if len(rows) == first:
        raise GroundError("there are no numbers in it")
    width = len(rows[first])
    for number, row in enumerate(rows[first:], first + 1):
        if len(row) != width:
            raise GroundError(f"row {number} has {len(row)} numbers where the first has {width}")
    check_size(len(rows) - first, width)
    return names, np.array([_values(row, point, k) for k, row in enumerate(rows[first:], first)])


def _is_heading(words: Sequence[str], point: str) -> bool:
    """True of a line without a number, or with none in its corner and an even edge beside it."""
    numbers = [_is_number(word, point) for word in words]
    return not any(numbers) or not (numbers[0] or _edge(words[1:]) is None)


def _is_number(word: str, point: str) -> bool:
    try:
        float(word.replace(point, "."))
    except ValueError:
        return False
    return word.lower() not in NO_HEIGHT


def _values(words: Sequence[str], point: str, row: int) -> list[float]:
    """The numbers of a line; a place left empty is NaN."""
    try:
        return [float(word.replace(point, ".")) for word in words]
    except ValueError:
        pass
    values = []
    for word in words:
        if word.lower() in NO_HEIGHT:
            values.append(float("nan"))
        elif _is_number(word, point):
            values.append(float(word.replace(point, ".")))
        else:
            raise GroundError(f"line {row + 1} holds what is no number: {word[:40]!r}")
    return values


def _dialect(lines: Sequence[str]) -> tuple[Split, str]:
    """How the words of a line are parted, and what the decimal point is: one line of whole numbers
    says nothing of it, so that all are looked at.
    """
    body = lines[1:] or lines
    sample = body[0]
    whole = any("," in line for line in lines) and not any("." in line for line in body)
    comma = "," if whole else "."
    if ";" in sample:
        return _parted_by(";", sample), comma
    if "\t" in sample:
        return _parted_by("\t", sample), comma
    if '"' in sample and "," in sample:
        return _parted_by(",", sample), "," if re.search(r'"[^"]*\d,\d[^"]*"', sample) else "."
    blanks = re.search(r"\d\s+[-+\d]", sample)
    if "," in sample and (comma == "." or blanks is None):
        return _parted_by(",", sample), "."
    return str.split, comma


def _parted_by(separator: str, sample: str) -> Split:
    if '"' not in sample:
        return lambda line: line.split(separator)
    return lambda line: next(csv.reader([line], delimiter=separator, skipinitialspace=True))


# -- matrices


def _edge(words: Sequence[str]) -> Array | None:
    """The numbers of an edge that go up or down evenly; None of any others."""
    try:
        values = np.array([float(word.replace(",", ".")) for word in words])
    except ValueError:
        return None
    steps = np.diff(values)
    if len(steps) < 1 or steps[0] == 0.0 or np.ptp(steps) > 1e-3 * abs(steps[0]):
        return None
    return values


def _with_edges(names: Sequence[str], table: Array) -> Raster:
    """A matrix whose first row and column say where its rows and columns are, or number them."""
    x = _edge(names[1:])
    y = _edge([repr(float(value)) for value in table[:, 0]])
    if x is None or y is None:
        return Raster(table[::-1], "matrix")
    heights = table[:, 1:]
    dx, dy = float(x[1] - x[0]), float(y[1] - y[0])
    if _counts_up(x) and _counts_up(y):
        return Raster(heights[::-1], "matrix with numbered rows and columns")
    heights = heights[:, :: -1 if dx < 0.0 else 1][:: 1 if dy > 0.0 else -1]
    return Raster(heights, "matrix with x and y at its edges", (abs(dx), abs(dy)))


def _without_numbers(table: Array) -> Raster:
    """A matrix; a first row of 0, 1, 2 ... is the heading that pandas writes."""
    if table.shape[1] >= NUMBERED and len(table) > 2 and _counts_up(table[0]):
        return Raster(table[1:][::-1], "matrix with numbered columns")
    return Raster(table[::-1], "matrix")


def _counts_up(values: Array) -> bool:
    first = values[0] if values[0] in (0.0, 1.0) else 0.0
    return bool(len(values) >= 2 and (values == np.arange(len(values)) + first).all())


# -- points


def _columns(names: Sequence[str]) -> list[int] | None:
    """Which columns are x, y and z by their names; None where one is missing."""
    plain = [re.split(r"[\s(\[{_/,]", name.strip())[0] for name in names]
    found = []
    for known in (X_NAMES, Y_NAMES, Z_NAMES):
        place = next((k for k, name in enumerate(plain) if name in known), None)
        if place is None:
            return None
        found.append(place)
    return found


def _is_globe(name: str) -> bool:
    return name.startswith("lon")


def _are_places(table: Array) -> bool:
    """True when the first two columns are places, each once, that fill much of a grid, and when
    three columns are too many rows to be ground.
    """
    if len(table) < 9 or table.shape[1] > 12:
        return False
    if table.shape[1] == 3 and len(table) >= NARROW:
        return True
    xs, ys = np.unique(table[:, 0]), np.unique(table[:, 1])
    filled = len(table) / (len(xs) * len(ys))
    places = np.unique(table[:, :2], axis=0)
    return bool(min(len(xs), len(ys)) > 1 and FILLED <= filled and len(places) == len(table))


def _points(table: Array, globe: bool) -> Raster:
    """Points on a regular grid, in any order, as a matrix; a place without a point is NaN."""
    x, y, z = table.T
    if not np.isfinite(table[:, :2]).all():
        raise GroundError("a point has no place")
    dx, dy = _spacing(x, "x"), _spacing(y, "y")
    columns = np.rint((x - x.min()) / dx)
    rows = np.rint((y - y.min()) / dy)
    off = np.maximum(abs((x - x.min()) / dx - columns), abs((y - y.min()) / dy - rows))
    ny, nx = int(rows.max()) + 1, int(columns.max()) + 1
    if off.max() > 0.05 or len(table) < FILLED * ny * nx:
        k = int(off.argmax())
        raise GroundError(
            f"points must lie on a grid: spacing {dx:g} x {dy:g} makes {nx} x {ny} places for "
            f"{len(table)} points, and there is one at ({x[k]:g}, {y[k]:g}); resample them first"
        )
    check_size(ny, nx)
    heights = np.full((ny, nx), np.nan)
    heights[rows.astype(int), columns.astype(int)] = z
    latitude = float(np.mean(y)) if globe else None
    return Raster(heights, "point list", (dx, dy), latitude=latitude)


def points_of(table: Array) -> Raster:
    """Points x, y, z (n, 3) on a regular grid as a matrix; raises ``GroundError``."""
    return _points(table, False)


def _spacing(values: Array, axis: str) -> float:
    places = np.unique(values)
    steps = np.diff(places)
    steps = steps[steps > EVEN * max(float(np.ptp(values)), 1e-12) / max(len(places), 1)]
    if not len(steps):
        raise GroundError(f"all points have the same {axis}")
    step = float(np.median(steps)) if np.ptp(steps) < 0.05 * steps.min() else float(steps.min())
    whole = float(np.ptp(values))
    # far from 0 a single step is rounded; all of them together hardly are
    return whole / max(1, round(whole / step))
