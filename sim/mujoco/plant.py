"""The physics plant: servo speeds and loads in, ``Sensing`` out, one tick of 20 ms at a time.

A floating torso on servo-driven legs over the true ground (``model``). What it senses is what a
machine can know: joints, loads and soles of its feet, whiskers, attitude and rates of an inertial
sensor, and where its legs say it is, which drifts (``odometry``). The truth is in ``body`` and
``feet``. MuJoCo repeats to the last bit, in one process and across processes of one version.

Approximations: point feet; only feet and torso meet the ground, links pass through; a leg's drives
are alike and ideal but for their give; ground of many heights is a height field (``terrain``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from walking_console.planner.config import Tolerances
from walking_console.planner.geometry.transforms import Point
from walking_console.planner.protocols import PlantState
from walking_console.planner.robot.kinematics import Joints, inverse
from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import TIP_SLACK, polygon_margin, support_polygon
from walking_console.planner.types import Sensing, Stance

from ..sensor_noise import SensorNoise, with_noise
from ..terrain.ground import Ground
from .bodies import Bodies, Truth
from .contacts import FootContacts
from .odometry import LegOdometry
from .settings import Physics
from .start import set_down
from .targets import Targets, pressing

FALLEN_TILT = 0.6  # rad; leaning further than this is lying
TIPPING_TILT = 0.15  # rad; leaning further, with the centre of gravity outside its feet, is tipping
DROPPED = 2.0  # m below where it began; further down is lying at the bottom of a hole
DRIFT = 0.003  # of the way, that leg odometry drifts by on level ground; a third of it without slip
BURIED = 0.002  # m; a foot this deep in new ground is put on top of it


class PhysicsPlant:
    """The machine on its ground. ``body`` is x, y, z, roll, pitch, yaw; ``feet`` are foot tips,
    absolute; both are the truth.
    """

    def __init__(
        self,
        machine: Machine,
        ground: Ground,
        stance: Stance,
        *,
        noise: SensorNoise | None = None,
        rng: np.random.Generator | None = None,
        physics: Physics | None = None,
    ) -> None:
        if len(stance.feet) != len(machine.legs):
            raise ValueError(
                f"a stance for {machine.name!r} has {len(machine.legs)} feet, "
                f"got {len(stance.feet)}"
            )
        if noise is not None and rng is None:
            raise ValueError("sensor noise needs a seeded generator")
        self.machine = machine
        self.ground = ground
        self.physics = physics or Physics()
        self.tick = 0
        self.state: PlantState = "standing"
        self.contact = FootContacts(machine, ground)
        self._noise = noise
        self._rng = rng
        self._bodies = Bodies(machine, ground, self.physics)
        self._floor = stance.body[2] - DROPPED
        joints = set_down(self._bodies, ground, stance, self.contact)
        self._truth = Truth(self._bodies, stance.body[3])
        self._odometry = LegOdometry(stance.body, len(machine.legs))
        self._targets = Targets(machine, joints, self.physics.servos.lead)
        self._odometry.update(self._truth.feet_b, self.soles, 0.0, 0.0)

    # -- what is so, and what it senses

    @property
    def body(self) -> list[float]:
        """The true x, y, z, roll, pitch, yaw, m and rad; the yaw is not wrapped."""
        return self._truth.body

    @property
    def feet(self) -> list[list[float]]:
        """True foot tips, absolute, m."""
        return self._truth.feet

    @property
    def soles(self) -> list[bool]:
        """Per leg, True where the foot carries something."""
        return self.contact.soles

    @property
    def whiskers(self) -> list[int]:
        """Per leg, one bit per direction of eight in which something is felt."""
        return self.contact.whiskers

    @property
    def rims(self) -> list[int]:
        """Per leg, one bit per direction of eight in which the sole hangs over."""
        return self.contact.rims

    @property
    def slipping(self) -> list[bool]:
        """Per leg, True where a foot that carries is not where it came down."""
        return self._odometry.slipping

    @property
    def loads(self) -> list[float]:
        """Per leg, what the foot carries, N, mean of the last tick."""
        return self.contact.loads

    @property
    def joints(self) -> list[Joints]:
        """Joint coordinates of every leg, rad or m."""
        return self._truth.joints

    @property
    def tolerances(self) -> Tolerances:
        """How exactly it does what it is told: legs that give, odometry that drifts."""
        noise = self._noise or SensorNoise()
        return Tolerances(
            same_place=0.005,
            held_back=0.05,
            body_off=0.01,
            foot_off=0.03,
            law="inertia",
            position_noise=noise.position,
            posture_noise=noise.posture,
            late=noise.delay,
            drift=DRIFT,
        )

    @property
    def carrying(self) -> tuple[int, ...]:
        """Legs whose feet carry the body."""
        return tuple(leg for leg, sole in enumerate(self.soles) if sole)

    def sense(self) -> Sensing:
        """What a machine can know at this tick; the place is that of its odometry, which drifts."""
        odometry = self._odometry
        contact = self.contact
        x = odometry.x
        y = odometry.y
        z = odometry.z
        yaw = odometry.yaw
        roll = self.body[3]
        pitch = self.body[4]
        if self.physics.true_place:
            x = self.body[0]
            y = self.body[1]
            z = self.body[2]
            yaw = self.body[5]
        sensing = Sensing(
            self.tick,
            (x, y, z, roll, pitch, yaw),
            tuple(self._truth.feet_b),
            tuple(contact.soles),
            tuple(contact.whiskers),
            tuple(odometry.slipping),
            tuple(contact.rims),
            tuple(contact.loads),
            tuple(self._truth.joints),
            self._bodies.rates(),
        )
        if self._noise is None or self._rng is None:
            return sensing
        return with_noise(sensing, self._noise, self._rng)

    # -- what is done to it

    def push(self, fx: float, fy: float, ticks: int) -> None:
        """Push the torso with (fx, fy) newtons, level, at its centre of gravity, for so many
        ticks.
        """
        if not (math.isfinite(fx) and math.isfinite(fy)) or ticks < 0:
            raise ValueError(
                f"a push needs finite newtons and ticks >= 0, got {fx!r}, {fy!r}, {ticks!r}"
            )
        self._bodies.push(fx, fy, ticks)

    def replace_ground(self, ground: Ground) -> None:
        """Put other ground under the machine, which goes on in the same motion: feet whose ground
        rose are put on top of it, feet whose ground is gone fall.
        """
        self.ground = ground
        self.contact.replace_ground(ground)
        self._bodies.rebuild(ground)
        for leg, foot in enumerate(self.feet):
            deep = ground.height_at(foot[0], foot[1]) - foot[2]
            if deep > BURIED:
                self._dig_out(leg, deep)
        self._truth.read(self._bodies)

    def _dig_out(self, leg: int, deep: float) -> None:
        """Shorten a leg by what its ground has risen; a leg that cannot be lifts the body."""
        x, y, z = self._truth.feet_b[leg]
        joints = inverse(self.machine.chains[leg], (x, y, z + deep))
        if joints is None:
            self._bodies.lift(deep)
            return
        self._bodies.set_leg(leg, joints)
        self._targets.joints[leg] = joints
        self._targets.feet[leg] = (x, y, z + deep)

    def move(self, velocities: Sequence[Point], loads: Sequence[float] | None = None) -> None:
        """One tick: every foot is driven at its velocity in body axes, m/s; with ``loads``, N, its
        drives press with them too.
        """
        before = self._targets.flat
        self._targets.drive(velocities, self._truth.feet_b)
        self._run(before, loads)

    def follow(self, feet_b: Sequence[Point], loads: Sequence[float] | None = None) -> None:
        """One tick: servos go to foot places in body axes, m, as an open loop plays them."""
        before = self._targets.flat
        self._targets.follow(feet_b)
        self._run(before, loads)

    def _run(self, before: np.ndarray[Any, Any], loads: Sequence[float] | None) -> None:
        self.tick += 1
        if self.state == "fallen":
            return
        press = np.zeros(len(before))
        if loads is not None:
            press = pressing(self.machine, self._truth.joints, loads, self._truth.attitude)
        self.contact.take_loads(self._bodies.run(before, self._targets.flat, press))
        self._truth.read(self._bodies)
        self.contact.feel(self.feet, self.body, self._bodies.side_contacts())
        self._odometry.update(self._truth.feet_b, self.soles, self.body[3], self.body[4])
        self.state = self._state()

    def _state(self) -> PlantState:
        upright = self._truth.attitude[2][2]
        if upright < math.cos(FALLEN_TILT) or self.body[2] < self._floor:
            return "fallen"
        if self._bodies.torso_touches:
            return "fallen"
        if upright > math.cos(TIPPING_TILT):
            return "standing"
        x, y, _ = self._bodies.centre_of_gravity()
        polygon = support_polygon(self.feet[leg] for leg in self.carrying)
        return "tipping" if polygon_margin(polygon, x, y) < -TIP_SLACK else "standing"

    # -- stopping and going on

    def checkpoint(self) -> dict[str, Any]:
        """Everything needed to go on bit by bit, as plain data; ``restore`` takes it."""
        return {
            "tick": self.tick,
            "state": self.state,
            "mujoco": self._bodies.state().tolist(),
            "yaw": self.body[5],
            "push_ticks": self._bodies.push_ticks,
            "target_feet": [list(foot) for foot in self._targets.feet],
            "target_joints": [list(joints) for joints in self._targets.joints],
            "contact": self.contact.state(),
            "odometry": self._odometry.state(),
            "noise": None if self._rng is None else self._rng.bit_generator.state,
        }

    def restore(self, saved: dict[str, Any]) -> None:
        """Go on from a ``checkpoint`` of a plant like this one, on the same ground."""
        self.tick = saved["tick"]
        self.state = saved["state"]
        self._bodies.restore(np.array(saved["mujoco"]))
        self._bodies.push_ticks = saved["push_ticks"]
        self._targets.feet = [(x, y, z) for x, y, z in saved["target_feet"]]
        self._targets.joints = [(a, b, c) for a, b, c in saved["target_joints"]]
        self.contact.restore(saved["contact"])
        self._odometry.restore(saved["odometry"])
        if self._rng is not None:
            self._rng.bit_generator.state = saved["noise"]
        self._truth = Truth(self._bodies, saved["yaw"])
