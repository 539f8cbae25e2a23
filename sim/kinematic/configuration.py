"""Where everything of the machine is, and which feet carry it; changed in place, tick by tick."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from walking_console.planner.geometry.transforms import left_fold_sum
from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import GRAVITY, TIP_SLACK, polygon_margin, support_polygon
from walking_console.planner.types import Stance

from ..terrain.ground import Ground
from .contact import ContactWorld
from .rest_pose import Rotation, rotation, turned, unturned

SOLE_GAP = 0.001  # m; a sole this near the ground is on: what it gives under load
STEP_UP = 0.01  # m; a foot moving sideways rides up this much, a taller riser stops it
ON_GROUND = 0.005  # m; a foot of the start stance this near the ground stands on it

FootMotion = tuple[float, float, float]  # m in one tick, body axes
XY = tuple[float, float]


class Configuration:
    """The machine's state variables, and the small changes that all of the plant is made of.

    ``body`` is x, y, z, roll, pitch, yaw; ``feet`` are foot tips, absolute, and ``tips`` the same
    in body axes; ``rotation`` goes from body axes to absolute ones. ``carrying`` and ``free`` are
    legs, each sorted. The lists of body, feet, soles and whiskers are never replaced by others.
    """

    def __init__(self, machine: Machine, ground: Ground, stance: Stance) -> None:
        x, y, z, yaw = stance.body
        self.machine = machine
        self.ground = ground
        self.contact = ContactWorld(ground.obstacles, machine)
        self.body = [x, y, z, 0.0, 0.0, yaw]
        self.feet = [list(foot) for foot in stance.feet]
        self.rotation: Rotation = rotation(0.0, 0.0, yaw)
        self.tips = [[0.0, 0.0, 0.0] for _ in self.feet]
        self.soles = [False] * len(self.feet)
        self.whiskers = [0] * len(self.feet)
        self.rims = [0] * len(self.feet)
        self.slipping = [False] * len(self.feet)
        self.carrying: list[int] = []
        self.free: list[int] = []
        self.push = (0.0, 0.0)  # N, absolute axes
        self.push_ticks = 0
        for leg in range(len(self.feet)):
            self.measure(leg)
            if leg not in stance.lifted:
                self._stand_at_start(leg)

    def _stand_at_start(self, leg: int) -> None:
        foot = self.feet[leg]
        height = self.ground.height_at(foot[0], foot[1])
        if abs(foot[2] - height) <= ON_GROUND:
            foot[2] = height
            self.measure(leg)
            self.carrying.append(leg)

    def replace_ground(self, ground: Ground) -> None:
        """Other ground; the machine stays where it is, and what carries it is for others to say."""
        if ground.obstacles is self.ground.obstacles:
            self.contact.stop()
        else:
            self.contact = ContactWorld(ground.obstacles, self.machine)
        self.ground = ground

    # -- body and legs

    def turn_to(self, x: float, y: float, yaw: float, roll: float, pitch: float) -> None:
        """Put the body over (x, y) in this attitude, at the height it has."""
        body = self.body
        body[0] = x
        body[1] = y
        body[3] = roll
        body[4] = pitch
        body[5] = yaw
        self.rotation = rotation(roll, pitch, yaw)

    def measure(self, leg: int) -> None:
        """Set the monitors of a leg to where its foot is."""
        body = self.body
        foot = self.feet[leg]
        self.tips[leg][:] = unturned(
            self.rotation, foot[0] - body[0], foot[1] - body[1], foot[2] - body[2]
        )

    def measure_sideways(self) -> None:
        """Set the monitors of carrying legs, but for their lengths, to where their feet stand."""
        x, y, z, *_ = self.body
        for leg in self.carrying:
            foot = self.feet[leg]
            tip = self.tips[leg]
            tip[0], tip[1], _ = unturned(self.rotation, foot[0] - x, foot[1] - y, foot[2] - z)

    def drive(self, legs: Iterable[int], motions: Sequence[FootMotion]) -> None:
        """Move the tips of these legs, in body axes."""
        for leg in legs:
            tip = self.tips[leg]
            (dx, dy, dz) = motions[leg]
            tip[0] += dx
            tip[1] += dy
            tip[2] += dz

    def hang(self, leg: int) -> bool:
        """Put a foot where the body has it; True when that is on the ground, which stops it."""
        body = self.body
        foot = self.feet[leg]
        stood_x, stood_y, stood_z = foot
        x, y, z = turned(self.rotation, *self.tips[leg])
        foot[:] = body[0] + x, body[1] + y, body[2] + z
        height = self.ground.height_at(foot[0], foot[1])
        if height - max(foot[2], stood_z) > STEP_UP:  # a riser beside it: it stays before that
            foot[0], foot[1] = stood_x, stood_y
            x, y = stood_x - body[0], stood_y - body[1]
            height = self.ground.height_at(stood_x, stood_y)
            self.tips[leg][:] = unturned(self.rotation, x, y, z)
        self.soles[leg] = foot[2] - height <= SOLE_GAP
        self.slipping[leg] = False
        if not foot[2] <= height:
            return False
        foot[2] = height
        self.tips[leg][:] = unturned(self.rotation, x, y, height - body[2])
        return True

    def bumps(self, x: float, y: float, yaw: float) -> bool:
        """True when torso or legs would be in an obstacle with the body over (x, y)."""
        return self.contact.bump((x, y, self.body[2], 0.0, 0.0, yaw), self.feet) is not None

    # -- what presses where

    @property
    def pushed(self) -> XY:
        """The push of this tick, N in absolute axes."""
        return self.push if self.push_ticks else (0.0, 0.0)

    def load_point(self) -> XY:
        """Where the weight and a push, taken together, press on the ground."""
        x, y, z, *_ = self.body
        if not self.push_ticks or not self.carrying:
            return x, y
        ground = left_fold_sum(self.feet[leg][2] for leg in self.carrying) / len(self.carrying)
        lever = (z - ground) / (self.machine.mass * GRAVITY)
        return x + self.push[0] * lever, y + self.push[1] * lever

    def holds(self, x: float, y: float, more: Iterable[int] = ()) -> bool:
        """True when the feet that carry, and ``more``, can carry a load at (x, y)."""
        polygon = support_polygon(self.feet[leg] for leg in (*self.carrying, *more))
        return polygon_margin(polygon, x, y) >= -TIP_SLACK
