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

from ..geometry.paths import arc_exit, line_exit
from ..geometry.polygons import Polygon
from ..geometry.transforms import direction
from ..stability import stable_interval, stable_on_arc, support_polygon
from ..terrain.cells import FootholdMap
from .decision_log import DecisionLog, StepRefusal, note_cell, note_leg, note_reason
from .foothold_search import domain_of, landings
from .gait import AGREEMENT, IS_FRONT, OTHERS, SUCCESSOR, NominalGait, Posture
from .steps import BodyShift, Exits, Landing, Shift, SwingStep

# looked up once: members of an Enum are found slowly
MISSES = StepRefusal.MISSES
LEFT = StepRefusal.LEFT
NOT_YET = StepRefusal.NOT_YET
TOO_LATE = StepRefusal.TOO_LATE
STANDING_LEG = StepRefusal.STANDING_LEG
NO_FOOTHOLD = StepRefusal.NO_FOOTHOLD

STILL = 1e-6  # m; less than this is no motion
# m; a CoG this far outside an edge still counts as inside (a margin counts from -1 mm)
SLACK = 0.0005
# m a foot may stand outside its reach on an arc when it touches early, at mid-descent (H §4.5)
EARLY = 0.02

Accepts = Callable[[Shift, Landing], StepRefusal | None]


def after(nominal: NominalGait, posture: Posture, step: SwingStep) -> Posture:
    """The posture at N_{k+1}: the cheap roll-out of one step."""
    dx, dy, turn = nominal.path.pose(step.g)
    x, y = posture.absolute(dx, dy)
    feet = [(fx - dx, fy - dy) for fx, fy in posture.feet]
    feet[step.leg] = step.landing.x - dx, step.landing.y - dy
    if turn == 0.0:
        return Posture(x, y, posture.c, posture.s, tuple(feet), step.leg)
    c, s = direction(turn)
    feet = [(c * fx + s * fy, c * fy - s * fx) for fx, fy in feet]
    heading = posture.c * c - posture.s * s, posture.s * c + posture.c * s
    return Posture(x, y, *heading, tuple(feet), step.leg)


def shifted(posture: Posture, shift: BodyShift) -> Posture:
    """The posture after a four-leg shift."""
    x, y = posture.absolute(shift.x, shift.y)
    feet = tuple((fx - shift.x, fy - shift.y) for fx, fy in posture.feet)
    return posture._replace(x=x, y=y, feet=feet)


def exits_of(nominal: NominalGait, posture: Posture) -> Exits:
    """g_i of every leg: how far the body may go before leg i leaves its reach, never less than 0 (H
    §5.2 (4)-(10)).
    """
    path = nominal.path
    reach = zip(posture.feet, nominal.boxes, strict=True)
    if path.turn != 0.0:
        return tuple([arc_exit(fx, fy, box, path, EARLY) for (fx, fy), box in reach])
    ux, uy, _ = path
    exits = [line_exit(fx, fy, box, ux, uy) for (fx, fy), box in reach]
    return tuple([exit_ if exit_ > 0.0 else 0.0 for exit_ in exits])


def stable_on(nominal: NominalGait, polygon: Polygon, inset: float = 0.0) -> tuple[float, float]:
    """The s over which the CoG is inside a polygon along the path, by ``inset`` from every edge."""
    ux, uy, turn = nominal.path
    if turn == 0.0 and inset == 0.0:
        return stable_interval(polygon, 0.0, 0.0, ux, uy)
    return stable_on_arc(polygon, ux, uy, turn, inset)


def triangle_of(posture: Posture, leg: int) -> Polygon:
    """The support polygon of the legs that stay when ``leg`` swings."""
    i, j, k = OTHERS[leg]
    feet = posture.feet
    return support_polygon((feet[i], feet[j], feet[k]))


def shift_of(
    nominal: NominalGait,
    posture: Posture,
    exits: Exits,
    leg: int,
    margin: float | None = None,
) -> Shift | StepRefusal:
    """g0 and g when ``leg`` swings by the paper's rules, or why it cannot. ``margin`` replaces s0
    (a lookahead tries smaller ones).
    """
    i, j, k = OTHERS[leg]
    feet = posture.feet
    s0 = nominal.order.margin if margin is None else margin
    low, high = stable_on(nominal, support_polygon((feet[i], feet[j], feet[k])))
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
    nominal: NominalGait,
    posture: Posture,
    exits: Exits,
    leg: int,
    margin: float = 0.0,
    inset: float = 0.0,
) -> Shift | StepRefusal:
    """As ``shift_of`` for a leg of any place on any path: on four legs into the triangle, then on
    as far as it carries and every standing leg reaches.

    ``margin`` is kept along the path from both ends of the stretch in the triangle (less where that
    is short), ``inset`` square to the triangle's edges.
    """
    i, j, k = OTHERS[leg]
    low, high = stable_on(nominal, triangle_of(posture, leg), inset)
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


def leg_order(
    nominal: NominalGait, posture: Posture, exits: Exits
) -> list[tuple[int, Shift | StepRefusal]]:
    """Legs in the order they are to be tried, with their shifts (H §5.1, fig. 9 as reconstructed).

    First legs whose removal leaves pairs of feet standing as in the nominal walk, more agreeing
    pairs first and the nominal successor winning a tie; then the longest return. A leg that cannot
    swing falls to the back.
    """
    ranked = []
    successor = SUCCESSOR[posture.last] if posture.last >= 0 else -1
    for leg in range(4):
        if leg == posture.last:
            continue
        shift = shift_of(nominal, posture, exits, leg)
        agreeing = agreeing_pairs(nominal, posture, leg)
        rank = (
            isinstance(shift, StepRefusal),
            -agreeing,
            not (agreeing and leg == successor),
            -return_length(nominal, posture, leg),
        )
        ranked.append((rank, leg, shift))
    ranked.sort(key=_rank)
    return [(leg, shift) for _, leg, shift in ranked]


def _rank(
    entry: tuple[tuple[bool, int, bool, float], int, Shift | StepRefusal],
) -> tuple[bool, int, bool, float]:
    return entry[0]


def agreeing_pairs(nominal: NominalGait, posture: Posture, leg: int) -> int:
    """How many of the two pairs that stay stand to each other as in the layout in which ``leg``
    swings next.
    """
    near = AGREEMENT * nominal.stride
    feet = posture.feet
    count = 0
    for i, j, dx, dy in nominal.pairs[leg]:
        (ix, iy), (jx, jy) = feet[i], feet[j]
        if abs(ix - jx - dx) <= near and abs(iy - jy - dy) <= near:
            count += 1
    return count


def return_length(nominal: NominalGait, posture: Posture, leg: int) -> float:
    """ΔU: along the course, from the foot to the forward end of its stroke."""
    ux, uy, _ = nominal.path
    (cx, cy), (fx, fy) = nominal.centres[leg], posture.feet[leg]
    return (cx - fx) * ux + (cy - fy) * uy + (nominal.stride - nominal.ends[leg])


def planned_margin(nominal: NominalGait, posture: Posture, shift: Shift) -> float:
    """Least longitudinal margin of the whole step against the feet that carry in each phase (H
    §2.4).
    """
    margin = min(shift.g0 - shift.low, shift.high - shift.g)
    if shift.g0 > 0.0:
        low, high = stable_on(nominal, support_polygon(posture.feet))
        margin = min(margin, -low, high - shift.g0)
    return margin


def body_shift_to(posture: Posture, x: float, y: float) -> BodyShift:
    """The four-leg shift to (x, y) with the margin it keeps along its way."""
    way = math.hypot(x, y)
    low, high = stable_interval(support_polygon(posture.feet), 0.0, 0.0, x / way, y / way)
    return BodyShift(x, y, min(-low, high - way))


# the paper's policy


def decide(
    nominal: NominalGait,
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
    exits = exits_of(nominal, posture)
    for leg, shift in chain(
        leg_order(nominal, posture, exits), _once_more(nominal, posture, exits)
    ):
        trial = None if log is None else _noted(log, nominal, posture, leg, shift)
        if isinstance(shift, StepRefusal):
            continue
        step = foothold_step(nominal, posture, exits, shift, cells, accepts, trial)
        if step is None:
            note_reason(trial, NO_FOOTHOLD)
        elif changes_nothing(posture, step):
            note_reason(trial, StepRefusal.NOTHING)
        else:
            return step
    return None


def _once_more(
    nominal: NominalGait, posture: Posture, exits: Exits
) -> Iterator[tuple[int, Shift | StepRefusal]]:
    """The leg that swung last, for when no other helps: what H reaches by a step of another leg
    that changes nothing.
    """
    if posture.last >= 0:
        yield posture.last, shift_of(nominal, posture, exits, posture.last)


def _noted(
    log: DecisionLog, nominal: NominalGait, posture: Posture, leg: int, shift: Shift | StepRefusal
) -> DecisionLog | None:
    trial = note_leg(
        log,
        nominal.body_leg[leg],
        agreeing_pairs=agreeing_pairs(nominal, posture, leg),
        return_length=return_length(nominal, posture, leg),
    )
    if isinstance(shift, StepRefusal):
        note_reason(trial, shift)
    elif trial is not None:
        trial |= {"g0": shift.g0, "g": shift.g, "stable": [shift.low, shift.high]}
    return trial


def foothold_step(
    nominal: NominalGait,
    posture: Posture,
    exits: Exits,
    shift: Shift,
    cells: FootholdMap,
    accepts: Accepts | None = None,
    trial: DecisionLog | None = None,
) -> SwingStep | None:
    """The step of one leg to its J_u: D_u with method II first, then without it; None when D_u has
    no foothold.
    """
    for convergent in (True,) if IS_FRONT[shift.leg] else (True, False):
        for step in steps_to(nominal, posture, exits, shift, cells, convergent, trial):
            refusal = accepts(shift, step.landing) if accepts is not None else None
            if refusal is None:
                return step
            if trial is None and refusal is STANDING_LEG:
                return None
            note_cell(trial, step.landing.ax, step.landing.ay, refusal)
    return None


def steps_to(
    nominal: NominalGait,
    posture: Posture,
    exits: Exits,
    shift: Shift,
    cells: FootholdMap,
    convergent: bool = True,
    trial: DecisionLog | None = None,
) -> Iterator[SwingStep]:
    """Every step of one leg with one shift, to its footholds in the order of H §5.5: what a
    lookahead picks candidates from.
    """
    leg = shift.leg
    margin = planned_margin(nominal, posture, shift)
    domain = domain_of(nominal, posture.feet, exits, leg, shift.g, convergent)
    for start, landing in landings(nominal, posture, domain, exits, cells, trial):
        yield SwingStep(leg, shift.g0, shift.g, start, landing, margin, convergent)


def changes_nothing(posture: Posture, step: SwingStep) -> bool:
    """True when the body would stay and the foot come down where it stands.

    Not taking such steps is ours, not H's: with them, two legs take turns on the spot for ever (a
    tenth of random postures, every long walk over 30 % blocked cells).
    """
    if step.g > STILL:
        return False
    fx, fy = posture.feet[step.leg]
    return abs(step.landing.x - fx) <= STILL and abs(step.landing.y - fy) <= STILL
