"""Distance s along the body's course: the one idea under both papers.

H walks straight lines L_G at crab angle α, K any trace {ξ(s), η(s), β(s)}. What both ask of a
course is the same: where is the body after s, where is a standing foot then *in body axes*, and
over which s does that foot stay inside its leg's reach rectangle (K's existence segment; its right
end is H's g_i, §5.2 (4)-(9)).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Box = tuple[float, float, float, float]  # x_min, x_max, y_min, y_max in body axes
EDGE = 1e-9  # m; a foot this far outside its rectangle counts as on the edge: rounding, not a fault
FOREVER = math.inf
NOWHERE = FOREVER, -FOREVER  # an empty interval


def corners_of_box(box: Box) -> list[tuple[float, float]]:
    """The four corners of a rectangle, counter-clockwise from the least x and y."""
    x1, x2, y1, y2 = box
    return [(x1, y1), (x2, y1), (x2, y2), (x1, y2)]


def box_around(box: Box, x: float, y: float, c: float, s: float) -> Box:
    """The upright box around one that lies turned, its middle at (x, y): ``c`` and ``s`` are cosine
    and sine of its angle.
    """
    x1, x2, y1, y2 = box
    hx, hy = (x2 - x1) / 2, (y2 - y1) / 2
    c, s = abs(c), abs(s)
    half_x = c * hx + s * hy
    half_y = s * hx + c * hy
    return x - half_x, x + half_x, y - half_y, y + half_y


def room_within(points: Iterable[tuple[float, float]], boxes: Iterable[Box]) -> Box:
    """How far a frame may be shifted with none of the points in it farther outside of its box than
    it is: the shifts from least to largest x and y, 0 among them.
    """
    inside = list(zip(points, boxes, strict=True))
    x1 = min(max(x - box[1] for (x, _), box in inside), 0.0)
    x2 = max(min(x - box[0] for (x, _), box in inside), 0.0)
    y1 = min(max(y - box[3] for (_, y), box in inside), 0.0)
    y2 = max(min(y - box[2] for (_, y), box in inside), 0.0)
    return x1, x2, y1, y2


class ArcPath(NamedTuple):
    """A course of constant curvature from the present pose, in present body axes: a line when
    ``turn`` is 0, else an arc.

    Per metre of s the body moves (``ux``, ``uy``) and turns ``turn`` radians. With the yaw length
    scale ρ, ds² = dξ² + dη² + (ρ dβ)², so ux² + uy² + (ρ turn)² = 1 and a turn on the spot has a
    length too.
    """

    ux: float
    uy: float
    turn: float = 0.0

    def pose(self, s: float) -> tuple[float, float, float]:
        """The body after s: dx, dy in present body axes and the change of yaw."""
        if self.turn == 0.0:
            return self.ux * s, self.uy * s, 0.0
        angle = self.turn * s
        sine = math.sin(angle) / self.turn
        versine = (1.0 - math.cos(angle)) / self.turn
        return self.ux * sine - self.uy * versine, self.ux * versine + self.uy * sine, angle

    def seen(self, x: float, y: float, s: float) -> tuple[float, float]:
        """A standing foot, now at (x, y) in body axes, as the body sees it after s."""
        dx, dy, angle = self.pose(s)
        x = x - dx
        y = y - dy
        if angle == 0.0:
            return x, y
        c, d = math.cos(angle), math.sin(angle)
        return c * x + d * y, c * y - d * x

    def placed(self, x: float, y: float, s: float) -> tuple[float, float]:
        """A point fixed to the body at (x, y), where it is after s in present body axes."""
        dx, dy, angle = self.pose(s)
        c, d = math.cos(angle), math.sin(angle)
        return dx + c * x - d * y, dy + d * x + c * y

    def rate(self, x: float, y: float) -> tuple[float, float]:
        """How the body goes past a standing foot at (x, y), per metre of s."""
        return self.ux - self.turn * y, self.uy + self.turn * x

    def reversed(self) -> ArcPath:
        """The way back along the same line or arc."""
        return ArcPath(-self.ux, -self.uy, -self.turn)

    def exit(self, x: float, y: float, box: Box) -> float:
        """How far the body may go before the foot at (x, y) leaves ``box``: H §5.2 (4)-(9) on a
        line; negative behind it.
        """
        if self.turn != 0.0:
            return self.segment(x, y, box)[1]
        return line_exit(x, y, box, self.ux, self.uy)

    def segment(self, x: float, y: float, box: Box) -> tuple[float, float]:
        """K's existence segment [s1, s2] of a foothold at (x, y): the first connected one with s2
        >= 0.

        On an arc that never meets the box it is empty: (inf, -inf). On an arc that never leaves it,
        (-inf, inf).
        """
        if self.turn == 0.0:
            return line_segment(x, y, box, self.ux, self.uy)
        return _arc_segment(x, y, box, self)


def arc_of_command(
    crab_angle: float, speed: float, turn_rate: float, yaw_length: float
) -> tuple[ArcPath, float]:
    """The course of a joystick command and its pace ds/dt in m/s (0 when nothing is commanded)."""
    pace = math.hypot(speed, yaw_length * turn_rate)
    if pace == 0.0:
        return ArcPath(math.cos(crab_angle), math.sin(crab_angle)), 0.0
    return ArcPath(
        speed * math.cos(crab_angle) / pace, speed * math.sin(crab_angle) / pace, turn_rate / pace
    ), pace


def bounded_by(
    bounds: Iterable[tuple[float, float]], low: float, high: float, slack: float
) -> tuple[float, float]:
    """The part of the interval [low, high] of t in which a·t <= b for all (a, b); (inf, -inf) when
    there is none, but for ``slack``.
    """
    for a, b in bounds:
        if a > 1e-12:
            high = min(high, b / a)
        elif a < -1e-12:
            low = max(low, b / a)
        elif b < -slack:
            return NOWHERE
    return (low, high) if low <= high + slack else NOWHERE


def line_exit(x: float, y: float, box: Box, ux: float, uy: float) -> float:
    """Distance along (ux, uy) after which a standing foot leaves the rectangle's far side: g_i of H
    §5.2 (4)-(9).
    """
    g = FOREVER
    if ux > 1e-12:
        g = (x - box[0]) / ux
    elif ux < -1e-12:
        g = (x - box[1]) / ux
    if uy > 1e-12:
        g_y = (y - box[2]) / uy
    elif uy < -1e-12:
        g_y = (y - box[3]) / uy
    else:
        return g
    return g if g < g_y else g_y


def line_segment(x: float, y: float, box: Box, ux: float, uy: float) -> tuple[float, float]:
    """The interval of s over which a standing foot is inside the rectangle on a straight course;
    (inf, -inf) if never.
    """
    s1 = -FOREVER
    s2 = FOREVER
    for position, direction, low, high in ((x, ux, box[0], box[1]), (y, uy, box[2], box[3])):
        if abs(direction) < 1e-12:
            if not low - EDGE <= position <= high + EDGE:
                return FOREVER, -FOREVER
            continue
        a = (position - high) / direction
        b = (position - low) / direction
        if a > b:
            a, b = b, a
        s1 = max(s1, a)
        s2 = min(s2, b)
    return (s1, s2) if s1 <= s2 + EDGE else (FOREVER, -FOREVER)


def arc_exit(x: float, y: float, box: Box, arc: ArcPath, outside: float = EDGE) -> float:
    """How far the body may go on an arc before a foot that is in the rectangle leaves it; 0 for one
    that is not.

    The g_i of H §5.2 on an arc. Quicker than the existence segment, which also knows footholds not
    yet in reach. A foot up to ``outside`` beyond an edge and coming in counts as in: it has touched
    early, or the body is not quite where it should be.
    """
    if arc.turn == 0.0:
        return max(0.0, line_exit(x, y, box, arc.ux, arc.uy))
    cx = -arc.uy / arc.turn
    cy = arc.ux / arc.turn
    rx = x - cx
    ry = y - cy
    radius = math.hypot(rx, ry)
    if radius < 1e-12:
        return FOREVER if _inside(x, y, box) else 0.0
    way = -1.0 if arc.turn > 0.0 else 1.0  # in body axes the foot goes the other way round
    place = math.atan2(ry, rx)
    least = FOREVER
    for out, beyond, edge in (
        (0.0, x - box[1], box[1] - cx),
        (math.pi, box[0] - x, cx - box[0]),
        (math.pi / 2, y - box[3], box[3] - cy),
        (-math.pi / 2, box[2] - y, cy - box[2]),
    ):
        if beyond > max(outside, EDGE):
            return 0.0
        if edge >= radius:
            continue
        angle = way * (place - out)
        if beyond > -EDGE and math.sin(angle) < 0.0:
            return 0.0
        least = min(least, (-math.acos(max(-1.0, edge / radius)) - angle) % (2 * math.pi))
    return least / abs(arc.turn)


def _arc_segment(x: float, y: float, box: Box, arc: ArcPath) -> tuple[float, float]:
    """Existence segment on an arc, closed form: in body axes the foot goes on a circle."""
    cx = -arc.uy / arc.turn
    cy = arc.ux / arc.turn
    radius = math.hypot(x - cx, y - cy)
    start = math.atan2(y - cy, x - cx)
    crossings = sorted(
        (start - angle) / arc.turn + turn * abs(2 * math.pi / arc.turn)
        for angle in _edge_angles(cx, cy, radius, box)
        for turn in (-2, -1, 0, 1, 2)
    )
    if not crossings:
        inside = _inside(x, y, box)
        return (-FOREVER, FOREVER) if inside else (FOREVER, -FOREVER)
    for s1, s2 in zip(crossings, crossings[1:], strict=False):
        if s2 < -EDGE or s2 - s1 < EDGE:
            continue
        if _inside(*arc.seen(x, y, (s1 + s2) / 2), box):
            return s1, s2
    return FOREVER, -FOREVER


def _edge_angles(cx: float, cy: float, radius: float, box: Box) -> list[float]:
    """Angles about the centre at which its circle meets the rectangle's four edge lines within the
    edges.
    """
    angles = []
    for edge, low, high, c_along, c_across, upright in (
        (box[0], box[2], box[3], cy, cx, True),
        (box[1], box[2], box[3], cy, cx, True),
        (box[2], box[0], box[1], cx, cy, False),
        (box[3], box[0], box[1], cx, cy, False),
    ):
        offset = edge - c_across
        half = radius * radius - offset * offset
        if half < 0.0:
            continue
        for along in (math.sqrt(half), -math.sqrt(half)):
            if low - EDGE <= c_along + along <= high + EDGE:
                angles.append(math.atan2(along, offset) if upright else math.atan2(offset, along))
    return angles


def _inside(x: float, y: float, box: Box) -> bool:
    return box[0] - EDGE <= x <= box[1] + EDGE and box[2] - EDGE <= y <= box[3] + EDGE


@dataclass(frozen=True, eq=False)
class SampledPath:
    """A course of any shape as poses at equal steps of s (K "motion trace"), straight between
    samples; absolute frame.

    Planning on it talks about sample numbers: between two samples a standing foot moves straight in
    body axes (with a fixed yaw; otherwise within 0.1 mm for a step of 0.01 m), so what holds at
    both samples holds between them: rectangles and support polygons are convex.
    """

    step: float  # m of s between samples
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    yaw: NDArray[np.float64]  # rad, not wrapped

    def __post_init__(self) -> None:
        if not len(self.x) == len(self.y) == len(self.yaw) >= 1:
            raise ValueError(
                "a course needs as many x, y and yaw, at least one: "
                f"got {len(self.x)}, {len(self.y)}, {len(self.yaw)}"
            )
        for array in (self.x, self.y, self.yaw):
            array.setflags(write=False)

    @property
    def last(self) -> int:
        """Number of the last sample."""
        return len(self.x) - 1

    @property
    def length(self) -> float:
        return self.last * self.step

    def nearest(self, s: float, x: float, y: float, within: float = 0.5) -> tuple[float, float]:
        """The point of the course nearest to (x, y), no farther than ``within`` m of s from ``s``:
        its s, and how far it is, m.
        """
        first = max(0, min(math.floor((s - within) / self.step), self.last))
        end = max(first, min(math.ceil((s + within) / self.step), self.last)) + 1
        px = x - self.x[first:end]
        py = y - self.y[first:end]
        dx = np.diff(self.x[first:end])
        dy = np.diff(self.y[first:end])
        if not len(dx):
            return first * self.step, float(np.hypot(px[0], py[0]))
        squared = np.maximum(dx * dx + dy * dy, 1e-18)
        part = np.clip((px[:-1] * dx + py[:-1] * dy) / squared, 0.0, 1.0)
        away = np.hypot(px[:-1] - part * dx, py[:-1] - part * dy)
        best = int(away.argmin())
        return (first + best + float(part[best])) * self.step, float(away[best])

    @cached_property
    def turns(self) -> bool:
        """True when the yaw changes along the course."""
        return bool(np.ptp(self.yaw) > 1e-9)

    def pose(self, s: float) -> tuple[float, float, float]:
        """x, y, yaw after s; held at the ends."""
        at = min(max(s / self.step, 0.0), float(self.last))
        k = min(int(at), max(self.last - 1, 0))
        part = at - k
        nxt = min(k + 1, self.last)
        x = self.x
        y = self.y
        yaw = self.yaw
        return (
            float(x[k] + part * (x[nxt] - x[k])),
            float(y[k] + part * (y[nxt] - y[k])),
            float(yaw[k] + part * (yaw[nxt] - yaw[k])),
        )
