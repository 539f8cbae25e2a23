"""The support polygon, how long the centre of gravity stays in it along a course, and every
stability margin.

Points are foot tips; polygons are convex hulls, counter-clockwise, as tuples of (x, y). Plain
floats throughout: this runs every tick and inside every planning loop, where numpy on three points
costs seven times as much.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from .geometry.paths import ArcPath
from .geometry.polygons import Polygon, convex_hull
from .geometry.transforms import XY

MARGIN_SLACK = 0.001  # m; a margin counts as non-negative when it is >= -1 mm
# m; the simulated machine starts to tip when its centre of gravity is this far outside
TIP_SLACK = 0.005
GRAVITY = 9.81  # m/s²
LOOKS = 3  # places within a stretch of a path at which the least margin is looked for
OVER = 1e-6  # rad; a window of angles that ended this little ago still counts: rounding


def support_polygon(points: Iterable[Sequence[float]]) -> Polygon:
    """Convex hull of the supporting foot tips seen from above, counter-clockwise; fewer than three
    corners if degenerate.
    """
    return convex_hull(points)


def stable_interval(
    polygon: Polygon, x: float, y: float, ux: float, uy: float
) -> tuple[float, float]:
    """The s over which (x, y) + s·(ux, uy) is inside the polygon: (s_low, s_high); (inf, -inf) when
    the line misses it.

    On a straight course this is K's existence segment of a state, and s_low is H's D(X) for a
    triangle not yet entered.
    """
    low = -math.inf
    high = math.inf
    if len(polygon) < 3:
        return math.inf, -math.inf
    ax, ay = polygon[-1]
    for bx, by in polygon:
        ex = bx - ax
        ey = by - ay
        distance = ex * (y - ay) - ey * (x - ax)  # > 0 inside this edge
        rate = ex * uy - ey * ux
        if rate > 1e-12:
            s = -distance / rate
            if s > low:
                low = s
        elif rate < -1e-12:
            s = -distance / rate
            if s < high:
                high = s
        elif distance < 0.0:
            return math.inf, -math.inf
        ax = bx
        ay = by
    return (low, high) if low <= high else (math.inf, -math.inf)


def stable_on(path: ArcPath, polygon: Polygon, inset: float = 0.0) -> tuple[float, float]:
    """The s over which the CoG is inside a polygon along a path, by ``inset`` from every edge."""
    ux, uy, turn = path
    if turn == 0.0 and inset == 0.0:
        return stable_interval(polygon, 0.0, 0.0, ux, uy)
    return stable_on_arc(polygon, ux, uy, turn, inset)


def stable_on_arc(
    polygon: Polygon, ux: float, uy: float, turn: float, inset: float = 0.0
) -> tuple[float, float]:
    """The s over which a course of constant curvature from the origin (``ArcPath``) is inside,
    keeping ``inset`` from every edge.

    Closed form: the way runs on a circle about the turning centre, an edge cuts one window of
    angles out of it. Of the windows that come round again after each full turn the first that is
    not over yet is meant (of every edge: a stretch in which the second window of one meets the
    first of another is not found); on the spot it is all or nothing.
    """
    if len(polygon) < 3:
        return math.inf, -math.inf
    if turn == 0.0:
        return _stable_on_line(polygon, ux, uy, inset)
    cx = -uy / turn
    cy = ux / turn
    radius = math.hypot(cx, cy)
    start = math.atan2(-cy, -cx)
    side = 1.0 if turn > 0.0 else -1.0
    low = -math.inf
    high = math.inf
    for nx, ny, depth in _depths(polygon, cx, cy, inset):
        if depth >= radius:
            continue
        if depth < -radius:
            return math.inf, -math.inf
        half = math.acos(-depth / radius)
        middle = side * (math.atan2(ny, nx) - start)
        end = (middle + half + OVER) % (2 * math.pi) - OVER
        low = max(low, end - 2 * half)
        high = min(high, end)
    low = low / abs(turn)
    high = high / abs(turn)
    return (low, high) if low <= high else (math.inf, -math.inf)


def _stable_on_line(polygon: Polygon, ux: float, uy: float, inset: float) -> tuple[float, float]:
    """``stable_on_arc`` of an arc of turn 0."""
    low = -math.inf
    high = math.inf
    for nx, ny, depth in _depths(polygon, 0.0, 0.0, inset):
        rate = nx * ux + ny * uy
        if rate > 1e-12:
            low = max(low, -depth / rate)
        elif rate < -1e-12:
            high = min(high, -depth / rate)
        elif depth < 0.0:
            return math.inf, -math.inf
    return (low, high) if low <= high else (math.inf, -math.inf)


def _depths(
    polygon: Polygon, x: float, y: float, inset: float
) -> Iterator[tuple[float, float, float]]:
    """The unit vector into the polygon and how deep inside a point is by more than ``inset``, for
    every edge.
    """
    ax, ay = polygon[-1]
    for bx, by in polygon:
        ex = bx - ax
        ey = by - ay
        length = math.sqrt(ex * ex + ey * ey)
        nx = -ey / length
        ny = ex / length
        yield nx, ny, nx * (x - ax) + ny * (y - ay) - inset
        ax = bx
        ay = by


def polygon_margin(polygon: Polygon, x: float, y: float) -> float:
    """Shortest distance from (x, y) to the polygon's edge, m; negative outside, −inf with no
    polygon.
    """
    if len(polygon) < 3:
        return -math.inf
    least = math.inf
    ax, ay = polygon[-1]
    for bx, by in polygon:
        ex = bx - ax
        ey = by - ay
        distance = (ex * (y - ay) - ey * (x - ax)) / math.sqrt(ex * ex + ey * ey)
        if distance < least:
            least = distance
        ax = bx
        ay = by
    return least


def least_polygon_margin(polygon: Polygon, places: Sequence[XY]) -> float:
    """The least ``polygon_margin`` of some places, m; infinite of none."""
    if len(polygon) < 3:
        return -math.inf if places else math.inf
    least = math.inf
    ax, ay = polygon[-1]
    for bx, by in polygon:
        ex = bx - ax
        ey = by - ay
        deep = min([ex * (y - ay) - ey * (x - ax) for x, y in places], default=math.inf)
        least = min(least, deep / math.sqrt(ex * ex + ey * ey))
        ax = bx
        ay = by
    return least


def polygon_margin_on(path: ArcPath, polygon: Polygon, begin: float, end: float) -> float:
    """Least polygon margin of the CoG between two s of a path, m, looked at both and ``LOOKS``
    times in between.
    """
    poses = [path.pose(begin + k / (LOOKS + 1) * (end - begin)) for k in range(LOOKS + 2)]
    return least_polygon_margin(polygon, [(x, y) for x, y, _ in poses])


def capture_margin(
    polygon: Polygon, x: float, y: float, velocity: XY, height: float, gravity: float = GRAVITY
) -> float:
    """The polygon margin less what a dead stop needs, m: negative where it would tip.

    A body at ``height`` m over its feet that moves at ``velocity``, m/s, comes to rest over a point
    v·√(h/g) ahead (the capture point, Pratt et al. 2006); towards each edge that much is taken off.
    Moving away from an edge adds nothing.
    """
    if len(polygon) < 3:
        return -math.inf
    time = math.sqrt(max(height, 0.0) / gravity)
    least = math.inf
    ax, ay = polygon[-1]
    for bx, by in polygon:
        ex = bx - ax
        ey = by - ay
        length = math.sqrt(ex * ex + ey * ey)
        distance = (ex * (y - ay) - ey * (x - ax)) / length
        outward = (ey * velocity[0] - ex * velocity[1]) / length
        least = min(least, distance - max(outward, 0.0) * time)
        ax = bx
        ay = by
    return least


def longitudinal_margin(polygon: Polygon, x: float, y: float, ux: float, uy: float) -> float:
    """The longitudinal stability margin s, m (H §2.4): least distance to the polygon's edge along
    ±(ux, uy).

    Outside the polygon it is negative: the way still to go along the course, or the polygon margin
    when the course line misses the polygon altogether.
    """
    low, high = stable_interval(polygon, x, y, ux, uy)
    if low > high:
        return min(polygon_margin(polygon, x, y), 0.0)
    return min(-low, high)


def energy_margin(points: Sequence[Sequence[float]], centre: Sequence[float]) -> float:
    """Normalised energy stability margin, m: how far the centre of gravity must rise to tip over
    the weakest edge.

    Messuri & Klein 1985, divided by the weight (Hirose et al. 2001). ``points`` are supporting foot
    tips (x, y, z), ``centre`` is the centre of gravity. Negative once the centre of gravity is
    outside an edge.
    """
    corner = {(p[0], p[1]): p for p in points}
    polygon = support_polygon(points)
    if len(polygon) < 3:
        return -math.inf
    least = math.inf
    for a_xy, b_xy in zip(polygon, (*polygon[1:], polygon[0]), strict=True):
        a = corner[a_xy]
        b = corner[b_xy]
        least = min(least, _rise_over(a, b, centre))
    return least


def _rise_over(a: Sequence[float], b: Sequence[float], centre: Sequence[float]) -> float:
    """Rise of ``centre`` when it swings about the line a-b up to the vertical plane through it."""
    ex = b[0] - a[0]
    ey = b[1] - a[1]
    ez = b[2] - a[2]
    length = math.sqrt(ex * ex + ey * ey + ez * ez)
    ex = ex / length
    ey = ey / length
    ez = ez / length
    rx = centre[0] - a[0]
    ry = centre[1] - a[1]
    rz = centre[2] - a[2]
    along = rx * ex + ry * ey + rz * ez
    # from the axis to the centre, square to it
    rx = rx - along * ex
    ry = ry - along * ey
    rz = rz - along * ez
    radius = math.sqrt(rx * rx + ry * ry + rz * rz)
    rise = radius * math.sqrt(max(0.0, 1.0 - ez * ez)) - rz
    inside = (b[0] - a[0]) * (centre[1] - a[1]) - (b[1] - a[1]) * (centre[0] - a[0]) >= 0.0
    return rise if inside else -rise
