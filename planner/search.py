"""Several steps ahead: roll candidates out, keep the best. Bounded by count, never by the clock, so
that a walk can be repeated.

This file knows neither legs nor ground: nodes and candidates are the planner's own. Both searches
are generators that pause after each slice of work and yield what it weighed; ``send(True)`` says
that the answer is wanted now, and they finish with the best found so far.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from operator import attrgetter
from typing import Generic, NamedTuple, TypeVar

from .protocols import Answer, SlicedJob

ENOUGH = 8  # postures looked at between two pauses. More: see ticks come late

S = TypeVar("S")
C = TypeVar("C")


# one candidate from a node: it, where it leads, what the step gains, and the heuristic worth of the
# node reached, m; a plain tuple, as most are only weighed
Option = tuple[C, S, float, float]


class Branch(NamedTuple, Generic[S, C]):
    """A way through the tree of candidates: only its first will be taken."""

    first: C
    node: S
    gain: float  # m, of all its steps
    score: float  # m, the gain and the heuristic worth of its end
    steps: int

    def pace(self, horizon: int) -> float:
        """Mean gain a step over a horizon: a way that ends early gains nothing more."""
        return self.gain / horizon


class Found(NamedTuple, Generic[S, C]):
    """Ways found, best first; not ``finished`` when the answer was wanted before the search was
    over.
    """

    ways: list[Branch[S, C]]
    finished: bool


Search = SlicedJob[Found[S, C]]


class Work:
    """What has been asked since a search last paused: one for each posture looked at, and what
    whoever is asked adds for what is as dear.
    """

    __slots__ = ("asked",)

    def __init__(self) -> None:
        self.asked = 0

    def taken(self) -> int:
        """The weight so far; what comes counts from 0 again."""
        asked, self.asked = self.asked, 0
        return asked


def beam(
    start: S,
    options: Callable[[S, int], Iterable[Option[C, S]]],
    depth: int,
    width: int,
    work: Work | None = None,
) -> Search[S, C]:
    """Look ``depth`` steps ahead, going on from the ``width`` best of each depth; where none goes
    on, those reached before.

    Behind the ways that came farthest stand all first steps, by their heuristic. Pauses after each
    node looked at, and within one that takes long.
    """
    work = work or Work()
    wanted_now: bool | None = False
    found: list[Branch[S, C]] = []
    for candidate, node, gain, heuristic in options(start, 0):
        found.append(Branch(candidate, node, gain, gain + heuristic, 1))
        work.asked += 1
        if work.asked >= ENOUGH:
            wanted_now = (yield work.taken()) or wanted_now
    begun = ranked(found)
    level = begun[:width]
    wanted_now = (yield work.taken()) or wanted_now
    for depth_now in range(1, depth):
        if wanted_now and level:
            break
        best: list[Branch[S, C]] = []
        for branch in level:
            for _, node, gain, heuristic in options(branch.node, depth_now):
                gain += branch.gain
                score = gain + heuristic
                _keep(best, (branch.first, node, gain, score, depth_now + 1), width)
                work.asked += 1
                if work.asked >= ENOUGH:
                    wanted_now = (yield work.taken()) or wanted_now
            wanted_now = (yield work.taken()) or wanted_now
            if wanted_now:
                break
        if wanted_now or not best:
            break
        level = best
    return Found([*level, *begun], not wanted_now or not level)


def rollouts(
    options: Iterable[Option[C, S]],
    policy: Callable[[S], tuple[S, float] | None],
    steps: int,
    begun: tuple[C, float] | None = None,
    work: Work | None = None,
) -> Search[S, C]:
    """Take each option, then follow the policy for ``steps`` steps. Pauses after each option, and
    on the way where it takes long.

    ``begun`` is a step taken before, with its gain: it then is the first of all of them.
    """
    work = work or Work()
    wanted_now: bool | None = False
    found: list[Branch[S, C]] = []
    for candidate, node, more, heuristic in options:
        first, gained = (candidate, 0.0) if begun is None else begun
        gain = gained + more
        taken = 1 if begun is None else 2
        for _ in range(steps):
            work.asked += 1
            if work.asked >= ENOUGH:
                wanted_now = (yield work.taken()) or wanted_now
            ahead = policy(node)
            if ahead is None:
                break
            node, more = ahead
            gain += more
            taken += 1
        found.append(Branch(first, node, gain, gain + heuristic, taken))
        wanted_now = (yield work.taken()) or wanted_now
        if wanted_now:
            return Found(ranked(found), False)
    return Found(ranked(found), True)


def _keep(best: list[Branch[S, C]], row: tuple[C, S, float, float, int], most: int) -> None:
    """Keep what would be a branch where it is one of the best, ``most`` of them; of equal ones the
    one found first stays.
    """
    if len(best) < most or row[3] > best[-1].score:
        best.append(Branch(*row))
        best.sort(key=attrgetter("score"), reverse=True)
        del best[most:]


def ranked(branches: list[Branch[S, C]]) -> list[Branch[S, C]]:
    """Best first; of equal ones the one found first."""
    return sorted(branches, key=attrgetter("score"), reverse=True)


def firsts(branches: Iterable[Branch[S, C]]) -> list[Branch[S, C]]:
    """Of each first candidate only the branch that comes first."""
    best: dict[int, Branch[S, C]] = {}
    for branch in branches:
        best.setdefault(id(branch.first), branch)
    return list(best.values())


def thinned(found: list[C], most: int) -> list[C]:
    """At most so many, evenly picked."""
    count = len(found)
    if count <= most:
        return found
    return [found[(2 * k + 1) * count // (2 * most)] for k in range(most)]


def uninterruptible(job: SlicedJob[Answer]) -> SlicedJob[Answer]:
    """A job that goes on slice by slice to its end, even when the answer is wanted now."""
    while True:
        try:
            weight = next(job)
        except StopIteration as done:
            answer: Answer = done.value
            return answer
        yield weight
