"""How fast a plan is played, and how a body in motion is brought to rest.

A swayed plan has a body with bounded acceleration; played at another pace it keeps it: the pace
changes no faster than that allows, and a stop goes on along the plan ever slower. A plan with the
body straight as printed changes its pace and stops at once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..motion.body_bounds import STEEPEST, CarryingFeet, bounds_of
from ..motion.body_course import centre_over
from ..motion.braking import LEAST_SHARE, STANDS, Braking, braking
from ..stability import support_polygon
from ..types import TICK, Command, Sensing, Stance
from .execution import Execution

SOON = 0.4  # s; a foot that lands by then is waited for where the body is too fast to stop before
CREEPS = 1e-9  # m/s; a plan with a slower body is played as slowly as is wanted at once
SLOWER = 0.5  # of the speed, while a foot slips and for a while after


def pace_for(run: Execution, command: Command) -> float:
    """How fast to play the step: a change of speed inside it takes effect at once, or as soon as
    the body can, never above its v_max.

    A body that waits for its foot is not kept waiting longer by a slower command.
    """
    tracker = run.tracker
    known, ratio = tracker.wanted
    if known is not command:
        plan = tracker.plan
        if command.holds and plan.rates is not None:
            return run.pace  # its foot is to land first
        if plan.speed <= 0.0:
            return _in_reach(run, 1.0)
        wanted = _asked(run, command)
        if run.compliant is not None and run.compliant.slips:
            wanted *= SLOWER
        if plan.speed_max > 0.0:
            wanted = min(wanted, plan.speed_max)
        ratio = wanted / plan.speed
        if run.compliant is None:
            tracker.wanted = command, ratio
    if ratio > 1.0 + 1e-12:
        return _in_reach(run, min(ratio, max(1.0, _pace_max(run))))
    pace = ratio if ratio < 1.0 and tracker.body_moves(run.t) else 1.0
    return pace if pace == run.pace else _in_reach(run, pace)


def _asked(run: Execution, command: Command) -> float:
    """The speed asked for, m/s, as if the step were as fast as it was planned for: one that the
    sway has made slower anyway is not to be slower than the command, nor one without way on.
    """
    plan = run.tracker.plan
    asked = math.hypot(command.speed, run.machine.yaw_length * command.turn_rate)
    if plan.rates is None or asked >= plan.speed * (1.0 - 1e-9):
        return asked
    return plan.speed if asked >= plan.mean_speed else asked * plan.speed / plan.mean_speed


def _pace_max(run: Execution) -> float:
    """How many times faster than planned may be played now."""
    if run.tracker.plan.rates is None:
        return run.tracker.pace_max(run.t, run.machine)
    return run.tracker.pace_ahead(run.t, run.machine, run.acceleration)


def _in_reach(run: Execution, pace: float) -> float:
    """The pace nearest to one wanted that a smoothly moving body can have a tick on."""
    if run.tracker.plan.rates is None or pace == run.pace:
        return pace
    vx, vy, _, turn = run.tracker.velocity_at(run.t)
    speed = math.hypot(vx, vy, run.machine.yaw_length * turn)
    bends = run.pace * run.pace * run.tracker.acceleration_at(run.t)
    left = max(run.acceleration - bends, LEAST_SHARE * run.acceleration)
    slower = left * TICK / max(speed, CREEPS)
    faster = left * TICK / max(speed, STANDS)
    return min(max(pace, run.pace - slower), run.pace + faster)


def braking_now(run: Execution, sensing: Sensing, nearest: bool = False) -> Braking | None:
    """The body's way to rest from where it is, by what the ``nearest`` edge allows or those ahead;
    None when it stands or stops dead: as printed, or because it is held back.
    """
    if run.held_back(sensing):
        return None
    footing = _footing(run, run.carrying(standing=False), nearest)
    return _braking_at(run, sensing.body[0], sensing.body[1], footing)


def braking_from(run: Execution, stance: Stance) -> Braking | None:
    """The same from where the body came out at the end of the plan."""
    carrying = [leg not in stance.lifted for leg in range(len(stance.feet))]
    return _braking_at(run, stance.place[0], stance.place[1], _footing(run, carrying))


def lands_first(run: Execution, way: Braking | None) -> bool:
    """True of a body that is too fast to stop on the feet that carry now, or stops sooner on one
    that lands soon.
    """
    if way is None or run.pace <= 0.0:
        return False
    left = (run.tracker.duration - run.t) / run.pace
    vx, vy, _, turn = way.rates[0]
    stopped = left + math.hypot(vx, vy, run.machine.yaw_length * turn) / STEEPEST
    return left <= SOON and (not way.safe or stopped < way.seconds - TICK)


def _braking_at(run: Execution, x: float, y: float, footing: CarryingFeet) -> Braking | None:
    if not run.gait.sways:
        return None
    way = braking(run.tracker, run.t, run.pace, footing, run.machine.yaw_length)
    if way is None:
        return None
    dx = x - way.body[0][0]
    dy = y - way.body[0][1]
    lean = run.tracker.lean_at(run.t)
    near = math.hypot(dx, dy) <= run.tolerances.same_place
    return way if near else way.moved(dx, dy, lean[0] * dx + lean[1] * dy)


def _footing(run: Execution, carrying: Sequence[bool], nearest: bool = False) -> CarryingFeet:
    """What carries the body where the plan has it."""
    body = run.tracker.body_at(run.t)
    feet = [run.tracker.foot_at(leg, run.t) for leg in range(len(carrying))]
    polygon = support_polygon(foot for foot, carries in zip(feet, carrying, strict=True) if carries)
    return CarryingFeet(
        polygon,
        centre_over(run.machine, body, feet, run.tracker.lean_at(run.t)),
        bounds_of(run.stance, run.gait),
        nearest,
    )
