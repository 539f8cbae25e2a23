"""The machine as MuJoCo's bodies: a floating torso, every leg its chain of joints, point feet."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.geometry.transforms import Point, direction, left_fold_sum
from walking_console.planner.robot.chains import LegChain
from walking_console.planner.robot.kinematics import Joints, inverse, jacobian
from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import GRAVITY

from ..terrain.ground import Ground
from .library import mujoco
from .settings import Physics
from .terrain import GROUND, add_ground, fill_field

_Floats = NDArray[np.float64]

INERTIA_MIN = 1e-6  # kg m² of a link: thinner, see the solver refuse it
# friction against normal stiffness of a contact. Less: see feet that hold creep down a slope
GRIP = 10.0
MASS_MIN = 1e-4  # kg of a link
MACHINE = 1  # contact bit of torso and feet: they meet the ground, not each other


@dataclass(frozen=True)
class LegDrive:
    """A leg's three servos: stiffness and damping (N/m and Ns/m, or N·m/rad and N·m·s/rad)."""

    stiffness: Point
    damping: Point
    inertia: Point  # reflected, kg or kg m²


@dataclass(frozen=True)
class Built:
    """A compiled model and where in its arrays the machine is."""

    model: Any
    torso: int  # body
    torso_shape: int  # geom
    feet: dict[int, int]  # geom of each foot: its leg
    stiffness: _Floats  # (3n,)
    damping: _Floats
    pool: int  # shapes that become boxes of the ground; they are the first


def build(machine: Machine, ground: Ground, physics: Physics, pool: int = 0) -> Built:
    """The model of a machine on its ground, which is a ``pool`` of shapes where it is no relief."""
    spec = mujoco.MjSpec()
    _set_options(spec, physics)
    friction = machine.friction if physics.friction is None else physics.friction
    surface = {
        "friction": [friction, 0.0, 0.0],
        "condim": 3,
        "solref": [physics.contact_time, 1.0],
    }
    add_ground(spec, ground, pool, {**surface, "contype": GROUND, "conaffinity": 0})
    touching = {**surface, "contype": 0, "conaffinity": MACHINE, "mass": 0.0}
    drives = [leg_drive(machine, leg, physics) for leg in range(len(machine.legs))]
    torso = _add_torso(spec, machine, physics, touching)
    for leg, chain in enumerate(machine.chains):
        _add_leg(spec, torso, machine, physics, leg, chain, drives[leg], touching)
    model = spec.compile()
    if ground.relief:
        fill_field(model, ground)
    return Built(
        model,
        model.body("torso").id,
        model.geom("torso").id,
        {model.geom(f"foot {leg}").id: leg for leg in range(len(drives))},
        np.array([part for drive in drives for part in drive.stiffness]),
        np.array([part for drive in drives for part in drive.damping]),
        0 if ground.relief else pool,
    )


def leg_drive(machine: Machine, leg: int, physics: Physics) -> LegDrive:
    """The servos of a leg, so stiff that its foot gives by ``sag`` under its share of the weight.

    Joint j holds |J_j|² of the foot's stiffness, J_j its column of the Jacobian in the standard
    posture; all are scaled to make the foot's give exact there.
    """
    servos = physics.servos
    chain = machine.chains[leg]
    share = machine.mass / len(machine.legs)
    stiff = share * GRAVITY / servos.sag
    rows = jacobian(chain, standard_joints(machine, leg))
    squares = [left_fold_sum(row[j] * row[j] for row in rows) for j in range(3)]
    squares = [max(square, 1e-9) for square in squares]
    scale = left_fold_sum(rows[2][j] * rows[2][j] / squares[j] for j in range(3))
    a, b, c = (scale * stiff * square for square in squares)
    lag = 2.0 * servos.damping * math.sqrt(share / stiff)
    leg_mass = machine.masses.leg * servos.reflected
    i, j, k = (leg_mass * square for square in squares)
    return LegDrive((a, b, c), (lag * a, lag * b, lag * c), (i, j, k))


def standard_joints(machine: Machine, leg: int) -> Joints:
    """The joints of a leg whose foot is in the middle of its reach, at the machine's height."""
    joints = inverse(machine.chains[leg], (*machine.legs[leg].centre, -machine.height))
    if joints is not None:
        return joints
    a, b, c = ((low + high) / 2.0 for low, high in machine.chains[leg].limits)
    return a, b, c


def _set_options(spec: Any, physics: Physics) -> None:
    option = spec.option
    option.timestep = physics.step
    option.gravity = [0.0, 0.0, -GRAVITY]
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = GRIP
    spec.compiler.degree = False
    spec.compiler.autolimits = True


def _add_torso(spec: Any, machine: Machine, physics: Physics, touching: dict[str, Any]) -> Any:
    length, width, height = machine.torso
    masses = machine.masses
    mass = masses.torso * physics.mass_factor
    torso = spec.worldbody.add_body(name="torso")
    torso.add_freejoint(name="free")
    torso.explicitinertial = True
    torso.mass = mass
    torso.ipos = [c + off for c, off in zip(masses.centre, physics.centre_off, strict=True)]
    torso.inertia = [
        mass * (width**2 + height**2) / 12.0,
        mass * (length**2 + height**2) / 12.0,
        mass * (length**2 + width**2) / 12.0,
    ]
    torso.add_geom(
        name="torso",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[length / 2, width / 2, height / 2],
        **touching,
    )
    return torso


def _add_leg(
    spec: Any,
    torso: Any,
    machine: Machine,
    physics: Physics,
    leg: int,
    chain: LegChain,
    drive: LegDrive,
    touching: dict[str, Any],
) -> None:
    """A leg's chain of bodies; joints whose link has neither mass nor length share one body."""
    c, s = direction(chain.facing / 2)
    link = torso.add_body(name=f"leg {leg}", pos=list(chain.hip), quat=[c, 0.0, 0.0, s])
    count = len(chain.joints)
    for k, joint in enumerate(chain.joints):
        kind = mujoco.mjtJoint.mjJNT_SLIDE if joint.slides else mujoco.mjtJoint.mjJNT_HINGE
        link.add_joint(
            name=f"leg {leg} joint {k}",
            type=kind,
            axis=list(joint.axis),
            armature=drive.inertia[k],
        )
        _add_servo(spec, f"leg {leg} joint {k}", drive, k, physics, joint.torque)
        mass = machine.masses.links[k] * physics.mass_factor
        bare = mass == 0.0 and joint.offset == (0.0, 0.0, 0.0)
        if bare and k < count - 1:
            continue
        _give_mass(link, mass, joint.offset, joint.slides)
        if k < count - 1:
            link = link.add_body(name=f"leg {leg} link {k + 1}", pos=list(joint.offset))
    _add_foot(spec, link, leg, (chain.joints[-1].offset, physics.tip), touching)


def _give_mass(link: Any, mass: float, offset: Point, slides: bool) -> None:
    """A link's mass: in the middle of a turning link's offset, at the end of a sliding one's."""
    length = math.hypot(*offset)
    share = 1.0 if slides else 0.5
    mass = max(mass, MASS_MIN)
    spread = max(mass * length * length / 12.0, INERTIA_MIN)
    link.explicitinertial = True
    link.mass = mass
    link.ipos = [share * part for part in offset]
    link.inertia = [spread, spread, spread]


def _add_servo(
    spec: Any, joint: str, drive: LegDrive, k: int, physics: Physics, torque: float
) -> None:
    stiff = drive.stiffness[k]
    damped = drive.damping[k]
    actuator = spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    actuator.gaintype = mujoco.mjtGain.mjGAIN_FIXED
    actuator.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    actuator.gainprm[0] = stiff
    actuator.biasprm[1] = -stiff
    actuator.biasprm[2] = -damped
    if physics.servos.limited:
        actuator.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
        actuator.forcerange = [-torque, torque]


def _add_foot(
    spec: Any, link: Any, leg: int, tip: tuple[Point, float], touching: dict[str, Any]
) -> None:
    """A small ball whose lowest point is the foot tip, and what measures its load."""
    offset, radius = tip
    length = math.hypot(*offset)
    back = (0.0, 0.0, radius)
    if length > 0.0:
        x, y, z = (-radius * part / length for part in offset)
        back = (x, y, z)
    middle = [part + way for part, way in zip(offset, back, strict=True)]
    ball = mujoco.mjtGeom.mjGEOM_SPHERE
    link.add_geom(name=f"foot {leg}", type=ball, size=[radius, 0.0, 0.0], pos=middle, **touching)
    link.add_site(name=f"sole {leg}", type=ball, size=[2.0 * radius, 0.0, 0.0], pos=middle)
    spec.add_sensor(
        name=f"sole {leg}",
        type=mujoco.mjtSensor.mjSENS_TOUCH,
        objtype=mujoco.mjtObj.mjOBJ_SITE,
        objname=f"sole {leg}",
    )
