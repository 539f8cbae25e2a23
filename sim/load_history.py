"""What feet carried over a whole walk, by statics, from the rows of its log."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import GRAVITY
from walking_console.planner.statics import RAMP, load_share, planned_loads, pushed_at
from walking_console.planner.types import TICK

from .margin_history import true_centres

_Floats = NDArray[np.float64]

AROUND = 3  # ticks before and after one that its acceleration is taken from
JUMPS = 1.5  # m/s²; what speeds up more is a jump of a body that goes straight: no leg follows it


def shares_over(support: NDArray[np.bool_], ramp: float = RAMP) -> NDArray[np.float64]:
    """How much each leg counts as carrying, (T, n) in 0 to 1, ramped up after every touch-down and
    down before every lift-off.
    """
    ticks, legs = support.shape
    shares = np.zeros((ticks, legs))
    for leg in range(legs):
        changes = (np.nonzero(support[1:, leg] != support[:-1, leg])[0] + 1).tolist()
        for begin, end in pairwise([0, *changes, ticks]):
            if support[begin, leg]:
                shares[begin:end, leg] = _stance_shares(begin, end, ticks, ramp)
    return shares


def _stance_shares(begin: int, end: int, ticks: int, ramp: float) -> list[float]:
    return [
        load_share(
            math.inf if begin == 0 else (tick - begin + 0.5) * TICK,
            math.inf if end == ticks else (end - tick - 0.5) * TICK,
            ramp,
        )
        for tick in range(begin, end)
    ]


def accelerations(body: _Floats) -> _Floats:
    """How the velocity of a body, rows (T, 6) a tick apart, changes over the ground, (T, 2) m/s²;
    none where it jumps.
    """
    changes = np.zeros((len(body), 2))
    if len(body) <= 2 * AROUND:
        return changes
    place = body[:, :2]
    bent = place[2 * AROUND :] - 2.0 * place[AROUND:-AROUND] + place[: -2 * AROUND]
    changes[AROUND:-AROUND] = bent / (AROUND * TICK) ** 2
    at_once = np.diff(place, n=2, axis=0) / TICK**2
    jumps = np.nonzero(np.hypot(at_once[:, 0], at_once[:, 1]) > JUMPS)[0] + 1
    for tick in jumps.tolist():
        changes[max(tick - AROUND, 0) : tick + AROUND + 1] = 0.0
    return changes


def loads_over(
    machine: Machine,
    body: _Floats,
    feet: _Floats,
    shares: _Floats,
    changes: _Floats | None = None,
) -> _Floats:
    """What every foot carries, (T, n) N, for rows of body (T, 6), feet (T, n, 3), how much each
    counts as carrying and how the body speeds up (T, 2): ``planned_loads`` row by row, all at once
    where no foot is let go of.
    """
    if changes is None:
        changes = np.zeros((len(body), 2))
    true = true_centres(machine, body, feet).tolist()
    rows = zip(true, changes.tolist(), feet.tolist(), shares.tolist(), strict=True)
    centres = np.array([pushed_at(*row) for row in rows]).reshape(-1, 2)
    weight = machine.mass * GRAVITY
    arms = np.concatenate(
        [np.ones((*shares.shape, 1)), feet[:, :, :2] - centres[:, None, :]], axis=2
    )
    moments = np.einsum("tn,tni,tnj->tij", shares, arms, arms)
    solid = np.abs(np.linalg.det(moments)) > 1e-9
    plane = np.zeros((len(body), 3))
    right = np.broadcast_to([[weight], [0.0], [0.0]], (int(solid.sum()), 3, 1))
    plane[solid] = np.linalg.solve(moments[solid], right)[:, :, 0]
    heights = np.einsum("tni,ti->tn", arms, plane)
    loads: _Floats = shares * heights
    least = np.where(shares > 0.0, heights, np.inf).min(axis=1)
    for row in np.nonzero((least < 0.0) | ~solid)[0].tolist():
        x, y = centres[row].tolist()
        loads[row] = planned_loads(weight, (x, y), feet[row].tolist(), shares[row].tolist()).newtons
    return loads
