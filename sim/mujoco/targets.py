"""Where the servos are to be: foot targets in body axes, and the joints that put feet there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.geometry.transforms import Matrix, Point, turned_back_by
from walking_console.planner.robot.chains import LegChain
from walking_console.planner.robot.kinematics import (
    Joints,
    forward,
    holding_torques,
    inverse,
    joint_torques,
)
from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import GRAVITY
from walking_console.planner.types import TICK

_Floats = NDArray[np.float64]


class Targets:
    """Foot targets in body axes, m, and their joints; each moves by what it is told and no faster
    than the machine can.
    """

    def __init__(self, machine: Machine, joints: Sequence[Joints], lead: float) -> None:
        self.machine = machine
        self.lead = lead
        self.joints: list[Joints] = list(joints)
        self.feet: list[Point] = [
            forward(chain, values) for chain, values in zip(machine.chains, joints, strict=True)
        ]
        self._reach = tuple(_mechanical(machine, leg) for leg in range(len(machine.legs)))

    def drive(self, velocities: Sequence[Point], feet_b: Sequence[Point]) -> None:
        """One tick at foot velocities in body axes, m/s, held to speed limits, to reach, and to
        ``lead`` ahead of where the feet are; NaN does not move.
        """
        for leg, (velocity, foot) in enumerate(zip(velocities, feet_b, strict=True)):
            self._aim(leg, self._step(leg, velocity, foot))

    def follow(self, feet_b: Sequence[Point]) -> None:
        """One tick to foot places in body axes, m, whatever the speed; those out of reach stay."""
        for leg, foot in enumerate(feet_b):
            self._aim(leg, foot)

    def _step(self, leg: int, velocity: Point, foot: Point) -> Point:
        now = self.feet[leg]
        reach = self._reach[leg]
        limits = self.machine.speed
        x, y, z = (
            _stepped(
                now[k], velocity[k], limits[k], (foot[k] - self.lead, foot[k] + self.lead), reach[k]
            )
            for k in range(3)
        )
        return x, y, z

    def _aim(self, leg: int, foot: Point) -> None:
        """Take a foot target as far as joints can follow it, at their speeds."""
        chain = self.machine.chains[leg]
        joints = inverse(chain, foot)
        if joints is None:
            return
        share = _share_in_a_tick(chain, self.joints[leg], joints)
        if share < 1.0:
            a, b, c = (
                old + share * (new - old) for old, new in zip(self.joints[leg], joints, strict=True)
            )
            joints = (a, b, c)
            foot = forward(chain, joints)
        self.joints[leg] = joints
        self.feet[leg] = foot

    @property
    def flat(self) -> _Floats:
        """Joint targets of all legs in a row, (3n,)."""
        return np.array([value for joints in self.joints for value in joints])


def pressing(
    machine: Machine, joints: Sequence[Joints], loads: Sequence[float], attitude: Matrix
) -> _Floats:
    """What the drives give, (3n,), for every foot to press straight down with its load, N, and
    for every leg to hold itself up.
    """
    down = turned_back_by(attitude, (0.0, 0.0, -1.0))
    gravity = (GRAVITY * down[0], GRAVITY * down[1], GRAVITY * down[2])
    forces: list[float] = []
    for chain, values, load in zip(machine.chains, joints, loads, strict=True):
        push = joint_torques(chain, values, (load * down[0], load * down[1], load * down[2]))
        hold = holding_torques(chain, machine.masses, values, gravity)
        forces += [a + b for a, b in zip(push, hold, strict=True)]
    return np.array(forces)


def _stepped(
    now: float, speed: float, limit: float, near: tuple[float, float], reach: tuple[float, float]
) -> float:
    """One coordinate of a target after a tick: within its speed, near its foot, within reach."""
    if speed != speed:
        return now
    there = now + min(max(speed, -limit), limit) * TICK
    for low, high in (near, reach):
        # outside already: only back towards it
        there = min(max(there, min(low, now)), max(high, now))
    return there


def _share_in_a_tick(chain: LegChain, old: Joints, new: Joints) -> float:
    """How much of a joint motion its speeds allow in a tick, at most 1."""
    share = 1.0
    for joint, a, b in zip(chain.joints, old, new, strict=True):
        far = abs(b - a)
        if far > joint.speed * TICK:
            share = min(share, joint.speed * TICK / far)
    return share


def _mechanical(
    machine: Machine, leg: int
) -> tuple[tuple[float, float], tuple[float, float], tuple[float, float]]:
    """The reach of a leg's mechanism: its control box widened by δ."""
    dx, dy, dz = machine.overreach
    box = machine.legs[leg]
    return (
        (box.x[0] - dx, box.x[1] + dx),
        (box.y[0] - dy, box.y[1] + dy),
        (box.z[0] - dz, box.z[1] + dz),
    )
