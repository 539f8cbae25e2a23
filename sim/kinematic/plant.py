"""The plant: servo speeds in, ``Sensing`` out, one tick of 20 ms at a time; changed in place.

Legs are massless and quick, servos follow their speed exactly up to the machine's limits. Feet that
carry stay where they are, to the last bit, unless they slide; the body goes where they take it. The
body rests on the upper hull of its feet; four legs are statically indeterminate, so one of them may
hang, and its sole says so. A foot in the air stops on the ground and at the riser of a step.

Approximations: no dynamics but those of sliding and falling; load is shared evenly by the feet that
carry; a cell's ground is level, so what pushes a foot down a slope is the slope of the cells around
it. A sole gives by a millimetre: a foot that is lifted stays on the ground for that long and then
springs clear, so that over one tick it may seem faster than its servo is (by up to 0.05 m/s).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from walking_console.planner.config import Tolerances
from walking_console.planner.geometry.transforms import direction
from walking_console.planner.protocols import PlantState
from walking_console.planner.robot.kinematics import inverse
from walking_console.planner.robot.model import Machine
from walking_console.planner.types import Point, Sensing, Stance

from ..sensor_noise import SensorNoise, with_noise
from ..terrain.ground import Ground
from .configuration import SOLE_GAP, Configuration, FootMotion
from .falling import UPRIGHT, Falling
from .gliding import glide
from .rest_pose import plane_fit
from .servos import Servos
from .support import Support
from .swing_feet import swing

# m a tick; a foot that has come down and moves faster over the ground than this does not carry
SCRAPE = 0.001
UNREACHED: Point = (math.nan, math.nan, math.nan)


class KinematicPlant:
    """The simulated machine on its ground, without dynamics but those of sliding and falling.

    ``body`` is x, y, z, roll, pitch, yaw (m, rad); ``feet`` are foot tips, absolute, m, in leg
    order; ``soles`` and ``whiskers`` are what is felt, a value a leg. ``noise`` needs a seeded
    ``rng``; ``physics`` makes no odds to legs without mass. Raises ``ValueError`` for a stance of
    another machine.
    """

    def __init__(
        self,
        machine: Machine,
        ground: Ground,
        stance: Stance,
        *,
        noise: SensorNoise | None = None,
        rng: np.random.Generator | None = None,
        physics: object = None,
    ) -> None:
        if len(stance.feet) != len(machine.legs):
            raise ValueError(
                f"a stance for {machine.name!r} has {len(machine.legs)} feet, "
                f"got {len(stance.feet)}"
            )
        if noise is not None and rng is None:
            raise ValueError("sensor noise needs a seeded generator")
        self.q = q = Configuration(machine, ground, stance)
        self.body = q.body
        self.feet = q.feet
        self.soles = q.soles
        self.whiskers = q.whiskers
        self.noise = noise
        self.rng = rng
        self.tick = 0
        self.state: PlantState = "standing"
        self._servos = Servos(machine)
        self._support = Support(q)
        self._falling = Falling(q)
        self._support.take_stock()

    @property
    def loads(self) -> Sequence[float]:
        """It has no sensors of load."""
        return ()

    @property
    def joints(self) -> list[Point]:
        """Joint coordinates of every leg, rad or m; those of a foot out of its chain's reach are
        not numbers.
        """
        legs = zip(self.q.machine.chains, self.q.tips, strict=True)
        return [inverse(chain, (x, y, z)) or UNREACHED for chain, (x, y, z) in legs]

    @property
    def tolerances(self) -> Tolerances:
        """Servos follow exactly, so that what is off is off by rounding, or by what sensors
        scatter.
        """
        noise = self.noise
        if noise is None or not noise.blurs:
            return Tolerances()
        return Tolerances(
            same_place=max(0.005, noise.position),
            held_back=0.05,
            body_off=0.01,
            foot_off=0.03,
            law="inertia",
            position_noise=noise.position,
            posture_noise=noise.posture,
            late=noise.delay,
        )

    # -- what the machine senses

    def sense(self) -> Sensing:
        """Position monitors, soles, whiskers and posture at this tick."""
        q = self.q
        exact = Sensing(
            self.tick,
            tuple(q.body),  # type: ignore[arg-type]
            tuple(map(tuple, q.tips)),  # type: ignore[arg-type]
            tuple(q.soles),
            tuple(q.whiskers),
            tuple(q.slipping),
            tuple(q.rims),
        )
        if self.noise is None or self.rng is None:
            return exact
        return with_noise(exact, self.noise, self.rng)

    @property
    def carrying(self) -> tuple[int, ...]:
        """Legs whose feet carry the body."""
        return tuple(self.q.carrying)

    # -- what is done to it from outside

    def push(self, fx: float, fy: float, ticks: int) -> None:
        """Push the body with (fx, fy) newtons in the ground plane, at the centre of gravity, for so
        many ticks.
        """
        if not (math.isfinite(fx) and math.isfinite(fy)) or ticks < 0:
            raise ValueError(
                f"a push needs finite newtons and ticks >= 0, got {fx!r}, {fy!r}, {ticks!r}"
            )
        self.q.push = (fx, fy)
        self.q.push_ticks = ticks
        self._support.quiet = self._support.quiet and ticks == 0

    def replace_ground(self, ground: Ground) -> None:
        """Put other ground under the machine: feet whose ground rose are lifted by it, feet whose
        ground is gone hang.
        """
        q = self.q
        q.replace_ground(ground)
        for leg in tuple(q.carrying):
            foot = q.feet[leg]
            height = ground.height_at(foot[0], foot[1])
            if height >= foot[2] - SOLE_GAP:
                foot[2] = height
            else:
                q.carrying.remove(leg)
                q.soles[leg] = False
        self._support.take_stock(self._falling.fall is not None)
        self._support.quiet = False

    # -- one tick

    def move(self, velocities: Sequence[Point], loads: Sequence[float] | None = None) -> None:
        """One tick: every foot is driven at its velocity in body axes, m/s, within its limits and
        its mechanical reach. What legs press with makes no odds to legs that do not give.
        """
        self.tick += 1
        if self.state == "fallen":
            return
        q = self.q
        support = self._support
        motions = self._servos.motions(velocities, q.tips)
        for leg in q.free:
            if q.soles[leg]:
                self._take_up(motions)
                break
        if support.quiet and glide(q, support, motions):
            if q.free:
                swing(q, motions, q.free)
            return
        if self._falling.fall is None:
            self._shift(motions)
        else:
            self._fall_on(motions)
        if q.push_ticks:
            q.push_ticks -= 1

    def _take_up(self, motions: Sequence[FootMotion]) -> None:
        """Feet that came down in the tick before carry from now on, but those that scrape over the
        ground.
        """
        q = self.q
        tips = self.q.tips
        if self._falling.fall is not None or len(q.carrying) < 2:
            return
        before = [tips[leg] for leg in q.carrying]
        driven = [
            (tips[leg][0] + motions[leg][0], tips[leg][1] + motions[leg][1]) for leg in q.carrying
        ]
        dx, dy, turn = plane_fit(before, driven, 0.0)  # the body's motion, in its own axes
        c, s = direction(turn)
        for leg in tuple(q.free):
            if not q.soles[leg]:
                continue
            foot = q.feet[leg]
            height = q.ground.height_at(foot[0], foot[1])
            if not height >= foot[2] - SOLE_GAP:  # its ground has gone since
                q.soles[leg] = False
                continue
            x, y, _ = tips[leg]
            px, py = x + motions[leg][0], y + motions[leg][1]
            ax, ay = dx + c * px - s * py, dy + s * px + c * py
            if math.hypot(ax - x, ay - y) <= SCRAPE:
                foot[2] = height
                q.carrying = sorted((*q.carrying, leg))
        self._support.take_stock()

    def _shift(self, motions: Sequence[FootMotion]) -> None:
        """A tick in which carrying feet are not driven as one, or the body is pushed, or rests
        anew, or loses its balance.
        """
        q = self.q
        support = self._support
        free = tuple(q.free)
        q.drive(q.carrying, motions)
        for leg in q.carrying:
            q.slipping[leg] = False
        self._follow_legs()
        if support.balances():
            self._settle()
        else:
            self._falling.begin()
            self.state = "tipping"
        swing(q, motions, [leg for leg in free if leg in q.free])
        support.take_stock(self._falling.fall is not None)

    def _follow_legs(self) -> None:
        """The body goes where its legs take it, unless that is into an obstacle."""
        q = self.q
        body = self.q.body
        before = body[0], body[1], body[5]
        self._support.follow()
        if (
            q.contact.crowds(body[0], body[1])
            and not q.bumps(*before)
            and q.bumps(body[0], body[1], body[5])
        ):
            q.turn_to(*before, body[3], body[4])
            q.measure_sideways()

    def _settle(self) -> None:
        """A balanced body comes to rest on its feet, which may slip or slide."""
        q = self.q
        support = self._support
        support.rest()
        heights = [foot[2] for foot in q.feet]
        support.give_way()
        support.slide()
        if heights != [foot[2] for foot in q.feet]:  # a foot was dragged onto other ground
            support.rest()
            q.measure_sideways()
        if q.rotation[8] < UPRIGHT:  # its legs have laid it down
            self.state = "fallen"

    def _fall_on(self, motions: Sequence[FootMotion]) -> None:
        if self._falling.advance(motions, self._support):
            self.state = "fallen"
        elif self._falling.fall is None:
            self.state = "standing"
