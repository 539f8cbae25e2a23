"""Ground from outside: height files (.npy, .npz, .png) and the elevation model in ``sim/data``.

Whatever a file says about itself is checked against the limits before its data is read, and every
refusal is one line.
"""

from __future__ import annotations

import math
import os
import warnings
import zipfile
from functools import cache
from importlib import resources
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from PIL import Image

from walking_console.planner.robot.model import is_file

from .generators import (
    CELL_MAX,
    CELL_MIN,
    SMOOTH_CELL,
    Array,
    Dem,
    FileTerrain,
    GroundError,
    Site,
    _turn,
)

ARRAY_CELLS_MAX = 1_000_000
PICTURE_CELLS_MAX = 4_000_000
HEADER_MAX = 4096  # bytes of an .npy header
MEMBERS_MAX = 16  # of an .npz
MEMBER_BYTES_MAX = 8 * ARRAY_CELLS_MAX + 2 * HEADER_MAX
HEIGHT_MAX = 10.0  # m
DEFAULT_CELL = 0.05  # m
PICTURE_MODES = {"L": 255.0, "I;16": 65535.0}  # Pillow mode: level of white

Heights = tuple[Array, float, tuple[float, float]]


def read_heights(terrain: FileTerrain, base: Path | None) -> Heights:
    """Heights, cell and origin of a height file. Raises ``GroundError``."""
    path = (base or Path()) / terrain.file
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise GroundError(
            f"terrain file {terrain.file!r} must end in one of: {', '.join(sorted(_READERS))}"
        )
    if not is_file(path):
        raise GroundError(f"terrain file {terrain.file!r} does not exist, or is not a file")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            heights, cell, origin = reader(path)
    except GroundError as error:
        raise GroundError(f"terrain file {terrain.file!r}: {error}") from None
    # broken files raise whatever the decoders underneath happen to: struct, zlib, tokenize ...
    except Exception as error:
        reason = " ".join(str(error).split())[:200]
        raise GroundError(
            f"terrain file {terrain.file!r} cannot be read: {reason or type(error).__name__}"
        ) from None
    try:
        return _placed(terrain, heights * terrain.scale, cell, origin)
    except GroundError as error:
        raise GroundError(f"terrain file {terrain.file!r}: {error}") from None


def _placed(
    terrain: FileTerrain,
    heights: Array,
    own_cell: float | None,
    own_origin: tuple[float, float] | None,
) -> Heights:
    _check_heights(heights, terrain.nan == "hole")
    cell = (
        terrain.cell
        if terrain.cell is not None
        else own_cell
        if own_cell is not None
        else DEFAULT_CELL
    )
    ny, nx = heights.shape
    if terrain.origin is not None:
        origin = (terrain.origin[0], terrain.origin[1])
    else:
        origin = own_origin or (-(nx // 2) * cell, -(ny // 2) * cell)
    if terrain.smooth and cell > SMOOTH_CELL:
        heights, cell = _smoothed(heights, cell)
    return heights, cell, origin


def _check_heights(heights: Array, holes: bool) -> None:
    """Refuse what is no ground, naming the first cell at fault as [row, column]."""
    if heights.ndim != 2 or min(heights.shape) < 2:
        raise GroundError(
            f"heights must be (ny, nx) with at least 2 x 2 cells, got shape {heights.shape}"
        )
    for bad, says in (
        (np.isinf(heights), "is infinite"),
        (
            np.isnan(heights) & (not holes),
            'is NaN; set nan = "hole" if it is a hole without a bottom',
        ),
        (abs(heights) > HEIGHT_MAX, f"is more than {HEIGHT_MAX:g} m from 0"),
    ):
        if bad.any():
            row, column = np.argwhere(bad)[0]
            raise GroundError(f"height of cell [{row}, {column}] {says} ({int(bad.sum())} such)")
    if np.isnan(heights).all():
        raise GroundError("every cell is a hole; there is no ground to stand on")


def _smoothed(heights: Array, cell: float) -> tuple[Array, float]:
    """The same map in cells of at most 0.025 m, straight lines between the old cells' centres."""
    if np.isnan(heights).any():
        raise GroundError("smooth = true needs ground without holes")
    parts = math.ceil(cell / SMOOTH_CELL - 1e-9)
    ny, nx = heights.shape
    if ny * nx * parts * parts > PICTURE_CELLS_MAX:
        raise GroundError(
            f"smooth = true would make {ny * parts} x {nx * parts} cells; at most {PICTURE_CELLS_MAX}"
        )
    rows, columns = ((np.arange(n * parts) + 0.5) / parts - 0.5 for n in (ny, nx))
    return _between(heights, rows, columns), cell / parts


def _between(grid: Array, rows: Array, columns: Array) -> Array:
    """Bilinear interpolation of ``grid`` at every (row, column) of two axes, held constant beyond
    the edges.
    """
    r, c = np.clip(rows, 0, grid.shape[0] - 1), np.clip(columns, 0, grid.shape[1] - 1)
    r0, c0 = (
        np.minimum(r.astype(int), grid.shape[0] - 2),
        np.minimum(c.astype(int), grid.shape[1] - 2),
    )
    fr, fc = (r - r0)[:, np.newaxis], (c - c0)[np.newaxis, :]
    near = grid[r0][:, c0] * (1 - fc) + grid[r0][:, c0 + 1] * fc
    far = grid[r0 + 1][:, c0] * (1 - fc) + grid[r0 + 1][:, c0 + 1] * fc
    return np.asarray(near * (1 - fr) + far * fr)


def _read_npy(path: Path) -> tuple[Array, float | None, tuple[float, float] | None]:
    with path.open("rb") as file:
        return _array(file, os.fstat(file.fileno()).st_size).astype(np.float64), None, None


def _array(file: IO[bytes], size: int) -> Array:
    """One .npy stream of ``size`` bytes: kind, shape and length are checked from its header before
    data is read.
    """
    version = npy.read_magic(file)
    read_header = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}.get(
        version
    )
    if read_header is None:
        raise GroundError(f"unknown .npy version {version[0]}.{version[1]}")
    shape, _, dtype = read_header(file, max_header_size=HEADER_MAX)
    if dtype.hasobject or dtype.kind not in "fiu":
        raise GroundError(f"numbers wanted, got {dtype}")
    count = math.prod(shape)
    if len(shape) > 2 or count > ARRAY_CELLS_MAX or any(n < 1 for n in shape):
        raise GroundError(
            f"heights must be (ny, nx) with at most {ARRAY_CELLS_MAX} cells, got shape {tuple(shape)}"
        )
    if size < file.tell() + count * dtype.itemsize:
        raise GroundError(f"the file ends before its {count} numbers do")
    file.seek(0)
    return np.asarray(npy.read_array(file, allow_pickle=False, max_header_size=HEADER_MAX))


def _read_npz(path: Path) -> tuple[Array, float | None, tuple[float, float] | None]:
    with zipfile.ZipFile(path) as archive:
        members = {info.filename: info for info in archive.infolist()}
        if len(archive.infolist()) > MEMBERS_MAX:
            raise GroundError(f"{len(archive.infolist())} members; at most {MEMBERS_MAX}")
        if "heights.npy" not in members:
            known = (
                ", ".join(sorted(name.removesuffix(".npy")[:40] for name in members)) or "nothing"
            )
            raise GroundError(f"there is no 'heights' in it, only {known}")
        heights = _member(archive, members["heights.npy"])
        cell = _member(archive, members["cell.npy"]) if "cell.npy" in members else None
        origin = _member(archive, members["origin.npy"]) if "origin.npy" in members else None
    return heights.astype(np.float64), _checked_cell(cell), _checked_origin(origin)


def _member(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Array:
    """One array of an archive; a member that says it is larger than any allowed map is not
    unpacked.
    """
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
    value = float(cell) if cell.size == 1 else math.nan
    if not CELL_MIN <= value <= CELL_MAX:
        raise GroundError(
            f"cell must be one number between {CELL_MIN:g} and {CELL_MAX:g} m, got {cell!r:.60}"
        )
    return value


def _checked_origin(origin: Any) -> tuple[float, float] | None:
    if origin is None:
        return None
    values = [float(v) for v in origin.ravel()] if origin.size == 2 else []
    if len(values) != 2 or not all(abs(v) <= 1000.0 for v in values):
        raise GroundError(f"origin must be x and y within 1000 m, got {origin!r:.60}")
    return values[0], values[1]


def _read_png(path: Path) -> tuple[Array, float | None, tuple[float, float] | None]:
    """Grey levels as parts of white; the size is checked before a pixel is decoded."""
    with Image.open(path, formats=["PNG"]) as picture:
        width, height = picture.size
        if width * height > PICTURE_CELLS_MAX:
            raise GroundError(f"{width} x {height} pixels; at most {PICTURE_CELLS_MAX}")
        if picture.mode not in PICTURE_MODES:
            raise GroundError(
                f"a grey picture of 8 or 16 bits is wanted (mode {' or '.join(PICTURE_MODES)}), got mode {picture.mode}"
            )
        levels = np.asarray(picture, dtype=np.float64)
        return levels / PICTURE_MODES[picture.mode], None, None


_READERS = {".npy": _read_npy, ".npz": _read_npz, ".png": _read_png}


@cache
def _elevation() -> tuple[Array, float, float]:
    """The elevation model, south row first: metres, and metres between its points eastwards and
    northwards.
    """
    with (
        (resources.files("walking_console.sim") / "data" / "jacksboro.npz").open("rb") as file,
        np.load(file, allow_pickle=False) as data,
    ):
        east, north = (float(v) for v in data["spacing"])
        return data["elevation"].astype(np.float64), east, north


def read_elevation(terrain: Dem, site: Site) -> Array:
    """The elevation model at walking scale on the site's cells, 0 at the origin; mirrored at its
    edges.
    """
    grid, east, north = _elevation()
    c, s = _turn(terrain.heading_deg)
    to_column, to_row = terrain.scale / east, terrain.scale / north
    columns = (terrain.offset[0] + c * site.x - s * site.y) * to_column
    rows = (terrain.offset[1] + s * site.x + c * site.y) * to_row
    here = _sampled(
        grid,
        np.full((1, 1), terrain.offset[1] * to_row),
        np.full((1, 1), terrain.offset[0] * to_column),
    )
    return (_sampled(grid, rows, columns) - here) / terrain.relief


def _sampled(grid: Array, rows: Array, columns: Array) -> Array:
    """Bilinear interpolation of a mirrored grid at fractional places; an axis-parallel map is
    interpolated axis by axis.
    """
    ny, nx = grid.shape
    r, c = _mirrored(rows, ny - 1), _mirrored(columns, nx - 1)
    if r.shape[1] == 1 and c.shape[0] == 1:
        return _between(grid, r.ravel(), c.ravel())
    r, c = np.broadcast_arrays(r, c)
    r0, c0 = np.minimum(r.astype(int), ny - 2), np.minimum(c.astype(int), nx - 2)
    fr, fc = r - r0, c - c0
    near = grid[r0, c0] * (1 - fc) + grid[r0, c0 + 1] * fc
    far = grid[r0 + 1, c0] * (1 - fc) + grid[r0 + 1, c0 + 1] * fc
    return np.asarray(near * (1 - fr) + far * fr)


def _mirrored(places: Array, last: int) -> Array:
    folded = np.mod(places, 2.0 * last)
    return np.minimum(folded, 2.0 * last - folded)
