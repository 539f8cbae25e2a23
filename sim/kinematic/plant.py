"""The plant: servo speeds in, ``Sensing`` out, one tick of 20 ms at a time. The arrays here change
in place.

Legs are massless and quick, servos follow their speed exactly up to the machine's limits. Feet that
carry stay where they are, to the last bit, unless they slide; the body goes where they take it. The
body rests on the upper hull of its feet; four legs are statically indeterminate, so one of them may
hang, and its sole says so. A foot in the air stops on the ground and at the riser of a step.
Contact with poles and blocks, and sliding, are in ``contact.py``; falling over is in ``topple.py``.

Approximations: no dynamics but those of sliding and falling; load is shared evenly by the feet that
carry; a cell's ground is level, so what pushes a foot down a slope is the slope of the cells around
it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from walking_console.planner.config import Tolerances
from walking_console.planner.geometry.transforms import left_fold_sum
from walking_console.planner.protocols import PlantState
from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import GRAVITY, TIP_SLACK, polygon_margin, support_polygon
from walking_console.planner.types import TICK, Point, Sensing, Stance

from ..terrain.ground import Ground
from .contact import OVER, World
from .rest_pose import (
    Rest,
    Rotation,
    about,
    after,
    angles,
    attitude,
    lean,
    nearest_inside,
    plane_fit,
    rest,
    rotation,
    turned,
    unturned,
)
from .tipping import (
    DROP_MAX,
    FALL_TILT,
    Edge,
    Fall,
    angular_acceleration,
    carried_over,
    edge_of,
    passed_on,
)

# m; a moving foot this near the ground has come down: nearer than that a servo could not take it in
# time
TOUCH = 1e-6
SOLE_GAP = 0.001  # m; a sole this near the ground is on: what it gives under load
# m; a body about to tip onto a foot that hangs no higher than this rests on it at once, without a
# fall
ROCK = 0.01
# m a tick; a foot that has come down and moves faster over the ground than this does not carry
SCRAPE = 0.001
OVERHANG = 0.03  # m the ground under a sole's rim may lie lower; more is an edge
STEP_UP = 0.01  # m; a foot moving sideways rides up this much, a taller riser stops it
SAME = 1e-10  # m a tick; foot motions this near each other are one motion of the body
STIFF = 1e-9  # m; carrying feet pulled apart by less are not pulled
EXACT = 1e-12  # a lean or a height that changes by less does not change
# N/m sideways: an estimate; titan3's feet give 5 mm before they slip. Softer: see feet slip later
LEG_STIFFNESS = 32_000.0
ROUNDING = 1e-9  # m²; a body on the very edge of its polygon is not outside it
STEEP = 0.9  # of the friction: ground that pulls less holds without a look at the contact world
# times a body that tilts is laid on its feet in a tick: each leaves a hundredth of the error, or
# less
RESTS_MAX = 8
ON_GROUND = 0.005  # m; a foot of the start stance this near the ground stands on it

Step = tuple[float, float, float]  # m in one tick, body axes


@dataclass(frozen=True, slots=True)
class Noise:
    """Standard deviations of what the sensors add, drawn anew each tick."""

    position: float = 0.0  # m, position monitors, per axis
    posture: float = 0.0  # rad, roll and pitch


class KinematicPlant:
    """The simulated machine on its ground. ``body`` is x, y, z, roll, pitch, yaw; ``feet`` are foot
    tips, absolute.
    """

    tolerances = Tolerances()  # servos follow exactly: what is off is off by rounding

    def __init__(
        self,
        machine: Machine,
        ground: Ground,
        stance: Stance,
        *,
        noise: Noise | None = None,
        rng: np.random.Generator | None = None,
    ) -> None:
        if len(stance.feet) != len(machine.legs):
            raise ValueError(
                f"a stance for {machine.name!r} has {len(machine.legs)} feet, got {len(stance.feet)}"
            )
        if noise is not None and rng is None:
            raise ValueError("sensor noise needs a seeded generator")
        x, y, z, yaw = stance.body
        self.machine, self.ground = machine, ground
        self.world = World(ground.obstacles, machine)
        self.noise, self.rng = noise, rng
        self.tick = 0
        self.body = [x, y, z, 0.0, 0.0, yaw]
        self.feet = [list(foot) for foot in stance.feet]
        self.soles = [False] * len(self.feet)
        self.whiskers = [0] * len(self.feet)
        self.rims = [0] * len(self.feet)
        self.slipping = [False] * len(self.feet)
        self.state: PlantState = "standing"
        self._stride = tuple(limit * TICK for limit in machine.speed)
        self._reach = tuple(_mechanical(machine, leg) for leg in range(len(machine.legs)))
        self._turned: Rotation = rotation(0.0, 0.0, yaw)
        # foot tips in body axes
        self._legs = [list(unturned(self._turned, f[0] - x, f[1] - y, f[2] - z)) for f in self.feet]
        self._carry: list[int] = []
        self._free: list[int] = []
        self._pull = [[0.0, 0.0] for _ in self.feet]  # m, how far each carrying leg is pulled aside
        # of the support polygon: inside where n·(x, y) >= offset
        self._edges: list[tuple[float, float, float]] = []
        self._slope = (0.0, 0.0)  # mean, under the carrying feet
        self._weight = machine.mass * GRAVITY
        self._push = (0.0, 0.0)
        self._push_ticks = 0
        # nothing but walking happens: no push, no slide, nothing changed from outside
        self._quiet = False
        self._fall: Fall | None = None
        for leg, foot in enumerate(self.feet):
            height = ground.height_at(foot[0], foot[1])
            if leg not in stance.lifted and abs(foot[2] - height) <= ON_GROUND:
                foot[2] = height
                self._legs[leg][:] = unturned(self._turned, foot[0] - x, foot[1] - y, foot[2] - z)
                self._carry.append(leg)
        self._stand()

    # -- what the machine senses

    def sense(self) -> Sensing:
        """Position monitors, soles, whiskers and posture at this tick."""
        body, legs, (x, y, z, roll, pitch, yaw) = self.body, self._legs, self.body
        if self.noise is None:
            return Sensing(
                self.tick,
                (x, y, z, roll, pitch, yaw),
                tuple([(leg[0], leg[1], leg[2]) for leg in legs]),
                tuple(self.soles),
                tuple(self.whiskers),
                tuple(self.slipping),
                tuple(self.rims),
            )
        assert self.rng is not None
        drawn = self.rng.standard_normal(3 * len(legs) + 2).tolist()
        p, a = self.noise.position, self.noise.posture
        noisy = zip(legs, drawn[0::3], drawn[1::3], drawn[2::3], strict=False)
        feet = tuple(
            (leg[0] + p * ax, leg[1] + p * ay, leg[2] + p * az) for leg, ax, ay, az in noisy
        )
        tilt = body[3] + a * drawn[-2], body[4] + a * drawn[-1]
        touch = tuple(self.soles), tuple(self.whiskers), tuple(self.slipping), tuple(self.rims)
        return Sensing(self.tick, (x, y, z, *tilt, yaw), feet, *touch)

    @property
    def carrying(self) -> tuple[int, ...]:
        """Legs whose feet carry the body."""
        return tuple(self._carry)

    # -- what is done to it from outside

    def push(self, fx: float, fy: float, ticks: int) -> None:
        """Push the body with (fx, fy) newtons in the ground plane, at the centre of gravity, for so
        many ticks.
        """
        if not (math.isfinite(fx) and math.isfinite(fy)) or ticks < 0:
            raise ValueError(
                f"a push needs finite newtons and ticks >= 0, got {fx!r}, {fy!r}, {ticks!r}"
            )
        self._push, self._push_ticks = (fx, fy), ticks
        self._quiet = self._quiet and ticks == 0

    def replace_ground(self, ground: Ground) -> None:
        """Put other ground under the machine: feet whose ground rose are lifted by it, feet whose
        ground is gone hang.
        """
        self.ground = ground
        self.world = World(ground.obstacles, self.machine)
        for leg in tuple(self._carry):
            foot = self.feet[leg]
            height = ground.height_at(foot[0], foot[1])
            if height >= foot[2] - SOLE_GAP:
                foot[2] = height
            else:
                self._carry.remove(leg)
                self.soles[leg] = False
        self._stand()
        self._quiet = False

    # -- one tick

    def move(self, velocities: Sequence[Point]) -> None:
        """One tick: every foot is driven at its velocity in body axes, m/s, within its limits and
        its mechanical reach.
        """
        self.tick += 1
        if self.state == "fallen":
            return
        steps = self._servos(velocities)
        for leg in self._free:
            if self.soles[leg]:
                self._take_up(steps)
                break
        if self._quiet and self._glide(steps):
            return
        if self._fall is None:
            self._shift(steps)
        else:
            self._topple(steps)
        if self._push_ticks:
            self._push_ticks -= 1

    def _servos(self, velocities: Sequence[Point]) -> list[Step]:
        """How far each foot goes this tick in body axes: what is asked, held to speed limits and
        reach; NaN does not move.
        """
        sx, sy, sz = self._stride
        steps = []
        for (vx, vy, vz), (px, py, pz), (x0, x1, y0, y1, z0, z1) in zip(
            velocities, self._legs, self._reach, strict=True
        ):
            dx, dy, dz = vx * TICK, vy * TICK, vz * TICK
            if not -sx <= dx <= sx:
                dx = sx if dx > sx else -sx if dx < -sx else 0.0
            if not -sy <= dy <= sy:
                dy = sy if dy > sy else -sy if dy < -sy else 0.0
            if not -sz <= dz <= sz:
                dz = sz if dz > sz else -sz if dz < -sz else 0.0
            if not x0 <= px + dx <= x1:
                dx = _into(px, dx, x0, x1)
            if not y0 <= py + dy <= y1:
                dy = _into(py, dy, y0, y1)
            if not z0 <= pz + dz <= z1:
                dz = _into(pz, dz, z0, z1)
            steps.append((dx, dy, dz))
        return steps

    def _glide(self, steps: Sequence[Step]) -> bool:
        """The common walking tick: carrying legs do one and the same motion, so the body moves and
        their feet do not.

        False, and nothing done, when it is not that simple.
        """
        body, legs, carry, r = self.body, self._legs, self._carry, self._turned
        dx, dy, dz = steps[carry[0]]
        for leg in carry:
            ax, ay, az = steps[leg]
            if not (-SAME < ax - dx < SAME and -SAME < ay - dy < SAME and -SAME < az - dz < SAME):
                return self._glide_turning(steps)
        x = body[0] - (r[0] * dx + r[1] * dy + r[2] * dz)
        y = body[1] - (r[3] * dx + r[4] * dy + r[5] * dz)
        for nx, ny, offset in self._edges:
            if nx * x + ny * y < offset:
                return False
        if self.world.crowds(x, y) and self._bumps(x, y, body[5]) is not None:
            return False
        body[0], body[1] = x, y
        body[2] -= r[6] * dx + r[7] * dy + r[8] * dz
        for leg in carry:
            position = legs[leg]
            position[0] += dx
            position[1] += dy
            position[2] += dz
        if self._free:
            self._swing(steps, self._free)
        return True

    def _glide_turning(self, steps: Sequence[Step]) -> bool:
        """The same for a level body that turns: one rotation fits all carrying feet."""
        body, legs, feet, carry = self.body, self._legs, self.feet, self._carry
        dz = steps[carry[0]][2]
        if (
            body[3] != 0.0
            or body[4] != 0.0
            or any(not -SAME < steps[leg][2] - dz < SAME for leg in carry)
        ):
            return False
        reached = [(legs[leg][0] + steps[leg][0], legs[leg][1] + steps[leg][1]) for leg in carry]
        x, y, yaw = plane_fit([feet[leg] for leg in carry], reached, body[5])
        c, d = math.cos(yaw), math.sin(yaw)
        for leg, (qx, qy) in zip(carry, reached, strict=True):
            if (
                abs(x + c * qx - d * qy - feet[leg][0]) > STIFF
                or abs(y + d * qx + c * qy - feet[leg][1]) > STIFF
            ):
                return False
        if any(nx * x + ny * y < offset for nx, ny, offset in self._edges):
            return False
        if self.world.crowds(x, y) and self._bumps(x, y, yaw) is not None:
            return False
        body[0], body[1], body[5] = x, y, yaw
        body[2] -= dz
        self._turned = (c, -d, 0.0, d, c, 0.0, 0.0, 0.0, 1.0)
        for leg in carry:
            ax, ay = feet[leg][0] - x, feet[leg][1] - y
            legs[leg][:] = c * ax + d * ay, c * ay - d * ax, legs[leg][2] + dz
        if self._free:
            self._swing(steps, self._free)
        return True

    def _swing(self, steps: Sequence[Step], legs: Sequence[int]) -> None:
        """Feet that carry nothing: they go where they are driven until they touch the ground, and
        stop there.
        """
        (bx, by, bz, _, _, _), r = self.body, self._turned
        crowded = self.world.crowds(bx, by)
        for leg in legs:
            foot, position, (dx, dy, dz) = self.feet[leg], self._legs[leg], steps[leg]
            px, py, pz = position[0] + dx, position[1] + dy, position[2] + dz
            x = bx + r[0] * px + r[1] * py + r[2] * pz
            y = by + r[3] * px + r[4] * py + r[5] * pz
            z = bz + r[6] * px + r[7] * py + r[8] * pz
            if self.world.near(x, y):
                x, y = self._feel(leg, x, y, z)
            elif self.whiskers[leg]:
                self.whiskers[leg] = 0
            if (
                crowded
                and self.world.leg_hits(leg, self.body, (x, y, z))
                and not self.world.leg_hits(leg, self.body, foot)
            ):
                self._meet(leg, x - foot[0], y - foot[1])
                x, y = foot[0], foot[1]
            height = self.ground.height_at(x, y)
            if z - height > TOUCH or height != height:
                self.soles[leg] = self.slipping[leg] = False
                position[0], position[1], position[2] = px, py, pz
                foot[0], foot[1], foot[2] = x, y, z
            else:
                self._touch(leg, x, y, z, height)

    def _take_up(self, steps: Sequence[Step]) -> None:
        """Feet that came down in the tick before carry from now on, but those that scrape over the
        ground.
        """
        if self._fall is not None or len(self._carry) < 2:
            return
        legs = self._legs
        before = [legs[leg] for leg in self._carry]
        driven = [
            (legs[leg][0] + steps[leg][0], legs[leg][1] + steps[leg][1]) for leg in self._carry
        ]
        dx, dy, turn = plane_fit(before, driven, 0.0)  # the body's motion, in its own axes
        c, d = math.cos(turn), math.sin(turn)
        for leg in tuple(self._free):
            if self.soles[leg]:
                (px, py, _), (sx, sy, _) = legs[leg], steps[leg]
                ax, ay = dx + c * (px + sx) - d * (py + sy), dy + d * (px + sx) + c * (py + sy)
                if math.hypot(ax - px, ay - py) <= SCRAPE:
                    foot = self.feet[leg]
                    foot[2] = self.ground.height_at(foot[0], foot[1])
                    self._carry = sorted((*self._carry, leg))
        self._stand()

    def _feel(self, leg: int, x: float, y: float, z: float) -> tuple[float, float]:
        """Where a foot gets to that is driven to (x, y, z) near an obstacle; its whiskers say what
        is around it.
        """
        foot = self.feet[leg]
        touch = self.world.sweep(foot[0], foot[1], x, y, z + OVER)
        if touch is not None:
            short = max(0.0, touch.share - 1e-3)
            x, y = foot[0] + (x - foot[0]) * short, foot[1] + (y - foot[1]) * short
        self.whiskers[leg] = self.world.feel(x, y, z, self.body[5])
        return x, y

    def _touch(self, leg: int, x: float, y: float, z: float, height: float) -> None:
        """A foot in the air meets ground: it stops there, or beside a riser. From the next tick on
        it carries.
        """
        foot, body, was_on = self.feet[leg], self.body, self.soles[leg]
        if height - foot[2] > STEP_UP:
            (x, y), height = self._stop_at_riser(leg, x, y)
        self.soles[leg] = on = z - height <= TOUCH
        self.slipping[leg] = (
            was_on and on and (abs(x - foot[0]) > STIFF or abs(y - foot[1]) > STIFF)
        )
        foot[0], foot[1], foot[2] = x, y, height if on else z
        self._legs[leg][:] = unturned(self._turned, x - body[0], y - body[1], foot[2] - body[2])
        self.rims[leg] = (
            self._overhang(x, y, height) if on and not was_on else self.rims[leg] if on else 0
        )

    def _overhang(self, x: float, y: float, height: float) -> int:
        """Directions of eight, bit 0 along body +x, in which the rim of a sole has no ground under
        it, as finely as the map tells.
        """
        ground = self.ground
        reach = math.floor(self.machine.foot_radius / ground.cell + 1e-9) * ground.cell
        if ground.final or reach == 0.0:
            return 0
        bits = 0
        for k in range(8):
            bearing = self.body[5] + k * math.pi / 4
            if (
                not height
                - ground.height_at(x + reach * math.cos(bearing), y + reach * math.sin(bearing))
                <= OVERHANG
            ):
                bits |= 1 << k
        return bits

    def _stop_at_riser(self, leg: int, x: float, y: float) -> tuple[tuple[float, float], float]:
        """How far a foot on its way to (x, y) gets before ground too tall to ride up, and the
        ground there.
        """
        foot, ground = self.feet[leg], self.ground
        free, stuck = 0.0, 1.0
        for _ in range(6):  # to a third of a millimetre
            middle = (free + stuck) / 2
            height = ground.height_at(
                foot[0] + (x - foot[0]) * middle, foot[1] + (y - foot[1]) * middle
            )
            if height - foot[2] > STEP_UP:
                stuck = middle
            else:
                free = middle
        self._meet(leg, x - foot[0], y - foot[1])
        x, y = foot[0] + (x - foot[0]) * free, foot[1] + (y - foot[1]) * free
        return (x, y), ground.height_at(x, y)

    def _meet(self, leg: int, dx: float, dy: float) -> None:
        """The whisker on the side a foot was going to says that something is there."""
        bearing = math.atan2(dy, dx) - self.body[5]
        self.whiskers[leg] |= 1 << round(bearing / (math.pi / 4)) % 8

    # -- ticks that are not simple

    def _shift(self, steps: Sequence[Step]) -> None:
        """A tick in which carrying feet are not driven as one, or the body is pushed, or rests
        anew, or loses its balance.
        """
        place = self.body[0], self.body[1], self.body[5]
        for leg in self._carry:
            position, (dx, dy, dz) = self._legs[leg], steps[leg]
            position[0], position[1], position[2] = (
                position[0] + dx,
                position[1] + dy,
                position[2] + dz,
            )
            self.slipping[leg] = False
        free = tuple(self._free)
        self._follow()
        if (
            self.world.crowds(self.body[0], self.body[1])
            and self._bumps(*place) is None
            and self._bumps(*self._place) is not None
        ):
            self._turn_to(*place, self.body[3], self.body[4])
            self._measure()
        if self._balanced():
            self._rest()
            heights = [foot[2] for foot in self.feet]
            self._give_way()
            self._slide()
            if heights != [foot[2] for foot in self.feet]:  # a foot was dragged onto other ground
                self._rest()
                self._measure()
            if self._turned[8] < math.cos(FALL_TILT):  # its legs have laid it down
                self.state = "fallen"
        else:
            self._start_to_fall()
        self._swing(steps, [leg for leg in free if leg in self._free])
        self._stand()

    @property
    def _place(self) -> tuple[float, float, float]:
        return self.body[0], self.body[1], self.body[5]

    def _turn_to(self, x: float, y: float, yaw: float, roll: float, pitch: float) -> None:
        body = self.body
        body[0], body[1], body[3], body[4], body[5] = x, y, roll, pitch, yaw
        self._turned = rotation(roll, pitch, yaw)

    def _follow(self) -> None:
        """The body goes, in the ground plane, where its carrying legs take it: the best fit when
        they do not agree.
        """
        if not self._carry:
            return
        roll, pitch = self.body[3], self.body[4]
        tilt = rotation(roll, pitch, 0.0)
        feet = [self.feet[leg] for leg in self._carry]
        x, y, yaw = plane_fit(
            feet, [turned(tilt, *self._legs[leg])[:2] for leg in self._carry], self.body[5]
        )
        self._turn_to(x, y, yaw, roll, pitch)

    def _measure(self) -> None:
        """Set the monitors of carrying legs, sideways, to where their feet stand."""
        x, y, z, *_ = self.body
        for leg in self._carry:
            foot = self.feet[leg]
            px, py, _ = unturned(self._turned, foot[0] - x, foot[1] - y, foot[2] - z)
            self._legs[leg][0], self._legs[leg][1] = px, py

    def _bumps(self, x: float, y: float, yaw: float) -> int | None:
        """What of the machine would be in an obstacle with its body here: a leg, −1 for the torso,
        None for nothing.
        """
        return self.world.bump((x, y, self.body[2], 0.0, 0.0, yaw), self.feet)

    def _load_point(self) -> tuple[float, float]:
        """Where the weight and a push, taken together, press on the ground."""
        x, y, z, *_ = self.body
        if not self._push_ticks or not self._carry:
            return x, y
        lever = (z - left_fold_sum(self.feet[leg][2] for leg in self._carry) / len(self._carry)) / (
            self.machine.mass * GRAVITY
        )
        return x + self._push[0] * lever, y + self._push[1] * lever

    def _balanced(self) -> bool:
        """True when the feet carry the load; before it is lost, the body rocks onto feet that touch
        or nearly do.
        """
        x, y = self._load_point()
        if self._holds(x, y):
            return True
        near = {}
        for leg in self._free:
            foot = self.feet[leg]
            height = self.ground.height_at(foot[0], foot[1])
            if foot[2] - height <= ROCK:
                near[leg] = height
        if not near or not self._holds(x, y, near):
            return False
        for leg, height in near.items():
            self.feet[leg][2] = height
        self._carry = sorted((*self._carry, *near))
        self._free = [leg for leg in self._free if leg not in near]
        return True

    def _holds(self, x: float, y: float, more: Iterable[int] = ()) -> bool:
        return (
            polygon_margin(support_polygon(self.feet[leg] for leg in (*self._carry, *more)), x, y)
            >= -TIP_SLACK
        )

    def _rest(self) -> None:
        """Lay the body on its feet; feet that then hang by more than a sole gives are let go."""
        for _ in range(RESTS_MAX):
            x, y, z, roll, pitch, yaw = self.body
            now = Rest(z, *lean(self._turned))
            polygon = support_polygon(self.feet[leg] for leg in self._carry)
            if len(polygon) < 3:
                return
            px, py = nearest_inside(polygon, *self._load_point())
            feet = [
                (self.feet[leg][0] - x, self.feet[leg][1] - y, self.feet[leg][2])
                for leg in self._carry
            ]
            lengths = [self._legs[leg][2] for leg in self._carry]
            laid = rest(feet, lengths, px - x, py - y, now)
            if laid is None:
                return
            self.body[2] = z = laid.z if abs(laid.z - z) > EXACT else z
            if abs(laid.lean_x - now.lean_x) <= EXACT and abs(laid.lean_y - now.lean_y) <= EXACT:
                break
            level = abs(laid.lean_x) < EXACT and abs(laid.lean_y) < EXACT
            roll, pitch = (0.0, 0.0) if level else attitude(laid.lean_x, laid.lean_y, yaw)
            self._turn_to(x, y, yaw, roll, pitch)
            # a body that tilts goes sideways over its feet, and there lies a little higher or lower
            self._follow()
        assert laid is not None
        stretch = 1.0 / self._turned[8]
        for leg, (ex, ey, height), length in zip(tuple(self._carry), feet, lengths, strict=True):
            gap = laid.z - laid.lean_x * ex - laid.lean_y * ey - height + stretch * length
            if gap > SOLE_GAP:
                self._let_go(leg)

    def _let_go(self, leg: int) -> None:
        """A foot that hangs: it is where the body has it, though not in the ground."""
        self._carry.remove(leg)
        self._pull[leg][:] = 0.0, 0.0
        self._hang(leg)

    def _hang(self, leg: int) -> bool:
        """Put a foot where the body has it; True when that is on the ground, which stops it."""
        body, foot = self.body, self.feet[leg]
        x, y, z = turned(self._turned, *self._legs[leg])
        foot[:] = body[0] + x, body[1] + y, body[2] + z
        height = self.ground.height_at(foot[0], foot[1])
        self.soles[leg], self.slipping[leg] = foot[2] - height <= SOLE_GAP, False
        if not foot[2] <= height:
            return False
        foot[2] = height
        self._legs[leg][:] = unturned(self._turned, x, y, height - body[2])
        return True

    def _give_way(self) -> None:
        """Feet that are pulled apart: a leg gives a little, then its foot slips by what is too
        much.
        """
        if not self._carry:
            return
        body, machine = self.body, self.machine
        grip = machine.friction * machine.mass * GRAVITY / len(self._carry) / LEG_STIFFNESS
        for leg in tuple(self._carry):
            foot, pull = self.feet[leg], self._pull[leg]
            x, y, _ = turned(self._turned, *self._legs[leg])
            rx, ry = body[0] + x - foot[0], body[1] + y - foot[1]
            if abs(rx) <= STIFF and abs(ry) <= STIFF:
                continue
            pull[0], pull[1] = pull[0] + rx, pull[1] + ry
            pulled = math.hypot(pull[0], pull[1])
            if pulled > grip:
                over = 1.0 - grip / pulled
                ox, oy = pull[0] * over, pull[1] * over
                pull[0], pull[1] = pull[0] - ox, pull[1] - oy
                self._replant(leg, foot[0] + ox, foot[1] + oy)
        self._measure()

    def _replant(self, leg: int, x: float, y: float) -> bool:
        """Drag a carrying foot to (x, y) over the ground; False when a riser is in the way. Over an
        edge it loses its hold.
        """
        foot = self.feet[leg]
        height = self.ground.height_at(x, y)
        if height - foot[2] > STEP_UP:
            return False
        self.slipping[leg] = True
        fell = not height >= foot[2] - SOLE_GAP
        foot[0], foot[1], foot[2] = x, y, foot[2] if fell else height
        if fell:
            self._let_go(leg)
        return True

    def _slide(self) -> None:
        """Push and slope against the friction of all feet: what is too much, moves the machine over
        the ground.
        """
        fx, fy = self._ground_load()
        if (
            not self._carry
            or math.hypot(fx, fy) <= STEEP * self.machine.friction * self._weight
            and not self.world.sliding
        ):
            return
        slip = self.world.slide(self.body, [self.feet[leg] for leg in self._carry], fx, fy, TICK)
        if slip is None:
            return
        (bx, by, _, roll, pitch, yaw), c, d = self.body, math.cos(slip.turn), math.sin(slip.turn)
        x, y = bx + slip.dx, by + slip.dy
        places = [(self.feet[leg][0] - bx, self.feet[leg][1] - by) for leg in self._carry]
        self._turn_to(x, y, yaw + slip.turn, roll, pitch)
        for leg, (ex, ey) in zip(tuple(self._carry), places, strict=True):
            if not self._replant(leg, x + c * ex - d * ey, y + d * ex + c * ey):
                self.world.stop()
        self._measure()

    def _ground_load(self) -> tuple[float, float]:
        """Newtons in the ground plane: the push, and the weight on the mean slope under the
        carrying feet.
        """
        fx, fy = self._push if self._push_ticks else (0.0, 0.0)
        if self._slope == (0.0, 0.0):
            return fx, fy
        return fx - self._weight * self._slope[0], fy - self._weight * self._slope[1]

    def _stand(self) -> None:
        """Take stock after a change of support: which legs carry, the edges of their polygon, the
        slope under them.
        """
        self._free = [leg for leg in range(len(self.feet)) if leg not in self._carry]
        for leg in self._carry:
            self.soles[leg] = True
            self.whiskers[leg] = 0
        polygon = support_polygon(self.feet[leg] for leg in self._carry)
        self._edges = [
            (ay - by, bx - ax, (bx - ax) * ay - (by - ay) * ax - ROUNDING)
            for (ax, ay), (bx, by) in zip(polygon, (*polygon[1:], *polygon[:1]), strict=True)
        ]
        self._slope = self._mean_slope()
        steep = math.hypot(*self._slope) > STEEP * self.machine.friction
        self._quiet = len(polygon) > 2 and not (
            self._push_ticks or steep or self.world.sliding or self._fall
        )

    def _mean_slope(self) -> tuple[float, float]:
        if self.ground.level is not None or not self._carry:
            return 0.0, 0.0
        slopes = [
            slope_at(self.ground, self.feet[leg][0], self.feet[leg][1], self.machine.foot_radius)
            for leg in self._carry
        ]
        return left_fold_sum(slope[0] for slope in slopes) / len(slopes), left_fold_sum(
            slope[1] for slope in slopes
        ) / len(slopes)

    # -- falling

    def _start_to_fall(self) -> None:
        self.state = "tipping"
        self._fall = Fall(
            edge_of({leg: self.feet[leg] for leg in self._carry}, *self._load_point())
        )
        self.world.stop()

    def _topple(self, steps: Sequence[Step]) -> None:
        """A tick of falling: legs still move, the whole machine turns about its edge until a foot
        catches it or it lies.
        """
        fall = self._fall
        assert fall is not None
        for position, (dx, dy, dz) in zip(self._legs, steps, strict=True):
            position[0], position[1], position[2] = (
                position[0] + dx,
                position[1] + dy,
                position[2] + dz,
            )
        if fall.edge is None:
            self._drop(fall)
        else:
            self._tilt(fall, fall.edge)
        touching = self._hang_feet(fall.edge.legs if fall.edge else ())
        if self._lies(fall):
            self.state, self._fall = "fallen", None
        elif touching:
            self._catch(fall, touching)

    def _drop(self, fall: Fall) -> None:
        fall.sink += GRAVITY * TICK
        fall.dropped += fall.sink * TICK
        self.body[2] -= fall.sink * TICK

    def _tilt(self, fall: Fall, edge: Edge) -> None:
        body, r = self.body, self._turned
        shift = [0.0, 0.0, 0.0]
        for leg in edge.legs:  # the feet of the edge stay where they are
            x, y, z = turned(r, *self._legs[leg])
            for axis, reached in enumerate((body[0] + x, body[1] + y, body[2] + z)):
                shift[axis] += (self.feet[leg][axis] - reached) / len(edge.legs)
        body[0], body[1], body[2] = body[0] + shift[0], body[1] + shift[1], body[2] + shift[2]
        push = self._push if self._push_ticks else (0.0, 0.0)
        fall.rate += angular_acceleration(self.machine, edge, body, push) * TICK
        spin = about(edge.axis, fall.rate * TICK)
        px, py, pz = edge.point
        x, y, z = turned(spin, body[0] - px, body[1] - py, body[2] - pz)
        self._turned = after(spin, r)
        roll, pitch, yaw = angles(self._turned)
        # the yaw does not jump at ±π
        yaw += 2.0 * math.pi * round((body[5] - yaw) / (2.0 * math.pi))
        body[:] = px + x, py + y, pz + z, roll, pitch, yaw

    def _hang_feet(self, pivots: Sequence[int]) -> list[int]:
        """Put all feet but the pivots where the body has them; those that the ground stops are
        returned.
        """
        for leg in pivots:
            self.soles[leg], self.slipping[leg] = True, False
        return [leg for leg in range(len(self.feet)) if leg not in pivots and self._hang(leg)]

    def _lies(self, fall: Fall) -> bool:
        """True when the torso leans too far, is on the ground, or has fallen into a hole."""
        if self._turned[8] < math.cos(FALL_TILT) or fall.dropped > DROP_MAX:
            return True
        length, width, height = self.machine.torso
        for sx, sy in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
            x, y, z = turned(self._turned, sx * length / 2, sy * width / 2, -height / 2)
            if self.body[2] + z <= self.ground.height_at(self.body[0] + x, self.body[1] + y):
                return True
        return False

    def _catch(self, fall: Fall, touching: Sequence[int]) -> None:
        """Feet have come down: either they and the edge carry the body now, or it goes on about
        another edge.
        """
        edge = fall.edge
        self._carry = sorted({*touching, *(edge.legs if edge else ())})
        x, y = self._load_point()
        feet = {leg: self.feet[leg] for leg in self._carry}
        if self._holds(x, y):
            over = carried_over(self.machine, edge, fall.rate, feet, self.body) if edge else None
            if over is None:
                self.state, self._fall = "standing", None
                self._measure()
            else:
                self._fall = over
        else:
            new = edge_of(feet, x, y)
            if edge is None or new is None or new.legs != edge.legs:
                fall.rate = passed_on(edge, new, fall.rate)
            fall.edge, fall.sink = new, 0.0
        self._stand()


def _mechanical(machine: Machine, leg: int) -> tuple[float, float, float, float, float, float]:
    """The reach of a leg's mechanism: its control box widened by δ."""
    (dx, dy, dz), box = machine.overreach, machine.legs[leg]
    return box.x[0] - dx, box.x[1] + dx, box.y[0] - dy, box.y[1] + dy, box.z[0] - dz, box.z[1] + dz


def _into(position: float, step: float, low: float, high: float) -> float:
    """As much of a step as the reach allows; outside it, only back towards it."""
    if position + step > high:
        return min(step, max(0.0, high - position)) if step > 0.0 else step
    return max(step, min(0.0, low - position)) if step < 0.0 else step


def slope_at(ground: Ground, x: float, y: float, span: float) -> tuple[float, float]:
    """Slope of the ground along x and y: the lesser of before and behind, so that the riser of a
    step is not a slope.
    """
    cell = ground.cell_at(x, y)
    if cell is None:
        return 0.0, 0.0
    d = ground.cell * max(1, round(span / ground.cell))
    here, (x, y) = ground.height_at(x, y), ground.centre(*cell)
    slopes = []
    for dx, dy in ((d, 0.0), (0.0, d)):
        before, behind = (
            (ground.height_at(x + dx, y + dy) - here) / d,
            (here - ground.height_at(x - dx, y - dy)) / d,
        )
        slopes.append(min(before, behind, key=abs) if before * behind > 0.0 else 0.0)
    return slopes[0], slopes[1]
