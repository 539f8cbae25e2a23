"""What the walker believes about the ground: heights and forbidden cells on a square grid.

Row index is y, column index is x; ``origin`` is the corner of cell [0, 0]; between cells the ground
is flat or relief (``grid``). NaN is a hole without a bottom. Outside the map everything is
forbidden. A map is frozen: what the walker learns makes a new one (``forbid``).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..robot.model import Machine
from .grid import HeightGrid, Window, crests_of, is_relief, renew_crests
from .traversability import classify

# what is worked out of the heights alone: a map of the same heights need not do it again
OF_HEIGHTS = {"crests", "_span", "holes_bytes"}
EDGE = 0.01  # m a foothold keeps from the bottomless. Less: see a point of a foot slip off


@dataclass(frozen=True, eq=False)
class TerrainMap(HeightGrid):
    """Believed ground: ``heights`` (ny, nx) in metres, ``forbidden`` (ny, nx) bool, the side of a
    ``cell`` in metres, ``origin`` x, y.

    Frozen, its arrays write-protected. ``from_heights`` makes one of what you measured. Raises
    ``ValueError`` for arrays of different shapes.

    >>> import numpy as np
    >>> from walking_console import TerrainMap, load_machine
    >>> heights = np.zeros((40, 60))
    >>> heights[:, 30:] = np.nan
    >>> terrain = TerrainMap.from_heights(heights, 0.05, load_machine("titan3"))
    >>> terrain.allows(0.5, 1.0), terrain.allows(2.0, 1.0), terrain.height_at(0.5, 1.0)
    (True, False, 0.0)
    """

    heights: NDArray[np.float64]
    forbidden: NDArray[np.bool_]
    cell: float
    origin: tuple[float, float]
    foot_radius: float = 0.03
    # (ny, nx) seen or touched; None: all of it (heights elsewhere are supposed)
    known: NDArray[np.bool_] | None = None
    edge: float = EDGE  # m a foothold keeps from the bottomless; 0: it may stand on its very edge
    # straight between the centres of cells; None: as its heights are (``is_relief``)
    relief: bool | None = None

    def __post_init__(self) -> None:
        shape = self.heights.shape
        if shape != self.forbidden.shape or self.heights.ndim != 2:
            raise ValueError(
                "heights and forbidden must be one (ny, nx) shape, "
                f"got {shape} and {self.forbidden.shape}"
            )
        if self.known is not None and self.known.shape != shape:
            raise ValueError(
                f"known must have the shape of heights, {shape}, got {self.known.shape}"
            )
        for name in ("heights", "forbidden", "known"):
            if (given := getattr(self, name)) is not None:
                array = np.ascontiguousarray(given)
                array.setflags(write=False)
                object.__setattr__(self, name, array)
        if self.relief is None:
            object.__setattr__(self, "relief", is_relief(self.heights))

    @classmethod
    def from_heights(
        cls,
        heights: ArrayLike,
        cell: float,
        machine: Machine,
        origin: tuple[float, float] = (0.0, 0.0),
        forbidden: ArrayLike | None = None,
    ) -> TerrainMap:
        """The map of measured ground, for one machine to walk on.

        ``heights`` (ny, nx) in metres, row 0 at the least y and column 0 at the least x, NaN where
        there is no ground; ``cell`` is the side of a cell in metres, ``origin`` the x, y of the
        outer corner of cell [0, 0]. ``forbidden`` (ny, nx) says where no foot may land; without it
        that is worked out from the heights for this machine's feet (``classify``). Raises
        ``ValueError`` for other shapes, infinite heights and cells of no size.
        """
        ground = np.array(heights, dtype=np.float64)
        if ground.ndim != 2 or np.isinf(ground).any():
            raise ValueError(f"heights must be (ny, nx), finite or NaN, got shape {ground.shape}")
        if not 0.0 < cell < math.inf:
            raise ValueError(f"cell must be the side of a cell in metres, got {cell!r}")
        closed = classify(ground, cell, machine) if forbidden is None else np.array(forbidden, bool)
        x, y = origin
        return cls(ground, closed, float(cell), (float(x), float(y)), machine.foot_radius)

    @cached_property
    def forbidden_bytes(self) -> bytes:
        """One byte a cell, row by row: 1 where landing is prohibited."""
        return self.forbidden.tobytes()

    @cached_property
    def holes_bytes(self) -> bytes:
        """One byte a cell, row by row: 1 where there is no bottom; none at all without holes."""
        holes = np.isnan(self.heights)
        return holes.tobytes() if holes.any() else b""

    def keeps_off_holes(self, x: float, y: float) -> bool:
        """True when (x, y) is no nearer than ``edge`` to the bottomless."""
        holes = self.holes_bytes
        if not holes or self.edge <= 0.0:
            return True
        x0, y0, cell, rows, columns, _, _ = self._look_up
        edge = self.edge
        floor = math.floor
        left = floor((x - edge - x0) / cell)
        right = floor((x + edge - x0) / cell)
        low = floor((y - edge - y0) / cell)
        high = floor((y + edge - y0) / cell)
        if left < 0 or low < 0 or right >= columns or high >= rows:
            left, right = max(left, 0), min(right, columns - 1)
            low, high = max(low, 0), min(high, rows - 1)
        for row in range(low * columns, high * columns + 1, columns):
            if 1 in holes[row + left : row + right + 1]:
                return False
        return True

    @cached_property
    def _span(self) -> tuple[float, float]:
        """Lowest and highest ground on the map, m; the lowest is above the highest where there is
        none.
        """
        low = np.fmin.reduce(self.heights, axis=None, initial=math.inf)
        high = np.fmax.reduce(self.heights, axis=None, initial=-math.inf)
        return float(low), float(high)

    @cached_property
    def highest(self) -> float:
        """Highest ground on the map, m; 0 when there is none."""
        _, high = self._span
        return high if math.isfinite(high) else 0.0

    @cached_property
    def is_level(self) -> bool:
        """True when all ground there is has one height: nothing to clear, nothing to climb."""
        return self._span[0] >= self._span[1]

    @cached_property
    def is_plain(self) -> bool:
        """True when all of it is known and level ground, on which feet may land anywhere."""
        level = self.is_level and not (self.holes_bytes or self.forbidden.any())
        return level and (self.known is None or bool(self.known.all()))

    @cached_property
    def crests(self) -> NDArray[np.float64]:
        """Highest ground within a foot radius of each cell; −inf over holes."""
        return crests_of(self.heights, math.ceil(self.foot_radius / self.cell))

    @cached_property
    def crest_view(self) -> memoryview:
        """Highest ground within a foot radius of each cell, row by row; −inf over holes."""
        return self.crests.ravel().data

    def allows(self, x: float, y: float) -> bool:
        """True when a foot may land at (x, y)."""
        flat = self.index(x, y)
        return flat >= 0 and not self.forbidden_bytes[flat] and self.keeps_off_holes(x, y)

    def is_known(self, x: float, y: float) -> bool:
        """True when the ground at (x, y) has been seen or touched."""
        flat = self.index(x, y)
        return flat >= 0 and (self.known is None or bool(self.known.flat[flat]))

    def is_free(self, x_min: float, x_max: float, y_min: float, y_max: float) -> bool:
        """True when an axis-aligned rectangle is on the map and no cell of it is prohibited."""
        ox, oy = self.origin
        c0, c1 = (math.floor((x - ox) / self.cell) for x in (x_min, x_max))
        r0, r1 = (math.floor((y - oy) / self.cell) for y in (y_min, y_max))
        if c0 < 0 or r0 < 0 or c1 >= self.columns or r1 >= self.rows:
            return False
        return self.is_plain or not self.forbidden[r0 : r1 + 1, c0 : c1 + 1].any()

    def crest_between(self, ax: float, ay: float, bx: float, by: float) -> float:
        """Highest ground a foot passes on the straight way from a to b, m; −inf over none."""
        steps = max(1, math.ceil(math.hypot(bx - ax, by - ay) / self.cell))
        dx = (bx - ax) / (steps * self.cell)
        dy = (by - ay) / (steps * self.cell)
        fx = (ax - self.origin[0]) / self.cell
        fy = (ay - self.origin[1]) / self.cell
        columns = self.columns
        rows = self.rows
        view = self.crest_view
        top = -math.inf
        for _ in range(steps + 1):
            column = int(fx)
            row = int(fy)
            if 0 <= column < columns and 0 <= row < rows:
                height = view[row * columns + column]
                if height > top:
                    top = height
            fx += dx
            fy += dy
        return top

    def crest_in(self, x_min: float, x_max: float, y_min: float, y_max: float) -> float:
        """Highest ground in an axis-aligned rectangle, m; −inf when there is none."""
        patch = self.heights[self.window(x_min, x_max, y_min, y_max)]
        solid = patch[~np.isnan(patch)]
        return float(solid.max()) if solid.size else -math.inf

    def forbid(self, cells: Iterable[tuple[int, int]]) -> TerrainMap:
        """A new map in which no foot may land on these (row, column) cells."""
        forbidden = self.forbidden.copy()
        for row, column in cells:
            self.need_cell(row, column)
            forbidden[row, column] = True
        other = replace(self, forbidden=forbidden)
        other.__dict__.update(
            {name: self.__dict__[name] for name in OF_HEIGHTS & vars(self).keys()}
        )
        return other

    def told(
        self, prohibited: Iterable[tuple[int, int]], heights: Mapping[tuple[int, int], float]
    ) -> TerrainMap:
        """A new map in which no foot may land on ``prohibited`` cells, and cells are at least as
        high as ``heights`` has them (m), or holes (NaN).
        """
        believed = self.forbid(prohibited)
        if not heights:
            return believed
        new = self.heights.copy()
        crests = self.crests.copy()
        reach = math.ceil(self.foot_radius / self.cell)
        for (row, column), height in heights.items():
            self.need_cell(row, column)
            if math.isnan(height) or not new[row, column] >= height:
                new[row, column] = height
                cell = slice(row, row + 1), slice(column, column + 1)
                renew_crests(crests, new, cell, reach)
        told = replace(believed, heights=new)
        told.__dict__["crests"] = crests
        return told

    def keeping_off(self, edge: float) -> TerrainMap:
        """The same map whose footholds keep so far from the bottomless, m."""
        other = replace(self, edge=edge)
        other.__dict__.update({**vars(self), "edge": edge})
        return other

    def replaced(
        self,
        heights: NDArray[np.float64],
        forbidden: NDArray[np.bool_],
        known: NDArray[np.bool_],
        crests: NDArray[np.float64],
        span: tuple[float, float],
    ) -> TerrainMap:
        """The same map with other cells, whose crests, and lowest and highest ground, m, are known
        already.
        """
        other = replace(self, heights=heights, forbidden=forbidden, known=known)
        other.__dict__["crests"] = crests
        other.__dict__["_span"] = span
        return other

    def work_out(self) -> TerrainMap:
        """This map, with all that planning asks of it worked out now: otherwise the first tick that
        asks would be late.
        """
        for name in ("forbidden_bytes", "holes_bytes", "crest_view", "highest", "is_level"):
            getattr(self, name)
        return self


def with_crests(terrain: TerrainMap, crests: NDArray[np.float64]) -> TerrainMap:
    """The same map, whose crests, m, are known already."""
    other = replace(terrain)
    other.__dict__["crests"] = crests
    return other


def changed_in(
    terrain: TerrainMap, window: Window, heights: NDArray[np.float64], forbidden: NDArray[np.bool_]
) -> TerrainMap:
    """The same map with other heights in one rectangle, m, and other cells prohibited: what has
    been worked out of the heights elsewhere is not worked out again.
    """
    other = replace(terrain, heights=heights, forbidden=forbidden)
    kept = vars(terrain)
    if heights is terrain.heights:
        other.__dict__.update({name: kept[name] for name in OF_HEIGHTS & kept.keys()})
        return other
    if "crests" in kept:
        crests = terrain.crests.copy()
        renew_crests(crests, heights, window, math.ceil(terrain.foot_radius / terrain.cell))
        other.__dict__["crests"] = crests
    if (span := _span_after(terrain, window, heights[window])) is not None:
        other.__dict__["_span"] = span
    if not (terrain.holes_bytes or np.isnan(heights[window]).any()):
        other.__dict__["holes_bytes"] = b""
    return other


def _span_after(
    terrain: TerrainMap, window: Window, now: NDArray[np.float64]
) -> tuple[float, float] | None:
    """Lowest and highest ground, m, after a part of a map has changed; None where the lowest or the
    highest was in that part.
    """
    low, high = terrain._span
    before = terrain.heights[window]
    if ((before <= low) | (before >= high)).any():
        return None
    least = np.fmin.reduce(now, axis=None, initial=low)
    return float(least), float(np.fmax.reduce(now, axis=None, initial=high))
