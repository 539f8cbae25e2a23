"""A way to a place, planned ahead before it is walked: whether it is reached, in how many steps and
how long, or why not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from walking_console.planner import registry
from walking_console.planner.protocols import Planner, PlannerSetup
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import Blocked, Command, Stance, StepPlan

from .snapshot import Snapshot, TerrainView

STEPS_MAX = 200  # planned at most; larger: a far place keeps a core busy for long
NEAR = 0.03  # m from the place at which it is reached
OFF_COURSE = math.radians(3.0)  # from the bearing of the place at which the course is set anew
VAIN_STEPS = 12  # that come no nearer, after which there is no way
AT_HAND = 3.0  # m from where the ground at hand ends that a way is blocked for no other reason
BEYOND = "it leads beyond the ground that is at hand"
GAIN = 0.003  # m a step must come nearer to count


@dataclass(frozen=True)
class RoutePreview:
    """What was planned: lengths in m, times in s."""

    reachable: bool
    steps: int
    time: float
    distance: float  # walked along the way
    left: float  # to the place, as the crow flies
    reason: str  # "" when it is reached


def preview_route(
    snapshot: Snapshot, place: tuple[float, float], speed: float, steps_max: int = STEPS_MAX
) -> RoutePreview:
    """Plan step after step towards ``place`` (x, y in m, absolute) at ``speed`` m/s, on the ground
    as it is shown, by the planner that walks; the body keeps its heading.

    Bounded by the count of steps, and on a wide map by the window about the machine. Nothing of the
    walk itself is touched.
    """
    walk = _Ahead(_stance_of(snapshot), place)
    planner, ground = _planner_of(snapshot), _ground_of(snapshot)
    while walk.left > NEAR:
        if walk.steps == steps_max:
            return walk.ending(f"farther than {steps_max} steps")
        plan = planner.plan_step(walk.stance, Command(walk.steer(), speed), ground)
        if isinstance(plan, Blocked):
            ends = _ends_at_hand(snapshot.terrain, walk.stance)
            return walk.ending(BEYOND if ends else plan.text)
        walk.take(plan)
        if walk.vain == VAIN_STEPS:
            return walk.ending("it comes no nearer")
    return walk.ending("")


class _Ahead:
    """A walk in thought: the stance it has come to, and what it took."""

    def __init__(self, stance: Stance, place: tuple[float, float]) -> None:
        self.stance = stance
        self.place = place
        self.left = self.nearest = math.dist(stance.body[:2], place)
        self.course = self._bearing()
        self.steps = self.vain = 0
        self.time = self.distance = 0.0

    def _bearing(self) -> float:
        """Of the place, from the body's heading, rad."""
        x, y, _, yaw = self.stance.body
        return math.remainder(math.atan2(self.place[1] - y, self.place[0] - x) - yaw, math.tau)

    def steer(self) -> float:
        """The course, set anew where the place lies clearly off it, rad."""
        if abs(math.remainder(self._bearing() - self.course, math.tau)) > OFF_COURSE:
            self.course = self._bearing()
        return self.course

    def take(self, plan: StepPlan) -> None:
        """One step; the last one ends at the place."""
        share = min(1.0, self.left / plan.shift) if plan.shift > 0.0 else 1.0
        self.steps += 1
        self.time += share * float(plan.times[-1])
        self.distance += share * plan.shift
        self.stance = plan.end
        self.left = 0.0 if share < 1.0 else math.dist(plan.end.body[:2], self.place)
        self.vain = 0 if self.left < self.nearest - GAIN else self.vain + 1
        self.nearest = min(self.nearest, self.left)

    def ending(self, reason: str) -> RoutePreview:
        """How it ended."""
        reached = not reason
        return RoutePreview(reached, self.steps, self.time, self.distance, self.left, reason)


def _planner_of(snapshot: Snapshot) -> Planner:
    machine = snapshot.machine
    setup = PlannerSetup(machine, machine.gait, snapshot.planner_mode)
    return registry.make_planner(snapshot.planner, setup)


def _ground_of(snapshot: Snapshot) -> TerrainMap:
    """The ground as it is shown, closed where the machine believes it is."""
    view = snapshot.terrain
    return TerrainMap.from_heights(
        view.heights, view.cell, snapshot.machine, view.origin, view.forbidden
    )


def _ends_at_hand(view: TerrainView, stance: Stance) -> bool:
    """Whether the window of a wide map ends near a stance, and the map goes on there."""
    if view.whole is None:
        return False
    x, y = stance.body[:2]
    for axis, at in enumerate((y, x)):
        first, count = view.corner[axis], view.heights.shape[axis]
        before = at - view.origin[1 - axis]
        if first > 0 and before < AT_HAND:
            return True
        if first + count < view.whole.shape[axis] and count * view.cell - before < AT_HAND:
            return True
    return False


def _stance_of(snapshot: Snapshot) -> Stance:
    """Where it stands, or will when the step it is in is done."""
    if snapshot.plan is not None and snapshot.speed > 0.0:
        return snapshot.plan.end
    x, y, z, _, _, yaw = snapshot.body
    return Stance((x, y, z, yaw), snapshot.feet)
