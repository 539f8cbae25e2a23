"""What H §5.3 warns of: the standard sequence, each leg swung to its maximum stride, no search
domain (H fig. 6(c)).

Kept to show why domain methods I-III exist: from an odd posture it comes to a standstill on level
ground at its fourth step.
"""

from __future__ import annotations

from ..geometry.paths import line_exit
from ..motion.leg_order import SUCCESSOR
from ..terrain.cells import foothold_map
from ..types import Blocked, Reason, StepPlan
from .foothold_checks import FootholdChecks
from .gait import Posture, nominal_gait, posture_of
from .leg_selection import planned_margin, shift_of
from .step_plans import build
from .step_refusals import StepRefusal
from .steps import Landing, Shift, StepRequest, SwingStep

FIRST = 0  # H's leg 1 begins


def plan_step(request: StepRequest) -> StepPlan | Blocked:
    """The next leg of the standard sequence, swung as far as it reaches, or why it cannot."""
    stance, command = request.stance, request.command
    nominal = nominal_gait(request.machine, request.gait, command.crab_angle, stance.quarter_turns)
    posture = posture_of(nominal, stance)
    log = request.log(crab_angle=command.crab_angle, quarter_turns=nominal.quarter_turns)
    leg = SUCCESSOR[posture.last] if posture.last >= 0 else FIRST
    shift = shift_of(posture, leg)
    if isinstance(shift, StepRefusal):
        return Blocked(Reason.NO_SHIFT, nominal.body_leg[leg], log, {"shift": shift.value})
    step = longest_step(posture, shift)
    if not foothold_map(request.terrain).allows(step.landing.ax, step.landing.ay):
        return Blocked(Reason.PROHIBITED_CELL, nominal.body_leg[leg], log)
    checks = FootholdChecks(posture, request)
    return build(checks, step, checks.height_after(step, step.landing), command.speed, log)


def longest_step(posture: Posture, shift: Shift) -> SwingStep:
    """The foot straight on along the course, to the far side of its reach after the body's g."""
    ux, uy, _ = posture.nominal.path
    box = posture.nominal.boxes[shift.leg]
    fx, fy = posture.feet[shift.leg]
    g = shift.g
    # as the body will see the foot at N_{k+1}
    inside_x = min(max(fx - g * ux, box[0]), box[1])
    inside_y = min(max(fy - g * uy, box[2]), box[3])
    # the body's exit backwards is the foot's way forward
    way = line_exit(inside_x, inside_y, box, -ux, -uy)
    x = inside_x + (g + way) * ux
    y = inside_y + (g + way) * uy
    landing = Landing(x, y, *posture.absolute(x, y))
    margin = planned_margin(posture, shift)
    return SwingStep(shift.leg, shift.g0, g, (x, y), landing, margin, False)
