"""Level B4 (H §7): how fast the body may go while the leg returns, and the knots of the swing: up,
return, down.

All velocities are of the foot against the body, which is what the servos drive. ``n`` is the course
per metre walked on the ground plane (x, y in body axes, z the climb), ``D`` the foot's displacement
on the ground.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from ..robot.model import Machine
from ..types import TICK, Gait, Phase, Point
from .swing import Profile, SwingCorners, peak, profile_of, swing_speeds

BACK_MIN = TICK  # s, one tick of Level C: no return phase is shorter
WAIT_SHARE = 0.2  # of V_z at which a waiting body changes height
# of V_z left to the body's own climb; more leaves too little to lift the foot against it
CLIMB_SHARE = 0.5

Knot = tuple[float, Point, Point]  # s from N_k; body x, y, z; swing foot x, y, z


class Timing(NamedTuple):
    """The clock of one step: speeds in m/s along the course on the ground plane, durations in s."""

    speed: float  # v_G while the leg swings (0 when the body waits)
    speed_max: float  # the same without the command
    support_speed: float  # v_G while all four stand
    support: float  # t_spt
    up: float  # t_up
    back: float  # t_rtn
    down: float  # t_dwn


def axis_limit(displacement: float, n: float, limit: float, g: float, vertical: float) -> float:
    """The largest v with D/t_rtn - v·n <= V on one axis and everywhere below it, t_rtn = g/v - τ:
    (24) with its root repaired.

    From D·v - (n·v + V)(g - v·τ) <= 0. With V = V_x, n = 1: A = τ/V, B = τ + (D - g)/V, C = -g/V,
    all times V.
    """
    # a·v² + b·v - c <= 0
    a, b, c = n * vertical, displacement - n * g + limit * vertical, limit * g
    inside = b * b + 4.0 * a * c
    if inside < 0.0:
        return math.inf
    below = b + math.sqrt(inside)
    return 2.0 * c / below if below > 1e-15 else math.inf


def speed_limit(displacement: Point, n: Point, limits: Point, g: float, vertical: float) -> float:
    """v_max of H §7 (28) without the command: the largest v with |D_c/t_rtn - v·n_c| <= V_c on
    every axis c.
    """
    v = g / vertical if vertical > 0.0 else math.inf
    for d, m, limit in zip(displacement, n, limits, strict=True):
        v = min(v, axis_limit(d, m, limit, g, vertical), axis_limit(-d, -m, limit, g, vertical))
    return v


def speed_standing(n: Point, limits: Point) -> float:
    """The largest v at which standing legs keep their limits, using at most half of V_z for
    climbing.
    """
    share = (1.0, 1.0, CLIMB_SHARE)
    return min(
        limit * part / abs(m) if abs(m) > 1e-12 else math.inf
        for m, limit, part in zip(n, limits, share, strict=True)
    )


def timing(
    machine: Machine,
    gait: Gait,
    displacement: Point,
    n: Point,
    climb: float,
    g0: float,
    g: float,
    rise: float,
    drop: float,
    room: tuple[float, float],
    command: float,
    cruise: Callable[[], float],
) -> Timing:
    """Durations and speeds of a step.

    ``climb`` is the body's own change of height in the step, ``rise`` and ``drop`` are the foot's
    vertical strokes, ``room`` how far the body may go on during each before the foot is out of
    mechanical reach. ``cruise`` gives v_max of the standard step: the four-leg phase goes on at it
    when the swing is slower.
    """
    limits = swing_speeds(machine, gait)
    kappa = peak(profile_of(gait))
    g_u = g - g0
    standing = speed_standing(n, limits)
    sinking = 0.0 if g > 0.0 or climb == 0.0 else WAIT_SHARE * limits[2]  # |v_Gz|
    v = v_max = 0.0
    # the body's own climb slows the lift, and the slower lift the climb: the second pass is
    # feasible
    for _ in range(2):
        lift = (machine.speed[2] - sinking) / kappa
        up, down = rise / lift, drop / lift
        if g_u <= 0.0:
            break
        lifting = up + down  # τ
        v_max = min(
            speed_limit(displacement, n, limits, g_u, lifting),
            standing,
            room[0] / up,
            room[1] / down,
            g_u / (lifting + BACK_MIN),
        )
        v = min(v_max, command) if command > 0.0 else v_max
        sinking = abs(v_max * n[2])
        if sinking == 0.0:
            break
    if g_u > 0.0:
        back = g_u / v - (up + down)  # H §7 (29)
    else:
        dx, dy, dz = displacement
        # (13b): the body waits
        back = max(
            BACK_MIN, abs(dx) / limits[0], abs(dy) / limits[1], abs(dz) / (limits[2] - sinking)
        )
        if sinking > 0.0:
            back = max(back, abs(climb) / sinking)
    support_speed = v
    if not 0.0 < command <= v:
        at_most = min(cruise(), standing)
        support_speed = max(v, min(command, at_most) if command > 0.0 else at_most)
    return Timing(v, v_max, support_speed, g0 / support_speed, up, back, down)  # H §7 (32)


def knots(
    clock: Timing,
    profile: Profile,
    body: tuple[Point, Point],
    g0: float,
    g: float,
    swing: SwingCorners,
) -> tuple[list[Knot], list[Phase]]:
    """The step as knots and the phase of every stretch between them.

    ``body`` at N_k and N_{k+1}. Up and down are vertical in the absolute frame; the return is eased
    against the body, so that the servo's own speed is what is bounded.
    """
    (x0, y0, z0), (x1, y1, z1) = body
    dx, dy, dz = x1 - x0, y1 - y0, z1 - z0
    share0 = g0 / g if g > 0.0 else 0.0
    stand, top, over, aim = swing
    out: list[Knot] = [(0.0, body[0], stand)]
    phases: list[Phase] = []
    t = clock.support
    if clock.support > 0.0:
        out.append((t, (x0 + share0 * dx, y0 + share0 * dy, z0 + share0 * dz), stand))
        phases.append(Phase.SUPPORT)
    total = clock.up + clock.back + clock.down
    rate = (1.0 - share0) / total  # of the body's way, per second
    share = share0
    for phase, duration, a, b in (
        (Phase.UP, clock.up, stand, top),
        (Phase.RETURN, clock.back, top, over),
        (Phase.DOWN, clock.down, over, aim),
    ):
        way = rate * duration
        carried = (way * dx, way * dy, way * dz) if phase is Phase.RETURN else (0.0, 0.0, 0.0)
        cx, cy, cz = carried
        rx, ry, rz = b[0] - a[0] - cx, b[1] - a[1] - cy, b[2] - a[2] - cz
        for tau, eased in profile:
            w = share + tau * way
            place = (x0 + w * dx, y0 + w * dy, z0 + w * dz)
            foot = (
                a[0] + tau * cx + eased * rx,
                a[1] + tau * cy + eased * ry,
                a[2] + tau * cz + eased * rz,
            )
            out.append((t + tau * duration, place, foot))
            phases.append(phase)
        t += duration
        share += way
        out[-1] = (t, out[-1][1], b)
    out[-1] = (t, body[1], aim)
    return out, phases
