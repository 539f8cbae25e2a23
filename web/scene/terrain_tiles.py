"""The ground in the scene: tiles sent again where they changed, and the heights that lie under."""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np
import viser

from walking_console.planner.geometry.transforms import XY
from walking_console.sim.snapshot import TerrainView

from .terrain import TerrainMesh, Tile, floor
from .types import Floats

RAY_STEP = 0.02  # m along a click's ray between looks at the ground
RAY_MAX = 40.0  # m
EDITED_MOST = 0.2  # share of a map's cells; more: another world, with colours of its own


class TerrainTiles:
    """The ground, drawn again tile by tile where it changed."""

    def __init__(self, server: viser.ViserServer) -> None:
        self.server = server
        self.view: TerrainView | None = None
        self.tiles: dict[str, tuple[Tile, viser.GlbHandle]] = {}
        self.floor: viser.GlbHandle | None = None
        self._relief: tuple[float, float] | None = None  # of this world when it was new

    def draw(self, view: TerrainView) -> None:
        """Show this ground: nothing is sent where it is the same as before."""
        if self.view is not None and _same_ground(view, self.view):
            return
        relief = self._relief if self.view is not None and _is_edit_of(self.view, view) else None
        mesh = TerrainMesh(view.heights, view.forbidden, view.cell, view.origin, relief)
        self._relief = mesh.relief
        wanted = mesh.tiles()
        fresh = [(tile, mesh.draw(tile)) for tile in wanted if self._differs(tile)]
        with self.server.atomic():
            self._remove_all_but({tile.name for tile in wanted})
            for tile, data in fresh:
                self.tiles[tile.name] = (tile, self._show(tile.name, data))
            self._show_floor(mesh, view)
        self.view = view

    def _differs(self, tile: Tile) -> bool:
        return tile.name not in self.tiles or self.tiles[tile.name][0].key != tile.key

    def _remove_all_but(self, names: Collection[str]) -> None:
        for name in self.tiles.keys() - set(names):
            self.tiles.pop(name)[1].remove()

    def _show(self, name: str, data: bytes) -> viser.GlbHandle:
        if name in self.tiles:
            handle = self.tiles[name][1]
            handle.glb_data = data
            return handle
        return self._glb(name, data)

    def _glb(self, name: str, data: bytes) -> viser.GlbHandle:
        return self.server.scene.add_glb(
            f"/world/ground/{name}", data, cast_shadow=False, receive_shadow=False
        )

    def _show_floor(self, mesh: TerrainMesh, view: TerrainView) -> None:
        """The dark floor under the holes; without holes it would only be painted over."""
        old = self.view
        if old is None or view.origin != old.origin or view.heights.shape != old.heights.shape:
            self.floor = self._glb("floor", floor(mesh))
        assert self.floor is not None
        self.floor.visible = bool(np.isnan(view.heights).any())

    def height(self, x: float, y: float, otherwise: float) -> float:
        """Ground height under a point, m; ``otherwise`` over holes and outside."""
        view = self.view
        assert view is not None
        column = int((x - view.origin[0]) // view.cell)
        row = int((y - view.origin[1]) // view.cell)
        rows, columns = view.heights.shape
        if not (0 <= row < rows and 0 <= column < columns):
            return otherwise
        height = float(view.heights[row, column])
        return otherwise if math.isnan(height) else height

    def floor_at(self, x: float, y: float) -> float:
        """Ground height under a point, m; the lowest ground over holes and outside, and nothing at
        all before there is any.
        """
        if self.view is None or not np.isfinite(self.view.heights).any():
            return -math.inf
        return self.height(x, y, float(np.nanmin(self.view.heights)))

    def heights(self, points: Floats, otherwise: float) -> Floats:
        """Ground heights under many points (n, 2), m; ``otherwise`` over holes and outside."""
        view = self.view
        assert view is not None
        column, row = (((points[:, k] - view.origin[k]) // view.cell).astype(int) for k in (0, 1))
        rows, columns = view.heights.shape
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        found = np.full(len(points), np.nan)
        found[inside] = view.heights[row[inside], column[inside]]
        return np.where(np.isnan(found), otherwise, found)

    def hit(self, origin: Floats, direction: Floats) -> XY | None:
        """Where a ray first meets the ground; None outside the map.

        Holes are met at the height of the ground around them.
        """
        if self.view is None:
            return None
        along = np.arange(0.0, RAY_MAX, RAY_STEP)[:, None]
        points = origin + direction / np.linalg.norm(direction) * along
        solid = self.view.heights[np.isfinite(self.view.heights)]
        level = float(np.median(solid)) if solid.size else 0.0
        below = np.flatnonzero(points[:, 2] <= self.heights(points[:, :2], level))
        if not below.size:
            return None
        x, y = points[below[0], :2].tolist()
        return (x, y) if _is_on(self.view, x, y) else None


def _is_on(view: TerrainView, x: float, y: float) -> bool:
    rows, columns = view.heights.shape
    inside_x = bool(0.0 <= x - view.origin[0] < columns * view.cell)
    inside_y = bool(0.0 <= y - view.origin[1] < rows * view.cell)
    return inside_x and inside_y


def _is_edit_of(old: TerrainView, new: TerrainView) -> bool:
    """Whether this is the same map, but for a few cells: its colours stay."""
    places = (old.cell, old.origin, old.heights.shape), (new.cell, new.origin, new.heights.shape)
    if places[0] != places[1]:
        return False
    same = (old.heights == new.heights) | (np.isnan(old.heights) & np.isnan(new.heights))
    return float(np.mean(~same)) < EDITED_MOST


def _same_ground(a: TerrainView, b: TerrainView) -> bool:
    if a is b:
        return True
    return a.revision == b.revision and a.heights is b.heights and a.forbidden is b.forbidden
