"""The swing of a foot: up, return and down, its speed profile, and what it must clear.

One shape for both walkers, for placements, postures and reflexes: straight up, over to the landing
point, and straight down to an aim below the expected ground, so that touch decides (H §4.5, fig.
8). Each of the three stretches is run through at the speeds of one profile. A new profile is one
more table here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from ..geometry.transforms import XY
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Gait, Phase, Point

# m between a lifted foot, or the torso, and the highest ground under its way; less: see it scuff
CLEARANCE = 0.02

# Where a stretch has got to: (share of its time, share of its way), each stair of constant speed.
Profile = tuple[XY, ...]

EVEN: Profile = ((1.0, 1.0),)
# Stairs of 1/4, 3/4, then 1 of the peak speed, mirrored; peak / mean = 1.25 (H §11 (3)).
EASED: Profile = (
    (0.1, 0.03125),
    (0.2, 0.125),
    (0.8, 0.875),
    (0.9, 0.96875),
    (1.0, 1.0),
)

STRETCHES = (Phase.UP, Phase.RETURN, Phase.DOWN)


class SwingCorners(NamedTuple):
    """The corners of a swing, absolute frame, m."""

    stand: Point  # where the foot is
    top: Point  # lifted
    over: Point  # above its landing point
    aim: Point  # what it aims for, below the ground expected


def profile_of(gait: Gait) -> Profile:
    """The speed profile of every stretch of a swing: eased, or even as printed."""
    return EASED if gait.smooth else EVEN


def peak(profile: Profile) -> float:
    """κ: the largest speed of a profile over its mean speed."""
    steps = zip(((0.0, 0.0), *profile), profile, strict=False)
    return round(max((w - v) / (t - s) for (s, v), (t, w) in steps), 12)


EVEN_PEAK = peak(EVEN)
EASED_PEAK = peak(EASED)


def peak_of(gait: Gait) -> float:
    """κ of the profile of a gait; asked several times a step."""
    return EASED_PEAK if gait.smooth else EVEN_PEAK


def swing_speeds(machine: Machine, gait: Gait, share: float = 1.0) -> Point:
    """The mean speeds of a stretch at which no foot exceeds ``share`` of V, along body x, y and z:
    V / κ, m/s.
    """
    kappa = peak_of(gait)
    vx, vy, vz = machine.speed
    return share * vx / kappa, share * vy / kappa, share * vz / kappa


def stairs(profile: Profile, pieces: int = 1) -> Iterator[XY]:
    """Share of the time and of the way at the end of every stair, stairs cut so finely that a
    stretch has at least ``pieces``.
    """
    before = done = 0.0
    for tau, eased in profile:
        count = max(1, math.ceil(pieces * (tau - before)))
        for k in range(1, count + 1):
            yield before + (tau - before) * k / count, done + (eased - done) * k / count
        before = tau
        done = eased


def between(a: Point, b: Point, share: float) -> Point:
    """The point at a share of the straight line from ``a`` to ``b``."""
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])


def lift(
    foot: Point,
    landing: Point,
    crest: float,
    ceiling: float,
    height: float,
    machine: Machine,
    gait: Gait,
) -> SwingCorners:
    """The corners of a swing from ``foot`` to ``landing`` while the body ends at ``height``, m.

    The lift clears the ``crest`` under the way; it is cut at the ``ceiling``, where the leg cannot
    be drawn higher, the aim where it cannot reach lower.
    """
    clear = crest + CLEARANCE
    top = max(min(max(foot[2] + gait.lift_up, clear), ceiling), foot[2])
    over = max(min(max(landing[2] + gait.lift_up, clear), ceiling), landing[2])
    lowest = height + machine.z_range[0] - machine.overreach[2]
    aim = max(landing[2] + gait.lift_up - gait.lift_down, min(lowest, landing[2]))
    return SwingCorners(
        foot,
        (foot[0], foot[1], top),
        (landing[0], landing[1], over),
        (landing[0], landing[1], aim),
    )


def aim_of(landing: Point, body_z: float, leg: int, machine: Machine, gait: Gait) -> Point:
    """What a foot of ``leg`` that comes down aims at: h_up below the ground expected, as far as the
    leg reaches under a body at ``body_z``, m.
    """
    bottom = body_z + machine.legs[leg].z[0] - machine.overreach[2]
    return landing[0], landing[1], min(landing[2], max(landing[2] - gait.lift_up, bottom))


def carry_height(start: Point, end: Point, terrain: TerrainMap, gait: Gait) -> float:
    """Height at which a foot is carried from ``start`` to ``end``, absolute, m: h_up above both and
    clear of everything between.
    """
    top = max(start[2], end[2]) + gait.lift_up
    if terrain.is_level:
        return top
    return max(top, terrain.crest_between(start[0], start[1], end[0], end[1]) + CLEARANCE)


def waiting_place(machine: Machine, leg: int, gait: Gait, terrain: TerrainMap) -> Point:
    """Where a leg that stays lifted is carried (K), body axes, m: over the middle of its rectangle,
    drawn right up where ground may rise.

    In body axes a foot goes straight from where it leaves the ground to where it comes down, inside
    its own reach rectangle; rectangles of different legs do not overlap, so it passes no other leg
    nearer than its two ends do.
    """
    x, y = machine.legs[leg].centre
    top = machine.legs[leg].z[1] + machine.overreach[2]
    return x, y, min(-gait.height + gait.lift_up, top) if terrain.is_level else top
