"""Level B3 (H §6): the height of the next foothold and of the body, and what of the ground the body
and the lift must clear.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..geometry.transforms import direction, left_fold_sum
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Point
from .leg_order import OTHERS
from .swing import CLEARANCE


def ground_ahead(left: Point, right: Point, ux: float, uy: float) -> tuple[float, float]:
    """ẑ_A and |A|: the height predicted where the course meets the line of the two leading feet,
    and how far ahead that is.

    Interpolated by the line's own parameter, not by x as printed: the feet may be level in x. A
    course that does not pass between the feet takes their mean, at the nearer one's distance.
    """
    left_across = ux * left[1] - uy * left[0]
    right_across = ux * right[1] - uy * right[0]
    left_along = ux * left[0] + uy * left[1]
    right_along = ux * right[0] + uy * right[1]
    spread = left_across - right_across
    w = left_across / spread if abs(spread) > 1e-9 else -1.0
    if not 0.0 <= w <= 1.0:
        return (left[2] + right[2]) / 2, min(left_along, right_along)
    # H §6 (20)
    return left[2] + w * (right[2] - left[2]), left_along + w * (right_along - left_along)


def body_height(
    z: float, g: float, ahead: tuple[float, float], height: float, low: float, high: float
) -> float:
    """Height of the CoG at N_{k+1}: on the straight line to H above the ground at A, within what
    the standing legs reach.
    """
    ground, distance = ahead
    share = g / distance if distance > g else 1.0
    return min(max(z + share * (ground + height - z), low), high)  # H §6 (21)


class FeetHeights:
    """Feet on four heights, m, and a body at height ``z``: how high it may be when one of them
    comes down elsewhere.
    """

    def __init__(self, machine: Machine, heights: Sequence[float], z: float) -> None:
        self._heights = heights
        self._z = z
        self._z_range = machine.z_range
        self._others = [
            (min(a, b, c), max(a, b, c))
            for a, b, c in ((heights[i], heights[j], heights[k]) for i, j, k in OTHERS)
        ]
        self._known: dict[tuple[int, float, float], tuple[float, float]] = {}

    def limits(self, leg: int, ground: float, share: float) -> tuple[float, float]:
        """Lowest and highest CoG with all feet in reach, that of ``leg`` on the ground it comes
        down on; low > high when there is none.

        After ``share`` of the way there that leg must still be in reach where it stands. Asked for
        every foothold, most of which are as high as another, so remembered.
        """
        limits = self._known.get((leg, ground, share))
        if limits is None:
            limits = self._known[leg, ground, share] = self._limits(leg, ground, share)
        return limits

    def _limits(self, leg: int, ground: float, share: float) -> tuple[float, float]:
        below, above = self._z_range
        lowest, highest = self._others[leg]
        low = max(highest, ground) - above
        high = min(lowest, ground) - below
        if share > 0.0:
            z = self._z
            stands = self._heights[leg]
            low = max(low, z + (stands - above - z) / share)
            high = min(high, z + (stands - below - z) / share)
        return low, high

    def mean(self, leg: int, ground: float) -> float:
        """Mean height of the feet, that of ``leg`` on such ground, m."""
        heights = list(self._heights)
        heights[leg] = ground
        return left_fold_sum(heights) / 4


def clears_all(terrain: TerrainMap, machine: Machine, z: float) -> bool:
    """True when the torso of a body at height ``z`` passes over everything on the map."""
    return terrain.highest + machine.torso[2] / 2 + CLEARANCE <= z


def torso_needs(terrain: TerrainMap, machine: Machine, x: float, y: float, yaw: float) -> float:
    """Lowest CoG at which the torso at (x, y, yaw) passes over the ground, m; -inf where there is
    none. First a square around it.
    """
    reach = math.hypot(machine.torso[0], machine.torso[1]) / 2
    return (
        terrain.crest_in(x - reach, x + reach, y - reach, y + reach)
        + machine.torso[2] / 2
        + CLEARANCE
    )


def torso_needs_exactly(
    terrain: TerrainMap, machine: Machine, x: float, y: float, yaw: float
) -> float:
    """As ``torso_needs`` with the turned rectangle itself, sampled at half the map's spacing; about
    ten times slower.
    """
    half_length = machine.torso[0] / 2
    half_width = machine.torso[1] / 2
    along = np.linspace(-half_length, half_length, math.ceil(4 * half_length / terrain.cell) + 1)
    across = np.linspace(-half_width, half_width, math.ceil(4 * half_width / terrain.cell) + 1)
    px, py = (grid.ravel() for grid in np.meshgrid(along, across))
    c, s = direction(yaw)
    columns = np.floor((x + c * px - s * py - terrain.origin[0]) / terrain.cell).astype(np.int64)
    rows = np.floor((y + s * px + c * py - terrain.origin[1]) / terrain.cell).astype(np.int64)
    inside = (columns >= 0) & (columns < terrain.columns) & (rows >= 0) & (rows < terrain.rows)
    heights = terrain.heights[rows[inside], columns[inside]]
    solid = heights[~np.isnan(heights)]
    return (float(solid.max()) if solid.size else -math.inf) + machine.torso[2] / 2 + CLEARANCE


def torso_clearance(
    terrain: TerrainMap, machine: Machine, x: float, y: float, yaw: float, height: float = -math.inf
) -> float:
    """Lowest CoG at which the torso at (x, y, yaw) clears the ground, m; looked at exactly only
    where the quick look wants more than ``height``.
    """
    needs = torso_needs(terrain, machine, x, y, yaw)
    return needs if needs <= height else torso_needs_exactly(terrain, machine, x, y, yaw)
