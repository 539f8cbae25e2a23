"""Double precision packed by LZW and by the floating-point predictor."""

import io
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.sim.terrain.readers.files import HILL, ground

SIDE = 16  # rows and columns of a tile
ROWS = 5  # of a strip


def packed_by_lzw(data: bytes) -> bytes:
    """Bytes packed by Pillow: the strip of a grey picture of one row."""
    out = io.BytesIO()
    Image.frombytes("L", (len(data), 1), data).save(out, "TIFF", compression="tiff_lzw")
    with Image.open(out) as picture:
        offset, count = picture.tag_v2[273][0], picture.tag_v2[279][0]  # type: ignore[attr-defined]
    return out.getvalue()[offset : offset + count]


def floating(part: np.ndarray) -> bytes:
    """TIFF Technical Note 3: bytes by significance, each the difference to the one before."""
    big = part.astype(">f8").view(np.uint8).reshape(*part.shape, 8)
    planes = big.transpose(0, 2, 1).reshape(len(part), -1)
    return np.diff(planes, axis=1, prepend=np.uint8(0)).astype(np.uint8).tobytes()


def write(path: Path, values: np.ndarray, compression: int, predictor: int, tiled: bool) -> None:
    """A little-endian TIFF of doubles."""
    ny, nx = values.shape
    if tiled:
        padded = np.pad(values, ((0, -ny % SIDE), (0, -nx % SIDE)))
        parts = [row[:, k : k + SIDE] for row in np.split(padded, len(padded) // SIDE)
                 for k in range(0, padded.shape[1], SIDE)]  # fmt: skip
    else:
        parts = [values[k : k + ROWS] for k in range(0, ny, ROWS)]
    plain = [floating(part) if predictor == 3 else part.astype("<f8").tobytes() for part in parts]
    packed = [packed_by_lzw(data) if compression == 5 else zlib.compress(data) for data in plain]
    places = np.cumsum([8, *map(len, packed)])
    lists = int(places[-1])
    count = len(packed)
    sizes = [(322, SIDE), (323, SIDE)] if tiled else [(278, ROWS)]
    where, lengths = (324, 325) if tiled else (273, 279)
    pairs = [(256, nx), (257, ny), (258, 64), (259, compression), (262, 1), (277, 1)]
    pairs += [*sizes, (317, predictor), (339, 3)]
    entries = [(tag, 1, value) for tag, value in pairs]
    entries += [(where, count, lists), (lengths, count, lists + 4 * count)]
    table = b"".join(struct.pack("<HHII", tag, 4, n, value) for tag, n, value in sorted(entries))
    head = struct.pack("<2sHI", b"II", 42, lists + 8 * count)
    numbers = struct.pack(f"<{2 * count}I", *places[:-1], *map(len, packed))
    directory = struct.pack("<H", len(entries)) + table + bytes(4)
    path.write_bytes(head + b"".join(packed) + numbers + directory)


@pytest.mark.parametrize("tiled", [False, True])
@pytest.mark.parametrize("predictor", [1, 3])
@pytest.mark.parametrize("compression", [5, 8, 32946])
def test_doubles_packed_as_gdal_packs_them_load_to_the_last_bit(
    tmp_path: Path, compression: int, predictor: int, tiled: bool
) -> None:
    values = np.tile(HILL, (3, 3)) + 0.1
    write(tmp_path / "h.tif", values, compression, predictor, tiled)
    made = ground(tmp_path / "h.tif", cell=0.1)
    np.testing.assert_array_equal(made.heights, values[::-1])
