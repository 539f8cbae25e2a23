"""The words of Level B2: how far the body goes while a leg swings, and where the foot comes down.

Gait frame, origin at the CoG at N_k (H's E_k); metres.
"""

from __future__ import annotations

from typing import NamedTuple

from ..geometry.transforms import XY

Exits = tuple[float, ...]  # g_i of every leg, m


class Landing(NamedTuple):
    """A foothold: in the canonical frame E_k and in the absolute one."""

    x: float
    y: float
    ax: float
    ay: float


class Shift(NamedTuple):
    """How far the body goes while one leg swings: g0 on four legs, g in all; the CoG is over the
    triangle on [low, high], ``inset`` from its edges.
    """

    leg: int
    g0: float
    g: float
    low: float
    high: float
    inset: float = 0.0


class SwingStep(NamedTuple):
    """One step of Level B2 and nothing else: who swings, how far, and where the foot goes. Gait
    frame, E_k.
    """

    leg: int
    g0: float
    g: float
    start: XY  # I_u
    landing: Landing  # J_u
    margin: float  # least longitudinal margin against the feet that carry; on an arc the inset kept
    convergent: bool  # J_u satisfies domain method II (always so for a front leg)


class BodyShift(NamedTuple):
    """A four-leg shift: no leg swings, the body goes (x, y) in the gait frame."""

    x: float
    y: float
    margin: float  # least longitudinal margin along its own way


Candidate = SwingStep | BodyShift
