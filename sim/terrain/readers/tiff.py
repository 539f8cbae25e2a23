"""TIFF and GeoTIFF: one channel of any number type, with pixel size and NODATA from the tags.

The first row is north, as in every map viewer. Tags read: ModelPixelScale 33550,
ModelTiepoint 33922, ModelTransformation 34264, GeoKeyDirectory 34735 (1024 GTModelType: 2 is
degrees; 3076 ProjLinearUnits), GDAL_NODATA 42113, and of GDAL_METADATA 42112 scale and offset of
the heights. Compressed files that
tifffile cannot unpack by itself go to Pillow, those of 64 bits to ``tiff_codecs``.
"""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import tifffile
from PIL import Image

from ..generators import GroundError
from ..wide_map import WIDE_CELLS_MAX
from .pictures import _one_level
from .raster import CELLS_MAX, Heights, Raster, as_heights, check_size
from .tiff_codecs import can_unpack, unpacked

# what tifffile cannot make of a tag is no news to whoever brings the file
logging.getLogger("tifffile").addHandler(logging.NullHandler())

PIXEL_SCALE = 33550
TIEPOINT = 33922
TRANSFORMATION = 34264
GEO_KEYS = 34735
CHANNELS_MAX = 16
GDAL_NODATA = 42113
GDAL_METADATA = 42112
MODEL_TYPE_KEY = 1024
PALETTE = 3  # of what PhotometricInterpretation says
WHITE = 257.0  # of a palette's 16 bits, so that 255 is white
UNCOMPRESSED = 1
ASKEW = 1e-3  # of a pixel's side, by which columns and rows may lie beside x and y
GEOGRAPHIC = 2  # value of the model type key: longitude and latitude
PROJECTED = 1
UNIT_KEY = 3076  # of lengths on the map
UNITS = {9002: 0.3048, 9003: 0.3048006096}  # EPSG: foot, US survey foot, m
SMALL = 0.01  # degrees; a pixel this small at a longitude and latitude is one of degrees


def read_tiff(path: Path) -> Raster:
    """Heights of the first page, north up, with what its tags say of the ground."""
    with tifffile.TiffFile(path) as file:
        if not file.pages:
            raise GroundError("there is no picture in it")
        page: Any = file.pages[0]
        shape = tuple(int(n) for n in page.shape)
        most = WIDE_CELLS_MAX if len(shape) == 2 else CELLS_MAX
        check_size(shape[0], shape[1] if len(shape) > 1 else 1, most)
        values = _in_colours(_pixels(page, path), page)
        tags = {code: page.tags[code].value for code in _TAGS if code in page.tags}
        alpha = _has_alpha(page)
    scale, offset = _said_of_heights(tags, "scale", 1.0), _said_of_heights(tags, "offset", 0.0)
    heights = _one_channel(values, alpha) * scale + offset
    cell = _cell(tags)
    return Raster(
        _north_up(heights, _matrix(tags)),
        f"{values.dtype} GeoTIFF" if cell is not None else f"{values.dtype} TIFF",
        cell,
        None,
        tuple(value * scale + offset for value in _nodata(tags.get(GDAL_NODATA))),
        latitude=_latitude(tags, cell),
    )


def _has_alpha(page: Any) -> bool:
    """Whether the last channel says how far one sees through."""
    return any(int(kind) in (1, 2) for kind in getattr(page, "extrasamples", ()))


def _in_colours(values: Any, page: Any) -> Any:
    """The red, green and blue of 0 to 255 that the numbers of a palette stand for."""
    if int(page.photometric or 0) != PALETTE or page.colormap is None or values.ndim != 2:
        return values
    return np.moveaxis(np.asarray(page.colormap)[:, values] / WHITE, 0, -1)


def _matrix(tags: dict[int, Any]) -> list[float]:
    """How columns and rows lie on the map, row by row; none where the file does not say. Raises
    ``GroundError`` where they lie askew.
    """
    matrix = [float(v) for v in np.ravel(tags.get(TRANSFORMATION, ()))]
    if len(matrix) != 16:
        return []
    askew = max(abs(matrix[1]), abs(matrix[4]))
    if askew > ASKEW * max(abs(matrix[0]), abs(matrix[5])):
        turned = math.degrees(math.atan2(matrix[4], matrix[0]))
        raise GroundError(
            f"its rows are turned {turned:.3g} degrees against the map's x; turn it north up first "
            "(gdalwarp does)"
        )
    return matrix


def _north_up(heights: Heights, matrix: Sequence[float]) -> Heights:
    """The row of least y and the column of least x first: of a picture whose rows run south, as
    most do, upside down.
    """
    northwards = bool(matrix and matrix[5] > 0.0)
    westwards = bool(matrix and matrix[0] < 0.0)
    return heights[:: 1 if northwards else -1, :: -1 if westwards else 1]


_TAGS = (PIXEL_SCALE, TIEPOINT, TRANSFORMATION, GEO_KEYS, GDAL_NODATA, GDAL_METADATA)


def _pixels(page: Any, path: Path) -> Any:
    try:
        return np.asarray(page.asarray())
    except (ValueError, KeyError, NotImplementedError) as error:  # a codec that is not installed
        if int(page.compression) == UNCOMPRESSED:
            raise GroundError(f"its pixels cannot be read: {error}") from None
        values = unpacked(page) if can_unpack(page) else _by_pillow(path)
        if values is None:
            raise GroundError(f"compressed in a way that cannot be read here: {error}") from None
        return values


def _by_pillow(path: Path) -> Any:
    try:
        with Image.open(path, formats=["TIFF"]) as picture:
            return np.asarray(picture)
    except (OSError, ValueError):
        return None


def _one_channel(values: Any, alpha: bool) -> Heights:
    """Heights (ny, nx) from a page of one channel, or of several equal ones; with ``alpha`` the
    last says where one sees through.
    """
    if values.dtype.kind not in "fiub":
        raise GroundError(f"numbers wanted, got {values.dtype}")
    if values.ndim == 3 and values.shape[0] <= CHANNELS_MAX < values.shape[2]:
        values = np.moveaxis(values, 0, -1)
    if values.ndim == 3 and values.shape[2] == 2 and alpha:
        values = values[..., [0, 0, 0, 1]]
    if values.ndim == 3 and values.shape[2] == 1:
        values = values[..., 0]
    if values.ndim == 3 and values.shape[2] == 3 + alpha:
        return _one_level(np.asarray(values, dtype=np.float64), alpha)
    if values.ndim == 3:
        raise GroundError(f"one channel of heights is wanted, got {values.shape[2]}: export one")
    if values.ndim != 2:
        raise GroundError(f"one channel of heights is wanted, got an array of shape {values.shape}")
    return as_heights(values)


def _cell(tags: dict[int, Any]) -> tuple[float, float] | None:
    """Size of a pixel along x and y, m; in degrees where the file is."""
    unit = UNITS.get(_geo_key(tags, UNIT_KEY), 1.0)
    if PIXEL_SCALE in tags:
        scale = [abs(float(v)) * unit for v in np.ravel(tags[PIXEL_SCALE])]
        if len(scale) >= 2 and scale[0] > 0.0 and scale[1] > 0.0:
            return scale[0], scale[1]
    if TRANSFORMATION in tags:
        matrix = [float(v) * unit for v in np.ravel(tags[TRANSFORMATION])]
        if len(matrix) == 16:
            return math.hypot(matrix[0], matrix[4]), math.hypot(matrix[1], matrix[5])
    return None


def _geo_key(tags: dict[int, Any], key: int) -> int:
    """The value of a key of the GeoKeyDirectory; 0 without it."""
    entries = [int(v) for v in np.ravel(tags.get(GEO_KEYS, ()))]
    values = (entries[k + 3] for k in range(4, len(entries) - 3, 4) if entries[k] == key)
    return next(values, 0)


def _latitude(tags: dict[int, Any], cell: tuple[float, float] | None) -> float | None:
    """Where the pixels are degrees: by the geo-keys, or small ones at a longitude and latitude
    where there are none.
    """
    x, y = _corner(tags)
    model = _geo_key(tags, MODEL_TYPE_KEY)
    on_globe = 1.0 < abs(x) <= 180.0 and 1.0 < abs(y) <= 90.0
    if model == GEOGRAPHIC:
        return y
    guessed = cell is not None and cell[0] < SMALL and on_globe and model != PROJECTED
    return y if guessed else None


def _corner(tags: dict[int, Any]) -> tuple[float, float]:
    """x and y of the first pixel on the map; 0, 0 where the file does not say."""
    tie = [float(v) for v in np.ravel(tags.get(TIEPOINT, ()))]
    if len(tie) >= 6:
        return tie[3], tie[4]
    matrix = [float(v) for v in np.ravel(tags.get(TRANSFORMATION, ()))]
    return (matrix[3], matrix[7]) if len(matrix) == 16 else (0.0, 0.0)


def _said_of_heights(tags: dict[int, Any], role: str, without: float) -> float:
    """What GDAL's metadata (XML) say that the first channel's numbers are to be taken times, or
    plus.
    """
    item = re.search(
        rf"<Item\b(?=[^>]*role=\"{role}\")(?![^>]*sample=\"[1-9])[^>]*>\s*([-+.\deE]+)\s*<",
        str(tags.get(GDAL_METADATA, "")),
    )
    try:
        return without if item is None else float(item.group(1))
    except ValueError:
        return without


def _nodata(said: Any) -> tuple[float, ...]:
    """The heights that stand for nothing, from GDAL's tag (text)."""
    if said is None:
        return ()
    text = said.decode("ascii", "replace") if isinstance(said, bytes) else str(said)
    try:
        return (float(text.strip("\0 \n").replace(",", ".")),)
    except ValueError:
        return ()
