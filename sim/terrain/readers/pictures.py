"""Pictures: PNG (and JPEG, BMP, PGM) of any mode whose channels are equal; the levels are parts of
white.

The first row of a picture is its top, and that is north: the largest y. The size is checked before
a pixel is decoded. Pillow cuts 16-bit colour to 8 bits without a word, so that such files are read
by pypng.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import png
from PIL import Image, UnidentifiedImageError

from walking_console.planner.types import Array

from ..generators import GroundError
from ..wide_map import WIDE_CELLS_MAX
from .raster import CELLS_MAX, Heights, Raster, as_heights, check_size

GREY_MODES = {"1": 1.0, "L": 255.0, "I;16": 65535.0, "I": 65535.0}  # Pillow mode: level of white

FORMATS = ["PNG", "JPEG", "BMP", "PPM"]


def read_picture(path: Path) -> Raster:
    """Grey levels as parts of white (0 to 1), north up; see-through pixels are NaN."""
    levels: Heights
    with _opened(path) as picture:
        width, height = picture.size
        mode = str(picture.mode)
        check_size(height, width, WIDE_CELLS_MAX if mode in GREY_MODES else CELLS_MAX)
        deep = picture.format == "PNG" and _bits(path) == 16
        if deep and mode not in GREY_MODES:
            levels = _deep_colour(path)
            what = "16-bit picture"
        elif mode in GREY_MODES:
            levels = as_heights(np.asarray(picture)) / GREY_MODES[mode]
            levels[levels == _clear_level(picture, path)] = np.nan
            what = f"{16 if GREY_MODES[mode] > 255.0 else 8}-bit grey picture"
        else:
            levels = _colour(picture, mode)
            what = f"8-bit picture of mode {mode}"
    return Raster(levels[::-1], what)


def _opened(path: Path) -> Image.Image:
    try:
        return Image.open(path, formats=FORMATS)
    except UnidentifiedImageError:
        with path.open("rb") as file:
            begins = file.read(8)
        raise GroundError(
            f"a picture of {', '.join(FORMATS)} is wanted; it is none, or cut short, and begins "
            f"with {begins!r}"
        ) from None


def _clear_level(picture: Image.Image, path: Path) -> float:
    """The grey level that one sees through, as a part of white (PNG's tRNS); NaN without one."""
    said = picture.info.get("transparency")
    if picture.format != "PNG" or not isinstance(said, int):
        return math.nan
    return said / (255.0 if picture.mode == "1" else 2.0 ** _bits(path) - 1.0)


def _bits(path: Path) -> int:
    """Bits a channel, from the header of the file (PNG specification, 11.2.2)."""
    with path.open("rb") as file:
        header = file.read(25)
    return header[24] if len(header) == 25 else 0


def _colour(picture: Image.Image, mode: str) -> Array:
    """A colour or palette picture whose red, green and blue are equal everywhere."""
    clear = "A" in mode or "transparency" in picture.info
    wanted = picture.convert("RGBA" if clear else "RGB")
    return _one_level(np.asarray(wanted, dtype=np.float64) / 255.0, clear)


def _deep_colour(path: Path) -> Array:
    """A picture of 16 bits a channel with more channels than one."""
    with path.open("rb") as file:
        width, height, rows, info = png.Reader(file=file).asDirect()
        values = np.vstack([np.asarray(row, dtype=np.float64) for row in rows])
    planes = int(info["planes"])
    channels: Array = values.reshape(height, width, planes) / float(2 ** int(info["bitdepth"]) - 1)
    clear = bool(info["alpha"])
    if planes - clear == 1:
        channels = np.concatenate([channels[..., :1]] * 3 + [channels[..., 1:]], axis=-1)
    return _one_level(channels, clear)


def _one_level(channels: Any, clear: bool) -> Array:
    """One level from equal channels (ny, nx, 3 or 4); a pixel one sees through is NaN."""
    red, green, blue = channels[..., 0], channels[..., 1], channels[..., 2]
    unequal = (red != green) | (red != blue)
    if clear:
        unequal &= channels[..., 3] > 0.0
    if unequal.any():
        row, column = np.argwhere(unequal)[0]
        raise GroundError(
            "a picture whose channels are equal (grey) is wanted; this one is coloured: pixel "
            f"[{row}, {column}] is red {red[row, column]:.5f}, green {green[row, column]:.5f}, "
            f"blue {blue[row, column]:.5f} ({int(unequal.sum())} such)"
        )
    levels = np.array(red, dtype=np.float64)
    if clear:
        levels[channels[..., 3] == 0.0] = np.nan
    return levels
