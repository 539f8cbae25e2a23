"""How far any way along a lane can lead at most: what tells a stuck search that it looks in vain.

Not in K. A few samples about the place are looked at with nearly everything relaxed that the search
keeps: every state that carries at the first of them counts as reached; feet may be put down as near
to one another as they like and be carried over anything; and a set of feet carries where in each of
DIRECTIONS directions from the centre of gravity one of them is the margin beyond it, which it is
where the centre is the margin inside their polygon. What cannot be reached even so, cannot be.

A footing is a place in an array with an axis for each leg, 0 for a leg in the air; its samples are
the bits of one word. The changes of all footings at all samples are then a few operations on whole
arrays.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import directions
from ..protocols import Weight
from .reachability import Reachability

BEHIND = 20  # before the farthest sample reached; fewer find ways that are none
AHEAD = 16  # and after it; with those before it no more than a word has bits
DIRECTIONS = 64
FOOTINGS_MAX = 60_000  # words looked at in each row; of more nothing is said
SLACK = 1e-6  # m by which feet may be nearer than the margin: covers rounding
WORDS_A_POSTURE = 50_000  # words worked on in the time one posture is looked at
SHIFTS = (1, 2, 4, 8, 16, 32)  # back along a run: each goes as far as all before it and one more
RUN_STEPS = 4 + 4 * len(SHIFTS)  # operations on whole arrays

Words = NDArray[np.uint64]


class _Window(NamedTuple):
    """So many samples of a lane from ``first`` on."""

    first: int
    width: int


class _Legs(NamedTuple):
    """What some legs offer together, an entry for each choice of a foothold or none of every one:
    in which samples they exist, and in which they are beyond the margin in each direction.
    """

    exists: Words  # (rows, choices)
    beyond: Words  # (rows, directions, choices)


def farthest_possible(
    reachable: Reachability, start: int, farthest: int
) -> Generator[Weight, None, int | None]:
    """A sample of the trace beyond which no way leads from ``start``, looked for about the
    ``farthest`` reached; None where none is found. Pauses after each part of the work.
    """
    first = max(start, farthest - BEHIND)
    window = _Window(first, min(reachable.samples.count - first, farthest + AHEAD - first))
    choices = [_choices(reachable, leg, window) for leg in range(len(reachable.by_leg))]
    counts = [1 + len(choice) for choice in choices]
    if math.prod(counts) > FOOTINGS_MAX:
        return None
    legs = [_of_leg(reachable, choice, window) for choice in choices]
    yield None
    carries = yield from _carrying(legs)
    reached = yield from _flooded(carries.reshape(len(carries), *counts))
    last = int(np.bitwise_or.reduce(reached, axis=None)).bit_length() - 1
    return None if last == window.width - 1 else first + last


def _choices(reachable: Reachability, leg: int, window: _Window) -> list[int]:
    """Footholds of a leg that exist within the window in some row."""
    samples = reachable.samples
    inside = samples.in_all_rows((1 << window.width) - 1 << window.first)
    return [f for f in reachable.by_leg[leg] if reachable.existence[f] & inside]


def _of_leg(reachable: Reachability, choices: list[int], window: _Window) -> _Legs:
    """What one leg offers; first that it is in the air."""
    samples = reachable.samples
    whole = (1 << window.width) - 1
    exists = np.full((samples.rows, 1 + len(choices)), whole, dtype=np.uint64)
    for n, f in enumerate(choices, 1):
        for row in range(samples.rows):
            exists[row, n] = samples.row_of(reachable.existence[f], row) >> window.first & whole
    beyond = np.zeros((samples.rows, DIRECTIONS, 1 + len(choices)), dtype=np.uint64)
    if choices:
        beyond[:, :, 1:] = _beyond(reachable, choices, window)
    return _Legs(exists, beyond)


def _beyond(reachable: Reachability, choices: list[int], window: _Window) -> Words:
    """(rows, directions, footholds): the samples at which a foothold is the margin beyond the
    centre of gravity in a direction.
    """
    lane = reachable.lane
    part = slice(window.first, window.first + window.width)
    ux, uy = directions(
        np.linspace(0.0, 2.0 * math.pi, DIRECTIONS, endpoint=False, dtype=np.float64)
    )
    x, y = (
        np.array([getattr(reachable.footholds[f], axis) for f in choices]) for axis in ("x", "y")
    )
    feet = ux[:, None] * x + uy[:, None] * y
    centre = ux[:, None] * lane.x[:, None, part] + uy[:, None] * lane.y[:, None, part]
    flags = np.zeros((len(lane.x), DIRECTIONS, len(choices), 64), dtype=bool)
    least = reachable.stability.least_margin - SLACK
    flags[..., : window.width] = feet[:, :, None] - centre[:, :, None, :] >= least
    packed = np.packbits(flags, axis=-1, bitorder="little")
    return np.asarray(packed.view("<u8")[..., 0], dtype=np.uint64)


def _carrying(legs: list[_Legs]) -> Generator[Weight, None, Words]:
    """(rows, footings): the samples at which each footing carries."""
    middle = len(legs) // 2
    some, others = _together(legs[:middle]), _together(legs[middle:])
    carries = some.exists[:, :, None] & others.exists[:, None, :]
    beyond = np.empty_like(carries)
    done = 0
    for n in range(DIRECTIONS):
        np.bitwise_or(some.beyond[:, n, :, None], others.beyond[:, n, None, :], out=beyond)
        carries &= beyond
        done += 2 * carries.size
        if done >= WORDS_A_POSTURE:
            yield done // WORDS_A_POSTURE
            done %= WORDS_A_POSTURE
    return carries.reshape(len(carries), -1)


def _together(legs: list[_Legs]) -> _Legs:
    """What some legs offer, every choice of one with every choice of the others."""
    exists, beyond = legs[0]
    for leg in legs[1:]:
        exists = (exists[:, :, None] & leg.exists[:, None, :]).reshape(len(exists), -1)
        joined = beyond[:, :, :, None] | leg.beyond[:, :, None, :]
        beyond = joined.reshape(len(exists), DIRECTIONS, -1)
    return _Legs(exists, beyond)


def _flooded(carries: Words) -> Generator[Weight, None, Words]:
    """(rows, footings of each leg …): the samples reached in each footing, from all that carry at
    the first one.
    """
    reached = carries & np.uint64(1)
    # with a leg in the air; whatever carries without it carries with it
    without = [np.take(carries, [0], axis=axis) for axis in range(1, carries.ndim)]
    while True:
        before = reached.copy()
        for row, carrying in zip(reached, carries, strict=True):
            _along_runs(row, carrying)
            yield 1 + RUN_STEPS * row.size // WORDS_A_POSTURE
        if len(carries) > 1:  # straight from one row to another
            reached |= np.bitwise_or.reduce(reached, axis=0) & carries
        for axis, waiting in enumerate(without, 1):
            lifted = np.bitwise_or.reduce(reached, axis=axis, keepdims=True) & waiting
            reached |= lifted & carries
        if np.array_equal(reached, before):
            return reached
        yield 1 + 3 * carries.ndim * carries.size // WORDS_A_POSTURE


def _along_runs(reached: Words, carries: Words) -> None:
    """Spread what is reached over the unbroken runs it lies in, within the words."""
    reached |= carries & ~(carries + reached)  # onward: the carry runs to the end of the run
    open_way = carries.copy()
    for shift in map(np.uint64, SHIFTS):
        reached |= open_way & (reached >> shift)
        open_way &= open_way >> shift
