"""The ground in the scene: tiles sent again where they changed, and the heights that lie under."""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np
import viser

from walking_console.planner.geometry.transforms import XY
from walking_console.sim.snapshot import TerrainView, WholeMap

from .far_terrain import look_over, mesh_of, sheets_around
from .terrain import TerrainMesh, Tile, Window, floor
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
        self._looks: Floats | None = None  # heights all over a wide map when it was new

    def draw(self, view: TerrainView) -> None:
        """Show this ground: nothing is sent where it is the same as before."""
        if self.view is not None and _same_ground(view, self.view):
            return
        mesh = self._mesh(view)
        self._relief = mesh.relief
        wanted = [(tile, mesh) for tile in mesh.tiles()]
        wanted += self._far(view, mesh.relief)
        fresh = [(tile, mesh.draw(tile)) for tile, mesh in wanted if self._differs(tile)]
        with self.server.atomic():
            self._remove_all_but({tile.name for tile, _ in wanted})
            for tile, data in fresh:
                self.tiles[tile.name] = (tile, self._show(tile.name, data))
            self._show_floor(mesh, view)
        self.view = view

    def _mesh(self, view: TerrainView) -> TerrainMesh:
        """The ground at hand in the colours of its world."""
        if view.whole is not None:
            relief = self._relief_of(view.whole)
            corner = view.corner
            return TerrainMesh(
                view.heights,
                view.forbidden,
                view.cell,
                view.origin,
                relief,
                corner=corner,
                is_part=True,
            )
        self._looks = None
        relief = self._relief if self.view is not None and _is_edit_of(self.view, view) else None
        return TerrainMesh(view.heights, view.forbidden, view.cell, view.origin, relief)

    def _relief_of(self, whole: WholeMap) -> tuple[float, float] | None:
        """Lowest and highest ground of a wide map, m, as far as it is looked over; the same as
        before after an edit.
        """
        looks = look_over(whole)
        if self._looks is not None and _are_alike(self._looks, looks):
            return self._relief
        self._looks = looks
        solid = looks[np.isfinite(looks)]
        return (float(solid.min()), float(solid.max())) if solid.size else None

    def _far(
        self, view: TerrainView, relief: tuple[float, float]
    ) -> list[tuple[Tile, TerrainMesh]]:
        """What lies beyond the window of a wide map, each sheet with its key."""
        if view.whole is None:
            return []
        (ny, nx), (row, column) = view.heights.shape, view.corner
        window = (row, row + ny), (column, column + nx)
        found = []
        for sheet in sheets_around(window, view.whole.shape):
            mesh = mesh_of(sheet, view.whole, view.cell, relief)
            rows, columns = mesh.heights.shape
            extent = Window(0, rows, 0, columns)
            found.append((Tile(sheet.name, mesh.key(extent), extent), mesh))
        return found

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
    places = (old.cell, old.origin), (new.cell, new.origin)
    return places[0] == places[1] and _are_alike(old.heights, new.heights)


def _are_alike(old: Floats, new: Floats) -> bool:
    """Whether most heights are the same."""
    if old.shape != new.shape:
        return False
    same = (old == new) | (np.isnan(old) & np.isnan(new))
    return float(np.mean(~same)) < EDITED_MOST


def _same_ground(a: TerrainView, b: TerrainView) -> bool:
    if a is b:
        return True
    same = a.heights is b.heights and a.forbidden is b.forbidden and a.whole is b.whole
    return a.revision == b.revision and same
