"""Putting a machine down on its ground, so that it neither drops nor sinks when it is let go."""

from __future__ import annotations

from walking_console.planner.geometry.transforms import Matrix, Point, point_seen
from walking_console.planner.robot.kinematics import Joints, inverse
from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import GRAVITY
from walking_console.planner.statics import centre_of_gravity, planned_loads
from walking_console.planner.types import Stance

from ..terrain.ground import Ground
from .bodies import Bodies
from .contacts import FootContacts
from .targets import pressing

ON_GROUND = 0.005  # m; a foot of the start stance this near the ground stands on it
LEVEL: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def set_down(bodies: Bodies, ground: Ground, stance: Stance, contact: FootContacts) -> list[Joints]:
    """Put a machine down in its stance and answer the joints its servos aim at.

    They aim as much too far as their legs give under the planned loads. ``contact`` is told which
    feet stand and what they carry. Raises ``ValueError`` for a foot out of reach.
    """
    machine = bodies.machine
    feet_b = [_standing(ground, stance, leg, contact) for leg in range(len(stance.feet))]
    joints = [_joints_for(machine, leg, foot) for leg, foot in enumerate(feet_b)]
    bodies.place(stance.body, joints)
    x, y, _ = centre_of_gravity(machine, feet_b)
    shares = [1.0 if sole else 0.0 for sole in contact.soles]
    loads = planned_loads(machine.mass * GRAVITY, (x, y), feet_b, shares).newtons
    contact.loads[:] = loads
    give = pressing(machine, joints, loads, LEVEL) / bodies.built.stiffness
    off = give.tolist()
    return [
        (a + off[3 * leg], b + off[3 * leg + 1], c + off[3 * leg + 2])
        for leg, (a, b, c) in enumerate(joints)
    ]


def _standing(ground: Ground, stance: Stance, leg: int, contact: FootContacts) -> Point:
    """Where a foot is in body axes: on the ground when it nearly is."""
    x, y, z = stance.feet[leg]
    height = ground.height_at(x, y)
    contact.soles[leg] = leg not in stance.lifted and abs(z - height) <= ON_GROUND
    return point_seen(stance.body, (x, y, height if contact.soles[leg] else z))


def _joints_for(machine: Machine, leg: int, foot: Point) -> Joints:
    joints = inverse(machine.chains[leg], foot)
    if joints is None:
        place = ", ".join(f"{part:.3f}" for part in foot)
        raise ValueError(f"leg {leg + 1} cannot reach ({place}) of its start stance")
    return joints
