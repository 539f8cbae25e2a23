"""Terrain edits as they come in, as requests to the simulation."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from walking_console.sim.requests import EDIT_CELLS_MAX, Edit
from walking_console.sim.snapshot import TerrainView
from walking_console.sim.terrain.areas import CellList, cells_in_circle, cells_in_rectangle

from ..schemas import CircleArea, RectangleArea, TerrainBody
from .errors import HTTPProblem

EDITS_A_TICK = 1  # of those that clients ask for; more: ticks come late
STROKES_A_TICK = 8  # of the brush, those of the clients counted
BRUSH_AMOUNT = 0.05  # m, one touch of the page's brush


def painted(brush: str, x: float, y: float, radius: float) -> TerrainBody:
    """One touch of a brush on the page: dig, raise, lower, forbid or clear a circle."""
    amount = {"raise": BRUSH_AMOUNT, "lower": -BRUSH_AMOUNT}.get(brush)
    body: dict[str, Any] = {
        "action": "raise" if brush == "lower" else brush,
        "circle": {"x_m": x, "y_m": y, "radius_m": radius},
        "amount_m": amount,
    }
    return TerrainBody.model_validate(body)


def packed_terrain(terrain: TerrainView) -> bytes:
    """The ground as a .npz file, which a scenario can walk on again; of a wide map the window about
    the machine, and its ``place``: row, column, and rows and columns of the whole map.
    """
    packed = io.BytesIO()
    arrays = {
        "heights": terrain.heights.astype(np.float32),
        "cell": np.array(terrain.cell),
        "origin": np.array(terrain.origin),
        "forbidden": terrain.forbidden,
    }
    if terrain.whole is not None:
        arrays["place"] = np.array([*terrain.corner, *terrain.whole_shape])
    np.savez_compressed(packed, **arrays)  # type: ignore[arg-type]
    return packed.getvalue()


def edit_under(body: TerrainBody, terrain: TerrainView) -> Edit:
    """A terrain edit by its cells; raises ``HTTPProblem`` when it is not on the map."""
    return Edit(body.action, _cells_of(body, terrain), body.amount_m or 0.0)


def _cells_of(body: TerrainBody, terrain: TerrainView) -> CellList:
    if body.circle is not None:
        return _covered("circle", _in_circle(body.circle, terrain))
    if body.rectangle is not None:
        return _covered("rectangle", _in_rectangle(body.rectangle, terrain))
    assert body.cells is not None
    return _on_the_map(body.cells, terrain)


def _in_circle(area: CircleArea, terrain: TerrainView) -> CellList:
    return cells_in_circle(terrain, area.x_m, area.y_m, area.radius_m)


def _in_rectangle(area: RectangleArea, terrain: TerrainView) -> CellList:
    high = (area.x_m + area.width_m, area.y_m + area.depth_m)
    return cells_in_rectangle(terrain, (area.x_m, area.y_m), high)


def _covered(name: str, cells: CellList) -> CellList:
    """Some of the map and not too much of it."""
    if 1 <= len(cells) <= EDIT_CELLS_MAX:
        return cells
    limit = {"ge": 1, "le": EDIT_CELLS_MAX}
    detail = f"{name} covers {len(cells)} cells of the map; it must cover 1 to {EDIT_CELLS_MAX}"
    raise HTTPProblem(422, detail, field=name, value=len(cells), limit=limit)


def _on_the_map(cells: list[list[int]], terrain: TerrainView) -> CellList:
    ny, nx = terrain.whole_shape
    for row, column in cells:
        if row >= ny or column >= nx:
            raise HTTPProblem(
                422,
                f"cell [{row}, {column}] is not on the map of {ny} rows and {nx} columns",
                field="cells",
                value=[row, column],
                limit={"rows": ny, "columns": nx},
            )
    return tuple((row, column) for row, column in cells)
