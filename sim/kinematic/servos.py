"""The servos: how far each foot goes in a tick of what it is asked to."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from walking_console.planner.robot.model import Machine
from walking_console.planner.types import TICK, Point

from .configuration import FootMotion

# x_min, x_max, y_min, y_max, z_min, z_max of a foot tip in body axes, m
MechanicalReach = tuple[float, float, float, float, float, float]


NONE: FootMotion = (0.0, 0.0, 0.0)


class Servos:
    """Every leg's drives: they follow their speed exactly up to the machine's limits."""

    def __init__(self, machine: Machine) -> None:
        self.stride = tuple(limit * TICK for limit in machine.speed)  # m a tick, x, y, z
        self.reach = tuple(mechanical_reach(machine, leg) for leg in range(len(machine.legs)))

    def motions(
        self, velocities: Sequence[Point], tips: Sequence[Sequence[float]]
    ) -> list[FootMotion]:
        """How far each foot goes this tick in body axes, m: what is asked (m/s), held to speed
        limits and reach. NaN does not move.
        """
        sx, sy, sz = self.stride
        motions: list[FootMotion] = []
        before: Point | None = None
        motion = NONE
        for velocity, (px, py, pz), (x0, x1, y0, y1, z0, z1) in zip(
            velocities, tips, self.reach, strict=True
        ):
            if velocity is not before:  # carrying legs are all given one
                before = velocity
                vx, vy, vz = velocity
                dx = vx * TICK
                dy = vy * TICK
                dz = vz * TICK
                if not -sx <= dx <= sx:
                    dx = _limited(dx, sx)
                if not -sy <= dy <= sy:
                    dy = _limited(dy, sy)
                if not -sz <= dz <= sz:
                    dz = _limited(dz, sz)
                motion = dx, dy, dz
            if x0 <= px + dx <= x1 and y0 <= py + dy <= y1 and z0 <= pz + dz <= z1:
                motions.append(motion)
            else:
                at = (px, dx, x0, x1), (py, dy, y0, y1), (pz, dz, z0, z1)
                motions.append(_within(at))
        return motions


def mechanical_reach(machine: Machine, leg: int) -> MechanicalReach:
    """The reach of a leg's mechanism: its control box widened by δ."""
    (dx, dy, dz) = machine.overreach
    box = machine.legs[leg]
    return box.x[0] - dx, box.x[1] + dx, box.y[0] - dy, box.y[1] + dy, box.z[0] - dz, box.z[1] + dz


def _limited(motion: float, most: float) -> float:
    """A motion that is too fast, or none, at its limit; NaN is none."""
    if motion > most:
        return most
    return -most if motion < -most else 0.0


def _within(ways: Iterable[tuple[float, float, float, float]]) -> FootMotion:
    """As much of a motion as the reach allows: along each axis where the foot is, how far it is to
    go, and the reach.
    """
    x, y, z = (way[1] if way[2] <= way[0] + way[1] <= way[3] else _into(*way) for way in ways)
    return x, y, z


def _into(position: float, motion: float, low: float, high: float) -> float:
    """As much of a motion as the reach allows; outside it, only back towards it."""
    if position + motion > high:
        return min(motion, max(0.0, high - position)) if motion > 0.0 else motion
    return max(motion, min(0.0, low - position)) if motion < 0.0 else motion
