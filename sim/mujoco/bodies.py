"""The machine's bodies in motion: what stands between the plant's words and MuJoCo's arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.geometry.transforms import (
    Matrix,
    Point,
    direction,
    left_fold_sum,
    turned_by,
)
from walking_console.planner.robot.kinematics import Joints, forward
from walking_console.planner.robot.model import Machine
from walking_console.planner.types import TICK

from ..terrain.ground import Ground
from .library import mujoco
from .model import Built, build
from .near_ground import SHARE, NearGround, lay, shares
from .settings import Physics
from .terrain import fill_field, holds_field

_Floats = NDArray[np.float64]

FREE_PLACES = 7  # of the torso in qpos: x, y, z and a quaternion
FREE_SPEEDS = 6


class Bodies:
    """Torso and legs as MuJoCo moves them. ``stiffness`` and ``damping`` are the servos', (3n,)."""

    def __init__(self, machine: Machine, ground: Ground, physics: Physics) -> None:
        self.machine = machine
        self.physics = physics
        self._put_on(ground)
        self._compile(SHARE)
        self.steps = round(TICK / physics.step)
        self.push_ticks = 0
        if abs(self.steps * physics.step - TICK) > 1e-12:
            raise ValueError(f"a tick of {TICK:g} s must be whole steps, got {physics.step!r}")

    def _put_on(self, ground: Ground) -> None:
        """This ground from now on; its boxes are still to be laid."""
        self.ground = ground
        self.near = None
        if not ground.relief:
            reach = math.hypot(*self.machine.torso) / 2
            self.near = NearGround(ground, self.physics.tip, reach)
        self._laid: list[int] | None = None

    def _compile(self, pool: int) -> None:
        self.built: Built = build(self.machine, self.ground, self.physics, pool)
        self.data: Any = mujoco.MjData(self.built.model)
        self._feet = list(self.built.feet)

    def _bring_ground(self) -> None:
        """Lay the boxes that are near feet and torso where they are now."""
        near = self.near
        if near is None:
            return
        mujoco.mj_kinematics(self.built.model, self.data)
        feet = self.data.geom_xpos[self._feet].tolist()
        numbers = near.numbers(feet, self._under_torso())
        if numbers == self._laid:
            return
        if len(numbers) > self.built.pool:
            state = self.state()
            self._compile(shares(len(numbers)))
            self._set(state)
            mujoco.mj_kinematics(self.built.model, self.data)
        lay(self.built.model, self.built.pool, near, numbers)
        self._laid = numbers

    def _under_torso(self) -> Point:
        """The middle of the torso seen from above, and its lowest point, m."""
        x, y, z = self.place_of_torso()
        down = self.attitude()[2]
        sides = zip(down, self.machine.torso, strict=True)
        return x, y, z - left_fold_sum(abs(share) * side for share, side in sides) / 2

    def place(self, body: Sequence[float], joints: Sequence[Joints]) -> None:
        """Put the machine at x, y, z, yaw with these joints, at rest."""
        x, y, z, yaw = body
        c, s = direction(yaw / 2)
        self.data.qpos[:FREE_PLACES] = (x, y, z, c, 0.0, 0.0, s)
        self.data.qpos[FREE_PLACES:] = [value for leg in joints for value in leg]
        self.data.qvel[:] = 0.0
        self._bring_ground()
        mujoco.mj_forward(self.built.model, self.data)

    def set_leg(self, leg: int, joints: Joints) -> None:
        """Put one leg somewhere else, at rest."""
        at = FREE_PLACES + 3 * leg
        self.data.qpos[at : at + 3] = joints
        at = FREE_SPEEDS + 3 * leg
        self.data.qvel[at : at + 3] = 0.0

    def lift(self, height: float) -> None:
        """Put the whole machine higher, m."""
        self.data.qpos[2] += height

    def rebuild(self, ground: Ground) -> None:
        """Other ground, the same machine in the same motion."""
        state = self.state()
        kept = self.near is not None and not ground.relief  # boxes are only laid elsewhere
        self._put_on(ground)
        if holds_field(self.built.model, ground):
            fill_field(self.built.model, ground)
            mujoco.mj_resetData(self.built.model, self.data)
        elif not kept:
            self._compile(SHARE)
        self.restore(state)

    def state(self) -> _Floats:
        """Everything MuJoCo needs to go on bit by bit: time, places, speeds, warm start, forces."""
        kind = mujoco.mjtState.mjSTATE_INTEGRATION
        state = np.empty(mujoco.mj_stateSize(self.built.model, kind))
        mujoco.mj_getState(self.built.model, self.data, state, kind)
        return state

    def restore(self, state: _Floats) -> None:
        """Go on from a ``state``."""
        size = mujoco.mj_stateSize(self.built.model, mujoco.mjtState.mjSTATE_INTEGRATION)
        if len(state) != size:
            raise ValueError(f"a state of this machine has {size} numbers, got {len(state)}")
        self._set(state)
        self._bring_ground()
        mujoco.mj_forward(self.built.model, self.data)

    def _set(self, state: _Floats) -> None:
        kind = mujoco.mjtState.mjSTATE_INTEGRATION
        mujoco.mj_setState(self.built.model, self.data, np.asarray(state, np.float64), kind)

    def push(self, fx: float, fy: float, ticks: int) -> None:
        """A horizontal force on the torso, N, for so many ticks."""
        self.data.xfrc_applied[self.built.torso, :2] = (fx, fy) if ticks else (0.0, 0.0)
        self.push_ticks = ticks

    def run(self, start: _Floats, end: _Floats, pressing: _Floats) -> list[float]:
        """One tick: the servos' targets go evenly from ``start`` to ``end`` while the drives press
        with ``pressing`` on top, all (3n,). Answers each foot's mean load, N.
        """
        self._bring_ground()
        built = self.built
        data = self.data
        step = mujoco.mj_step
        model = built.model
        ahead = (built.damping * (end - start) / TICK + pressing) / built.stiffness
        share = (end - start) / self.steps
        target = start + ahead
        total = np.zeros(len(self.machine.legs))
        for _ in range(self.steps):
            target += share
            data.ctrl[:] = target
            step(model, data)
            total += data.sensordata
        if self.push_ticks:
            self.push_ticks -= 1
            if not self.push_ticks:
                data.xfrc_applied[built.torso, :2] = 0.0
        loads: list[float] = (total / self.steps).tolist()
        for leg, upright in self._upright_shares().items():
            loads[leg] *= upright
        return loads

    def _upright_shares(self) -> dict[int, float]:
        """Of what presses on each foot that touches, how much holds it up: a soles' sensors add up
        what presses, also against a riser.
        """
        data = self.data
        count = self.data.ncon
        if count == 0:
            return {}
        contact = data.contact
        forces = data.efc_force
        pressing: dict[int, float] = {}
        lifting: dict[int, float] = {}
        rows = contact.frame[:count].tolist()
        places = contact.efc_address[:count].tolist()
        for pair, frame, at in zip(contact.geom[:count].tolist(), rows, places, strict=True):
            leg = self.built.feet.get(pair[1], self.built.feet.get(pair[0]))
            if leg is None or at < 0:
                continue
            normal, first, second = forces[at : at + 3].tolist()
            up = normal * frame[2] + first * frame[5] + second * frame[8]
            pressing[leg] = pressing.get(leg, 0.0) + normal
            lifting[leg] = lifting.get(leg, 0.0) + (up if pair[1] in self.built.feet else -up)
        return {
            leg: max(0.0, min(1.5, lifting[leg] / press))
            for leg, press in pressing.items()
            if press > 0.0
        }

    # -- what is so

    def place_of_torso(self) -> Point:
        """x, y, z of the body's origin, m."""
        x, y, z = self.data.qpos[:3].tolist()
        return x, y, z

    def attitude(self) -> Matrix:
        """Body axes to absolute axes."""
        w, x, y, z = self.data.qpos[3:7].tolist()
        return (
            (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
        )

    def rates(self) -> Point:
        """Turning of the torso about its own x, y, z, rad/s: what a gyroscope says."""
        x, y, z = self.data.qvel[3:6].tolist()
        return x, y, z

    def velocity(self) -> Point:
        """Of the torso's origin, absolute axes, m/s."""
        x, y, z = self.data.qvel[:3].tolist()
        return x, y, z

    def joints(self) -> list[Joints]:
        """Joint coordinates of every leg, rad or m."""
        values = self.data.qpos[FREE_PLACES:].tolist()
        return [(values[k], values[k + 1], values[k + 2]) for k in range(0, len(values), 3)]

    def centre_of_gravity(self) -> Point:
        """Of everything, absolute, m."""
        x, y, z = self.data.subtree_com[self.built.torso].tolist()
        return x, y, z

    def drive_forces(self) -> list[float]:
        """What every drive gives, N or N·m, (3n,)."""
        forces: list[float] = self.data.actuator_force.tolist()
        return forces

    @property
    def torso_touches(self) -> bool:
        """True when the torso is on the ground or against something."""
        count = self.data.ncon
        if count == 0:
            return False
        return bool((self.data.contact.geom[:count] == self.built.torso_shape).any())

    def side_contacts(self) -> list[tuple[int, float, float]]:
        """Leg, and the way it was going (x, y), of every foot that meets something upright."""
        data = self.data
        found = []
        count = data.ncon
        if count == 0:
            return []
        normals = data.contact.frame[:count, :3]
        for k in np.nonzero(np.abs(normals[:, 2]) < 0.5)[0].tolist():
            pair = data.contact.geom[k].tolist()
            for side, shape in enumerate(pair):
                if shape in self.built.feet:
                    sign = -1.0 if side else 1.0  # the normal points from the first to the second
                    x, y = normals[k, :2].tolist()
                    found.append((self.built.feet[shape], sign * x, sign * y))
        return found


class Truth:
    """Where body, joints and feet truly are, read once a tick. ``body`` is x, y, z, roll, pitch,
    yaw; ``feet`` are absolute, ``feet_b`` in body axes, m.
    """

    def __init__(self, bodies: Bodies, yaw: float) -> None:
        self.body = [0.0, 0.0, 0.0, 0.0, 0.0, yaw]
        self.read(bodies)

    def read(self, bodies: Bodies) -> None:
        """Take it out of MuJoCo's arrays; the yaw goes on from the last one."""
        x, y, z = bodies.place_of_torso()
        self.attitude = bodies.attitude()
        self.body = [x, y, z, *roll_pitch_yaw(self.attitude, self.body[5])]
        self.joints = bodies.joints()
        chains = bodies.machine.chains
        self.feet_b = [forward(*leg) for leg in zip(chains, self.joints, strict=True)]
        self.feet: list[list[float]] = []
        for foot in self.feet_b:
            ax, ay, az = turned_by(self.attitude, foot)
            self.feet.append([x + ax, y + ay, z + az])


def roll_pitch_yaw(attitude: Matrix, near: float) -> Point:
    """Angles of an attitude, rad; the yaw is the one nearest to ``near``."""
    roll = math.atan2(attitude[2][1], attitude[2][2])
    pitch = math.asin(max(-1.0, min(1.0, -attitude[2][0])))
    yaw = math.atan2(attitude[1][0], attitude[0][0])
    return roll, pitch, yaw + 2.0 * math.pi * round((near - yaw) / (2.0 * math.pi))
