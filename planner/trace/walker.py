"""Kugushev and Jaroshevskij's planner as the other rooms see it."""

from __future__ import annotations

from ..geometry.transforms import Body
from ..motion.body_sway import swaying
from ..protocols import Capabilities, Planner, PlannerError, PlannerSetup, PlanningJob
from ..robot.separate_reach import separated
from ..terrain.map import TerrainMap
from ..types import Blocked, Command, GaitPreview, Stance, StepPlan
from .expected_supports import expected_supports
from .periodic_gaits import GAITS, given_gait, rigid_gait
from .planner import TraceWalk
from .preview import ahead, course_now

CAPABILITIES = Capabilities(
    follows_trace=True,
    gives_preview=True,
    gives_decision=True,
    standing_min=3,
    rigid_gaits=tuple(GAITS),
)


class TracePlanner(Planner):
    """Along a given trace or, without one, wherever the joystick leads.

    Raises ``PlannerError`` for a rigid gait that does not exist or does not fit the machine.
    """

    def __init__(self, setup: PlannerSetup) -> None:
        name = setup.rigid_gait
        try:
            if name is None:
                rigid = None
            elif isinstance(name, str):
                rigid = rigid_gait(name, setup.machine)
            else:
                rigid = given_gait(name, setup.machine)
            machine = separated(setup.machine)
            self.walk = TraceWalk(machine, setup.gait, setup.path, rigid, setup.config.trace)
        except ValueError as error:
            raise PlannerError(str(error)) from None
        self.walk.explain = setup.explain
        self.take_attitude(setup.attitude)
        self._previewed: tuple[tuple[object, ...], GaitPreview | None] = ((), None)

    @property
    def capabilities(self) -> Capabilities:
        return CAPABILITIES

    def plan(self, stance: Stance, command: Command, terrain: TerrainMap) -> PlanningJob:
        answer = yield from self.walk(stance, command, terrain)
        if isinstance(answer, Blocked) or not self.walk.gait.sways:
            return answer
        supports = expected_supports(self.walk.prediction, stance, answer)
        known = self.walk.gait, self.walk.machine, terrain
        return (yield from swaying(answer, stance, supports, *known))

    def preview(self, stance: Stance, running: StepPlan | None) -> GaitPreview | None:
        """The same object as long as nothing else is foreseen."""
        key = (self.walk.prediction, stance, running)
        known = self._previewed[0]
        if not known or any(a is not b for a, b in zip(key, known, strict=True)):
            self._previewed = key, ahead(self.walk, stance, running)
        return self._previewed[1]

    def progress(self, stance: Stance, running: StepPlan | None, body: Body) -> float:
        return course_now(stance, running, body, self.walk.machine.yaw_length)
