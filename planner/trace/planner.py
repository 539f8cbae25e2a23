"""The trace walker on one page: predict globally on s, hand over one step at a time.

``predict`` is K's global prediction, about two body lengths ahead: states, footholds, existence
segments. ``plan_step`` takes its next change of state and gives it times. A ``Prediction`` is a
frozen value; whoever walks carries it from step to step (``TraceWalk`` does) and it serves until
its horizon has shrunk to a body length or the command, the trace or the ground under its footholds
has changed.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..geometry.paths import SampledPath
from ..motion.step_builder import changed
from ..protocols import run_to_completion
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Array, Blocked, Command, Gait, Point, Stance, StepPlan
from .moves import Move, moves_along
from .paths import joystick_trace, step_for
from .periodic_gaits import RigidGait
from .reachability import AIR, Field, Lane, thinning
from .state_search import Path, search, search_rigid
from .state_sequence import State
from .timing import step_plan

BODY_LENGTHS = 2.0  # how far ahead the global prediction looks, K
RENEW = 1.0  # body lengths left ahead when it is made anew
BACK = 0.5  # body lengths behind the machine it may go back to leave a blind alley
JOIN = 0.3  # body lengths over which a body beside its trace comes back to it
# body lengths the body may leave the trace sideways, only where on it there is no way: 0.10 m for a
# body of 1.6 m
SWAY = 1 / 16
SWAY_TURNING = 0.04  # m at most while turning on the spot
# rows of the wide search, in parts of SWAY; the trace itself first
SWAYS = (0.0, 0.5, -0.5, 1.0, -1.0)
LIMIT = 6_000  # states met on the trace itself; more finds little that sway does not find sooner
# states met with sway, some two seconds of thinking: less blocks on ground that can be crossed
LIMIT_WIDE = 20_000
SAME = 1e-3  # m; a foot this near to where the prediction has it is there
ARRIVED = "the trace ends here"


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


def plan_step(
    stance: Stance, command: Command, terrain: TerrainMap, machine: Machine, gait: Gait, *, explain: bool = False,
    trace: SampledPath | None = None, prediction: Prediction | None = None, rigid: RigidGait | None = None,
) -> StepPlan | Blocked:  # fmt: skip
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
    """What a walk along a trace remembers between steps: its prediction. Called like any ``think``,
    it plans in slices.
    """

    def __init__(
        self,
        machine: Machine,
        gait: Gait,
        trace: SampledPath | None = None,
        rigid: RigidGait | None = None,
    ) -> None:
        self.machine, self.gait, self.trace, self.rigid = machine, gait, trace, rigid
        self.prediction: Prediction | None = None
        self.explain = False

    def __call__(
        self, stance: Stance, command: Command, terrain: TerrainMap
    ) -> Generator[None, bool | None, StepPlan | Blocked]:
        """Think about the step from ``stance``: a few states a slice, never a whole prediction in
        one tick.
        """
        known = self.prediction
        if known is None or not serves(known, stance, command, terrain, self.machine, self.trace):
            known = yield from self._renewed(stance, command, terrain)
            self.prediction = known
            yield
        return next_step(
            known, stance, command, terrain, self.machine, self.gait, explain=self.explain
        )

    def _renewed(
        self, stance: Stance, command: Command, terrain: TerrainMap
    ) -> Generator[None, None, Prediction]:
        """A new prediction; the old one is kept while it leads farther over the same ground."""
        old = self.prediction
        new = yield from predicting(
            stance, command, terrain, self.machine, self.gait, trace=self.trace, rigid=self.rigid
        )
        if (
            old is None
            or new.complete
            or old.terrain is not terrain
            or old.command != command
            or new.reached > old.reached
        ):
            return new
        n = index_of(old, stance)
        return (
            new
            if n is None or n >= len(old.moves)
            else replace(old, complete=False, reason=new.reason)
        )


# using a prediction


def index_of(prediction: Prediction, stance: Stance) -> int | None:
    """Which of the prediction's moves starts at this stance; None when the stance is none of its
    own.
    """
    feet: tuple[Point | None, ...] = tuple(
        None if leg in prediction.start.lifted else f for leg, f in enumerate(prediction.start.feet)
    )
    body: tuple[float, ...] = prediction.start.body
    for n in range(len(prediction.moves) + 1):
        if _near(body, stance.body) and all(
            leg in stance.lifted
            if at is None
            else leg not in stance.lifted and _near(at, stance.feet[leg])
            for leg, at in enumerate(feet)
        ):
            return n
        if n < len(prediction.moves):
            feet, body = prediction.moves[n].after, prediction.moves[n].carry[-1]
    return None


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
    if n is None or n >= len(prediction.moves):
        return False
    if (
        prediction.trace is not trace
        if trace is not None
        else prediction.given or _course_of(prediction.command) != _course_of(command)
    ):
        return False
    if (
        prediction.complete
        and prediction.goal - stance.course < RENEW * machine.torso[0]
        and not prediction.last
    ):
        return False
    if prediction.terrain is terrain:
        return True
    return prediction.complete and all(
        point is None or terrain.allows(point[0], point[1])
        for move in prediction.moves[n:]
        for point in (move.after[k] for k in move.legs)
    )


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
            prediction.reason or ARRIVED,
            _first_to_leave(prediction),
            _decision(prediction, n) if explain else None,
        )
    pace = (
        command.speed
        if prediction.given
        else math.hypot(command.speed, machine.yaw_length * command.turn_rate)
    )
    # the eye's horizon, or a blind alley that may yet open: slow down towards it
    if not prediction.complete:
        left = (prediction.reached - stance.course) / machine.torso[0]
        pace *= min(1.0, max(left, 0.2))
    plan = step_plan(stance, prediction.moves[n], max(pace, 1e-3), terrain, machine, gait)
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
            for move in ahead[:12]
        ],
    }


# making one


def predicting(
    stance: Stance, command: Command, terrain: TerrainMap, machine: Machine, gait: Gait, *, trace: SampledPath | None = None,
    rigid: RigidGait | None = None, limit: int = LIMIT, limit_wide: int = LIMIT_WIDE,
) -> Generator[None, None, Prediction]:  # fmt: skip
    """Predict from ``stance``: on the trace by K's order and by search, then with sway; the best of
    these, and of ``older``.
    """
    given = trace is not None
    step = step_for(machine)
    ahead = round(BODY_LENGTHS * machine.torso[0] / step)
    if trace is None:
        x, y, _, yaw = stance.body
        drawn = joystick_trace(
            (x, y, yaw),
            command.crab_angle,
            command.speed,
            command.turn_rate,
            machine.yaw_length,
            ahead * step,
            step,
        )
        first, now, offset = 0, 0, stance.course
    else:
        drawn, step = trace, trace.step
        ahead = round(BODY_LENGTHS * machine.torso[0] / step)
        now = min(round(stance.course / step), drawn.last)
        first = max(0, now - round(BACK * machine.torso[0] / step))
        offset = first * step
    last = min(now + ahead, drawn.last)
    goal = last - first
    path, looked = Path((), False, now - first, 0, False), 0
    moves: tuple[Move, ...] = ()
    grazed = False
    for sway, count in ((0.0, limit), (SWAY * machine.torso[0], limit_wide)):
        if rigid is not None and sway:
            break
        lane = lane_along(drawn, first, last, now, stance, terrain, machine, gait, sway)
        thin = thinning(lane, terrain, machine)
        if thin > 1:
            # plenty of ground everywhere: what stops it is an edge, and sway does not help
            count = limit
        field = Field(lane, terrain, machine, thin=thin)
        for leg in range(len(machine.legs)):
            yield
            field.find(leg)
        yield
        start = State(_standing(field, stance, now - first), now - first)
        if not field.accept(start.feet, start.at):
            break
        if rigid is None:
            found = yield from search(field, start, goal, count)
        else:
            found = yield from search_rigid(
                field, start, goal, limit, _from_next(rigid, stance.last_swing)
            )
        looked += found.looked
        if found.farthest > path.farthest or not moves:
            path = found if found.complete else found.to_standing()
            grazed = field.grazed and not _any_row(field, min(found.farthest + 1, field.count - 1))
            moves = yield from moves_along(
                field, path, offset, step, *(() if rigid is None else (1,))
            )
        if found.complete:
            break
        yield
    reached = offset + path.farthest * step
    sure = reached if path.complete else moves[-1].course if moves else stance.course
    reason = "" if path.complete else _why(path, reached, looked, grazed)
    return Prediction(
        drawn, command, terrain, stance, moves, sure, offset + goal * step, path.complete, reason, looked, given,
        last=given and last == drawn.last,
    )  # fmt: skip


def _from_next(rigid: RigidGait, last_swing: int) -> tuple[tuple[int, ...], ...]:
    """A rigid gait's groups beginning with the one after the legs that moved last."""
    groups = rigid.groups
    k = next((n + 1 for n, group in enumerate(groups) if last_swing in group), 0)
    return groups[k:] + groups[:k]


def _any_row(field: Field, k: int) -> bool:
    """True when the torso meets nothing at sample ``k`` of the trace, or beside it."""
    return any(field.everywhere >> (r * field.width + k) & 1 for r in range(field.rows))


def _why(path: Path, reached: float, looked: int, grazed: bool) -> str:
    if not path.states:
        return "the machine does not stand within reach and stable here"
    if grazed:
        return f"there is no way beyond s = {reached:.2f} m: the torso would touch the ground"
    known = "there is no way" if path.exhausted else f"no way was found among {looked} states"
    return f"{known} beyond s = {reached:.2f} m: no foothold lets the next leg leave its own"


def _standing(field: Field, stance: Stance, sample: int) -> tuple[int, ...]:
    return tuple(
        AIR if leg in stance.lifted else field.stand(leg, foot, sample)
        for leg, foot in enumerate(stance.feet)
    )


def lane_along(
    trace: SampledPath,
    first: int,
    last: int,
    now: int,
    stance: Stance,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    sway: float,
) -> Lane:
    """The body's poses: through where it is now, back to the trace over JOIN, and beside it up to
    ``sway`` in every row.
    """
    part = slice(first, last + 1)
    x, y, yaw = trace.x[part].copy(), trace.y[part].copy(), trace.yaw[part].copy()
    tx, ty = (
        np.gradient(values) if len(values) > 1 else np.zeros_like(values) for values in (x, y)
    )
    size = np.hypot(tx, ty)
    moving = size > 1e-6
    safe = np.where(moving, size, 1.0)
    nx, ny = np.where(moving, -ty / safe, -np.sin(yaw)), np.where(moving, tx / safe, np.cos(yaw))
    fade = np.clip(
        1.0 - np.abs(np.arange(first, last + 1) - now) * trace.step / (JOIN * machine.torso[0]),
        0.0,
        1.0,
    )
    bx, by, bz, byaw = stance.body
    off_x, off_y = bx - trace.x[now], by - trace.y[now]
    off_yaw = math.remainder(byaw - trace.yaw[now], 2 * math.pi)
    turned = byaw - off_yaw - trace.yaw[now]  # whole turns between the trace's count and the body's
    x, y, yaw = x + fade * off_x, y + fade * off_y, yaw + fade * off_yaw + turned
    z = body_heights(x, y, terrain, machine, gait)
    z = z + fade * (bz - z[now - first])
    if sway == 0.0:
        return Lane(x[None, :], y[None, :], yaw, z)
    width = sway if bool(moving.mean() > 0.5) else min(sway, SWAY_TURNING)
    beside = fade * (off_x * nx + off_y * ny)
    rows = [
        np.clip(beside + part_ * width, -width, width) - beside if part_ else np.zeros_like(x)
        for part_ in SWAYS
    ]
    return Lane(
        np.stack([x + row * nx for row in rows]), np.stack([y + row * ny for row in rows]), yaw, z
    )


def body_heights(x: Array, y: Array, terrain: TerrainMap, machine: Machine, gait: Gait) -> Array:
    """Height of the centre of gravity: H above the mean of the ground under the body, smoothed over
    half its length.
    """
    if terrain.is_level:
        return np.full(len(x), terrain.highest + gait.height)
    length = machine.torso[0]
    grid = np.linspace(-length / 2, length / 2, 7)
    ground = []
    for gx in grid:
        for gy in grid:
            columns = np.clip(
                np.floor((x + gx - terrain.origin[0]) / terrain.cell).astype(int),
                0,
                terrain.columns - 1,
            )
            rows = np.clip(
                np.floor((y + gy - terrain.origin[1]) / terrain.cell).astype(int),
                0,
                terrain.rows - 1,
            )
            ground.append(terrain.heights[rows, columns])
    table = np.array(ground, dtype=np.float64)
    solid = np.isfinite(table)
    count = solid.sum(axis=0)
    mean = np.where(
        count > 0, np.where(solid, table, 0.0).sum(axis=0) / np.maximum(count, 1), np.nan
    )
    if not np.isfinite(mean).any():
        return np.full(len(x), gait.height)
    known = np.isfinite(mean)
    mean = np.interp(np.arange(len(x)), np.nonzero(known)[0], mean[known])
    return np.asarray(mean + gait.height)
