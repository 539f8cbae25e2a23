"""The supports that follow a step if the walk goes on as its nominal gait: for the body's sway."""

from __future__ import annotations

from ..geometry.paths import arc_of_command
from ..motion.body_path import SupportPhase
from ..robot.model import Machine
from ..stability import support_polygon
from ..types import Command, Gait, StepPlan
from .gait import NominalGait, nominal_gait, nominal_gait_on, posture_of
from .turning import turns

HIND = (1, 2)  # legs of the gait frame that wait for g0 before they swing
AHEAD = 3  # steps that are expected; fewer: see the body come late to its next support


def expected_supports(
    plan: StepPlan, command: Command, machine: Machine, gait: Gait
) -> tuple[SupportPhase, ...]:
    """The next few supports after a step, when legs swing in the nominal order by their nominal
    steps; times from its end, s. None after a step in which nothing swings.
    """
    if plan.end.last_swing < 0 or plan.speed <= 0.0:
        return ()
    nominal = _nominal(plan, command, machine, gait)
    posture = posture_of(nominal, plan.end)
    feet = list(posture.feet)
    way = 0.0
    leg = nominal.body_leg.index(plan.end.last_swing)
    supports = []
    for _ in range(AHEAD):
        leg = nominal.order.successor[leg]
        g = nominal.lags[leg]
        g0 = min(2.0 * max(nominal.margin, 0.0), g) if leg in HIND else 0.0
        polygon = support_polygon(
            posture.absolute(*foot) for other, foot in enumerate(feet) if other != leg
        )
        lift = nominal.path.pose(way + g0)
        land = nominal.path.pose(way + g)
        supports.append(
            SupportPhase(
                (way + g0) / plan.speed,
                (way + g) / plan.speed,
                polygon,
                posture.absolute(lift[0], lift[1]),
                posture.absolute(land[0], land[1]),
            )
        )
        way += g
        ahead = nominal.layouts[leg][leg]  # of C_u, when it has just landed
        feet[leg] = nominal.path.placed(*nominal.centres[leg], way + ahead)
    return tuple(supports)


def _nominal(plan: StepPlan, command: Command, machine: Machine, gait: Gait) -> NominalGait:
    """The nominal walk on the course of a command, or on the one a step took beside it."""
    if not turns(command, machine):
        return nominal_gait(machine, gait, plan.crab_angle, plan.end.quarter_turns)
    path, _ = arc_of_command(
        command.crab_angle, command.speed, command.turn_rate, machine.yaw_length
    )
    return nominal_gait_on(machine, gait, path, command.crab_angle)
