"""Level C (H §8) for a machine whose legs give and whose body has inertia.

Every foot gets the velocity its plan has it at in body axes, and a few percent a tick of what its
position monitor says it is off; legs that carry share one rigid motion of the body. The torso is
levelled by (36) from its posture and its rates, its height kept by (37), and each leg presses with
its planned load. The body's absolute place is not fed back: the next step begins where it is.
Body axes and angles as in ``foot_controller``.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

from ..config import Compliance, Gains, PlannerConfig, Tolerances
from ..geometry.transforms import attitude_of, left_fold_sum
from ..robot.model import Machine
from ..statics import RAMP
from ..types import TICK, Point, Sensing, StepPlan
from .foot_controller import ZERO, ReflexState
from .load_schedule import LoadSchedule, body_frame_feet
from .senses import Senses
from .sensor_filter import SensorFilter
from .tracking import PlanStretch, TrajectoryTracker

WALKED_IN_A_TICK = 1.5 * TICK  # s; more of a plan than this is broken off, not left over
UNLOADED = 0.02  # of a leg's even share; a foot meant to carry less is not made to reach for it
IDLE = 0.1  # of the same; a foot meant to carry less is not waited for


class CompliantController:
    """Level C of one walker, from plan to plan: ``loads`` are what its legs are to press with, N.

    ``printed``: (33) to (38) as they stand, every leg after its own reference.
    """

    def __init__(self, machine: Machine, config: PlannerConfig, printed: bool = False) -> None:
        self.loads: tuple[float, ...] = (0.0,) * len(machine.legs)
        self._machine = machine
        self._gains = _as_printed(config.gains) if printed else config.compliance
        self._printed = printed
        self._schedule: LoadSchedule | None = None
        self._since: dict[int, float] = {}  # s since feet came down before the plan
        self._aims: list[Point] | None = None  # where the plan has the feet now, body axes
        self._rest: list[Point] | None = None  # of the way of the plan before
        self._following: StepPlan | None = None
        self._last: Sequence[float] = ()  # loads of the tick before, N
        self._time = 0.0  # into the plan, of the tick before, s
        self._offset: list[float] = []  # of the loads of the plan before from this one's
        self._blend = 0.0  # of that offset there is still
        self._senses = Senses(machine, 0.0 if printed else config.compliance.centre)

    @staticmethod
    def wanted(
        machine: Machine, config: PlannerConfig, plant: Tolerances
    ) -> CompliantController | None:
        """The one a plant asks for, or a scenario; None for a plant that does what it is told."""
        law = config.gains.law or plant.law
        if law == "exact":
            return None
        controller = CompliantController(machine, config, law == "printed")
        if plant.scatters:
            controller._senses.filter = SensorFilter(config.compliance.filter, plant.late)
            gains = controller._gains  # a foot in the air would follow what scatters
            controller._gains = replace(gains, swing=min(gains.swing, gains.position))
        return controller

    @property
    def slips(self) -> bool:
        """A foot slips, or has just slipped."""
        return self._senses.slips

    def believed(self, sensing: Sensing) -> Sensing:
        """What is believed of a reading, by a body whose centre of gravity is where its loads say.
        A foot that slips is taken note of.
        """
        return self._senses.believed(sensing)

    def take_over(self, old: TrajectoryTracker, left: float) -> None:
        """Another plan begins. What is ``left`` of the old one, s, is walked in its first tick when
        that is all there was to walk in one.
        """
        over = left <= WALKED_IN_A_TICK
        if self._schedule and self._last:
            # what speeding up adds ends with it; the rest is taken over
            moving, resting = self._schedule.at(self._time), self._schedule.resting(self._time)
            parts = zip(self._last, moving, resting, strict=True)
            self._last = tuple(last - a + b for last, a, b in parts)
        self._since = self._schedule.since_landing() if over and self._schedule else {}
        self._rest = None
        if over and self._aims is not None:
            air = old.stretches[-1].air
            ends = zip(body_frame_feet(old, old.duration), self._aims, strict=True)
            self._rest = [
                ZERO if leg in air else _scaled(_minus(end, aim), 1.0 / TICK)
                for leg, (end, aim) in enumerate(ends)
            ]
        self._schedule = None
        self._following = None
        self._aims = None

    def velocities(
        self, tracker: TrajectoryTracker, t_next: float, sensing: Sensing, state: ReflexState
    ) -> tuple[list[Point], ReflexState]:
        """One tick: the feet's velocities in body axes, m/s, that follow the plan to ``t_next``."""
        weight = self._senses.centre.weight
        played = t_next - self._time if self._schedule else min(t_next, TICK)
        wanted = [weight * load for load in self._wanted(tracker, t_next)]
        self.loads = tuple(self._gains.press * load for load in wanted)
        before = self._aims or body_frame_feet(tracker, 0.0)
        aims = body_frame_feet(tracker, t_next)
        self._aims = aims
        ahead = [_scaled(_minus(a, b), 1.0 / TICK) for a, b in zip(aims, before, strict=True)]
        off = [_minus(b, foot) for b, foot in zip(before, sensing.feet_b, strict=True)]
        stretch = tracker.stretches[tracker.stretch(t_next)]
        stand = (*stretch.stand, *_still_down(stretch, t_next, sensing))
        state = _with_landed(state, stretch, sensing)
        landed = [leg for leg in stretch.air if state.landed[leg]]
        swinging = [leg for leg in stretch.air if leg not in stand]
        out = self._followed(ahead, off, swinging)
        if stand:
            if landed or not self._printed:
                self._carry(out, stand, landed, sensing, ahead, off)
            self._level(out, (*stand, *landed), sensing, _tilt(tracker, t_next, sensing))
            _reach(out, (*stand, *landed), sensing, wanted, self._gains.pliancy)
        if self._rest is not None:
            out = [_plus(v, rest) for v, rest in zip(out, self._rest, strict=True)]
            self._rest = None
        x, y, z, turn = (played * rate for rate in tracker.velocity_at(t_next))
        self._senses.expect(out, tracker.bending_at(t_next), (x, y, z, turn))
        return out, state

    def _followed(
        self, ahead: Sequence[Point], off: Sequence[Point], swinging: Collection[int]
    ) -> list[Point]:
        """The plan's velocities, with a share of what every foot is off closed in the tick."""
        gains = self._gains
        shares = (gains.swing if leg in swinging else gains.position for leg in range(len(off)))
        return [
            _plus(v, _scaled(error, share / TICK))
            for v, error, share in zip(ahead, off, shares, strict=True)
        ]

    def foresee(self, following: StepPlan | None) -> None:
        """What is played after the running plan, as soon as it is known."""
        if following is not self._following and following is not None and self._schedule:
            self._schedule.foresee(following)
        self._following = following

    def idle(self, t: float) -> tuple[int, ...]:
        """Legs that carry next to nothing at ``t`` and as soon as loads are shifted after it."""
        if self._schedule is None:
            return ()
        least = IDLE * left_fold_sum(self.loads) / len(self.loads)
        soon = self._schedule.at(t + RAMP)
        both = zip(self.loads, soon, strict=True)
        return tuple(leg for leg, (now, then) in enumerate(both) if max(now, then) < least)

    def presses(self, legs: Sequence[int]) -> bool:
        """True while the loads of the plan before are not all taken over and ``legs`` press."""
        even = left_fold_sum(self.loads) / len(self.loads)
        begins = self._schedule is None or self._blend > 0.0
        return begins and any(self.loads[leg] > UNLOADED * even for leg in legs)

    def _wanted(self, tracker: TrajectoryTracker, t: float) -> Sequence[float]:
        """What the legs are to carry. A plan that begins otherwise than the last one ended takes
        the loads over from it.
        """
        if self._schedule is None:
            self._schedule = LoadSchedule(tracker, self._machine, self._since)
            starts = self._schedule.resting(t)
            last = self._last or starts
            self._offset = [a - b for a, b in zip(last, starts, strict=True)]
            self._blend = 1.0
        wanted = self._schedule.at(t)
        if self._blend > 0.0:
            self._blend = max(0.0, self._blend - TICK / RAMP)
            wanted = tuple(a + self._blend * b for a, b in zip(wanted, self._offset, strict=True))
        self._last = wanted
        self._time = t
        return wanted

    def _carry(
        self,
        out: list[Point],
        stand: Sequence[int],
        landed: Sequence[int],
        sensing: Sensing,
        ahead: Sequence[Point],
        off: Sequence[Point],
    ) -> None:
        """(34), (35): one rigid motion for all that carry, so that they do not pull against each
        other.
        """
        feet = sensing.feet_b
        on = [leg for leg in stand if sensing.soles[leg]] or list(stand)
        closing = RigidMotion.nearest([feet[leg] for leg in on], [off[leg] for leg in on])
        moving = RigidMotion.nearest([feet[leg] for leg in stand], [ahead[leg] for leg in stand])
        k = self._gains.position / TICK
        height = self._gains.height / TICK
        for leg in (*stand, *landed):
            if self._printed and leg in stand:
                continue
            vx, vy, vz = ahead[leg] if leg in stand else moving.at(feet[leg])
            ex, ey, ez = closing.at(feet[leg])
            out[leg] = (vx + k * ex, vy + k * ey, vz + height * ez)

    def _level(
        self, out: list[Point], legs: Sequence[int], sensing: Sensing, tilt: tuple[float, float]
    ) -> None:
        """Second term of (36), C1 (-x θ_p + y θ_r), and as much against the turning itself."""
        c1 = self._gains.posture / TICK
        roll = c1 * tilt[0] + self._gains.rate * sensing.rates[0]
        pitch = c1 * tilt[1] + self._gains.rate * sensing.rates[1]
        for leg in legs:
            x, y, _ = sensing.feet_b[leg]
            vx, vy, vz = out[leg]
            out[leg] = (vx, vy, vz + y * roll - x * pitch)


def _as_printed(gains: Gains) -> Compliance:
    """Weights of (33) to (38) as they stand: nothing pressed, no rates."""
    k = gains.position
    return Compliance(k, k, k, gains.posture, rate=0.0, pliancy=gains.pliancy, press=0.0)


def _with_landed(state: ReflexState, stretch: PlanStretch, sensing: Sensing) -> ReflexState:
    """Early touchdown: a foot on its way down whose sole switches on joins the support."""
    if not stretch.down:
        return state
    return state._replace(
        landed=tuple(
            on or (leg in stretch.air and sensing.soles[leg]) for leg, on in enumerate(state.landed)
        )
    )


class RigidMotion(NamedTuple):
    """A small rigid motion of the body's feet: along x, y, z and turning about a middle."""

    x: float
    y: float
    z: float
    turn: float
    middle: tuple[float, float]

    @staticmethod
    def nearest(spots: Sequence[Point], moves: Sequence[Point]) -> RigidMotion:
        """The one nearest to how so many spots move."""
        n = len(spots)
        cx = left_fold_sum(spot[0] for spot in spots) / n
        cy = left_fold_sum(spot[1] for spot in spots) / n
        mx, my, mz = (left_fold_sum(move[k] for move in moves) / n for k in range(3))
        around = 0.0
        spread = 0.0
        for spot, move in zip(spots, moves, strict=True):
            x = spot[0] - cx
            y = spot[1] - cy
            around += x * (move[1] - my) - y * (move[0] - mx)
            spread += x * x + y * y
        return RigidMotion(mx, my, mz, around / spread if spread > 0.0 else 0.0, (cx, cy))

    def at(self, spot: Point) -> Point:
        """How it moves one spot."""
        x = spot[0] - self.middle[0]
        y = spot[1] - self.middle[1]
        return self.x - self.turn * y, self.y + self.turn * x, self.z


def _still_down(stretch: PlanStretch, t: float, sensing: Sensing) -> list[int]:
    """Legs that carry until the stretch begins, while the plan waits there for one that is to carry
    and hangs.
    """
    hangs = not all(sensing.soles[leg] for leg in stretch.stand)
    return (
        [leg for leg in stretch.air if sensing.soles[leg]] if hangs and t <= stretch.start else []
    )


def _tilt(tracker: TrajectoryTracker, t: float, sensing: Sensing) -> tuple[float, float]:
    """Roll and pitch, rad, beyond what the plan has."""
    _, _, _, roll, pitch, yaw = sensing.body
    wanted = attitude_of(tracker.lean_at(t), yaw) if tracker.leans else (0.0, 0.0)
    return roll - wanted[0], pitch - wanted[1]


def _reach(
    out: list[Point],
    legs: Sequence[int],
    sensing: Sensing,
    loads: Sequence[float],
    pliancy: float,
) -> None:
    """Third term of (36), C2 Δz: legs that carry less than they are to reach down, and the others
    give way as much.
    """
    missing = {leg: _missing(leg, sensing, loads) for leg in legs}
    mean = left_fold_sum(missing.values()) / len(legs)
    for leg in legs:
        x, y, z = out[leg]
        out[leg] = (x, y, z - (missing[leg] - mean) * pliancy / TICK)


def _missing(leg: int, sensing: Sensing, loads: Sequence[float]) -> float:
    """How much of a leg's load is missing, as a share of an even one, from -1 to 1."""
    even = left_fold_sum(loads) / len(loads)
    if even <= 0.0:
        return 0.0
    if not sensing.loads:
        return 0.0 if sensing.soles[leg] or loads[leg] < UNLOADED * even else 1.0
    return max(-1.0, min(1.0, (loads[leg] - sensing.loads[leg]) / even))


def _minus(a: Point, b: Point) -> Point:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _plus(a: Point, b: Point) -> Point:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _scaled(a: Point, k: float) -> Point:
    return k * a[0], k * a[1], k * a[2]
