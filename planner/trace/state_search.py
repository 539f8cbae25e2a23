"""Beyond K: a best-first search over states, for where K's order finds no way.

Only s matters here, so a change is *one leg to another foothold* at a sample where the other feet
carry, or a leg in the air put down, or a leg that must leave lifted while the others carry on:
every longer sequence of lifting and placing, pairs and triples included, is made of these (a
polygon only grows when a foot is added). Nothing else is assumed, so the search left alone visits
every state that can be reached. The body may also go back along the trace inside a state; reaching
farther ahead always comes first.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, replace
from heapq import heappop, heappush
from itertools import product
from typing import NamedTuple

from ..protocols import Weight
from .footholds import AIR, Footing, legs_clear
from .reachability import Reachability
from .samples import first_bit
from .state_sequence import SupportState, k_step
from .upper_bound import farthest_possible

PAUSE = 40  # work between two yields. More: see ticks come late
PAUSE_WEIGHT = 8  # what it weighs, in postures looked at
PAUSE_WEIGHT_RIGID = 5  # the same of a rigid gait, whose choices are fewer
ENTERING = 8  # what entering a state costs of it; looking at a leg costs 1
# states met since it came farther, after which it is asked how far any way can lead at most, on the
# trace and beside it; fewer: see that asked where there is a way
STUCK, STUCK_ASIDE = 100, 400
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
    exhausted: bool  # there is known to be no way farther
    most: int  # sample beyond which there is known to be no way

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
    change_cost: float = 0.0,
    whole_only: bool = False,
) -> Generator[Weight, None, StatePath]:
    """States from ``start`` to one that lasts until sample ``goal``, or as far as ``limit`` states
    met could find.

    K's order first; where it fails the search goes on from every state it passed. ``change_cost``
    samples are held to be lost by every change: with a high one the way has few, and K's order is
    left out. Where the search is stuck it is asked how far any way can lead: so far and no farther
    it goes on, not at all with ``whole_only`` where that is not to the goal. Yields now and then,
    so that a caller may spread it over ticks; the answer does not depend on how.
    """
    met = _Met(reachable, change_cost)
    met.enter(start, None)
    most = min(goal, reachable.clearance.leads_to(start.at))
    if most < goal and whole_only:
        return met.path(most, False)
    if change_cost == 0.0:
        yield from _in_order(met, start, most, limit)
    heap = met.heap
    paused = 0
    while heap and met.farthest < most and met.count < limit:
        if met.is_stuck():
            most = yield from _at_most(met, start, most)
            if most < goal and whole_only:
                break
        value, _, state, place = heappop(heap)
        more = False
        code = met.code_of(state.feet)
        for leg in range(len(state.feet)):
            found = successors(met, state, place, leg, code)
            for nxt in found[:BATCH]:
                met.enter(nxt, (state.feet, place))
            more = more or len(found) > BATCH
            paused += 1 + ENTERING * min(len(found), BATCH)
            if paused >= PAUSE:
                paused = 0
                yield PAUSE_WEIGHT
        if more:
            met.serial += 1
            heappush(heap, (value + BATCH_COST, met.serial, state, place))
    return met.path(most, met.farthest >= goal)


def _at_most(met: _Met, start: SupportState, most: int) -> Generator[Weight, None, int]:
    """How far any way can lead, of which ``most`` is known."""
    bound = yield from farthest_possible(met.reachable, start.at, met.farthest)
    return most if bound is None else min(most, bound)


class _Met:
    """The states a search has met: where each came from, and those still to look at, best first."""

    def __init__(self, reachable: Reachability, change_cost: float = 0.0) -> None:
        self.reachable = reachable
        self.change_cost = change_cost
        self.changes: dict[StateKey, int] = {}  # from the first state
        self.heap: list[tuple[float, int, SupportState, int]] = []  # with the place of each
        self.serial = 0
        self.came_from: dict[StateKey, StateKey | None] = {}
        self.state_of: dict[StateKey, SupportState] = {}
        self.places: dict[int, int] = {}  # all samples a set of feet, by its code, has been met in
        self._bits = (len(reachable.footholds) + 1).bit_length()
        self._shifts = [self._bits * leg for leg in reversed(range(len(reachable.by_leg)))]
        self._puttings: dict[tuple[int, int, int], list[_Put]] = {}
        self.farthest = -1
        self.best: StateKey | None = None
        self._patience = STUCK if reachable.samples.rows == 1 else STUCK_ASIDE
        self._asks_at = math.inf  # states met when it is next asked how far any way can lead

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
        code = self.code_of(state.feet)
        self.places[code] = self.places.get(code, 0) | place
        end = reachable.samples.farthest(place)
        self.serial += 1
        worth = value_of(reachable, state.feet, end)
        if self.change_cost:
            changes = 0 if parent is None else self.changes[parent] + 1
            self.changes[key] = changes
            worth -= self.change_cost * changes
        heappush(self.heap, (-worth, self.serial, state, place))
        if end > self.farthest:
            self.best = key
            self.farthest = end
            self._asks_at = self.count + self._patience
        return True

    def code_of(self, feet: Footing) -> int:
        """A set of feet as one number: looked up more quickly, and changed by one addition."""
        code = 0
        for f in feet:
            code = code << self._bits | (f + 1)
        return code

    def placed(self, leg: int, f: int) -> int:
        """What a leg's foothold counts for in the code of a set of feet."""
        return (f + 1) << self._shifts[leg]

    def puttings(self, feet: Footing, leg: int) -> list[_Put]:
        """Footholds of a leg that exist somewhere where those of the two legs before it do: of all
        there are, few come into question.
        """
        key = (leg, feet[leg - 1], feet[leg - 2])
        found = self._puttings.get(key)
        if found is None:
            reachable = self.reachable
            existence = reachable.existence
            window = reachable.samples.all
            for f in key[1:]:
                if f >= 0:
                    window &= existence[f]
            found = self._puttings[key] = [
                _Put(g, existence[g], self.placed(leg, g))
                for g in reachable.by_leg[leg]
                if window & existence[g]
            ]
        return found

    @property
    def count(self) -> int:
        """States met so far."""
        return len(self.came_from)

    def is_stuck(self) -> bool:
        """True when it has met many states since it came farther last; once only each time."""
        if self.count < self._asks_at:
            return False
        self._asks_at = math.inf
        return True

    def path(self, most: int, complete: bool) -> StatePath:
        """The way that leads farthest; ``most`` is a sample beyond which none is known to lead."""
        states: list[SupportState] = []
        key = self.best
        while key is not None:
            states.append(self.state_of[key])
            key = self.came_from[key]
        if not self.heap:
            most = self.farthest
        return StatePath(
            tuple(reversed(states)),
            complete,
            self.farthest,
            self.count,
            exhausted=self.farthest >= most,
            most=most,
        )


def _in_order(
    met: _Met, start: SupportState, goal: int, limit: int
) -> Generator[Weight, None, None]:
    """K's order as far as it leads."""
    state: SupportState | None = start
    while state is not None and met.farthest < goal and met.count < limit:
        state = _follow_order(met.reachable, met, state)
        yield None


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


class _Put(NamedTuple):
    """A leg put down: on which foothold, in which samples, and what that counts for in a code."""

    foothold: int
    samples: int
    code: int


def successors(
    met: _Met, state: SupportState, place: int, leg: int, code: int
) -> list[SupportState]:
    """States one change of ``leg`` away, those that last longest first: moved, put down, or lifted
    when it must leave.

    ``met`` says in which samples a set of feet has been met before; only what is new is returned.
    ``code`` is that of the state's feet.
    """
    feet, at = state
    reachable = met.reachable
    f = feet[leg]
    rest = (*feet[:leg], AIR, *feet[leg + 1 :])
    found: list[tuple[int, Footing, int]] = []
    window = place
    if f >= 0:
        window &= reachable.carries(rest)
        if not window:
            return []
        code -= met.placed(leg, f)
        lifted = window & ~met.places.get(code, 0)
        if lifted:
            found += _lifted(reachable, rest, place, lifted)
    found += _put_down(met, feet, leg, window, code)
    found.sort(key=_lasting, reverse=True)
    return [SupportState(new, reachable.samples.nearest(fresh, at)) for _, new, fresh in found]


def _put_down(
    met: _Met, feet: Footing, leg: int, window: int, code: int
) -> Iterator[tuple[int, Footing, int]]:
    """The leg on every other foothold of its own, wherever in the window it exists; ``code`` is
    that of the other feet.
    """
    reachable = met.reachable
    places = met.places
    holds = reachable.footholds
    radius = reachable.machine.foot_radius
    f = feet[leg]
    crossing = f >= 0 and reachable.clearance.has_tall
    for g, samples, placed in met.puttings(feet, leg):
        fresh = window & samples
        if not fresh or g == f:
            continue
        new = code + placed
        if new in places:
            fresh &= ~places[new]
        if not fresh or (crossing and not reachable.crosses(f, g)):
            continue
        rest = (*feet[:leg], AIR, *feet[leg + 1 :])
        if legs_clear(holds, rest, holds[g], radius):
            yield holds[g].last, (*feet[:leg], g, *feet[leg + 1 :]), fresh


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
    most = min(goal, reachable.clearance.leads_to(start.at))
    phase: dict[StateKey, int] = {(start.feet, met.place_of(start)): 0}
    heap = met.heap
    paused = 0
    while heap and met.farthest < most and met.count < limit:
        _, _, state, place = heappop(heap)
        key = (state.feet, place)
        group = groups[phase[key] % len(groups)]
        for nxt in moved_together(reachable, state, key[1], group):
            if met.enter(nxt, key):
                phase[nxt.feet, met.place_of(nxt)] = phase[key] + 1
            paused += ENTERING
            if paused >= PAUSE:
                paused = 0
                yield PAUSE_WEIGHT_RIGID
        yield 2
    return met.path(most, met.farthest >= goal)


def moved_together(
    reachable: Reachability, state: SupportState, place: int, legs: tuple[int, ...]
) -> Iterator[SupportState]:
    """States in which just ``legs`` have been lifted at one sample and put down at another, at most
    CHOICES footholds each.
    """
    feet, at = state
    rest = tuple(AIR if leg in legs else f for leg, f in enumerate(feet))
    lifted = _carried_from(reachable, rest, place, at)
    if not lifted:
        return
    samples = reachable.samples
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
        still = tuple(f if f == g else AIR for f, g in zip(feet, new, strict=True))
        if both and still != rest:  # a leg that stays where it is has not been in the air
            both &= _carried_from(reachable, still, place, at)
        if both and new != feet:
            yield SupportState(new, samples.nearest(both, at))


def _carried_from(reachable: Reachability, rest: Footing, place: int, at: int) -> int:
    """Samples the body gets to on the feet that stay, from a state at ``place``, or none."""
    carries = reachable.carries(rest)
    window = place & carries
    samples = reachable.samples
    return samples.unbroken(carries, samples.nearest(window, at)) if window else 0


def _longest_lasting(reachable: Reachability, leg: int, stood: int, lifted: int) -> list[int]:
    """Footholds a leg lifted from number ``stood`` can be carried to, those that last longest."""
    able = [f for f in reachable.by_leg[leg] if lifted & reachable.existence[f]]
    if reachable.clearance.has_tall and stood >= 0:
        able = [f for f in able if reachable.crosses(stood, f)]
    able.sort(key=lambda f: -reachable.footholds[f].last)
    return able[:CHOICES]
