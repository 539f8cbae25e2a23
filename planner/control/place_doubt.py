"""How far a machine may be from where it takes itself to be, and what footholds keep from holes
for it.

Leg odometry drifts by a share of the way. A map that the machine has made itself drifts along, but
in one it was given every hole is beside where it seems to be, by as much at last.
"""

from __future__ import annotations

import math

from ..geometry.transforms import XY
from ..terrain.map import TerrainMap
from ..types import Sensing

MARK = 0.05  # m between places from which the way is counted on: a body that sways gets nowhere
GRAIN = 0.005  # m by which footholds keep farther off at a time
FARTHEST = 0.03  # m; more: see a long walk run out of footholds
MIDDLE = 0.49  # of a cell; more leaves none beside a hole


class PlaceDoubt:
    """Counts the way walked by odometry that drifts by a share of it."""

    def __init__(self, drift: float) -> None:
        self._drift = drift
        self._way = 0.0
        self._mark: XY | None = None
        self._given: TerrainMap | None = None
        self._cautious: TerrainMap | None = None

    def cautious(self, sensing: Sensing, terrain: TerrainMap) -> TerrainMap:
        """The map with footholds as far from the bottomless as the machine may be off by now."""
        if self._drift <= 0.0:
            return terrain
        self._count(sensing.body[0], sensing.body[1])
        edge = self._edge(terrain)
        if edge <= terrain.edge:
            return terrain
        kept = self._cautious
        if kept is None or self._given is not terrain or kept.edge != edge:
            self._given = terrain
            self._cautious = kept = terrain.keeping_off(edge)
        return kept

    def _count(self, x: float, y: float) -> None:
        mark = self._mark
        if mark is None:
            self._mark = x, y
            return
        way = math.hypot(x - mark[0], y - mark[1])
        if way >= MARK:
            self._mark = x, y
            self._way += way

    def _edge(self, terrain: TerrainMap) -> float:
        """What footholds keep from the bottomless, m."""
        if terrain.known is not None or terrain.edge <= 0.0 or not terrain.holes_bytes:
            return terrain.edge
        off = min(GRAIN * math.floor(self._drift * self._way / GRAIN), FARTHEST)
        middle = MIDDLE * terrain.cell
        return min(off, middle) if middle > terrain.edge else off
