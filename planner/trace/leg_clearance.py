"""Legs beside what is tall (K's third truncation, "non-touching the surface"): from hip to foot a
leg runs through nothing, where it stands and on its way.

The same line as in ``robot.collision``, looked at for all poses of a lane at once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Body, directions
from ..motion.swing import CLEARANCE
from ..robot.collision import NEAR_FOOT, TALL
from ..robot.model import Machine
from ..terrain.grid import spread_max
from ..terrain.map import TerrainMap
from ..types import Point
from .footholds import within_reach
from .lane import Lane

SWEPT_APART = 0.05  # m between the looks at a foot on its way; more and a pole slips between


class Swing(NamedTuple):
    """How a foot is carried: from where to where, while the body takes these poses one after the
    other.
    """

    stood: Point
    lands: Point
    bodies: Sequence[Body]  # x, y, z, yaw


class LegClearance:
    """Which legs meet ground where on a lane, standing on which points or carried between them."""

    def __init__(self, lane: Lane, terrain: TerrainMap, machine: Machine) -> None:
        self._lane = lane
        self._terrain = terrain
        self._machine = machine
        lowest = float(lane.z.min()) - machine.height
        self.matters = not terrain.is_level and terrain.highest - lowest > TALL
        self._near: NDArray[np.bool_] | None = None
        if self.matters:
            self._look_for_tall_things(lowest + TALL)

    def _look_for_tall_things(self, height: float) -> None:
        """Cells from which a leg may reach something tall."""
        terrain = self._terrain
        window = within_reach(self._lane, terrain, self._machine)
        tall = np.nan_to_num(terrain.heights[window], nan=-np.inf) > height
        self.matters = bool(tall.any())
        if not self.matters:
            return
        longest = max(
            math.hypot(x - hip[0], y - hip[1])
            for leg, hip in zip(self._machine.legs, self._machine.hips, strict=True)
            for x in leg.x
            for y in leg.y
        )
        reach = math.ceil(longest / terrain.cell) + 1
        near = np.zeros(terrain.heights.shape, dtype=bool)
        near[window] = spread_max(tall.astype(np.float64), reach) > 0.0
        self._near = near

    def is_near(self, x: float, y: float) -> bool:
        """True when a leg that stands at (x, y) may reach something tall."""
        if self._near is None:
            return False
        cell = self._terrain.cell_at(x, y)
        return cell is not None and bool(self._near[cell])

    def clear(self, leg: int, foot: Point, poses: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(rows, samples): those of ``poses`` at which the leg that stands on ``foot`` meets
        nothing.
        """
        rows, samples = np.nonzero(poses)
        meets = self._meets(leg, foot, rows, samples)
        free = poses.copy()
        free[rows[meets], samples[meets]] = False
        return free

    def _meets(
        self,
        leg: int,
        foot: Point,
        rows: NDArray[np.intp],
        samples: NDArray[np.intp],
    ) -> NDArray[np.bool_]:
        """Whether the leg meets ground, pose by pose."""
        lane = self._lane
        x = lane.x[rows, samples]
        bodies = np.column_stack((x, lane.y[rows, samples], lane.z[samples], lane.yaw[samples]))
        return self._lines_meet(leg, bodies, np.broadcast_to(np.array(foot), (len(x), 3)))

    def sweeps_through(self, leg: int, way: Swing) -> bool:
        """True when a leg that swings meets ground on its way, its foot lifted over what lies
        between.
        """
        bodies = np.array(way.bodies)
        (ax, ay, az), (bx, by, bz) = way.stood, way.lands
        if not (self.is_near(ax, ay) or self.is_near(bx, by)):
            return False
        parts = max(2, math.ceil(math.hypot(bx - ax, by - ay) / SWEPT_APART))
        share = np.arange(1, parts) / parts
        lifted = max(self._terrain.crest_between(ax, ay, bx, by) + CLEARANCE, az, bz)
        feet = np.column_stack(
            (ax + share * (bx - ax), ay + share * (by - ay), np.full(parts - 1, lifted))
        )
        at = np.round(share * (len(bodies) - 1)).astype(np.intp)
        return bool(self._lines_meet(leg, bodies[at], feet).any())

    def _lines_meet(
        self, leg: int, bodies: NDArray[np.float64], feet: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        """Whether the leg meets ground between hip and foot: (n, 4) x, y, z, yaw of bodies and
        (n, 3) feet.
        """
        hip_x, hip_y = self._machine.hips[leg]
        c, s = directions(bodies[:, 3])
        x = bodies[:, 0] + c * hip_x - s * hip_y
        y = bodies[:, 1] + s * hip_x + c * hip_y
        length = np.hypot(feet[:, 0] - x, feet[:, 1] - y)
        parts = max(1, math.ceil(float(length.max(initial=0.0)) / self._terrain.cell))
        near = NEAR_FOOT + self._terrain.foot_radius
        far = np.maximum(length - near, 0.0) / np.maximum(length, near)
        share = far[:, None] * np.linspace(0.0, 1.0, parts + 1)
        px = x[:, None] + share * (feet[:, 0] - x)[:, None]
        py = y[:, None] + share * (feet[:, 1] - y)[:, None]
        pz = bodies[:, 2][:, None] * (1.0 - share) + share * feet[:, 2][:, None]
        return np.asarray((self._ground_at(px, py) > pz).any(axis=1))

    def _ground_at(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Highest ground within a foot's radius, which is about as thick as a leg, m; -inf outside
        the map.
        """
        terrain = self._terrain
        columns = np.floor((x - terrain.origin[0]) / terrain.cell).astype(np.intp)
        rows = np.floor((y - terrain.origin[1]) / terrain.cell).astype(np.intp)
        inside = (rows >= 0) & (rows < terrain.rows)
        inside &= (columns >= 0) & (columns < terrain.columns)
        crests = np.asarray(terrain.crest_view).reshape(terrain.rows, terrain.columns)
        tops = crests[rows.clip(0, terrain.rows - 1), columns.clip(0, terrain.columns - 1)]
        return np.asarray(np.where(inside, tops, -np.inf))
