"""One search for states along a course: on the trace or beside it, by K's order, by search, or by a
rigid gait; and the moves it comes to.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from typing import NamedTuple

from ..geometry.paths import SampledPath
from ..protocols import Weight
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Gait, Point, Stance
from .footholds import AIR, Footing, is_open, is_plenty, thinning
from .lane import Lane, TraceWindow, lane_along
from .moves import Move, moves_along, up_to_what_is_met
from .periodic_gaits import RigidGait
from .reachability import OutOfHeight, Reachability
from .stability_table import MARGIN
from .state_search import StatePath, search, search_rigid
from .state_sequence import SupportState

# body lengths that the fastest gait must lead ahead to be walked until it is made anew; with less
# the search stands still where it could still go on, with more it comes to walls it cannot leave
LEAD_MIN = 1.25
# ways that are given up because a leg would sweep through something tall, before what is left of
# the last is walked. Fewer: see it stop before poles it could pass; more: see it plan long there
BANS_MAX = 6
BANNED = 0.10  # m about where such a leg would land that is looked at no more
LEAD_OPEN_MIN = 0.1  # the same where nothing is forbidden: there are no blind alleys


class TraceCourse(NamedTuple):
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

    def up_to(self, sample: int) -> TraceCourse:
        """The same with its goal at ``sample``, counted so."""
        return self._replace(window=self.window._replace(last=self.window.first + sample))


class Task(NamedTuple):
    """What a way is looked for: from where, along what, over which ground, by which machine."""

    course: TraceCourse
    stance: Stance
    terrain: TerrainMap
    machine: Machine
    gait: Gait


class Manner(NamedTuple):
    """How one is looked for."""

    rigid: RigidGait | None = None  # held to this gait
    margin: float = MARGIN  # m, least stability margin of every state
    change_cost: float = 0.0  # samples a change of state counts for; 0: K's order first


class _Brief(NamedTuple):
    """A search that was ended early: the states it may meet, and where it can lead at most."""

    met_max: int
    met_max_dense: int
    most: int  # sample


class Attempt:
    """The search for states along one course, first on it, then beside it too.

    ``manner`` is how it searches: held to a rigid gait, with another margin, or for few changes.
    """

    def __init__(self, task: Task, manner: Manner) -> None:
        self.course = course = task.course
        self.stance = task.stance
        self.terrain = task.terrain
        self.machine = task.machine
        self.gait = task.gait
        self.manner = manner
        self.path = StatePath((), False, course.start, 0, False, course.goal)
        self.moves: tuple[Move, ...] = ()
        self.looked = 0
        self.torso_stops = False
        self.out_of_height: OutOfHeight | None = None
        self.was_thinned = False  # the last search saw only some of the footholds there are
        self.leads_in_the_open = False  # over ground of which nothing is forbidden
        self._lane: Lane | None = None  # on the trace, once it has been asked for
        self._brief: _Brief | None = None  # a search ended early

    def on_plenty(self, count: int) -> Generator[Weight, None, None]:
        """Search on the trace, if most of the ground along it may be stepped on. What leads well
        ahead is taken for a way to a nearer goal.
        """
        course = self.course
        self._lane = lane = self._lane_with(0.0)
        if self.manner.rigid is not None and is_plenty(lane, self.terrain, self.machine):
            yield from self.along(0.0, count, count)
            lead = (self.path.farthest - course.start) * course.trace.step / self.machine.torso[0]
            if self.moves and lead >= LEAD_MIN:
                self.course = course.up_to(self.path.farthest)
                self.path = replace(self.path, complete=True)
            elif self.moves and lead >= LEAD_OPEN_MIN:
                self.leads_in_the_open = is_open(lane, self.terrain, self.machine)

    def along(
        self,
        aside: float,
        count: int,
        count_dense: int,
        *,
        whole: bool = False,
        briefly: bool = False,
    ) -> Generator[Weight, None, bool]:
        """Search with rows up to ``aside`` m beside the trace, meeting ``count`` states at most, or
        ``count_dense`` where there is plenty of ground, which is thinned unless it is to be looked
        at ``whole``; True when there is no more to try.

        ``briefly``: a wider search follows. This one ends where no way is known to lead to the
        goal, and is made to its end after all if the wider one leads no farther than it could.
        """
        course = self.course
        terrain = self.terrain
        lane = self._lane if self._lane and aside == 0.0 else self._lane_with(aside)
        thin = 1 if whole else thinning(lane, terrain, self.machine)
        self.was_thinned = thin > 1
        if thin > 1:
            # plenty of ground everywhere: what stops it is an edge, and going beside does not help
            count = count_dense
        reachable = Reachability(lane, terrain, self.machine, thin=thin, margin=self.manner.margin)
        if self.moves and reachable.clearance.leads_to(course.start) <= self.path.farthest:
            return self.path.complete
        for leg in range(len(self.machine.legs)):
            yield None
            yield from reachable.finding(leg)
        yield None
        start = SupportState(_footing(reachable, self.stance, course.start), course.start)
        if not reachable.accept(start.feet, start.at):
            yield from self._after_all()
            return True
        most = yield from self._ways(reachable, start, count, briefly)
        if most is not None:
            self._brief = _Brief(count, count_dense, most)
        self.was_thinned = thin > 1
        return self.path.complete

    def _ways(
        self, reachable: Reachability, start: SupportState, count: int, briefly: bool
    ) -> Generator[Weight, None, int | None]:
        """Keep the way that is found, and look for others where a leg would meet something on it;
        where it is not looked for to its end, the sample it can lead to at most.
        """
        for ban in range(1 + BANS_MAX):
            found = yield from self._search(reachable, start, count, briefly and not ban)
            self.looked += found.looked
            if briefly and not ban and found.most < self.course.goal:
                return found.most
            yield from self._after_all(found.farthest)
            if found.farthest <= self.path.farthest and self.moves:
                break
            met = yield from self._take(reachable, found)
            if met is None:
                break
            reachable.ban(*met, BANNED)
            if not reachable.accept(start.feet, start.at):
                break
        return None

    def _lane_with(self, aside: float) -> Lane:
        """The lane with rows up to ``aside`` m beside the trace."""
        known = self.stance, self.terrain, self.machine, self.gait
        return lane_along(self.course.trace, self.course.window, *known, aside)

    def _search(
        self, reachable: Reachability, start: SupportState, count: int, briefly: bool
    ) -> Generator[Weight, None, StatePath]:
        goal = self.course.goal
        if self.manner.rigid is None:
            few = self.manner.change_cost
            return (yield from search(reachable, start, goal, count, few, briefly))
        groups = _from_next(self.manner.rigid, self.stance.last_swing)
        return (yield from search_rigid(reachable, start, goal, count, groups))

    def _after_all(self, farthest: int = -1) -> Generator[Weight, None, None]:
        """The search that was ended early, to its end, unless this one has come farther."""
        brief, self._brief = self._brief, None
        if brief is not None and farthest <= brief.most:
            yield from self.along(0.0, brief.met_max, brief.met_max_dense)

    def _take(
        self, reachable: Reachability, found: StatePath
    ) -> Generator[Weight, None, tuple[int, Point] | None]:
        """Keep what was found: it leads farther. Answers with the leg that would sweep through
        something tall, and where to; what was found leads up to there only.
        """
        self.path = found if found.complete else found.to_standing()
        beyond = min(found.farthest + 1, reachable.samples.count - 1)
        grazes = reachable.clearance.torso_grazes
        self.torso_stops = grazes and not _has_torso_room(reachable, beyond)
        self.out_of_height = None if found.complete else reachable.out_of_height(beyond)
        together = () if self.manner.rigid is None else (1,)
        course = self.course
        moves = yield from moves_along(
            reachable, self.path, course.offset, course.trace.step, *together
        )
        clear, met = up_to_what_is_met(moves, reachable.legs)
        self.moves = moves[:clear]
        if met is not None:
            s = self.moves[-1].course if self.moves else course.offset
            farthest = round((s - course.offset) / course.trace.step)
            self.path = replace(self.path, complete=False, farthest=farthest)
        return met

    def why(self, reached: float) -> str:
        """Why there is no way to the goal."""
        if not self.path.states:
            return "the machine does not stand within reach and stable here"
        beyond = f"beyond s = {reached:.2f} m"
        if self.torso_stops:
            return f"there is no way {beyond}: the torso would touch the ground"
        known = "there is no way"
        if not self.path.exhausted:
            known = f"no way was found among {self.looked} states"
        if self.out_of_height is not None:
            return f"{known} {beyond}: {self.out_of_height.said(self.machine)}"
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
