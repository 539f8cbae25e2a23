"""Mode ``predictive``: the paper's step where it keeps the standard walk, else the best of several
rolled out on the known map.

The paper plans one step and can dead-lock, creep or crawl (gait-spec §4). Here each candidate is
followed for several steps, mostly with the paper's own policy, and the one that gets on best is
taken. In order: the paper's step, as long as the walk is standard and open ground ahead; on open
ground any step that leads back to the standard walk; on broken ground a beam over steps near the
paper's; where that does not get on, any foothold in reach and four-leg shifts; then ``escape``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterable, Iterator
from itertools import chain
from typing import NamedTuple

from ..search import Branch, Found, Option, beam, firsts, ranked, rollouts
from .candidates import SMALL, Field, State, Sway, near_steps, reserve, sways, wide_steps
from .foothold_search import NEAR
from .gait import AGREEMENT, SUCCESSOR, Posture, Standard
from .leg_selection import SLACK, Step, decide

# steps the beam looks ahead, and how many ways it follows; narrower and it dies on 80 % prohibited
# ground
DEPTH, WIDTH = 6, 6
PER_SHIFT = 6  # footholds of one leg and shift the beam tries
TWO_MARGINS = 3  # depths of the beam at which s0 is tried beside the smallest margin
# m of way given up for each m of margin below s0; 0: see margins of millimetres where there is no
# need
CARE = 0.1
GETS_ON = 0.6  # of the standard step; a beam slower than this is not good enough
BACK_STEPS = 12  # steps in which open ground should lead back to the standard walk
BACK_CARE = 0.5  # as CARE on open ground: more than any walk with less margin can gain
# steps rolled out for any foothold, for its successors, and how many get successors
GLANCE, LOOK, KEPT = 3, 6, 6
STUCK = 0.1  # of the standard step; slower is no walk
LOWER = 0.001  # m below s0 that still counts as the standard margin

Chosen = Step | Sway
Ways = list[Branch[State, Chosen]]
Ahead = Found[State, Chosen]
Work = Generator[None, bool | None, Ahead]


class Choice(NamedTuple):
    """What the search came to: ways by their first steps, best first, and which search it was."""

    search: str  # paper | back | near | wide
    ways: Ways
    horizon: int  # steps the ways were followed
    finished: bool = True  # False: the answer was wanted before the search was over

    @property
    def pace(self) -> float:
        """What the best way gains a step, m."""
        return self.ways[0].pace(self.horizon) if self.ways else 0.0


def standard_way(standard: Standard) -> float:
    """Way of the standard walk per step, m."""
    return standard.stride / (4.0 * standard.duty_factor)


def choose(field: Field, paper: Step | None) -> Generator[None, bool | None, Choice]:
    """The ways to go on from here, best first. ``send(True)`` asks for the best so far."""
    open_ahead = is_open(field)
    if paper is not None and (
        is_standard_step(field.standard, field.start.posture, paper)
        if open_ahead
        else stays_standard(field, paper)
    ):
        return Choice("paper", [Branch(paper, field.start, paper.g, paper.g, 1)], 1)
    enough = GETS_ON * standard_way(field.standard)
    if open_ahead:
        back = choice_of("back", (yield from _back_to_standard(field)), BACK_STEPS + 1)
        if not back.finished or back.pace >= enough:
            return back
    return (yield from best_of(field))


def best_of(field: Field) -> Generator[None, bool | None, Choice]:
    """The ways on from here over broken ground: near the paper's, and where those do not get on,
    any.
    """
    enough = GETS_ON * standard_way(field.standard)
    near = choice_of("near", (yield from look_near(field)), DEPTH)
    if not near.finished or near.pace >= enough:
        return near
    wide = choice_of("wide", (yield from look_wide(field)), LOOK + 2)
    if max(wide.pace, near.pace) < STUCK * standard_way(field.standard):
        wide = choice_of("wide", (yield from look_wide(field.daring())), LOOK + 2)
    best, other = (
        (wide, near) if wide.ways and (wide.pace > near.pace or not near.ways) else (near, wide)
    )
    return Choice(best.search, [*best.ways, *other.ways], best.horizon)


def choice_of(search: str, found: Ahead, horizon: int) -> Choice:
    """A search's result; one cut short is measured by the steps it came to."""
    if found.finished:
        return Choice(search, found.ways, horizon)
    return Choice(search, found.ways, found.ways[0].steps, False)


# the searches


def _back_to_standard(field: Field) -> Work:
    """Open ground: whatever first step the paper's own policy walks on from best, margins counted
    dear.
    """
    start = field.start
    gain = gain_with(field, BACK_CARE)
    margins = (field.standard.margin, min(SMALL, field.standard.margin))
    choices = chain(near_steps(field, start, margins, 3), any_steps(field, start))
    found: Ahead = yield from rollouts(
        _options(field, start, choices, gain, 0.0), policy_with(field, gain), BACK_STEPS
    )
    return found


def look_near(field: Field) -> Work:
    """Broken ground: steps near the paper's, several deep; what the footholds still hold is worth
    as much as way made.
    """
    standard = field.standard
    gain = gain_with(field, CARE)
    least = min(SMALL, standard.margin)

    def options(state: State, depth: int) -> Iterator[Option[State, Chosen]]:
        margins = (standard.margin, least) if depth < TWO_MARGINS else (least,)
        for step in near_steps(field, state, margins, PER_SHIFT):
            if not field.permits(state, step):
                continue
            reached = field.after(state, step)
            yield Option(step, reached, gain(step), reserve(standard, reached.posture))

    found: Ahead = yield from beam(field.start, options, DEPTH, WIDTH)
    return Found(firsts(found.ways), found.finished)


def look_wide(field: Field) -> Work:
    """Where the standard order has come to an end: any foothold in reach, followed by the paper's
    policy; then two of them.
    """
    start, gain = field.start, gain_with(field, CARE)
    policy = policy_with(field, gain)
    glanced: Ahead = yield from rollouts(
        _options(field, start, any_steps(field, start), gain, 0.5), policy, GLANCE
    )
    if not glanced.finished:
        return glanced
    found: Ways = []
    for branch in glanced.ways[:KEPT]:
        first = branch.first
        reached = field.after(start, first)
        successors = any_steps(field, reached, short=False)
        second = ((option, first) for option, _ in _options(field, reached, successors, gain, 0.0))
        looked: Ahead = yield from rollouts(second, policy, LOOK, gain(first), 1)
        found += looked.ways
        if not looked.finished:
            return Found(firsts([*ranked(found), *glanced.ways]), False)
    return Found(firsts([*ranked(found), *glanced.ways]), True)


def any_steps(field: Field, state: State, short: bool = True) -> Iterator[Chosen]:
    """Any foothold in reach and the four-leg shifts, found one by one: all at once is too much for
    a tick.
    """
    yield from wide_steps(field, state, short)
    yield from sways(field, state)


def _options(
    field: Field,
    state: State,
    choices: Iterable[Chosen],
    gain: Callable[[Chosen], float],
    hope: float,
) -> Iterator[tuple[Option[State, Chosen], Chosen]]:
    """Choices with where they lead; ``hope`` is the share of the reserve that counts as promised."""
    for choice in choices:
        if not field.permits(state, choice):
            continue
        reached = field.after(state, choice)
        yield (
            Option(
                choice,
                reached,
                gain(choice),
                hope * reserve(field.standard, reached.posture) if hope else 0.0,
            ),
            choice,
        )


def gain_with(field: Field, care: float) -> Callable[[Chosen], float]:
    """Way along the course, less ``care`` times the margin that is missing to s0."""
    s0 = field.standard.margin

    def gain(choice: Chosen) -> float:
        way = field.way(choice)
        return way - care * (s0 - choice.margin) if choice.margin < s0 else way

    return gain


def policy_with(
    field: Field, gain: Callable[[Chosen], float]
) -> Callable[[State], tuple[State, float] | None]:
    """The paper's policy as a rollout follows it, but for steps it could not take itself: promises
    nobody keeps make it mark time.
    """

    def policy(state: State) -> tuple[State, float] | None:
        step = decide(field.standard, state.posture, field.ground, field.accepts(state))
        return (
            None
            if step is None or step.margin < field.least - SLACK
            else (field.after(state, step), gain(step))
        )

    return policy


# when the paper's step will do


def stays_standard(field: Field, step: Step) -> bool:
    """The paper's policy keeps the standard walk for the whole horizon, whatever cells are
    prohibited.
    """
    state = field.start
    for _ in range(BACK_STEPS):
        if not is_standard_step(field.standard, state.posture, step):
            return False
        state = field.after(state, step)
        ahead = decide(field.standard, state.posture, field.ground, field.accepts(state))
        if ahead is None:
            return False
        step = ahead
    return True


def is_standard_step(standard: Standard, posture: Posture, step: Step) -> bool:
    """The walk is standard and stays so: the successor swings, by the standard distance, to I_u
    itself.
    """
    leg, tolerance = step.leg, AGREEMENT * standard.stride
    if posture.last >= 0 and leg != SUCCESSOR[posture.last]:
        return False
    (x, y), landing = step.start, step.landing
    return (
        abs(landing.x - x) <= NEAR
        and abs(landing.y - y) <= NEAR
        and step.g >= standard.shift_of(leg) - tolerance
        and step.margin >= standard.margin - LOWER
        and _on_stroke(standard, posture, tolerance)
        and _phases_hold(standard, posture, leg, tolerance)
    )


def _on_stroke(standard: Standard, posture: Posture, tolerance: float) -> bool:
    ux, uy = standard.ux, standard.uy
    return all(
        abs(ux * (fy - cy) - uy * (fx - cx)) <= tolerance
        for (fx, fy), (cx, cy) in zip(posture.feet, standard.centres, strict=True)
    )


def _phases_hold(standard: Standard, posture: Posture, leg: int, tolerance: float) -> bool:
    ux, uy = standard.ux, standard.uy
    for (fx, fy), (cx, cy), offset in zip(
        posture.feet, standard.centres, standard.offsets[leg], strict=True
    ):
        if abs(ux * (fx - cx) + uy * (fy - cy) - offset) > tolerance:
            return False
    return True


def is_open(field: Field) -> bool:
    """True when no cell is prohibited anywhere the feet could come within the horizon."""
    standard, terrain, posture = field.standard, field.terrain, field.start.posture
    way = (DEPTH + 2) * standard_way(standard)
    x_reach = max(abs(v) for box in standard.boxes for v in box[:2])
    y_reach = max(abs(v) for box in standard.boxes for v in box[2:])
    corners = [
        posture.absolute(x + dx, y + dy)
        for x in (-x_reach, x_reach)
        for y in (-y_reach, y_reach)
        for dx, dy in ((0.0, 0.0), (way * standard.ux, way * standard.uy))
    ]
    cell, (ox, oy) = terrain.cell, terrain.origin
    c0, c1 = (
        math.floor((v - ox) / cell)
        for v in (min(x for x, _ in corners), max(x for x, _ in corners))
    )
    r0, r1 = (
        math.floor((v - oy) / cell)
        for v in (min(y for _, y in corners), max(y for _, y in corners))
    )
    if c0 < 0 or r0 < 0 or c1 >= terrain.columns or r1 >= terrain.rows:
        return False
    return not terrain.forbidden[r0 : r1 + 1, c0 : c1 + 1].any()
