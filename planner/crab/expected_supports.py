"""The supports that follow a step if the walk goes on as its nominal gait: for the body's sway."""

from __future__ import annotations

from dataclasses import replace

from ..motion.body_path import SupportPhase
from ..robot.model import Machine
from ..stability import support_polygon
from ..types import Command, Gait, StepPlan
from .gait import nominal_gait_of, posture_of

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
    taken = replace(command, crab_angle=plan.crab_angle)  # a step may go beside what is commanded
    nominal = nominal_gait_of(taken, machine, gait, plan.end.quarter_turns)
    path = nominal.path
    posture = posture_of(nominal, plan.end)
    feet = list(posture.feet)
    way = 0.0
    leg = nominal.body_leg.index(plan.end.last_swing)
    supports = []
    for _ in range(AHEAD):
        leg = nominal.order.successor[leg]
        g = nominal.lags[leg]
        g0 = min(2.0 * max(nominal.margin, 0.0), g) if leg in HIND else 0.0
        stay = (posture.absolute(*foot) for other, foot in enumerate(feet) if other != leg)
        polygon = support_polygon(stay)
        supports.append(
            SupportPhase(
                (way + g0) / plan.speed,
                (way + g) / plan.speed,
                polygon,
                posture.absolute(*path.pose(way + g0)[:2]),
                posture.absolute(*path.pose(way + g)[:2]),
            )
        )
        way += g
        ahead = nominal.layouts[leg][leg]  # of C_u, when it has just landed
        feet[leg] = path.placed(*nominal.centres[leg], way + ahead)
    return tuple(supports)
