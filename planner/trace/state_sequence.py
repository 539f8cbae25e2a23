"""The state sequence in K's order ("calculation of states"): lift the leg that must leave first; if
that cannot be, move one other leg first, then two together, then three.

A state is which feet stand where, and the sample the body has reached in it. Successive states
overlap there by making.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

from ..geometry.transforms import turned_back
from .footholds import AIR, Footing, legs_clear
from .reachability import Reachability
from .samples import first_bit, run_end, span

HIND = 0
MIDDLE = 1
FORE = 2
# a leg is fore (hind) when it leads (trails) by over this part of the foremost leg's lead
FORE_PART = 0.25
STEP_FIRST = 8  # samples the s-iteration first goes ahead


class SupportState(NamedTuple):
    """Footing on footholds (or in the air), and the sample ``at`` which the body is when this state
    begins.
    """

    feet: Footing
    at: int


def end_of(reachable: Reachability, state: SupportState) -> int:
    """K's S2 of a state: the last sample the body reaches before a leg must leave or stability
    ends.
    """
    return run_end(reachable.valid(state.feet), state.at)


def k_step(reachable: Reachability, state: SupportState) -> list[SupportState] | None:
    """The next states by K's rule: Q0 -> U_i0, else Q0 -> U_j -> D_j -> U_i0, then pairs, then
    triples; None where it fails.

    Each U is followed by its D, where the s-iteration puts the leg down. A sequence counts as
    realised when the leg that had to leave then lasts longer than before.
    """
    reached = end_of(reachable, state)
    standing = [leg for leg, f in enumerate(state.feet) if f >= 0]
    if len(standing) < 3:
        return None
    waiting = [leg for leg, f in enumerate(state.feet) if f < 0]
    # a leg the search has left in the air comes down as soon as there is ground for it
    for leg in waiting:
        placed = put_down(reachable, state.feet, state.at, reached, (leg,))
        if placed is not None:
            return [placed]
    must_leave = min(standing, key=lambda leg: reachable.footholds[state.feet[leg]].last)
    others = [leg for leg in standing if leg != must_leave]
    for together in range(4):
        for first in combinations(others, together):
            states: list[SupportState] = []
            now: SupportState | None = state
            if first:
                now = transfer(reachable, state, first, states)
            if now is not None:
                now = transfer(reachable, now, (must_leave,), states)
            if (
                now is not None
                and reachable.footholds[now.feet[must_leave]].last
                > reachable.footholds[state.feet[must_leave]].last
            ):
                return states
    return None


def transfer(
    reachable: Reachability, state: SupportState, legs: tuple[int, ...], states: list[SupportState]
) -> SupportState | None:
    """Lift ``legs`` together and put them down again: appends U and D to ``states``; None when that
    cannot be.
    """
    lifted = tuple(AIR if leg in legs else f for leg, f in enumerate(state.feet))
    overlap = reachable.valid(lifted) & span(state.at, end_of(reachable, state))
    if not overlap:
        return None
    begins = first_bit(overlap)
    placed = put_down(reachable, lifted, begins, run_end(reachable.valid(lifted), begins), legs)
    if placed is not None:
        states += (SupportState(lifted, begins), placed)
    return placed


def put_down(
    reachable: Reachability, feet: Footing, begins: int, ends: int, legs: tuple[int, ...]
) -> SupportState | None:
    """K "calculation of footholds" for legs in the air while the state [begins, ends] lasts: where,
    and at which sample.
    """
    at = first_guess(reachable, begins, ends, legs)
    while True:
        chosen = iterate(reachable, feet, at, legs)
        if chosen is not None:
            return SupportState(chosen, at)
        if at == begins:
            return None
        at = (begins + at) // 2 if at - begins > 1 else begins  # bisection, back on s


def first_guess(reachable: Reachability, begins: int, ends: int, legs: tuple[int, ...]) -> int:
    """Where the iteration starts: S2 for hind legs, half way for middle legs, a third of the way
    for fore legs.
    """
    kind = min(leg_kind(reachable, begins, leg) for leg in legs)
    return (ends, (begins + ends) // 2, (2 * begins + ends) // 3)[kind]


def leg_kind(reachable: Reachability, sample: int, leg: int) -> int:
    """Whether a leg is hind, middle or fore along the course (sideways the left legs lead)."""
    x = reachable.lane.x[0]
    y = reachable.lane.y[0]
    k = min(sample % reachable.samples.width, reachable.samples.count - 2)
    yaw = reachable.lane.yaw[k]
    ux, uy = turned_back(float(x[k + 1] - x[k]), float(y[k + 1] - y[k]), yaw)
    centres = [description.centre for description in reachable.machine.legs]
    lead = [ux * cx + uy * cy for cx, cy in centres]
    most = max(max(lead), -min(lead))
    if most < 1e-9 or abs(lead[leg]) <= FORE_PART * most:
        return MIDDLE
    return FORE if lead[leg] > 0.0 else HIND


def iterate(
    reachable: Reachability, feet: Footing, at: int, legs: tuple[int, ...]
) -> Footing | None:
    """The s-iteration: truncate the legs' domains ever farther ahead while they still hold points
    that carry at ``at``.

    The step doubles while it succeeds and is bisected when a domain runs empty; what is left at the
    end are the footholds whose segments reach farthest.
    """
    domains = [
        [f for f in reachable.by_leg[leg] if reachable.existence[f] >> at & 1] for leg in legs
    ]
    best = choose(reachable, feet, at, domains, at)
    if best is None:
        return None
    good = at
    step = STEP_FIRST
    bad = reachable.samples.count
    while bad - good > 1:
        ahead = good + step if good + step < bad else (good + bad) // 2
        chosen = choose(reachable, feet, at, domains, ahead)
        if chosen is not None:
            best = chosen
            good = ahead
            step = 2 * step
        else:
            bad = ahead
            step = max(step // 2, 1)
    return best


def choose(
    reachable: Reachability, feet: Footing, at: int, domains: list[list[int]], ahead: int
) -> Footing | None:
    """One foothold for each leg from the domains truncated at ``ahead``, such that the new state is
    stable at ``at``.
    """
    holds = reachable.footholds
    radius = reachable.machine.foot_radius
    for domain in domains:
        for f in domain:
            if holds[f].last >= ahead and legs_clear(holds, feet, holds[f], radius):
                feet = feet[: holds[f].leg] + (f,) + feet[holds[f].leg + 1 :]
                break
        else:
            return None
    return feet if reachable.stability.stable(feet) >> at & 1 else None
