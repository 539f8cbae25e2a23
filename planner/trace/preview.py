"""What a prediction foresees, for viewers: the trace ahead, the footholds on it, and K's chart of
existence segments.
"""

from __future__ import annotations

import math

import numpy as np

from ..geometry.paths import EDGE, SampledPath
from ..geometry.transforms import directions, left_fold_sum
from ..robot.model import Machine
from ..types import GaitPreview, Point, Stance, StepPlan
from .moves import Move
from .planner import TraceWalk
from .prediction import Prediction, index_of

LINE_STEP = 0.05  # m of s between points of the line; wider and a curve shows corners
BEYOND = 3.0  # body lengths of a given trace shown beyond the prediction

Bar = tuple[float, float, float, float]


def ahead(walk: TraceWalk, stance: Stance, running: StepPlan | None) -> GaitPreview | None:
    """What ``walk`` foresees from ``stance``, the last N_k, where ``running`` begins; None while it
    foresees nothing.
    """
    known = walk.prediction
    if known is not None:
        n = index_of(known, stance)
        if n is not None:
            return _foreseen(known, n, stance, walk.machine, {})
        n = None if running is None else index_of(known, running.end)
        # made while the step runs: it begins where the step ends
        if n is not None and running is not None:
            return _foreseen(known, n, running.end, walk.machine, _leaving(stance, running))
    if walk.course is None:
        return None
    line = _line(walk.course, stance.course, walk.course.length, 0.0)
    count = len(walk.machine.legs)
    return GaitPreview(
        line, ((),) * count, ((),) * count, (), stance.course, stance.course, True, ""
    )


def course_now(
    stance: Stance, running: StepPlan | None, body: tuple[float, ...], yaw_length: float
) -> float:
    """s of the body on its trace, m: within a step by how far it has got from its start."""
    if running is None:
        return stance.course
    end = running.end
    whole = _apart(stance.body, end.body, yaw_length)
    if whole < 1e-6:
        return end.course
    part = _apart(stance.body, body, yaw_length) / whole
    return stance.course + min(part, 1.0) * (end.course - stance.course)


def _apart(a: tuple[float, ...], b: tuple[float, ...], yaw_length: float) -> float:
    """Distance of two bodies x, y, z, yaw, heights left out."""
    return math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (yaw_length * (a[3] - b[3])) ** 2)


def _length(poses: tuple[tuple[float, ...], ...], yaw_length: float) -> float:
    pairs = zip(poses, poses[1:], strict=False)
    return left_fold_sum(_apart(a, b, yaw_length) for a, b in pairs)


def _foreseen(
    known: Prediction, n: int, stance: Stance, machine: Machine, leaving: dict[int, Bar]
) -> GaitPreview:
    """What a prediction holds from its move ``n`` on, which starts at ``stance``; ``leaving`` are
    the bars of feet on their way.
    """
    offset = 0.0 if known.given else known.start.course
    bars: list[list[Bar]] = [
        [leaving[leg]] if leg in leaving else [] for leg in range(len(machine.legs))
    ]
    for leg, leg_bars in enumerate(bars):
        if leg not in stance.lifted:
            segment = _present(known, n, leg)
            if segment is None:
                segment = _segment(known.trace, stance, leg, offset, machine)
            leg_bars.append((*segment, min(segment[0], stance.course), segment[1]))
    for move in known.moves[n:]:
        _add_bars(bars, move, machine.yaw_length)
    present = [
        leg_bars[-1 if leg in leaving else 0][:2]
        for leg, leg_bars in enumerate(bars)
        if leg_bars and leg not in stance.lifted
    ]
    far = min(known.goal + BEYOND * machine.torso[0], offset + known.trace.length)
    return GaitPreview(
        _line(known.trace, stance.course, far, offset),
        tuple(_footholds(known.moves[n:], leg) for leg in range(len(bars))),
        tuple(map(tuple, bars)),
        (_shared(present, stance.course), *_states(known.moves[n:])),
        known.reached,
        known.goal,
        known.complete,
        known.reason,
    )


def _add_bars(bars: list[list[Bar]], move: Move, yaw_length: float) -> None:
    """The bars of the footholds a move lifts feet from, cut there, and of those it puts them on."""
    lifted_at = move.course - _length((*move.rise, *move.carry, *move.lower), yaw_length)
    for leg in move.legs:
        if move.before[leg] is not None and bars[leg]:
            s1, s2, placed, lifted = bars[leg][-1]
            bars[leg][-1] = s1, s2, placed, max(placed, lifted_at)
        found = move.segments[leg]
        if move.after[leg] is not None and found is not None:
            bars[leg].append((*found, move.course, max(found[1], move.course)))


def _footholds(moves: tuple[Move, ...], leg: int) -> tuple[Point, ...]:
    """Where a leg will be put down, in order."""
    return tuple(
        foot
        for move in moves
        if leg in move.legs
        and (foot := move.after[leg]) is not None
        and move.segments[leg] is not None
    )


def _states(moves: tuple[Move, ...]) -> list[tuple[float, float]]:
    """The segments of whole states: those of each move with its legs lifted, then standing."""
    states = []
    for move in moves:
        standing = [(leg, s) for leg, s in enumerate(move.segments) if s is not None]
        staying = [s for leg, s in standing if leg not in move.legs]
        states.append(_shared(staying, move.course))
        states.append(_shared([s for _, s in standing], move.course))
    return states


def _leaving(stance: Stance, running: StepPlan) -> dict[int, Bar]:
    """Bars of the footholds the running step leaves, known only as far as they are used."""
    lifted = stance.course + running.support_shift
    return {
        leg: (stance.course, lifted, stance.course, lifted)
        for leg in running.swing
        if leg not in stance.lifted
    }


def _present(known: Prediction, n: int, leg: int) -> tuple[float, float] | None:
    """Existence segment of the foothold a leg has before move ``n``, from the moves; None when no
    move tells.
    """
    for move in reversed(known.moves[:n]):
        if move.segments[leg] is not None or leg in move.legs:
            return move.segments[leg]
    for move in known.moves[n:]:
        if leg in move.legs:
            return None
        if move.segments[leg] is not None:
            return move.segments[leg]
    return None


def _segment(
    trace: SampledPath, stance: Stance, leg: int, offset: float, machine: Machine
) -> tuple[float, float]:
    """Existence segment of a standing foot around s, by the samples of the trace itself."""
    x1, x2, y1, y2 = machine.boxes[leg]
    c, s = directions(trace.yaw)
    dx = stance.feet[leg][0] - trace.x
    dy = stance.feet[leg][1] - trace.y
    bx = c * dx + s * dy
    by = c * dy - s * dx
    inside = (bx >= x1 - EDGE) & (bx <= x2 + EDGE) & (by >= y1 - EDGE) & (by <= y2 + EDGE)
    now = min(max(round((stance.course - offset) / trace.step), 0), trace.last)
    outside = np.flatnonzero(~inside)
    first = int(outside[outside < now].max(initial=-1)) + 1
    last = int(outside[outside >= now].min(initial=trace.last + 1)) - 1
    return offset + first * trace.step, offset + max(last, now) * trace.step


def _shared(segments: list[tuple[float, float]], otherwise: float) -> tuple[float, float]:
    if not segments:
        return otherwise, otherwise
    return max(s[0] for s in segments), min(s[1] for s in segments)


def _line(trace: SampledPath, start: float, end: float, offset: float) -> tuple[Point, ...]:
    points = []
    for s in np.linspace(start, end, max(2, math.ceil((end - start) / LINE_STEP) + 1)).tolist():
        x, y, _ = trace.pose(s - offset)
        points.append((s, x, y))
    return tuple(points)
