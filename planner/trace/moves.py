"""From states to moves (K stage two).

``moves_along`` turns a path of states into moves: which legs change, where the body is when they
are lifted and when they are down again. Changes that can be made at once are.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ..geometry.transforms import Body
from ..protocols import Weight
from ..types import Point
from .footholds import AIR, Footing
from .leg_clearance import LegClearance, Swing
from .reachability import Reachability
from .samples import SampleGrid, first_bit, span
from .state_search import StatePath

TOGETHER = 3  # legs at most in the air at once by choice, K: k = 1, 2, 3
MOVES_PAUSE = 4  # moves between two yields
BEHIND_COST = 10  # samples off the target that one sample backwards counts for
ROW_COST = 4  # samples off the target that a row beside the trace counts for


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


class _Node(NamedTuple):
    """A state of the path and the samples it may be used in."""

    feet: Footing
    part: int


class _Change(NamedTuple):
    """From one state to another: samples at which its legs may be lifted, and at which they may be
    down again.
    """

    before: _Node
    lifting: int
    placing: int
    after: _Node


class _Timed(NamedTuple):
    """A change with the samples of the body at its start, at the lift and at the landing."""

    change: _Change
    start: int
    lift: int
    land: int


def moves_along(
    reachable: Reachability,
    path: StatePath,
    offset: float,
    step: float,
    together: int = 2 * TOGETHER,
) -> Generator[Weight, None, tuple[Move, ...]]:
    """The path of states as moves; ``offset`` is s at the first sample and ``step`` from one to the
    next, m; ``together`` how many states one move may span.

    Yields move by move, so that a caller may spread it over ticks. Raises ``RuntimeError`` for
    states that do not overlap.
    """
    if not path.states:
        return ()
    samples = reachable.samples
    nodes = [
        _Node(state.feet, samples.unbroken(reachable.valid(state.feet), state.at))
        for state in path.states
    ]
    yield None
    changes = yield from _merged(reachable, nodes, together)
    timed = _timed(samples, changes, path)
    yield None
    at = timed[-1].land if timed else path.states[0].at
    end = _pick(samples, nodes[-1].part, at % samples.width, path.farthest)
    space = _Space(reachable, offset, step)
    moves: list[Move] = []
    for found in timed:
        moves += space.moves(found)
        if len(moves) % MOVES_PAUSE == 0:
            yield None
    if end % samples.width > at % samples.width:
        moves.append(space.shift(nodes[-1], at, end))
    return tuple(moves)


def up_to_what_is_met(
    moves: Sequence[Move], legs: LegClearance
) -> tuple[int, tuple[int, Point] | None]:
    """How many moves can be made, up to one after which every leg stands, before a leg sweeps
    through something tall; and which leg that is, with where it would land.
    """
    if not legs.matters:
        return len(moves), None
    standing = 0
    for number, move in enumerate(moves):
        for leg in move.legs:
            stood, lands = move.before[leg], move.after[leg]
            if stood is None or lands is None:
                continue
            if legs.sweeps_through(leg, Swing(stood, lands, move.carry)):
                return standing, (leg, lands)
        if None not in move.after:
            standing = number + 1
    return len(moves), None


def _merged(
    reachable: Reachability, nodes: list[_Node], together: int
) -> Generator[Weight, None, list[_Change]]:
    """Skip states that can be passed over: from each on to the farthest of the next few reachable
    in one move.
    """
    changes: list[_Change] = []
    k = 0
    while k < len(nodes) - 1:
        best = None
        if len(changes) % MOVES_PAUSE == MOVES_PAUSE - 1:
            yield None
        for j in range(k + 1, min(k + together + 1, len(nodes))):
            # legs that the search itself moves together are as many as its gait has
            if j > k + 1 and len(_differing(nodes[k].feet, nodes[j].feet)) > TOGETHER:
                continue
            change = _change(reachable, nodes[k], nodes[j])
            if change is not None:
                best = j, change
        if best is None:
            raise RuntimeError(f"states {k} and {k + 1} of the path do not overlap")
        k, change = best
        changes.append(change)
    return changes


def _change(reachable: Reachability, a: _Node, b: _Node) -> _Change | None:
    """The change from one state to another in one move, None where it cannot be."""
    carried = reachable.between(a.feet, b.feet)
    lifting = a.part & carried
    placing = b.part & carried
    while lifting and placing:
        whole = reachable.samples.unbroken(carried, first_bit(lifting))
        if placing & whole:
            return _Change(a, lifting & whole, placing & whole, b)
        lifting &= ~whole
    return None


def _differing(feet: Footing, after: Footing) -> tuple[int, ...]:
    """Legs that change."""
    pairs = zip(feet, after, strict=True)
    return tuple(leg for leg, (f, g) in enumerate(pairs) if f != g)


def _timed(samples: SampleGrid, changes: list[_Change], path: StatePath) -> list[_Timed]:
    """Where the body is at each lift and each landing: onward at an even pace as far as the windows
    allow.
    """
    latest = [0] * len(changes)
    bound = samples.count - 1
    for n in range(len(changes) - 1, -1, -1):
        latest[n] = _highest(samples, changes[n].placing, bound)
        bound = _highest(samples, changes[n].lifting, latest[n])
    timed = []
    at = path.states[0].at
    for n, change in enumerate(changes):
        k = at % samples.width
        lift = _pick(samples, change.lifting, k, k)
        even = k + max(latest[-1] - k, 0) / (len(changes) - n)
        land = _pick(samples, change.placing, lift % samples.width, min(even, latest[n]))
        timed.append(_Timed(change, at, lift, land))
        at = land
    return timed


def _highest(samples: SampleGrid, mask: int, bound: int) -> int:
    """The last sample up to ``bound`` in any row of the mask, else its first beyond."""
    best = -1
    least = samples.count
    for r in range(samples.rows):
        row = samples.row_of(mask, r)
        if row:
            below = row & span(0, bound)
            best = max(best, below.bit_length() - 1)
            least = min(least, first_bit(row))
    return best if best >= 0 else least


def _pick(samples: SampleGrid, mask: int, low: int, target: float) -> int:
    """The sample of the mask nearest to ``target``, never behind ``low`` if that can be, near the
    trace.
    """
    best = -1
    least = math.inf
    aim = int(target)
    for r in range(samples.rows):
        row = samples.row_of(mask, r)
        candidates = []
        if below := row & span(0, aim):
            candidates.append(below.bit_length() - 1)
        if above := row >> (aim + 1):
            candidates.append(aim + 1 + first_bit(above))
        for k in candidates:
            behind = BEHIND_COST * (low - k) if k < low else 0
            cost = abs(k - aim) + behind + ROW_COST * ((r + 1) // 2)
            if cost < least:
                best = r * samples.width + k
                least = cost
    return best


class _Space:
    """States and samples as points and poses of the absolute frame."""

    def __init__(self, reachable: Reachability, offset: float, step: float) -> None:
        self.reachable = reachable
        self.offset = offset  # s at the first sample, m
        self.step = step  # m of s between samples

    def moves(self, timed: _Timed) -> Iterator[Move]:
        """A move of legs; with a leg waiting in the air, the body's way there is a move of its own
        (nothing else lifts in it).
        """
        samples = self.reachable.samples
        before, _, _, after = timed.change
        shift = self._poses(samples.way(before.part, timed.start, timed.lift))
        if AIR in before.feet and timed.start != timed.lift:
            yield self.shift(before, timed.start, timed.lift)
            shift = shift[-1:]
        way = samples.way(self.reachable.between(*_feet(timed.change)), timed.lift, timed.land)
        up, down = self._raised_and_lowered(timed.change, way)
        poses = self._poses(way)
        yield Move(
            _differing(before.feet, after.feet),
            self._points(before.feet),
            self._points(after.feet),
            shift=shift,
            rise=poses[: up + 1],
            carry=poses,
            lower=poses[down:],
            course=self._course(timed.land),
            segments=self._segments(after.feet, timed.land),
        )

    def shift(self, node: _Node, start: int, end: int) -> Move:
        """The body alone moves on, every foot staying as it is."""
        feet = self._points(node.feet)
        way = self._poses(self.reachable.samples.way(node.part, start, end))
        segments = self._segments(node.feet, end)
        return Move((), feet, feet, way[:1], way[:1], way, way[-1:], self._course(end), segments)

    def _raised_and_lowered(self, change: _Change, way: list[int]) -> tuple[int, int]:
        """How far along the way the feet lifted are still in reach of where they stood, and from
        where on they are in reach of where they will stand.
        """
        existence = self.reachable.existence
        rising = lowering = self.reachable.clearance.torso_room
        for f, g in zip(*_feet(change), strict=True):
            if f != g and f >= 0:
                rising &= existence[f]
            if f != g and g >= 0:
                lowering &= existence[g]
        up = 0
        while up + 1 < len(way) and rising >> way[up + 1] & 1:
            up += 1
        down = len(way) - 1
        while down > 0 and lowering >> way[down - 1] & 1:
            down -= 1
        return up, down

    def _points(self, feet: Footing) -> tuple[Point | None, ...]:
        holds = self.reachable.footholds
        return tuple(None if f < 0 else (holds[f].x, holds[f].y, holds[f].z) for f in feet)

    def _poses(self, way: list[int]) -> tuple[Body, ...]:
        lane = self.reachable.lane
        poses = []
        for sample in way:
            r, k = divmod(sample, self.reachable.samples.width)
            pose = float(lane.x[r, k]), float(lane.y[r, k]), float(lane.z[k]), float(lane.yaw[k])
            poses.append(pose)
        return tuple(poses)

    def _course(self, sample: int) -> float:
        return self.offset + sample % self.reachable.samples.width * self.step

    def _segments(self, feet: Footing, sample: int) -> tuple[tuple[float, float] | None, ...]:
        return tuple(None if f < 0 else self._segment(f, sample) for f in feet)

    def _segment(self, f: int, sample: int) -> tuple[float, float]:
        """The existence segment of a foothold around a sample, in m of s."""
        samples = self.reachable.samples
        run = self.reachable.existence[f]
        if samples.rows == 1:
            run = samples.unbroken(run, sample)
        return self._course(first_bit(run)), self.offset + samples.farthest(run) * self.step


def _feet(change: _Change) -> tuple[Footing, Footing]:
    return change.before.feet, change.after.feet
