"""How far the body goes on one foothold: the lengths that gaits, maps of passable ground and slopes
work out from a leg's reach rectangle.

All lengths are metres, all angles radians in body axes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..geometry.paths import ArcPath, Box, arc_exit
from ..geometry.transforms import XY, direction
from ..robot.model import Machine

# m of reach kept beyond the strokes for vertical lifting while the body moves; less and v_max
# collapses
LIFT_ROOM = 0.02
# m; the same where legs stretch to the mechanical limit: the body goes 0.016 m/s as a foot comes
# down
STRETCHED_LIFT_ROOM = 0.005
STROKE_MAX = 1.0  # m of s on an arc; on a circle about itself a foot would never leave its reach

Boxes = tuple[Box, ...]


class Strokes(NamedTuple):
    """The stretch of the path every leg can stay on the ground for, lengths in m of s."""

    centres: tuple[XY, ...]  # C_i
    ends: tuple[float, ...]  # from C_i to the end of the stroke
    spares: tuple[float, ...]  # from there to the end of the reach
    stride: float  # λ*
    size: float = 1.0  # of the machine, as in ``Machine``


def stroke_length(x_span: float, y_span: float, crab_angle: float) -> float:
    """λ*, the longest stroke through the middle of a reach rectangle (H §4.3 (1))."""
    c, s = map(abs, direction(crab_angle))
    along_x = x_span / c if c > 1e-12 else math.inf
    along_y = y_span / s if s > 1e-12 else math.inf
    return min(along_x, along_y)


def kept(machine: Machine, stretched: bool) -> XY:
    """By how much footholds are planned inside the control reach along x and y, m; negative:
    outside it.
    """
    over_x, over_y, _ = machine.overreach
    if stretched:
        room = machine.size * STRETCHED_LIFT_ROOM
        return room - over_x, room - over_y
    room = machine.size * LIFT_ROOM
    return max(0.0, room - over_x), max(0.0, room - over_y)


def planning_boxes(machine: Machine, quarter_turns: int, stretched: bool) -> Boxes:
    """Where footholds are planned, one rectangle for each quadrant of the body frame turned by so
    many quarter turns; odd numbers swap (x0, x*) with (y0, y*) (H table 1). Of legs that are not
    mirrored it is the part they have in common.
    """
    kept_x, kept_y = kept(machine, stretched)
    return _widened(machine, quarter_turns, -kept_x, -kept_y)


def mechanical_boxes(machine: Machine, quarter_turns: int) -> Boxes:
    """As ``planning_boxes``, where a foot can be at all."""
    over_x, over_y, _ = machine.overreach
    return _widened(machine, quarter_turns, over_x, over_y)


def _widened(machine: Machine, quarter_turns: int, more_x: float, more_y: float) -> Boxes:
    x1, x2, y1, y2 = machine.mirrored_box
    spans = [(x1 - more_x, x2 + more_x), (y1 - more_y, y2 + more_y)]
    if quarter_turns % 2:
        spans.reverse()
    (x1, x2), (y1, y2) = spans
    return (x1, x2, y1, y2), (-x2, -x1, y1, y2), (-x2, -x1, -y2, -y1), (x1, x2, -y2, -y1)


def strokes_on(boxes: Boxes, path: ArcPath) -> Strokes:
    """C_i and, on circles about the turning centre, the stroke the legs share: that of the leg
    which has least. On a line it is H's (``stroke_length``).
    """
    back = path.reversed()
    centres = centres_of(boxes)
    ahead = [arc_exit(x, y, box, path) for (x, y), box in zip(centres, boxes, strict=True)]
    behind = [arc_exit(x, y, box, back) for (x, y), box in zip(centres, boxes, strict=True)]
    stride = min(STROKE_MAX, *(a + b for a, b in zip(ahead, behind, strict=True)))
    ends = tuple(
        ((a - b if a < math.inf else 0.0) + stride) / 2 for a, b in zip(ahead, behind, strict=True)
    )
    spares = tuple(
        leave - end if leave < math.inf else 0.0 for leave, end in zip(ahead, ends, strict=True)
    )
    return Strokes(centres, ends, spares, stride)


def centres_of(boxes: Boxes) -> tuple[XY, ...]:
    """C_i, the middle of every rectangle (H §2.1)."""
    return tuple(((x1 + x2) / 2, (y1 + y2) / 2) for x1, x2, y1, y2 in boxes)
