"""Beyond K: a best-first search over states, for where K's order finds no way.

Only s matters here, so a change is *one leg to another foothold* at a sample where the other feet
carry, or a leg in the air put down, or a leg that must leave lifted while the others carry on:
every longer sequence of lifting and placing, pairs and triples included, is made of these (a
polygon only grows when a foot is added). Nothing else is assumed, so the search left alone visits
every state that can be reached. The body may also go back along the trace inside a state; reaching
farther ahead always comes first.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, replace
from heapq import heappop, heappush
from itertools import product

from .reachability import AIR, Feet, Field, first_bit, legs_clear
from .state_sequence import State, k_step

# work between two yields, a third of a millisecond: thirty such pieces stay inside a tick
PAUSE = 40
ENTERING = 8  # what entering a state costs of it; looking at a leg costs 1
AHEAD_WEIGHT = 0.35  # how much the mean remaining life of the feet counts beside the sample reached


BATCH = 8  # changes of each leg tried at once; the rest wait their turn
BATCH_COST = 10.0  # samples: how much a state's next batch waits behind its first

CHOICES = 6  # footholds tried for each leg of a rigid gait

Key = tuple[Feet, int]  # feet, and the place (unbroken samples) they exist in


@dataclass(frozen=True, slots=True)
class Path:
    """States from where the machine stands on; ``complete`` when the last one reaches the goal."""

    states: tuple[State, ...]
    complete: bool
    farthest: int  # sample of the trace
    looked: int  # states met
    exhausted: bool  # nothing was left to look at: there is no way

    def to_standing(self) -> Path:
        """The part up to the last state in which every leg stands: where to wait when there is no
        way on, or none yet.
        """
        for n in range(len(self.states) - 1, 0, -1):
            if AIR not in self.states[n].feet:
                return replace(self, states=self.states[: n + 1])
        return (
            replace(self, states=self.states[:1])
            if self.states and AIR not in self.states[0].feet
            else self
        )


def search(
    field: Field, start: State, goal: int, limit: int, in_order: bool = True
) -> Generator[None, None, Path]:
    """States from ``start`` to one that lasts until sample ``goal``, or as far as ``limit`` states
    met could find.

    K's order first; where it fails the search goes on from every state it passed. Yields now and
    then, so that a caller may spread it over ticks; the answer does not depend on how.
    """
    met = _Met(field)
    met.enter(start, None)
    if in_order:
        state: State | None = start
        while state is not None and met.farthest < goal and met.count < limit:
            state = _follow_order(field, met, state)
            yield
    heap = met.heap
    paused = 0
    while heap and met.farthest < goal and met.count < limit:
        worth, _, state = heappop(heap)
        place = met.place_of(state)
        more = False
        for leg in range(len(state.feet)):
            found = successors(field, state, place, leg, met.places)
            for nxt in found[:BATCH]:
                met.enter(nxt, (state.feet, place))
            more = more or len(found) > BATCH
            paused += 1 + ENTERING * min(len(found), BATCH)
            if paused >= PAUSE:
                paused = 0
                yield
        if more:
            met.serial += 1
            heappush(heap, (worth + BATCH_COST, met.serial, state))
    return met.path(met.farthest >= goal)


class _Met:
    """The states a search has met: where each came from, and those still to look at, best first."""

    def __init__(self, field: Field) -> None:
        self.field = field
        self.heap: list[tuple[float, int, State]] = []
        self.serial = 0
        self.came_from: dict[Key, Key | None] = {}
        self.state_of: dict[Key, State] = {}
        self.places: dict[Feet, int] = {}  # all samples a set of feet has been met in
        self.farthest = -1
        self.best: Key | None = None

    def place_of(self, state: State) -> int:
        return self.field.place(self.field.valid(state.feet), state.at)

    def enter(self, state: State, parent: Key | None) -> bool:
        """Enter a state, once for every place it exists in; False when it was there already."""
        field = self.field
        place = self.place_of(state)
        key = (state.feet, place)
        if key in self.came_from:
            return False
        self.came_from[key] = parent
        self.state_of[key] = state
        self.places[state.feet] = self.places.get(state.feet, 0) | place
        end = field.farthest(place)
        self.serial += 1
        heappush(self.heap, (-promise(field, state.feet, end), self.serial, state))
        if end > self.farthest:
            self.best, self.farthest = key, end
        return True

    @property
    def count(self) -> int:
        """States met so far."""
        return len(self.came_from)

    def path(self, complete: bool) -> Path:
        states: list[State] = []
        key = self.best
        while key is not None:
            states.append(self.state_of[key])
            key = self.came_from[key]
        return Path(tuple(reversed(states)), complete, self.farthest, self.count, not self.heap)


def _follow_order(field: Field, met: _Met, state: State) -> State | None:
    """One step of K's order; None where the order fails or comes back to where it was."""
    states = k_step(field, state)
    if states is None:
        return None
    fresh = False
    for nxt in states:
        fresh = met.enter(nxt, (state.feet, met.place_of(state)))
        state = nxt
    return state if fresh else None


def promise(field: Field, feet: Feet, end: int) -> float:
    """What a state is worth: the sample it reaches, and how long its feet last beyond that."""
    holds = field.holds
    life = 0
    for f in feet:
        if f >= 0:
            life += holds[f].last - end
    return end + AHEAD_WEIGHT * life / len(feet)


def successors(
    field: Field, state: State, place: int, leg: int, met: dict[Feet, int]
) -> list[State]:
    """States one change of ``leg`` away, those that last longest first: moved, put down, or lifted
    when it must leave.

    ``met`` says in which samples a set of feet has been met before; only what is new is returned.
    """
    feet, at = state
    holds, reach, radius, tall = field.holds, field.reach, field.machine.foot_radius, field.tall
    f = feet[leg]
    fore, aft = feet[:leg], feet[leg + 1 :]
    rest = (*fore, AIR, *aft)
    found: list[tuple[int, Feet, int]] = []
    window = place
    if f >= 0:
        window &= field.carries(rest)
        if not window:
            return []
        waiting = field.valid(rest)
        fresh = window & waiting & ~met.get(rest, 0)
        while fresh:
            whole = field.place(waiting, first_bit(fresh))
            if whole & ~place:  # lifted, the body can go where it cannot go otherwise
                found.append((field.count, rest, fresh & whole))
            fresh &= ~whole
    for g in field.by_leg[leg]:
        both = window & reach[g]
        if both and g != f:
            new = (*fore, g, *aft)
            fresh = both & ~met.get(new, 0)
            if (
                fresh
                and legs_clear(holds, rest, holds[g], radius)
                and not (tall and f >= 0 and not field.crosses(f, g))
            ):
                found.append((holds[g].last, new, fresh))
    found.sort(key=_lasting, reverse=True)
    return [State(new, field.nearest(fresh, at)) for _, new, fresh in found]


def _lasting(change: tuple[int, Feet, int]) -> int:
    return change[0]


def search_rigid(
    field: Field, start: State, goal: int, limit: int, groups: Sequence[tuple[int, ...]]
) -> Generator[None, None, Path]:
    """The same for a rigid gait: legs are moved in the order of ``groups`` only, each group lifted
    and put down together.
    """
    met = _Met(field)
    met.enter(start, None)
    phase: dict[Key, int] = {(start.feet, met.place_of(start)): 0}
    heap = met.heap
    while heap and met.farthest < goal and met.count < limit:
        _, _, state = heappop(heap)
        key = (state.feet, met.place_of(state))
        group = groups[phase[key] % len(groups)]
        for nxt in moved_together(field, state, key[1], group):
            if met.enter(nxt, key):
                phase[nxt.feet, met.place_of(nxt)] = phase[key] + 1
        yield
    return met.path(met.farthest >= goal)


def moved_together(
    field: Field, state: State, place: int, legs: tuple[int, ...]
) -> Iterator[State]:
    """States in which just ``legs`` have been lifted at one sample and put down at another, at most
    CHOICES footholds each.
    """
    feet, at = state
    rest = tuple(AIR if leg in legs else f for leg, f in enumerate(feet))
    window = place & field.carries(rest)
    if not window:
        return
    lifted = field.place(field.carries(rest), field.nearest(window, at))
    choices = []
    for leg in legs:
        stood = feet[leg]
        able = [f for f in field.by_leg[leg] if lifted & field.reach[f]]
        if field.tall and stood >= 0:
            able = [f for f in able if field.crosses(stood, f)]
        able.sort(key=lambda f: -field.holds[f].last)
        choices.append(able[:CHOICES])
    for chosen in product(*choices):
        both = lifted
        new = rest
        for leg, f in zip(legs, chosen, strict=True):
            both &= field.reach[f]
            if not legs_clear(field.holds, new, field.holds[f], field.machine.foot_radius):
                both = 0
            new = new[:leg] + (f,) + new[leg + 1 :]
        if both and new != feet:
            yield State(new, field.nearest(both, at))
