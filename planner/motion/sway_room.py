"""How far a body may sway aside of its reference: within what its standing legs reach, and with
neither they nor the torso running into something tall.

A plan is decided with the body on its reference. A body that sways leaves it by some centimetres,
which beside a wall or a pole is enough to lean a leg against it. Metres, absolute frame.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..geometry.transforms import (
    XY,
    Body,
    direction,
    point_seen,
    tilt_of,
    tilted,
    turned_back,
    turned_back_by,
)
from ..robot.collision import LEG_CHECKS, leg_in_the_way, something_tall
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Point, Stance
from .body_height import torso_clearance
from .body_path import OFFSET_MAX
from .body_tilt import LEVEL, Lean

SAFE = 0.002  # m of mechanical reach that is left
SLANT_MIN = 0.05  # of the sway along an axis of the body; less is none
LOOK = 0.01  # m of sway from one place that is looked at to the next, among tall things

StandingFeet = Sequence[Point | None]  # of all legs, those that stand; absolute


class SwayRoom:
    """What keeps the body of one machine near its reference; ``tall`` is the ground among whose
    tall things it walks, None where there are none.
    """

    def __init__(self, machine: Machine, tall: TerrainMap | None = None) -> None:
        self._machine = machine
        self._tall = tall

    @classmethod
    def about(cls, stance: Stance, machine: Machine, terrain: TerrainMap | None) -> SwayRoom:
        """That of a step from a stance."""
        if terrain is None:
            return cls(machine)
        x, y = stance.body[:2]
        lowest = min(foot[2] for foot in stance.feet)
        tall = something_tall(terrain, machine, x, y, lowest)
        return cls(machine, terrain if tall else None)

    def offsets(self, body: Body, side: XY, feet: StandingFeet, lean: Lean = LEVEL) -> XY:
        """The offsets of the body along the unit vector ``side`` at which every foot that stands is
        within its leg's mechanical reach, and which lead past nothing tall. No body is led off its
        reference for the sake of its reach alone: see it stand beside its support where sensors
        scatter. Of a body that leans, on a slope, only the reach is looked at.
        """
        low, high = self._in_reach(body, side, feet, lean)
        if self._tall is None or lean != LEVEL:
            return low, high
        return self._clear(body, side, feet, (low, high))

    def _in_reach(self, body: Body, side: XY, feet: StandingFeet, lean: Lean) -> XY:
        yaw = body[3]
        climb = lean[0] * side[0] + lean[1] * side[1]
        tilt = None if lean == LEVEL else tilt_of(lean, yaw)
        ahead, left, _ = tilted(tilt, (*turned_back(*side, yaw), climb))
        over_x, over_y, _ = self._machine.overreach
        low, high = -OFFSET_MAX, OFFSET_MAX
        for (x_low, x_high, y_low, y_high), foot in zip(self._machine.boxes, feet, strict=True):
            if foot is None:
                continue
            seen_x, seen_y, _ = tilted(tilt, point_seen(body, foot))
            for place, begin, end, over, rate in (
                (seen_x, x_low, x_high, over_x, ahead),
                (seen_y, y_low, y_high, over_y, left),
            ):
                if -SLANT_MIN <= rate <= SLANT_MIN:
                    continue
                near = (place - end - over + SAFE) / rate
                far = (place - begin + over - SAFE) / rate
                if near > far:
                    near, far = far, near
                if near > low:
                    low = near
                if far < high:
                    high = far
        return min(low, 0.0), max(high, 0.0)

    def _clear(self, body: Body, side: XY, feet: StandingFeet, bounds: XY) -> XY:
        """Of some offsets those that are reached from the least of them past nothing tall; all of
        them where that one meets something itself.
        """
        start = min(max(0.0, bounds[0]), bounds[1])
        if self.is_barred(_beside(body, side, start), feet):
            return bounds
        low, high = (self._as_far_as(body, side, feet, (start, end)) for end in bounds)
        return low, high

    def _as_far_as(self, body: Body, side: XY, feet: StandingFeet, way: XY) -> float:
        start, end = way
        looks = math.ceil(abs(end - start) / LOOK)
        free = start
        for k in range(1, looks + 1):
            offset = start + (end - start) * k / looks
            if self.is_barred(_beside(body, side, offset), feet):
                return free
            free = offset
        return end

    def is_barred(self, body: Body, feet: StandingFeet) -> bool:
        """True when a leg that stands, or the torso, would be in something tall with the body
        there.
        """
        if self._tall is None:
            return False
        x, y, z, yaw = body
        lowest = torso_clearance(self._tall, self._machine, x, y, yaw, z)
        return lowest > z or self.is_met(body, feet)

    @property
    def is_among_tall(self) -> bool:
        """True when something tall is near."""
        return self._tall is not None

    def is_met(self, body: Body, feet: StandingFeet) -> bool:
        """True when a leg, its foot in the air or not, is in something tall."""
        if self._tall is None:
            return False
        return leg_in_the_way(self._tall, self._machine, body, feet) is not None

    def beyond(self, body: Body, feet: StandingFeet, lean: Lean = LEVEL) -> float:
        """How far the farthest foot that stands is outside of its leg's mechanical reach with the
        body there, m; negative inside.
        """
        over_x, over_y, _ = self._machine.overreach
        x, y, z, yaw = body
        c, s = direction(yaw)
        tilt = None if lean == LEVEL else tilt_of(lean, yaw)
        most = -math.inf
        for (x_low, x_high, y_low, y_high), foot in zip(self._machine.boxes, feet, strict=True):
            if foot is None:
                continue
            dx = foot[0] - x
            dy = foot[1] - y
            ahead = c * dx + s * dy
            aside = c * dy - s * dx
            if tilt is not None:
                ahead, aside, _ = turned_back_by(tilt, (ahead, aside, foot[2] - z))
            most = max(
                most,
                ahead - x_high - over_x,
                x_low - over_x - ahead,
                aside - y_high - over_y,
                y_low - over_y - aside,
            )
        return most

    def keeps_within(self, bodies: Sequence[Body], feet: StandingFeet, spare: float) -> bool:
        """True when every foot that stands is within its leg's mechanical reach, by at least
        ``spare``, m, with a level body at any of some places, where it faces one way.
        """
        over_x, over_y, _ = self._machine.overreach
        c, s = direction(bodies[0][3])
        ahead = [c * x + s * y for x, y, _, _ in bodies]
        aside = [c * y - s * x for x, y, _, _ in bodies]
        back, front = min(ahead) + over_x - spare, max(ahead) - over_x + spare
        right, left = min(aside) + over_y - spare, max(aside) - over_y + spare
        for (x_low, x_high, y_low, y_high), foot in zip(self._machine.boxes, feet, strict=True):
            if foot is None:
                continue
            x = c * foot[0] + s * foot[1]
            y = c * foot[1] - s * foot[0]
            # seen from the hindmost place it is farthest ahead, from the foremost farthest behind
            if not (front + x_low <= x <= back + x_high and left + y_low <= y <= right + y_high):
                return False
        return True


def shift_is_barred(terrain: TerrainMap, machine: Machine, stance: Stance, place: XY) -> bool:
    """True when the torso, or a leg that stands, meets ground as the body goes straight to a place
    on all its feet. A leg that meets it already, as the map has it, may be led away from it.
    """
    x, y, z, yaw = stance.body
    if torso_clearance(terrain, machine, *place, yaw, z) > z:
        return True
    meets = leg_in_the_way(terrain, machine, stance.body, stance.feet) is not None
    for share in (1.0,) if meets else LEG_CHECKS:
        body = x + share * (place[0] - x), y + share * (place[1] - y), z, yaw
        if leg_in_the_way(terrain, machine, body, stance.feet) is not None:
            return True
    return False


def _beside(body: Body, side: XY, offset: float) -> Body:
    x, y, z, yaw = body
    return x + offset * side[0], y + offset * side[1], z, yaw
