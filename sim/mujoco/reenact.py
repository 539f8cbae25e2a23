"""A recorded walk played again by rigid bodies, open loop: do its footholds and its motion stand?

The servos follow the feet as the run has them in body axes, tick by tick, whatever the bodies do
meanwhile; with planned loads they also press with what each leg should carry, by statics and by how
the body speeds up. Nothing looks at a sensor, so that what falls here is the plan's fault or the
legs', never a controller's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.geometry.transforms import (
    Matrix,
    Point,
    left_fold_sum,
    rotation,
    turned_back_by,
)
from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import GRAVITY
from walking_console.planner.statics import planned_loads, pushed_at
from walking_console.planner.types import TICK, Stance

from ..load_history import accelerations, shares_over
from ..margins import true_centre
from ..terrain.ground import Ground
from .plant import PhysicsPlant
from .settings import Physics

SETTLING = 50  # ticks it stands before it is set going
TRUE_HANG = 0.005  # m a foot that is meant to carry may be off the ground in a true walk
TRUE_END = 0.01  # of the way, how far off the end of a true walk may be
HANGING = 0.001  # of the weight; a foot that carries less hangs


@dataclass(frozen=True)
class Recording:
    """What a run directory holds of a walk: (T, 6) body, (T, n, 3) feet, (T, n) legs that carry."""

    machine: Machine
    ground: Ground
    body: NDArray[np.float64]
    feet: NDArray[np.float64]
    support: NDArray[np.bool_]

    def attitude(self, tick: int) -> Matrix:
        """Body axes to absolute axes."""
        roll, pitch, yaw = self.body[tick, 3:].tolist()
        return rotation(roll, pitch, yaw)

    def feet_b(self, tick: int) -> list[Point]:
        """Foot tips in body axes, m."""
        turn = self.attitude(tick)
        x, y, z = self.body[tick, :3].tolist()
        return [
            turned_back_by(turn, (fx - x, fy - y, fz - z))
            for fx, fy, fz in self.feet[tick].tolist()
        ]

    @property
    def stance(self) -> Stance:
        """Where it begins."""
        x, y, z, _, _, yaw = self.body[0].tolist()
        feet = tuple((a, b, c) for a, b, c in self.feet[0].tolist())
        lifted = tuple(np.nonzero(~self.support[0])[0].tolist())
        return Stance((x, y, z, yaw), feet, lifted=lifted)


@dataclass
class Verdict:
    """What became of it. Angles in degrees against the recorded posture, lengths in m."""

    seconds: float = 0.0  # played
    fell: float | None = None  # s, when; None: it stood
    tilt: float = 0.0  # deg, the most
    hang: float = 0.0  # m, the most a foot meant to carry was off the ground
    end_error: float = 0.0  # share of the way
    slip: float = 0.0  # m, the furthest a foot went in one stance
    peak_load: float = 0.0  # of the weight, of one foot, mean of a tick

    @property
    def true(self) -> bool:
        """It neither fell, nor let a foot hang, nor went elsewhere."""
        return self.fell is None and self.hang <= TRUE_HANG and self.end_error <= TRUE_END


class Reenactment:
    """One walk played again: ``play`` it, then read the ``verdict``."""

    def __init__(self, recording: Recording, physics: Physics, *, press: bool) -> None:
        self.recording = recording
        self.plant = PhysicsPlant(
            recording.machine, recording.ground, recording.stance, physics=physics
        )
        self.verdict = Verdict()
        self._press = press
        self._shares = shares_over(recording.support)
        self._changes = accelerations(recording.body)
        self._landed: list[Point | None] = [None] * len(recording.machine.legs)

    def play(self, ticks: int | None = None) -> Verdict:
        """The walk, or so many ticks of it, until it falls."""
        last = len(self.recording.body) if ticks is None else min(ticks, len(self.recording.body))
        for _ in range(SETTLING):
            self._act(0)
        for tick in range(last):
            self._act(tick)
            self.verdict.seconds = (tick + 1) * TICK
            if self.plant.state == "fallen":
                self.verdict.fell = tick * TICK
                break
            self._judge(tick)
        self._judge_end(min(last, round(self.verdict.seconds / TICK)) - 1)
        return self.verdict

    def planned_loads(self, tick: int) -> tuple[float, ...]:
        """What every foot should carry at a tick of the walk, N."""
        recording = self.recording
        shares = self._shares[tick].tolist()
        feet = recording.feet[tick].tolist()
        ax, ay = self._changes[tick].tolist()
        centre = true_centre(recording.machine, recording.body[tick].tolist(), feet)
        place = pushed_at(centre, (ax, ay), feet, shares)
        return planned_loads(recording.machine.mass * GRAVITY, place, feet, shares).newtons

    def _act(self, tick: int) -> None:
        loads = None
        if self._press:
            loads = self.planned_loads(tick)
        self.plant.follow(self.recording.feet_b(tick), loads)

    def _judge(self, tick: int) -> None:
        verdict = self.verdict
        plant = self.plant
        weight = self.recording.machine.mass * GRAVITY
        verdict.tilt = max(verdict.tilt, self._tilt(tick))
        for leg, foot in enumerate(plant.feet):
            verdict.peak_load = max(verdict.peak_load, plant.loads[leg] / weight)
            if not self.recording.support[tick, leg]:
                self._landed[leg] = None
                continue
            if plant.loads[leg] < HANGING * weight:
                gap = foot[2] - self.recording.ground.height_at(foot[0], foot[1])
                verdict.hang = max(verdict.hang, gap)
            elif self._shares[tick, leg] == 1.0:
                landed = self._landed[leg] or (foot[0], foot[1], foot[2])
                self._landed[leg] = landed
                verdict.slip = max(
                    verdict.slip, math.hypot(foot[0] - landed[0], foot[1] - landed[1])
                )

    def _tilt(self, tick: int) -> float:
        """Degrees between the upward axes of the body recorded and the body played."""
        wanted = self.recording.attitude(tick)
        roll, pitch, yaw = self.plant.body[3:]
        got = rotation(roll, pitch, yaw)
        cosine = left_fold_sum(wanted[k][2] * got[k][2] for k in range(3))
        return math.degrees(math.acos(max(-1.0, min(1.0, cosine))))

    def _judge_end(self, tick: int) -> None:
        body = self.recording.body
        way = float(np.hypot(*np.diff(body[: tick + 1, :2], axis=0).T).sum())
        off = math.dist(self.plant.body[:2], body[tick, :2].tolist())
        self.verdict.end_error = off / way if way > 0.1 else 0.0
