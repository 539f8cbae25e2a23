"""Where the legs say that the body is: feet that carry stay where they came down.

Every foot gets an anchor where it touches down, by the estimate of that moment; from then on the
body is where its legs, and the attitude an inertial sensor gives, put it over its anchors. Nothing
corrects the anchors, so that the estimate drifts: by what feet slip, and by what the sensors err.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from walking_console.planner.geometry.transforms import (
    Point,
    left_fold_sum,
    placed,
    rotation,
    turned_by,
)

from ..kinematic.rest_pose import plane_fit

# m a foot may seem to be off its anchor before it is said to slip. Smaller: see give taken for a
# slip; larger: see the body led astray by one foot
SLIP = 0.008


class LegOdometry:
    """x, y, z, yaw of the body as its legs measure it, and which of them slip."""

    def __init__(self, pose: Sequence[float], legs: int) -> None:
        self.x, self.y, self.z, self.yaw = pose
        self.anchors: list[Point | None] = [None] * legs
        self.slipping = [False] * legs

    def update(
        self, feet_b: Sequence[Point], carrying: Sequence[bool], roll: float, pitch: float
    ) -> None:
        """One tick: feet in body axes, m, which of them carry, and the attitude, rad."""
        level = rotation(roll, pitch, 0.0)
        reached = [turned_by(level, foot) for foot in feet_b]
        held = [leg for leg, anchor in enumerate(self.anchors) if anchor and carrying[leg]]
        bounces = len(held) < 2  # feet of stiff legs, off the ground for a tick, stand again soon
        if not bounces:
            self._fit_all_but_slipping(held, reached)
        for leg, carries in enumerate(carrying):
            if not carries and not bounces:
                self.anchors[leg] = None
                self.slipping[leg] = False
            elif carries and (self.anchors[leg] is None or self.slipping[leg]):
                self.anchors[leg] = self._placed(reached[leg])

    def _placed(self, spot: Point) -> Point:
        x, y = placed((self.x, self.y, self.yaw), spot[0], spot[1])
        return x, y, self.z + spot[2]

    def _fit(self, legs: Sequence[int], reached: Sequence[Point]) -> None:
        anchors = [anchor for leg in legs if (anchor := self.anchors[leg]) is not None]
        if len(anchors) >= 2:
            spots = [reached[leg] for leg in legs]
            self.x, self.y, self.yaw = plane_fit(anchors, spots, self.yaw)
        self.z = left_fold_sum(
            anchor[2] - reached[leg][2] for leg, anchor in zip(legs, anchors, strict=True)
        ) / len(legs)

    def _fit_all_but_slipping(self, held: list[int], reached: Sequence[Point]) -> None:
        """Leave out the foot that fits worst, and slips, until the others agree; two always do."""
        for leg in held:
            self.slipping[leg] = False
        while True:
            self._fit(held, reached)
            off, worst = max((self._off_anchor(leg, reached[leg]), leg) for leg in held)
            if off <= SLIP or len(held) <= 2:
                break
            self.slipping[worst] = True
            held.remove(worst)

    def _off_anchor(self, leg: int, spot: Point) -> float:
        anchor = self.anchors[leg]
        x, y, _ = self._placed(spot)
        return 0.0 if anchor is None else math.hypot(x - anchor[0], y - anchor[1])

    def state(self) -> dict[str, Any]:
        """What ``restore`` goes on from."""
        anchors = [None if anchor is None else list(anchor) for anchor in self.anchors]
        pose = [self.x, self.y, self.z, self.yaw]
        return {"pose": pose, "anchors": anchors, "slipping": list(self.slipping)}

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from a ``state``."""
        self.x, self.y, self.z, self.yaw = state["pose"]
        self.anchors = [None if a is None else (a[0], a[1], a[2]) for a in state["anchors"]]
        self.slipping = list(state["slipping"])
