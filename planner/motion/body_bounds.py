"""What a body may do on its way: the margin it keeps, and how fast it may speed up or slow down.

A centre of gravity at a height h that speeds up by a has its zero-moment point a·h/g behind it, and
one that slows down as far ahead of it. It is safe while that point stays in the polygon of the feet
that carry: on a margin m by g·m/h and no faster. Metres, seconds, absolute frame.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..geometry.polygons import Polygon
from ..geometry.transforms import XY
from ..stability import GRAVITY, polygon_margin
from ..types import Gait, Stance
from .body_path import OFFSET_MAX, edges_across

RESERVE = 0.005  # m of margin that slowing down leaves; less: see the machine rock as it stops
BRISK = 0.5  # m/s², most of a body that walks; more: see it rock on legs that give
STEEPEST = 1.0  # m/s², most to slow down by; more: see a body jerk that is nowhere near an edge
SHRINKS = 0.95  # of a margin that a body still has at the end of a tick in which it slows down
PARALLEL = 1e-6  # an edge that a way nears by less of its length lies along it
LOWEST = 0.05  # m; a body nearer to the ground counts as so high
FARTHEST = 10.0  # m; room without an edge ahead


class Bounds(NamedTuple):
    """What a body may do on its way."""

    margin: float  # m, of the polygon
    acceleration: float  # m/s², at which the margin is just kept
    height: float = 0.0  # of the body above its feet, m; 0 where the acceleration is given
    aside: float = OFFSET_MAX  # m aside of the reference, that a way goes which could go nearer

    def brisk(self, margin: float) -> float:
        """The most a body with a margin, m, may speed up, slow down or swing aside as it walks,
        m/s²: g·margin/h, as where the wanted margin is just kept at least.
        """
        return self._within(margin, BRISK)

    def steepest(self, room: float) -> float:
        """The most a body with so much room ahead, m, may slow down, m/s²."""
        return self._within(room, STEEPEST)

    def _within(self, room: float, most: float) -> float:
        if self.height <= 0.0:
            return self.acceleration
        return max(self.acceleration, min(GRAVITY * room / self.height, most))


def bounds_of(stance: Stance, gait: Gait) -> Bounds:
    """The wanted margin, and the acceleration at which it is just kept: g·m/h."""
    if gait.acceleration > 0.0:
        return Bounds(gait.margin, gait.acceleration)
    ground = min(foot[2] for foot in stance.feet)
    height = max(stance.body[2] - ground, LOWEST)
    return Bounds(gait.margin, GRAVITY * max(gait.margin, RESERVE) / height, height)


class CarryingFeet(NamedTuple):
    """What carries a body that slows down."""

    polygon: Polygon  # of the feet that carry meanwhile
    centre: XY  # of gravity from the body, m
    bounds: Bounds
    nearest: bool = False  # g·margin/height of the nearest edge is not to be exceeded

    def margin(self, place: XY) -> float:
        """How far inside of them the centre of gravity and the body's origin, which planners go by,
        both are with the body there, m.
        """
        x, y = place
        dx, dy = self.centre
        origin = polygon_margin(self.polygon, x, y)
        return min(origin, polygon_margin(self.polygon, x + dx, y + dy))

    def slowing(self, place: XY, ahead: XY, bends: XY = (0.0, 0.0)) -> float:
        """The most the body may slow down there, m/s², while its way bends by ``bends``, m/s²; the
        zero-moment point stays ``RESERVE`` inside, and where ``nearest`` is asked for no farther
        from the centre of gravity than the nearest edge. Not positive where it cannot.

        ``ahead`` is the body's velocity over its speed, in which its turning counts too.
        """
        bounds = self.bounds
        if bounds.height <= 0.0:
            return bounds.acceleration
        if len(self.polygon) < 3:
            return 0.0
        lever = bounds.height / GRAVITY
        x = place[0] + self.centre[0]
        y = place[1] + self.centre[1]
        most = STEEPEST
        if self.nearest:
            margin = polygon_margin(self.polygon, x, y)
            most = min(most, SHRINKS * margin / lever - math.hypot(*bends))
        x -= lever * bends[0]
        y -= lever * bends[1]
        for depth, rate in edges_across(self.polygon, x, y, ahead):
            if rate < -PARALLEL:
                most = min(most, (RESERVE - depth) / (lever * rate))
        return most


def room_ahead(polygon: Polygon, place: XY, ahead: XY) -> float:
    """How far a point may go along the unit vector ``ahead`` and keep ``RESERVE`` inside the
    polygon, m; 0 where it does not keep it now.
    """
    if len(polygon) < 3:
        return 0.0
    room = FARTHEST
    for depth, rate in edges_across(polygon, *place, ahead):
        if depth < RESERVE:
            return 0.0
        if rate < 0.0:
            room = min(room, (RESERVE - depth) / rate)
    return room
