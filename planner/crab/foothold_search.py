"""Where the swing foot may land: domain D_u (H §5.3), search start I_u (§5.4), the search for J_u
(§5.5).

All three domain methods are one number: the crossing distance D_X(P), how far along L_G the body is
when it crosses the line through the candidate P and f̄, the front foot on the other side.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from ..geometry.paths import Box, line_exit
from ..stability import XY
from ..terrain.map import TerrainMap
from .gait import FRONT_ACROSS, IS_FRONT, IS_LEFT, PREDECESSOR, REAR_ACROSS, Posture, Standard

NEAR = 1e-9  # m; rounding: a point this far outside a limit is on it


class Ground(NamedTuple):
    """What landing asks of the map, as plain values: one byte a cell, 1 where a foot must not land."""

    forbidden: bytes
    rows: int
    columns: int
    cell: float
    x: float  # corner of cell [0, 0]
    y: float

    def allows(self, ax: float, ay: float) -> bool:
        """True when the cell under an absolute point is on the map and not prohibited."""
        column, row = math.floor((ax - self.x) / self.cell), math.floor((ay - self.y) / self.cell)
        return (
            0 <= column < self.columns
            and 0 <= row < self.rows
            and not self.forbidden[row * self.columns + column]
        )


class Landing(NamedTuple):
    """A foothold: in the canonical frame E_k and in the absolute one."""

    x: float
    y: float
    ax: float
    ay: float


class Domain(NamedTuple):
    """D_u as predicates. ``across`` and ``along`` are measured from L_G, positive to its left and
    forward.
    """

    leg: int
    ux: float
    uy: float
    box: Box  # u's reach as projected to N_{k+1}, in E_k
    now: Box  # u's reach at N_k: what g_u(P) is measured with
    left: bool  # method III: u stays on this side of L_G
    hind: bool  # methods I and II are for hind legs
    f_along: float  # f̄
    f_across: float
    limit: float  # method I: the least of g of f̄ and g of r̄
    least: float  # method II: g, or -inf when it is not asked for

    def crossing(self, x: float, y: float) -> float:
        """D_X(P): where L_G meets the line through f̄ and P; inf when they are parallel."""
        across, along = self.ux * y - self.uy * x, self.ux * x + self.uy * y
        spread = across - self.f_across
        if abs(spread) < 1e-12:
            return math.inf
        return (self.f_along * across - along * self.f_across) / spread

    def refuses(self, x: float, y: float) -> str | None:
        """Why the point is not in D_u; None when it is."""
        if not (
            self.box[0] - NEAR <= x <= self.box[1] + NEAR
            and self.box[2] - NEAR <= y <= self.box[3] + NEAR
        ):
            return "out of reach"
        across = self.ux * y - self.uy * x
        if (across < -NEAR) if self.left else (across > NEAR):
            return "on the other side of the course (method III)"
        if not self.hind:
            return None
        crossing = self.crossing(x, y)
        if (
            crossing > self.limit + NEAR
            or crossing > line_exit(x, y, self.now, self.ux, self.uy) + NEAR
        ):
            return "the hind leg after next could not swing (method I)"  # H §5.3.1 (15)-(18)
        if crossing < self.least - NEAR:
            return "the front leg of this side could not swing next (method II)"  # H §5.3.2
        return None


def ground_of(terrain: TerrainMap) -> Ground:
    """The landing view of a map."""
    return Ground(
        terrain.forbidden_bytes,
        terrain.rows,
        terrain.columns,
        terrain.cell,
        terrain.origin[0],
        terrain.origin[1],
    )


def domain_of(
    standard: Standard,
    feet: tuple[XY, ...],
    exits: tuple[float, ...],
    leg: int,
    g: float,
    convergent: bool,
) -> Domain:
    """D_u of ``leg`` when the body goes g; ``convergent`` asks for method II as well."""
    ux, uy = standard.ux, standard.uy
    x1, x2, y1, y2 = now = standard.boxes[leg]
    dx, dy = g * ux, g * uy
    fx, fy = feet[FRONT_ACROSS[leg]]
    hind = not IS_FRONT[leg]
    return Domain(
        leg,
        ux,
        uy,
        (x1 + dx, x2 + dx, y1 + dy, y2 + dy),
        now,
        IS_LEFT[leg],
        hind,
        ux * fx + uy * fy,
        ux * fy - uy * fx,
        min(exits[FRONT_ACROSS[leg]], exits[REAR_ACROSS[leg]]),
        g if hind and convergent else -math.inf,
    )


def landings(
    standard: Standard,
    posture: Posture,
    domain: Domain,
    exits: tuple[float, ...],
    g: float,
    ground: Ground,
    trial: dict[str, Any] | None = None,
) -> Iterator[tuple[XY, Landing]]:
    """I_u and the footholds in D_u, in the order of H §5.5; the first is J_u. I_u itself comes
    exactly where its cell is free.
    """
    cx, cy = standard.centres[domain.leg]
    low, high = stroke_in(standard, domain, g)
    phase = phase_point(standard, posture, exits, domain.leg)
    if low <= high:
        ahead = _on_stroke(standard, posture, domain.leg, phase, low, high)
        start = cx + ahead * domain.ux, cy + ahead * domain.uy
    else:
        nearest = nearest_in(domain, cx + phase * domain.ux, cy + phase * domain.uy)
        if nearest is None:
            return
        start = nearest
    if trial is not None:
        trial["domain"] = {
            "stroke": [low, high] if low <= high else None,  # null: the stroke line misses D_u
            "phase": phase,
            "crossing_max": domain.limit if domain.hind else None,
            "crossing_min": domain.least if domain.least > -math.inf else None,
        }
        trial["search_start"] = list(posture.absolute(*start))
    ax, ay = posture.absolute(*start)
    if domain.refuses(*start) is None:
        if ground.allows(ax, ay):
            yield start, Landing(start[0], start[1], ax, ay)
        elif trial is not None:
            trial["refused"].append({"x": ax, "y": ay, "reason": "prohibited cell"})
    for landing in cells_from(posture, domain, (ax, ay), ground, trial):
        yield start, landing


def phase_point(standard: Standard, posture: Posture, exits: tuple[float, ...], leg: int) -> float:
    """Where on the stroke line the phase-maintaining method puts u, as a distance ahead of C_u (H
    §5.4, table 2).

    There u leaves its reach later than u* by exactly the standard phase difference.
    """
    return exits[PREDECESSOR[leg]] + standard.lags[leg] - standard.stride / 2


def _on_stroke(
    standard: Standard, posture: Posture, leg: int, phase: float, low: float, high: float
) -> float:
    """I_u on the stroke line: the nearer of the two phase points if it is in D_u, else the farther,
    else the most forward in D_u.
    """
    if low - NEAR <= phase <= high + NEAR:
        return phase
    before = PREDECESSOR[leg]
    (fx, fy), box = posture.feet[before], standard.boxes[before]
    later = max(line_exit(fx, fy, box, standard.ux, 0.0), line_exit(fx, fy, box, 0.0, standard.uy))
    other = later + standard.lags[leg] - standard.stride / 2
    return other if low <= other <= high else high


def stroke_in(standard: Standard, domain: Domain, g: float) -> tuple[float, float]:
    """The part of the standard stroke line of u inside D_u, as distances ahead of C_u; low > high
    when the line misses D_u.
    """
    (cx, cy), half = standard.centres[domain.leg], standard.stride / 2
    low, high = g - half, g + half
    across, along = domain.ux * cy - domain.uy * cx, domain.ux * cx + domain.uy * cy
    if (across < -NEAR) if domain.left else (across > NEAR):
        return math.inf, -math.inf
    if not domain.hind:
        return low, high
    spread = across - domain.f_across
    if abs(spread) < 1e-12:
        return math.inf, -math.inf
    # D_X = base + slope·t
    base, slope = (
        (domain.f_along * across - along * domain.f_across) / spread,
        -domain.f_across / spread,
    )
    # each a·t <= b
    for a, b in (
        (slope, domain.limit - base),
        (slope - 1.0, half - base),
        (-slope, base - domain.least),
    ):
        if a > 1e-12:
            high = min(high, b / a)
        elif a < -1e-12:
            low = max(low, b / a)
        elif b < -NEAR:
            return math.inf, -math.inf
    return (low, high) if low <= high + NEAR else (math.inf, -math.inf)


def nearest_in(domain: Domain, x: float, y: float) -> XY | None:
    """The point of D_u nearest to (x, y), as far as D_u has straight sides (``corners_of``); None
    if D_u is empty.
    """
    corners = corners_of(domain)
    return nearest_of(corners, x, y) if corners else None


def corners_of(domain: Domain) -> list[XY]:
    """D_u as a polygon, the hyperbola of method I left out (``refuses`` still knows it); empty when
    D_u is.
    """
    x1, x2, y1, y2 = domain.box
    corners = [(x1, y1), (x2, y1), (x2, y2), (x1, y2)]
    side = 1.0 if domain.left else -1.0
    corners = clipped(corners, -side * domain.uy, side * domain.ux, 0.0)
    if domain.hind:
        for bound, sign in ((domain.limit, -side), (domain.least, side)):
            # sign·(D_X - bound) >= 0, multiplied by the spread, whose sign is that of side
            if math.isfinite(bound):
                a, b = sign * -domain.f_across, sign * (domain.f_along - bound)
                corners = clipped(
                    corners,
                    a * domain.ux - b * domain.uy,
                    a * domain.uy + b * domain.ux,
                    sign * bound * domain.f_across,
                )
    return corners


def clipped(corners: list[XY], a: float, b: float, c: float) -> list[XY]:
    """The part of a convex polygon where a·x + b·y + c >= 0; rounding must not lose a D_u that is a
    mere line (I meets II).
    """
    kept: list[XY] = []
    for (px, py), (qx, qy) in zip(corners, corners[1:] + corners[:1], strict=True):
        p, q = a * px + b * py + c, a * qx + b * qy + c
        if p >= -NEAR / 4:
            kept.append((px, py))
        if (p > NEAR / 4 and q < -NEAR / 4) or (p < -NEAR / 4 and q > NEAR / 4):
            w = p / (p - q)
            kept.append((px + w * (qx - px), py + w * (qy - py)))
    return kept


def nearest_of(corners: list[XY], x: float, y: float) -> XY:
    best, least = corners[0], math.inf
    inside, apart = True, False  # a polygon that is a mere line has no inside
    for (px, py), (qx, qy) in zip(corners, corners[1:] + corners[:1], strict=True):
        ex, ey = qx - px, qy - py
        left = ex * (y - py) - ey * (x - px)
        inside, apart = inside and left >= 0.0, apart or left > 0.0
        length = ex * ex + ey * ey
        w = min(1.0, max(0.0, ((x - px) * ex + (y - py) * ey) / length)) if length > 0.0 else 0.0
        nx, ny = px + w * ex, py + w * ey
        away = (nx - x) ** 2 + (ny - y) ** 2
        if away < least:
            best, least = (nx, ny), away
    return (x, y) if inside and apart else best


def cells_from(
    posture: Posture, domain: Domain, start: XY, ground: Ground, trial: dict[str, Any] | None = None
) -> Iterator[Landing]:
    """Centres of the free cells in D_u in the order of H §5.5.

    A row lies across the course: sideways from I_u first, which keeps the phase; then the rows
    behind and ahead in turn, each from the cell on the stroke line. The map's axis nearest to the
    course plays the part of "ahead".
    """
    forbidden, rows, columns, cell, ox, oy = ground
    c, s = posture.c, posture.s
    x1, x2, y1, y2 = domain.box
    mx, my = posture.absolute((x1 + x2) / 2, (y1 + y2) / 2)
    hx, hy = (x2 - x1) / 2, (y2 - y1) / 2
    half_x, half_y = abs(c) * hx + abs(s) * hy, abs(s) * hx + abs(c) * hy
    spans = (
        _span(mx - half_x, mx + half_x, ox, cell, columns),
        _span(my - half_y, my + half_y, oy, cell, rows),
    )
    # the course in the absolute frame
    vx, vy = c * domain.ux - s * domain.uy, s * domain.ux + c * domain.uy
    lengthwise = abs(vx) >= abs(vy)
    ahead, beside = spans if lengthwise else spans[::-1]
    if ahead[0] > ahead[1] or beside[0] > beside[1]:
        return
    a0, b0 = (start[0] - ox) / cell, (start[1] - oy) / cell
    if not lengthwise:
        a0, b0 = b0, a0
    slope = vy / vx if lengthwise else vx / vy
    forward = 1 if (vx if lengthwise else vy) > 0.0 else -1
    first = math.floor(a0)
    bx, by = posture.x, posture.y
    refuses = domain.refuses
    for row in _outward(first, ahead[0], ahead[1], -forward):
        middle = math.floor(b0 if row == first else b0 + slope * (row + 0.5 - a0))
        for place in _outward(middle, beside[0], beside[1], 1):
            column, line = (row, place) if lengthwise else (place, row)
            if forbidden[line * columns + column] and trial is None:
                continue
            ax, ay = ox + (column + 0.5) * cell, oy + (line + 0.5) * cell
            dx, dy = ax - bx, ay - by
            px, py = c * dx + s * dy, c * dy - s * dx
            if refuses(px, py) is not None:
                continue
            if forbidden[line * columns + column]:
                if trial is not None:
                    trial["refused"].append({"x": ax, "y": ay, "reason": "prohibited cell"})
                continue
            yield Landing(px, py, ax, ay)


def _span(low: float, high: float, origin: float, cell: float, count: int) -> tuple[int, int]:
    """First and last cell whose centre lies in [low, high], cut to the map."""
    return max(0, math.ceil((low - origin) / cell - 0.5 - 1e-9)), min(
        count - 1, math.floor((high - origin) / cell - 0.5 + 1e-9)
    )


def _outward(middle: int, low: int, high: int, first: int) -> Iterator[int]:
    """middle, then one to the ``first`` side, one to the other, two to the first ... as far as they
    are in [low, high].
    """
    if low <= middle <= high:
        yield middle
    step = 1
    while middle - step >= low or middle + step <= high:
        for place in (middle + first * step, middle - first * step):
            if low <= place <= high:
                yield place
        step += 1
