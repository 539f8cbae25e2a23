"""The ground plane as pymunk sees it: poles, blocks and steps as shapes; what whiskers and sweeps
meet; sliding feet.

Seen from above, each obstacle is a shape with a top. pymunk is asked only within the bounds of one
that is tall enough (``nearby``), and stepped only while something is loaded. Shapes and bodies are
inserted in a fixed order, a slide in a space of its own, so runs repeat to the last bit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import pymunk

from walking_console.planner.geometry.transforms import direction, left_fold_sum, placed
from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import GRAVITY

from ..terrain.generators import Obstacle
from .nearby import ASK, Nearby
from .rest_pose import centroid

# m beyond the rim of the foot: an estimate; longer, see feet shy away from what they could pass
WHISKER = 0.05
WHISKERS = 8
OVER = 0.005  # m; a foot this little below an obstacle's top is on it, not beside it
SUBSTEPS = 4  # of a tick while sliding
STILL = 1e-5  # m/s; a slide slower than this has stopped
ITERATIONS = 200  # of pymunk's solver; fewer, see a machine pushed off its centre of support creep

ANY = pymunk.ShapeFilter()


class SweepHit(NamedTuple):
    """Where a way through the ground plane first meets something: share of the way, and the
    surface's outward normal.
    """

    share: float
    normal: tuple[float, float]


class Slip(NamedTuple):
    """What one tick of sliding did to the machine, about its centre of gravity: m, m, rad."""

    dx: float
    dy: float
    turn: float


class ContactWorld:
    """All obstacles of one ground, and the machine's shape among them."""

    def __init__(self, obstacles: Sequence[Obstacle], machine: Machine) -> None:
        self.obstacles = tuple(obstacles)
        self.machine = machine
        self._space = pymunk.Space()
        self._tops: dict[pymunk.Shape, float] = {}
        for obstacle in self.obstacles:
            shape = _shape(self._space.static_body, obstacle)
            self._space.add(shape)
            self._tops[shape] = obstacle.top
        self.whisker = machine.foot_radius + WHISKER
        self._near_foot = Nearby(self.obstacles, self.whisker)
        self._near_body = Nearby(self.obstacles, _extent(machine))
        self._torso_reach = math.hypot(machine.torso[0], machine.torso[1]) / 2
        self._hips = machine.hips
        self._slide: _Slide | None = None

    def near(self, x: float, y: float) -> bool:
        """True when a foot at (x, y) may be within a whisker of something."""
        return self._near_foot.any(x, y)

    def crowds(self, x: float, y: float) -> bool:
        """True when the torso or a leg of a body at (x, y) may be at something."""
        return self._near_body.any(x, y)

    def sweep(self, ax: float, ay: float, bx: float, by: float, z: float) -> SweepHit | None:
        """The first thing standing higher than z on the straight way from a to b, None when it is
        free.
        """
        begin = ax, ay
        end = bx, by
        if not self._near_foot.on_the_way(begin, begin, end, z):
            return None
        hits = [
            hit
            for hit in self._space.segment_query(begin, end, 0.0, ANY)
            if self._tops_of(hit.shape) > z
        ]
        if not hits:
            return None
        first = min(hits, key=lambda hit: hit.alpha)
        return SweepHit(first.alpha, (first.normal.x, first.normal.y))

    def feel(self, x: float, y: float, z: float, yaw: float) -> int:
        """Contact mode of a foot's whiskers: one bit per direction of eight, bit 0 along body +x,
        counter-clockwise.
        """
        if not self._near_foot.within(x, y, self.whisker, z + OVER):
            return 0
        bits = 0
        for k in range(WHISKERS):
            c, s = direction(yaw + k * (2.0 * math.pi / WHISKERS))
            tip = x + self.whisker * c, y + self.whisker * s
            if self.sweep(x, y, *tip, z + OVER) is not None:
                bits |= 1 << k
        return bits

    def bump(self, body: Sequence[float], feet: Sequence[Sequence[float]]) -> int | None:
        """What of the machine is in an obstacle: a leg, −1 for the torso, None for nothing."""
        x, y, z, _, _, yaw = body
        if self._torso_hits(x, y, z - self.machine.torso[2] / 2, yaw):
            return -1
        for leg, foot in enumerate(feet):
            if self.leg_hits(leg, body, foot):
                return leg
        return None

    def leg_hits(self, leg: int, body: Sequence[float], foot: Sequence[float]) -> bool:
        """True when something stands in the straight way from a leg's hip, at the height of the
        body, to its foot.
        """
        hip = placed((body[0], body[1], body[5]), *self._hips[leg])
        low = body[2] if body[2] < foot[2] else foot[2]
        if not self._near_body.on_the_way(body, hip, foot, low + OVER - ASK):
            return False
        hits = self._space.segment_query(hip, (foot[0], foot[1]), 0.0, ANY)
        return any(
            self._tops_of(hit.shape) > body[2] + hit.alpha * (foot[2] - body[2]) + OVER
            for hit in hits
        )

    def _torso_hits(self, x: float, y: float, bottom: float, yaw: float) -> bool:
        if not self._near_body.within(x, y, self._torso_reach, bottom):
            return False
        length, width, _ = self.machine.torso
        c, s = direction(yaw)
        body = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        turn = pymunk.Transform(a=c, b=s, c=-s, d=c, tx=x, ty=y)
        shape = pymunk.Poly(body, _rectangle(length, width), turn)
        shape.cache_bb()
        return any(self._tops_of(hit.shape) > bottom for hit in self._space.shape_query(shape))

    def _tops_of(self, shape: pymunk.Shape | None) -> float:
        return -math.inf if shape is None else self._tops[shape]

    # -- sliding

    @property
    def sliding(self) -> bool:
        """True while the machine is moving over the ground on its feet."""
        return self._slide is not None

    def slide(
        self,
        body: Sequence[float],
        feet: Sequence[Sequence[float]],
        fx: float,
        fy: float,
        dt: float,
    ) -> Slip | None:
        """One tick of (fx, fy) newtons in the ground plane on a machine standing on ``feet``; None
        when friction holds.
        """
        if not feet:
            return None
        if self._slide is None:
            self._slide = _Slide(self, body, feet)
        slip = self._slide.step(body, feet, fx, fy, dt)
        if slip is None:
            self._slide = None
        return slip

    def stop(self) -> None:
        """Forget the speed of a slide: its feet have lost the ground or hit something."""
        self._slide = None


class _Slide:
    """One slide from beginning to end, in a space of its own.

    Friction is one pivot joint at the centre of support, good for μ m g, and one gear joint for
    yaw, good for μ m g times the feet's mean distance from it. One pivot per foot would be wrong:
    the pivots fight each other, and the machine slips at 0.9 of the Coulomb limit. Nothing pulls
    the machine back to where it stood (max_bias 0).
    """

    def __init__(
        self, world: ContactWorld, body: Sequence[float], feet: Sequence[Sequence[float]]
    ) -> None:
        machine = world.machine
        length, width, height = machine.torso
        self.machine = machine
        self.space = pymunk.Space()
        self.space.iterations = ITERATIONS
        self.hull = pymunk.Body(
            machine.mass, machine.mass * (length * length + width * width) / 12.0
        )
        self.hull.position, self.hull.angle = (body[0], body[1]), body[5]
        bottom = body[2] - height / 2
        low = min(foot[2] for foot in feet) + OVER
        shapes = [_shape(self.space.static_body, obstacle) for obstacle in world.obstacles]
        for shape, obstacle in zip(shapes, world.obstacles, strict=True):
            shape.filter = pymunk.ShapeFilter(
                categories=(1 if obstacle.top > bottom else 0) | (2 if obstacle.top > low else 0)
            )
            self.space.add(shape)
        torso = pymunk.Poly(self.hull, _rectangle(length, width))
        torso.filter = pymunk.ShapeFilter(group=1, mask=1)
        self.space.add(self.hull, torso)
        for foot in feet:
            tip = pymunk.Circle(
                self.hull, machine.foot_radius, self.hull.world_to_local((foot[0], foot[1]))
            )
            tip.filter = pymunk.ShapeFilter(group=1, mask=2)
            self.space.add(tip)

    def step(
        self,
        body: Sequence[float],
        feet: Sequence[Sequence[float]],
        fx: float,
        fy: float,
        dt: float,
    ) -> Slip | None:
        """Advance one tick under a force at the centre of gravity; None once it has come to rest
        and friction holds.
        """
        hull = self.hull
        space = self.space
        hull.position = body[0], body[1]
        hull.angle = body[5]
        grips = self._friction(feet)
        space.add(*grips)
        for _ in range(SUBSTEPS):
            hull.apply_force_at_world_point((fx, fy), hull.position)
            space.step(dt / SUBSTEPS)
        space.remove(*grips)
        slip = Slip(hull.position.x - body[0], hull.position.y - body[1], hull.angle - body[5])
        speed = hull.velocity.length + abs(hull.angular_velocity) * self.machine.yaw_length
        moved = abs(slip.dx) + abs(slip.dy) + abs(slip.turn)
        return None if speed < STILL and moved < STILL * dt else slip

    def _friction(self, feet: Sequence[Sequence[float]]) -> tuple[pymunk.Constraint, ...]:
        """The joints that hold the machine by its feet on the ground."""
        cx, cy = centroid(feet)
        away = left_fold_sum(math.hypot(foot[0] - cx, foot[1] - cy) for foot in feet)
        grip = self.machine.friction * self.machine.mass * GRAVITY
        pivot = pymunk.PivotJoint(self.space.static_body, self.hull, (cx, cy))
        gear = pymunk.GearJoint(self.space.static_body, self.hull, self.hull.angle, 1.0)
        pivot.max_force = grip
        gear.max_force = grip * away / len(feet)
        for joint in (pivot, gear):
            joint.max_bias = 0.0
            joint.collide_bodies = True
        return pivot, gear


def _shape(body: pymunk.Body, obstacle: Obstacle) -> pymunk.Shape:
    if obstacle.corners:
        return pymunk.Poly(body, list(obstacle.corners))
    return pymunk.Circle(body, obstacle.radius, (obstacle.x, obstacle.y))


def _rectangle(length: float, width: float) -> list[tuple[float, float]]:
    a, b = length / 2, width / 2
    return [(a, b), (-a, b), (-a, -b), (a, -b)]


def _extent(machine: Machine) -> float:
    """How far the machine reaches from its centre of gravity at most, seen from above."""
    dx, dy, _ = machine.overreach
    far = [
        (max(abs(leg.x[0]), abs(leg.x[1])) + dx, max(abs(leg.y[0]), abs(leg.y[1])) + dy)
        for leg in machine.legs
    ]
    return max(math.hypot(x, y) for x, y in (*far, (machine.torso[0] / 2, machine.torso[1] / 2)))
