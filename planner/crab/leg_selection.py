"""Level B2 (H §5): which leg swings next, how far the body goes, and with ``landing`` where the
foot comes down.

Pure plane geometry in the canonical frame of ``standard``, origin at the CoG at N_k (H's E_k): no
heights, no times, no arrays. ``decide`` is the paper's policy; its parts (``leg_order``,
``shift_of``, ``landing.landings``) and ``after`` are what a lookahead rolls forward.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain
from typing import Any, NamedTuple

from ..geometry.paths import line_exit
from ..stability import XY, stable_interval, support_polygon
from .foothold_search import Ground, Landing, domain_of, landings
from .gait import AGREEMENT, IS_FRONT, OTHERS, SUCCESSOR, Posture, Standard

STILL = 1e-6  # m; less than this is no motion
# whatever the foothold: no use to try another with this shift
STANDING_LEG = "a leg that stands would run into something tall"
# m; a CoG this far outside an edge still counts as inside (a margin counts from -1 mm)
SLACK = 0.0005

Notes = dict[str, Any]
Accepts = Callable[["Shift", Landing], str | None]


class Shift(NamedTuple):
    """How far the body goes while one leg swings: g0 on four legs, g in all; the CoG is over the
    triangle on [low, high].
    """

    leg: int
    g0: float
    g: float
    low: float
    high: float


class Step(NamedTuple):
    """One step of Level B2 and nothing else: who swings, how far, and where the foot goes.
    Canonical frame, E_k.
    """

    leg: int
    g0: float
    g: float
    start: XY  # I_u
    landing: Landing  # J_u
    margin: float  # least longitudinal margin against the feet that carry
    convergent: bool  # J_u satisfies domain method II (always so for a front leg)


def after(standard: Standard, posture: Posture, step: Step) -> Posture:
    """The posture at N_{k+1}: the cheap roll-out of one step."""
    dx, dy = step.g * standard.ux, step.g * standard.uy
    feet = [(fx - dx, fy - dy) for fx, fy in posture.feet]
    feet[step.leg] = step.landing.x - dx, step.landing.y - dy
    x, y = posture.absolute(dx, dy)
    return Posture(x, y, posture.c, posture.s, tuple(feet), step.leg)


def exits_of(standard: Standard, posture: Posture) -> tuple[float, float, float, float]:
    # H §5.2 (4)-(10)
    """g_i of every leg: how far the body may go before leg i leaves its reach, never less than 0."""
    ux, uy = standard.ux, standard.uy
    a, b, c, d = (
        max(0.0, line_exit(fx, fy, box, ux, uy))
        for (fx, fy), box in zip(posture.feet, standard.boxes, strict=True)
    )
    return a, b, c, d


def shift_of(
    standard: Standard,
    posture: Posture,
    exits: tuple[float, float, float, float],
    leg: int,
    margin: float | None = None,
) -> Shift | str:
    """g0 and g when ``leg`` swings, or why it cannot. ``margin`` replaces s0 (a lookahead tries
    smaller ones).
    """
    i, j, k = OTHERS[leg]
    feet, s0 = posture.feet, standard.margin if margin is None else margin
    low, high = stable_interval(
        support_polygon((feet[i], feet[j], feet[k])), 0.0, 0.0, standard.ux, standard.uy
    )
    if low > high:
        return "the course misses the triangle of the other feet"
    if high < -SLACK:
        return "the centre of gravity has already left the triangle of the other feet"  # (13a)
    g_max = min(exits[i], exits[j], exits[k])  # (12)
    if IS_FRONT[leg]:
        if low > SLACK:
            return "the centre of gravity is not yet in the triangle of the other feet"
        return Shift(leg, 0.0, min(g_max, max(0.0, high - s0)), low, high)  # (13b) (13c) (13d)
    g0_max = min(g_max, exits[leg])  # (11)
    if low > g0_max + SLACK:
        # (14a)
        return "the centre of gravity cannot enter the triangle of the other feet before a leg leaves its reach"
    # (14b) (14c) (14d), and no farther than the triangle's middle
    g0 = max(0.0, min(low + min(s0, (high - low) / 2), g0_max))
    return Shift(leg, g0, max(g0, min(g_max, high)), low, high)


def leg_order(
    standard: Standard, posture: Posture, exits: tuple[float, float, float, float]
) -> list[tuple[int, Shift | str]]:
    """Legs in the order they are to be tried, with their shifts (H §5.1, fig. 9 as reconstructed).

    First legs whose removal leaves pairs of feet standing as in the standard walk, more agreeing
    pairs first and the standard successor winning a tie; then the longest return. A leg that cannot
    swing falls to the back.
    """
    ranked = []
    successor = SUCCESSOR[posture.last] if posture.last >= 0 else -1
    for leg in range(4):
        if leg == posture.last:
            continue
        shift = shift_of(standard, posture, exits, leg)
        agreeing = agreeing_pairs(standard, posture, leg)
        rank = (
            isinstance(shift, str),
            -agreeing,
            not (agreeing and leg == successor),
            -return_length(standard, posture, leg),
        )
        ranked.append((rank, leg, shift))
    ranked.sort(key=_rank)
    return [(leg, shift) for _, leg, shift in ranked]


def _rank(
    entry: tuple[tuple[bool, int, bool, float], int, Shift | str],
) -> tuple[bool, int, bool, float]:
    return entry[0]


def agreeing_pairs(standard: Standard, posture: Posture, leg: int) -> int:
    """How many of the two pairs that stay stand to each other as in the layout in which ``leg``
    swings next.
    """
    near, feet, count = AGREEMENT * standard.stride, posture.feet, 0
    for i, j, dx, dy in standard.pairs[leg]:
        (ix, iy), (jx, jy) = feet[i], feet[j]
        if abs(ix - jx - dx) <= near and abs(iy - jy - dy) <= near:
            count += 1
    return count


def return_length(standard: Standard, posture: Posture, leg: int) -> float:
    """ΔU: along the course, from the foot to the forward end of its stroke."""
    (cx, cy), (fx, fy) = standard.centres[leg], posture.feet[leg]
    return (cx - fx) * standard.ux + (cy - fy) * standard.uy + standard.stride / 2


def planned_margin(standard: Standard, posture: Posture, shift: Shift) -> float:
    """Least longitudinal margin of the whole step against the feet that carry in each phase (H
    §2.4).
    """
    margin = min(shift.g0 - shift.low, shift.high - shift.g)
    if shift.g0 > 0.0:
        low, high = stable_interval(
            support_polygon(posture.feet), 0.0, 0.0, standard.ux, standard.uy
        )
        margin = min(margin, -low, high - shift.g0)
    return margin


def decide(
    standard: Standard,
    posture: Posture,
    ground: Ground,
    accepts: Accepts | None = None,
    notes: Notes | None = None,
) -> Step | None:
    """The paper's choice at N_k: the first leg in order that can swing and finds a foothold; None
    when no leg is left.

    ``accepts`` may refuse a foothold for reasons that are not of the plane (height). ``notes``
    collects what was tried.
    """
    exits = exits_of(standard, posture)
    for leg, shift in chain(
        leg_order(standard, posture, exits), _once_more(standard, posture, exits)
    ):
        trial = _note_leg(standard, posture, notes, leg, shift)
        if isinstance(shift, str):
            continue
        step = foothold_step(standard, posture, exits, shift, ground, accepts, trial)
        if step is None:
            _note_reason(trial, "no foothold in the search domain")
        elif changes_nothing(posture, step):
            _note_reason(trial, "the step would change nothing")
        else:
            return step
    return None


def _once_more(
    standard: Standard, posture: Posture, exits: tuple[float, float, float, float]
) -> Iterator[tuple[int, Shift | str]]:
    """The leg that swung last, for when no other helps: what H reaches by a step of another leg
    that changes nothing.
    """
    if posture.last >= 0:
        yield posture.last, shift_of(standard, posture, exits, posture.last)


def foothold_step(
    standard: Standard,
    posture: Posture,
    exits: tuple[float, float, float, float],
    shift: Shift,
    ground: Ground,
    accepts: Accepts | None = None,
    trial: Notes | None = None,
) -> Step | None:
    """The step of one leg to its J_u: D_u with method II first, then without it; None when D_u has
    no foothold.
    """
    for convergent in (True,) if IS_FRONT[shift.leg] else (True, False):
        for step in steps_to(standard, posture, exits, shift, ground, convergent, trial):
            refusal = accepts(shift, step.landing) if accepts is not None else None
            if refusal is None:
                return step
            if trial is None and refusal is STANDING_LEG:
                return None
            _note_cell(trial, step.landing, refusal)
    return None


def steps_to(
    standard: Standard,
    posture: Posture,
    exits: tuple[float, float, float, float],
    shift: Shift,
    ground: Ground,
    convergent: bool = True,
    trial: Notes | None = None,
) -> Iterator[Step]:
    """Every step of one leg with one shift, to its footholds in the order of H §5.5: what a
    lookahead picks candidates from.
    """
    leg, margin = shift.leg, planned_margin(standard, posture, shift)
    domain = domain_of(standard, posture.feet, exits, leg, shift.g, convergent)
    for start, landing in landings(standard, posture, domain, exits, shift.g, ground, trial):
        yield Step(leg, shift.g0, shift.g, start, landing, margin, convergent)


def changes_nothing(posture: Posture, step: Step) -> bool:
    """True when the body would stay and the foot come down where it stands.

    Not taking such steps is ours, not H's: with them, two legs take turns on the spot for ever (a
    tenth of random postures, every long walk over 30 % blocked cells).
    """
    fx, fy = posture.feet[step.leg]
    return (
        step.g <= STILL and abs(step.landing.x - fx) <= STILL and abs(step.landing.y - fy) <= STILL
    )


def _note_leg(
    standard: Standard, posture: Posture, notes: Notes | None, leg: int, shift: Shift | str
) -> Notes | None:
    if notes is None:
        return None
    trial: Notes = {
        "leg": standard.body_leg[leg] + 1,
        "agreeing_pairs": agreeing_pairs(standard, posture, leg),
        "return_length": return_length(standard, posture, leg),
        "refused": [],
    }
    if isinstance(shift, str):
        trial["reason"] = shift
    else:
        trial |= {"g0": shift.g0, "g": shift.g, "stable": [shift.low, shift.high]}
    notes.setdefault("legs", []).append(trial)
    return trial


def _note_reason(trial: Notes | None, reason: str) -> None:
    if trial is not None:
        trial["reason"] = reason


def _note_cell(trial: Notes | None, landing: Landing, reason: str) -> None:
    if trial is not None:
        trial["refused"].append({"x": landing.ax, "y": landing.ay, "reason": reason})
