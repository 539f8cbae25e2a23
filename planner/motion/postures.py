"""Postures on command, as short sequences of plans: sitting down and standing up, and what every
motion of the body on standing feet needs.

All motion is quasi-static and nothing else moves while a foot is in the air. Going back into the
nominal layout, one foot after the other, is in ``return_to_nominal``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from ..geometry.transforms import Body, left_fold_sum, turned_back
from ..robot.collision import leg_in_the_way
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Blocked, Gait, Point, Reason, Stance, StepPlan
from .body_height import torso_clearance, torso_needs_exactly
from .step_builder import plan_on_all_feet
from .swing import profile_of, swing_speeds

STILL = 1e-4  # m; a shorter way of the body is none
# of V_z at which the body sinks and rises; more: see it drop rather than sit down
HEIGHT_SHARE = 0.5
# of V_x, V_y at which it shifts on all feet: about the speed of a walk; more: see it lurch
SHIFT_SHARE = 0.2
GIVE = 0.005  # m of the legs' last reach kept while sitting, for Level C to level the torso with
# m between the heights at which the legs of a sinking body are held against the ground beside them
LEG_LOOK = 0.025

PlanSequence = tuple[StepPlan, ...]


def sit(
    stance: Stance, terrain: TerrainMap, machine: Machine, gait: Gait
) -> PlanSequence | Blocked:
    """The body sinks on its feet until the torso is just above the ground, or the legs (δz
    included) can be drawn no higher; ``Blocked`` with a foot in the air, or where a leg would come
    to lie on the ground.
    """
    if stance.lifted:
        return in_the_air(stance)
    x, y, z, yaw = stance.body
    pairs = zip(stance.feet, machine.legs, strict=True)
    drawn = max(foot[2] - leg.z[1] for foot, leg in pairs) - machine.overreach[2] + GIVE
    lowest = max(drawn, torso_needs_exactly(terrain, machine, x, y, yaw))
    reached = z
    while reached > lowest:
        lower = max(lowest, reached - LEG_LOOK)
        if leg_in_the_way(terrain, machine, (x, y, lower, yaw), stance.feet) is not None:
            break
        reached = lower
    if reached == z and lowest < z - STILL:
        body = x, y, max(lowest, z - LEG_LOOK), yaw
        met = leg_in_the_way(terrain, machine, body, stance.feet)
        return Blocked(Reason.LEG_BESIDE, met)
    return shifted(stance, ((x, y, min(reached, z)),), machine, gait)


def stand(
    stance: Stance, terrain: TerrainMap, machine: Machine, gait: Gait
) -> PlanSequence | Blocked:
    """The body rises (or sinks) to H above the mean of its feet, as far as every leg reaches, and
    over the ground below it; ``Blocked`` with a foot in the air.
    """
    if stance.lifted:
        return in_the_air(stance)
    x, y, _, yaw = stance.body
    z = standing_height(stance.feet, terrain, machine, gait, (x, y, yaw))
    return shifted(stance, ((x, y, z),), machine, gait)


def standing_height(
    feet: Sequence[Point],
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    place: tuple[float, float, float],
) -> float:
    """The CoG at H above the mean of the feet, within reach of them all, for a body at ``place``
    (x, y, yaw), m; where no height is, half of what is amiss is left to δz.
    """
    low, high = height_limits(feet, machine)
    if low > high:
        return (low + high) / 2
    mean = left_fold_sum(foot[2] for foot in feet) / len(feet)
    wanted = max(mean + gait.height, torso_clearance(terrain, machine, *place))
    return min(max(wanted, low), high)


def height_limits(feet: Sequence[Point], machine: Machine) -> tuple[float, float]:
    """Lowest and highest CoG from which every foot is in its control reach, m; low > high when
    there is none.
    """
    pairs = list(zip(feet, machine.legs, strict=True))
    lowest = max(foot[2] - leg.z[1] for foot, leg in pairs)
    return lowest, min(foot[2] - leg.z[0] for foot, leg in pairs)


def in_the_air(stance: Stance) -> Blocked:
    """The refusal of a posture while a foot is in the air."""
    return Blocked(Reason.FOOT_IN_THE_AIR, stance.lifted[0])


def shifted(stance: Stance, places: Sequence[Point], machine: Machine, gait: Gait) -> PlanSequence:
    """One plan that takes the body through ``places`` (x, y, z) on all feet that stand; none where
    there is no way to go.
    """
    x, y, z, yaw = stance.body
    times = [0.0]
    rows: list[Body] = [stance.body]
    for px, py, pz in places:
        seconds = _seconds((px - x, py - y, pz - z), yaw, machine, gait)
        if seconds == 0.0:
            continue
        begun = times[-1]
        for tau, share in profile_of(gait):
            times.append(begun + tau * seconds)
            rows.append((x + share * (px - x), y + share * (py - y), z + share * (pz - z), yaw))
        x = px
        y = py
        z = pz
    if len(times) == 1:
        return ()
    rows[-1] = (x, y, z, yaw)
    end = replace(stance, body=(x, y, z, yaw))
    way = math.hypot(x - stance.body[0], y - stance.body[1])
    return (plan_on_all_feet(stance, times, rows, end, support_shift=way),)


def _seconds(way: Point, yaw: float, machine: Machine, gait: Gait) -> float:
    """How long a body takes for a way on all feet, s; 0 where it is none."""
    ahead, left = turned_back(way[0], way[1], yaw)
    up = way[2]
    if math.hypot(ahead, left, up) < STILL:
        return 0.0
    vx, vy, vz = swing_speeds(machine, gait)
    return max(
        abs(ahead) / (SHIFT_SHARE * vx),
        abs(left) / (SHIFT_SHARE * vy),
        abs(up) / (HEIGHT_SHARE * vz),
    )
