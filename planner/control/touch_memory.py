"""What touch has shown of the ground, until the map is told of it (H §9.2 (f), last sentence).

Prohibited cells are those no foot may land on again. Heights are lower bounds of what was felt
beside a foot; NaN is a hole: nothing down to the bottom of the reach.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

from ..config import Contact
from ..geometry.transforms import placed
from ..terrain.map import TerrainMap
from ..types import Point

CellSet = set[tuple[int, int]]  # row, column


@dataclass(slots=True)
class Felt:
    """``prohibited`` cells, and ``heights`` (m) of cells: at least this high, or NaN."""

    prohibited: CellSet = field(default_factory=set)
    heights: dict[tuple[int, int], float] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.prohibited or self.heights)

    def raise_to(self, cells: Iterable[tuple[int, int]], height: float) -> None:
        """These cells are at least so high, m."""
        for cell in cells:
            known = self.heights.get(cell, -math.inf)
            self.heights[cell] = height if math.isnan(known) else max(known, height)

    def dig(self, cells: Iterable[tuple[int, int]]) -> None:
        """There is no ground in these cells; what was felt standing there stays."""
        for cell in cells:
            self.heights.setdefault(cell, math.nan)


def edge_cells(foot: Point, bearing: float, terrain: TerrainMap, settings: Contact) -> CellSet:
    """Cells of a rectangle along an edge that was felt in direction ``bearing`` from the foot (H
    §9.2, last sentence).
    """
    return cells_ahead(foot, bearing, terrain, (settings.edge_length, settings.edge_depth))


def cells_ahead(
    foot: Point, bearing: float, terrain: TerrainMap, size: tuple[float, float]
) -> CellSet:
    """Cells of a rectangle of this length and depth, m, across the direction ``bearing`` from the
    foot.
    """
    length, depth = size
    across = max(1, math.ceil(depth / (terrain.cell / 2)))
    along = max(1, math.ceil(length / (terrain.cell / 2)))
    pose = (foot[0], foot[1], bearing)
    cells = (
        terrain.cell_at(*placed(pose, depth * i / across, length * j / along - length / 2))
        for i in range(across + 1)
        for j in range(along + 1)
    )
    return {cell for cell in cells if cell is not None}


def cells_near(foot: Point, radius: float, terrain: TerrainMap) -> CellSet:
    """Cells whose centre is within ``radius`` of a foot, seen from above."""
    reach = math.ceil(radius / terrain.cell)
    at = terrain.cell_at(foot[0], foot[1])
    if at is None:
        return set()
    rows = range(max(0, at[0] - reach), min(terrain.rows - 1, at[0] + reach) + 1)
    columns = range(max(0, at[1] - reach), min(terrain.columns - 1, at[1] + reach) + 1)
    centres = ((row, column, *terrain.centre(row, column)) for row in rows for column in columns)
    return {
        (row, column)
        for row, column, x, y in centres
        if math.hypot(x - foot[0], y - foot[1]) <= radius
    }


def cell_of(foot: Point, terrain: TerrainMap) -> CellSet:
    """The one cell under a foot, if the map has it."""
    cell = terrain.cell_at(foot[0], foot[1])
    return set() if cell is None else {cell}
