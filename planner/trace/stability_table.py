"""Which sets of standing feet are stable on which samples of a trace (K "calculation of states").

The centre of gravity must be the margin to the left of every edge of the support polygon. Edges
between two footholds are looked up by their numbers, so that each is worked out once for all the
sets it borders.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ..geometry.paths import EDGE
from ..stability import MARGIN_SLACK
from .footholds import Foothold, Footing
from .lane import Lane
from .samples import SampleGrid, bits_of

MARGIN = 0.01  # m, least stability margin planned for


class StabilityTable:
    """Stable samples of every set of feet asked for, by foothold numbers."""

    def __init__(
        self, lane: Lane, samples: SampleGrid, footholds: Sequence[Foothold], margin: float = MARGIN
    ) -> None:
        """``footholds`` may grow; ``margin`` is in m."""
        self.footholds = footholds
        self.margin = margin
        self._all = samples.all
        pad = ((0, 0), (0, 1))
        self._x = np.pad(lane.x, pad).ravel()
        self._y = np.pad(lane.y, pad).ravel()
        self._corners: list[tuple[float, float, int]] = []  # of footholds: x, y, number
        self._edges: dict[tuple[int, int], int] = {}
        # edges the machine is nearer to than the margin where it stands now
        self._least: dict[tuple[int, int], float] = {}
        self._stable: dict[Footing, int] = {}

    def stable(self, feet: Footing) -> int:
        """Samples at which the centre of gravity is the margin inside the polygon of the standing
        feet.
        """
        mask = self._stable.get(feet)
        if mask is None:
            mask = self._stable[feet] = self._stability(feet)
        return mask

    def accept(self, feet: Footing, sample: int) -> bool:
        """Take the machine as it stands: where it is less stable than the margin asks it may become
        more so, never less. False when it does not stand at all.

        A stop in mid-step sets feet down wherever there is ground.
        """
        corners = self._hull(feet)
        if len(corners) < 3:
            return False
        x = float(self._x[sample])
        y = float(self._y[sample])
        for a, b in pairwise([*corners, corners[0]]):
            p = self.footholds[a]
            q = self.footholds[b]
            twice_area = (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x)
            inside = twice_area / math.hypot(q.x - p.x, q.y - p.y)
            if inside < -MARGIN_SLACK:
                return False
            if inside < self.margin:
                self._least[a, b] = inside
        return True

    @property
    def least_margin(self) -> float:
        """The least margin planned for anywhere, that of the machine as it stands included, m."""
        return min([self.margin, *self._least.values()])

    def _stability(self, feet: Footing) -> int:
        mask = self._all
        edges = self._edges
        corners = self._hull(feet)
        if len(corners) < 3:
            return 0
        a = corners[-1]
        for b in corners:
            edge = edges.get((a, b))
            if edge is None:
                edge = edges[a, b] = self._edge(a, b)
            mask &= edge
            if not mask:
                return 0
            a = b
        return mask

    def _hull(self, feet: Footing) -> list[int]:
        """Footholds at the corners of the polygon of the standing feet, counter-clockwise."""
        known = self._corners
        for hold in self.footholds[len(known) :]:
            known.append((hold.x, hold.y, len(known)))
        corners = sorted([known[f] for f in feet if f >= 0])
        if len(corners) < 3:
            return []
        hull: list[int] = []
        for side in (corners, corners[::-1]):
            chain: list[tuple[float, float, int]] = []
            count = 0
            for corner in side:
                x, y, _ = corner
                while count > 1:
                    ax, ay, _ = chain[-2]
                    bx, by, _ = chain[-1]
                    if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
                        break
                    chain.pop()
                    count -= 1
                chain.append(corner)
                count += 1
            hull += [number for _, _, number in chain[:-1]]
        return hull

    def _edge(self, a: int, b: int) -> int:
        """Samples at which the centre of gravity is the margin to the left of the line from
        foothold a to b.
        """
        p = self.footholds[a]
        q = self.footholds[b]
        ex = q.x - p.x
        ey = q.y - p.y
        length = math.sqrt(ex * ex + ey * ey)
        if length < EDGE:
            return 0
        distance = (ex / length) * self._y
        distance -= (ey / length) * self._x
        least = self._least.get((a, b), self.margin)
        return bits_of(distance >= least - EDGE + (ex * p.y - ey * p.x) / length)
