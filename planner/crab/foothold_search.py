"""Where the swing foot may land: domain D_u (H §5.3), search start I_u (§5.4), the search for J_u
(§5.5).

All three domain methods are one number: the crossing distance D_X(P), how far along L_G the body is
when it crosses the line through the candidate P and f̄, the front foot on the other side.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from ..decision_log import DecisionLog, note_cell
from ..geometry.paths import NOWHERE, Box, bounded_by, corners_of_box, line_exit
from ..geometry.polygons import clipped, nearest_of
from ..geometry.transforms import XY
from ..motion.leg_order import FRONT_ACROSS, IS_FRONT, IS_LEFT, PREDECESSOR, REAR_ACROSS
from ..terrain.cells import FootholdMap, HalfPlane, cells_across
from .gait import NominalGait, Posture
from .step_refusals import StepRefusal
from .steps import Landing

NEAR = 1e-9  # m; rounding: a point this far outside a limit is on it


@dataclass(slots=True)
class Domain:
    """D_u as predicates; ``across`` is positive to the left of L_G, ``along`` forward."""

    leg: int
    ux: float
    uy: float
    box: Box  # u's reach as projected to N_{k+1}, in E_k
    now: Box  # u's reach at N_k: what g_u(P) is measured with
    g: float  # how far the body goes
    left: bool  # method III: u stays on this side of L_G
    hind: bool  # methods I and II are for hind legs
    f_along: float  # f̄
    f_across: float
    limit: float  # method I: the least of g of f̄ and g of r̄
    least: float  # method II: g, or -inf when it is not asked for

    def beside(self, across: float) -> bool:
        """True on the wrong side of L_G (method III)."""
        return across < -NEAR if self.left else across > NEAR

    def crossing(self, x: float, y: float) -> float:
        """D_X(P): where L_G meets the line through f̄ and P; inf when they are parallel."""
        across = self.ux * y - self.uy * x
        along = self.ux * x + self.uy * y
        spread = across - self.f_across
        if abs(spread) < 1e-12:
            return math.inf
        return (self.f_along * across - along * self.f_across) / spread

    def holds(self, x: float, y: float) -> bool:
        """True when the point is in D_u."""
        x1, x2, y1, y2 = self.box
        if not (x1 - NEAR <= x <= x2 + NEAR and y1 - NEAR <= y <= y2 + NEAR):
            return False
        across = self.ux * y - self.uy * x
        if (across < -NEAR) if self.left else (across > NEAR):
            return False  # method III
        if not self.hind:
            return True
        crossing = self.crossing(x, y)
        if not self.least - NEAR <= crossing <= self.limit + NEAR:
            return False  # method II, H §5.3.2, and method I
        return crossing <= line_exit(x, y, self.now, self.ux, self.uy) + NEAR  # H §5.3.1 (15)-(18)


def domain_of(posture: Posture, leg: int, g: float, convergent: bool) -> Domain:
    """D_u of ``leg`` when the body goes g; ``convergent`` asks for method II as well."""
    ux, uy, _ = posture.nominal.path
    x1, x2, y1, y2 = now = posture.nominal.boxes[leg]
    dx = g * ux
    dy = g * uy
    fx, fy = posture.feet[FRONT_ACROSS[leg]]
    exits = posture.exits
    hind = not IS_FRONT[leg]
    return Domain(
        leg,
        ux,
        uy,
        (x1 + dx, x2 + dx, y1 + dy, y2 + dy),
        now,
        g,
        IS_LEFT[leg],
        hind,
        ux * fx + uy * fy,
        ux * fy - uy * fx,
        min(exits[FRONT_ACROSS[leg]], exits[REAR_ACROSS[leg]]),
        g if hind and convergent else -math.inf,
    )


def landings(
    posture: Posture, domain: Domain, cells: FootholdMap, trial: DecisionLog | None = None
) -> Iterator[tuple[XY, Landing]]:
    """I_u and the footholds in D_u, in the order of H §5.5; the first is J_u. I_u itself comes
    exactly where its cell is free.
    """
    start = search_start(posture, domain, trial)
    if start is None:
        return
    x, y = start
    ax, ay = posture.absolute(x, y)
    if domain.holds(x, y):
        if cells.allows(ax, ay):
            yield start, Landing(x, y, ax, ay)
        else:
            note_cell(trial, ax, ay, StepRefusal.PROHIBITED)
    course = posture.turned(domain.ux, domain.uy)
    area = posture.around(domain.box)
    straight = 3 if domain.beside(domain.f_across) else 1  # method III, and I and II with it
    within = [posture.half_plane(*plane) for plane in half_planes(domain)[:straight]]
    order = cells_across(cells, area, (ax, ay), course, trial is not None, within)
    px, py, c, s = posture.x, posture.y, posture.c, posture.s  # this is asked of every cell
    holds = domain.holds
    for ax, ay, free in order:
        dx = ax - px
        dy = ay - py
        x = c * dx + s * dy
        y = c * dy - s * dx
        if not holds(x, y):
            continue
        if free:
            yield start, Landing(x, y, ax, ay)
        else:
            note_cell(trial, ax, ay, StepRefusal.PROHIBITED)


def search_start(posture: Posture, domain: Domain, trial: DecisionLog | None = None) -> XY | None:
    """I_u: on the stroke line within D_u, else the point of D_u nearest to the phase point."""
    cx, cy = posture.nominal.centres[domain.leg]
    low, high = stroke_in(posture.nominal, domain)
    phase = phase_point(posture, domain.leg)
    if low <= high:
        ahead = _on_stroke(posture, domain.leg, phase, low, high)
        start: XY | None = (cx + ahead * domain.ux, cy + ahead * domain.uy)
    else:
        start = nearest_in(domain, cx + phase * domain.ux, cy + phase * domain.uy)
    if trial is not None and start is not None:
        trial["domain"] = {
            "stroke": [low, high] if low <= high else None,  # null: the stroke line misses D_u
            "phase": phase,
            "crossing_max": domain.limit if domain.hind else None,
            "crossing_min": domain.least if domain.least > -math.inf else None,
        }
        trial["search_start"] = list(posture.absolute(*start))
    return start


def phase_point(posture: Posture, leg: int) -> float:
    """Where on its stroke the phase-maintaining method puts u, as a distance along the path ahead
    of C_u (H §5.4, table 2).

    There u leaves its stroke later than u* by exactly the nominal phase difference.
    """
    nominal = posture.nominal
    before = nominal.order.predecessor[leg]
    return posture.exits[before] - nominal.spares[before] + nominal.lags[leg] - nominal.ends[leg]


def _on_stroke(posture: Posture, leg: int, phase: float, low: float, high: float) -> float:
    """I_u on the stroke line: the nearer of the two phase points if it is in D_u, else the farther,
    else the most forward in D_u.
    """
    if low - NEAR <= phase <= high + NEAR:
        return phase
    nominal = posture.nominal
    ux, uy, _ = nominal.path
    before = PREDECESSOR[leg]
    fx, fy = posture.feet[before]
    box = nominal.boxes[before]
    later = max(line_exit(fx, fy, box, ux, 0.0), line_exit(fx, fy, box, 0.0, uy))
    other = later + nominal.lags[leg] - nominal.ends[leg]
    return other if low <= other <= high else high


def stroke_in(nominal: NominalGait, domain: Domain) -> tuple[float, float]:
    """The part of u's stroke line inside D_u, m ahead of C_u; low > high when it misses D_u."""
    cx, cy = nominal.centres[domain.leg]
    end = nominal.ends[domain.leg]
    low = domain.g - end
    high = domain.g + (nominal.stride - end)
    across = domain.ux * cy - domain.uy * cx
    along = domain.ux * cx + domain.uy * cy
    if domain.beside(across):
        return NOWHERE
    if not domain.hind:
        return low, high
    spread = across - domain.f_across
    if abs(spread) < 1e-12:
        return NOWHERE
    # D_X = base + slope·t
    base = (domain.f_along * across - along * domain.f_across) / spread
    slope = -domain.f_across / spread
    bounds = (
        (slope, domain.limit - base),
        (slope - 1.0, end - base),
        (-slope, base - domain.least),
    )
    return bounded_by(bounds, low, high, NEAR)


def nearest_in(domain: Domain, x: float, y: float) -> XY | None:
    """The point of D_u (``corners_of``) nearest to (x, y); None if D_u is empty."""
    corners = corners_of(domain)
    return nearest_of(corners, x, y) if corners else None


def half_planes(domain: Domain) -> list[HalfPlane]:
    """What bounds D_u beside its box, but for the hyperbola of method I, which ``holds`` knows:
    method III, then I and II, which are straight where f̄ is on the other side of L_G.
    """
    side = 1.0 if domain.left else -1.0
    planes = [(-side * domain.uy, side * domain.ux, 0.0)]
    if domain.hind:
        for bound, sign in ((domain.limit, -side), (domain.least, side)):
            # sign·(D_X - bound) >= 0, multiplied by the spread, whose sign is that of side
            if math.isfinite(bound):
                a, b = sign * -domain.f_across, sign * (domain.f_along - bound)
                across = a * domain.ux - b * domain.uy, a * domain.uy + b * domain.ux
                planes.append((*across, sign * bound * domain.f_across))
    return planes


def corners_of(domain: Domain) -> list[XY]:
    """D_u as a polygon, but for that hyperbola."""
    corners = corners_of_box(domain.box)
    for plane in half_planes(domain):
        corners = clipped(corners, *plane)
    return corners
