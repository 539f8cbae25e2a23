"""Which legs are better not lifted: where the standing legs' reach lets the body sway no farther.

A step is decided with the body on its reference, and so are its margins. Where the true centre of
gravity is then, torso and legs, is known once the body's way is worked out: it bends by as much as
every standing leg reaches, and that may be too little. Metres, absolute frame.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from ..protocols import PlanningJob
from ..types import Gait, Stance, StepPlan
from .body_bounds import RESERVE


def on_surer_legs(
    swayed: Callable[[Stance], PlanningJob], stance: Stance, gait: Gait
) -> PlanningJob:
    """The step of ``swayed`` from a stance; where its legs would lift with the centre of gravity
    less than ``RESERVE`` inside of the others, a step of other legs or a shift of the body, if one
    keeps more. Every leg is tried once at most; ``Blocked`` only where the first answer is.
    """
    best = answer = yield from swayed(stance)
    least = min(RESERVE, gait.margin)
    most = -math.inf
    while isinstance(answer, StepPlan) and answer.swing and answer.polygon_margin_min < least:
        most = max(most, answer.polygon_margin_min)
        stance = replace(stance, kept_down=(*stance.kept_down, *answer.swing))
        answer = yield from swayed(stance)
        if isinstance(answer, StepPlan) and answer.polygon_margin_min > most:
            best = replace(answer, end=replace(answer.end, kept_down=()))
    return best
