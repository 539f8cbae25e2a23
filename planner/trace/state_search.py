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

from ..protocols import Weight
from .footholds import AIR, Footing, legs_clear
from .reachability import Reachability
from .samples import first_bit
from .state_sequence import SupportState, k_step

PAUSE = 40  # work between two yields. More: see ticks come late
PAUSE_WEIGHT = 8  # what it weighs, in postures looked at
PAUSE_WEIGHT_RIGID = 5  # the same of a rigid gait, whose choices are fewer
ENTERING = 8  # what entering a state costs of it; looking at a leg costs 1
LIFE_WEIGHT = 0.35  # how much the mean remaining life of the feet counts beside the sample reached


BATCH = 8  # changes of each leg tried at once; the rest wait their turn
BATCH_COST = 10.0  # samples: how much a state's next batch waits behind its first

CHOICES = 6  # footholds tried for each leg of a rigid gait

StateKey = tuple[Footing, int]  # feet, and the place (unbroken samples) they exist in


@dataclass(frozen=True, slots=True)
class StatePath:
    """States from where the machine stands on; ``complete`` when the last one reaches the goal."""

    states: tuple[SupportState, ...]
    complete: bool
    farthest: int  # sample of the trace
    looked: int  # states met
    exhausted: bool  # nothing was left to look at: there is no way

    def to_standing(self) -> StatePath:
        """The part up to the last state in which every leg stands: where to wait when there is no
        way on, or none yet.
        """
        for n in range(len(self.states) - 1, 0, -1):
            if AIR not in self.states[n].feet:
                return replace(self, states=self.states[: n + 1])
        if self.states and AIR not in self.states[0].feet:
            return replace(self, states=self.states[:1])
        return self


def search(
    reachable: Reachability,
    start: SupportState,
    goal: int,
    limit: int,
    in_order: bool = True,
    change_cost: float = 0.0,
) -> Generator[Weight, None, StatePath]:
    """States from ``start`` to one that lasts until sample ``goal``, or as far as ``limit`` states
    met could find.

    K's order first; where it fails the search goes on from every state it passed. ``change_cost``
    samples are held to be lost by every change: with a high one the way has few. Yields now and
    then, so that a caller may spread it over ticks; the answer does not depend on how.
    """
    met = _Met(reachable, change_cost)
    met.enter(start, None)
    if in_order:
        state: SupportState | None = start
        while state is not None and met.farthest < goal and met.count < limit:
            state = _follow_order(reachable, met, state)
            yield None
    heap = met.heap
    paused = 0
    while heap and met.farthest < goal and met.count < limit:
        value, _, state = heappop(heap)
        place = met.place_of(state)
        more = False
        for leg in range(len(state.feet)):
            found = successors(reachable, state, place, leg, met.places)
            for nxt in found[:BATCH]:
                met.enter(nxt, (state.feet, place))
            more = more or len(found) > BATCH
            paused += 1 + ENTERING * min(len(found), BATCH)
            if paused >= PAUSE:
                paused = 0
                yield PAUSE_WEIGHT
        if more:
            met.serial += 1
            heappush(heap, (value + BATCH_COST, met.serial, state))
    return met.path(met.farthest >= goal)


class _Met:
    """The states a search has met: where each came from, and those still to look at, best first."""

    def __init__(self, reachable: Reachability, change_cost: float = 0.0) -> None:
        self.reachable = reachable
        self.change_cost = change_cost
        self.changes: dict[StateKey, int] = {}  # from the first state
        self.heap: list[tuple[float, int, SupportState]] = []
        self.serial = 0
        self.came_from: dict[StateKey, StateKey | None] = {}
        self.state_of: dict[StateKey, SupportState] = {}
        self.places: dict[Footing, int] = {}  # all samples a set of feet has been met in
        self.farthest = -1
        self.best: StateKey | None = None

    def place_of(self, state: SupportState) -> int:
        return self.reachable.samples.unbroken(self.reachable.valid(state.feet), state.at)

    def enter(self, state: SupportState, parent: StateKey | None) -> bool:
        """Enter a state, once for every place it exists in; False when it was there already."""
        reachable = self.reachable
        place = self.place_of(state)
        key = (state.feet, place)
        if key in self.came_from:
            return False
        self.came_from[key] = parent
        self.state_of[key] = state
        self.places[state.feet] = self.places.get(state.feet, 0) | place
        end = reachable.samples.farthest(place)
        self.serial += 1
        worth = value_of(reachable, state.feet, end)
        if self.change_cost:
            changes = 0 if parent is None else self.changes[parent] + 1
            self.changes[key] = changes
            worth -= self.change_cost * changes
        heappush(self.heap, (-worth, self.serial, state))
        if end > self.farthest:
            self.best = key
            self.farthest = end
        return True

    @property
    def count(self) -> int:
        """States met so far."""
        return len(self.came_from)

    def path(self, complete: bool) -> StatePath:
        states: list[SupportState] = []
        key = self.best
        while key is not None:
            states.append(self.state_of[key])
            key = self.came_from[key]
        return StatePath(
            tuple(reversed(states)), complete, self.farthest, self.count, not self.heap
        )


def _follow_order(reachable: Reachability, met: _Met, state: SupportState) -> SupportState | None:
    """One step of K's order; None where the order fails or comes back to where it was."""
    states = k_step(reachable, state)
    if states is None:
        return None
    fresh = False
    for nxt in states:
        fresh = met.enter(nxt, (state.feet, met.place_of(state)))
        state = nxt
    return state if fresh else None


def value_of(reachable: Reachability, feet: Footing, end: int) -> float:
    """What a state is worth: the sample it reaches, and how long its feet last beyond that."""
    holds = reachable.footholds
    life = 0
    for f in feet:
        if f >= 0:
            life += holds[f].last - end
    return end + LIFE_WEIGHT * life / len(feet)


def successors(
    reachable: Reachability, state: SupportState, place: int, leg: int, met: dict[Footing, int]
) -> list[SupportState]:
    """States one change of ``leg`` away, those that last longest first: moved, put down, or lifted
    when it must leave.

    ``met`` says in which samples a set of feet has been met before; only what is new is returned.
    """
    feet, at = state
    holds = reachable.footholds
    existence = reachable.existence
    radius = reachable.machine.foot_radius
    has_tall = reachable.clearance.has_tall
    f = feet[leg]
    fore = feet[:leg]
    aft = feet[leg + 1 :]
    rest = (*fore, AIR, *aft)
    found: list[tuple[int, Footing, int]] = []
    window = place
    if f >= 0:
        window &= reachable.carries(rest)
        if not window:
            return []
        found += _lifted(reachable, rest, place, window & ~met.get(rest, 0))
    for g in reachable.by_leg[leg]:
        both = window & existence[g]
        if both and g != f:
            new = (*fore, g, *aft)
            fresh = both & ~met.get(new, 0)
            if (
                fresh
                and legs_clear(holds, rest, holds[g], radius)
                and not (has_tall and f >= 0 and not reachable.crosses(f, g))
            ):
                found.append((holds[g].last, new, fresh))
    found.sort(key=_lasting, reverse=True)
    return [SupportState(new, reachable.samples.nearest(fresh, at)) for _, new, fresh in found]


def _lifted(
    reachable: Reachability, rest: Footing, place: int, window: int
) -> list[tuple[int, Footing, int]]:
    """The leg lifted, wherever in the window the body can then go where it cannot go otherwise."""
    found = []
    waiting = reachable.valid(rest)
    fresh = window & waiting
    while fresh:
        whole = reachable.samples.unbroken(waiting, first_bit(fresh))
        if whole & ~place:
            found.append((reachable.samples.count, rest, fresh & whole))
        fresh &= ~whole
    return found


def _lasting(change: tuple[int, Footing, int]) -> int:
    return change[0]


def search_rigid(
    reachable: Reachability,
    start: SupportState,
    goal: int,
    limit: int,
    groups: Sequence[tuple[int, ...]],
) -> Generator[Weight, None, StatePath]:
    """The same for a rigid gait: legs are moved in the order of ``groups`` only, each group lifted
    and put down together.
    """
    met = _Met(reachable)
    met.enter(start, None)
    phase: dict[StateKey, int] = {(start.feet, met.place_of(start)): 0}
    heap = met.heap
    paused = 0
    while heap and met.farthest < goal and met.count < limit:
        _, _, state = heappop(heap)
        key = (state.feet, met.place_of(state))
        group = groups[phase[key] % len(groups)]
        for nxt in moved_together(reachable, state, key[1], group):
            if met.enter(nxt, key):
                phase[nxt.feet, met.place_of(nxt)] = phase[key] + 1
            paused += ENTERING
            if paused >= PAUSE:
                paused = 0
                yield PAUSE_WEIGHT_RIGID
        yield 2
    return met.path(met.farthest >= goal)


def moved_together(
    reachable: Reachability, state: SupportState, place: int, legs: tuple[int, ...]
) -> Iterator[SupportState]:
    """States in which just ``legs`` have been lifted at one sample and put down at another, at most
    CHOICES footholds each.
    """
    feet, at = state
    rest = tuple(AIR if leg in legs else f for leg, f in enumerate(feet))
    window = place & reachable.carries(rest)
    if not window:
        return
    samples = reachable.samples
    lifted = samples.unbroken(reachable.carries(rest), samples.nearest(window, at))
    choices = [_longest_lasting(reachable, leg, feet[leg], lifted) for leg in legs]
    for chosen in product(*choices):
        new = rest
        both = lifted
        for leg, f in zip(legs, chosen, strict=True):
            both &= reachable.existence[f]
            hold = reachable.footholds[f]
            if not legs_clear(reachable.footholds, new, hold, reachable.machine.foot_radius):
                both = 0
            new = (*new[:leg], f, *new[leg + 1 :])
        if both and new != feet:
            yield SupportState(new, samples.nearest(both, at))


def _longest_lasting(reachable: Reachability, leg: int, stood: int, lifted: int) -> list[int]:
    """Footholds a leg lifted from number ``stood`` can be carried to, those that last longest."""
    able = [f for f in reachable.by_leg[leg] if lifted & reachable.existence[f]]
    if reachable.clearance.has_tall and stood >= 0:
        able = [f for f in able if reachable.crosses(stood, f)]
    able.sort(key=lambda f: -reachable.footholds[f].last)
    return able[:CHOICES]
