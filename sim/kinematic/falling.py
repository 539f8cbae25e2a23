"""A tick of falling: the whole machine turns about an edge of its support until a foot catches it
or it lies.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from walking_console.planner.stability import GRAVITY
from walking_console.planner.types import TICK

from .configuration import Configuration, FootMotion
from .rest_pose import about, after, angles, turned
from .support import Support
from .tipping import (
    DROP_MAX,
    FALL_TILT,
    Edge,
    Fall,
    angular_acceleration,
    carried_over,
    edge_of,
    passed_on,
)

UPRIGHT = math.cos(FALL_TILT)  # cosine of the lean below which the machine lies
CORNERS = ((1, 1), (-1, 1), (-1, -1), (1, -1))


class Falling:
    """What becomes of a machine that has lost its balance. ``fall`` is None while it stands or
    lies.
    """

    def __init__(self, q: Configuration) -> None:
        self.q = q
        self.fall: Fall | None = None

    def begin(self) -> None:
        """The load has left the support polygon: it tips over the edge nearest to it."""
        q = self.q
        self.fall = Fall(edge_of({leg: q.feet[leg] for leg in q.carrying}, *q.load_point()))
        q.contact.stop()

    def advance(self, motions: Sequence[FootMotion], support: Support) -> bool:
        """One tick; legs still move. True when the machine has come to lie."""
        fall = self.fall
        q = self.q
        assert fall is not None
        q.drive(range(len(q.feet)), motions)
        if fall.edge is None:
            self._drop(fall)
        else:
            self._tilt(fall, fall.edge)
        touching = self._hang_feet(fall.edge.legs if fall.edge else ())
        if self._lies(fall):
            self.fall = None
            return True
        if touching:
            self._catch(fall, touching, support)
        return False

    def _drop(self, fall: Fall) -> None:
        fall.sink += GRAVITY * TICK
        fall.dropped += fall.sink * TICK
        self.q.body[2] -= fall.sink * TICK

    def _tilt(self, fall: Fall, edge: Edge) -> None:
        self._keep_on(edge)
        q = self.q
        body = self.q.body
        fall.rate += angular_acceleration(q.machine, edge, body, q.pushed) * TICK
        spin = about(edge.axis, fall.rate * TICK)
        px, py, pz = edge.point
        x, y, z = turned(spin, body[0] - px, body[1] - py, body[2] - pz)
        q.rotation = after(spin, q.rotation)
        roll, pitch, yaw = angles(q.rotation)
        # the yaw does not jump at ±π
        yaw += 2.0 * math.pi * round((body[5] - yaw) / (2.0 * math.pi))
        body[:] = px + x, py + y, pz + z, roll, pitch, yaw

    def _keep_on(self, edge: Edge) -> None:
        """Move the body so that the feet of the edge stay where they are while their legs move."""
        q = self.q
        body = self.q.body
        shift = [0.0, 0.0, 0.0]
        for leg in edge.legs:
            x, y, z = turned(q.rotation, *q.tips[leg])
            for axis, reached in enumerate((body[0] + x, body[1] + y, body[2] + z)):
                shift[axis] += (q.feet[leg][axis] - reached) / len(edge.legs)
        for axis in range(3):
            body[axis] += shift[axis]

    def _hang_feet(self, pivots: Sequence[int]) -> list[int]:
        """Put all feet but the pivots where the body has them; those that the ground stops are
        returned.
        """
        q = self.q
        for leg in pivots:
            q.soles[leg] = True
            q.slipping[leg] = False
        return [leg for leg in range(len(q.feet)) if leg not in pivots and q.hang(leg)]

    def _lies(self, fall: Fall) -> bool:
        """True when the torso leans too far, is on the ground, or has fallen into a hole."""
        q = self.q
        body = self.q.body
        if q.rotation[8] < UPRIGHT or fall.dropped > DROP_MAX:
            return True
        length, width, height = q.machine.torso
        for sx, sy in CORNERS:
            x, y, z = turned(q.rotation, sx * length / 2, sy * width / 2, -height / 2)
            if body[2] + z <= q.ground.height_at(body[0] + x, body[1] + y):
                return True
        return False

    def _catch(self, fall: Fall, touching: Sequence[int], support: Support) -> None:
        """Feet have come down: either they and the edge carry the body now, or it goes on about
        another edge.
        """
        q = self.q
        edge = fall.edge
        q.carrying = sorted({*touching, *(edge.legs if edge else ())})
        x, y = q.load_point()
        feet = {leg: q.feet[leg] for leg in q.carrying}
        if q.holds(x, y):
            self.fall = carried_over(q.machine, edge, fall.rate, feet, q.body) if edge else None
            if self.fall is None:
                q.measure_sideways()
        else:
            new = edge_of(feet, x, y)
            if edge is None or new is None or new.legs != edge.legs:
                fall.rate = passed_on(edge, new, fall.rate)
            fall.edge = new
            fall.sink = 0.0
        support.take_stock(falling=self.fall is not None)
