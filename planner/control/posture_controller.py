"""Postures on command: sitting, standing up, going back into the standard layout.

A posture is a row of plans made at once and played one after the other; when the ground or a push
makes one come out otherwise, the rest is made anew from there.
"""

from __future__ import annotations

from collections.abc import Callable

from ..initial_stance import Placement
from ..motion.body_tilt import LEVEL, leaned
from ..motion.postures import Choosing, Poses, regroup, sit, stand
from ..terrain.map import TerrainMap
from ..types import Blocked, Stance, StepPlan
from .execution import Execution

Layout = Callable[[Placement], Stance]  # the standard posture of a course


class PostureController:
    """Which posture is wanted, which is being taken, and the plans still to be played for it.

    ``posture`` is the one it is in or going to (stand, sit, standard), ``wanted`` the one asked for
    and not yet reached, ``low`` whether the body has sunk on command: it rises before it walks.
    """

    def __init__(self, run: Execution, layout: Layout) -> None:
        self.posture = "stand"
        self.wanted = ""
        self.low = False
        self.rises_to_walk = False  # a command to move wants the posture it is taking
        self.plans: Poses = ()
        self._run = run
        self._layout = layout
        self._choosing: Choosing | None = None  # the order of the legs is being searched for
        self._terrain: TerrainMap | None = None  # the map the plans were made on
        self._tries = 0  # times the posture wanted has been begun

    def ask(self, posture: str) -> None:
        """Take a posture from the next standstill on; what else it was going to is dropped."""
        self.wanted = posture
        self.rises_to_walk = False
        self._tries = 0
        self._choosing = None

    def halt(self) -> None:
        """No posture is wanted any more."""
        self.wanted = ""
        self.rises_to_walk = False
        self._choosing = None

    @property
    def is_choosing(self) -> bool:
        """True while the order of the legs is being searched for."""
        return self._choosing is not None

    def begin(self, terrain: TerrainMap) -> Blocked | None:
        """Count another try; why not, when there have been too many."""
        if self._tries >= self._run.config.tracking.posture_tries:
            return Blocked("something keeps the machine from the posture asked for")
        self._tries += 1
        self._terrain = terrain
        return None

    def planned(self, stance: Stance, terrain: TerrainMap, crab_angle: float) -> Blocked | bool:
        """Make the plans of the posture wanted, from a standstill; False while that takes longer."""
        upright: Poses = ()
        if stance.lean != LEVEL:
            levelling = leaned(stance, LEVEL, self._run.machine)
            if levelling is None:
                return Blocked("the legs cannot level the body here: drive on first")
            upright = (levelling,)
            stance = levelling.end
        answer = self._plans_from(stance, terrain, crab_angle)
        if isinstance(answer, Blocked):
            return answer
        if answer is None:
            return False
        self.posture = "stand" if self.low and self.wanted == "standard" else self.wanted
        self.low = self.low or self.wanted == "sit"
        self.plans = (*upright, *answer)
        return True

    def _plans_from(
        self, stance: Stance, terrain: TerrainMap, crab_angle: float
    ) -> Poses | Blocked | None:
        machine, gait = self._run.machine, self._run.gait
        if self.wanted == "sit":
            return sit(stance, terrain, machine, gait)
        if self.wanted == "stand" or self.low:
            return stand(stance, terrain, machine, gait)
        if self._choosing is None:
            x, y, _, yaw = stance.body
            goal = self._layout(Placement((x, y, yaw), terrain.height_at, crab_angle))
            self._choosing = regroup(stance, goal, terrain, machine, gait, crab_angle)
        return self._choose_on()

    def _choose_on(self) -> Poses | Blocked | None:
        """Some more of the search for the order of the legs; None while it goes on."""
        assert self._choosing is not None
        try:
            for _ in range(self._run.config.planning.slices_wanted):
                next(self._choosing)
        except StopIteration as done:
            self._choosing = None
            answer: Poses | Blocked = done.value
            return answer
        return None

    def next_plan(self) -> StepPlan:
        """The next plan of the posture."""
        plan, *rest = self.plans
        self.plans = tuple(rest)
        return plan

    def taken(self) -> None:
        """The posture is taken; one that was only on the way to another leaves that wanted."""
        self.low = self.posture == "sit"
        if self.wanted == self.posture:
            self.wanted = ""

    def broken_off(self) -> None:
        """The posture is not gone on with: it stands, wherever it is."""
        self.posture = "stand"

    @property
    def is_still_wanted(self) -> bool:
        """True while the posture being taken is the one wanted, or on the way to it."""
        on_the_way = self.wanted == "standard" and self.posture == "stand" and self.low
        return self.wanted == self.posture or on_the_way

    def is_still_good(self, terrain: TerrainMap) -> bool:
        """True while every foothold still to come is believed to be what it was taken for."""
        if terrain is self._terrain:
            return True
        off = self._run.config.tracking.same_ground
        places = [plan.landing for plan in self.plans if plan.landing is not None]
        return all(
            terrain.allows(x, y) and abs(terrain.height_at(x, y) - z) <= off for x, y, z in places
        )
