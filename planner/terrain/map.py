"""What the walker believes about the ground: heights and forbidden cells on a square grid.

Row index is y, column index is x; ``origin`` is the corner of cell [0, 0]; the ground is the height
of the cell that contains the point. NaN is a hole without a bottom. Outside the map everything is
forbidden. A map is frozen: what the walker learns makes a new one (``forbid``).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import IntFlag
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..robot.model import Machine

SLOPE_MAX = math.radians(35.0)  # steeper ground is H: see feet slide off (titan3 default)
RELIEF_MAX = 0.03  # m under one foot; more is H: see feet land on edges
SLOPING = 1.1  # times what an even slope gives a foot of relief; more is no slope
RISE_MAX = 0.30  # m above the ground around; taller is P: see legs hit what they cannot step on
RISE_WINDOW = 1.0  # m, side of the square that counts as "the ground around"


@dataclass(frozen=True, eq=False)
class TerrainMap:
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

    def __post_init__(self) -> None:
        if self.heights.shape != self.forbidden.shape or self.heights.ndim != 2:
            raise ValueError(
                f"heights and forbidden must be one (ny, nx) shape, got {self.heights.shape} and {self.forbidden.shape}"
            )
        if self.known is not None and self.known.shape != self.heights.shape:
            raise ValueError(
                f"known must have the shape of heights, {self.heights.shape}, got {self.known.shape}"
            )
        for name in (
            ("heights", "forbidden") if self.known is None else ("heights", "forbidden", "known")
        ):
            array = np.ascontiguousarray(getattr(self, name))
            array.setflags(write=False)
            object.__setattr__(self, name, array)

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
        if forbidden is None:
            closed = classify(ground, cell, machine)
        else:
            closed = np.array(forbidden, dtype=np.bool_)
        x, y = origin
        return cls(ground, closed, float(cell), (float(x), float(y)), machine.foot_radius)

    # scalar views for the planning loops: numpy scalars cost three times as much
    @cached_property
    def rows(self) -> int:
        return int(self.heights.shape[0])

    @cached_property
    def columns(self) -> int:
        return int(self.heights.shape[1])

    @cached_property
    def forbidden_bytes(self) -> bytes:
        """One byte a cell, row by row: 1 where landing is prohibited."""
        return self.forbidden.tobytes()

    @cached_property
    def height_view(self) -> memoryview:
        """Heights row by row as plain floats."""
        return self.heights.astype(np.float64, copy=False).ravel().data

    @cached_property
    def highest(self) -> float:
        """Highest ground on the map, m; 0 when there is none."""
        finite = self.heights[np.isfinite(self.heights)]
        return float(finite.max()) if finite.size else 0.0

    @cached_property
    def is_level(self) -> bool:
        """True when all ground there is has one height: nothing to clear, nothing to climb."""
        finite = self.heights[np.isfinite(self.heights)]
        return bool(finite.size == 0 or finite.max() == finite.min())

    @cached_property
    def _crests(self) -> NDArray[np.float64]:
        """Highest ground within a foot radius of each cell; −inf over holes."""
        return _spread_max(_solid(self.heights), math.ceil(self.foot_radius / self.cell))

    @cached_property
    def crest_view(self) -> memoryview:
        """Highest ground within a foot radius of each cell, row by row; −inf over holes."""
        return self._crests.ravel().data

    def index(self, x: float, y: float) -> int:
        """Flat index of the cell under (x, y), −1 outside the map."""
        column, row = (
            math.floor((x - self.origin[0]) / self.cell),
            math.floor((y - self.origin[1]) / self.cell),
        )
        if 0 <= column < self.columns and 0 <= row < self.rows:
            return row * self.columns + column
        return -1

    def cell_at(self, x: float, y: float) -> tuple[int, int] | None:
        """(row, column) of the cell under (x, y), None outside the map."""
        flat = self.index(x, y)
        return None if flat < 0 else divmod(flat, self.columns)

    def centre(self, row: int, column: int) -> tuple[float, float]:
        """x, y of a cell's centre."""
        return self.origin[0] + (column + 0.5) * self.cell, self.origin[1] + (row + 0.5) * self.cell

    def allows(self, x: float, y: float) -> bool:
        """True when a foot may land at (x, y)."""
        flat = self.index(x, y)
        return flat >= 0 and not self.forbidden_bytes[flat]

    def height_at(self, x: float, y: float) -> float:
        """Believed ground height under (x, y), m; NaN over a hole and outside the map."""
        flat = self.index(x, y)
        return math.nan if flat < 0 else float(self.height_view[flat])

    def crest_between(self, ax: float, ay: float, bx: float, by: float) -> float:
        """Highest ground a foot passes on the straight way from a to b, m; −inf when there is none."""
        steps = max(1, math.ceil(math.hypot(bx - ax, by - ay) / self.cell))
        dx, dy = (bx - ax) / (steps * self.cell), (by - ay) / (steps * self.cell)
        fx, fy = (ax - self.origin[0]) / self.cell, (ay - self.origin[1]) / self.cell
        columns, rows, view, top = self.columns, self.rows, self.crest_view, -math.inf
        for _ in range(steps + 1):
            column, row = int(fx), int(fy)
            if 0 <= column < columns and 0 <= row < rows:
                height = view[row * columns + column]
                if height > top:
                    top = height
            fx += dx
            fy += dy
        return top

    def crest_in(self, x_min: float, x_max: float, y_min: float, y_max: float) -> float:
        """Highest ground in an axis-aligned rectangle, m; −inf when there is none."""
        c0, c1 = ((v - self.origin[0]) / self.cell for v in (x_min, x_max))
        r0, r1 = ((v - self.origin[1]) / self.cell for v in (y_min, y_max))
        patch = self.heights[
            max(0, math.floor(r0)) : max(0, math.floor(r1) + 1),
            max(0, math.floor(c0)) : max(0, math.floor(c1) + 1),
        ]
        solid = patch[~np.isnan(patch)]
        return float(solid.max()) if solid.size else -math.inf

    def forbid(self, cells: Iterable[tuple[int, int]]) -> TerrainMap:
        """A new map in which no foot may land on these (row, column) cells."""
        forbidden = self.forbidden.copy()
        for row, column in cells:
            if not (0 <= row < self.rows and 0 <= column < self.columns):
                raise ValueError(
                    f"cell ({row}, {column}) is outside the map of {self.rows} x {self.columns} cells"
                )
            forbidden[row, column] = True
        return replace(self, forbidden=forbidden)

    def patched(
        self,
        window: Window,
        heights: NDArray[np.float64],
        forbidden: NDArray[np.bool_],
        known: NDArray[np.bool_],
    ) -> TerrainMap:
        """A new map in which one rectangle of cells is replaced; what was worked out about the rest
        is kept.
        """
        new_heights, new_forbidden = self.heights.copy(), self.forbidden.copy()
        new_known = (
            np.ones(self.heights.shape, dtype=bool) if self.known is None else self.known.copy()
        )
        new_heights[window], new_forbidden[window], new_known[window] = heights, forbidden, known
        patched = replace(self, heights=new_heights, forbidden=new_forbidden, known=new_known)
        if "_crests" in self.__dict__:
            reach = math.ceil(self.foot_radius / self.cell)
            outer, inner = (
                grown(window, 2 * reach, self.heights.shape),
                grown(window, reach, self.heights.shape),
            )
            crests = self._crests.copy()
            crests[inner] = _spread_max(_solid(new_heights[outer]), reach)[within(inner, outer)]
            patched.__dict__["_crests"] = crests
        return patched


Window = tuple[slice, slice]  # rows and columns of a rectangle of cells


def grown(window: Window, by: int, shape: tuple[int, ...]) -> Window:
    """The rectangle with ``by`` more cells on every side, as far as the map goes."""
    rows, columns = (
        slice(max(0, side.start - by), min(size, side.stop + by))
        for side, size in zip(window, shape, strict=True)
    )
    return rows, columns


def within(inner: Window, outer: Window) -> Window:
    """Where a rectangle of the map lies in an array cut out by a larger one."""
    rows, columns = (
        slice(a.start - b.start, a.stop - b.start) for a, b in zip(inner, outer, strict=True)
    )
    return rows, columns


def _solid(heights: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(np.isnan(heights), -np.inf, heights)


class Kind(IntFlag):
    """What a cell is to one machine (H §2.3): the classes of HP-type ground."""

    O = 0  # noqa: E741  the paper's letter: walkable
    H = 1  # no ground, ground too steep, or no flat patch of foot size
    P = 2  # taller than it can step on
    HP = 3  # both: the rim of something tall


def kinds(
    heights: NDArray[np.float64],
    known: NDArray[np.bool_],
    cell: float,
    machine: Machine,
    final: bool = False,
) -> NDArray[np.uint8]:
    """G-type heights to the ``Kind`` of every cell, from the known cells alone; unknown ones are O
    and hide nothing.

    Where all is known this is ``classify``, told by kind. ``final``: only the cell under the foot
    tip counts, H are the holes.
    """
    holes = known & np.isnan(heights)
    if final:
        return holes.astype(np.uint8)
    solid = known & ~holes
    reach = _foot_cells(machine, cell)
    high = _spread_max(np.where(solid, heights, -np.inf), reach)
    low = -_spread_max(np.where(solid, -heights, -np.inf), reach)
    rough = (high - low > _relief_allowed(np.where(solid, heights, np.nan), reach)) | (
        _spread_max(holes.astype(np.float64), reach) > 0.0
    )
    steep = _slope(heights, solid, cell) > math.tan(SLOPE_MAX)
    tall = (
        heights
        - _mean_around(np.where(solid, heights, np.nan), max(1, round(RISE_WINDOW / cell / 2)))
        > RISE_MAX
    )
    low_kinds = holes | (solid & (rough | steep))
    return np.asarray(
        low_kinds * np.uint8(Kind.H) + (solid & tall) * np.uint8(Kind.P), dtype=np.uint8
    )


def _relief_allowed(heights: NDArray[np.float64], reach: int) -> NDArray[np.float64]:
    """Relief a foot may stand on at every cell, m: ``RELIEF_MAX``, or what an even slope has under
    it.

    The slope is the lesser of before and behind, so that the riser of a step is none; nor is what
    goes up or down both ways.
    """
    even = np.zeros(heights.shape)
    for axis in (0, 1):
        if heights.shape[axis] < 3:
            continue
        h, total = np.moveaxis(heights, axis, 0), np.moveaxis(even, axis, 0)
        before, behind = h[2:] - h[1:-1], h[1:-1] - h[:-2]
        total[1:-1] += np.where(
            before * behind > 0.0, np.minimum(np.abs(before), np.abs(behind)), 0.0
        )
    return np.maximum(RELIEF_MAX, SLOPING * 2 * reach * even)


def _slope(
    heights: NDArray[np.float64], solid: NDArray[np.bool_], cell: float
) -> NDArray[np.float64]:
    """Steepness between known neighbours: central where both are known, one-sided where one is,
    else 0.
    """
    steepness, filled = np.zeros(heights.shape), np.where(solid, heights, 0.0)
    for axis in (0, 1):
        h, stands = np.moveaxis(filled, axis, 0), np.moveaxis(solid, axis, 0)
        both = stands[1:] & stands[:-1]
        rise = np.where(both, h[1:] - h[:-1], 0.0)
        total, count = np.zeros(h.shape), np.zeros(h.shape)
        for side in (slice(1, None), slice(None, -1)):
            total[side] += rise
            count[side] += both
        steepness = np.hypot(steepness, np.moveaxis(total / np.maximum(count, 1.0) / cell, 0, axis))
    return steepness


def classify(heights: NDArray[np.float64], cell: float, machine: Machine) -> NDArray[np.bool_]:
    """Where ``machine`` must not land, from heights alone: the step from G-type to HP-type terrain
    (H §2.3).

    H: no ground, slope over 35 degrees, or more than 0.03 m of relief under the foot that is no
    even slope; P: over 0.30 m above the ground around.
    """
    holes = np.isnan(heights)
    if holes.all():
        return np.ones(heights.shape, dtype=bool)
    solid = heights[~holes]
    if solid.max() == solid.min():
        return _spread_max(holes.astype(np.float64), _foot_cells(machine, cell)) > 0.0
    reach = _foot_cells(machine, cell)
    high = _spread_max(np.where(holes, -np.inf, heights), reach)
    # a hole under the foot's rim makes relief infinite
    low = -_spread_max(np.where(holes, np.inf, -heights), reach)
    with np.errstate(invalid="ignore"):  # nothing but holes under the foot: −inf less −inf
        rough = ~(high - low <= _relief_allowed(heights, reach))
    filled = np.where(holes, np.nanmean(heights), heights)
    slope_y, slope_x = (
        np.gradient(filled, cell, axis=axis) if filled.shape[axis] > 1 else np.zeros_like(filled)
        for axis in (0, 1)
    )
    steep = np.hypot(slope_x, slope_y) > math.tan(SLOPE_MAX)
    tall = filled - _mean_around(heights, max(1, round(RISE_WINDOW / cell / 2))) > RISE_MAX
    return np.asarray(holes | rough | steep | tall, dtype=bool)


def classify_again(
    heights: NDArray[np.float64],
    forbidden: NDArray[np.bool_],
    cell: float,
    machine: Machine,
    cells: Sequence[tuple[int, int]],
) -> NDArray[np.bool_]:
    """``forbidden`` brought up to date after the heights of some (row, column) cells have changed:
    only their surroundings are read.
    """
    near = max(_foot_cells(machine, cell) + 1, round(RISE_WINDOW / cell / 2) + 1)
    rows, columns = [row for row, _ in cells], [column for _, column in cells]
    r0, r1 = max(0, min(rows) - near), max(rows) + near + 1
    c0, c1 = max(0, min(columns) - near), max(columns) + near + 1
    top, left = max(0, r0 - near), max(0, c0 - near)
    patch = classify(heights[top : r1 + near, left : c1 + near], cell, machine)
    again = forbidden.copy()
    inner = again[r0:r1, c0:c1]
    inner[:] = patch[r0 - top : r0 - top + inner.shape[0], c0 - left : c0 - left + inner.shape[1]]
    return again


def _foot_cells(machine: Machine, cell: float) -> int:
    """How many whole cells the sole's rim reaches beyond the cell under its tip."""
    return math.floor(machine.foot_radius / cell + 1e-9)


def _spread_max(values: NDArray[np.float64], reach: int) -> NDArray[np.float64]:
    """Largest value within ``reach`` cells in rows and columns."""
    out = values.copy()
    for axis in (0, 1):
        source = out.copy()
        for shift in range(1, reach + 1):
            ahead: Any = [slice(None), slice(None)]
            behind: Any = [slice(None), slice(None)]
            ahead[axis], behind[axis] = slice(shift, None), slice(None, -shift)
            ahead, behind = tuple(ahead), tuple(behind)
            np.maximum(out[behind], source[ahead], out=out[behind])
            np.maximum(out[ahead], source[behind], out=out[ahead])
    return out


def _mean_around(heights: NDArray[np.float64], reach: int) -> NDArray[np.float64]:
    """Mean of the ground that exists in the square of ``reach`` cells around each cell."""
    exists = ~np.isnan(heights)
    total = _box_sum(np.where(exists, heights, 0.0), reach)
    count = _box_sum(exists.astype(np.float64), reach)
    return np.asarray(total / np.maximum(count, 1.0))


def _box_sum(values: NDArray[np.float64], reach: int) -> NDArray[np.float64]:
    padded = np.pad(values, ((reach + 1, reach), (reach + 1, reach)))
    summed = padded.cumsum(axis=0).cumsum(axis=1)
    side = 2 * reach + 1
    return np.asarray(
        summed[side:, side:]
        - summed[:-side, side:]
        - summed[side:, :-side]
        + summed[:-side, :-side]
    )
