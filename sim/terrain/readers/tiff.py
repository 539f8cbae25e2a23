"""TIFF and GeoTIFF: one channel of any number type, with pixel size and NODATA from the tags.

The first row is north, as in every map viewer. Tags read: ModelPixelScale 33550,
ModelTransformation 34264, GeoKeyDirectory 34735 (1024 GTModelType: 2 is degrees), GDAL_NODATA
42113, GDAL_METADATA is not. Compressed files that tifffile cannot unpack by itself go to Pillow.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import tifffile
from PIL import Image

from walking_console.planner.types import Array

from ..generators import GroundError
from .pictures import _one_level
from .raster import Raster, check_size

PIXEL_SCALE = 33550
TRANSFORMATION = 34264
GEO_KEYS = 34735
GDAL_NODATA = 42113
MODEL_TYPE_KEY = 1024
GEOGRAPHIC = 2  # value of the model type key: longitude and latitude


def read_tiff(path: Path) -> Raster:
    """Heights of the first page, north up, with what its tags say of the ground."""
    with tifffile.TiffFile(path) as file:
        if not file.pages:
            raise GroundError("there is no picture in it")
        page: Any = file.pages[0]
        shape = tuple(int(n) for n in page.shape)
        check_size(shape[0], shape[1] if len(shape) > 1 else 1)
        values = _pixels(page, path)
        tags = {code: page.tags[code].value for code in _TAGS if code in page.tags}
    heights = _one_channel(values)
    return Raster(
        heights[::-1],
        f"{values.dtype} GeoTIFF" if PIXEL_SCALE in tags else f"{values.dtype} TIFF",
        _cell(tags),
        None,
        _nodata(tags.get(GDAL_NODATA)),
        _in_degrees(tags.get(GEO_KEYS)),
    )


_TAGS = (PIXEL_SCALE, TRANSFORMATION, GEO_KEYS, GDAL_NODATA)


def _pixels(page: Any, path: Path) -> Any:
    try:
        return np.asarray(page.asarray())
    except (ValueError, KeyError, NotImplementedError) as error:  # a codec that is not installed
        unpacked = _by_pillow(path)
        if unpacked is None:
            raise GroundError(f"compressed in a way that cannot be read here: {error}") from None
        return unpacked


def _by_pillow(path: Path) -> Any:
    try:
        with Image.open(path, formats=["TIFF"]) as picture:
            return np.asarray(picture)
    except (OSError, ValueError):
        return None


def _one_channel(values: Any) -> Array:
    """Heights (ny, nx) from a page of one channel, or of several equal ones."""
    if values.dtype.kind not in "fiub":
        raise GroundError(f"numbers wanted, got {values.dtype}")
    if values.ndim == 3 and values.shape[0] in (1, 3, 4) and values.shape[2] not in (1, 3, 4):
        values = np.moveaxis(values, 0, -1)
    if values.ndim == 3 and values.shape[2] == 1:
        values = values[..., 0]
    if values.ndim == 3 and values.shape[2] in (3, 4):
        return _one_level(np.asarray(values, dtype=np.float64), values.shape[2] == 4)
    if values.ndim != 2:
        raise GroundError(f"one channel of heights is wanted, got an array of shape {values.shape}")
    return np.asarray(values, dtype=np.float64)


def _cell(tags: dict[int, Any]) -> tuple[float, float] | None:
    """Size of a pixel along x and y, in the units of the file."""
    if PIXEL_SCALE in tags:
        scale = [float(v) for v in np.ravel(tags[PIXEL_SCALE])]
        if len(scale) >= 2 and scale[0] > 0.0 and scale[1] > 0.0:
            return scale[0], scale[1]
    if TRANSFORMATION in tags:
        matrix = [float(v) for v in np.ravel(tags[TRANSFORMATION])]
        if len(matrix) == 16:
            return math.hypot(matrix[0], matrix[4]), math.hypot(matrix[1], matrix[5])
    return None


def _in_degrees(keys: Any) -> bool:
    """Whether the geo-keys name a model of longitude and latitude."""
    if keys is None:
        return False
    entries = [int(v) for v in np.ravel(keys)]
    return any(
        entries[k] == MODEL_TYPE_KEY and entries[k + 3] == GEOGRAPHIC
        for k in range(4, len(entries) - 3, 4)
    )


def _nodata(said: Any) -> tuple[float, ...]:
    """The heights that stand for nothing, from GDAL's tag (text)."""
    if said is None:
        return ()
    text = said.decode("ascii", "replace") if isinstance(said, bytes) else str(said)
    try:
        return (float(text.strip("\0 \n")),)
    except ValueError:
        return ()
