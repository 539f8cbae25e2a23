"""Triangle meshes: STL, PLY and OBJ, seen from above.

The ground is the upper surface. A vertical riser covers no cell, so that none falls through it:
every cell takes the highest triangle over its centre, and cells over which there is none take the
lowest height of the mesh (the floor it stands on). trimesh reads the files; their materials and
textures are not looked at.
"""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from walking_console.planner.types import Array

from ..generators import GroundError
from .raster import CELLS_MAX, Raster

FILE_BYTES_MAX = 128_000_000
TRIANGLES_MAX = 1_000_000
UPRIGHT = 1e-9  # m²; a triangle with less area seen from above is upright
TOUCHING = 1e-7  # of barycentric coordinates: a centre on an edge belongs to both triangles
ON_ITS_SIDE = 1.5  # times as much area facing y as z, from which a mesh is no ground
STL_HEAD = 84  # bytes before the triangles of a binary STL; the last four count them
BATCH = 4096  # triangles between two looks at the size


def read_mesh(path: Path) -> Raster:
    """The triangles of a mesh; heights come from ``surface`` once scale and cell are known."""
    if path.stat().st_size > FILE_BYTES_MAX:
        raise GroundError(f"{path.stat().st_size} bytes; at most {FILE_BYTES_MAX}")
    triangles = _triangles(path)
    low, high = triangles.reshape(-1, 3).min(axis=0), triangles.reshape(-1, 3).max(axis=0)
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        raise GroundError("a corner of the mesh is no number")
    corners = np.array([[low[2], low[2]], [low[2], low[2]]])
    what = f"mesh of {len(triangles)} triangles"
    return Raster(corners, what, surface=partial(_rasterised, triangles, what))


def _triangles(path: Path) -> Array:
    import trimesh

    kind = path.suffix.lower().removeprefix(".")
    loaded: Any = trimesh.load(
        path, file_type=kind, force="mesh", process=False, skip_materials=True
    )
    triangles = np.asarray(getattr(loaded, "triangles", np.zeros((0, 3, 3))), dtype=np.float64)
    if not len(triangles):
        raise GroundError(_cut_short(path) or "there are no triangles in it")
    if len(triangles) > TRIANGLES_MAX:
        raise GroundError(f"{len(triangles)} triangles; at most {TRIANGLES_MAX}")
    return triangles


def _upright(triangles: Array, up: str | None) -> Array:
    """The triangles with z up. Where nobody says which axis is, z is, unless more of the mesh faces
    y than z, which ground does not.
    """
    if up == "y":
        return triangles[..., [0, 2, 1]] * (1.0, -1.0, 1.0)
    sides = triangles[:, 1:] - triangles[:, :1]
    facing = np.abs(np.cross(sides[:, 0], sides[:, 1])).sum(axis=0)
    if up is None and facing[1] > ON_ITS_SIDE * facing[2]:
        raise GroundError(
            f"more of it faces y than z ({facing[1] / 2:.3g} to {facing[2] / 2:.3g}), as if y were "
            'up: set up = "y", or up = "z" if it is right as it is'
        )
    return triangles


def _cut_short(path: Path) -> str:
    """What is wrong with a binary STL that holds other triangles than it announces; else ""."""
    with path.open("rb") as file:
        head = file.read(STL_HEAD)
    size = path.stat().st_size
    if path.suffix.lower() != ".stl" or len(head) < STL_HEAD or head.lstrip()[:5] == b"solid":
        return ""
    count = int.from_bytes(head[-4:], "little")
    return f"a binary STL of {count} triangles has {STL_HEAD + 50 * count} bytes, it has {size}"


def _rasterised(triangles: Array, what: str, scale: float, cell: float, up: str | None) -> Raster:
    """The upper surface in square cells; rows and columns begin at the mesh's least x and y."""
    upright = _upright(triangles, up)
    size = np.ptp(upright.reshape(-1, 3), axis=0)
    if min(size[:2]) <= 0.0:
        raise GroundError("seen from above the mesh has no area")
    what = f"{what}, {size[0]:g} x {size[1]:g}"
    scaled = upright * scale
    low = scaled.reshape(-1, 3).min(axis=0)
    high = scaled.reshape(-1, 3).max(axis=0)
    nx = max(2, math.ceil((high[0] - low[0]) / cell - 1e-9))
    ny = max(2, math.ceil((high[1] - low[1]) / cell - 1e-9))
    if ny * nx > CELLS_MAX:
        raise GroundError(
            f"its {high[0] - low[0]:g} x {high[1] - low[1]:g} m are {nx} x {ny} cells of {cell:g} "
            f"m; at most {CELLS_MAX}: set scale = 0.001 if it is in millimetres, or cell"
        )
    heights = np.full((ny, nx), -np.inf)
    for triangle in scaled:
        _lay(heights, triangle - (low[0], low[1], 0.0), cell)
    heights[np.isinf(heights)] = low[2]
    return Raster(heights, what, (cell, cell), (float(low[0]), float(low[1])), scaled=True)


def _lay(heights: Array, triangle: Array, cell: float) -> None:
    """Raise the cells whose centre lies under a triangle to its height there."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = triangle
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    if abs(area) < UPRIGHT:
        return
    ny, nx = heights.shape
    c0 = max(0, math.floor(min(ax, bx, cx) / cell - 0.5))
    c1 = min(nx, math.ceil(max(ax, bx, cx) / cell + 0.5))
    r0 = max(0, math.floor(min(ay, by, cy) / cell - 0.5))
    r1 = min(ny, math.ceil(max(ay, by, cy) / cell + 0.5))
    x = ((np.arange(c0, c1) + 0.5) * cell)[np.newaxis, :]
    y = ((np.arange(r0, r1) + 0.5) * cell)[:, np.newaxis]
    u = ((by - cy) * (x - cx) + (cx - bx) * (y - cy)) / area
    v = ((cy - ay) * (x - cx) + (ax - cx) * (y - cy)) / area
    w = 1.0 - u - v
    inside = (u >= -TOUCHING) & (v >= -TOUCHING) & (w >= -TOUCHING)
    window = heights[r0:r1, c0:c1]
    np.maximum(window, np.where(inside, u * az + v * bz + w * cz, -np.inf), out=window)
