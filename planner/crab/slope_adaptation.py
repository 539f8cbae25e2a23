"""Standing on a slope: strides as long as the legs' height allows, and a body that is level or
leans with the ground (``motion.slope_strides``; docs/slopes.md has the figures).

Planning with a lean goes on in a sheared frame, z' = z - l·(x, y): there the floor is level, lines
stay lines and verticals vertical, and a foot's height in body axes is z' times the cosine of the
lean, whatever its place. Below it nothing knows of leans. The plan is sheared back; Level C turns
the body to the lean (``control.posture_controller``).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ..motion.body_tilt import (
    LEVEL,
    FrameCache,
    Lean,
    ShearedFrame,
    approached,
    in_body,
    leaned,
    rounded,
)
from ..motion.slope_strides import SLOPE_GRAIN, Leans, SlopeWalker, fitted, towards_level
from ..motion.tilted_reach import whole_reach
from ..protocols import BodyAttitude, PlanFunction, PlanningJob
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..terrain.slope import slope_under
from ..types import Array, Command, Gait, Stance, StepPlan
from .gait import nominal_gait

# of a grain, by which a slope must change before it counts; less than 0.8: see strides and leans
# tremble
STAYS = 1.0
# m of planned margin a step that leans must have; 0: see it rock off a narrow triangle on 25°
SURE = 0.002
FRAME, SHEARED = 20, 120  # what the frame of a slope weighs, in postures looked at, and of a lean


class SlopeAdaptation:
    """A planner that stands on slopes as its machine can: strides fitted, and the body leaning
    when it is to follow the ground.

    ``planner_for`` makes the planner of one machine. The lean is remembered in ``Stance``;
    ``attitude`` may be changed at any time and counts from the next step planned on.
    """

    def __init__(
        self,
        machine: Machine,
        gait: Gait,
        planner_for: Callable[[Machine], PlanFunction],
        attitude: BodyAttitude = "level",
    ) -> None:
        self.machine = machine
        self._walker = walker_on_slopes(machine, gait)
        self.attitude = attitude
        self._planner_for = planner_for
        self._shears = FrameCache()
        self._leans = Leans(self._walker)
        self._slope = LEVEL  # that the present strides are fitted to
        # share of the lean it would take on this slope: less after steps with it that stood on an
        # edge
        self._trust = 1.0

    def __call__(self, stance: Stance, command: Command, terrain: TerrainMap) -> PlanningJob:
        if self.attitude == "ground":
            slope = self._slope_known(slope_under(stance, command, terrain, self.machine))
            yield from self._leans.weighed(stance.body[3], slope, command.straight_course)
        frame = self.frame(stance, command, terrain)
        yield 0 if terrain.is_level else (FRAME, SHEARED)[frame.terrain is not terrain]
        answer = yield from self._planned(frame, command)
        if frame.lean != LEVEL or stance.lean != LEVEL:
            if isinstance(answer, StepPlan) and not on_edge(answer):
                return frame.restored(answer, stance)
            self._trust /= 2
            if stance.lean != LEVEL:
                back = leaned(stance, approached(stance.lean, LEVEL), self.machine)
                return back or (
                    frame.restored(answer, stance) if isinstance(answer, StepPlan) else answer
                )
            frame = self.frame(stance, command, terrain, may_lean=False)
            answer = yield from self._planned(frame, command)
        if isinstance(answer, StepPlan) or frame.machine == self.machine:
            return answer
        # feet where the shorter strides do not want them
        return (yield from self._planner_for(self.machine)(stance, command, terrain))

    def _planned(self, frame: ShearedFrame, command: Command) -> PlanningJob:
        return self._planner_for(frame.machine)(frame.stance, command, frame.terrain)

    def frame(
        self, stance: Stance, command: Command, terrain: TerrainMap, may_lean: bool = True
    ) -> ShearedFrame:
        """The lean of the next step, and the frame it is planned in."""
        slope = self._slope_known(slope_under(stance, command, terrain, self.machine))
        lean = self._next_lean(stance, command, slope) if may_lean else LEVEL
        machine = self._fitted(stance, command, slope, lean)
        if machine is None and stance.lean != LEVEL:
            lean = approached(stance.lean, LEVEL)
            machine = self._fitted(stance, command, slope, lean)
        if machine is None:
            machine = whole_reach(
                self.machine,
                self._walker.gait,
                tuple(in_body(each, stance.body[3]) for each in (stance.lean, lean)),
            )
        return self._shears.frame(stance, terrain, machine or self.machine, lean)

    def _fitted(self, stance: Stance, command: Command, slope: Lean, lean: Lean) -> Machine | None:
        return fitted(
            self._walker, stance.body[3], slope, (stance.lean, lean), command.straight_course
        )

    def _slope_known(self, measured: Lean) -> Lean:
        """The slope rounded, and the one before as long as it is near: strides that change with
        every step keep no standard walk.
        """
        if math.dist(measured, self._slope) >= STAYS * SLOPE_GRAIN:
            self._slope = rounded(measured[0], SLOPE_GRAIN), rounded(measured[1], SLOPE_GRAIN)
            self._trust = 1.0
        return self._slope

    def _next_lean(self, stance: Stance, command: Command, slope: Lean) -> Lean:
        """One step of lean towards the one that follows the ground as far as it may."""
        target = LEVEL
        if self.attitude == "ground":
            share = self._leans.followed(stance.body[3], slope, command.straight_course)
            gx, gy = share * slope[0], share * slope[1]
            target = towards_level(self._trust * gx), towards_level(self._trust * gy)
        return approached(stance.lean, target)


def on_edge(plan: StepPlan) -> bool:
    """True of a step so near the edge that a body which leans in it could rock off its feet."""
    return plan.margin_min < min(SURE, plan.standard_margin)


def walker_on_slopes(machine: Machine, gait: Gait) -> SlopeWalker:
    """The machine with its standard walk."""
    return SlopeWalker(machine, gait, nominal_layouts)


def nominal_layouts(machine: Machine, gait: Gait, crab_angle: float) -> Array:
    """[u][i]: how far leg i stands ahead of C_i when u has just landed, in strides; gait frame."""
    nominal = nominal_gait(machine, gait, crab_angle)
    return np.array(nominal.layouts) / nominal.stride
