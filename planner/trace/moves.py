"""From states to moves (K stage two).

``moves_along`` turns a path of states into moves: which legs change, where the body is when they
are lifted and when they are down again. Changes that can be made at once are.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator
from dataclasses import dataclass

from ..geometry.transforms import Body
from ..types import Point
from .reachability import AIR, Feet, Field, first_bit, span
from .state_search import Path

TOGETHER = 3  # legs at most in the air at once by choice, K: k = 1, 2, 3
MOVES_PAUSE = 4  # moves between two yields


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
