"""The ground as triangles in tiles, under a map-like texture.

Shape and picture are apart: the texture has the full resolution of the map, so forbidden cells and
small holes stay crisp where the triangles are thinned out. Stepped ground (stairs, rivers, blocks,
hole fields) keeps its exact edges.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from .gltf import Part, glb
from .terrain_texture import (
    ABYSS,
    CONTOUR,
    contours,
    height_colours,
    hill_shade,
    mark_forbidden,
    png,
)
from .types import Bools, Floats, Indices

TILES = 8  # tiles a side: an edited patch re-sends one of them
WIDE_TILE = 96  # cells a side of a tile of a window: what comes into it is drawn, the rest stays
QUADS_MAX = 200  # quads a side on smooth ground; more: joining takes seconds on a slow line
# exact steps up to here; more: drawn thinned out, with holes only painted
STEPPED_QUADS_MAX = 60_000
PIXELS_MAX = 2048  # a side, all tiles together
FINE_CELLS = 300  # cells a side below which a texture has several pixels a cell anyway
PIT = 0.5  # m, depth at which a bottomless hole is drawn shut
AROUND = 2  # cells around a tile that its shading and its edges depend on
LINED_MAX = 0.25  # m; in larger cells lines a metre apart would be half of what is seen
EDGE_SHADE = 0.9  # how bright the side of a part is beside its ground
EARTH = np.array([0.115, 0.125, 0.145])  # sRGB 0-1, the side of the block of earth


_Scalar = TypeVar("_Scalar", bound=np.generic)


class Window(NamedTuple):
    """Cells of a map: rows from ``r0`` up to ``r1``, columns from ``c0`` up to ``c1``."""

    r0: int
    r1: int
    c0: int
    c1: int

    @property
    def cells(self) -> tuple[slice, slice]:
        """As an index into a grid."""
        return slice(self.r0, self.r1), slice(self.c0, self.c1)

    def grown(self, rim: int) -> Window:
        """With ``rim`` more cells on every side, as far as the map's lower edges allow."""
        r0 = max(self.r0 - rim, 0)
        c0 = max(self.c0 - rim, 0)
        return Window(r0, self.r1 + rim, c0, self.c1 + rim)


@dataclass(frozen=True, slots=True)
class Tile:
    """One tile as it is sent: ``key`` changes exactly when what it shows changes."""

    name: str
    key: int
    window: Window


class TerrainMesh:
    """One map, ready to be cut into tiles. Heights in m (ny, nx), NaN is a hole. ``relief`` is from
    which height to which its colours go, m; its own where none is given. Of a wide map it is a
    window with its ``corner`` there, tiles keep their places while it moves; ``is_part``: other
    ground goes on beyond its edges.
    """

    def __init__(
        self,
        heights: Floats,
        forbidden: Bools,
        cell: float,
        origin: tuple[float, float],
        relief: tuple[float, float] | None = None,
        *,
        stepped: bool | None = None,
        corner: tuple[int, int] | None = None,
        is_part: bool = False,
    ) -> None:
        self.heights = heights
        self.corner = corner
        self.is_part = is_part
        self.forbidden = forbidden
        self.cell = cell
        self.origin = origin
        solid = heights[np.isfinite(heights)]
        self.low = float(solid.min()) if solid.size else 0.0
        high = float(solid.max()) if solid.size else 0.0
        self.relief = relief or (self.low, high)
        self.stepped = is_stepped(heights) if stepped is None else stepped
        self.scale = self._pixels_a_cell()
        self._stride = max(1, -(-max(heights.shape) // QUADS_MAX))
        if corner is not None:
            self._stride = 1 << (self._stride - 1).bit_length()

    def _pixels_a_cell(self) -> int:
        side = max(self.heights.shape)
        marked = self.forbidden.any() or np.isnan(self.heights).any()
        scale = max(1, min(8, PIXELS_MAX // side)) if marked else 1
        return max(scale, 4) if side < FINE_CELLS else scale

    @cached_property
    def _corner_heights(self) -> Floats:
        return _corners(self.heights, self.low - PIT)

    def tiles(self) -> list[Tile]:
        """Every tile of the map, row by row, each with its key."""
        rows, columns = self._cuts()
        found = []
        for j, r0, r1 in rows:
            for i, c0, c1 in columns:
                window = Window(r0, r1, c0, c1)
                found.append(Tile(f"{j}_{i}", self.key(window), window))
        return found

    def _cuts(self) -> Iterator[list[tuple[int, int, int]]]:
        """Of rows and columns: number, first cell and one past the last of every strip of tiles."""
        for n, first in zip(self.heights.shape, self.corner or (0, 0), strict=True):
            if self.corner is None:
                cuts = np.linspace(0, n, min(TILES, n) + 1).astype(int).tolist()
                begin = 0
            else:
                begin = first // WIDE_TILE
                inner = range((begin + 1) * WIDE_TILE - first, n, WIDE_TILE)
                cuts = [0, *inner, n]
            yield [(begin + k, a, b) for k, (a, b) in enumerate(zip(cuts, cuts[1:], strict=False))]

    def key(self, window: Window) -> int:
        """A hash over all that the picture and the shape of a tile depend on."""
        around = window.grown(AROUND).cells
        cells = (self.heights[around].tobytes(), self.forbidden[around].tobytes())
        relief = tuple(round(height, 3) for height in (self.low, *self.relief))
        r0, r1, c0, c1 = window
        rows, columns = self.heights.shape
        at = self.corner or (0, 0)
        origin = self.origin if self.corner is None else None
        # of a window only where a tile lies in the whole map, and which sides are its edge
        sides = (r0 == 0, r1 == rows, c0 == 0, c1 == columns)
        place = (self.cell, origin, self.stepped, self.scale, r0 + at[0], c0 + at[1], sides)
        return hash((cells, relief, place))

    def draw(self, tile: Tile) -> bytes:
        """The tile as binary glTF."""
        window = tile.window
        parts = self._steps(window) if self.stepped else [self._sheet(window)]
        surface = parts[0]
        image = png(self.picture(window))
        textured = Part(surface.vertices, surface.faces, unlit=True, uv=surface.uv, image=image)
        return glb([textured, *parts[1:], self._rim(window)])

    # the picture

    def picture(self, window: Window) -> Floats:
        """The window's colours as (rows, columns, 3) sRGB 0-1, ``scale`` pixels a cell."""
        around = window.grown(AROUND)
        heights = self.heights[around.cells]
        hole = np.isnan(heights)
        colour = self._shaded(np.where(hole, self.low, heights))
        colour = colour * (1.0 - 0.055 * self._metre_lines(around, heights.shape))[..., None]
        big = _enlarged(colour, self.scale)
        mark_forbidden(big, _enlarged(self.forbidden[around.cells] & ~hole, self.scale), self.scale)
        big[_enlarged(hole, self.scale)] = ABYSS
        top = (window.r0 - around.r0) * self.scale
        left = (window.c0 - around.c0) * self.scale
        rows = (window.r1 - window.r0) * self.scale
        columns = (window.c1 - window.c0) * self.scale
        return big[top : top + rows, left : left + columns]

    def _shaded(self, heights: Floats) -> Floats:
        shade = hill_shade(heights, self.cell, self.stepped)
        low, high = self.relief
        colour = height_colours(heights, low, high) * shade[..., None]
        if not self.stepped and high - low > CONTOUR:
            colour *= (1.0 - 0.16 * contours(heights, self.cell))[..., None]
        return colour

    def _metre_lines(self, window: Window, shape: tuple[int, ...]) -> Floats:
        """1 on lines every metre, so that level ground shows that the machine moves; none in parts
        of a wide map that are drawn too coarsely for them.
        """
        if self.is_part and self.cell > LINED_MAX:
            return np.zeros(shape)
        y = self.origin[1] + (window.r0 + np.arange(shape[0] + 1)) * self.cell
        x = self.origin[0] + (window.c0 + np.arange(shape[1] + 1)) * self.cell
        on_y, on_x = (np.diff(np.floor(axis + 1e-9)) > 0 for axis in (y, x))
        return np.asarray(on_y[:, None] | on_x[None, :], dtype=np.float64)

    # the shape

    def _xy(self, rows: Indices | Floats, columns: Indices | Floats) -> tuple[Floats, Floats]:
        """Where cell corners are, m."""
        x = np.asarray(self.origin[0] + columns * self.cell, dtype=np.float64)
        y = np.asarray(self.origin[1] + rows * self.cell, dtype=np.float64)
        return x, y

    def _sheet(self, window: Window) -> Part:
        """A smooth sheet through the cell corners, thinned out to the stride."""
        r0, r1, c0, c1 = window
        rows = _lines(r0, r1, self._stride)
        columns = _lines(c0, c1, self._stride)
        x, y = self._xy(rows, columns)
        z = self._corner_heights[np.ix_(rows, columns)]
        vertices = _grid_points(x, y, z)
        uv = _grid_points((columns - c0) / (c1 - c0), (rows - r0) / (r1 - r0))
        wide = len(columns)
        first = (np.arange(len(rows) - 1)[:, None] * wide + np.arange(wide - 1)).ravel()
        lower = np.stack([first, first + 1, first + wide + 1], 1)
        upper = np.stack([first, first + wide + 1, first + wide], 1)
        return Part(vertices, np.concatenate([lower, upper]), uv=uv)

    def _steps(self, window: Window) -> list[Part]:
        """Level rectangles with upright walls between them: the ground as it is walked on."""
        r0, r1, c0, c1 = window
        tops = [
            (r0 + a, r0 + b, c0 + c, c0 + d, height)
            for a, b, c, d, height in _rectangles(self.heights[window.cells])
            if not np.isnan(height)
        ]
        box = np.array(tops, dtype=np.float64).reshape(-1, 5)
        rows = box[:, [0, 0, 1, 1]].ravel()
        columns = box[:, [2, 3, 3, 2]].ravel()
        x, y = self._xy(rows, columns)
        vertices = np.stack([x, y, box[:, 4].repeat(4)], axis=1)
        uv = np.stack([(columns - c0) / (c1 - c0), (rows - r0) / (r1 - r0)], axis=1)
        return [Part(vertices, _quads(len(tops)), uv=uv), self._walls(window)]

    def _walls(self, window: Window) -> Part:
        """Upright faces where neighbouring cells differ in height, darker downwards."""
        walls = [
            *self._walls_along(window, upright=False),
            *self._walls_along(window, upright=True),
        ]
        table = np.array(walls, dtype=np.float64).reshape(-1, 6)
        x, y = self._xy(table[:, [0, 2, 2, 0]].ravel(), table[:, [1, 3, 3, 1]].ravel())
        z = table[:, [4, 4, 5, 5]].ravel()
        top = 0.55 * height_colours(table[:, 5], *self.relief)
        depth = np.clip((table[:, 5] - table[:, 4]) / PIT, 0.0, 1.0)[:, None]
        bottom = top * (1.0 - depth) * 0.8 + ABYSS * depth
        shades = np.ones((len(z), 4))
        shades[:, :3] = np.stack([bottom, bottom, top, top], axis=1).reshape(-1, 3)
        vertices = np.stack([x, y, z], axis=1)
        return Part(vertices, _quads(len(table)), shades=shades, unlit=True, double=True)

    def _walls_along(self, window: Window, upright: bool) -> Iterator[tuple[float, ...]]:
        """Walls between rows (columns when ``upright``): row, column, row, column, low, high."""
        grid = self.heights.T if upright else self.heights
        r0, r1, c0, c1 = window
        first, last, start, stop = (c0, c1, r0, r1) if upright else (r0, r1, c0, c1)
        for line in range(max(first, 1), last):
            low, high = _wall_span(grid[line - 1, start:stop], grid[line, start:stop])
            for a, b in _runs(np.stack([low, high])):
                if high[a] <= low[a]:
                    continue
                if upright:
                    ends = (start + a, line, start + b, line)
                else:
                    ends = (line, start + a, line, start + b)
                yield (*ends, float(low[a]), float(high[a]))

    def _rim(self, window: Window) -> Part:
        """The map's outer edge as the side of a block of earth; of a part of a wide map in the
        colours of its ground, as it fills the cracks beside the next part.
        """
        lines = self._outer_lines(window)
        if not lines:
            return Part(np.zeros((0, 3)), np.zeros((0, 3), int))
        # (n, 2 ends, row and column)
        ends = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in lines])
        x, y = self._xy(ends[..., 0], ends[..., 1])
        bottom = np.stack([x, y, np.full(x.shape, self.low - PIT)], -1)
        top = np.stack([x, y, self._edge_heights(ends)], -1)[:, ::-1]
        vertices = np.stack([bottom, top], axis=1).reshape(-1, 3)
        is_bottom = (np.arange(len(vertices)) % 4 < 2)[:, None]
        shades = np.ones((len(vertices), 4))
        if self.is_part:
            shades[:, :3] = EDGE_SHADE * height_colours(
                top[..., 2].mean(axis=1), *self.relief
            ).repeat(4, axis=0)
        else:
            shades[:, :3] = np.where(is_bottom, EARTH * 0.45, EARTH * 1.9)
        return Part(vertices, _quads(len(ends)), shades=shades, unlit=True, double=True)

    def _outer_lines(self, window: Window) -> list[Indices]:
        """The parts of the map's edge this window has, as (n, 2) corners: row, column."""
        r0, r1, c0, c1 = window
        rows, columns = self.heights.shape
        step = 1 if self.stepped else self._stride
        along_rows = _lines(r0, r1, step)
        along_columns = _lines(c0, c1, step)
        level = [edge for edge, here in ((0, r0), (rows, r1)) if edge == here]
        upright = [edge for edge, here in ((0, c0), (columns, c1)) if edge == here]
        return [
            *(np.stack([np.full_like(along_columns, at), along_columns], axis=1) for at in level),
            *(np.stack([along_rows, np.full_like(along_rows, at)], axis=1) for at in upright),
        ]

    def _edge_heights(self, ends: Indices) -> Floats:
        """Heights at the ends of edge pieces, (n, 2)."""
        if not self.stepped:
            return np.asarray(self._corner_heights[ends[..., 0], ends[..., 1]], dtype=np.float64)
        rows, columns = self.heights.shape
        first = ends.min(axis=1)
        inner = self.heights[
            np.minimum(first[:, 0], rows - 1), np.minimum(first[:, 1], columns - 1)
        ]
        return np.where(np.isnan(inner), self.low - PIT, inner)[:, None].repeat(2, axis=1)


def floor(mesh: TerrainMesh) -> bytes:
    """The dark floor far below, seen through the holes, as binary glTF."""
    rows, columns = mesh.heights.shape
    x0, y0 = mesh.origin
    x1 = x0 + columns * mesh.cell
    y1 = y0 + rows * mesh.cell
    z = mesh.low - PIT
    vertices = np.array([[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]])
    red, green, blue = ABYSS.tolist()
    return glb([Part(vertices, _quads(1), colour=(red, green, blue), unlit=True)])


def _enlarged(grid: NDArray[_Scalar], scale: int) -> NDArray[_Scalar]:
    """Every cell as ``scale`` by ``scale`` pixels."""
    return grid.repeat(scale, axis=0).repeat(scale, axis=1)


def _grid_points(x: Floats, y: Floats, *more: Floats) -> Floats:
    """The points of a grid row by row: x, y and the layers that follow, (rows * columns, 2 + n)."""
    shape = (len(y), len(x))
    layers = [np.broadcast_to(x, shape), np.broadcast_to(y[:, None], shape), *more]
    return np.stack(layers, axis=-1).reshape(-1, len(layers))


def _lines(first: int, last: int, stride: int) -> Indices:
    """Grid lines from ``first`` to ``last``, on multiples of the stride so that neighbouring tiles
    meet.
    """
    inner = np.arange(first - first % stride + stride, last, stride)
    return np.concatenate([[first], inner, [last]])


def _quads(count: int) -> Indices:
    """Faces of quads with four vertices each, one after the other."""
    first = np.arange(count)[:, None] * 4
    return np.concatenate([first + [0, 1, 2], first + [0, 2, 3]])


def _corners(heights: Floats, pit: float) -> Floats:
    """Heights at cell corners, the mean of the cells that meet there; the bottom of the pit inside
    holes.
    """
    padded = np.pad(heights, 1, mode="edge")
    around = np.stack([padded[:-1, :-1], padded[:-1, 1:], padded[1:, :-1], padded[1:, 1:]])
    solid = np.isfinite(around)
    count = solid.sum(axis=0)
    total = np.where(solid, around, 0.0).sum(axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), pit)


def is_stepped(heights: Floats) -> bool:
    """True when most neighbours are level, in pieces few enough to be drawn exactly."""
    for axis in (0, 1):
        change = _differs(heights, axis)
        if change.size and change.mean() > 0.5:
            return False
    rows_change = _differs(heights, 0).any(axis=1)
    strips = np.concatenate([[True], rows_change])
    quads = int(_differs(heights[strips], 1).sum()) + int(strips.sum())
    return quads <= STEPPED_QUADS_MAX


def _differs(grid: Floats, axis: int) -> Bools:
    a, b = (grid[1:], grid[:-1]) if axis == 0 else (grid[:, 1:], grid[:, :-1])
    return np.asarray((a != b) & ~(np.isnan(a) & np.isnan(b)), dtype=np.bool_)


def _rectangles(heights: Floats) -> list[tuple[int, int, int, int, float]]:
    """Level rectangles (row0, row1, column0, column1, height): equal rows make a strip, equal cells
    in it a rectangle.
    """
    cuts = [0, *(np.flatnonzero(_differs(heights, 0).any(axis=1)) + 1).tolist(), len(heights)]
    found = []
    for a, b in zip(cuts, cuts[1:], strict=False):
        row = heights[a]
        for c, d in _runs(row[None]):
            found.append((a, b, c, d, float(row[c])))
    return found


def _runs(rows: Floats) -> list[tuple[int, int]]:
    """Stretches of columns over which every row keeps its value."""
    cuts = [0, *(np.flatnonzero(_differs(rows, 1).any(axis=0)) + 1).tolist(), rows.shape[1]]
    return list(zip(cuts, cuts[1:], strict=False))


def _wall_span(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """Bottom and top of the wall between two rows of cells; equal where there is none."""
    low = np.fmin(a, b)
    high = np.fmax(a, b)
    one_hole = np.isnan(a) ^ np.isnan(b)
    low = np.where(one_hole, high - PIT, low)
    none = np.isnan(high)
    return np.where(none, 0.0, low), np.where(none, 0.0, high)
