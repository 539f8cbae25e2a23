"""Arrays of numpy: .npy, and .npz with heights and perhaps their cell and origin.

A header is checked before the data behind it is read; nothing is unpickled. Rows are y: the first
row is the least y, as in the ``terrain.npz`` of a run.
"""

from __future__ import annotations

import math
import os
import warnings
import zipfile
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy

from ..generators import CELL_MIN, GroundError
from ..wide_map import WIDE_CELLS_MAX
from .raster import Raster, as_heights
from .tables import NARROW, points_of

HEADER_MAX = 4096  # bytes of an .npy header
MEMBERS_MAX = 16  # of an .npz
MEMBER_BYTES_MAX = 8 * WIDE_CELLS_MAX + 2 * HEADER_MAX
NUMBER_KINDS = "fiu"  # of numpy: floating-point, whole, whole from 0 on
HEIGHTS_NAMES = (
    "heights_exact", "heights", "height", "elevation", "z", "dem", "dtm", "terrain", "topo",
    "arr_0",
)  # fmt: skip
CELL_NAMES = ("cell", "cell_size", "cellsize", "resolution", "res", "spacing")
X_NAMES = ("x", "xs", "lon", "longitude")
Y_NAMES = ("y", "ys", "lat", "latitude")
Members = dict[str, zipfile.ZipInfo]
PLACE_MAX = 1e7  # m; a corner farther away is no place


def read_npy(path: Path) -> Raster:
    """One array of numbers (ny, nx)."""
    with path.open("rb") as file:
        heights = _array(file, os.fstat(file.fileno()).st_size)
    return _raster(heights, None)


def _raster(
    array: Any,
    cell: tuple[float, float] | None,
    origin: tuple[float, float] | None = None,
    latitude: float | None = None,
) -> Raster:
    """Heights (ny, nx); three columns and many rows are points, as in a table."""
    heights = as_heights(array)
    if cell is None and heights.shape[-1] == 3 and len(heights) >= NARROW:
        return points_of(np.asarray(heights, dtype=np.float64))
    return Raster(heights, f"{array.dtype} array", cell, origin, latitude=latitude)


def read_npz(path: Path) -> Raster:
    """An archive with ``heights`` (``heights_exact`` wins) or another array of two axes, and
    perhaps ``cell`` and ``origin``, or ``x`` and ``y`` of its columns and rows.
    """
    with zipfile.ZipFile(path) as archive:
        if len(archive.infolist()) > MEMBERS_MAX:
            raise GroundError(f"{len(archive.infolist())} members; at most {MEMBERS_MAX}")
        members = {
            info.filename.removesuffix(".npy").lower(): info
            for info in archive.infolist()
            if info.filename.endswith(".npy")
        }
        heights = _member(archive, members[_name_of_heights(archive, members)])
        known = (*CELL_NAMES, *X_NAMES, *Y_NAMES, "dx", "dy", "origin", "ymin")
        small = {name: _small(archive, members[name]) for name in known if name in members}
    heights = _along_axes(heights, small)
    cell = _cell_of(small)
    southwards = _runs_down(next((small[name] for name in Y_NAMES if name in small), None))
    origin = _checked_origin(small.get("origin"))
    return _raster(heights[:: -1 if southwards else 1], cell, origin, _latitude(small, cell))


def _along_axes(heights: Any, small: dict[str, Any]) -> Any:
    """Heights with rows along y; x and y of every cell become those of columns and rows."""
    x, y = (next((n for n in names if n in small), "") for names in (X_NAMES, Y_NAMES))
    places = small.get(x), small.get(y)
    if any(place is None or place.ndim != 2 or place.shape != heights.shape for place in places):
        return heights
    if (small[x][0] == small[x][-1]).all():
        small[x], small[y] = small[x][0], small[y][:, 0]
        return heights
    small[x], small[y] = small[x][:, 0], small[y][0]
    return heights.T


def _name_of_heights(archive: zipfile.ZipFile, members: Members) -> str:
    """The array with a usual name for heights, else the only one of two axes."""
    grids = _grids(archive, members)
    usual = [name for name in HEIGHTS_NAMES if name in (grids or members)]
    if usual or len(grids) == 1:
        return (usual or grids)[0]
    there = ", ".join(sorted(name[:40] for name in grids or members)) or "nothing"
    if grids:
        raise GroundError(f"several grids in it and no 'heights': {there}; name one of them so")
    raise GroundError(f"there is no 'heights' in it, only {there}")


def _grids(archive: zipfile.ZipFile, members: Members) -> list[str]:
    """The arrays of two axes that may be heights, not the places of them."""
    places = (*X_NAMES, *Y_NAMES)
    return [
        name for name, info in members.items() if name not in places and _axes(archive, info) == 2
    ]


def _axes(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> int:
    """How many axes of more than one an array has, from its header; 0 of what is no numbers."""
    _check_member(info)
    with archive.open(info) as file:
        shape, dtype = _header(file)
    return len(_squeezed(shape)) if dtype.kind in NUMBER_KINDS else 0


def _small(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Any:
    """An array that says something about the heights; None where it is no numbers."""
    return _member(archive, info) if _axes(archive, info) <= 2 else None


def _cell_of(small: dict[str, Any]) -> tuple[float, float] | None:
    """Size of a cell: said as one number, as two, or by where columns and rows are."""
    for name in CELL_NAMES:
        if small.get(name) is not None:
            side = _checked_cell(small[name])
            return side, side
    if small.get("dx") is not None and small.get("dy") is not None:
        return _number(small["dx"]), _number(small["dy"])
    x = next((name for name in X_NAMES if small.get(name) is not None), None)
    y = next((name for name in Y_NAMES if small.get(name) is not None), None)
    return None if x is None or y is None else (_step(small[x], x), _step(small[y], y))


def _step(places: Any, name: str) -> float:
    """The step between places, even or, of degrees, in the mean; above 0, or refused."""
    steps = np.abs(np.diff(np.asarray(places, dtype=np.float64).ravel()))
    even = len(steps) and steps.min() > 0.0 and np.ptp(steps) <= 1e-3 * steps[0]
    if not even and not (name.startswith(("lon", "lat")) and len(steps) and steps.mean() > 0.0):
        raise GroundError(f"its columns and rows are not evenly spaced ({name})")
    return float(steps[0] if even else steps.mean())


def _runs_down(places: Any) -> bool:
    """True when the first row is the largest y."""
    return places is not None and places.size > 1 and bool(places.flat[0] > places.flat[-1])


def _number(value: Any) -> float:
    return abs(float(value.item())) if value.size == 1 else math.nan


def _latitude(small: dict[str, Any], cell: tuple[float, float] | None) -> float | None:
    """Where the cells are degrees: by the names of what is there, or too small for metres."""
    for name in ("lat", "latitude", "ymin"):
        value = small.get(name)
        if cell is not None and value is not None and (name != "ymin" or cell[0] < CELL_MIN):
            return float(np.mean(value))
    return None


def _header(file: IO[bytes]) -> tuple[tuple[int, ...], Any]:
    """Shape and number type that an .npy stream says."""
    version = npy.read_magic(file)
    readers = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
    read_header = readers.get(version)
    if read_header is None:
        raise GroundError(f"unknown .npy version {version[0]}.{version[1]}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of files that Python 2 has written
        shape, _, dtype = read_header(file, max_header_size=HEADER_MAX)
    return tuple(shape), dtype


def _squeezed(shape: tuple[int, ...]) -> tuple[int, ...]:
    """A shape without axes of one place, where it has more than two."""
    return shape if len(shape) <= 2 else tuple(n for n in shape if n != 1)


def _array(file: IO[bytes], size: int) -> Any:
    """One .npy stream of ``size`` bytes: kind, shape and length are checked from its header."""
    shape, dtype = _header(file)
    if dtype.hasobject or dtype.kind not in NUMBER_KINDS:
        raise GroundError(f"numbers wanted, got {dtype}")
    count = math.prod(shape)
    if len(_squeezed(shape)) > 2 or count > WIDE_CELLS_MAX or any(n < 1 for n in shape):
        raise GroundError(
            f"heights must be (ny, nx) with at most {WIDE_CELLS_MAX} cells, "
            f"got shape {tuple(shape)}"
        )
    if size < file.tell() + count * dtype.itemsize:
        raise GroundError(f"the file ends before its {count} numbers do")
    file.seek(0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        array = npy.read_array(file, allow_pickle=False, max_header_size=HEADER_MAX)
    return array.reshape(_squeezed(shape))


def _member(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Any:
    """One array of an archive."""
    _check_member(info)
    with archive.open(info) as file:
        return _array(file, info.file_size)


def _check_member(info: zipfile.ZipInfo) -> None:
    """Refuse what says it is larger than any allowed map, before it is unpacked."""
    if info.file_size > MEMBER_BYTES_MAX:
        raise GroundError(
            f"{info.filename!r} unpacks to {info.file_size} bytes; at most {MEMBER_BYTES_MAX}"
        )
    if info.flag_bits & 0x1:
        raise GroundError(f"{info.filename!r} is encrypted")


def _checked_cell(cell: Any) -> float:
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
