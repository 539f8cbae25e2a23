"""The words of Level B2: how far the body goes while a leg swings, and where the foot comes down.

Gait frame, origin at the CoG at N_k (H's E_k); metres.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..config import DEFAULT, PlannerConfig
from ..geometry.transforms import XY
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Command, Gait, Stance


class StepRequest(NamedTuple):
    """What a step is planned from: the walker at N_k, what is commanded, and the ground."""

    stance: Stance
    command: Command
    terrain: TerrainMap
    machine: Machine
    gait: Gait
    explain: bool = False
    config: PlannerConfig = DEFAULT

    def log(self, **facts: Any) -> dict[str, Any] | None:
        """A decision log begun with these facts; None when nobody asks for one."""
        return facts if self.explain else None


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
    """One step of Level B2, in E_k: who swings, how far, and where the foot goes."""

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
