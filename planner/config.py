"""The tunables of the planner by theme; each says what you see when it is wrong."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Tolerances:
    """How exactly a plant does what it is told; the defaults are of one that errs by rounding only.

    The supervisor takes what is within them for what was planned.
    """

    # m, rad; a stance this close to the plan's end is taken to be it. Smaller than the plant errs:
    # see every step planned twice; larger: see feet drift from their plan unnoticed
    same_place: float = 1e-6
    # m the body may be from where the plan has it. Smaller: servo noise stops the walk; larger: see
    # it lean on an obstacle before it stops
    held_back: float = 0.01
    # m a foot set down may be from J_u and still have finished its step. Smaller: see the same leg
    # swing twice
    landed_as_planned: float = 0.02
    # m the body may be off in the plans of a posture. Larger: see a push eat up the margin of the
    # next swing
    body_off: float = 0.002
    # m a foot may seem to be off in the plans of a posture. Smaller: see sensor noise begin the
    # posture anew
    foot_off: float = 0.015
