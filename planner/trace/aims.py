"""What a way along a trace is to be best at: K takes the first that is found; here also the one
with fewest changes of state, with the greatest margin, or the fastest.

Each aim names other manners of search; the ways they find over the same horizon are measured, and
the best is taken. It is the best of these few, not of all there are.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator

from ..config import FEWEST_STATES, GREATEST_MARGIN, GREATEST_SPEED
from ..geometry.transforms import Body
from ..protocols import Weight
from ..stability import polygon_margin, support_polygon
from ..types import Point
from .attempt import Attempt, Manner, Task
from .moves import Move
from .periodic_gaits import fastest_gait
from .timing import body_pace_max, step_plan

LIMIT = 2_000  # states met by each of the other manners; more: see the first step come late
# samples a change is held to lose; more: see it meet many states for few changes
CHANGE_COST = 30.0
MARGINS = (0.12, 0.08, 0.05, 0.03, 0.02)  # m, the greatest that there is a way with is kept
LOOKS = 5  # poses of a stretch at which its margin is looked at
Stretch = tuple[tuple[Body, ...], list[Point]]  # of the body's way, and the feet that stand on it


def best_way(found: Attempt, task: Task, aim: str) -> Generator[Weight, None, Attempt]:
    """The best of the way found and of others, by one of ``config.AIMS``; the way found itself
    where it does not lead to the goal. Yields now and then.
    """
    if not (found.path.complete and found.moves):
        return found
    best = found
    least = yield from _cost(found, task, aim)
    for manner in _manners(task, aim):
        other = Attempt(task, manner)
        yield from other.along(0.0, LIMIT, LIMIT, briefly=True)
        best.looked += other.looked
        if not (other.path.complete and other.moves):
            continue
        cost = yield from _cost(other, task, aim)
        if cost < least:
            other.looked = best.looked
            least = cost
            best = other
        if aim == GREATEST_MARGIN:
            break  # those to come ask for less
    return best


def _manners(task: Task, aim: str) -> Iterator[Manner]:
    if aim == GREATEST_MARGIN:
        yield from (Manner(margin=margin) for margin in MARGINS)
        return
    rigid = fastest_gait(task.machine)
    if rigid is not None and not task.stance.lifted:
        yield Manner(rigid)
    yield Manner(change_cost=CHANGE_COST)


def _cost(way: Attempt, task: Task, aim: str) -> Generator[Weight, None, float]:
    """What a complete way costs: less is better."""
    if aim == GREATEST_MARGIN:
        return -least_margin(way.moves)
    if aim == FEWEST_STATES:
        return len(way.moves)
    assert aim == GREATEST_SPEED
    return (yield from seconds(way.moves, task))


def least_margin(moves: tuple[Move, ...]) -> float:
    """Least polygon margin of the centre of gravity over some moves, m."""
    return min(
        polygon_margin(support_polygon(feet), x, y)
        for move in moves
        for poses, feet in _stretches(move)
        for x, y, *_ in poses[:: max(1, len(poses) // LOOKS)]
    )


def _stretches(move: Move) -> Iterator[Stretch]:
    """The stretches of a move with the feet that stand then: before its legs are lifted, and with
    them in the air.
    """
    before = [foot for foot in move.before if foot is not None]
    pairs = zip(move.before, move.after, strict=True)
    still = [
        foot for leg, (foot, _) in enumerate(pairs) if foot is not None and leg not in move.legs
    ]
    yield move.shift, before
    yield move.carry, still


def seconds(moves: tuple[Move, ...], task: Task) -> Generator[Weight, None, float]:
    """How long some moves take, as fast as the legs can, s."""
    top = body_pace_max(task.machine, task.gait)
    stance = task.stance
    total = 0.0
    for move in moves:
        plan = step_plan(stance, move, top, task.terrain, task.machine, task.gait)
        total += float(plan.times[-1])
        stance = plan.end
        yield None
    return total
