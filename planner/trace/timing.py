"""From moves to step plans, from s to time (K stage three).

``step_plan`` gives one move its times: the body keeps the commanded pace where the legs can follow,
and is slower where footholds are far apart. Raising and lowering are vertical in the absolute
frame, the way between is a straight line in body axes; all three run at the speeds of the gait's
profile, and no foot exceeds V.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..geometry.transforms import Body, point_placed, point_seen
from ..motion.step_builder import Feet, plan_from_knots
from ..motion.swing import (
    EVEN,
    Profile,
    aim_of,
    between,
    carry_height,
    peak_of,
    profile_of,
    stairs,
    swing_speeds,
    waiting_place,
)
from ..motion.timing import CLIMB_SHARE
from ..robot.model import Machine
from ..stability import longitudinal_margin, polygon_margin, support_polygon
from ..terrain.map import TerrainMap
from ..types import Gait, Phase, Point, Stance, StepPlan
from .moves import Move

KNOT = 1 / 16  # body lengths of s between knots at most; wider shows as corners on a curve
KNOT_TURN = 0.05  # rad of yaw between knots; wider lets feet leave their rectangles by over 0.3 mm
PAUSE_SPEED = 1e-6  # m; a shorter way is no way
PACE_SHARE = (
    0.9  # of the pace at which a standing foot reaches its speed limit; more leaves it none
)


def body_pace_max(machine: Machine, gait: Gait) -> float:
    """ds/dt at which a standing foot, seen from the body, reaches V/κ at most, m/s: straight on, to
    the side or turning.
    """
    slower = min(machine.speed[0], machine.speed[1])
    return PACE_SHARE * slower / peak_of(gait) / math.sqrt(2.0)


class _Way:
    """The body's way through poses, by the metres gone along it; a turn counts by the machine's
    yaw length.
    """

    def __init__(self, poses: Sequence[Body], machine: Machine) -> None:
        self.poses = poses
        marks = [0.0]
        for a, b in pairwise(poses):
            marks.append(marks[-1] + _apart(a, b, machine.yaw_length))
        self._marks = marks
        self._knot = KNOT * machine.torso[0]

    @property
    def length(self) -> float:
        """m."""
        return self._marks[-1]

    @property
    def steepest(self) -> float:
        """The most the body climbs or sinks per metre of its way."""
        rises = [abs(b[2] - a[2]) for a, b in pairwise(self.poses)]
        ways = [end - start for start, end in pairwise(self._marks)]
        return max(
            (z / s for z, s in zip(rises, ways, strict=True) if s > PAUSE_SPEED), default=0.0
        )

    def pieces(self, start: float, end: float) -> int:
        """Into how many straight lines the stretch between two places is cut."""
        turn = abs(self.poses[-1][3] - self.poses[0][3])
        by_length = math.ceil((end - start) / self._knot - 1e-9)
        by_turn = math.ceil(turn / KNOT_TURN * (end - start) / max(self.length, 1e-9) - 1e-9)
        return max(1, by_length, by_turn)

    def at(self, places: Sequence[float]) -> list[Body]:
        """The poses at these places, m from the start."""
        columns = [[pose[axis] for pose in self.poses] for axis in range(4)]
        x, y, z, yaw = (np.interp(places, self._marks, column).tolist() for column in columns)
        return list(zip(x, y, z, yaw, strict=True))


def _apart(a: Body, b: Body, yaw_length: float) -> float:
    return math.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2 + (yaw_length * (b[3] - a[3])) ** 2)


FeetAt = Callable[[float, Body], Feet]  # at a share of the stretch and a pose of the body


class _Knots:
    """Knots of a step in the making."""

    def __init__(self, stance: Stance) -> None:
        self.times = [0.0]
        self.body: list[Body] = [stance.body]
        self.feet: list[Feet] = [stance.feet]
        self.phases: list[Phase] = []

    def go(
        self,
        way: _Way,
        stretch: tuple[float, float],
        seconds: float,
        phase: Phase,
        feet_at: FeetAt,
        profile: Profile = EVEN,
    ) -> None:
        """One phase: the body at an even pace along a ``stretch`` of its way (m from, to), the feet
        eased by the profile.
        """
        if seconds <= 0.0:
            return
        begin = self.times[-1]
        (start, end) = stretch
        shares = list(stairs(profile, way.pieces(start, end)))
        places = [start + tau * (end - start) for tau, _ in shares]
        poses = way.at([*places[:-1], end])
        for (tau, eased), pose in zip(shares, poses, strict=True):
            self.times.append(begin + seconds * tau)
            self.body.append(pose)
            self.feet.append(feet_at(eased, pose))
            self.phases.append(phase)


def step_plan(
    stance: Stance, move: Move, pace: float, terrain: TerrainMap, machine: Machine, gait: Gait
) -> StepPlan:
    """One move as a step from ``stance``, at ``pace`` (ds/dt, m/s) or as fast as the legs can."""
    top = body_pace_max(machine, gait)
    pace = min(pace, top)
    carried_b = {leg: point_seen(stance.body, stance.feet[leg]) for leg in stance.lifted}
    shift = _Way(move.shift, machine)
    transfer = _Transfer(stance, move, terrain, machine, gait, carried_b)
    fastest = transfer.timed(top, top)
    paced = transfer.timed(pace, top)

    knots = _Knots(stance)
    if shift.length > PAUSE_SPEED:
        stretch = 0.0, shift.length
        standing = _carrying(stance.feet, carried_b)
        knots.go(shift, stretch, shift.length / pace, Phase.SUPPORT, standing)
    transfer.play(paced, knots)

    air = tuple(sorted({*transfer.moving, *stance.lifted}))
    end = _end_of(stance, move, knots)
    total = shift.length + transfer.way.length
    goes = total > PAUSE_SPEED
    return plan_from_knots(
        air,
        knots.times,
        knots.body,
        knots.feet,
        tuple(knots.phases),
        end,
        crab_angle=_course(stance.body, end.body),
        support_shift=shift.length,
        shift=total,
        margin_min=_least_margin(knots, air, stance.lifted),
        speed=total / knots.times[-1] if goes else 0.0,
        speed_max=total / (shift.length / top + fastest.seconds) if goes else 0.0,
        landing=next((foot for leg in move.legs if (foot := move.after[leg]) is not None), None),
    )


def _carrying(feet: Feet, carried_b: dict[int, Point]) -> FeetAt:
    """Feet that stand, but for those in the air, which go with the body."""

    def at(_share: float, body: Body) -> Feet:
        return tuple(
            point_placed(body, carried_b[leg]) if leg in carried_b else foot
            for leg, foot in enumerate(feet)
        )

    return at


def _end_of(stance: Stance, move: Move, knots: _Knots) -> Stance:
    """The stance after a move: feet that moved stand on their footholds, those in the air are where
    the last knot has them.
    """
    feet = list(stance.feet)
    for leg, foot in enumerate(move.after):
        if foot is None:
            feet[leg] = knots.feet[-1][leg]
        elif leg in move.legs:
            feet[leg] = foot
    return replace(
        stance,
        body=knots.body[-1],
        feet=tuple(feet),
        lifted=tuple(leg for leg, foot in enumerate(move.after) if foot is None),
        course=move.course,
        last_swing=move.legs[-1] if move.legs else stance.last_swing,
    )


def _course(start: Body, end: Body) -> float:
    """The crab angle of a step from one pose to another, rad; 0 when it does not travel."""
    dx = end[0] - start[0]
    dy = end[1] - start[1]
    if math.hypot(dx, dy) <= PAUSE_SPEED:
        return 0.0
    return math.remainder(math.atan2(dy, dx) - start[3], 2 * math.pi)


@dataclass(frozen=True, slots=True)
class _FootWay:
    """Where one moving foot goes: absolute corners where it stands or is to stand, body axes where
    it comes from or stays in the air.
    """

    foot: Point
    raised: Point | None = None  # straight above where it stood
    over: Point | None = None  # straight above where it is to stand
    aim: Point | None = None
    from_air_b: Point | None = None
    to_air_b: Point | None = None

    def begin_b(self, body: Body) -> Point:
        """Where the way through the air begins for a body that is at ``body`` then."""
        if self.from_air_b is not None:
            return self.from_air_b
        assert self.raised is not None
        return point_seen(body, self.raised)

    def end_b(self, body: Body) -> Point:
        """Where the way through the air ends for a body that is at ``body`` then."""
        if self.to_air_b is not None:
            return self.to_air_b
        assert self.over is not None
        return point_seen(body, self.over)


class _Timed(NamedTuple):
    """The times of a transfer with the body at some pace."""

    up: float  # s
    carried: float  # s in the air between up and down
    down: float  # s
    up_way: float  # m the body goes meanwhile
    down_way: float  # m
    begin_b: dict[int, Point]  # per moving leg, where its way through the air begins, body axes
    end_b: dict[int, Point]

    @property
    def seconds(self) -> float:
        """Of the whole transfer."""
        return self.up + self.carried + self.down


class _Transfer:
    """The moving legs of one move (K "local prediction"): their ways and how long they take."""

    def __init__(
        self,
        stance: Stance,
        move: Move,
        terrain: TerrainMap,
        machine: Machine,
        gait: Gait,
        carried_b: dict[int, Point],
    ) -> None:
        self.stance = stance
        self.move = move
        self.machine = machine
        self.gait = gait
        self.limits = swing_speeds(machine, gait)
        self.resting_b = {leg: at for leg, at in carried_b.items() if leg not in move.legs}
        self.way = _Way(move.carry, machine)
        self.feet = {leg: self._foot_way(leg, terrain, carried_b) for leg in move.legs}
        rises = [w.raised[2] - w.foot[2] for w in self.feet.values() if w.raised is not None]
        drops = [
            w.over[2] - w.aim[2]
            for w in self.feet.values()
            if w.over is not None and w.aim is not None
        ]
        self.rise = max(rises, default=0.0)
        self.drop = max(drops, default=0.0)
        self.slope = self.way.steepest

    @property
    def moving(self) -> list[int]:
        """Legs that change and are on the ground before or after."""
        before = self.move.before
        after = self.move.after
        return [leg for leg in self.move.legs if before[leg] is not None or after[leg] is not None]

    def _foot_way(self, leg: int, terrain: TerrainMap, carried_b: dict[int, Point]) -> _FootWay:
        move = self.move
        machine = self.machine
        gait = self.gait
        foot = self.stance.feet[leg]
        landing = move.after[leg]
        stood = move.before[leg] is not None
        lowest = min(pose[2] for pose in move.carry)
        ceiling = lowest + machine.legs[leg].z[1] + machine.overreach[2]
        from_air = None if stood else carried_b.get(leg, point_seen(move.carry[0], foot))
        top = ceiling
        if landing is None:
            if terrain.is_level:
                top = min(carry_height(foot, foot, terrain, gait), ceiling)
            raised = (foot[0], foot[1], top)
            waits = waiting_place(machine, leg, gait, terrain)
            return _FootWay(foot, raised, from_air_b=from_air, to_air_b=waits)
        if terrain.is_level or stood:
            start = foot if stood else landing
            top = min(carry_height(start, landing, terrain, gait), ceiling)
        return _FootWay(
            foot,
            (foot[0], foot[1], top) if stood else None,
            (landing[0], landing[1], top),
            aim_of(landing, move.carry[-1][2], leg, machine, gait),
            from_air,
        )

    def timed(self, pace: float, top: float) -> _Timed:
        """Times of the three stretches with the body at ``pace``, slower where the legs need longer
        (never faster than ``top``), m/s.
        """
        length = self.way.length
        if self.slope > 0.0:
            pace = min(pace, CLIMB_SHARE * self.machine.speed[2] / self.slope)
        # what the body climbs or sinks meanwhile is no longer there for the feet
        lifting = self.limits[2] * (1.0 - self.slope * pace / self.machine.speed[2])
        up = self.rise / lifting
        down = self.drop / lifting
        up_way = min(_Way(self.move.rise, self.machine).length, pace * up)
        down_way = min(_Way(self.move.lower, self.machine).length, pace * down)
        if up_way + down_way > length:
            scale = length / (up_way + down_way)
            up_way *= scale
            down_way *= scale
        after_up, before_down = self.way.at([up_way, length - down_way])
        begin_b = {leg: foot.begin_b(after_up) for leg, foot in self.feet.items()}
        end_b = {leg: foot.end_b(before_down) for leg, foot in self.feet.items()}
        need = 0.0
        for leg in self.feet:
            axes = zip(begin_b[leg], end_b[leg], self.limits, strict=True)
            need = max(need, *(abs(q - p) / v for p, q, v in axes))
        way = max(length - up_way - down_way, 0.0)
        carried = max(need, way / top, length / pace - up - down)
        return _Timed(up, carried, down, up_way, down_way, begin_b, end_b)

    def play(self, times: _Timed, knots: _Knots) -> None:
        """Append the stretches up, return, down."""
        profile = profile_of(self.gait)
        phase = Phase.RETURN if self.move.legs or self.resting_b else Phase.SHIFT
        lifted = times.up_way
        lowered = self.way.length - times.down_way
        raising, carrying, lowering = self._motions(times)
        knots.go(self.way, (0.0, lifted), times.up, Phase.UP, raising, profile)
        knots.go(self.way, (lifted, lowered), times.carried, phase, carrying, profile)
        end = self.way.length
        knots.go(self.way, (lowered, end), times.down, Phase.DOWN, lowering, profile)

    def _motions(self, times: _Timed) -> tuple[FeetAt, FeetAt, FeetAt]:
        """Where all feet are while some are raised, carried and lowered."""

        def raising(leg: int, share: float, body: Body) -> Point:
            way = self.feet[leg]
            if way.raised is None or way.from_air_b is not None:
                return point_placed(body, times.begin_b[leg])
            return between(way.foot, way.raised, share)

        def carrying(leg: int, share: float, body: Body) -> Point:
            return point_placed(body, between(times.begin_b[leg], times.end_b[leg], share))

        def lowering(leg: int, share: float, body: Body) -> Point:
            way = self.feet[leg]
            if way.over is None or way.aim is None:
                return point_placed(body, times.end_b[leg])
            return between(way.over, way.aim, share)

        return self._all(raising), self._all(carrying), self._all(lowering)

    def _all(self, moving_at: Callable[[int, float, Body], Point]) -> FeetAt:
        """The moving feet as given, the resting ones with the body, the others where they stand."""

        def at(share: float, body: Body) -> Feet:
            feet = list(self.stance.feet)
            for leg, point_b in self.resting_b.items():
                feet[leg] = point_placed(body, point_b)
            for leg in self.feet:
                feet[leg] = moving_at(leg, share, body)
            return tuple(feet)

        return at


def _least_margin(knots: _Knots, air: tuple[int, ...], lifted: tuple[int, ...]) -> float:
    """Least longitudinal margin on the knots of a step, m; where the body does not travel, least
    distance to an edge.

    ``lifted`` legs are in the air throughout, ``air`` ones while the feet swing. Feet that stand do
    not move, so there are two support polygons.
    """
    first = knots.feet[0]
    swinging, standing = (
        support_polygon([foot for leg, foot in enumerate(first) if leg not in legs])
        for legs in (air, lifted)
    )
    least = math.inf
    for (a, b), phase in zip(pairwise(knots.body), knots.phases, strict=True):
        polygon = standing if phase in (Phase.SUPPORT, Phase.SHIFT) else swinging
        dx = b[0] - a[0]
        dy = b[1] - a[1]
        length = math.hypot(dx, dy)
        for x, y, *_ in (a, b):
            if length > 1e-9:
                least = min(least, longitudinal_margin(polygon, x, y, dx / length, dy / length))
            else:
                least = min(least, polygon_margin(polygon, x, y))
    return least
