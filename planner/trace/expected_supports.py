"""The supports that follow a step in the prediction: for the body's sway."""

from __future__ import annotations

import math

from ..motion.body_path import SupportPhase
from ..stability import support_polygon
from ..types import Stance, StepPlan
from .moves import Move
from .prediction import Prediction, index_of

AHEAD = 3  # moves that are looked at; fewer: see the body come late to its next support
SWING_MIN = 0.3  # s a swing takes at least, about


def expected_supports(
    prediction: Prediction | None, stance: Stance, plan: StepPlan
) -> tuple[SupportPhase, ...]:
    """The supports of the moves that follow the one that begins in ``stance``; times from the end
    of its plan, s, at the pace of the plan.
    """
    n = None if prediction is None else index_of(prediction, stance)
    if prediction is None or n is None or plan.speed <= 0.0:
        return ()
    time = 0.0
    supports = []
    for move in prediction.moves[n + 1 : n + 1 + AHEAD]:
        lift = time + _length(move.shift) / plan.speed
        land = lift + max(_length(move.carry) / plan.speed, SWING_MIN)
        begin, end = move.carry[0], move.carry[-1]
        supports.append(SupportPhase(lift, land, _polygon(move), begin[:2], end[:2]))
        time = land
    return tuple(supports)


def _polygon(move: Move) -> tuple[tuple[float, float], ...]:
    """Of the feet that carry while the legs of a move are in the air."""
    feet = [
        foot for leg, foot in enumerate(move.before) if foot is not None and leg not in move.legs
    ]
    return support_polygon(feet)


def _length(way: tuple[tuple[float, ...], ...]) -> float:
    return math.fsum(math.dist(a[:2], b[:2]) for a, b in zip(way, way[1:], strict=False))
