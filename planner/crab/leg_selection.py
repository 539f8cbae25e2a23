"""Level B2 (H §5): which leg swings next, how far the body goes, and where the foot comes down.

Pure plane geometry in the gait frame, origin at the CoG at N_k (H's E_k): no heights, no times, no
arrays. ``decide`` is the paper's policy on a line; its parts (``leg_order``, ``shift_of``,
``steps_to``) and ``after`` are what a lookahead rolls forward. ``free_shift`` is the shift of any
leg on any path: what the searches of ``candidates`` and ``turning`` go by.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import chain

from ..decision_log import DecisionLog, note_cell, note_leg, note_reason
from ..geometry.polygons import Polygon, triangle
from ..geometry.transforms import XY, direction
from ..motion.leg_order import IS_FRONT, OTHERS, SUCCESSOR
from ..stability import stable_interval, stable_on
from ..terrain.cells import FootholdMap
from .foothold_search import domain_of, landings
from .gait import AGREEMENT, Posture
from .step_refusals import StepRefusal
from .steps import BodyShift, Landing, Shift, SwingStep

# looked up once: members of an Enum are found slowly
MISSES = StepRefusal.MISSES
LEFT = StepRefusal.LEFT
NOT_YET = StepRefusal.NOT_YET
TOO_LATE = StepRefusal.TOO_LATE
STANDING_LEG = StepRefusal.STANDING_LEG

STILL = 1e-6  # m; less than this is no motion
# m; a CoG this far outside an edge still counts as inside (a margin counts from -1 mm)
SLACK = 1e-6

Accepts = Callable[[Shift, Landing], StepRefusal | None]
LegShift = tuple[int, Shift | StepRefusal]


def after(posture: Posture, step: SwingStep) -> Posture:
    """The posture at N_{k+1}: the cheap roll-out of one step."""
    dx, dy, turn = posture.nominal.path.pose(step.g)
    x, y = posture.absolute(dx, dy)
    c, s = posture.c, posture.s
    feet = [(fx - dx, fy - dy) for fx, fy in posture.feet]
    feet[step.leg] = step.landing.x - dx, step.landing.y - dy
    if turn != 0.0:
        ct, st = direction(turn)
        feet = [(ct * fx + st * fy, ct * fy - st * fx) for fx, fy in feet]
        c, s = c * ct - s * st, s * ct + c * st
    return Posture(posture.nominal, x, y, c, s, tuple(feet), step.leg)


def shifted(posture: Posture, shift: BodyShift) -> Posture:
    """The posture after a four-leg shift."""
    x, y = posture.absolute(shift.x, shift.y)
    feet = tuple((fx - shift.x, fy - shift.y) for fx, fy in posture.feet)
    return Posture(posture.nominal, x, y, posture.c, posture.s, feet, posture.last)


def triangle_of(posture: Posture, leg: int) -> Polygon:
    """The support polygon of the legs that stay when ``leg`` swings."""
    i, j, k = OTHERS[leg]
    feet = posture.feet
    return triangle(feet[i], feet[j], feet[k])


def stretch_without(posture: Posture, leg: int) -> XY:
    """From where to where on a straight course the legs that stay carry when ``leg`` swings, m."""
    known = posture.stretches
    if leg not in known:
        known[leg] = stable_on(posture.nominal.path, triangle_of(posture, leg))
    return known[leg]


def shift_of(posture: Posture, leg: int, margin: float | None = None) -> Shift | StepRefusal:
    """g0 and g when ``leg`` swings by the paper's rules, or why it cannot. ``margin`` replaces s0
    (a lookahead tries smaller ones).
    """
    nominal = posture.nominal
    exits = posture.exits
    i, j, k = OTHERS[leg]
    s0 = nominal.order.margin if margin is None else margin
    if leg in posture.kept_down:
        return StepRefusal.KEPT_DOWN
    low, high = stretch_without(posture, leg)
    if low > high:
        return MISSES
    if high < -SLACK:
        return LEFT  # (13a)
    g_max = min(exits[i], exits[j], exits[k])  # (12)
    if IS_FRONT[leg]:
        if low > SLACK:
            return NOT_YET
        return Shift(leg, 0.0, min(g_max, max(0.0, high - s0)), low, high)  # (13b) (13c) (13d)
    g0_max = min(g_max, exits[leg])  # (11)
    if low > g0_max + SLACK:
        return TOO_LATE  # (14a)
    # (14b) (14c) (14d), and no farther than the triangle's middle
    g0 = max(0.0, min(low + min(s0, (high - low) / 2), g0_max))
    return Shift(leg, g0, max(g0, min(g_max, high)), low, high)


def free_shift(
    posture: Posture, leg: int, margin: float = 0.0, inset: float = 0.0
) -> Shift | StepRefusal:
    """As ``shift_of`` for a leg of any place on any path: on four legs into the triangle, then on
    as far as it carries and every standing leg reaches.

    ``margin`` is kept along the path from both ends of the stretch in the triangle (less where that
    is short), ``inset`` square to the triangle's edges.
    """
    exits = posture.exits
    i, j, k = OTHERS[leg]
    if leg in posture.kept_down:
        return StepRefusal.KEPT_DOWN
    low, high = stable_on(posture.nominal.path, triangle_of(posture, leg), inset)
    if low > high:
        return MISSES
    if high < 0.0:
        return LEFT
    g_max = min(exits[i], exits[j], exits[k])  # H §5.2 (12)
    g0_max = min(g_max, exits[leg])
    if low > g0_max:
        return TOO_LATE
    margin = min(margin, (high - low) / 2)
    g0 = min(max(0.0, low + margin), g0_max)
    return Shift(leg, g0, max(g0, min(g_max, high - margin)), low, high, inset)


def leg_order(posture: Posture) -> Iterator[LegShift]:
    """Legs in the order they are to be tried, with their shifts (H §5.1, fig. 9 as reconstructed).

    First legs whose removal leaves pairs of feet standing as in the nominal walk, more agreeing
    pairs first and the nominal successor winning a tie; then the longest return. A leg that cannot
    swing falls to the back. Shifts are worked out as they are asked for: most often the first.
    """
    last = posture.last
    successor = SUCCESSOR[last] if last >= 0 else -1
    ranked = []
    for leg in range(4):
        if leg == last:
            continue
        agreeing = agreeing_pairs(posture, leg)
        second = not (agreeing and leg == successor)
        ranked.append((-agreeing, second, -return_length(posture, leg), leg))
    ranked.sort()
    stuck = []
    for _, _, _, leg in ranked:
        shift = shift_of(posture, leg)
        if isinstance(shift, Shift):
            yield leg, shift
        else:
            stuck.append((leg, shift))
    yield from stuck


def agreeing_pairs(posture: Posture, leg: int) -> int:
    """How many of the two pairs that stay stand as in the layout in which ``leg`` swings next."""
    near = AGREEMENT * posture.nominal.stride
    feet = posture.feet
    count = 0
    for i, j, dx, dy in posture.nominal.pairs[leg]:
        (ix, iy), (jx, jy) = feet[i], feet[j]
        if abs(ix - jx - dx) <= near and abs(iy - jy - dy) <= near:
            count += 1
    return count


def return_length(posture: Posture, leg: int) -> float:
    """ΔU: along the course, from the foot to the forward end of its stroke."""
    nominal = posture.nominal
    ux, uy, _ = nominal.path
    (cx, cy), (fx, fy) = nominal.centres[leg], posture.feet[leg]
    return (cx - fx) * ux + (cy - fy) * uy + (nominal.stride - nominal.ends[leg])


def planned_margin(posture: Posture, shift: Shift) -> float:
    """Least longitudinal margin of a step against the feet that carry in each phase (H §2.4)."""
    margin = min(shift.g0 - shift.low, shift.high - shift.g)
    if shift.g0 > 0.0:
        low, high = posture.carried
        margin = min(margin, -low, high - shift.g0)
    return margin


def body_shift_to(posture: Posture, x: float, y: float) -> BodyShift:
    """The four-leg shift to (x, y) with the margin it keeps along its way."""
    way = math.hypot(x, y)
    low, high = stable_interval(posture.support, 0.0, 0.0, x / way, y / way)
    return BodyShift(x, y, min(-low, high - way))


# the paper's policy


def decide(
    posture: Posture,
    cells: FootholdMap,
    accepts: Accepts | None = None,
    log: DecisionLog | None = None,
) -> SwingStep | None:
    """The paper's choice at N_k: the first leg in order that can swing and finds a foothold; None
    when no leg is left.

    ``accepts`` may refuse a foothold for reasons that are not of the plane (height). ``log``
    collects what was tried.
    """
    # at last the leg that swung last: what H reaches by a step of another that changes nothing
    again = ((leg, shift_of(posture, leg)) for leg in (posture.last,) if leg >= 0)
    for leg, shift in chain(leg_order(posture), again):
        trial = None if log is None else _noted(log, posture, leg, shift)
        if not isinstance(shift, Shift):
            continue
        step = next(steps_to(posture, shift, cells, accepts, trial), None)
        if step is None:
            note_reason(trial, StepRefusal.NO_FOOTHOLD)
        elif changes_nothing(posture, step, step.landing):
            note_reason(trial, StepRefusal.NOTHING)
        else:
            return step
    return None


def _noted(
    log: DecisionLog, posture: Posture, leg: int, shift: Shift | StepRefusal
) -> DecisionLog | None:
    trial = note_leg(
        log,
        posture.nominal.body_leg[leg],
        agreeing_pairs=agreeing_pairs(posture, leg),
        return_length=return_length(posture, leg),
    )
    if isinstance(shift, StepRefusal):
        note_reason(trial, shift)
    elif trial is not None:
        trial |= {"g0": shift.g0, "g": shift.g, "stable": [shift.low, shift.high]}
    return trial


def steps_to(
    posture: Posture,
    shift: Shift,
    cells: FootholdMap,
    accepts: Accepts | None = None,
    trial: DecisionLog | None = None,
) -> Iterator[SwingStep]:
    """Every step of one leg with one shift, to its footholds in the order of H §5.5, those of D_u
    with method II first; the first one is the paper's, others are a lookahead's.
    """
    leg, g0, g = shift[:3]
    margin = planned_margin(posture, shift)
    for convergent in (True,) if IS_FRONT[leg] else (True, False):
        domain = domain_of(posture, leg, g, convergent)
        for start, landing in landings(posture, domain, cells, trial):
            refusal = accepts(shift, landing) if accepts is not None else None
            if refusal is None:
                yield SwingStep(leg, g0, g, start, landing, margin, convergent)
            elif trial is not None:
                note_cell(trial, landing.ax, landing.ay, refusal)
            elif refusal is STANDING_LEG:
                return


def changes_nothing(posture: Posture, step: Shift | SwingStep, landing: Landing) -> bool:
    """True when the body would stay and the foot come down where it stands.

    Not taking such steps is ours, not H's: with them, two legs take turns on the spot for ever (a
    tenth of random postures, every long walk over 30 % blocked cells).
    """
    if step.g > STILL:
        return False
    fx, fy = posture.feet[step.leg]
    return abs(landing.x - fx) <= STILL and abs(landing.y - fy) <= STILL
