"""Level C (H §8): every 20 ms, from the monitors and the running step, the velocity each foot gets.

Body axes: x forward, y left, z up, origin at the centre of gravity; angles right-handed, pitch
about +y (nose down positive), roll about +x (left side up positive). Three departures from print:
the plan is evaluated at the tick where H sums v·Δt (a sum misses knots by up to V·Δt = 20 mm);
supporting legs are all given one rigid motion of the body, so they never pull against each other;
θ_p is pitch and θ_r roll, which the sentence under (37) swaps. Plain floats and flat code
throughout: this runs every tick.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..config import Gains
from ..geometry.transforms import (
    XY,
    Matrix,
    attitude_of,
    left_fold_sum,
    rotation,
    turned_back_by,
    turned_by,
)
from ..types import TICK, Point, Sensing
from .tracking import TrajectoryTracker, bent, curved

TURN_MIN = 1e-12  # rad; less than this to turn in one tick is no turn
LEVEL = 1e-12  # rad; a posture sensor that reads less reads level
# rad; a body further off level than this is levelled about its feet by its whole rotation: to first
# order it would drag them
TILTED = math.radians(2.0)
ZERO = (0.0, 0.0, 0.0)


class ReflexState(NamedTuple):
    """What Level C remembers from tick to tick of one step; a new step starts with
    ``next_step``.
    """

    landed: tuple[bool, ...]  # swing legs that have touched down early and carry since
    aims: tuple[Point, ...] = ()  # PID option: where each foot should be by now, body axes, m
    misses: tuple[Point, ...] = ()  # PID option: by how much it was missed one tick ago, m
    sums: tuple[Point, ...] = ()  # PID option: all misses so far, m

    @staticmethod
    def begin(legs: int) -> ReflexState:
        """Nothing has landed, nothing has been summed."""
        return ReflexState((False,) * legs)

    def next_step(self) -> ReflexState:
        """The same at a step-switching point: nothing has landed in the step that begins; the sums
        go on.
        """
        return self._replace(landed=(False,) * len(self.landed)) if True in self.landed else self


def reflex(
    playback: TrajectoryTracker,
    t_next: float,
    sensing: Sensing,
    state: ReflexState,
    gains: Gains,
    dt: float = TICK,
) -> tuple[list[Point], ReflexState]:
    """One tick of Level C: the body-frame foot velocities, m/s, that bring everything to where the
    plan has it at ``t_next``.
    """
    (bx, by, _, roll, pitch, yaw) = sensing.body
    if playback.leans or not (-TILTED <= roll <= TILTED and -TILTED <= pitch <= TILTED):
        return leaning_reflex(playback, t_next, sensing, state, gains, dt)
    feet_b = sensing.feet_b
    soles = sensing.soles
    start, body, rate, air, stand, down, feet, ground, bend, curves = playback.stretches[
        playback.stretch(t_next)
    ]
    s = t_next if t_next < playback.duration else playback.duration
    s = s - start if s > 0.0 else -start
    if bend is not None:
        rate = bent(rate, bend, s)
    vx, vy, vz, turn = rate
    x, y, z, heading = body
    x += vx * s
    y += vy * s
    z += vz * s
    heading += turn * s
    playback.here = t_next, (x, y, z, heading)

    landed: tuple[int, ...] = ()
    if air:
        if down:  # early touchdown: a foot whose sole switches on stops and joins the support
            for leg in air:
                if soles[leg] and not state.landed[leg]:
                    state = state._replace(
                        landed=tuple(on or leg == i for i, on in enumerate(state.landed))
                    )
        if True in state.landed:
            landed = tuple(leg for leg in air if state.landed[leg])
            air = tuple(leg for leg in air if not state.landed[leg])

    # (37): how far the carrying feet's mean height is from the plan's; landed feet have no planned
    # height to hold
    measured, carrying = 0.0, 0
    for leg in stand:
        if soles[leg]:
            measured += feet_b[leg][2]
            carrying += 1
    off = carrying < len(stand)
    if off:
        lift = _lift(feet, stand, soles, feet_b, z)
    else:
        lift = ground - z - measured / carrying if carrying else 0.0
    tilted = not (-LEVEL <= roll <= LEVEL and -LEVEL <= pitch <= LEVEL)
    if tilted and carrying:
        lift += _lean(stand, soles, feet_b, roll, pitch) / carrying

    # (34), (35): one rigid motion for all carrying legs, from the body's monitored place to its
    # planned one
    c = math.cos(yaw)
    d = math.sin(yaw)
    ax = x - bx
    ay = y - by
    px = c * ax + d * ay
    py = c * ay - d * ax
    turn = heading - yaw
    simple = gains.integral == 0.0 and gains.derivative == 0.0
    gain = gains.position / dt if simple else 1.0
    out: list[Point]
    if -TURN_MIN < turn < TURN_MIN:
        out = [(-px * gain, -py * gain, lift * gain)] * len(feet_b)
    else:
        out = [ZERO] * len(feet_b)
        e, f = math.cos(turn), math.sin(turn)
        for leg in stand + landed:
            mx, my, _ = feet_b[leg]
            ax, ay = mx - px, my - py
            out[leg] = ((e * ax + f * ay - mx) * gain, (e * ay - f * ax - my) * gain, lift * gain)
        c, d = math.cos(heading), math.sin(heading)

    # (33), table 3: swing legs follow the plan, seen from where the body will be
    for leg in air:
        fx, fy, fz, vx, vy, vz = feet[leg]
        if curves is not None and (curve := curves[leg]) is not None:
            vx, vy, vz = curved(vx, vy, vz, curve, s)
        mx, my, mz = feet_b[leg]
        ax = fx + vx * s - x
        ay = fy + vy * s - y
        fx = c * ax + d * ay
        fy = c * ay - d * ax
        fz = fz + vz * s - z
        if tilted:  # the body is not level; first order in its angles
            fx, fy, fz = fx - fz * pitch, fy + fz * roll, fz + fx * pitch - fy * roll
        out[leg] = ((fx - mx) * gain, (fy - my) * gain, (fz - mz) * gain)  # (38)

    if not simple:
        state = _pid(out, stand, landed, feet_b, state, gains, dt)
    if tilted or off:
        _adjust(out, stand + landed, soles, feet_b, roll, pitch, gains, dt)
    return out, state


def leaning_reflex(
    playback: TrajectoryTracker,
    t_next: float,
    sensing: Sensing,
    state: ReflexState,
    gains: Gains,
    dt: float,
) -> tuple[list[Point], ReflexState]:
    """The same for a plan that leans, with the body's whole rotation: to first order feet would
    miss by millimetres.

    C1 levels towards the lean of the plan: what the posture is off by goes down by that share a
    tick, the plan's own turning is followed.
    """
    (bx, by, _, roll, pitch, yaw), feet_b, soles = sensing.body, sensing.feet_b, sensing.soles
    start, body, rate, air, stand, down, feet, ground, bend, curves = playback.stretches[
        playback.stretch(t_next)
    ]
    s = (0.0 if t_next < 0.0 else min(t_next, playback.duration)) - start
    if bend is not None:
        rate = bent(rate, bend, s)
    x, y, z = body[0] + rate[0] * s, body[1] + rate[1] * s, body[2] + rate[2] * s
    heading = body[3] + rate[3] * s
    if air and down:
        state = state._replace(
            landed=tuple(on or (leg in air and soles[leg]) for leg, on in enumerate(state.landed))
        )
    landed = tuple(leg for leg in air if state.landed[leg])
    swinging = tuple(leg for leg in air if not state.landed[leg])

    now = rotation(roll, pitch, yaw)
    reached = [turned_by(now, foot) for foot in feet_b]
    on = [leg for leg in stand if soles[leg]]
    # of the body, from where its feet stand (37)
    height = left_fold_sum(feet[leg][2] - reached[leg][2] for leg in on) / len(on) if on else z
    then = _attitude_asked(playback, t_next, heading, (roll, pitch), gains)

    simple = gains.integral == 0.0 and gains.derivative == 0.0
    gain = gains.position / dt if simple else 1.0
    out: list[Point] = [ZERO] * len(feet_b)
    for leg in stand + landed:  # one rigid motion of the body for all that carry
        px, py, pz = reached[leg]
        there = turned_back_by(then, (px + bx - x, py + by - y, pz + height - z))
        out[leg] = _towards(there, feet_b[leg], gain)
    for leg in swinging:
        fx, fy, fz, vx, vy, vz = feet[leg]
        if curves is not None and (curve := curves[leg]) is not None:
            vx, vy, vz = curved(vx, vy, vz, curve, s)
        there = turned_back_by(then, (fx + vx * s - x, fy + vy * s - y, fz + vz * s - z))
        out[leg] = _towards(there, feet_b[leg], gain)
    if not simple:
        state = _pid(out, stand, landed, feet_b, state, gains, dt)
    for leg in stand + landed:
        if not soles[leg]:
            vx, vy, vz = out[leg]
            out[leg] = (vx, vy, vz - gains.pliancy / dt)  # C2 Δz
    return out, state


def _attitude_asked(
    playback: TrajectoryTracker, t_next: float, heading: float, tilt: XY, gains: Gains
) -> Matrix:
    """The rotation of the body to bring about by ``t_next``: that of the plan's lean, and what is
    left of what roll and pitch are off by.
    """
    wanted = attitude_of(playback.lean_at(t_next), heading)
    asked = playback.asked
    playback.asked = wanted
    keep = 1.0 - gains.posture
    roll = wanted[0] + keep * (tilt[0] - asked[0])
    pitch = wanted[1] + keep * (tilt[1] - asked[1])
    return rotation(roll, pitch, heading)


def _towards(there: Point, here: Point, gain: float) -> Point:
    return (there[0] - here[0]) * gain, (there[1] - here[1]) * gain, (there[2] - here[2]) * gain


def _lift(
    feet: tuple[tuple[float, ...], ...],
    stand: tuple[int, ...],
    soles: tuple[bool, ...],
    feet_b: tuple[Point, ...],
    z: float,
) -> float:
    """(37) over the legs that do carry, when some sole is off: a leg in the air says nothing about
    the height.
    """
    on = [leg for leg in stand if soles[leg]]
    return sum(feet[leg][2] - z - feet_b[leg][2] for leg in on) / len(on) if on else 0.0


def _lean(
    stand: tuple[int, ...],
    soles: tuple[bool, ...],
    feet_b: tuple[Point, ...],
    roll: float,
    pitch: float,
) -> float:
    """What tilting adds to the carrying feet's heights in body axes, summed; first order in the
    angles.
    """
    return sum(feet_b[leg][0] * pitch - feet_b[leg][1] * roll for leg in stand if soles[leg])


def _adjust(
    out: list[Point],
    stand: tuple[int, ...],
    soles: tuple[bool, ...],
    feet_b: tuple[Point, ...],
    roll: float,
    pitch: float,
    gains: Gains,
    dt: float,
) -> None:
    """Second and third term of (36): level the torso, and reach for the ground with a carrying leg
    whose sole is off.
    """
    for leg in stand:
        x, y, _ = feet_b[leg]
        vx, vy, vz = out[leg]
        vz += gains.posture * (y * roll - x * pitch) / dt  # C1 (-x θ_p + y θ_r)
        if not soles[leg]:
            vz -= gains.pliancy / dt  # C2 Δz
        out[leg] = (vx, vy, vz)


def _pid(
    out: list[Point],
    stand: tuple[int, ...],
    landed: tuple[int, ...],
    feet_b: tuple[Point, ...],
    state: ReflexState,
    gains: Gains,
    dt: float,
) -> ReflexState:
    """Turn position errors into velocities by PID, in place.

    The integral is of what was missed of the tick before, not of the error, which holds the motion
    still to come; it is held to ``windup``, and carrying legs share one, so that they do not pull
    against each other.
    """
    aims = tuple(
        (x + dx, y + dy, z + dz) for (x, y, z), (dx, dy, dz) in zip(feet_b, out, strict=True)
    )
    before = state.aims or feet_b
    misses = [
        (ax - x, ay - y, az - z) for (ax, ay, az), (x, y, z) in zip(before, feet_b, strict=True)
    ]
    _share(misses, stand, landed)
    old = state.misses or (ZERO,) * len(out)
    bound = gains.windup / gains.integral if gains.integral else 0.0
    before_sums = state.sums or (ZERO,) * len(out)
    sums = [_summed(total, miss, bound) for total, miss in zip(before_sums, misses, strict=True)]
    _share(sums, stand, landed)
    for leg, error in enumerate(out):
        x, y, z = (
            (gains.position * e + gains.integral * total + gains.derivative * (miss - last)) / dt
            for e, total, miss, last in zip(error, sums[leg], misses[leg], old[leg], strict=True)
        )
        out[leg] = (x, y, z)
    return state._replace(aims=aims, misses=tuple(misses), sums=tuple(sums))


def _summed(total: Point, miss: Point, bound: float) -> Point:
    """The sum of misses so far, held to ``bound`` on every axis."""
    x, y, z = (
        max(-bound, min(bound, value + more)) for value, more in zip(total, miss, strict=True)
    )
    return x, y, z


def _share(points: list[Point], stand: tuple[int, ...], landed: tuple[int, ...]) -> None:
    """Give all carrying legs the mean of those that stand, in place."""
    if stand:
        shared = _mean(points, stand)
        for leg in stand + landed:
            points[leg] = shared


def _mean(points: list[Point], legs: tuple[int, ...]) -> Point:
    n = len(legs)
    return (
        left_fold_sum(points[i][0] for i in legs) / n,
        left_fold_sum(points[i][1] for i in legs) / n,
        left_fold_sum(points[i][2] for i in legs) / n,
    )
