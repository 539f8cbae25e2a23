"""Convex polygons as lists of corners, counter-clockwise: cutting them, and their nearest points.

Plain floats throughout: planning loops cut polygons of four corners by the thousand.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

XY = tuple[float, float]

ROUNDING = 1e-9 / 4  # a corner this far outside a cut is on it: a polygon may be a mere line


def clipped(corners: list[XY], a: float, b: float, c: float) -> list[XY]:
    """The part of a polygon where a·x + b·y + c >= 0, but for rounding: a polygon that is a mere
    line is not lost.
    """
    kept: list[XY] = []
    for (px, py), (qx, qy) in zip(corners, corners[1:] + corners[:1], strict=True):
        p = a * px + b * py + c
        q = a * qx + b * qy + c
        if p >= -ROUNDING:
            kept.append((px, py))
        if (p > ROUNDING and q < -ROUNDING) or (p < -ROUNDING and q > ROUNDING):
            w = p / (p - q)
            kept.append((px + w * (qx - px), py + w * (qy - py)))
    return kept


def beside(corners: list[XY], a: XY, b: XY, inset: float) -> list[XY]:
    """The part of a polygon at least ``inset`` to the left of the line from a to b."""
    ex = b[0] - a[0]
    ey = b[1] - a[1]
    length = math.hypot(ex, ey)
    kept: list[XY] = []
    for (px, py), (qx, qy) in zip(corners, corners[1:] + corners[:1], strict=True):
        p = (ex * (py - a[1]) - ey * (px - a[0])) / length - inset
        q = (ex * (qy - a[1]) - ey * (qx - a[0])) / length - inset
        if p >= 0.0:
            kept.append((px, py))
        if (p > 0.0 > q) or (p < 0.0 < q):
            w = p / (p - q)
            kept.append((px + w * (qx - px), py + w * (qy - py)))
    return kept


def inside_of(
    corners: Iterable[XY], polygon: Sequence[XY], inset: float, dx: float = 0.0, dy: float = 0.0
) -> list[XY]:
    """The part of a polygon whose points, moved by (dx, dy), are inside another by ``inset``."""
    moved = [(x - dx, y - dy) for x, y in polygon]
    kept = list(corners)
    for a, b in zip(moved, moved[1:] + moved[:1], strict=True):
        kept = beside(kept, a, b, inset)
    return kept


def nearest_of(corners: list[XY], x: float, y: float) -> XY:
    """The point of a polygon nearest to (x, y): itself where it is inside."""
    best = corners[0]
    least = math.inf
    inside = True
    apart = False  # a polygon that is a mere line has no inside
    for (px, py), (qx, qy) in zip(corners, corners[1:] + corners[:1], strict=True):
        ex = qx - px
        ey = qy - py
        left = ex * (y - py) - ey * (x - px)
        inside = inside and left >= 0.0
        apart = apart or left > 0.0
        length = ex * ex + ey * ey
        w = min(1.0, max(0.0, ((x - px) * ex + (y - py) * ey) / length)) if length > 0.0 else 0.0
        nx = px + w * ex
        ny = py + w * ey
        away = (nx - x) * (nx - x) + (ny - y) * (ny - y)
        if away < least:
            best, least = (nx, ny), away
    return (x, y) if inside and apart else best
