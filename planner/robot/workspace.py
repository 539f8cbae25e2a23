"""Where a leg can put its foot: reach worked out from its chain of joints (H §11 (5), reach of
indeterminate form).

A *region* is one horizontal slice of that reach, a polygon in body axes seen from above. On it the
questions of every planner have exact answers, on lines and on arcs, as they have on a rectangle
(``geometry.paths``): how far may the body go before a standing foot leaves (H §5.2 (4)-(9)), and
over which s does a foothold serve (K's existence segment).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from ..geometry.paths import EDGE, FOREVER, ArcPath, Box
from ..geometry.polygons import clipped
from ..geometry.transforms import XY, Point, direction
from .chains import JointSpan, LegChain
from .kinematics import forward, inverse

NOWHERE: tuple[float, float] = (FOREVER, -FOREVER)
EVERYWHERE: tuple[float, float] = (-FOREVER, FOREVER)

RAYS = 72  # of a slice; fewer, see its round side cut by more than (1 - cos π/RAYS) of its radius
MARCH = 64  # places looked at along a ray before its first edge is bisected
SHARP = 1e-9  # m, how exactly the edge along a ray is found
PARALLEL = 1e-12
GRID = 5  # places along each side of a control box that must be in reach
GROWTH = 0.005  # m, by which a fitted box grows
GROWN_MAX = 4000  # growths of a side before it is taken as it is


# -- regions


@dataclass(frozen=True)
class ReachRegion:
    """A simple polygon, counter-clockwise, at least three corners, m in body axes.

    Convex ones answer fastest; star-shaped and other simple ones are answered as exactly.
    """

    corners: tuple[XY, ...]

    def __post_init__(self) -> None:
        if len(self.corners) < 3:
            raise ValueError(f"a region needs at least 3 corners, got {len(self.corners)}")
        if signed_area(self.corners) <= 0.0:
            raise ValueError("a region's corners must run counter-clockwise around some area")

    @classmethod
    def of_box(cls, box: Box) -> ReachRegion:
        """A rectangle x_min, x_max, y_min, y_max as a region."""
        x0, x1, y0, y1 = box
        return cls(((x0, y0), (x1, y0), (x1, y1), (x0, y1)))

    @cached_property
    def edges(self) -> tuple[tuple[XY, XY], ...]:
        """From corner to corner, in order."""
        return tuple(zip(self.corners, (*self.corners[1:], self.corners[0]), strict=True))

    @cached_property
    def convex(self) -> bool:
        """True when no corner turns inwards."""
        ring = (*self.corners, *self.corners[:2])
        return all(
            _left_of(a, b, c) >= 0.0 for a, b, c in zip(ring, ring[1:], ring[2:], strict=False)
        )

    @cached_property
    def box(self) -> Box:
        """The rectangle around it: x_min, x_max, y_min, y_max."""
        xs = [x for x, _ in self.corners]
        ys = [y for _, y in self.corners]
        return min(xs), max(xs), min(ys), max(ys)

    @cached_property
    def _half_planes(self) -> tuple[tuple[float, float, float], ...]:
        """Inside where n·p >= offset, n of unit length; of a convex region."""
        planes = []
        for (ax, ay), (bx, by) in self.edges:
            length = math.hypot(bx - ax, by - ay)
            nx = (ay - by) / length
            ny = (bx - ax) / length
            planes.append((nx, ny, nx * ax + ny * ay))
        return tuple(planes)

    def contains(self, x: float, y: float, slack: float = EDGE) -> bool:
        """True when (x, y) is inside, or outside by at most ``slack`` m."""
        if self.convex:
            return all(nx * x + ny * y >= offset - slack for nx, ny, offset in self._half_planes)
        return self._winds(x, y) or self.distance(x, y) <= slack

    def distance(self, x: float, y: float) -> float:
        """From (x, y) to the nearest point of the outline, m."""
        return min(_to_segment(x, y, a, b) for a, b in self.edges)

    def _winds(self, x: float, y: float) -> bool:
        """True when a ray from (x, y) along +x crosses the outline an odd number of times."""
        inside = False
        for (ax, ay), (bx, by) in self.edges:
            if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
                inside = not inside
        return inside

    def exit(self, x: float, y: float, path: ArcPath) -> float:
        """How far the body may go, m, before the foot now at (x, y) leaves; ``inf``: never.

        On a line over a convex region it is where the foot passes the far side, negative when that
        lies behind it (H §5.2 (4)-(9)); otherwise the end of the existence segment.
        """
        if path.turn != 0.0 or not self.convex:
            return self.segment(x, y, path)[1]
        least = FOREVER
        for nx, ny, offset in self._half_planes:
            rate = nx * path.ux + ny * path.uy
            if rate > PARALLEL:
                least = min(least, (nx * x + ny * y - offset) / rate)
        return least

    def segment(self, x: float, y: float, path: ArcPath) -> tuple[float, float]:
        """K's existence segment [s1, s2] of a foothold at (x, y): the first connected one with
        s2 >= 0; (inf, −inf) when there is none.
        """
        if path.turn == 0.0:
            if self.convex:
                return self._convex_segment(x, y, path)
            crossings = sorted(self._line_crossings(x, y, path))
            crossings = [-FOREVER, *crossings, FOREVER]
        else:
            crossings = sorted(self._arc_crossings(x, y, path))
        if not crossings:
            return EVERYWHERE if self.contains(x, y) else NOWHERE
        return self._first_inside(x, y, path, crossings)

    def _convex_segment(self, x: float, y: float, path: ArcPath) -> tuple[float, float]:
        """In body axes a foot moves against the body: p − s u, through the half planes."""
        s1, s2 = EVERYWHERE
        for nx, ny, offset in self._half_planes:
            depth = nx * x + ny * y - offset
            rate = nx * path.ux + ny * path.uy
            if rate > PARALLEL:
                s2 = min(s2, depth / rate)
            elif rate < -PARALLEL:
                s1 = max(s1, depth / rate)
            elif depth < -EDGE:
                return NOWHERE
        return (s1, s2) if s1 <= s2 + EDGE and s2 >= -EDGE else NOWHERE

    def _line_crossings(self, x: float, y: float, path: ArcPath) -> Iterator[float]:
        for (ax, ay), (bx, by) in self.edges:
            across = (bx - ax) * path.uy - (by - ay) * path.ux
            if abs(across) < PARALLEL:
                continue
            along = ((x - ax) * path.uy - (y - ay) * path.ux) / across
            if -EDGE <= along <= 1.0 + EDGE:
                yield ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / across

    def _arc_crossings(self, x: float, y: float, path: ArcPath) -> Iterator[float]:
        """In body axes the foot circles the turning centre: where that circle meets the outline,
        over two turns either way.
        """
        cx = -path.uy / path.turn
        cy = path.ux / path.turn
        radius = math.hypot(x - cx, y - cy)
        start = math.atan2(y - cy, x - cx)
        round_trip = 2.0 * math.pi / abs(path.turn)
        for a, b in self.edges:
            for angle in _circle_meets(cx, cy, radius, a, b):
                s = (start - angle) / path.turn
                for turn in (-2, -1, 0, 1, 2):
                    yield s + turn * round_trip

    def _first_inside(
        self, x: float, y: float, path: ArcPath, crossings: Sequence[float]
    ) -> tuple[float, float]:
        """The first stretch between crossings that is inside and not over yet; stretches that
        touch are one.
        """
        begun: float | None = None
        last = -FOREVER
        for s1, s2 in zip(crossings, crossings[1:], strict=False):
            if s2 - s1 < EDGE:
                continue
            if self.contains(*path.seen(x, y, _between(s1, s2)), slack=0.0):
                begun = s1 if begun is None else begun
                last = s2
            elif begun is not None and last >= -EDGE:
                break
            else:
                begun = None
        return NOWHERE if begun is None or last < -EDGE else (begun, last)


def signed_area(corners: Sequence[XY]) -> float:
    """Twice the area of a polygon, m²; positive counter-clockwise."""
    total = 0.0
    for (ax, ay), (bx, by) in zip(corners, (*corners[1:], corners[0]), strict=True):
        total += ax * by - bx * ay
    return total


def convex_inside(region: ReachRegion, centre: XY) -> ReachRegion:
    """A convex part of a star-shaped region around ``centre``.

    Every corner that turns inwards cuts the rest off by the line through it square to the way from
    the centre: not the largest such part, but one that is there for every star.
    """
    corners = region.corners
    for _ in range(len(region.corners)):
        dent = _first_dent(corners, centre)
        if dent is None:
            return ReachRegion(corners)
        nx = centre[0] - dent[0]
        ny = centre[1] - dent[1]
        corners = tuple(clipped(corners, nx, ny, -(nx * dent[0] + ny * dent[1])))
    return ReachRegion(corners)


def _first_dent(corners: Sequence[XY], centre: XY) -> XY | None:
    """The corner that turns inwards and is nearest to the centre."""
    ring = (corners[-1], *corners, corners[0])
    dents = [
        b
        for a, b, c in zip(ring, ring[1:], ring[2:], strict=False)
        if _left_of(a, b, c) < -PARALLEL
    ]
    return min(dents, key=lambda p: math.dist(p, centre), default=None)


def _left_of(a: XY, b: XY, c: XY) -> float:
    return (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])


def _to_segment(x: float, y: float, a: XY, b: XY) -> float:
    ex = b[0] - a[0]
    ey = b[1] - a[1]
    share = ((x - a[0]) * ex + (y - a[1]) * ey) / (ex * ex + ey * ey)
    share = min(1.0, max(0.0, share))
    return math.hypot(x - a[0] - share * ex, y - a[1] - share * ey)


def _circle_meets(cx: float, cy: float, radius: float, a: XY, b: XY) -> Iterator[float]:
    """Angles about the centre at which a circle crosses the stretch from a to b."""
    ex = b[0] - a[0]
    ey = b[1] - a[1]
    length = math.hypot(ex, ey)
    ex /= length
    ey /= length
    foot = (cx - a[0]) * ex + (cy - a[1]) * ey  # along the edge, nearest to the centre
    away = (cx - a[0]) * ey - (cy - a[1]) * ex
    squared = radius * radius - away * away
    if squared < 0.0:
        return
    for along in (foot - math.sqrt(squared), foot + math.sqrt(squared)):
        if -EDGE <= along <= length + EDGE:
            yield math.atan2(a[1] + along * ey - cy, a[0] + along * ex - cx)


def _between(s1: float, s2: float) -> float:
    """A place inside a stretch that may be endless on either side."""
    if s1 == -FOREVER:
        return 0.0 if s2 == FOREVER else s2 - 1.0
    return s1 + 1.0 if s2 == FOREVER else (s1 + s2) / 2.0


# -- reach of a leg


def reaches(chain: LegChain, foot: Point) -> bool:
    """True when some joints within their limits put the foot there (body axes, m)."""
    return inverse(chain, foot) is not None


def reach_at(chain: LegChain, z: float, centre: XY, rays: int = RAYS) -> ReachRegion | None:
    """The slice of a leg's reach at height z, star-shaped about ``centre``; None when the leg does
    not reach the centre.

    Each corner is the first edge of the reach along a ray from the centre, to 1e-9 m; between
    corners the outline is straight, so that a round reach is cut by less than 0.1 % of its radius.
    """
    if not reaches(chain, (*centre, z)):
        return None
    corners = []
    for k in range(rays):
        ux, uy = direction(2.0 * math.pi * k / rays)
        far = _first_edge(chain, (*centre, z), (ux, uy, 0.0), 2.0 * chain.reach)
        corners.append((centre[0] + far * ux, centre[1] + far * uy))
    return ReachRegion(tuple(corners))


def _first_edge(chain: LegChain, start: Point, way: Point, far: float) -> float:
    """How far along a ray the leg reaches without a gap, m."""

    def held(s: float) -> bool:
        x, y, z = start
        return reaches(chain, (x + s * way[0], y + s * way[1], z + s * way[2]))

    low = 0.0
    for step in range(1, MARCH + 1):
        high = far * step / MARCH
        if not held(high):
            break
        low = high
    else:
        return far
    while high - low > SHARP:
        middle = (low + high) / 2.0
        if held(middle):
            low = middle
        else:
            high = middle
    return low


Spans = tuple[JointSpan, JointSpan, JointSpan]


def out_of_reach(chain: LegChain, spans: Spans) -> Point | None:
    """A place in a control box x, y, z (body axes, m) that the leg does not reach, looked for on a
    grid of it; None when all are reached.
    """
    sides = [[low + (high - low) * k / (GRID - 1) for k in range(GRID)] for low, high in spans]
    for x in sides[0]:
        for y in sides[1]:
            for z in sides[2]:
                if not reaches(chain, (x, y, z)):
                    return x, y, z
    return None


def fitted_box(chain: LegChain, middle: Point | None = None) -> Spans:
    """A control box inside the reach: what a card without one gets.

    It grows from ``middle`` (the foot with all joints in the middle of their ranges when None), one
    side after the other by 5 mm, for as long as all of it is reached.
    """
    x, y, z = forward(chain, _middle(chain)) if middle is None else middle
    sides = [[x, x], [y, y], [z, z]]
    open_sides = [(axis, end) for axis in range(3) for end in (0, 1)]
    for _ in range(GROWN_MAX):
        open_sides = [side for side in open_sides if _grow(chain, sides, *side)]
        if not open_sides:
            break
    a, b, c = ((round(low, 9), round(high, 9)) for low, high in sides)
    return a, b, c


def _grow(chain: LegChain, sides: list[list[float]], axis: int, end: int) -> bool:
    """Push one side of a box out by a step; False, and nothing done, where the reach ends."""
    sides[axis][end] += GROWTH if end else -GROWTH
    spans = [(low, high) for low, high in sides]
    face = spans[:axis] + [(sides[axis][end], sides[axis][end])] + spans[axis + 1 :]
    if out_of_reach(chain, (face[0], face[1], face[2])) is None:
        return True
    sides[axis][end] -= GROWTH if end else -GROWTH
    return False


def _middle(chain: LegChain) -> Point:
    a, b, c = ((low + high) / 2.0 for low, high in chain.limits)
    return a, b, c
