"""What a leg is made of: three joints in a row, how far, how fast and how strongly each moves.

Every kind is the same chain of three joints. The leg's own axes stand at its hip: x the way the leg
faces, y to the left of that, z up. Joint i turns about, or slides along, its axis; then the chain
goes on by its offset, to the next joint or to the foot tip. Joint coordinates are radians (turns)
or metres (slides); zero is the posture in which the offsets are written.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from ..geometry.transforms import Point, direction

JointSpan = tuple[float, float]

JOINTS = 3
UP: Point = (0.0, 0.0, 1.0)
ALONG: Point = (1.0, 0.0, 0.0)
LEFT: Point = (0.0, 1.0, 0.0)
RIGHT: Point = (0.0, -1.0, 0.0)
NOWHERE: Point = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Joint:
    """One joint and the link behind it, in the leg's own axes.

    ``limits`` low and high, rad or m; ``speed`` rad/s or m/s; ``torque`` N·m or N, the most its
    drive gives.
    """

    axis: Point  # unit vector
    offset: Point  # m, to the next joint or the foot tip
    slides: bool
    limits: JointSpan
    speed: float
    torque: float


@dataclass(frozen=True)
class LegChain:
    """A leg: where its hip is, which way it faces, and its three joints.

    ``kind`` says which formula solves it: ``slides`` (x, y, z in series, as TITAN III's ball
    screws), ``insect`` (yaw, pitch, pitch), ``mammal`` (roll, pitch, pitch), ``serial`` (any).
    ``links`` are the lengths l1, l2, l3 of insect and mammal, m; empty for the others.
    """

    kind: str
    hip: Point  # m, body axes
    facing: float  # rad, the leg's x against the body's
    joints: tuple[Joint, Joint, Joint]
    links: tuple[float, ...] = ()

    @cached_property
    def turn(self) -> tuple[float, float]:
        """Cosine and sine of ``facing``."""
        return direction(self.facing)

    @cached_property
    def limits(self) -> tuple[JointSpan, JointSpan, JointSpan]:
        """Low and high of each joint, rad or m."""
        a, b, c = self.joints
        return a.limits, b.limits, c.limits

    @cached_property
    def reach(self) -> float:
        """A length no foot is further from its hip than, m."""
        far = 0.0
        for joint in self.joints:
            far += math.hypot(*joint.offset)
            if joint.slides:
                far += max(abs(joint.limits[0]), abs(joint.limits[1]))
        return far


@dataclass(frozen=True, slots=True)
class Masses:
    """Where the mass is: the torso's about ``centre`` (body axes, m), and three links in every leg.

    The body's origin is where the planners take the centre of gravity to be; ``centre`` says how
    far off the middle the torso's own is. A turning joint's link has its mass in the middle of its
    offset, a sliding joint's at the end of it.
    """

    torso: float  # kg
    links: Point  # kg
    centre: Point = NOWHERE

    @property
    def leg(self) -> float:
        """One whole leg, kg."""
        return self.links[0] + self.links[1] + self.links[2]


@dataclass(frozen=True, slots=True)
class Drives:
    """What moves a leg's three joints: limits (rad or m), speeds (rad/s or m/s), torques (N·m or
    N).
    """

    limits: tuple[JointSpan, JointSpan, JointSpan]
    speed: Point
    torque: Point


def chain_of(
    kind: str,
    hip: Point,
    facing: float,
    axes: Sequence[tuple[Point, Point, bool]],
    drives: Drives,
    links: tuple[float, ...] = (),
) -> LegChain:
    """A chain from (axis, offset, slides) of each joint and its drives."""
    a, b, c = (
        Joint(axis, offset, slides, drives.limits[i], drives.speed[i], drives.torque[i])
        for i, (axis, offset, slides) in enumerate(axes)
    )
    return LegChain(kind, hip, facing, (a, b, c), links)


def slides_chain(hip: Point, facing: float, drives: Drives) -> LegChain:
    """Three slides in series: the joint coordinates are the foot tip as the hip sees it."""
    axes = [(axis, NOWHERE, True) for axis in (ALONG, LEFT, UP)]
    return chain_of("slides", hip, facing, axes, drives)


def insect_chain(hip: Point, facing: float, links: Point, drives: Drives) -> LegChain:
    """Yaw at the hip, then two pitches: zero is straight out, a positive pitch raises the leg."""
    l1, l2, l3 = links
    axes = [
        (UP, (l1, 0.0, 0.0), False),
        (RIGHT, (l2, 0.0, 0.0), False),
        (RIGHT, (l3, 0.0, 0.0), False),
    ]
    return chain_of("insect", hip, facing, axes, drives, links)


def mammal_chain(hip: Point, facing: float, links: Point, drives: Drives) -> LegChain:
    """Roll at the hip, then two pitches: zero is straight down, a positive pitch swings it back.

    The upper leg hangs l1 further out than the hip: to the left of a hip that is left of the
    middle, to the right of any other.
    """
    l1, l2, l3 = links
    c, s = direction(facing)
    side = 1.0 if c * hip[1] - s * hip[0] > 0.0 else -1.0
    axes = [
        (ALONG, (0.0, side * l1, 0.0), False),
        (LEFT, (0.0, 0.0, -l2), False),
        (LEFT, (0.0, 0.0, -l3), False),
    ]
    return chain_of("mammal", hip, facing, axes, drives, links)
