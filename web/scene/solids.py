"""Solids and flat rings as vertices and faces, from which the machine and its marks are built."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from walking_console.planner.geometry.transforms import direction

from .types import Floats, Indices

Outline = Floats  # (n, 2), counter-clockwise
Solid = tuple[Floats, Indices]  # vertices (V, 3), faces (F, 3)
RoundSolid = tuple[Floats, Indices, Floats]  # the same with vertex normals (V, 3)


def loft(stations: Sequence[tuple[float, Outline]], axis: int = 0) -> Solid:
    """A closed skin over outlines placed along an axis, capped at both ends.

    Outlines (n, 2) of equal n; they are y, z along ``axis`` 0 and x, y along ``axis`` 2.
    """
    rings = [_ring(at, outline, axis) for at, outline in stations]
    count = len(stations[0][1])
    caps = [rings[0].mean(axis=0)[None], rings[-1].mean(axis=0)[None]]
    vertices = np.concatenate([*rings, *caps])
    bottom = len(vertices) - 2
    last = (len(rings) - 1) * count
    i = np.arange(count)
    j = (i + 1) % count
    bottom_fan = np.stack([np.full(count, bottom), j, i], 1)
    top_fan = np.stack([np.full(count, bottom + 1), last + i, last + j], 1)
    return vertices, np.concatenate([_skin(len(rings), count), bottom_fan, top_fan])


def _ring(at: float, outline: Outline, axis: int) -> Floats:
    across = np.full((len(outline), 1), at)
    return np.hstack([across, outline] if axis == 0 else [outline, across])


def _skin(rings: int, count: int) -> Indices:
    """Faces between neighbouring rings of ``count`` vertices."""
    i = np.arange(count)
    j = (i + 1) % count
    faces = []
    for first in range(0, (rings - 1) * count, count):
        following = first + count
        faces.append(np.stack([first + i, first + j, following + j], 1))
        faces.append(np.stack([first + i, following + j, following + i], 1))
    return np.concatenate(faces)


def octagon(half_width: float, half_height: float, chamfer: float, lift: float = 0.0) -> Outline:
    """A rectangle with cut corners, counter-clockwise, its middle at height ``lift``."""
    w = half_width
    h = half_height
    c = min(chamfer, w, h)
    right = [(w, -h + c), (w, h - c), (w - c, h)]
    left = [(-w + c, h), (-w, h - c), (-w, -h + c)]
    below = [(-w + c, -h), (w - c, -h)]
    return np.array([*right, *left, *below]) + (0.0, lift)


def circle(radius: float, count: int = 20) -> Outline:
    """Points of a circle about the origin, counter-clockwise from +x."""
    points = radius * np.exp(2j * np.pi * np.arange(count) / count)
    return np.stack([points.real, points.imag], axis=1)


def revolution(profile: Sequence[tuple[float, float]], count: int = 20) -> RoundSolid:
    """A body of revolution about z from (z, radius) pairs, with smooth normals round its side."""
    table = np.array(profile)
    around = circle(1.0, count)
    vertices = np.concatenate([np.hstack([around * r, np.full((count, 1), z)]) for z, r in table])
    slope = np.gradient(table[:, 1], table[:, 0])
    normals = np.concatenate([np.hstack([around, np.full((count, 1), -s)]) for s in slope])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return vertices, _skin(len(table), count), normals


def ball(radius: float, count: int = 18) -> RoundSolid:
    """A sphere about the origin; the normals of the unit sphere are its points."""
    tilt = np.linspace(-np.pi / 2, np.pi / 2, count // 2 + 1)
    sides = [direction(t) for t in tilt.tolist()]  # radius and height of each ring
    rings = [np.hstack([circle(r, count), np.full((count, 1), z)]) for r, z in sides]
    normals = np.concatenate(rings)
    return normals * radius, _skin(len(tilt), count), normals


def disc(inner: float, outer: float, count: int = 28) -> Solid:
    """A level ring facing up; a disc when ``inner`` is 0."""
    around = circle(1.0, count)
    flat = np.concatenate([around * inner, around * outer])
    i = np.arange(count)
    j = (i + 1) % count
    faces = [np.stack([i, count + i, count + j], 1), np.stack([i, count + j, j], 1)]
    return np.hstack([flat, np.zeros((2 * count, 1))]), np.concatenate(faces)
