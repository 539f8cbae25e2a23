"""K's global prediction, about two body lengths ahead: states, footholds, existence segments.

A ``Prediction`` is a frozen value. ``predicting`` makes one, ``serves`` says whether it is still
good: until its horizon has shrunk to a body length, or the command, the trace or the ground under
its footholds has changed.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass

from ..config import SOONEST, TraceSearch
from ..geometry.paths import SampledPath
from ..protocols import Weight
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Command, Gait, Point, Stance
from .aims import best_way
from .attempt import Attempt, Manner, Task, TraceCourse
from .lane import ASIDE, TraceWindow
from .moves import Move
from .paths import joystick_trace, step_for
from .periodic_gaits import RigidGait, fastest_gait

BODY_LENGTHS = 2.0  # how far ahead the global prediction looks, K
RENEW = 1.0  # body lengths left ahead when it is made anew
BACK = 0.5  # body lengths behind the machine it may go back to leave a blind alley
LIMIT = 6_000  # states met on the trace itself; more finds little that its rows do not find sooner
# states met beside the trace, some two seconds of search: less blocks on ground that can be crossed
LIMIT_WIDE = 20_000
SAME = 1e-3  # m; a foot this near to where the prediction has it is there
ON_ITS_OWN = TraceSearch()


@dataclass(frozen=True, slots=True, eq=False)
class Prediction:
    """K's global prediction: moves from ``start`` on. ``trace`` and ``course`` (s at each move's
    end) are for drawing too.
    """

    trace: SampledPath
    command: Command
    terrain: TerrainMap
    start: Stance
    moves: tuple[Move, ...]
    reached: float  # s up to which the machine is sure to get, m
    goal: float  # s the prediction was made for, m
    complete: bool  # the goal was reached
    reason: str  # why not
    looked: int  # states met
    given: bool  # the trace was given, not the joystick's
    last: bool = False  # the goal is the end of the trace


def index_of(prediction: Prediction, stance: Stance) -> int | None:
    """Which of the prediction's moves starts at this stance; None when the stance is none of its
    own.
    """
    start = prediction.start
    feet: tuple[Point | None, ...] = tuple(
        None if leg in start.lifted else foot for leg, foot in enumerate(start.feet)
    )
    body = start.body
    for n in range(len(prediction.moves) + 1):
        if _near(body, stance.body) and _stands_so(stance, feet):
            return n
        if n < len(prediction.moves):
            feet = prediction.moves[n].after
            body = prediction.moves[n].carry[-1]
    return None


def _stands_so(stance: Stance, feet: tuple[Point | None, ...]) -> bool:
    """True when the feet of a stance are where these are, None in the air."""
    for leg, at in enumerate(feet):
        lifted = leg in stance.lifted
        if lifted if at is not None else not lifted:
            return False
        if at is not None and not _near(at, stance.feet[leg]):
            return False
    return True


def _near(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    return abs(a[0] - b[0]) <= SAME and abs(a[1] - b[1]) <= SAME


def serves(
    prediction: Prediction,
    stance: Stance,
    command: Command,
    terrain: TerrainMap,
    machine: Machine,
    trace: SampledPath | None,
) -> bool:
    """True when the prediction's next move may be taken from here as it is."""
    n = index_of(prediction, stance)
    if n is None or n >= len(prediction.moves) or not _is_for(prediction, command, trace):
        return False
    near_its_end = prediction.goal - stance.course < RENEW * machine.torso[0]
    if prediction.complete and near_its_end and not prediction.last:
        return False
    if prediction.terrain is terrain:
        return True
    return prediction.complete and all(
        point is None or terrain.allows(point[0], point[1])
        for move in prediction.moves[n:]
        for point in (move.after[k] for k in move.legs)
    )


def _is_for(prediction: Prediction, command: Command, trace: SampledPath | None) -> bool:
    """True when it was made for this trace, or for the joystick's course of this command."""
    if trace is not None:
        return prediction.trace is trace
    return not prediction.given and _course_of(prediction.command) == _course_of(command)


def _course_of(command: Command) -> tuple[float, ...]:
    """What of a command shapes the joystick's trace: the proportions of its arc, not its pace."""
    size = math.hypot(command.speed, command.turn_rate)
    if size == 0.0:
        return (0.0,)
    return (
        round(command.crab_angle, 9) if command.speed else 0.0,
        round(command.speed / size, 9),
        round(command.turn_rate / size, 9),
    )


# making one


def predicting(
    stance: Stance,
    command: Command,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    *,
    trace: SampledPath | None = None,
    drawn: SampledPath | None = None,
    rigid: RigidGait | None = None,
    limit: int = LIMIT,
    limit_wide: int = LIMIT_WIDE,
    search: TraceSearch = ON_ITS_OWN,
) -> Generator[Weight, None, Prediction]:
    """Predict from ``stance``: on the trace by K's order and by search, then with rows beside it;
    the better of these.

    Without a ``trace`` the joystick's own is looked along, as it is ``drawn`` from here if it has
    been. ``limit`` and ``limit_wide`` bound the states met on and beside the trace, ``search`` says
    how far beside it, and what the way is to be best at. Yields now and then, so that a caller may
    spread it over ticks.
    """
    if trace is None:
        course = _joystick_course(stance, command, machine, drawn)
    else:
        course = _given_course(stance, trace, machine)
    task = Task(course, stance, terrain, machine, gait)
    sway = ASIDE * machine.torso[0] if search.sway is None else search.sway
    looks: Looks = ((0.0, limit), (sway, limit_wide)) if sway else ((0.0, limit),)
    best = yield from _first_way(task, rigid, looks)
    if rigid is None and search.aim != SOONEST:
        best = yield from best_way(best, task, search.aim)
    return _predicted(best, command, trace is not None)


Looks = tuple[tuple[float, int], ...]  # m beside the trace, and states met at most


def _first_way(
    task: Task, rigid: RigidGait | None, looks: Looks
) -> Generator[Weight, None, Attempt]:
    """The first way found, the widest look last; where none gets there, the farthest."""
    limit = looks[0][1]
    if rigid is None and not task.stance.lifted:
        # a free gait may be any gait: where there is plenty of ground it is the fastest one
        fast = Attempt(task, Manner(fastest_gait(task.machine)))
        yield from fast.on_plenty(limit)
        if fast.path.complete or fast.leads_in_the_open:
            return fast
    attempt = Attempt(task, Manner(rigid))
    for aside, count in looks:
        if aside and rigid is not None:
            break
        wider_follows = rigid is None and aside < looks[-1][0]
        done = yield from attempt.along(aside, count, limit, briefly=wider_follows)
        if done:
            break
        yield None
    else:
        if attempt.was_thinned:
            yield from attempt.along(0.0, limit, limit, whole=True)
    return attempt


def _predicted(way: Attempt, command: Command, given: bool) -> Prediction:
    """What was found, as a prediction."""
    course = way.course
    step = course.trace.step
    reached = course.offset + way.path.farthest * step
    sure = way.moves[-1].course if way.moves else way.stance.course
    return Prediction(
        course.trace,
        command,
        way.terrain,
        way.stance,
        way.moves,
        reached if way.path.complete else sure,
        course.offset + course.goal * step,
        way.path.complete,
        "" if way.path.complete else way.why(reached),
        way.looked,
        given,
        last=given and course.window.last == course.trace.last,
    )


def joystick_from(stance: Stance, command: Command, machine: Machine, ahead: float) -> SampledPath:
    """The joystick's own trace from where the body is, so many body lengths long."""
    step = step_for(machine)
    x, y, _, yaw = stance.body
    return joystick_trace(
        (x, y, yaw),
        command.crab_angle,
        command.speed,
        command.turn_rate,
        machine.yaw_length,
        round(ahead * machine.torso[0] / step) * step,
        step,
    )


def _joystick_course(
    stance: Stance, command: Command, machine: Machine, drawn: SampledPath | None
) -> TraceCourse:
    """The joystick's course from where the body is."""
    trace = drawn or joystick_from(stance, command, machine, BODY_LENGTHS)
    ahead = round(BODY_LENGTHS * machine.torso[0] / trace.step)
    return TraceCourse(trace, TraceWindow(0, min(ahead, trace.last), 0), stance.course)


def _given_course(stance: Stance, trace: SampledPath, machine: Machine) -> TraceCourse:
    """A given trace from a little behind the body on."""
    step = trace.step
    ahead = round(BODY_LENGTHS * machine.torso[0] / step)
    now = min(round(stance.course / step), trace.last)
    first = max(0, now - round(BACK * machine.torso[0] / step))
    return TraceCourse(trace, TraceWindow(first, min(now + ahead, trace.last), now), first * step)
