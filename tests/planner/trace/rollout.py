"""A walk on paper: step after step as planned, every invariant looked at on the way. Shared by the
trace tests.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from walking_console.planner.config import TraceSearch
from walking_console.planner.geometry.paths import SampledPath
from walking_console.planner.initial_stance import Placement, square_stance
from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import MARGIN_SLACK, polygon_margin, support_polygon
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.trace.periodic_gaits import RigidGait
from walking_console.planner.trace.planner import TraceWalk
from walking_console.planner.types import Blocked, Command, Gait, Phase, Reason, Stance, StepPlan

ON_THE_TRACE = TraceSearch(detour=0.0)  # K's own test: the trace does not bend
TOUCH = 0.005  # m, a foot's reach may be exceeded by while the torso turns between knots


def gait_of(machine: Machine) -> Gait:
    return Gait(machine.duty_factor, machine.lift_up, machine.lift_down, machine.height)


def field_of(
    fraction: float,
    seed: int,
    machine: Machine,
    box: tuple[float, float, float, float] = (-3, 11, -3.5, 3.5),
) -> TerrainMap:
    """Ground of which a fraction of 5 cm cells is allowed; the cells under the start posture
    are.
    """
    cell, rng = 0.05, np.random.default_rng(seed)
    columns, rows = round((box[1] - box[0]) / cell), round((box[3] - box[2]) / cell)
    forbidden = rng.random((rows, columns)) >= fraction
    for leg in machine.legs:
        x, y = leg.centre
        forbidden[math.floor((y - box[2]) / cell), math.floor((x - box[0]) / cell)] = False
    return TerrainMap(np.where(forbidden, np.nan, 0.0), forbidden, cell, (box[0], box[2]))


@dataclass
class Walked:
    stance: Stance
    steps: list[StepPlan] = field(default_factory=list)
    blocked: Blocked | None = None
    faults: list[str] = field(default_factory=list)
    seconds: float = 0.0
    slices: int = 0

    @property
    def arrived(self) -> bool:
        return self.blocked is not None and self.blocked.reason is Reason.ARRIVED


def walk(
    machine: Machine,
    terrain: TerrainMap,
    command: Command,
    trace: SampledPath | None = None,
    *,
    until: float = math.inf,
    steps: int = 600,
    rigid: RigidGait | None = None,
    check: bool = True,
    stance: Stance | None = None,
    search: TraceSearch = ON_THE_TRACE,
) -> Walked:
    gait = gait_of(machine)
    pose = trace.pose(0.0) if trace is not None else (0.0, 0.0, 0.0)
    place = Placement(pose, lambda x, y: 0.0 if terrain.is_level else terrain.height_at(x, y))
    now = stance or square_stance(machine, gait, place)
    out, think = Walked(now), TraceWalk(machine, gait, trace, rigid, search)
    for _ in range(steps):
        thinking = think(now, command, terrain)
        while True:
            try:
                next(thinking)
                out.slices += 1
            except StopIteration as done:
                answer = done.value
                break
        if isinstance(answer, Blocked):
            out.blocked = answer
            break
        if check:
            out.faults += [
                f"step {len(out.steps)}: {fault}"
                for fault in faults_of(answer, now, machine, terrain)
            ]
        out.steps.append(answer)
        out.seconds += float(answer.times[-1])
        now = out.stance = answer.end
        if now.course >= until:
            break
    return out


def faults_of(plan: StepPlan, stance: Stance, machine: Machine, terrain: TerrainMap) -> list[str]:
    """What is wrong with a step: landing, margin, reach, foot speed, standing feet, feet down,
    continuity.
    """
    found = []
    if not np.allclose(plan.feet[0], stance.feet, atol=1e-9) or not np.allclose(
        plan.body[0], stance.body, atol=1e-9
    ):
        found.append("does not begin where the machine stands")
    if np.any(np.diff(plan.times) <= 0.0):
        found.append("times do not increase")
    for leg, foot in enumerate(plan.end.feet):
        if (
            leg not in plan.end.lifted
            and leg in plan.swing
            and not terrain.allows(foot[0], foot[1])
        ):
            found.append(f"leg {leg} lands on forbidden ground at {foot}")
    for k, phase in enumerate(plan.phases):
        air = () if phase is Phase.SUPPORT else plan.swing
        for part in (0.0, 0.5, 1.0):
            found += _instant(plan, k, part, air, machine)
        found += _speeds(plan, k, machine)
        for leg in range(len(machine.legs)):
            if leg not in air and np.abs(plan.feet[k + 1, leg] - plan.feet[k, leg]).max() > 1e-9:
                found.append(f"standing foot {leg} moves in stretch {k}")
    return found


def _instant(
    plan: StepPlan, k: int, part: float, air: tuple[int, ...], machine: Machine
) -> list[str]:
    body = plan.body[k] + part * (plan.body[k + 1] - plan.body[k])
    feet = plan.feet[k] + part * (plan.feet[k + 1] - plan.feet[k])
    found, standing = [], [leg for leg in range(len(machine.legs)) if leg not in air]
    if len(standing) < 3:
        found.append(f"only {len(standing)} feet down")
    margin = polygon_margin(support_polygon([feet[leg] for leg in standing]), body[0], body[1])
    if margin < -MARGIN_SLACK:
        found.append(f"margin {margin:.4f}")
    c, d = math.cos(body[3]), math.sin(body[3])
    for leg, description in enumerate(machine.legs):
        x, y, z = feet[leg] - body[:3]
        bx, by = c * x + d * y, c * y - d * x
        slack = TOUCH if plan.body[0, 3] != plan.body[-1, 3] else 1e-6
        low, high = description.z
        if leg in air:
            low, high = low - machine.overreach[2], high + machine.overreach[2]
        inside = (
            description.x[0] - slack <= bx <= description.x[1] + slack
            and description.y[0] - slack <= by <= description.y[1] + slack
        )
        if not inside or not low - 1e-6 <= z <= high + 1e-6:
            found.append(
                f"foot {leg} out of reach at ({bx:.4f}, {by:.4f}, {z:.4f}) in stretch {k}"
                f" {plan.phases[k].name}"
            )
    return found


def _speeds(plan: StepPlan, k: int, machine: Machine) -> list[str]:
    seconds = plan.times[k + 1] - plan.times[k]
    found = []
    ends = []
    for j in (k, k + 1):
        yaw = plan.body[j, 3]
        c, d = math.cos(yaw), math.sin(yaw)
        rel = plan.feet[j] - plan.body[j, :3]
        ends.append(
            np.stack(
                [c * rel[:, 0] + d * rel[:, 1], c * rel[:, 1] - d * rel[:, 0], rel[:, 2]], axis=1
            )
        )
    fastest = np.abs(ends[1] - ends[0]) / seconds
    for leg, speeds in enumerate(fastest):
        for axis, limit in enumerate(machine.speed):
            if speeds[axis] > limit + 1e-6:
                found.append(
                    f"foot {leg} at {speeds[axis]:.3f} m/s on axis {axis} in stretch {k}"
                    f" {plan.phases[k].name}"
                )
    return found
