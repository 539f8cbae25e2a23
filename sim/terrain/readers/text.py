"""Heights as text: ESRI ASCII grids, matrices and point lists.

Found in the wild and taken: header keys in any order and case, CRLF, corner or centre of the lower
left cell, ``dx``/``dy`` in place of ``cellsize``, rows wrapped over several lines, commas,
semicolons, tabs or spaces between numbers, and the decimal comma. The first row is north.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from walking_console.planner.types import Array

from ..generators import GroundError
from .raster import FILE_BYTES_MAX, Raster, check_size

HEADER_LINES_MAX = 20
ESRI_KEYS = {
    "ncols", "nrows", "xllcorner", "yllcorner", "xllcenter", "yllcenter", "xllcentre", "yllcentre",
    "cellsize", "dx", "dy", "nodata_value", "nodata", "byteorder", "xcellsize", "ycellsize",
}  # fmt: skip
EVEN = 1e-3  # of the spacing: how far a point of a regular list may be beside its place


def _text(path: Path) -> str:
    if path.stat().st_size > FILE_BYTES_MAX:
        raise GroundError(f"{path.stat().st_size} bytes; at most {FILE_BYTES_MAX}")
    raw = path.read_bytes()
    for encoding in (
        ("utf-8-sig", "utf-16") if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else ("utf-8-sig",)
    ):
        try:
            return raw.decode(encoding)
        except UnicodeDecodeError:
            continue
    return raw.decode("latin-1")


def read_ascii_grid(path: Path) -> Raster:
    """An ESRI ASCII grid: a header of keys, then nrows x ncols heights."""
    text = _text(path)
    header, body = _header(text)
    ncols, nrows = _count(header, "ncols"), _count(header, "nrows")
    check_size(nrows, ncols)
    values = _numbers(body)
    if values.size != nrows * ncols:
        raise GroundError(f"{nrows} x {ncols} heights are announced, {values.size} are there")
    cell = header.get("cellsize")
    dx = header.get("dx", header.get("xcellsize", cell))
    dy = header.get("dy", header.get("ycellsize", cell))
    nodata = header.get("nodata_value", header.get("nodata"))
    degrees = _looks_like_degrees(header, dx)
    return Raster(
        values.reshape(nrows, ncols)[::-1],
        "ESRI ASCII grid",
        None if dx is None or dy is None else (dx, dy),
        None,
        () if nodata is None else (nodata,),
        degrees,
    )


def _header(text: str) -> tuple[dict[str, float], str]:
    """Keys and values at the beginning, and what follows them."""
    found: dict[str, float] = {}
    position = 0
    for _ in range(HEADER_LINES_MAX):
        end = text.find("\n", position)
        line = text[position : len(text) if end < 0 else end].strip()
        words = line.replace("=", " ").split()
        if line and not re.match(r"[A-Za-z_]", line):
            break
        if words:
            key = words[0].lower().rstrip(":")
            if key not in ESRI_KEYS:
                raise GroundError(f"unknown header key {words[0]!r:.40}; an ESRI ASCII grid has "
                                  f"{', '.join(sorted(ESRI_KEYS))}")  # fmt: skip
            if key != "byteorder":
                found[key] = _number(words[1] if len(words) > 1 else "", words[0])
        if end < 0:
            position = len(text)
            break
        position = end + 1
    for key in ("ncols", "nrows"):
        if key not in found:
            raise GroundError(f"there is no {key} in its header: an ESRI ASCII grid is wanted")
    return found, text[position:]


def _number(word: str, key: str) -> float:
    try:
        return float(word.replace(",", "."))
    except ValueError:
        raise GroundError(f"{key} must be a number, got {word!r:.40}") from None


def _count(header: dict[str, float], key: str) -> int:
    value = header[key]
    if not value.is_integer() or not 1 <= value < 1e9:
        raise GroundError(f"{key} must be a whole number, got {value:g}")
    return int(value)


def _looks_like_degrees(header: dict[str, float], dx: float | None) -> bool:
    """A cell of less than a hundredth with corners that are longitude and latitude."""
    x = header.get("xllcorner", header.get("xllcenter", header.get("xllcentre", 0.0)))
    y = header.get("yllcorner", header.get("yllcenter", header.get("yllcentre", 0.0)))
    on_globe = 1.0 < abs(x) <= 180.0 and 1.0 < abs(y) <= 90.0
    return dx is not None and dx < 0.01 and on_globe


def _numbers(body: str) -> Array:
    """All numbers of a text, however they are wrapped; a comma is a decimal point where blanks part
    the numbers."""
    if "," in body:
        body = body.replace(",", ".")
    values = np.array(body.split(), dtype=object)
    try:
        return values.astype(np.float64)
    except ValueError as error:
        raise GroundError(f"heights must be numbers: {error}") from None


def read_csv(path: Path) -> Raster:
    """A matrix of heights, or a list of points x, y, z; which of the two its shape and header
    say.
    """
    lines = [
        line for line in _text(path).splitlines() if line.strip() and line.lstrip()[0] not in "#%"
    ]
    if not lines:
        raise GroundError("it is empty")
    names, rows = _table(lines)
    width = len(rows[0])
    for number, row in enumerate(rows, 1):
        if len(row) != width:
            raise GroundError(f"row {number} has {len(row)} numbers where the first has {width}")
    check_size(len(rows), width)
    table = np.array(rows, dtype=np.float64)
    if _is_point_list(names, table):
        return _points(names, table)
    if names and not _are_numbers(names):
        names = []
    return Raster(table[::-1], "matrix")


def _table(lines: Sequence[str]) -> tuple[list[str], list[list[float]]]:
    """The words of a heading line, if there is one, and the numbers of all others."""
    split, point = _dialect(lines)
    names: list[str] = []
    rows: list[list[float]] = []
    for number, line in enumerate(lines):
        words = [word.strip().strip('"') for word in split(line)]
        while words and words[-1] == "":
            words.pop()
        try:
            rows.append([_value(word, point) for word in words])
        except ValueError:
            if number == 0:
                names = [word.lower() for word in words]
                continue
            raise GroundError(f"line {number + 1} holds what is no number: {line[:60]!r}") from None
    if not rows:
        raise GroundError("there are no numbers in it")
    return names, rows


def _value(word: str, point: str) -> float:
    if word.lower() in ("", "nan", "na", "null"):
        return math.nan
    return float(word.replace(point, ".") if point != "." else word)


def _dialect(lines: Sequence[str]) -> tuple[Callable[[str], list[str]], str]:
    """How the numbers of a line are parted, and what the decimal point is."""
    sample = lines[min(1, len(lines) - 1)]
    if ";" in sample:
        return (lambda line: line.split(";")), "," if "," in sample else "."
    if "\t" in sample:
        return (lambda line: line.split("\t")), "," if "," in sample else "."
    if (
        "," in sample
        and re.search(r",\s|\.", sample)
        or sample.count(",")
        and " " not in sample.strip()
    ):
        return (lambda line: line.split(",")), "."
    return (lambda line: line.split()), "," if "," in sample else "."


def _are_numbers(names: Sequence[str]) -> bool:
    return all(re.fullmatch(r"[-+0-9.eE]+", name) for name in names)


def _is_point_list(names: Sequence[str], table: Array) -> bool:
    """A heading x, y, z; or three columns of which the first two are the places of a grid."""
    if [name[:1] for name in names[:3]] == ["x", "y", "z"] or names[:2] in (
        ["lon", "lat"],
        ["easting", "northing"],
    ):
        return bool(table.shape[1] >= 3)
    if table.shape[1] != 3 or len(table) < 9:
        return False
    xs, ys = np.unique(table[:, 0]), np.unique(table[:, 1])
    return bool(len(xs) * len(ys) == len(table) and min(len(xs), len(ys)) > 1)


def _points(names: Sequence[str], table: Array) -> Raster:
    """Points on a regular grid, in any order, as a matrix; a place without a point is NaN."""
    x, y, z = table[:, 0], table[:, 1], table[:, 2]
    dx, dy = _spacing(x, "x"), _spacing(y, "y")
    columns = np.rint((x - x.min()) / dx)
    rows = np.rint((y - y.min()) / dy)
    off = np.maximum(abs((x - x.min()) / dx - columns), abs((y - y.min()) / dy - rows))
    if off.max() > 0.05:
        k = int(off.argmax())
        raise GroundError(
            f"points must lie on a grid: spacing {dx:g} x {dy:g}, but there is one at "
            f"({x[k]:g}, {y[k]:g}); resample them first"
        )
    ny, nx = int(rows.max()) + 1, int(columns.max()) + 1
    check_size(ny, nx)
    heights = np.full((ny, nx), np.nan)
    heights[rows.astype(int), columns.astype(int)] = z
    return Raster(heights, "point list", (dx, dy), None, (), names[:2] == ["lon", "lat"])


def _spacing(values: Array, axis: str) -> float:
    places = np.unique(values)
    steps = np.diff(places)
    steps = steps[steps > EVEN * max(float(np.ptp(values)), 1e-12) / max(len(places), 1)]
    if not len(steps):
        raise GroundError(f"all points have the same {axis}")
    return float(np.median(steps)) if np.ptp(steps) < 0.05 * steps.min() else float(steps.min())
