"""Getting a lifted foot back on the ground while the body stands still: after a stop, or from an
emergent motion.

Static stability makes a stop safe at any tick: the other feet carry the body where it is. What is
left is the swing foot, which goes to the nearest valid ground in its present reach by its own
clock.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from ..geometry.transforms import direction, point_seen
from ..robot.model import Leg, Machine
from ..terrain.map import TerrainMap
from ..types import Blocked, Gait, Point, Reason, Stance, StepPlan
from .step_builder import FootWay, body_still_plan
from .swing import CLEARANCE, STRETCHES, SwingCorners, aim_of, profile_of, swing_speeds

STRETCHES_FOR = 0.05  # m of way that is worth a stretched leg
STAYS = 1e-6  # m; a foot this near above its landing point goes straight down


def place_foot(
    stance: Stance, leg: int, terrain: TerrainMap, machine: Machine, gait: Gait
) -> StepPlan | Blocked:
    """Set the lifted foot of ``leg`` down on the nearest valid ground within its reach; the body
    stays where it is.

    ``stance`` holds the present pose with the foot in the air. Blocked when there is no such
    ground.
    """
    way = _way_down(stance, leg, terrain, machine, gait)
    if way is None:
        return Blocked(Reason.NO_PLACE, leg)
    return _placing(stance, {leg: way}, machine, gait)


def place_feet(
    stance: Stance, legs: Sequence[int], terrain: TerrainMap, machine: Machine, gait: Gait
) -> StepPlan | Blocked:
    """Set several lifted feet down at once, each on its nearest ground; one without ground stays
    lifted. Blocked when all are.
    """
    if len(legs) == 1:
        return place_foot(replace(stance, lifted=()), legs[0], terrain, machine, gait)
    ways = {
        leg: way
        for leg in legs
        if (way := _way_down(stance, leg, terrain, machine, gait)) is not None
    }
    if not ways:
        return Blocked(Reason.NO_PLACE_FOR_ANY, legs[0])
    stays = tuple(leg for leg in legs if leg not in ways)
    down = _placing(replace(stance, lifted=stays), ways, machine, gait)
    return replace(down, swing=(*down.swing, *stays))


def _way_down(
    stance: Stance, leg: int, terrain: TerrainMap, machine: Machine, gait: Gait
) -> FootWay | None:
    """Up over what is on the way, to the nearest ground and down; None when there is none."""
    landing = nearest_ground(stance, leg, terrain, machine)
    if landing is None:
        return None
    foot = stance.feet[leg]
    crest = terrain.crest_between(foot[0], foot[1], landing[0], landing[1])
    near = math.hypot(landing[0] - foot[0], landing[1] - foot[1]) < STAYS
    top = foot[2] if near else max(foot[2], crest + CLEARANCE)
    corners = SwingCorners(
        foot,
        (foot[0], foot[1], top),
        (landing[0], landing[1], top),
        aim_of(landing, stance.body[2], leg, machine, gait),
    )
    return FootWay(corners, landing)


def _placing(stance: Stance, ways: dict[int, FootWay], machine: Machine, gait: Gait) -> StepPlan:
    """The feet along their ways, each stretch as long as the slowest of them takes."""
    ahead, left, vertical = swing_speeds(machine, gait)
    limits = vertical, min(ahead, left), vertical
    seconds = [0.0, 0.0, 0.0]
    for way in ways.values():
        for k, limit in enumerate(limits):
            apart = math.dist(way.corners[k], way.corners[k + 1])
            seconds[k] = max(seconds[k], apart / limit if apart >= STAYS else 0.0)
    return body_still_plan(stance, ways, seconds, STRETCHES, profile_of(gait))


def nearest_ground(stance: Stance, leg: int, terrain: TerrainMap, machine: Machine) -> Point | None:
    """The valid landing point nearest to a lifted foot: straight below if it may land there, else a
    cell centre. One that the leg must be stretched for is taken where it is nearer by
    ``STRETCHES_FOR`` and more.
    """
    x, y, _ = stance.feet[leg]
    reached = _nearest_within(0.0, stance, leg, terrain, machine)
    worth = machine.size * STRETCHES_FOR
    if reached is not None and math.hypot(reached[0] - x, reached[1] - y) <= worth:
        return reached
    stretched = _nearest_within(min(machine.overreach[:2]), stance, leg, terrain, machine)
    if reached is None or stretched is None:
        return reached or stretched
    way, other = (math.hypot(at[0] - x, at[1] - y) for at in (reached, stretched))
    return stretched if way - other > worth else reached


def _nearest_within(
    reach: float, stance: Stance, leg: int, terrain: TerrainMap, machine: Machine
) -> Point | None:
    """The same, no farther than ``reach`` beyond the leg's rectangle."""
    x, y, _ = stance.feet[leg]
    spec = machine.legs[leg]
    if _fits(x, y, stance, spec, terrain, machine, reach):
        return x, y, terrain.height_at(x, y)
    points = sorted(
        _centres_in_reach(stance, spec, terrain, reach),
        key=lambda p: (math.hypot(p[0] - x, p[1] - y), p),
    )
    for px, py in points:
        if _fits(px, py, stance, spec, terrain, machine, reach) and _way_is_low(
            stance, leg, px, py, terrain, machine
        ):
            return px, py, terrain.height_at(px, py)
    return None


def _fits(
    x: float,
    y: float,
    stance: Stance,
    leg: Leg,
    terrain: TerrainMap,
    machine: Machine,
    reach: float,
) -> bool:
    """In the reach rectangle, on an allowed cell, at a height the leg can stand at."""
    if not terrain.allows(x, y):
        return False
    bx, by, _ = point_seen(stance.body, (x, y, 0.0))
    if not (
        leg.x[0] - reach <= bx <= leg.x[1] + reach and leg.y[0] - reach <= by <= leg.y[1] + reach
    ):
        return False
    drop = terrain.height_at(x, y) - stance.body[2]
    return leg.z[0] - machine.overreach[2] <= drop <= leg.z[1]


def _way_is_low(
    stance: Stance, leg: int, x: float, y: float, terrain: TerrainMap, machine: Machine
) -> bool:
    """True when the leg can lift the foot over everything between here and there."""
    foot = stance.feet[leg]
    crest = terrain.crest_between(foot[0], foot[1], x, y) + CLEARANCE
    return crest <= max(foot[2], stance.body[2] + machine.legs[leg].z[1] + machine.overreach[2])


def _centres_in_reach(
    stance: Stance, leg: Leg, terrain: TerrainMap, reach: float
) -> list[tuple[float, float]]:
    x, y, _, yaw = stance.body
    corners = [
        (cx, cy)
        for cx in (leg.x[0] - reach, leg.x[1] + reach)
        for cy in (leg.y[0] - reach, leg.y[1] + reach)
    ]
    c, s = direction(yaw)
    xs = [x + c * cx - s * cy for cx, cy in corners]
    ys = [y + s * cx + c * cy for cx, cy in corners]
    c0, c1 = (math.floor((v - terrain.origin[0]) / terrain.cell) for v in (min(xs), max(xs)))
    r0, r1 = (math.floor((v - terrain.origin[1]) / terrain.cell) for v in (min(ys), max(ys)))
    return [
        terrain.centre(row, column)
        for row in range(max(r0, 0), min(r1, terrain.rows - 1) + 1)
        for column in range(max(c0, 0), min(c1, terrain.columns - 1) + 1)
    ]
