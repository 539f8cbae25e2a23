"""Convex polygons as corners, counter-clockwise: hulls, cuts, and nearest points.

Plain floats throughout: planning loops cut polygons of four corners by the thousand.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from .transforms import XY

Polygon = tuple[XY, ...]  # corners, counter-clockwise

CLEARLY = 1e-9  # m²; a corner with less area to its left may be none for rounding
ROUNDING = 1e-9 / 4  # a corner this far outside a cut is on it: a polygon may be a mere line


def triangle(a: XY, b: XY, c: XY) -> Polygon:
    """The triangle of three points, counter-clockwise; two corners if they are on one line."""
    twice_area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    if twice_area > 0.0:
        return a, b, c
    if twice_area < 0.0:
        return a, c, b
    return _hull([a, b, c])


def convex_hull(points: Iterable[Sequence[float]]) -> Polygon:
    """The convex hull of points seen from above, counter-clockwise; fewer than three corners if
    degenerate.
    """
    flat = [(p[0], p[1]) for p in points]
    count = len(flat)
    if count == 3:
        return triangle(*flat)
    if count == 4 and _goes_round(*flat):
        first = flat.index(min(flat))
        return (*flat[first:], *flat[:first])
    return _hull(flat)


def _goes_round(a: XY, b: XY, c: XY, d: XY) -> bool:
    """True when four points are the corners of their hull already, in its order, and clearly so."""
    ax, ay = a
    bx, by = b
    cx, cy = c
    dx, dy = d
    return (
        (bx - ax) * (cy - by) - (by - ay) * (cx - bx) > CLEARLY
        and (cx - bx) * (dy - cy) - (cy - by) * (dx - cx) > CLEARLY
        and (dx - cx) * (ay - dy) - (dy - cy) * (ax - dx) > CLEARLY
        and (ax - dx) * (by - ay) - (ay - dy) * (bx - ax) > CLEARLY
    )


def _hull(flat: list[XY]) -> Polygon:
    """As ``convex_hull``, corners from the least x on; sorts what it is given."""
    flat.sort()
    if len(flat) < 3:
        return tuple(flat)
    lower = _chain(flat)
    upper = _chain(flat[::-1])
    return (*lower[:-1], *upper[:-1])


def _chain(points: list[XY]) -> list[XY]:
    """The corners of one side of a hull, of sorted points."""
    chain: list[XY] = []
    for x, y in points:
        while len(chain) > 1:
            ax, ay = chain[-2]
            bx, by = chain[-1]
            if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
                break
            chain.pop()
        chain.append((x, y))
    return chain


def clipped(corners: Sequence[XY], a: float, b: float, c: float) -> list[XY]:
    """The part of a polygon where a·x + b·y + c >= 0, but for rounding: a polygon that is a mere
    line is not lost.
    """
    return _cut(corners, [a * x + b * y + c for x, y in corners], ROUNDING)


def beside(corners: Sequence[XY], a: XY, b: XY, inset: float) -> list[XY]:
    """The part of a polygon at least ``inset`` to the left of the line from a to b."""
    ex = b[0] - a[0]
    ey = b[1] - a[1]
    length = math.hypot(ex, ey)
    depths = [(ex * (y - a[1]) - ey * (x - a[0])) / length - inset for x, y in corners]
    return _cut(corners, depths, 0.0)


def _cut(corners: Sequence[XY], depths: Sequence[float], slack: float) -> list[XY]:
    """The part of a polygon on one side of a line, by how deep on that side each corner is; within
    ``slack`` it is on the line.
    """
    kept: list[XY] = []
    for k, (x, y) in enumerate(corners):
        after = k + 1 if k + 1 < len(corners) else 0
        p = depths[k]
        q = depths[after]
        if p >= -slack:
            kept.append((x, y))
        if (p > slack and q < -slack) or (p < -slack and q > slack):
            w = p / (p - q)
            nx, ny = corners[after]
            kept.append((x + w * (nx - x), y + w * (ny - y)))
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


def nearest_of(corners: Sequence[XY], x: float, y: float) -> XY:
    """The point of a polygon, counter-clockwise, nearest to (x, y): itself where it is inside."""
    best = corners[0]
    least = math.inf
    inside = True
    apart = False  # a polygon that is a mere line has no inside
    for (px, py), (qx, qy) in zip(corners, (*corners[1:], corners[0]), strict=True):
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
            best = (nx, ny)
            least = away
    return (x, y) if inside and apart else best
