"""A polygon laid over the ground like a cloth, so that steps do not hide it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .terrain_tiles import TerrainTiles
from .types import Floats, Indices, Segments

FOLDS = 8  # small triangles a side; fewer: edges of steps cut through it
CORNERS = 8  # corners a support polygon can have: as many as a machine can have legs
LIFT = 0.03  # m, what is drawn on the ground lies this high above it; less: it flickers through
EDGE_LIFT = LIFT + 0.004  # m, its edge lies on top of it


def _patch() -> Floats:
    """Weights (n, 3) of the points of a triangle cut into FOLDS² small ones.

    Of its first corner (the polygon's middle), then of the two outer ones.
    """
    rows = range(FOLDS + 1)
    return np.array(
        [(1 - i / FOLDS, (i - j) / FOLDS, j / FOLDS) for i in rows for j in range(i + 1)]
    )


PATCH = _patch()
VERTICES = CORNERS * len(PATCH)


def draped_faces() -> Indices:
    """The small triangles of all corners' patches, (F, 3)."""
    at = {(i, j): i * (i + 1) // 2 + j for i in range(FOLDS + 1) for j in range(i + 1)}
    up = [(at[i, j], at[i + 1, j], at[i + 1, j + 1]) for i in range(FOLDS) for j in range(i + 1)]
    down = [(at[i, j], at[i + 1, j + 1], at[i, j + 1]) for i in range(FOLDS) for j in range(i)]
    patch = np.array(up + down)
    return np.concatenate([patch + corner * len(PATCH) for corner in range(CORNERS)])


def drape(ring: Floats, terrain: TerrainTiles) -> tuple[NDArray[np.float32], Segments]:
    """A polygon (n, 3) laid over the ground: vertices (V, 3), and its edge as line segments.

    Never below the plane of its own corners.
    """
    missing = CORNERS - len(ring)
    ring = np.concatenate([ring, np.repeat(ring[-1:], missing, axis=0)])
    following = np.roll(ring, -1, axis=0)
    middle = np.unique(ring, axis=0).mean(axis=0)
    sides = list(zip(ring, following, strict=True))
    mesh = np.concatenate([PATCH @ np.stack([middle, a, b]) for a, b in sides])
    share = np.linspace(0.0, 1.0, FOLDS + 1)[:, None]
    edge = np.concatenate([a * (1 - share) + b * share for a, b in sides])
    for points, lift in ((mesh, LIFT), (edge, EDGE_LIFT)):
        points[:, 2] = np.maximum(points[:, 2], terrain.heights(points[:, :2], -math.inf)) + lift
    chains = edge.reshape(CORNERS, FOLDS + 1, 3)
    pieces = np.stack([chains[:, :-1], chains[:, 1:]], axis=2).reshape(-1, 2, 3)
    return mesh.astype(np.float32), pieces.astype(np.float32)
