"""The trace walker on one page: predict globally on s, hand over one step at a time.

``prediction`` makes K's global prediction, about two body lengths ahead. ``plan_step`` takes its
next change of state and gives it times. Whoever walks carries the prediction from step to step
(``TraceWalk`` does), and it serves as long as ``serves`` says so.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import replace
from typing import Any

from ..config import TraceSearch
from ..geometry.paths import SampledPath
from ..motion.step_builder import changed
from ..protocols import Weight, run_to_completion
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Blocked, Command, Gait, Reason, Stance, StepPlan
from .periodic_gaits import RigidGait
from .prediction import ON_ITS_OWN, Prediction, index_of, predicting, serves
from .timing import step_plan

PACE_MIN = 1e-3  # m/s; a slower command walks at this
PACE_SHARE_MIN = 0.2  # of the pace, towards the end of what is known to be passable
STATES_TOLD = 12  # moves ahead in the decision log


def plan_step(
    stance: Stance,
    command: Command,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    *,
    explain: bool = False,
    trace: SampledPath | None = None,
    prediction: Prediction | None = None,
    rigid: RigidGait | None = None,
) -> StepPlan | Blocked:
    """The next step along the trace (the joystick's own course when none is given), or why
    there is none.

    A ``prediction`` that still serves is used; otherwise one is made here and now.
    """
    if prediction is None or not serves(prediction, stance, command, terrain, machine, trace):
        prediction = run_to_completion(
            predicting(stance, command, terrain, machine, gait, trace=trace, rigid=rigid)
        )
    return next_step(prediction, stance, command, terrain, machine, gait, explain=explain)


class TraceWalk:
    """What a walk along a trace remembers between steps: its prediction. Called like any planner,
    it plans in slices.
    """

    def __init__(
        self,
        machine: Machine,
        gait: Gait,
        trace: SampledPath | None = None,
        rigid: RigidGait | None = None,
        search: TraceSearch = ON_ITS_OWN,
    ) -> None:
        self.machine = machine
        self.gait = gait
        self.trace = trace
        self.rigid = rigid
        self.search = search
        self.prediction: Prediction | None = None
        self.explain = False

    def __call__(
        self, stance: Stance, command: Command, terrain: TerrainMap
    ) -> Generator[Weight, bool | None, StepPlan | Blocked]:
        """Plan the step from ``stance``: a few states a slice, never all of them in one tick."""
        known = self.prediction
        if known is None or not serves(known, stance, command, terrain, self.machine, self.trace):
            known = yield from self._renewed(stance, command, terrain)
            self.prediction = known
            yield None
        return next_step(
            known, stance, command, terrain, self.machine, self.gait, explain=self.explain
        )

    def _renewed(
        self, stance: Stance, command: Command, terrain: TerrainMap
    ) -> Generator[Weight, None, Prediction]:
        """A new prediction; the old one is kept while it leads farther over the same ground."""
        old = self.prediction
        new = yield from predicting(
            stance,
            command,
            terrain,
            self.machine,
            self.gait,
            trace=self.trace,
            rigid=self.rigid,
            search=self.search,
        )
        if old is None or new.complete or new.reached > old.reached:
            return new
        if old.terrain is not terrain or old.command != command:
            return new
        n = index_of(old, stance)
        if n is None or n >= len(old.moves):
            return new
        return replace(old, complete=False, reason=new.reason)


def next_step(
    prediction: Prediction,
    stance: Stance,
    command: Command,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    *,
    explain: bool = False,
) -> StepPlan | Blocked:
    """The prediction's next move with its times; slower as the end of what is known to be passable
    comes near.
    """
    n = index_of(prediction, stance)
    if n is None or n >= len(prediction.moves):
        return Blocked(
            Reason.NO_WAY_ALONG if prediction.reason else Reason.ARRIVED,
            _first_to_leave(prediction),
            _decision(prediction, n) if explain else None,
            {"search": prediction.reason},
        )
    pace = command.speed
    if not prediction.given:
        pace = math.hypot(command.speed, machine.yaw_length * command.turn_rate)
    # the eye's horizon, or a blind alley that may yet open: slow down towards it
    if not prediction.complete:
        left = (prediction.reached - stance.course) / machine.torso[0]
        pace *= min(1.0, max(left, PACE_SHARE_MIN))
    plan = step_plan(stance, prediction.moves[n], max(pace, PACE_MIN), terrain, machine, gait)
    if not explain:
        return plan
    return changed(plan, decision=_decision(prediction, n))


def _first_to_leave(prediction: Prediction) -> int | None:
    if not prediction.moves:
        return None
    ends = [
        (segment[1], leg)
        for leg, segment in enumerate(prediction.moves[-1].segments)
        if segment is not None
    ]
    return min(ends)[1] if ends and not prediction.complete else None


def _decision(prediction: Prediction, n: int | None) -> dict[str, Any]:
    """Why: the existence segments of this state and the ones to come, what the horizon is, how much
    was looked at.
    """
    ahead = prediction.moves[n or 0 :]
    return {
        "states_met": prediction.looked,
        "reached_m": prediction.reached,
        "goal_m": prediction.goal,
        "complete": prediction.complete,
        "reason": prediction.reason,
        "states": [
            {
                "course_m": move.course,
                "moved": [leg + 1 for leg in move.legs],
                "segments_m": [
                    None if segment is None else list(segment) for segment in move.segments
                ],
            }
            for move in ahead[:STATES_TOLD]
        ],
    }
