"""Heights as text: what a text file is, and the ASCII grids of ESRI, GRASS and Surfer.

Found in the wild and taken: header keys in any order and case, one or several a line, comments
before and behind them, CRLF and CR, corner or centre of the lower left cell, ``dx``/``dy`` in place
of ``cellsize``, rows wrapped over several lines, blanks, tabs, commas or semicolons between
numbers, the decimal comma, and a minus that is no hyphen. The first row is north, of Surfer south.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from walking_console.planner.types import Array

from ..generators import CELL_MIN, GroundError
from .raster import FILE_BYTES_MAX, Raster, check_size
from .tables import read_table

HEADER_LINES_MAX = 40
ESRI_KEYS = {
    "ncols", "nrows", "xllcorner", "yllcorner", "xllcenter", "yllcenter", "xllcentre", "yllcentre",
    "cellsize", "dx", "dy", "nodata_value", "nodata", "byteorder", "xcellsize", "ycellsize",
}  # fmt: skip
GRASS_KEYS = {"north", "south", "east", "west", "rows", "cols", "null", "type", "multiplier"}
KEYS = ESRI_KEYS | GRASS_KEYS
PARTED = re.compile(r"[\s:=]+")
SURFER = "DSAA"  # what a text grid of Surfer begins with
SURFER_BLANK = 1.70141e38  # and what stands for no height in it, or more
BEGINNING = 1000  # bytes that tell text from what is none
MINUS = "\N{MINUS SIGN}"
COMMENTS = ("#", "!", "%", "//")
NO_NUMBERS = {"*": "nan", "na": "nan", "n/a": "nan", "null": "nan"}  # words for no height


def read_text(path: Path) -> Raster:
    """An ASCII grid where it begins with the keys of one, else a matrix or a list of points."""
    lines = [_told(line) for line in _text(path).split("\n") if _counts(line)]
    if not lines:
        raise GroundError("it is empty")
    if lines[0].strip().upper() == SURFER:
        return _surfer_grid(lines[1:])
    if lines[0].strip() == str(len(lines) - 1):  # how many points there are
        lines = lines[1:]
    lines = [*_one_a_line(lines[:HEADER_LINES_MAX]), *lines[HEADER_LINES_MAX:]]
    key = _key(lines[0])
    if key in ESRI_KEYS or key in GRASS_KEYS or (key and path.suffix.lower() == ".asc"):
        return _ascii_grid(lines)
    return read_table(lines, points=path.suffix.lower() == ".xyz")


def _text(path: Path) -> str:
    """The text of a file in UTF-8, UTF-16 or an old code page, lines ending in one way."""
    if path.stat().st_size > FILE_BYTES_MAX:
        raise GroundError(f"{path.stat().st_size} bytes; at most {FILE_BYTES_MAX}")
    raw = path.read_bytes()
    wide = raw[:2] in (b"\xff\xfe", b"\xfe\xff")
    if not wide and b"\0" in raw[:BEGINNING]:
        raise GroundError(f"text is wanted, and it is binary: it begins with {raw[:4]!r}")
    try:
        text = raw.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n").replace(MINUS, "-")


def _counts(line: str) -> bool:
    line = line.lstrip()
    return bool(line) and not line.startswith(COMMENTS)


def _told(line: str) -> str:
    """A line without the comment behind what it says."""
    return line if "#" not in line else re.sub(r"\s#.*$", "", line)


def _one_a_line(lines: Sequence[str]) -> Iterator[str]:
    """Header keys each in a line of its own, where several stand in one."""
    for line in lines:
        words = PARTED.split(line.strip())
        keys = [word.lower() for word in words[::2]]
        if len(words) > 2 and len(words) % 2 == 0 and KEYS.issuperset(keys):
            yield from map(" ".join, zip(words[::2], words[1::2], strict=True))
        else:
            yield line


def _key(line: str) -> str:
    """The header key a line begins with, lower case; "" of a line of numbers."""
    found = re.match(r"\s*([A-Za-z][A-Za-z_]*)\s*(?:[:=]\s*|\s)\S+\s*$", line)
    word = "" if found is None else found.group(1).lower()
    return "" if word in ("nan", "inf") or word in NO_NUMBERS else word


def _ascii_grid(lines: list[str]) -> Raster:
    header, body = _header(lines)
    names = ("rows", "cols") if "rows" in header else ("nrows", "ncols")
    nrows, ncols = (_count(header, name) for name in names)
    check_size(nrows, ncols)
    values = _numbers(body, nrows * ncols)
    if values.size != nrows * ncols:
        raise GroundError(f"{nrows} x {ncols} heights are announced, {values.size} are there")
    cell = _cell(header, nrows, ncols)
    nodata = header.get("nodata_value", header.get("nodata", header.get("null")))
    return Raster(
        values.reshape(nrows, ncols)[::-1] * header.get("multiplier", 1.0),
        "ESRI ASCII grid" if "nrows" in header else "GRASS ASCII grid",
        cell,
        None,
        () if nodata is None else (nodata,),
        latitude=_latitude(header, cell),
    )


def _header(lines: list[str]) -> tuple[dict[str, float], list[str]]:
    """Keys and values at the beginning, and the lines that follow them."""
    found: dict[str, float] = {}
    count = 0
    for line in lines[:HEADER_LINES_MAX]:
        key = _key(line)
        if not key:
            break
        count += 1
        if key not in ESRI_KEYS and key not in GRASS_KEYS:
            known = ", ".join(sorted(ESRI_KEYS))
            raise GroundError(f"unknown header key {key!r:.40}; an ESRI ASCII grid has {known}")
        if key not in ("byteorder", "type"):
            found[key] = _number(PARTED.split(line.strip())[1], key)
    wanted = ("rows", "cols") if "rows" in found or "cols" in found else ("ncols", "nrows")
    for key in wanted:
        if key not in found:
            raise GroundError(f"there is no {key} in its header: an ESRI ASCII grid is wanted")
    return found, lines[count:]


def _surfer_grid(lines: list[str]) -> Raster:
    """Counts, then the first and last x, y and z, then heights, row of least y first."""
    words = " ".join(lines[:4]).split()
    if len(words) != 8:
        raise GroundError(f"a Surfer grid has counts and x, y, z from and to, got {words[:9]}")
    nx, ny = (
        _count({name: _number(word, name)}, name)
        for name, word in zip("xy", words[:2], strict=True)
    )
    x_low, x_high, y_low, y_high = (_number(word, "the edge") for word in words[2:6])
    check_size(ny, nx)
    values = _numbers(lines[4:], nx * ny)
    if values.size != nx * ny or min(nx, ny) < 2:
        raise GroundError(f"{ny} x {nx} heights are announced, {values.size} are there")
    values[values >= SURFER_BLANK] = np.nan
    cell = abs(x_high - x_low) / (nx - 1), abs(y_high - y_low) / (ny - 1)
    return Raster(values.reshape(ny, nx), "Surfer grid", cell)


def _number(word: str, key: str) -> float:
    try:
        return float(NO_NUMBERS.get(word.lower(), word).replace(",", "."))
    except ValueError:
        raise GroundError(f"{key} must be a number, got {word!r:.40}") from None


def _count(header: Mapping[str, float], key: str) -> int:
    value = header[key]
    if not value.is_integer() or not 1 <= value < 1e9:
        raise GroundError(f"{key} must be a whole number, got {value:g}")
    return int(value)


def _cell(header: Mapping[str, float], nrows: int, ncols: int) -> tuple[float, float] | None:
    """The sides of a cell along x and y as they are said, or as the edges of the map have them."""
    if {"north", "south", "east", "west"} <= header.keys():
        wide = abs(header["east"] - header["west"]) / ncols
        return wide, abs(header["north"] - header["south"]) / nrows
    one = header.get("cellsize")
    dx = header.get("dx", header.get("xcellsize", one))
    dy = header.get("dy", header.get("ycellsize", one))
    return None if dx is None or dy is None else (dx, dy)


def _latitude(header: Mapping[str, float], cell: tuple[float, float] | None) -> float | None:
    """Where the cells are degrees: of less than a hundredth, with a corner that is longitude and
    latitude; None elsewhere.
    """
    x = _first(header, "xllcorner", "xllcenter", "xllcentre", "west")
    y = _first(header, "yllcorner", "yllcenter", "yllcentre", "south")
    if cell is None or not (abs(x) <= 180.0 and abs(y) <= 90.0):
        return None
    surely = 1.0 < abs(x) and 1.0 < abs(y)
    largest = 0.01 if surely else CELL_MIN
    return y if cell[0] < largest else None


def _first(header: Mapping[str, float], *names: str) -> float:
    return next((header[name] for name in names if name in header), 0.0)


def _numbers(lines: list[str], count: int) -> Array:
    """All numbers of a text, however they are wrapped. A comma is a decimal point where blanks
    alone part as many words as there should be numbers.
    """
    body = "\n".join(lines).replace(";", " ")
    words = body.split()
    if "," in body and len(words) == count and not any("." in word for word in words[:count]):
        words = body.replace(",", ".").split()
    elif "," in body:
        words = body.replace(",", " ").split()
    try:
        return np.array(words, dtype=object).astype(np.float64)
    except ValueError:
        return _spelled_out(words)


def _spelled_out(words: list[str]) -> Array:
    """As numbers, with the words for no height; names the first word that is neither."""
    values = np.empty(len(words))
    for k, word in enumerate(words):
        try:
            values[k] = float(NO_NUMBERS.get(word.lower(), word))
        except ValueError:
            raise GroundError(f"heights must be numbers, got {word!r:.40}") from None
    return values
