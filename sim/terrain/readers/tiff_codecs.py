"""What tifffile unpacks with a further package and Pillow does not: LZW and the floating-point
predictor at 64 bits, which is how GDAL packs elevation models of double precision.

LZW itself is Pillow's: the bytes of a strip are handed to it as a grey picture of one byte a pixel.
The predictor is that of TIFF Technical Note 3: bytes of a row by significance, each the difference
to the one before.
"""

from __future__ import annotations

import io
import struct
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ..generators import GroundError

LZW = 5
DEFLATE = (8, 32946)
NONE = 1
HORIZONTAL = 2  # predictors
FLOATING = 3

Bytes = NDArray[np.uint8]


def can_unpack(page: Any) -> bool:
    """True of a page of one channel of 64 bits that is packed in one of these ways."""
    packed = int(page.compression) in (LZW, *DEFLATE)
    known = int(page.predictor) in (NONE, HORIZONTAL, FLOATING)
    return packed and known and page.samplesperpixel == 1 and page.dtype.itemsize == 8


def unpacked(page: Any) -> Any:
    """The pixels (ny, nx) of a page that ``can_unpack``."""
    ny, nx = page.imagelength, page.imagewidth
    high = page.tilelength if page.is_tiled else min(page.rowsperstrip, ny)
    wide = page.tilewidth if page.is_tiled else nx
    across = -(-nx // wide)
    number = page.dtype.newbyteorder(page.parent.byteorder)
    values = np.zeros((-(-ny // high) * high, across * wide), page.dtype)
    file = page.parent.filehandle
    for k, (offset, count) in enumerate(zip(page.dataoffsets, page.databytecounts, strict=True)):
        file.seek(offset)
        row, column = k // across * high, k % across * wide
        rows = high if page.is_tiled else min(high, ny - row)
        raw = _bytes(int(page.compression), file.read(count), rows, wide * number.itemsize)
        part = _predicted(int(page.predictor), raw, number)
        values[row : row + rows, column : column + wide] = part
    return values[:ny, :nx]


def _bytes(compression: int, packed: bytes, rows: int, width: int) -> Bytes:
    """The bytes of a strip or tile, (rows, width)."""
    if compression == LZW:
        with Image.open(io.BytesIO(_grey_tiff(packed, rows, width)), formats=["TIFF"]) as picture:
            return np.asarray(picture)
    plain = zlib.decompressobj().decompress(packed, rows * width)
    if len(plain) != rows * width:
        raise GroundError(f"a strip of {rows * width} bytes unpacks to {len(plain)}")
    return np.frombuffer(plain, np.uint8).reshape(rows, width)


def _grey_tiff(packed: bytes, rows: int, width: int) -> bytes:
    """A TIFF of one strip of bytes packed by LZW (TIFF 6.0, section 2)."""
    entries = (
        (256, width), (257, rows), (258, 8), (259, LZW), (262, 1), (273, 8), (277, 1), (278, rows),
        (279, len(packed)),
    )  # fmt: skip
    padding = len(packed) % 2
    head = struct.pack("<2sHI", b"II", 42, 8 + len(packed) + padding)
    table = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in entries)
    directory = struct.pack("<H", len(entries)) + table + bytes(4)
    return head + packed + bytes(padding) + directory


def _predicted(predictor: int, raw: Bytes, number: Any) -> Any:
    """Numbers from the bytes of rows, with their predictor undone."""
    rows = len(raw)
    if predictor == FLOATING:
        planes = np.cumsum(raw, axis=1, dtype=np.uint8).reshape(rows, number.itemsize, -1)
        big = np.ascontiguousarray(planes.transpose(0, 2, 1)).reshape(rows, -1)
        return big.view(number.newbyteorder(">"))
    values = np.ascontiguousarray(raw).view(number)
    if predictor == HORIZONTAL:
        return np.cumsum(values, axis=1, dtype=number.newbyteorder("="))
    return values
