"""A step Level B2 decided on as a plan: heights, clock and knots (Levels B3 and B4, H §6, §7).

Every planner of this folder ends here, on lines and on arcs. Standing feet turn about the centre as
the body does; the swing foot returns along a straight line in body axes, which is what the servos
drive. Between knots the body goes straight: pieces of 0.02 rad are within 0.03 mm of an arc.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import chain

from ..decision_log import DecisionLog
from ..geometry.paths import arc_exit, corners_of_box, line_exit
from ..geometry.transforms import XY, turned_back
from ..motion.quarter_turns import quarter_turned
from ..motion.step_builder import plan_of_one_foot, shift_plan, with_feet
from ..motion.strides import STRETCHED_LIFT_ROOM
from ..motion.swing import SwingCorners, lift, profile_of
from ..motion.timing import (
    BodyWay,
    SwingDemand,
    Timing,
    cruise_limit,
    knots,
    return_limit_on,
    timing,
)
from ..robot.model import Machine
from ..types import Blocked, Gait, Point, Reason, Stance, StepPlan
from .foothold_checks import FootholdChecks
from .foothold_search import corners_of, domain_of
from .gait import EARLY, NominalGait, Posture, nominal_gait
from .steps import BodyShift, Candidate, SwingStep


def swing_plan(
    checks: FootholdChecks, step: SwingStep, speed: float, log: DecisionLog | None = None
) -> StepPlan | Blocked:
    """The plan of a swing, the body raised where its torso must clear the ground; ``Blocked`` where
    the legs do not reach that high. ``speed`` is along the path, m/s; 0: as fast as it can.
    """
    limits = checks.height_limits(step, checks.ground_at(step.landing))
    height = checks.height_after(step, step.landing, limits)
    needs = checks.torso_needs(step.g, height)
    if needs > limits[1]:
        facts = {"needs": needs, "reach": limits[1]}
        return Blocked(Reason.TORSO_TOUCHES, None, log, facts)
    return build(checks, step, max(height, needs), speed, log)


def plan_of(
    checks: FootholdChecks, candidate: Candidate, speed: float, log: DecisionLog | None = None
) -> StepPlan | Blocked:
    """A candidate with its heights and times."""
    if isinstance(candidate, BodyShift):
        return body_shift_plan(checks, candidate, speed, log)
    return swing_plan(checks, candidate, speed, log)


def build(
    checks: FootholdChecks,
    step: SwingStep,
    height: float,
    speed: float,
    log: DecisionLog | None = None,
) -> StepPlan:
    """The plan of a swing, the body ending at ``height`` (H §7)."""
    nominal = checks.nominal
    posture = checks.posture
    stance = checks.stance
    leg = nominal.body_leg[step.leg]
    landing = checks.foot_at(step.landing)
    way = BodyWay(stance.body, (posture.c, posture.s), nominal.path, step.g, height)
    crest = checks.crest(step.leg, step.landing)
    lifts = stance.feet[leg], landing, crest, checks.ceiling(height), height
    corners = lift(*lifts, checks.machine, checks.gait)
    clock = _clock(checks, step, way, corners, speed)
    rows, phases = knots(clock, profile_of(checks.gait), way, step.g0, corners)
    if log is not None:
        log["domain"] = searched(posture, step)
    return plan_of_one_foot(
        stance,
        leg,
        rows,
        phases,
        _end_of(checks, step, landing, way),
        crab_angle=nominal.course,
        support_shift=step.g0,
        shift=step.g,
        standard_margin=nominal.margin,
        margin_min=step.margin,
        speed=clock.speed if clock.speed > 0.0 else clock.support_speed,
        speed_max=clock.speed_max if clock.speed > 0.0 else clock.support_speed,
        search_start=(*posture.absolute(*step.start), landing[2]),
        landing=landing,
        decision=log,
    )


def _end_of(checks: FootholdChecks, step: SwingStep, landing: Point, way: BodyWay) -> Stance:
    nominal = checks.nominal
    leg = nominal.body_leg[step.leg]
    feet = with_feet(checks.stance.feet, {leg: landing})
    course = checks.stance.course + step.g
    held = checks.stance.held_course
    return Stance(way.end, feet, leg, nominal.quarter_turns, (), course, held_course=held)


def body_shift_plan(
    checks: FootholdChecks, shift: BodyShift, speed: float, log: DecisionLog | None = None
) -> StepPlan:
    """The plan of a four-leg shift: the body goes straight, at its height, no faster than the
    nominal walk in that direction.
    """
    nominal, (x, y, _, yaw) = checks.nominal, checks.stance.body
    place = end_x, end_y = checks.posture.absolute(shift.x, shift.y)
    course = math.atan2(end_y - y, end_x - x) - yaw
    speed_max = cruise_speed(checks.machine, checks.gait, math.remainder(course, 2 * math.pi))
    return shift_plan(
        checks.stance,
        place,
        nominal.quarter_turns,
        crab_angle=course,
        shift=math.hypot(shift.x, shift.y),
        standard_margin=nominal.margin,
        margin_min=shift.margin,
        speed=min(speed_max, speed) if speed > 0.0 else speed_max,
        speed_max=speed_max,
        decision=log,
    )


# the clock


def _clock(
    checks: FootholdChecks, step: SwingStep, way: BodyWay, corners: SwingCorners, speed: float
) -> Timing:
    nominal = checks.nominal
    path = nominal.path
    stand, top, over, aim = corners
    fx, fy = checks.posture.feet[step.leg]
    dx, dy = quarter_turned(step.landing.x - fx, step.landing.y - fy, nominal.quarter_turns)
    if path.turn == 0.0:
        courses = _courses(nominal, ())
        limit = None
    else:
        dx, dy = turned_back(dx, dy, path.turn * step.g0)
        # of all that feet reach: where the body goes past fastest
        courses = _courses(nominal, chain(*map(corners_of_box, nominal.far_boxes)))
        limit = return_limit_on(way, step.g0, corners)
    demand = SwingDemand(
        (dx, dy, over[2] - top[2]),
        courses,
        way.dz,
        step.g0,
        step.g,
        top[2] - stand[2],
        over[2] - aim[2],
        _room(nominal, checks.posture, step),
        limit,
    )
    machine = checks.machine
    gait = checks.gait
    return timing(machine, gait, demand, speed, lambda: cruise_on(machine, gait, nominal))


def _room(nominal: NominalGait, posture: Posture, step: SwingStep) -> tuple[float, float]:
    """How far the body may go on during the lift and during the descent before the foot is out of
    mechanical reach, m.
    """
    path = nominal.path
    box = nominal.far_boxes[step.leg]
    fx, fy = posture.feet[step.leg]
    x, y, _, _ = step.landing
    ux, uy, turn = path
    if turn == 0.0:
        behind = line_exit(fx, fy, box, ux, uy) - step.g0
        beyond = line_exit(x - ux * step.g, y - uy * step.g, box, -ux, -uy)
        least = nominal.size * STRETCHED_LIFT_ROOM
        return max(behind, least), max(beyond, least)
    x, y = path.seen(x, y, step.g)
    behind = arc_exit(fx, fy, box, path) - step.g0
    beyond = arc_exit(x, y, box, path.reversed())
    # a foot that touches early, at mid-descent, is no farther than that beyond its place
    drift = max(*map(abs, path.rate(x, y)), 1e-9)
    early = nominal.size * EARLY
    return max(behind, early / 2), min(max(beyond, early / 2), 2 * early / drift)


def _courses(nominal: NominalGait, places: Iterable[XY]) -> tuple[XY, ...]:
    """The body's way past standing feet at ``places`` per metre of s, body axes; past all alike on
    a line.
    """
    path = nominal.path
    if path.turn == 0.0:
        return (quarter_turned(path.ux, path.uy, nominal.quarter_turns),)
    return tuple(path.rate(x, y) for x, y in places)


def cruise_speed(machine: Machine, gait: Gait, crab_angle: float) -> float:
    """v_max of the nominal walk at a crab angle, m/s: what a command is held against before any
    step is planned.
    """
    return cruise_on(machine, gait, nominal_gait(machine, gait, crab_angle))


def cruise_on(machine: Machine, gait: Gait, nominal: NominalGait) -> float:
    """v_max of the nominal front step on level ground, m/s: past the slowest C_i on an arc."""
    courses = _courses(nominal, nominal.centres)
    return cruise_limit(machine, gait, nominal.duty_factor, nominal.stride, courses)


def searched(posture: Posture, step: SwingStep) -> list[list[float]]:
    """Corners of D_u in the absolute frame, for the decision log; the leg's whole reach at N_{k+1}
    where a search went beyond D_u.
    """
    nominal = posture.nominal
    reach = corners_of_box(nominal.boxes[step.leg])
    corners = [nominal.path.placed(x, y, step.g) for x, y in reach]
    if nominal.path.turn == 0.0:
        domain = domain_of(posture, step.leg, step.g, step.convergent)
        if domain.holds(step.landing.x, step.landing.y):
            corners = corners_of(domain)
    return [list(posture.absolute(x, y)) for x, y in corners]
