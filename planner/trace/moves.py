"""From states to steps, and from s to time (K stages two and three).

``moves_along`` turns a path of states into moves: which legs change, where the body is when they
are lifted and when they are down again. Changes that can be made at once are. ``step_plan`` gives
one move its times: the body keeps the commanded pace where the legs can follow, and is slower where
footholds are far apart; no foot exceeds V/κ.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..geometry.transforms import Body, point_placed, point_seen
from ..motion.step_builder import plan_from_knots
from ..motion.swing import (
    aim_of,
    between,
    carry_height,
    peak,
    profile_of,
    swing_speeds,
    waiting_place,
)
from ..robot.model import Machine
from ..stability import longitudinal_margin, polygon_margin, support_polygon
from ..terrain.map import TerrainMap
from ..types import Gait, Phase, Point, Stance, StepPlan
from .reachability import AIR, Feet, Field, first_bit, span
from .state_search import Path

TOGETHER = 3  # legs at most in the air at once by choice, K: k = 1, 2, 3
KNOT = 1 / 16  # body lengths of s between knots at most; wider shows as corners on a curve
KNOT_TURN = 0.05  # rad of yaw between knots; wider lets feet leave their rectangles by over 0.3 mm
MOVES_PAUSE = 4  # moves between two yields
PAUSE_SPEED = 1e-6  # m; a shorter way is no way


@dataclass(frozen=True, slots=True)
class Move:
    """One change of state in absolute terms: the legs that change, and the body's way before, while
    and after they do.
    """

    legs: tuple[int, ...]
    before: tuple[Point | None, ...]  # feet on the ground before, None in the air
    after: tuple[Point | None, ...]
    shift: tuple[Body, ...]  # the body's way with all these feet down; at least one pose
    rise: tuple[Body, ...]  # while the legs are raised
    carry: tuple[Body, ...]  # while they are carried
    lower: tuple[Body, ...]  # while they are lowered
    course: float  # s on the trace at the end, m
    # existence segment of each foothold after, s on the trace, m
    segments: tuple[tuple[float, float] | None, ...]


class _Node:
    """A state of the path and the samples it may be used in."""

    __slots__ = ("feet", "place")

    def __init__(self, feet: Feet, place: int) -> None:
        self.feet, self.place = feet, place


def moves_along(
    field: Field, path: Path, offset: float, step: float, together: int = 2 * TOGETHER
) -> Generator[None, None, tuple[Move, ...]]:
    """The path of states as moves; ``offset`` is s at the field's first sample, ``together`` how
    many states one move may span.

    Yields move by move, so that a caller may spread it over ticks.
    """
    if not path.states:
        return ()
    nodes = [
        _Node(state.feet, field.place(field.valid(state.feet), state.at)) for state in path.states
    ]
    yield
    merged = yield from _merge(field, nodes, together)
    chosen = _samples(field, merged, path)
    yield
    at = chosen[-1][4] if chosen else path.states[0].at
    end = _pick(field, nodes[-1].place, at % field.width, path.farthest)
    moves: list[Move] = []
    for found in chosen:
        moves += _in_space(field, found, offset, step)
        if len(moves) % MOVES_PAUSE == 0:
            yield
    if end % field.width > at % field.width:
        moves.append(_shift(field, nodes[-1], at, end, offset, step))
    return tuple(moves)


def _merge(
    field: Field, nodes: list[_Node], together: int
) -> Generator[None, None, list[tuple[_Node, int, int, _Node]]]:
    """Skip states that can be passed over: from each on to the farthest of the next few reachable
    in one move.
    """
    moves: list[tuple[_Node, int, int, _Node]] = []
    k = 0
    while k < len(nodes) - 1:
        best = None
        if len(moves) % MOVES_PAUSE == MOVES_PAUSE - 1:
            yield
        for j in range(k + 1, min(k + together + 1, len(nodes))):
            windows = _windows(field, nodes[k], nodes[j])
            if windows is not None:
                best = j, windows
        if best is None:
            raise RuntimeError(f"states {k} and {k + 1} of the path do not overlap")
        j, (lifting, placing) = best
        moves.append((nodes[k], lifting, placing, nodes[j]))
        k = j
    return moves


def _windows(field: Field, a: _Node, b: _Node) -> tuple[int, int] | None:
    """Samples at which the legs that differ may be lifted, and those at which they may be down
    again.
    """
    changed = [leg for leg, (f, g) in enumerate(zip(a.feet, b.feet, strict=True)) if f != g]
    if len(changed) > TOGETHER:
        return None
    carried = field.between(a.feet, b.feet)
    lifting, placing = a.place & carried, b.place & carried
    while lifting and placing:
        whole = field.place(carried, first_bit(lifting))
        if placing & whole:
            return lifting & whole, placing & whole
        lifting &= ~whole
    return None


def _samples(
    field: Field, moves: list[tuple[_Node, int, int, _Node]], path: Path
) -> list[tuple[_Node, _Node, int, int, int]]:
    """Where the body is at each lift and each landing: onward at an even pace as far as the windows
    allow.
    """
    top = field.count - 1
    latest, bound = [0] * len(moves), top
    for n in range(len(moves) - 1, -1, -1):
        _, lifting, placing, _ = moves[n]
        latest[n] = _highest(field, placing, bound)
        bound = _highest(field, lifting, latest[n])
    out, at = [], path.states[0].at
    for n, (a, lifting, placing, b) in enumerate(moves):
        k = at % field.width
        lift = _pick(field, lifting, k, k)
        even = k + max(latest[-1] - k, 0) / (len(moves) - n)
        land = _pick(field, placing, lift % field.width, min(even, latest[n]))
        out.append((a, b, at, lift, land))
        at = land
    return out


def _highest(field: Field, mask: int, bound: int) -> int:
    """The last sample of the trace up to ``bound`` in any row of the mask, else its first beyond."""
    best, least = -1, field.count
    row_mask = (1 << field.width) - 1
    for r in range(field.rows):
        row = mask >> (r * field.width) & row_mask
        if row:
            below = row & span(0, bound)
            best = max(best, below.bit_length() - 1)
            least = min(least, (row & -row).bit_length() - 1)
    return best if best >= 0 else least


def _pick(field: Field, mask: int, low: int, target: float) -> int:
    """The sample of the mask nearest to ``target``, never behind ``low`` if that can be, near the
    trace.
    """
    best, least = -1, math.inf
    row_mask = (1 << field.width) - 1
    aim = int(target)
    for r in range(field.rows):
        row = mask >> (r * field.width) & row_mask
        if not row:
            continue
        candidates = []
        below, above = row & span(0, aim), row >> (aim + 1)
        if below:
            candidates.append(below.bit_length() - 1)
        if above:
            candidates.append(aim + (above & -above).bit_length())
        for k in candidates:
            cost = abs(k - aim) + (10 * (low - k) if k < low else 0) + 4 * ((r + 1) // 2)
            if cost < least:
                best, least = r * field.width + k, cost
    return best


# where that is


def _in_space(
    field: Field, move: tuple[_Node, _Node, int, int, int], offset: float, step: float
) -> Iterator[Move]:
    """A move of legs; with a leg waiting in the air, the body's way there is a move of its own
    (nothing else lifts in it).
    """
    a, b, start, lift, land = move
    shift = tuple(_pose(field, sample) for sample in _way(field, a.place, start, lift))
    if AIR in a.feet and start != lift:
        yield _shift(field, a, start, lift, offset, step)
        shift = shift[-1:]
    legs = tuple(leg for leg, (f, g) in enumerate(zip(a.feet, b.feet, strict=True)) if f != g)
    way = _way(field, field.between(a.feet, b.feet), lift, land)
    rising = lowering = field.everywhere
    for leg in legs:
        if a.feet[leg] >= 0:
            rising &= field.reach[a.feet[leg]]
        if b.feet[leg] >= 0:
            lowering &= field.reach[b.feet[leg]]
    up = 0
    while up + 1 < len(way) and rising >> way[up + 1] & 1:
        up += 1
    down = len(way) - 1
    while down > 0 and lowering >> way[down - 1] & 1:
        down -= 1
    poses = [_pose(field, sample) for sample in way]
    before, after = _points(field, a.feet), _points(field, b.feet)
    yield Move(
        legs, before, after,
        shift=shift,
        rise=tuple(poses[: up + 1]), carry=tuple(poses), lower=tuple(poses[down:]),
        course=offset + land % field.width * step,
        segments=tuple(_segment(field, f, land, offset, step) for f in b.feet),
    )  # fmt: skip


def _shift(field: Field, node: _Node, start: int, end: int, offset: float, step: float) -> Move:
    """The body alone moves on, every foot staying as it is."""
    feet = _points(field, node.feet)
    way = tuple(_pose(field, sample) for sample in _way(field, node.place, start, end))
    segments = tuple(_segment(field, f, end, offset, step) for f in node.feet)
    return Move(
        (), feet, feet, way[:1], way[:1], way, way[-1:], offset + end % field.width * step, segments
    )


def _points(field: Field, feet: Feet) -> tuple[Point | None, ...]:
    return tuple(
        None if f < 0 else (field.holds[f].x, field.holds[f].y, field.holds[f].z) for f in feet
    )


def _segment(
    field: Field, f: int, sample: int, offset: float, step: float
) -> tuple[float, float] | None:
    if f < 0:
        return None
    run = field.place(field.reach[f], sample) if field.rows == 1 else field.reach[f]
    first, last = (run & -run).bit_length() - 1, field.farthest(run)
    return offset + first % field.width * step, offset + last * step


def _way(field: Field, mask: int, start: int, end: int) -> list[int]:
    """Samples the body passes from start to end inside the mask: along a row, and across rows where
    it must.
    """
    if start == end:
        return [start]
    width = field.width
    if start // width == end // width:
        between = list(range(start, end + 1)) if end > start else list(range(start, end - 1, -1))
        if all(mask >> sample & 1 for sample in between):
            return between
    came: dict[int, int] = {start: start}
    edge = [start]
    while edge and end not in came:
        nxt = []
        for sample in edge:
            for other in (
                sample + 1,
                sample - 1,
                *(sample + r * width for r in range(1 - field.rows, field.rows) if r),
            ):
                if other >= 0 and other not in came and mask >> other & 1:
                    came[other] = sample
                    nxt.append(other)
        edge = nxt
    if end not in came:
        raise RuntimeError(
            f"no way for the body from sample {start} to {end}: the states do not overlap"
        )
    way = [end]
    while way[-1] != start:
        way.append(came[way[-1]])
    return way[::-1]


def _pose(field: Field, sample: int) -> Body:
    r, k = divmod(sample, field.width)
    lane = field.lane
    return float(lane.x[r, k]), float(lane.y[r, k]), float(lane.z[k]), float(lane.yaw[k])


# times


def _length(poses: Sequence[Body], yaw_length: float) -> float:
    return sum(_apart(a, b, yaw_length) for a, b in zip(poses, poses[1:], strict=False))


def _apart(a: Body, b: Body, yaw_length: float) -> float:
    return math.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2 + (yaw_length * (b[3] - a[3])) ** 2)


def _part(poses: Sequence[Body], start: float, end: float, machine: Machine) -> list[Body]:
    """Bodys from ``start`` to ``end`` metres along a way, both ends included, knots no wider apart
    than needed.
    """
    marks = [0.0]
    for a, b in zip(poses, poses[1:], strict=False):
        marks.append(marks[-1] + _apart(a, b, machine.yaw_length))
    turn = abs(poses[-1][3] - poses[0][3])
    by_length = math.ceil((end - start) / (KNOT * machine.torso[0]) - 1e-9)
    by_turn = math.ceil(turn / KNOT_TURN * (end - start) / max(marks[-1], 1e-9) - 1e-9)
    count = max(1, by_length, by_turn)
    columns = [[pose[axis] for pose in poses] for axis in range(4)]
    at = np.linspace(start, end, count + 1)
    x, y, z, yaw = (np.interp(at, marks, column).tolist() for column in columns)
    return list(zip(x, y, z, yaw, strict=True))


def body_pace_max(machine: Machine, gait: Gait) -> float:
    """ds/dt at which a standing foot, seen from the body, reaches V/κ at most: straight on, to the
    side or turning.
    """
    return 0.9 * min(machine.speed[0], machine.speed[1]) / peak(profile_of(gait)) / math.sqrt(2.0)


@dataclass(slots=True)
class _Knots:
    """Knots of a step in the making."""

    times: list[float]
    body: list[Body]
    feet: list[tuple[Point, ...]]
    phases: list[Phase]

    def go(self, poses: Sequence[Body], seconds: float, phase: Phase, feet_at: Any) -> None:
        """One phase: the body along ``poses`` at an even pace, the feet as ``feet_at(part, pose)``
        has them.
        """
        if seconds <= 0.0:
            return
        begin, parts = self.times[-1], len(poses) - 1
        if parts == 0:
            poses, parts = (poses[0], poses[0]), 1
        for n, pose in enumerate(poses[1:], 1):
            self.times.append(begin + seconds * n / parts)
            self.body.append(pose)
            self.feet.append(feet_at(n / parts, pose))
            self.phases.append(phase)


def step_plan(
    stance: Stance, move: Move, pace: float, terrain: TerrainMap, machine: Machine, gait: Gait
) -> StepPlan:
    """One move as a step from ``stance``, at ``pace`` (ds/dt, m/s) or as fast as the legs can."""
    rho = machine.yaw_length
    limits = swing_speeds(machine, gait)
    top = body_pace_max(machine, gait)
    lifted = stance.lifted
    resting = _carried_b(stance)
    moving = [
        leg for leg in move.legs if move.before[leg] is not None or move.after[leg] is not None
    ]
    shift_length, swing_length = _length(move.shift, rho), _length(move.carry, rho)
    swing = _Swing(stance, move, terrain, machine, gait, limits, resting)
    fastest = swing.timed(swing_length, top, top)
    paced = swing.timed(swing_length, min(pace, top), top)
    total = shift_length + swing_length
    least = shift_length / top + fastest.seconds
    pace = min(pace, top)

    air = tuple(sorted({*moving, *lifted}))
    knots = _Knots([0.0], [stance.body], [stance.feet], [])
    still = list(stance.feet)

    def standing(part: float, pose: Body) -> tuple[Point, ...]:
        return tuple(
            point_placed(pose, resting[leg]) if leg in resting else foot
            for leg, foot in enumerate(still)
        )

    ways = _part(move.shift, 0.0, shift_length, machine) if shift_length > PAUSE_SPEED else []
    if ways:
        knots.go(ways, shift_length / pace, Phase.SUPPORT, standing)
    paced.play(knots)
    after_lifted = tuple(leg for leg, foot in enumerate(move.after) if foot is None)
    end_feet = tuple(
        knots.feet[-1][leg] if foot is None else foot if leg in move.legs else stance.feet[leg]
        for leg, foot in enumerate(move.after)
    )
    end_body = knots.body[-1]
    seconds = knots.times[-1]
    end = replace(
        stance, body=end_body, feet=end_feet, lifted=after_lifted, course=move.course,
        last_swing=move.legs[-1] if move.legs else stance.last_swing,
    )  # fmt: skip
    heading = math.atan2(end_body[1] - stance.body[1], end_body[0] - stance.body[0])
    travelled = math.hypot(end_body[0] - stance.body[0], end_body[1] - stance.body[1])
    landing = next((move.after[leg] for leg in move.legs if move.after[leg] is not None), None)
    return plan_from_knots(
        air,
        knots.times,
        knots.body,
        knots.feet,
        tuple(knots.phases),
        end,
        crab_angle=math.remainder(heading - stance.body[3], 2 * math.pi)
        if travelled > 1e-6
        else 0.0,
        support_shift=shift_length,
        shift=total,
        margin_min=_least_margin(knots, air, lifted),
        speed=total / seconds if total > PAUSE_SPEED else 0.0,
        speed_max=total / least if total > PAUSE_SPEED else 0.0,
        landing=landing,
    )


def _carried_b(stance: Stance) -> dict[int, Point]:
    """Feet in the air, in body axes: they go with the body until their turn comes."""
    return {leg: point_seen(stance.body, stance.feet[leg]) for leg in stance.lifted}


class _Swing:
    """The moving legs of one move: their ways in body axes and how long they take."""

    def __init__(
        self, stance: Stance, move: Move, terrain: TerrainMap, machine: Machine, gait: Gait, limits: tuple[float, ...],
        resting: dict[int, Point],
    ) -> None:  # fmt: skip
        self.stance, self.move, self.machine, self.gait, self.limits = (
            stance,
            move,
            machine,
            gait,
            limits,
        )
        self.resting = {leg: point for leg, point in resting.items() if leg not in move.legs}
        self.raised: dict[int, Point] = {}  # absolute, straight above where the leg stood
        self.over: dict[int, Point] = {}  # absolute, straight above where it is to stand
        self.aims: dict[int, Point] = {}
        self.from_air: dict[int, Point] = {}  # body axes
        self.to_air: dict[int, Point] = {}
        for leg in move.legs:
            self._prepare(leg, terrain, resting)
        self.up = (
            max((self.raised[leg][2] - stance.feet[leg][2] for leg in self.raised), default=0.0)
            / limits[2]
        )
        self.down = (
            max((self.over[leg][2] - self.aims[leg][2] for leg in self.over), default=0.0)
            / limits[2]
        )

    def _prepare(self, leg: int, terrain: TerrainMap, resting: dict[int, Point]) -> None:
        move, foot, landing = self.move, self.stance.feet[leg], self.move.after[leg]
        start, end = move.carry[0], move.carry[-1]
        ceiling = (
            min(pose[2] for pose in move.carry)
            + self.machine.legs[leg].z[1]
            + self.machine.overreach[2]
        )
        if move.before[leg] is None:
            self.from_air[leg] = resting.get(leg, point_seen(start, foot))
        if landing is None:
            self.to_air[leg] = waiting_place(self.machine, leg, self.gait, terrain)
            top = carry_height(foot, foot, terrain, self.gait) if terrain.is_level else ceiling
            self.raised[leg] = (foot[0], foot[1], min(top, ceiling))
            return
        top = ceiling
        if terrain.is_level or move.before[leg] is not None:
            top = min(
                carry_height(
                    foot if move.before[leg] is not None else landing, landing, terrain, self.gait
                ),
                ceiling,
            )
        self.over[leg] = (landing[0], landing[1], top)
        self.aims[leg] = aim_of(landing, end[2], leg, self.machine, self.gait)
        if move.before[leg] is not None:
            self.raised[leg] = (foot[0], foot[1], top)

    def timed(self, length: float, pace: float, top: float) -> _Timed:
        """Times of the three phases with the body at ``pace``, slower where the legs need longer."""
        rho = self.machine.yaw_length
        rise, lower = _length(self.move.rise, rho), _length(self.move.lower, rho)
        up_way, down_way = min(rise, pace * self.up), min(lower, pace * self.down)
        if up_way + down_way > length:
            scale = length / (up_way + down_way)
            up_way, down_way = up_way * scale, down_way * scale
        after_up = _part(self.move.carry, 0.0, up_way, self.machine)[-1]
        before_down = _part(self.move.carry, 0.0, length - down_way, self.machine)[-1]
        need = 0.0
        for leg in self.move.legs:
            a = (
                self.from_air[leg]
                if leg in self.from_air
                else point_seen(after_up, self.raised[leg])
            )
            b = self.to_air[leg] if leg in self.to_air else point_seen(before_down, self.over[leg])
            need = max(need, *(abs(q - p) / v for p, q, v in zip(a, b, self.limits, strict=True)))
        way = max(length - up_way - down_way, 0.0)
        carried = max(need, way / top, length / pace - self.up - self.down)
        return _Timed(self, length, up_way, down_way, carried)


@dataclass(slots=True)
class _Timed:
    swing: _Swing
    length: float
    up_way: float
    down_way: float
    carried: float  # s in the air between up and down

    @property
    def seconds(self) -> float:
        return self.swing.up + self.carried + self.swing.down

    def play(self, knots: _Knots) -> None:
        """Append the phases up, return, down."""
        swing, move = self.swing, self.swing.move
        still = swing.stance.feet
        after_up = _part(move.carry, 0.0, self.up_way, swing.machine)
        carry = _part(move.carry, self.up_way, self.length - self.down_way, swing.machine)
        lower = _part(move.carry, self.length - self.down_way, self.length, swing.machine)
        start_b, end_b = {}, {}
        for leg in move.legs:
            start_b[leg] = (
                swing.from_air[leg]
                if leg in swing.from_air
                else point_seen(after_up[-1], swing.raised[leg])
            )
            end_b[leg] = (
                swing.to_air[leg] if leg in swing.to_air else point_seen(carry[-1], swing.over[leg])
            )

        def feet(leg_at: Any) -> Any:
            def at(part: float, pose: Body) -> tuple[Point, ...]:
                out = []
                for leg, foot in enumerate(still):
                    if leg in move.legs:
                        out.append(leg_at(leg, part, pose))
                    else:
                        out.append(
                            point_placed(pose, swing.resting[leg]) if leg in swing.resting else foot
                        )
                return tuple(out)

            return at

        def rising(leg: int, part: float, pose: Body) -> Point:
            if leg not in swing.raised or leg in swing.from_air:
                return point_placed(pose, start_b[leg])
            return between(still[leg], swing.raised[leg], part)

        def returning(leg: int, part: float, pose: Body) -> Point:
            return point_placed(pose, between(start_b[leg], end_b[leg], part))

        def lowering(leg: int, part: float, pose: Body) -> Point:
            if leg not in swing.over:
                return point_placed(pose, end_b[leg])
            return between(swing.over[leg], swing.aims[leg], part)

        knots.go(after_up, swing.up, Phase.UP, feet(rising))
        knots.go(
            carry,
            self.carried,
            Phase.RETURN if move.legs or swing.resting else Phase.SHIFT,
            feet(returning),
        )
        knots.go(lower, swing.down, Phase.DOWN, feet(lowering))


def _least_margin(knots: _Knots, air: tuple[int, ...], lifted: tuple[int, ...]) -> float:
    """Least longitudinal margin on the knots of a step, m; where the body does not travel, least
    distance to an edge.
    """
    least = math.inf
    for k, phase in enumerate(knots.phases):
        legs = lifted if phase in (Phase.SUPPORT, Phase.SHIFT) else air
        polygon = support_polygon(
            [foot for leg, foot in enumerate(knots.feet[k]) if leg not in legs]
        )
        a, b = knots.body[k], knots.body[k + 1]
        dx, dy = b[0] - a[0], b[1] - a[1]
        length = math.hypot(dx, dy)
        for x, y, *_ in (a, b):
            if length > 1e-9:
                least = min(least, longitudinal_margin(polygon, x, y, dx / length, dy / length))
            else:
                least = min(least, polygon_margin(polygon, x, y))
    return least
