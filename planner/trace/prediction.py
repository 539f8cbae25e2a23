"""K's global prediction, about two body lengths ahead: states, footholds, existence segments.

A ``Prediction`` is a frozen value. ``predicting`` makes one, ``serves`` says whether it is still
good: until its horizon has shrunk to a body length, or the command, the trace or the ground under
its footholds has changed.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass
from typing import NamedTuple

from ..geometry.paths import SampledPath
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Command, Gait, Point, Stance
from .footholds import AIR, Footing, is_plenty, thinning
from .lane import ASIDE, TraceWindow, lane_along
from .moves import Move, moves_along
from .paths import joystick_trace, step_for
from .periodic_gaits import RigidGait, fastest_gait
from .reachability import Reachability
from .state_search import StatePath, search, search_rigid
from .state_sequence import SupportState

BODY_LENGTHS = 2.0  # how far ahead the global prediction looks, K
RENEW = 1.0  # body lengths left ahead when it is made anew
BACK = 0.5  # body lengths behind the machine it may go back to leave a blind alley
LIMIT = 6_000  # states met on the trace itself; more finds little that its rows do not find sooner
# states met beside the trace, some two seconds of search: less blocks on ground that can be crossed
LIMIT_WIDE = 20_000
SAME = 1e-3  # m; a foot this near to where the prediction has it is there


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


class _Course(NamedTuple):
    """The trace and which part of it is looked along."""

    trace: SampledPath
    window: TraceWindow
    offset: float  # s at the first sample, m

    @property
    def goal(self) -> int:
        """The last sample, counted from the first that is looked at."""
        return self.window.last - self.window.first

    @property
    def start(self) -> int:
        """The sample of the body, counted so."""
        return self.window.now - self.window.first


def predicting(
    stance: Stance,
    command: Command,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    *,
    trace: SampledPath | None = None,
    rigid: RigidGait | None = None,
    limit: int = LIMIT,
    limit_wide: int = LIMIT_WIDE,
) -> Generator[None, None, Prediction]:
    """Predict from ``stance``: on the trace by K's order and by search, then with rows beside it;
    the better of these.

    Without a ``trace`` the joystick's own is drawn. ``limit`` and ``limit_wide`` bound the states
    met on and beside the trace. Yields now and then, so that a caller may spread it over ticks.
    """
    if trace is None:
        course = _joystick_course(stance, command, machine)
    else:
        course = _given_course(stance, trace, machine)
    given = trace is not None
    if rigid is None and not stance.lifted:
        # a free gait may be any gait: where there is plenty of ground it is the fastest one
        fast = _Attempt(course, stance, terrain, machine, gait, fastest_gait(machine))
        yield from fast.on_plenty(limit)
        if fast.path.complete:
            return fast.prediction(command, given)
    attempt = _Attempt(course, stance, terrain, machine, gait, rigid)
    for aside, count in ((0.0, limit), (ASIDE * machine.torso[0], limit_wide)):
        if rigid is not None and aside:
            break
        done = yield from attempt.along(aside, count, limit)
        if done:
            break
        yield
    else:
        if attempt.was_thinned:
            yield from attempt.along(0.0, limit, limit, whole=True)
    return attempt.prediction(command, given)


def _joystick_course(stance: Stance, command: Command, machine: Machine) -> _Course:
    """The joystick's own course from where the body is."""
    step = step_for(machine)
    ahead = round(BODY_LENGTHS * machine.torso[0] / step)
    x, y, _, yaw = stance.body
    trace = joystick_trace(
        (x, y, yaw),
        command.crab_angle,
        command.speed,
        command.turn_rate,
        machine.yaw_length,
        ahead * step,
        step,
    )
    return _Course(trace, TraceWindow(0, min(ahead, trace.last), 0), stance.course)


def _given_course(stance: Stance, trace: SampledPath, machine: Machine) -> _Course:
    """A given trace from a little behind the body on."""
    step = trace.step
    ahead = round(BODY_LENGTHS * machine.torso[0] / step)
    now = min(round(stance.course / step), trace.last)
    first = max(0, now - round(BACK * machine.torso[0] / step))
    return _Course(trace, TraceWindow(first, min(now + ahead, trace.last), now), first * step)


class _Attempt:
    """The search for states along one course, first on it, then beside it too."""

    def __init__(
        self,
        course: _Course,
        stance: Stance,
        terrain: TerrainMap,
        machine: Machine,
        gait: Gait,
        rigid: RigidGait | None,
    ) -> None:
        self.course = course
        self.stance = stance
        self.terrain = terrain
        self.machine = machine
        self.gait = gait
        self.rigid = rigid
        self.path = StatePath((), False, course.start, 0, False)
        self.moves: tuple[Move, ...] = ()
        self.looked = 0
        self.torso_stops = False
        self.was_thinned = False  # the last search saw only some of the footholds there are

    def on_plenty(self, count: int) -> Generator[None, None, None]:
        """Search on the trace, if most of the ground along it may be stepped on."""
        course = self.course
        lane = lane_along(
            course.trace, course.window, self.stance, self.terrain, self.machine, self.gait, 0.0
        )
        if self.rigid is not None and is_plenty(lane, self.terrain, self.machine):
            yield from self.along(0.0, count, count)

    def along(
        self, aside: float, count: int, count_dense: int, whole: bool = False
    ) -> Generator[None, None, bool]:
        """Search with rows up to ``aside`` m beside the trace, meeting ``count`` states at most, or
        ``count_dense`` where there is plenty of ground, which is thinned unless it is to be looked
        at ``whole``; True when there is no more to try.
        """
        course = self.course
        terrain = self.terrain
        lane = lane_along(
            course.trace, course.window, self.stance, terrain, self.machine, self.gait, aside
        )
        thin = 1 if whole else thinning(lane, terrain, self.machine)
        self.was_thinned = thin > 1
        if thin > 1:
            # plenty of ground everywhere: what stops it is an edge, and going beside does not help
            count = count_dense
        reachable = Reachability(lane, terrain, self.machine, thin=thin)
        for leg in range(len(self.machine.legs)):
            yield
            yield from reachable.finding(leg)
        yield
        start = SupportState(_footing(reachable, self.stance, course.start), course.start)
        if not reachable.accept(start.feet, start.at):
            return True
        found = yield from self._search(reachable, start, count)
        self.looked += found.looked
        if found.farthest > self.path.farthest or not self.moves:
            yield from self._take(reachable, found)
        return found.complete

    def _search(
        self, reachable: Reachability, start: SupportState, count: int
    ) -> Generator[None, None, StatePath]:
        goal = self.course.goal
        if self.rigid is None:
            return (yield from search(reachable, start, goal, count))
        groups = _from_next(self.rigid, self.stance.last_swing)
        return (yield from search_rigid(reachable, start, goal, count, groups))

    def _take(self, reachable: Reachability, found: StatePath) -> Generator[None, None, None]:
        """Keep what was found: it leads farther."""
        self.path = found if found.complete else found.to_standing()
        beyond = min(found.farthest + 1, reachable.samples.count - 1)
        grazes = reachable.clearance.torso_grazes
        self.torso_stops = grazes and not _has_torso_room(reachable, beyond)
        together = () if self.rigid is None else (1,)
        course = self.course
        self.moves = yield from moves_along(
            reachable, self.path, course.offset, course.trace.step, *together
        )

    def prediction(self, command: Command, given: bool) -> Prediction:
        """What was found, as a prediction."""
        course = self.course
        step = course.trace.step
        reached = course.offset + self.path.farthest * step
        sure = self.moves[-1].course if self.moves else self.stance.course
        return Prediction(
            course.trace,
            command,
            self.terrain,
            self.stance,
            self.moves,
            reached if self.path.complete else sure,
            course.offset + course.goal * step,
            self.path.complete,
            "" if self.path.complete else self._why(reached),
            self.looked,
            given,
            last=given and course.window.last == course.trace.last,
        )

    def _why(self, reached: float) -> str:
        """Why there is no way to the goal."""
        if not self.path.states:
            return "the machine does not stand within reach and stable here"
        beyond = f"beyond s = {reached:.2f} m"
        if self.torso_stops:
            return f"there is no way {beyond}: the torso would touch the ground"
        known = "there is no way"
        if not self.path.exhausted:
            known = f"no way was found among {self.looked} states"
        return f"{known} {beyond}: no foothold lets the next leg leave its own"


def _from_next(rigid: RigidGait, last_swing: int) -> tuple[tuple[int, ...], ...]:
    """A rigid gait's groups beginning with the one after the legs that moved last."""
    groups = rigid.groups
    k = next((n + 1 for n, group in enumerate(groups) if last_swing in group), 0)
    return groups[k:] + groups[:k]


def _has_torso_room(reachable: Reachability, k: int) -> bool:
    """True when the torso meets nothing at sample ``k`` of the trace, or beside it."""
    samples = reachable.samples
    room = reachable.clearance.torso_room
    return any(samples.row_of(room, r) >> k & 1 for r in range(samples.rows))


def _footing(reachable: Reachability, stance: Stance, sample: int) -> Footing:
    """The footholds of a stance, by number."""
    return tuple(
        AIR if leg in stance.lifted else reachable.foothold_of(leg, foot, sample)
        for leg, foot in enumerate(stance.feet)
    )
