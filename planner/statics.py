"""Who carries what: the centre of gravity of body and legs, and the load of every foot.

Statics: a body at rest, or moving evenly, on its feet; of one that speeds up take its zero-moment
point for its centre. Points are m, forces N; the weight acts straight down. On three feet the loads
are exact. More feet are statically indeterminate: of all loads that balance the weight and press,
those with the least squares are taken, which is what legs of one stiffness would carry. Feet on
their way up or down count less and less, so that loads are continuous over lift-off and touch-down.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from .geometry.transforms import XY, Point, direction, left_fold_sum
from .robot.chains import LegChain, Masses
from .robot.kinematics import inverse, leg_moment, solved
from .robot.model import Machine
from .simplex import least_cost
from .stability import GRAVITY, polygon_margin, support_polygon

# s over which a leg takes its load up or gives it away; shorter, see the body jolt at lift-off,
# longer, see the leg that lifts leave the others less time
RAMP = 0.15
ROUNDS = 60  # of the search for loads; it ends by itself, mostly within five
EXACT = 1e-12  # share of the weight by which moments may be off
CONE = 8  # forces that stand for a friction cone; it lies inside the round one
LOAD_WEIGHT = 1.0  # in the linear programme, of the heaviest load against friction used
FRICTION_WEIGHT = 0.01


class Loads(NamedTuple):
    """What every foot carries, N, and whether that balances the weight.

    ``balanced`` is False when the centre of gravity is outside the feet: then the loads are those
    of the nearest point that could be carried.
    """

    newtons: tuple[float, ...]
    balanced: bool


# -- the centre of gravity


def centre_of_gravity(machine: Machine, feet_b: Sequence[Point]) -> Point:
    """Of torso and legs, body axes, m, with every foot, standing or swinging, where it is."""
    at_feet = machine.mass_at_feet
    if at_feet is None:
        return _centre_of_links(machine, feet_b)
    x, y, z, mass, whole = at_feet
    for ahead, aside, up in feet_b:
        x += mass * ahead
        y += mass * aside
        z += mass * up
    return x / whole, y / whole, z / whole


def _centre_of_links(machine: Machine, feet_b: Sequence[Point]) -> Point:
    masses = machine.masses
    whole = masses.torso
    x, y, z = masses.centre
    x *= masses.torso
    y *= masses.torso
    z *= masses.torso
    first, second, third = masses.links
    all_in_the_last = first == 0.0 == second
    for chain, foot in zip(machine.chains, feet_b, strict=True):
        if all_in_the_last and chain.joints[2].slides:
            x += third * foot[0]
            y += third * foot[1]
            z += third * foot[2]
        else:
            lx, ly, lz = _moment_of_leg(chain, masses, foot)
            x += lx
            y += ly
            z += lz
        whole += masses.leg
    return x / whole, y / whole, z / whole


def zero_moment_point(centre: XY, height: float, acceleration: XY) -> XY:
    """Where feet must push for a centre of gravity so far above them, m, to speed up so, m/s²."""
    lever = height / GRAVITY
    return centre[0] - lever * acceleration[0], centre[1] - lever * acceleration[1]


def pushed_at(
    centre: Point, acceleration: XY, feet: Sequence[Sequence[float]], shares: Sequence[float]
) -> XY:
    """Where feet that count as carrying by ``shares`` push for a centre of gravity to speed up so.

    While a foot takes its load up or gives it away, as much less of the acceleration counts, and
    none where the feet that carry could not push there.
    """
    on = [foot for foot, share in zip(feet, shares, strict=True) if share > 0.0]
    if not on:
        return centre[0], centre[1]
    counts = min((share for share in shares if share > 0.0), default=1.0)
    ground = left_fold_sum(foot[2] for foot in on) / len(on)
    ax, ay = counts * acceleration[0], counts * acceleration[1]
    place = zero_moment_point((centre[0], centre[1]), centre[2] - ground, (ax, ay))
    inside = polygon_margin(support_polygon(on), *place) > 0.0
    return place if inside else (centre[0], centre[1])


def _moment_of_leg(chain: LegChain, masses: Masses, foot: Point) -> Point:
    """Σ m·r of a leg's links, kg·m, body axes. A foot out of reach: as if on a straight leg."""
    joints = inverse(chain, foot)
    if joints is not None:
        return leg_moment(chain, masses, joints)
    half = masses.leg / 2.0
    hip = chain.hip
    return half * (hip[0] + foot[0]), half * (hip[1] + foot[1]), half * (hip[2] + foot[2])


# -- loads


def load_share(since: float, until: float, ramp: float = RAMP) -> float:
    """How much a leg counts as carrying, 0 to 1, so long after its touch-down and before its
    lift-off, s: smooth, with no jump of its rate.
    """
    part = min(since, until) / ramp
    if part >= 1.0:
        return 1.0
    return 0.0 if part <= 0.0 else part * part * (3.0 - 2.0 * part)


def planned_loads(
    weight: float, centre: XY, feet: Sequence[Sequence[float]], shares: Sequence[float]
) -> Loads:
    """What every foot carries, N, of a weight at ``centre`` (x, y).

    ``shares`` say how much each foot counts as carrying (``load_share``), 0 for one in the air. The
    loads minimise Σ f²/share with Σ f = weight, moments balanced and f >= 0, so f = share ·
    max(0, a + b x + c y): a plane over the feet, found by Newton steps on its three numbers.
    """
    bearing = [(i, foot) for i, foot in enumerate(feet) if shares[i] > 0.0]
    loads = [0.0] * len(feet)
    if not bearing:
        return Loads(tuple(loads), False)
    scale = max(math.hypot(foot[0] - centre[0], foot[1] - centre[1]) for _, foot in bearing) or 1.0
    arms = [((foot[0] - centre[0]) / scale, (foot[1] - centre[1]) / scale) for _, foot in bearing]
    most = max(shares)
    counts = [shares[i] / most for i, _ in bearing]
    found = _balanced(arms, counts)
    balanced = found is not None
    if found is None:
        found = _balanced_nearest(arms, counts)
    for (i, _), load in zip(bearing, found, strict=True):
        loads[i] = weight * load
    return Loads(tuple(loads), balanced)


def _balanced(arms: Sequence[XY], shares: Sequence[float]) -> list[float] | None:
    """Loads of a weight of 1 at the origin; None when it is outside the feet."""
    plane: Point = (1.0 / left_fold_sum(shares), 0.0, 0.0)
    loads = _pressing(arms, shares, plane)
    left = _left(arms, loads)
    for _ in range(ROUNDS):
        if max(abs(part) for part in left) < EXACT:
            return loads
        step = _newton_step(arms, shares, plane, left)
        if step is None:
            return None
        plane, loads = _towards(arms, shares, plane, step)
        left = _left(arms, loads)
    return loads if max(abs(part) for part in left) < EXACT * 1e3 else None


def _pressing(arms: Sequence[XY], shares: Sequence[float], plane: Point) -> list[float]:
    a, b, c = plane
    return [s * max(0.0, a + b * x + c * y) for (x, y), s in zip(arms, shares, strict=True)]


def _left(arms: Sequence[XY], loads: Sequence[float]) -> Point:
    """What is missing of the weight and of each moment."""
    force = 1.0
    mx = 0.0
    my = 0.0
    for (x, y), load in zip(arms, loads, strict=True):
        force -= load
        mx -= load * x
        my -= load * y
    return force, mx, my


def _newton_step(
    arms: Sequence[XY], shares: Sequence[float], plane: Point, left: Point
) -> Point | None:
    a, b, c = plane
    n = nx = ny = nxx = nxy = nyy = 0.0
    for (x, y), s in zip(arms, shares, strict=True):
        if a + b * x + c * y > 0.0:
            n += s
            nx += s * x
            ny += s * y
            nxx += s * x * x
            nxy += s * x * y
            nyy += s * y * y
    size = n if n > 0.0 else 1.0
    matrix = (
        (n / size, nx / size, ny / size),
        (nx / size, nxx / size, nxy / size),
        (ny / size, nxy / size, nyy / size),
    )
    return solved(matrix, (left[0] / size, left[1] / size, left[2] / size))


def _towards(
    arms: Sequence[XY], shares: Sequence[float], plane: Point, step: Point
) -> tuple[Point, list[float]]:
    """The longest halving of a step that lowers the dual cost ½ Σ s·max(0, plane)² − plane(0)."""
    least = _dual(arms, shares, plane)
    part = 1.0
    tried = plane
    for _ in range(40):
        tried = (
            plane[0] + part * step[0],
            plane[1] + part * step[1],
            plane[2] + part * step[2],
        )
        if _dual(arms, shares, tried) <= least:
            break
        part /= 2.0
    return tried, _pressing(arms, shares, tried)


def _dual(arms: Sequence[XY], shares: Sequence[float], plane: Point) -> float:
    a, b, c = plane
    total = -a
    for (x, y), s in zip(arms, shares, strict=True):
        height = a + b * x + c * y
        if height > 0.0:
            total += 0.5 * s * height * height
    return total


def _balanced_nearest(arms: Sequence[XY], shares: Sequence[float]) -> list[float]:
    """Loads of the point nearest to the origin that the feet can carry: on one edge, or one foot.

    With two feet or three in a line that is all there is.
    """
    loads = [0.0] * len(arms)
    best = math.inf
    for i in range(len(arms)):
        for j in range(i, len(arms)):
            part = _share_along(arms[i], arms[j])
            x = (1.0 - part) * arms[i][0] + part * arms[j][0]
            y = (1.0 - part) * arms[i][1] + part * arms[j][1]
            far = math.hypot(x, y)
            if far < best - EXACT:
                best = far
                loads = [0.0] * len(arms)
                loads[i] += 1.0 - part
                loads[j] += part
    return loads


def _share_along(a: XY, b: XY) -> float:
    """Where between a and b, 0 to 1, the point nearest to the origin is."""
    ex = b[0] - a[0]
    ey = b[1] - a[1]
    squared = ex * ex + ey * ey
    if squared == 0.0:
        return 0.0
    return min(1.0, max(0.0, -(a[0] * ex + a[1] * ey) / squared))


# -- forces inside friction cones


def contact_forces(
    weight: float,
    centre: Point,
    feet: Sequence[Point],
    normals: Sequence[Point],
    friction: float,
) -> tuple[Point, ...] | None:
    """Forces of the ground on feet that are not in one plane, N, that hold a weight at ``centre``.

    Each stays inside its friction cone about the ground's unit normal there (eight forces stand for
    a cone). Of all that balance, the heaviest normal load is least, and then the friction used.
    None when nothing holds: the body tips or slides. A linear programme, the same every time.
    """
    scale = max((math.dist(foot, centre) for foot in feet), default=0.0) or 1.0
    rays = [
        ray for foot, normal in zip(feet, normals, strict=True) for ray in _cone(normal, friction)
    ]
    per_foot = CONE + 1
    columns = []
    for k, ray in enumerate(rays):
        foot = feet[k // per_foot]
        arm = tuple((foot[axis] - centre[axis]) / scale for axis in range(3))
        columns.append((*ray, *_moment((arm[0], arm[1], arm[2]), ray)))
    rows, right, cost = _programme(columns, len(feet))
    amounts = least_cost(cost, rows, right)
    if amounts is None:
        return None
    return tuple(
        _force(weight, rays[i * per_foot : (i + 1) * per_foot], amounts[i * per_foot :])
        for i in range(len(feet))
    )


def _programme(
    columns: Sequence[tuple[float, ...]], feet: int
) -> tuple[list[list[float]], list[float], list[float]]:
    """Six equations of balance, and one a foot: its load and a slack are the heaviest load.

    Amounts are those of the rays (each with a normal part of 1), the slacks, the heaviest load.
    """
    per_foot = CONE + 1
    blank = [0.0] * (feet + 1)
    rows = [[column[axis] for column in columns] + blank for axis in range(6)]
    for foot in range(feet):
        row = [1.0 if k // per_foot == foot else 0.0 for k in range(len(columns))]
        rows.append([*row, *(1.0 if k == foot else 0.0 for k in range(feet)), -1.0])
    right = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0] + [0.0] * feet
    friction = [0.0 if k % per_foot == 0 else FRICTION_WEIGHT for k in range(len(columns))]
    return rows, right, [*friction, *([0.0] * feet), LOAD_WEIGHT]


def _cone(normal: Point, friction: float) -> list[Point]:
    """The normal itself, and forces around it at the friction angle, each with a normal part 1."""
    first = _across(normal)
    second = _moment(normal, first)
    rays = [normal]
    for k in range(CONE):
        c, s = direction(2.0 * math.pi * k / CONE)
        x, y, z = (
            normal[axis] + friction * (c * first[axis] + s * second[axis]) for axis in range(3)
        )
        rays.append((x, y, z))
    return rays


def _across(normal: Point) -> Point:
    """A unit vector square to another."""
    x, y, z = normal
    if abs(z) > 0.5:
        length = math.hypot(x, z)
        return z / length, 0.0, -x / length
    length = math.hypot(x, y)
    return -y / length, x / length, 0.0


def _moment(arm: Point, force: Point) -> Point:
    return (
        arm[1] * force[2] - arm[2] * force[1],
        arm[2] * force[0] - arm[0] * force[2],
        arm[0] * force[1] - arm[1] * force[0],
    )


def _force(weight: float, rays: Sequence[Point], amounts: Sequence[float]) -> Point:
    x = y = z = 0.0
    for ray, amount in zip(rays, amounts, strict=False):
        x += weight * amount * ray[0]
        y += weight * amount * ray[1]
        z += weight * amount * ray[2]
    return x, y, z
