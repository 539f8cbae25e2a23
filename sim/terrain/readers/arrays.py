"""Arrays of numpy: .npy, and .npz with ``heights`` and perhaps ``cell`` and ``origin``.

A header is checked before the data behind it is read; nothing is unpickled. Rows are y: the first
row is the least y, as in the ``terrain.npz`` of a run.
"""

from __future__ import annotations

import math
import os
import zipfile
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy

from walking_console.planner.types import Array

from ..generators import CELL_MIN, GroundError
from .raster import CELLS_MAX, Raster

HEADER_MAX = 4096  # bytes of an .npy header
MEMBERS_MAX = 16  # of an .npz
MEMBER_BYTES_MAX = 8 * CELLS_MAX + 2 * HEADER_MAX
PLACE_MAX = 1e7  # m; a corner farther away is no place


def read_npy(path: Path) -> Raster:
    """One array of numbers (ny, nx)."""
    with path.open("rb") as file:
        heights = _array(file, os.fstat(file.fileno()).st_size)
    return Raster(_as_heights(heights), f"{heights.dtype} array")


def read_npz(path: Path) -> Raster:
    """An archive with ``heights``; ``heights_exact`` wins, ``cell`` and ``origin`` are taken."""
    with zipfile.ZipFile(path) as archive:
        members = {info.filename: info for info in archive.infolist()}
        if len(archive.infolist()) > MEMBERS_MAX:
            raise GroundError(f"{len(archive.infolist())} members; at most {MEMBERS_MAX}")
        if "heights.npy" not in members:
            names = sorted(name.removesuffix(".npy")[:40] for name in members)
            raise GroundError(f"there is no 'heights' in it, only {', '.join(names) or 'nothing'}")
        exact = members.get("heights_exact.npy", members["heights.npy"])
        heights = _member(archive, exact)
        cell = _member(archive, members["cell.npy"]) if "cell.npy" in members else None
        origin = _member(archive, members["origin.npy"]) if "origin.npy" in members else None
    side = _checked_cell(cell)
    return Raster(
        _as_heights(heights),
        f"{heights.dtype} array",
        None if side is None else (side, side),
        _checked_origin(origin),
    )


def _as_heights(array: Array) -> Array:
    return np.asarray(array, dtype=np.float64)


def _array(file: IO[bytes], size: int) -> Any:
    """One .npy stream of ``size`` bytes: kind, shape and length are checked from its header."""
    version = npy.read_magic(file)
    readers = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
    read_header = readers.get(version)
    if read_header is None:
        raise GroundError(f"unknown .npy version {version[0]}.{version[1]}")
    shape, _, dtype = read_header(file, max_header_size=HEADER_MAX)
    if dtype.hasobject or dtype.kind not in "fiu":
        raise GroundError(f"numbers wanted, got {dtype}")
    count = math.prod(shape)
    if len(shape) > 2 or count > CELLS_MAX or any(n < 1 for n in shape):
        raise GroundError(
            f"heights must be (ny, nx) with at most {CELLS_MAX} cells, got shape {tuple(shape)}"
        )
    if size < file.tell() + count * dtype.itemsize:
        raise GroundError(f"the file ends before its {count} numbers do")
    file.seek(0)
    return npy.read_array(file, allow_pickle=False, max_header_size=HEADER_MAX)


def _member(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Any:
    """One array of an archive; one that says it is larger than any allowed map is not unpacked."""
    if info.file_size > MEMBER_BYTES_MAX:
        raise GroundError(
            f"{info.filename!r} unpacks to {info.file_size} bytes; at most {MEMBER_BYTES_MAX}"
        )
    if info.flag_bits & 0x1:
        raise GroundError(f"{info.filename!r} is encrypted")
    with archive.open(info) as file:
        return _array(file, info.file_size)


def _checked_cell(cell: Any) -> float | None:
    if cell is None:
        return None
    value = float(cell.item()) if cell.size == 1 else math.nan
    if not CELL_MIN <= value < math.inf:
        raise GroundError(f"cell must be one number of at least {CELL_MIN:g} m, got {cell!r:.60}")
    return value


def _checked_origin(origin: Any) -> tuple[float, float] | None:
    if origin is None:
        return None
    values = [float(v) for v in origin.ravel()] if origin.size == 2 else []
    if len(values) != 2 or not all(abs(v) <= PLACE_MAX for v in values):
        raise GroundError(f"origin must be x and y in m, got {origin!r:.60}")
    return values[0], values[1]
