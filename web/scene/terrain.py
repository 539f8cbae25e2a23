"""The ground as a picture: tiles of triangles under a map-like texture (height colours, hill
shading, contours, forbidden cells).

Shape and picture are apart: the texture has the full resolution of the map, so forbidden cells and
small holes stay crisp where the triangles are thinned out. Stepped ground (stairs, rivers, blocks,
hole fields) keeps its exact edges.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .gltf import Part, glb

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

TILES = 8  # tiles a side: an edited patch re-sends one of them
QUADS_MAX = 200  # quads a side on smooth ground; more: joining takes seconds on a slow line
# exact steps up to here; more: drawn thinned out, with holes only painted
STEPPED_QUADS_MAX = 60_000
PIXELS_MAX = 2048  # a side, all tiles together
PIT = 0.5  # m, depth at which a bottomless hole is drawn shut
# m, relief that gets the whole colour ramp at least; less: small bumps look like mountains
SPAN_MIN = 0.4
CONTOUR = 0.05  # m between contour lines

# Height colours: lightness rises evenly (OKLCh), hue runs from slate blue over sage to sand
RAMP = (
    (0.48, 0.042, 262.0),
    (0.56, 0.045, 225.0),
    (0.65, 0.055, 165.0),
    (0.75, 0.075, 118.0),
    (0.84, 0.078, 85.0),
    (0.94, 0.035, 75.0),
)
FORBIDDEN = np.array([0.80, 0.22, 0.14])  # sRGB
FORBIDDEN_EDGE = np.array([0.36, 0.07, 0.07])
# where most ground is forbidden, the allowed cells are what should be seen
FORBIDDEN_FIELD = np.array([0.34, 0.17, 0.16])
ABYSS = np.array([0.018, 0.022, 0.032])
EARTH = np.array([0.115, 0.125, 0.145])


@dataclass(frozen=True, slots=True, eq=False)
class Tile:
    """One tile as it is sent: ``key`` changes exactly when what it shows changes."""

    name: str
    key: int
    rows: slice
    columns: slice


def oklch(lightness: Floats, chroma: Floats, hue: Floats) -> Floats:
    """OKLCh to sRGB 0-1 (B. Ottosson 2020): equal steps of it look equal."""
    a, b = chroma * np.cos(np.radians(hue)), chroma * np.sin(np.radians(hue))
    lms = np.stack([lightness + 0.3963377774 * a + 0.2158037573 * b, lightness - 0.1055613458 * a - 0.0638541728 * b,
                    lightness - 0.0894841775 * a - 1.2914855480 * b], axis=-1) ** 3  # fmt: skip
    matrix = np.array([[4.0767416621, -3.3077115913, 0.2309699292], [-1.2684380046, 2.6097574011, -0.3413193965],
                       [-0.0041960863, -0.7034186147, 1.7076147010]])  # fmt: skip
    light = np.clip(lms @ matrix.T, 0.0, 1.0)
    return np.asarray(
        np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055),
        dtype=np.float64,
    )


def _ramp() -> Floats:
    at = np.linspace(0.0, 1.0, 256)
    knots = np.linspace(0.0, 1.0, len(RAMP))
    columns = [np.interp(at, knots, [key[i] for key in RAMP]) for i in range(3)]
    return oklch(*columns)


COLOURS = _ramp()  # (256, 3) sRGB


class Ground:
    """One map, ready to be cut into tiles."""

    def __init__(
        self, heights: Floats, forbidden: Bools, cell: float, origin: tuple[float, float]
    ) -> None:
        self.heights, self.forbidden, self.cell, self.origin = heights, forbidden, cell, origin
        rows, columns = heights.shape
        solid = heights[np.isfinite(heights)]
        low, high = (float(solid.min()), float(solid.max())) if solid.size else (0.0, 0.0)
        self.low, self.high = low, high
        self.stepped = _is_stepped(heights)
        self.scale = (
            max(1, min(8, PIXELS_MAX // max(rows, columns)))
            if forbidden.any() or np.isnan(heights).any()
            else 1
        )
        if max(rows, columns) < 300:
            self.scale = max(self.scale, 4)
        self._corners = None if self.stepped else _corners(heights, low - PIT)
        self._stride = max(1, -(-max(rows, columns) // QUADS_MAX))

    def tiles(self) -> list[Tile]:
        """Every tile of the map, row by row, each with its key."""
        rows, columns = (
            np.linspace(0, n, min(TILES, n) + 1).astype(int) for n in self.heights.shape
        )
        found = []
        for j, (r0, r1) in enumerate(zip(rows, rows[1:], strict=False)):
            for i, (c0, c1) in enumerate(zip(columns, columns[1:], strict=False)):
                around = np.s_[max(r0 - 2, 0) : r1 + 2, max(c0 - 2, 0) : c1 + 2]
                content = (
                    self.heights[around].tobytes(),
                    self.forbidden[around].tobytes(),
                    round(self.low, 3),
                    round(self.high, 3),
                )
                place = (self.cell, self.origin, self.stepped, self.scale, int(r0), int(c0))
                found.append(
                    Tile(
                        f"{j}_{i}",
                        hash((content, place)),
                        slice(int(r0), int(r1)),
                        slice(int(c0), int(c1)),
                    )
                )
        return found

    def draw(self, tile: Tile) -> bytes:
        """The tile as binary glTF."""
        r0, r1, c0, c1 = tile.rows.start, tile.rows.stop, tile.columns.start, tile.columns.stop
        parts = self._steps(r0, r1, c0, c1) if self.stepped else [self._sheet(r0, r1, c0, c1)]
        image = png(self.picture(r0, r1, c0, c1))
        surface = parts[0]
        textured = Part(surface.vertices, surface.faces, unlit=True, uv=surface.uv, image=image)
        return glb([textured, *parts[1:], self._rim(r0, r1, c0, c1)])

    # the picture

    def picture(self, r0: int, r1: int, c0: int, c1: int) -> Floats:
        """The tile's colours as (rows, columns, 3) sRGB 0-1, ``scale`` pixels a cell."""
        pad_r, pad_c = min(r0, 2), min(c0, 2)
        window = np.s_[r0 - pad_r : r1 + 2, c0 - pad_c : c1 + 2]
        heights, forbidden = self.heights[window], self.forbidden[window]
        hole = np.isnan(heights)
        filled = np.where(hole, self.low, heights)
        colour = self.colours(filled) * _hill_shade(filled, self.cell, self.stepped)[..., None]
        if not self.stepped and self.high - self.low > CONTOUR:
            colour = colour * (1.0 - 0.16 * _contours(filled, self.cell))[..., None]
        colour = (
            colour * (1.0 - 0.055 * self._grid(r0 - pad_r, c0 - pad_c, heights.shape))[..., None]
        )
        scale = self.scale
        big = colour.repeat(scale, axis=0).repeat(scale, axis=1)
        _mark(big, (forbidden & ~hole).repeat(scale, axis=0).repeat(scale, axis=1), scale)
        big[hole.repeat(scale, axis=0).repeat(scale, axis=1)] = ABYSS
        return big[
            pad_r * scale : (pad_r + r1 - r0) * scale, pad_c * scale : (pad_c + c1 - c0) * scale
        ]

    def colours(self, heights: Floats) -> Floats:
        """Height colours; level ground gets the middle of the lower half."""
        span = max(self.high - self.low, SPAN_MIN)
        middle = (self.high + self.low) / 2
        share: Floats = (
            np.clip(0.5 + (heights - middle) / span, 0.0, 1.0)
            if self.high > self.low
            else np.full(heights.shape, 0.22)
        )
        return np.asarray(COLOURS[(share * 255).astype(np.uint8)], dtype=np.float64)

    def _grid(self, row: int, column: int, shape: tuple[int, ...]) -> Floats:
        """1 on lines every metre, so that level ground shows that the machine moves."""
        y = self.origin[1] + (row + np.arange(shape[0] + 1)) * self.cell
        x = self.origin[0] + (column + np.arange(shape[1] + 1)) * self.cell
        on_y, on_x = (np.diff(np.floor(axis + 1e-9)) > 0 for axis in (y, x))
        return np.asarray(on_y[:, None] | on_x[None, :], dtype=np.float64)

    # the shape

    def _xy(self, rows: NDArray[Any], columns: NDArray[Any]) -> tuple[Floats, Floats]:
        return self.origin[0] + columns * self.cell, self.origin[1] + rows * self.cell

    def _sheet(self, r0: int, r1: int, c0: int, c1: int) -> Part:
        """A smooth sheet through the cell corners, thinned out to the stride."""
        assert self._corners is not None
        rows, columns = _lines(r0, r1, self._stride), _lines(c0, c1, self._stride)
        x, y = self._xy(rows, columns)
        z = self._corners[np.ix_(rows, columns)]
        points = np.stack(
            [np.broadcast_to(x, z.shape), np.broadcast_to(y[:, None], z.shape), z], axis=-1
        ).reshape(-1, 3)
        u, v = (columns - c0) / (c1 - c0), (rows - r0) / (r1 - r0)
        uv = np.stack(
            [np.broadcast_to(u, z.shape), np.broadcast_to(v[:, None], z.shape)], axis=-1
        ).reshape(-1, 2)
        wide = len(columns)
        first = (np.arange(len(rows) - 1)[:, None] * wide + np.arange(wide - 1)).ravel()
        faces = np.concatenate(
            [
                np.stack([first, first + 1, first + wide + 1], 1),
                np.stack([first, first + wide + 1, first + wide], 1),
            ]
        )
        return Part(points, faces, uv=uv)

    def _steps(self, r0: int, r1: int, c0: int, c1: int) -> list[Part]:
        """Level rectangles with upright walls between them: exactly the ground the machine stands
        on.
        """
        heights = self.heights[r0:r1, c0:c1]
        tops = [
            (r0 + a, r0 + b, c0 + c, c0 + d, h)
            for a, b, c, d, h in _rectangles(heights)
            if not np.isnan(h)
        ]
        box = np.array(tops, dtype=np.float64).reshape(-1, 5)
        corner_rows = box[:, [0, 0, 1, 1]].ravel()
        corner_columns = box[:, [2, 3, 3, 2]].ravel()
        x, y = self._xy(corner_rows, corner_columns)
        points = np.stack([x, y, box[:, 4].repeat(4)], axis=1)
        uv = np.stack([(corner_columns - c0) / (c1 - c0), (corner_rows - r0) / (r1 - r0)], axis=1)
        return [Part(points, _quads(len(tops)), uv=uv), self._walls(r0, r1, c0, c1)]

    def _walls(self, r0: int, r1: int, c0: int, c1: int) -> Part:
        """Upright faces where neighbouring cells differ in height, darker downwards; holes get deep
        ones.
        """
        segments: list[tuple[float, float, float, float, float, float]] = []
        for upright in (False, True):
            grid = self.heights.T if upright else self.heights
            (a0, a1), (b0, b1) = ((c0, c1), (r0, r1)) if upright else ((r0, r1), (c0, c1))
            for a in range(max(a0, 1), a1):
                below, above = grid[a - 1, b0:b1], grid[a, b0:b1]
                low, high = _wall_span(below, above)
                for start, stop in _runs(np.stack([low, high])):
                    if high[start] > low[start]:
                        ends = (
                            (a, b0 + start, a, b0 + stop)
                            if not upright
                            else (b0 + start, a, b0 + stop, a)
                        )
                        segments.append((*ends, float(low[start]), float(high[start])))
        table = np.array(segments, dtype=np.float64).reshape(-1, 6)
        x, y = self._xy(table[:, [0, 2, 2, 0]].ravel(), table[:, [1, 3, 3, 1]].ravel())
        z = table[:, [4, 4, 5, 5]].ravel()
        shades = np.ones((len(z), 4))
        top = 0.55 * self.colours(table[:, 5])
        depth = np.clip((table[:, 5] - table[:, 4]) / PIT, 0.0, 1.0)[:, None]
        bottom = top * (1.0 - depth) * 0.8 + ABYSS * depth
        shades[:, :3] = np.stack([bottom, bottom, top, top], axis=1).reshape(-1, 3)
        return Part(
            np.stack([x, y, z], axis=1), _quads(len(table)), shades=shades, unlit=True, double=True
        )

    def _rim(self, r0: int, r1: int, c0: int, c1: int) -> Part:
        """The map's outer edge as the side of a block of earth."""
        base = self.low - PIT
        lines: list[Floats] = []
        rows, columns = self.heights.shape
        step = 1 if self.stepped else self._stride
        along_r, along_c = _lines(r0, r1, step), _lines(c0, c1, step)
        for here, fixed in ((r0 == 0, 0), (r1 == rows, rows)):
            if here:
                lines.append(np.stack([np.full(len(along_c), fixed), along_c], axis=1))
        for here, fixed in ((c0 == 0, 0), (c1 == columns, columns)):
            if here:
                lines.append(np.stack([along_r, np.full(len(along_r), fixed)], axis=1))
        if not lines:
            return Part(np.zeros((0, 3)), np.zeros((0, 3), int))
        # (n, 2 ends, row and column)
        ends = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in lines])
        x, y = self._xy(ends[..., 0], ends[..., 1])
        z = self._edge_heights(ends)
        quad = np.stack(
            [np.stack([x, y, np.full(x.shape, base)], -1), np.stack([x, y, z], -1)[:, ::-1]], axis=1
        ).reshape(-1, 3)
        shades = np.ones((len(quad), 4))
        shades[:, :3] = np.where((np.arange(len(quad)) % 4 < 2)[:, None], EARTH * 0.45, EARTH * 1.9)
        return Part(quad, _quads(len(ends)), shades=shades, unlit=True, double=True)

    def _edge_heights(self, ends: NDArray[Any]) -> Floats:
        if self._corners is not None:
            return np.asarray(self._corners[ends[..., 0], ends[..., 1]], dtype=np.float64)
        rows, columns = self.heights.shape
        inner = self.heights[
            np.minimum(ends.min(axis=1)[:, 0], rows - 1),
            np.minimum(ends.min(axis=1)[:, 1], columns - 1),
        ]
        return np.where(np.isnan(inner), self.low - PIT, inner)[:, None].repeat(2, axis=1)


def floor(ground: Ground) -> bytes:
    """The dark floor far below, seen through the holes."""
    rows, columns = ground.heights.shape
    x0, y0 = ground.origin
    x1, y1 = x0 + columns * ground.cell, y0 + rows * ground.cell
    z = ground.low - PIT
    points = np.array([[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]])
    return glb(
        [
            Part(
                points,
                _quads(1),
                colour=(float(ABYSS[0]), float(ABYSS[1]), float(ABYSS[2])),
                unlit=True,
            )
        ]
    )


def _lines(first: int, last: int, stride: int) -> NDArray[Any]:
    """Grid lines from ``first`` to ``last``, on multiples of the stride so that neighbouring tiles
    meet.
    """
    inner = np.arange(first - first % stride + stride, last, stride)
    return np.concatenate([[first], inner, [last]])


def _quads(count: int) -> NDArray[Any]:
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


def _is_stepped(heights: Floats) -> bool:
    """True when most neighbours are level and the level pieces are few enough to be drawn exactly."""
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
    low, high = np.fmin(a, b), np.fmax(a, b)
    one_hole = np.isnan(a) ^ np.isnan(b)
    low = np.where(one_hole, high - PIT, low)
    none = np.isnan(high)
    return np.where(none, 0.0, low), np.where(none, 0.0, high)


def _hill_shade(heights: Floats, cell: float, stepped: bool) -> Floats:
    """Brightness of the ground under a low sun from the north-west and a wide sky; 1 on the level."""
    if min(heights.shape) < 2:
        return np.ones(heights.shape)
    dy, dx = np.gradient(heights, cell)
    if stepped:
        dy, dx = np.clip(dy, -0.3, 0.3), np.clip(dx, -0.3, 0.3)
    normal = 1.0 / np.sqrt(1.0 + dx * dx + dy * dy)
    sun = (0.42 * dx - 0.42 * dy + 0.80) * normal / 0.80
    return np.asarray(
        np.clip(0.30 + 0.70 * sun, 0.25, 1.45) * (0.55 + 0.45 * normal), dtype=np.float64
    )


def _contours(heights: Floats, cell: float) -> Floats:
    """Up to 1 where a contour line runs, every fifth one full, the others half; soft, and none
    where the ground is nearly level.
    """
    if min(heights.shape) < 2:
        return np.zeros(heights.shape)
    dy, dx = np.gradient(heights, cell)
    slope = np.hypot(dx, dy)
    width = np.maximum(slope, 1e-6) * cell * 0.8
    shown = np.clip(slope / 0.08 - 0.25, 0.0, 1.0)
    lines = [
        np.clip(1.3 - np.abs(heights - np.rint(heights / gap) * gap) / width, 0.0, 1.0)
        for gap in (CONTOUR, 5 * CONTOUR)
    ]
    return np.asarray(np.maximum(0.5 * lines[0], lines[1]) * shown, dtype=np.float64)


def _mark(picture: Floats, forbidden: Bools, scale: int) -> None:
    """Tint forbidden cells and draw a thin dark line round each forbidden region."""
    if not forbidden.any():
        return
    tint = FORBIDDEN if forbidden.mean() < 0.5 else FORBIDDEN_FIELD
    picture[forbidden] = 0.42 * picture[forbidden] + 0.58 * tint * (
        0.55 + 0.9 * picture[forbidden].mean(axis=1, keepdims=True)
    )
    if scale < 2:
        return
    free = np.pad(~forbidden, 1, mode="edge")
    edge = forbidden & (free[:-2, 1:-1] | free[2:, 1:-1] | free[1:-1, :-2] | free[1:-1, 2:])
    picture[edge] = 0.45 * picture[edge] + 0.55 * FORBIDDEN_EDGE


def png(picture: Floats) -> bytes:
    """An (h, w, 3) or (h, w, 4) picture, 0-1, as PNG; each row is stored as the change from the one
    above, which packs well.
    """
    pixels = np.clip(np.rint(picture * 255), 0, 255).astype(np.uint8)
    rows, columns, channels = pixels.shape
    # filter 2, wraps round as PNG wants
    change = np.diff(pixels, axis=0, prepend=np.zeros((1, columns, channels), np.uint8))
    lines = np.concatenate([np.full((rows, 1), 2, np.uint8), change.reshape(rows, -1)], axis=1)
    header = struct.pack(">IIBBBBB", columns, rows, 8, {3: 2, 4: 6}[channels], 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(lines.tobytes(), 6)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(c)) + k + c + struct.pack(">I", zlib.crc32(k + c)) for k, c in chunks
    )
