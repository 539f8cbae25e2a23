"""Ground from outside: height files of many formats, and the elevation model in ``sim/data``.

One path for all formats: a reader (``readers``) answers with what the file holds and says, then
heights are taken for what they are (NODATA, flip, step, scale), placed (cell, origin, crop),
brought to the walker (offset) and checked. Whatever was decided on the way is told in one line.
Whatever a file says about itself is checked against the limits before its data is read, and every
refusal is one line.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import resources
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.robot.toml_files import is_file
from walking_console.planner.types import Array

from .generators import (
    CELL_MAX,
    CELL_MIN,
    SMOOTH_CELL,
    Dem,
    FileTerrain,
    GroundError,
    HeightsTerrain,
    MapTerrain,
    Site,
    quarter_direction,
)
from .readers import READERS, Raster
from .readers.raster import Heights
from .wide_map import WHOLE_CELLS_MAX, WIDE_CELLS_MAX

Mask = NDArray[np.bool_]

FINE = 0.01  # m; of smaller cells too many lie near a machine for a map that is not held whole
BAND = 256  # rows that are looked at together; more: large files take much memory
RESAMPLED_MAX = 16_000_000  # cells a map of unequal cells may be interpolated to
HEIGHT_MAX = 10.0  # m from 0; beyond it heights are above some sea, and are brought to the start
RELIEF_MAX = 100.0  # m from the start; more is no ground for a walker
NEAR = 64  # cells about the start in which ground is looked for first
DEFAULT_CELL = 0.05  # m
EQUAL = 1e-6  # of a side, by which the sides of a square cell may differ: rounding, far from 0
DEGREE = 111_195.0  # m of a great circle
WINDOW = 25.0  # m around the start that is kept of a map with cells of more than ``CELL_MAX``
WINDOW_CELL = 0.05  # m, what such a map is interpolated to
NODATA_USUAL = (
    -9999.0,
    9999.0,
    -99999.0,
    -32768.0,
    -32767.0,
    32767.0,
    65535.0,
    -3.4028234663852886e38,
)


class FileGround(NamedTuple):
    """What a height file came to."""

    heights: Heights  # (ny, nx) m, row of least y first
    cell: float  # m
    origin: tuple[float, float]  # x, y of the corner of cell [0, 0], m
    note: str  # one line that says what was understood
    parts: int = 1  # that a cell is to be cut into a side, interpolated (``Smoothed``)


@dataclass(frozen=True, eq=False)
class _Map:
    """Heights on their way from a file to the walker."""

    heights: Heights
    cell: tuple[float, float]
    origin: tuple[float, float] | None = None
    said: tuple[str, ...] = field(default=())
    parts: int = 1  # that a cell is to be cut into a side

    def saying(self, what: str) -> _Map:
        """The same with one more thing to be told."""
        return replace(self, said=(*self.said, what))


def read_heights(
    terrain: FileTerrain,
    base: Path | None,
    start: tuple[float, float] = (0.0, 0.0),
    stand: Sequence[tuple[float, float]] = (),
) -> FileGround:
    """Heights, cell, origin and a line about them, of a height file. ``start`` and the feet that
    ``stand`` there, x, y m, should find ground. Raises ``GroundError``.
    """
    path = (base or Path()) / terrain.file
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise GroundError(
            f"terrain file {terrain.file!r} must end in one of: {', '.join(sorted(READERS))}"
        )
    if not is_file(path):
        raise GroundError(f"terrain file {terrain.file!r} does not exist, or is not a file")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            raster = reader(path)
            if raster.surface is not None:
                raster = raster.surface(terrain.scale, _mesh_cell(terrain), terrain.up)
        return _understood(terrain, raster, (start, *stand))
    except GroundError as error:
        raise GroundError(f"terrain file {terrain.file!r}: {error}") from None
    # broken files raise whatever the decoders underneath happen to: struct, zlib, tokenize ...
    except Exception as error:
        reason = " ".join(str(error).split())[:200]
        raise GroundError(
            f"terrain file {terrain.file!r} cannot be read: {reason or type(error).__name__}"
        ) from None


def given_heights(
    terrain: HeightsTerrain,
    start: tuple[float, float] = (0.0, 0.0),
    stand: Sequence[tuple[float, float]] = (),
) -> FileGround:
    """The same of heights that the scenario holds itself; raises ``GroundError``."""
    rows = [[math.nan if cell == "hole" else cell for cell in row] for row in terrain.rows]
    raster = Raster(np.array(rows, dtype=np.float64)[::-1], "heights of the scenario")
    try:
        return _understood(terrain, raster, (start, *stand))
    except GroundError as error:
        raise GroundError(f"terrain.rows: {error}") from None


def _mesh_cell(terrain: FileTerrain) -> float:
    if isinstance(terrain.cell, list):
        return min(terrain.cell)
    return min(terrain.cell or SMOOTH_CELL, CELL_MAX)


def _understood(
    terrain: MapTerrain, raster: Raster, places: Sequence[tuple[float, float]]
) -> FileGround:
    """``places``: the start, and the feet there."""
    start = places[0]
    if raster.heights.ndim != 2 or min(raster.heights.shape) < 2:
        raise GroundError(
            f"heights must be (ny, nx) with at least 2 x 2 cells, got shape {raster.heights.shape}"
        )
    ny, nx = raster.heights.shape
    found = _Map(_values(terrain, raster), _cell_of(terrain, raster), _own_origin(terrain, raster))
    found = found.saying(f"{raster.what}, {nx} x {ny} of {_size(found.cell)}")
    found = _stepped(_without_nodata(terrain, raster, found), terrain.step)
    found = _cropped(_at(found, places, terrain.origin is not None), terrain.crop)
    found = _thinned(_square(found, start))
    heights = _brought_to_start(terrain, found, start)
    _check_heights(heights.heights, terrain)
    if terrain.smooth and heights.cell[0] > SMOOTH_CELL:
        heights = _smoothed(heights)
    if heights.origin is None:
        raise AssertionError("a map is placed before it is cropped")
    said = ", ".join(heights.said)
    return FileGround(heights.heights, heights.cell[0], heights.origin, said, heights.parts)


def _size(cell: tuple[float, float]) -> str:
    x, y = (f"{side:g}" for side in cell)
    return f"{x} m" if x == y else f"{x} x {y} m"


def _values(terrain: MapTerrain, raster: Raster) -> Heights:
    """Heights in the walker's directions: the row of least y first."""
    heights = raster.heights
    if terrain.flip in ("x", "xy"):
        heights = heights[:, ::-1]
    if terrain.flip in ("y", "xy"):
        heights = heights[::-1]
    return heights


def _cell_of(terrain: MapTerrain, raster: Raster) -> tuple[float, float]:
    """The size of a cell along x and y, m: the scenario's, else the file's own, else 0.05."""
    if isinstance(terrain.cell, list):
        return terrain.cell[0], terrain.cell[1]
    if terrain.cell is not None:
        return terrain.cell, terrain.cell
    if raster.cell is None:
        return DEFAULT_CELL, DEFAULT_CELL
    if raster.latitude is not None:
        raise GroundError(
            f"its cells are degrees of longitude and latitude ({raster.cell[0]:g} x "
            f"{raster.cell[1]:g}): set cell in metres{_in_metres(raster.cell, raster.latitude)}"
        )
    if min(raster.cell) < CELL_MIN:
        raise GroundError(
            f"its cells are {_size(raster.cell)}; at least {CELL_MIN:g} m: set cell in metres"
        )
    return raster.cell


def _in_metres(cell: tuple[float, float], latitude: float) -> str:
    """What degrees of longitude and latitude are on the ground, within 1 %; nothing where the file
    lies at no latitude on earth.
    """
    if not abs(latitude) < 90.0:
        return ""
    x = cell[0] * DEGREE * math.cos(math.radians(latitude))
    y = cell[1] * DEGREE
    return f"; at latitude {latitude:.4g} that is cell = [{x:.4g}, {y:.4g}]"


def _own_origin(terrain: MapTerrain, raster: Raster) -> tuple[float, float] | None:
    if terrain.origin is not None:
        return terrain.origin[0], terrain.origin[1]
    return raster.origin


def _without_nodata(terrain: MapTerrain, raster: Raster, found: _Map) -> _Map:
    """Heights that stand for nothing are NaN; they must be holes by the scenario's word."""
    nothing = raster.nodata if terrain.nodata is None else (terrain.nodata,)
    missing: Mask = np.zeros(found.heights.shape, dtype=np.bool_)
    for value in nothing:
        for first in range(0, len(missing), BAND):
            some = slice(first, first + BAND)
            missing[some] |= np.isclose(found.heights[some], value, rtol=1e-6, atol=0.0)
    scale = 1.0 if raster.scaled else terrain.scale
    heights = np.where(missing, np.nan, found.heights) * scale
    if missing.any() and terrain.nan != "hole":
        row, column = np.argwhere(missing)[0]
        raise GroundError(
            f"cell [{row}, {column}] has no height (NODATA {nothing[0]:g}; {int(missing.sum())}"
            ' such); set nan = "hole" if these are holes without a bottom'
        )
    _refuse_hidden_nodata(found.heights, missing)
    said = (f"{int(missing.sum())} NODATA as holes",) if missing.any() else ()
    return replace(found, heights=heights, said=(*found.said, *said))


def _refuse_hidden_nodata(heights: Heights, missing: Mask) -> None:
    """A few cells of a usual NODATA value far from all others are no ground, whoever forgot to
    say.
    """
    for value in NODATA_USUAL:
        suspects = (heights == value) & ~missing
        if not suspects.any() or suspects.all():
            continue
        others = heights[~suspects & np.isfinite(heights) & ~missing]
        if others.size and np.abs(others - value).min() > 100.0:
            row, column = np.argwhere(suspects)[0]
            raise GroundError(
                f"height of cell [{row}, {column}] is {value:g}: looks like NODATA "
                f'({int(suspects.sum())} such); set nodata = {value:g} and nan = "hole"'
            )


def _stepped(found: _Map, step: int) -> _Map:
    if step == 1:
        return found
    heights = found.heights[::step, ::step]
    cell = found.cell[0] * step, found.cell[1] * step
    return replace(found, heights=heights, cell=cell).saying(f"one cell in {step} taken")


def _at(found: _Map, places: Sequence[tuple[float, float]], kept: bool) -> _Map:
    """The map with a place: its own if that is ``kept`` or has ground at all these places, else its
    middle lies at the origin.
    """
    own = found.origin
    if own is not None and (kept or all(_holds(found, own, place) for place in places)):
        return found
    ny, nx = found.heights.shape
    return replace(found, origin=(-(nx // 2) * found.cell[0], -(ny // 2) * found.cell[1]))


def _holds(found: _Map, origin: tuple[float, float], at: tuple[float, float]) -> bool:
    ny, nx = found.heights.shape
    x, y = at[0] - origin[0], at[1] - origin[1]
    return bool(0.0 <= x <= nx * found.cell[0] and 0.0 <= y <= ny * found.cell[1])


def _cropped(found: _Map, crop: list[float] | None) -> _Map:
    """Only x_min to x_max and y_min to y_max, m."""
    if crop is None or found.origin is None:
        return found
    (ny, nx), (dx, dy) = found.heights.shape, found.cell
    x_min, x_max, y_min, y_max = crop
    first = max(0, math.floor((x_min - found.origin[0]) / dx + 1e-9))
    last = min(nx, math.ceil((x_max - found.origin[0]) / dx - 1e-9))
    bottom = max(0, math.floor((y_min - found.origin[1]) / dy + 1e-9))
    top = min(ny, math.ceil((y_max - found.origin[1]) / dy - 1e-9))
    if last - first < 2 or top - bottom < 2:
        x, y = found.origin
        raise GroundError(
            f"crop {crop} leaves no ground: the map reaches from x {x:g} to {x + nx * dx:g}, "
            f"y {y:g} to {y + ny * dy:g} m"
        )
    origin = found.origin[0] + first * dx, found.origin[1] + bottom * dy
    cut = replace(found, heights=found.heights[bottom:top, first:last], origin=origin)
    return cut.saying(f"{last - first} x {top - bottom} of them kept")


def _square(found: _Map, start: tuple[float, float]) -> _Map:
    """Square cells a walker can use: unequal ones interpolated, large ones around the start."""
    dx, dy = found.cell
    if max(dx, dy) > CELL_MAX:
        return _window(found, start)
    if abs(dx - dy) <= EQUAL * max(dx, dy):
        return found
    cell = min(dx, dy)
    ny, nx = found.heights.shape
    counts = round(ny * dy / cell), round(nx * dx / cell)
    if counts[0] * counts[1] > RESAMPLED_MAX:
        raise GroundError(
            f"square cells of {cell:g} m would be {counts[1]} x {counts[0]}: set step"
        )
    heights = _resampled(found, cell, counts, found.origin or (0.0, 0.0))
    square = replace(found, heights=heights, cell=(cell, cell))
    return square.saying(f"interpolated to square cells of {cell:g} m")


def _window(found: _Map, start: tuple[float, float]) -> _Map:
    """Ground at its true size around the start, interpolated between cells of many metres."""
    origin = start[0] - WINDOW, start[1] - WINDOW
    count = round(2 * WINDOW / WINDOW_CELL)
    if found.origin is None or not _holds(found, found.origin, start):
        raise GroundError(f"its cells are {_size(found.cell)}, and the start is not on the map")
    heights = _resampled(found, WINDOW_CELL, (count, count), origin)
    near = replace(found, heights=heights, cell=(WINDOW_CELL, WINDOW_CELL), origin=origin)
    return near.saying(
        f"{2 * WINDOW:g} x {2 * WINDOW:g} m around the start interpolated to {WINDOW_CELL:g} m"
    )


def _resampled(
    found: _Map, cell: float, counts: tuple[int, int], origin: tuple[float, float]
) -> Array:
    own = found.origin or (0.0, 0.0)
    y = origin[1] + (np.arange(counts[0]) + 0.5) * cell
    x = origin[0] + (np.arange(counts[1]) + 0.5) * cell
    rows = np.asarray((y - own[1]) / found.cell[1] - 0.5, dtype=np.float64)
    columns = np.asarray((x - own[0]) / found.cell[0] - 0.5, dtype=np.float64)
    return _between_holes(found.heights, rows, columns)


def _thinned(found: _Map) -> _Map:
    """At most as many cells as a wide map may have; as one held whole, where they are fine."""
    ny, nx = found.heights.shape
    most = WIDE_CELLS_MAX if found.cell[0] >= FINE else WHOLE_CELLS_MAX
    if ny * nx <= most:
        return found
    step = math.ceil(math.sqrt(ny * nx / most))
    cell = found.cell[0] * step
    if cell > CELL_MAX:
        raise GroundError(
            f"{nx} x {ny} cells of {_size(found.cell)}; at most {most} of {CELL_MAX:g} m can"
            " be walked on: set crop"
        )
    thin = replace(found, heights=found.heights[::step, ::step], cell=(cell, cell))
    return thin.saying(f"thinned to one cell in {step} ({most} at most)")


def _brought_to_start(terrain: MapTerrain, found: _Map, start: tuple[float, float]) -> _Map:
    """Heights from where the walker stands: what is taken off is the scenario's word, or the height
    of the start where heights are above some sea."""
    heights = found.heights
    finite = np.isfinite(heights)
    if not finite.any():
        raise GroundError("every cell is a hole; there is no ground to stand on")
    offset = terrain.offset
    if offset is None:
        if float(np.abs(heights[finite]).max()) <= HEIGHT_MAX:
            return found
        offset = "start"
    if offset == "min":
        taken = float(heights[finite].min())
    elif offset == "start":
        taken = _height_near(found, start)
    else:
        taken = float(offset)
    return replace(found, heights=heights - taken).saying(f"{taken:g} m taken off")


def _height_near(found: _Map, at: tuple[float, float]) -> float:
    """The height of the cell that contains a place, or of the nearest one that has ground."""
    origin = found.origin or (0.0, 0.0)
    column = math.floor((at[0] - origin[0]) / found.cell[0])
    row = math.floor((at[1] - origin[1]) / found.cell[1])
    ny, nx = found.heights.shape
    near = NEAR
    while True:
        # the nearest in a square is the nearest of all when it is no farther than its sides
        first_row, first_column = max(0, row - near), max(0, column - near)
        square = found.heights[
            first_row : max(0, row + near + 1), first_column : max(0, column + near + 1)
        ]
        rows, columns = np.nonzero(np.isfinite(square))
        away = (rows + first_row - row) ** 2 + (columns + first_column - column) ** 2
        if rows.size and (away.min() <= near**2 or square.size == ny * nx):
            nearest = int(np.argmin(away))
            return float(square[rows[nearest], columns[nearest]])
        near *= 2


def _check_heights(heights: Heights, terrain: MapTerrain) -> None:
    """Refuse what is no ground, naming the first cell at fault as [row, column]."""
    for bad, says in (
        (np.isinf(heights), "is infinite"),
        (
            np.isnan(heights) & (terrain.nan != "hole"),
            'is NaN; set nan = "hole" if it is a hole without a bottom',
        ),
        (
            abs(heights) > RELIEF_MAX,
            f"is more than {RELIEF_MAX:g} m from 0: set offset, nodata, scale or crop",
        ),
    ):
        if bad.any():
            row, column = np.argwhere(bad)[0]
            raise GroundError(
                f"height of cell [{row}, {column}] {says} "
                f"({heights[row, column]:g}; {int(bad.sum())} such)"
            )


def _smoothed(found: _Map) -> _Map:
    """The same map in cells of at most 0.025 m, straight lines between the old cells' centres;
    holes stay holes. What is too much to be held whole is interpolated where it is wanted.
    """
    cell = found.cell[0]
    parts = math.ceil(cell / SMOOTH_CELL - 1e-9)
    ny, nx = found.heights.shape
    if ny * nx * parts * parts > WIDE_CELLS_MAX:
        raise GroundError(
            f"smooth = true would make {ny * parts} x {nx * parts} cells; at most "
            f"{WIDE_CELLS_MAX}: set crop"
        )
    said = found.saying(f"interpolated to {cell / parts:g} m")
    if ny * nx * parts * parts > WHOLE_CELLS_MAX:
        return replace(said, parts=parts)
    heights = Smoothed(found.heights, parts)(slice(0, ny * parts), slice(0, nx * parts))
    return replace(said, heights=heights, cell=(cell / parts, cell / parts))


@dataclass(frozen=True, eq=False)
class Smoothed:
    """Heights interpolated wherever they are asked for, every cell cut into ``parts`` a side."""

    heights: Heights
    parts: int

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the finer map."""
        ny, nx = self.heights.shape
        return ny * self.parts, nx * self.parts

    def __call__(self, rows: slice, columns: slice) -> Array:
        """Every slice has a start and a stop on the finer map."""
        ny, nx = self.heights.shape
        first_row, last_row, at_rows = self._around(rows, ny)
        first_column, last_column, at_columns = self._around(columns, nx)
        part = self.heights[first_row:last_row, first_column:last_column]
        return _between_holes(part, at_rows, at_columns)

    def _around(self, side: slice, size: int) -> tuple[int, int, Array]:
        """The cells about some cells of the finer map, and where among them those are."""
        places = (np.arange(side.start, side.stop, side.step) + 0.5) / self.parts - 0.5
        first = min(max(0, math.floor(places[0])), size - 2)
        last = min(max(math.floor(places[-1]) + 2, first + 2), size)
        return first, last, np.asarray(places - first, dtype=np.float64)


def _between_holes(grid: Heights, rows: Array, columns: Array) -> Array:
    """Bilinear interpolation between the cells that have ground; a place in a hole's cell is
    hole.
    """
    holes = np.isnan(grid)
    if not holes.any():
        return _between(grid, rows, columns)
    solid = _between(np.where(holes, 0.0, 1.0), rows, columns)
    weighted = _between(np.where(holes, 0.0, grid), rows, columns)
    with np.errstate(invalid="ignore", divide="ignore"):
        heights = weighted / solid
    nearest_rows = np.clip(np.rint(rows), 0, grid.shape[0] - 1).astype(int)
    nearest_columns = np.clip(np.rint(columns), 0, grid.shape[1] - 1).astype(int)
    heights[holes[nearest_rows][:, nearest_columns]] = np.nan
    return np.asarray(heights)


def _between(grid: Heights, rows: Array, columns: Array) -> Array:
    """Bilinear interpolation of ``grid`` at every (row, column) of two axes, held constant beyond
    the edges.
    """
    r, c = np.clip(rows, 0, grid.shape[0] - 1), np.clip(columns, 0, grid.shape[1] - 1)
    r0 = np.minimum(r.astype(int), grid.shape[0] - 2)
    c0 = np.minimum(c.astype(int), grid.shape[1] - 2)
    fr, fc = (r - r0)[:, np.newaxis], (c - c0)[np.newaxis, :]
    near = grid[r0][:, c0] * (1 - fc) + grid[r0][:, c0 + 1] * fc
    far = grid[r0 + 1][:, c0] * (1 - fc) + grid[r0 + 1][:, c0 + 1] * fc
    return np.asarray(near * (1 - fr) + far * fr)


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
    c, s = quarter_direction(terrain.heading_deg)
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
