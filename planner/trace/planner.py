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
from ..types import Blocked, Command, Departure, Gait, Reason, Stance, StepPlan
from .detour import AHEAD, DETOUR, PLACE, ROW_WEIGHT, BentTrace, DeadEnd, GroundBeside, bent
from .periodic_gaits import RigidGait
from .prediction import (
    BODY_LENGTHS,
    LIMIT,
    LIMIT_WIDE,
    ON_ITS_OWN,
    Prediction,
    index_of,
    joystick_from,
    predicting,
    serves,
)
from .timing import step_plan

PACE_MIN = 1e-3  # m/s; a slower command walks at this
PACE_SHARE_MIN = 0.2  # of the pace, towards the end of what is known to be passable
BENDS_MAX = 3  # of a trace that are tried where it cannot be walked as it is
ASIDE_MIN = 0.02  # m; a bent trace this near to the given one is the same
WORTH = 0.25  # m farther that a bend must lead that does not lead to the goal
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
        self.bend: BentTrace | None = None  # how the trace is bent round something
        self.explain = False

    @property
    def course(self) -> SampledPath | None:
        """The trace that is walked: the given one, bent where it must be; None: the joystick's."""
        return self.trace if self.trace is None or self.bend is None else self.bend.path

    def __call__(
        self, stance: Stance, command: Command, terrain: TerrainMap
    ) -> Generator[Weight, bool | None, StepPlan | Blocked]:
        """Plan the step from ``stance``: a few states a slice, never all of them in one tick."""
        known = self.prediction
        if known is None or not serves(known, stance, command, terrain, self.machine, self.course):
            known = yield from self._renewed(stance, command, terrain)
            self.prediction = known
            yield None
        answer = next_step(
            known, stance, command, terrain, self.machine, self.gait, explain=self.explain
        )
        if self.bend is None or isinstance(answer, Blocked):
            return answer
        began = 0.0 if known.given else known.start.course
        return _along(answer, self.bend, began)

    def _renewed(
        self, stance: Stance, command: Command, terrain: TerrainMap
    ) -> Generator[Weight, None, Prediction]:
        """A new prediction; the old one is kept while it leads farther over the same ground."""
        old = self.prediction
        if self.trace is None:
            self.bend = None  # the joystick's trace is drawn anew
        ground = self._ground_beside(stance, command, terrain)
        new = None
        if ground is not None and ground.may_bar_the_torso(stance):
            yield from ground.looking()
            if ground.bars_the_torso(self.bend, BODY_LENGTHS * self.machine.torso[0]):
                new = yield from self._bending(None, ground, stance, command, terrain)
        if new is None:
            new = yield from self._predicted(stance, command, terrain, self.bend)
            if ground is not None and not new.complete:
                new = (yield from self._bending(new, ground, stance, command, terrain)) or new
                if not new.complete:
                    sides = f"nor round it within {ground.width:g} m to either side"
                    new = replace(new, reason=f"{new.reason}, {sides}")
        if old is None or new.complete or new.reached > old.reached or new.trace is not old.trace:
            return new
        if old.terrain is not terrain or old.command != command:
            return new
        n = index_of(old, stance)
        if n is None or n >= len(old.moves):
            return new
        return replace(old, complete=False, reason=new.reason)

    def _predicted(
        self, stance: Stance, command: Command, terrain: TerrainMap, bend: BentTrace | None
    ) -> Generator[Weight, None, Prediction]:
        """What is predicted along the trace as it is, or bent."""
        path = None if bend is None else bend.path
        return predicting(
            stance,
            command,
            terrain,
            self.machine,
            self.gait,
            trace=None if self.trace is None else path or self.trace,
            drawn=path,
            rigid=self.rigid,
            limit_wide=LIMIT_WIDE if bend is self.bend else LIMIT,
            search=self.search,
        )

    def _ground_beside(
        self, stance: Stance, command: Command, terrain: TerrainMap
    ) -> GroundBeside | None:
        """What lies beside the trace from here on; None where it is not to bend."""
        size = self.machine.torso[0]
        width = DETOUR * size if self.search.detour is None else self.search.detour
        trace = self.trace
        on_the_spot = trace is None and command.speed == 0.0
        if width < PLACE or on_the_spot or self.rigid is not None:
            return None
        now = 0
        if trace is None:
            trace = joystick_from(stance, command, self.machine, AHEAD)
        else:
            now = min(round(stance.course / trace.step), trace.last)
        return GroundBeside(trace, now, width, terrain, self.machine, self.gait)

    def _bending(
        self,
        found: Prediction | None,
        ground: GroundBeside,
        stance: Stance,
        command: Command,
        terrain: TerrainMap,
    ) -> Generator[Weight, None, Prediction | None]:
        """The trace bent round what stops it, if that leads on: the first of a few bends that leads
        to the goal, else the one that leads farthest; else what was ``found``.
        """
        yield from ground.looking()
        trace = ground.trace
        began = stance.course if self.trace is None else 0.0
        before = self.bend
        for _ in range(BENDS_MAX):
            bend = bent(before, ground)
            yield ROW_WEIGHT
            if bend is None:
                break
            new = yield from self._predicted(stance, command, terrain, bend)
            if new.complete or (found is not None and new.reached > found.reached + WORTH):
                found = new
                self.bend = bend
            if new.complete:
                break
            stop = min(round((new.reached - began) / trace.step), trace.last)
            ground.shun(DeadEnd(stop * trace.step, float(bend.offsets[stop])))
        return found


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


def _along(plan: StepPlan, bend: BentTrace, began: float) -> StepPlan:
    """The plan of a step along a bent trace whose first sample is at s = ``began``, with why it is
    not along the trace itself.
    """
    if plan.decision is not None:
        first, last = bend.extent
        plan.decision["detour"] = {
            "aside_m": bend.aside,
            "from_m": began + first,
            "to_m": began + last,
        }
    off = abs(bend.offset_at(plan.end.course - began)) > ASIDE_MIN
    return changed(plan, departure=Departure.TRACE_BENT) if off else plan


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
