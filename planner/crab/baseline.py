"""What H §5.3 warns of: the standard sequence, each leg swung to its maximum stride, no search
domain (H fig. 6(c)).

Kept to show why domain methods I-III exist: from an odd posture it comes to a standstill on level
ground at its fourth step.
"""

from __future__ import annotations

from ..geometry.paths import line_exit
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Blocked, Command, Gait, Stance, StepPlan
from .foothold_search import Landing, ground_of
from .gait import SUCCESSOR, Posture, Standard, posture_of, standard_for
from .leg_selection import Shift, Step, exits_of, planned_margin, shift_of
from .planner import Ahead, build

FIRST = 0  # H's leg 1 begins


def plan_step(
    stance: Stance,
    command: Command,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    *,
    explain: bool = False,
) -> StepPlan | Blocked:
    """The next leg of the standard sequence, swung as far as it reaches, or why it cannot."""
    standard = standard_for(machine, gait, command.crab_angle, stance.quarter_turns)
    posture = posture_of(standard, stance)
    notes = (
        {"crab_angle": command.crab_angle, "quarter_turns": standard.quarter_turns}
        if explain
        else None
    )
    leg = SUCCESSOR[posture.last] if posture.last >= 0 else FIRST
    shift = shift_of(standard, posture, exits_of(standard, posture), leg)
    if isinstance(shift, str):
        return Blocked(shift, standard.body_leg[leg], notes)
    step = longest_step(standard, posture, shift)
    if not ground_of(terrain).allows(step.landing.ax, step.landing.ay):
        return Blocked(
            "the foot would come down on a prohibited cell", standard.body_leg[leg], notes
        )
    ahead = Ahead(standard, posture, stance, terrain, machine, gait)
    low, high = ahead.height_limits(leg, step.g0, step.g, step.landing)
    height = ahead.height_after(leg, step.g, step.landing, low, high)
    return build(standard, posture, stance, step, height, ahead, command, machine, gait, notes)


def longest_step(standard: Standard, posture: Posture, shift: Shift) -> Step:
    """The foot straight on along the course, to the far side of its reach when the body has gone g."""
    (fx, fy), box, g = posture.feet[shift.leg], standard.boxes[shift.leg], shift.g
    sx, sy = fx - g * standard.ux, fy - g * standard.uy  # as the body will see the foot at N_{k+1}
    inside = min(max(sx, box[0]), box[1]), min(max(sy, box[2]), box[3])
    # the body's exit backwards is the foot's way forward
    way = line_exit(*inside, box, -standard.ux, -standard.uy)
    x, y = inside[0] + (g + way) * standard.ux, inside[1] + (g + way) * standard.uy
    return Step(
        shift.leg,
        shift.g0,
        g,
        (x, y),
        Landing(x, y, *posture.absolute(x, y)),
        planned_margin(standard, posture, shift),
        False,
    )
