"""Which obstacles are near a place: what need not be asked about in any other way.

The ground plane is cut into squares, and each knows the bounds of what is within a margin of it.
What is not in the bounds of anything tall enough meets nothing; what is may still miss it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from ..terrain.generators import Obstacle

PATCH = 0.25  # m, side of the squares that know whether an obstacle is near
ASK = 1e-6  # m; bounds this near each other may meet


class Enclosure(NamedTuple):
    """The rectangle an obstacle is in, seen from above, and its top, m."""

    x_min: float
    x_max: float
    y_min: float
    y_max: float
    top: float

    @classmethod
    def of(cls, obstacle: Obstacle) -> Enclosure:
        """Those of an obstacle."""
        r = obstacle.radius
        xs = [x for x, _ in obstacle.corners] or [obstacle.x - r, obstacle.x + r]
        ys = [y for _, y in obstacle.corners] or [obstacle.y - r, obstacle.y + r]
        return cls(min(xs), max(xs), min(ys), max(ys), obstacle.top)


class Nearby:
    """The obstacles within ``margin`` (m) of a place, or a little farther from it."""

    def __init__(self, obstacles: Sequence[Obstacle], margin: float) -> None:
        self.margin = margin
        self._all = [Enclosure.of(obstacle) for obstacle in obstacles]
        self._patches: dict[tuple[int, int], list[Enclosure]] = {}
        for bounds in self._all:
            for i in _squares(bounds.x_min - margin, bounds.x_max + margin):
                for j in _squares(bounds.y_min - margin, bounds.y_max + margin):
                    self._patches.setdefault((i, j), []).append(bounds)

    def any(self, x: float, y: float) -> bool:
        """True when something may be within the margin of (x, y)."""
        patches = self._patches
        return bool(patches) and (math.floor(x / PATCH), math.floor(y / PATCH)) in patches

    def within(self, x: float, y: float, reach: float, low: float) -> bool:
        """True when something taller than ``low`` (m) may be within ``reach`` of (x, y), which is
        no more than the margin.
        """
        reach += ASK
        for bounds in self._patches.get((math.floor(x / PATCH), math.floor(y / PATCH)), ()):
            if (
                bounds.top > low
                and bounds.x_min - reach <= x <= bounds.x_max + reach
                and bounds.y_min - reach <= y <= bounds.y_max + reach
            ):
                return True
        return False

    def on_the_way(
        self, centre: Sequence[float], a: Sequence[float], b: Sequence[float], low: float
    ) -> bool:
        """True when something taller than ``low`` (m) may be on the straight way from a to b, which
        is about ``centre``.
        """
        ax, ay = a[0], a[1]
        bx, by = b[0], b[1]
        x, y = centre[0], centre[1]
        far = self.margin
        if ax > bx:
            ax, bx = bx, ax
        if ay > by:
            ay, by = by, ay
        near: Sequence[Enclosure]
        if x - ax > far or bx - x > far or y - ay > far or by - y > far:
            near = self._all
        else:
            near = self._patches.get((math.floor(x / PATCH), math.floor(y / PATCH)), ())
        for x_min, x_max, y_min, y_max, top in near:
            if (
                top > low
                and x_min - ASK <= bx
                and ax <= x_max + ASK
                and y_min - ASK <= by
                and ay <= y_max + ASK
            ):
                return True
        return False


def _squares(low: float, high: float) -> range:
    first = math.floor(low / PATCH)
    return range(first, math.floor(high / PATCH) + 1)
