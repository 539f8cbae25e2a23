"""A trembling hand at α_c: the course is held while what is commanded scatters about it.

At α_c the centre of gravity passes all but over a foot, so a degree more or less puts it on the
other side, and the layout of the feet, made for the one course, fits the next one badly. Away from
α_c the same tremor costs next to nothing, and every command is walked as it comes.
"""

from __future__ import annotations

import math
from dataclasses import replace

from ..robot.model import Machine
from ..types import Command, HeldCourse, Stance
from .quarter_turns import beside_critical

# rad from α_c within which a course is held; less: see the order of legs change as the stick
# trembles beside the diagonal, more: see it follow small corrections late elsewhere
NEAR = math.radians(8.0)
# rad; a command this far from the course held is meant, and walked at once
MEANT = math.radians(6.0)
FOLLOWS = 0.15  # of a command, a step, that its mean follows; more: see a tremor of 1° move it
CALMS = 0.05  # of a deviation, a step, that the mean tremor follows
TREMOR = math.radians(0.8)  # mean deviation of a hand not known yet: normal, of 1°
# mean deviations that the mean may be off the course held; fewer: see the course change as the
# stick trembles, more: see it walk a little beside what is commanded for long
APART = 3.5


def steadied(command: Command, stance: Stance, machine: Machine) -> tuple[Command, HeldCourse]:
    """The command on a straight course that a step is planned for, and what is held from it on.

    Within ``NEAR`` of α_c the course of the step before stays as long as the mean of what is
    commanded stays within ``APART`` of the hand's own tremor: a hand that trembles by 1° walks as a
    steady one, and a steady hand gets the very course it asks for after a few steps.
    """
    angle = command.crab_angle
    held = stance.held_course
    if held is None:
        return command, HeldCourse(angle, angle, TREMOR)
    if beside_critical(machine, angle) > NEAR or abs(_from(held.angle, angle)) > MEANT:
        return command, HeldCourse(angle, angle, held.tremor)
    deviation = _from(held.mean, angle)
    mean = math.remainder(held.mean + FOLLOWS * deviation, 2 * math.pi)
    tremor = held.tremor + CALMS * (abs(deviation) - held.tremor)
    stays = abs(_from(held.angle, mean)) <= APART * tremor
    course = held.angle if stays else mean
    return replace(command, crab_angle=course), HeldCourse(course, mean, tremor)


def holding(stance: Stance, held: HeldCourse | None) -> Stance:
    """The stance with what it remembers of the hand, and what the end of a step from it will."""
    return stance if stance.held_course == held else replace(stance, held_course=held)


def _from(one: float, other: float) -> float:
    """The turn from one angle to another, within ±π."""
    return math.remainder(other - one, 2 * math.pi)
