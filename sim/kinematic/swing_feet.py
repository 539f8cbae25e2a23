"""Feet in the air: they go where they are driven until they meet the ground, a riser or an
obstacle.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from walking_console.planner.geometry.transforms import direction

from ..terrain.ground import Ground
from .configuration import STEP_UP, XY, Configuration, FootMotion
from .contact import OVER

# m; a moving foot this near the ground has come down: nearer than that a servo could not take it in
# time
TOUCH = 1e-6
OVERHANG = 0.03  # m the ground under a sole's rim may lie lower; more is an edge
SAME_PLACE = 1e-9  # m; a sole that moves over the ground by more slips
RISER_HALVINGS = 6  # a foot stops at a riser to within a third of a millimetre
SHORT_OF = 1e-3  # of its way: a foot stops this much before the surface of an obstacle
EIGHTH = math.pi / 4  # rad between two whiskers


def swing(q: Configuration, motions: Sequence[FootMotion], legs: Iterable[int]) -> None:
    """One tick of feet that carry nothing: they go where they are driven until they touch the
    ground, and stop there.
    """
    (bx, by, bz, _, _, _) = q.body
    xx, xy, xz, yx, yy, yz, zx, zy, zz = q.rotation
    contact = q.contact
    obstacles = contact.obstacles
    crowded = obstacles and contact.crowds(bx, by)
    height_at = q.ground.height_at
    for leg in legs:
        foot = q.feet[leg]
        tip = q.tips[leg]
        (dx, dy, dz) = motions[leg]
        px = tip[0] + dx
        py = tip[1] + dy
        pz = tip[2] + dz
        x = bx + xx * px + xy * py + xz * pz
        y = by + yx * px + yy * py + yz * pz
        z = bz + zx * px + zy * py + zz * pz
        if obstacles and contact.near(x, y):
            x, y = _feel(q, leg, x, y, z)
        elif q.whiskers[leg]:
            q.whiskers[leg] = 0
        if crowded and _leg_meets(q, leg, x, y, z):
            _meet(q, leg, x - foot[0], y - foot[1])
            x, y = foot[0], foot[1]
        height = height_at(x, y)
        if z - height > TOUCH or height != height:
            q.soles[leg] = q.slipping[leg] = False
            tip[0], tip[1], tip[2] = px, py, pz
            foot[0], foot[1], foot[2] = x, y, z
        else:
            _touch(q, leg, (x, y, z), height)


def _leg_meets(q: Configuration, leg: int, x: float, y: float, z: float) -> bool:
    """True when the leg is free now and would not be with its foot at (x, y, z)."""
    hits = q.contact.leg_hits
    return hits(leg, q.body, (x, y, z)) and not hits(leg, q.body, q.feet[leg])


def _feel(q: Configuration, leg: int, x: float, y: float, z: float) -> XY:
    """Where a foot gets to that is driven to (x, y, z) near an obstacle; its whiskers say what is
    around it.
    """
    foot = q.feet[leg]
    touch = q.contact.sweep(foot[0], foot[1], x, y, z + OVER)
    if touch is not None:
        short = max(0.0, touch.share - SHORT_OF)
        x = foot[0] + (x - foot[0]) * short
        y = foot[1] + (y - foot[1]) * short
    height = q.ground.height_at(x, y)
    if z < height <= foot[2]:  # it stops on the ground, however far it was driven
        z = height
    q.whiskers[leg] = q.contact.feel(x, y, z, q.body[5])
    return x, y


def _touch(q: Configuration, leg: int, driven: tuple[float, float, float], height: float) -> None:
    """A foot in the air meets ground: it stops there, or beside a riser. From the next tick on it
    carries.
    """
    x, y, z = driven
    foot = q.feet[leg]
    was_on = q.soles[leg]
    if height - foot[2] > STEP_UP:
        (x, y), height = _stop_at_riser(q, leg, x, y)
    on = z - height <= TOUCH
    moved = abs(x - foot[0]) > SAME_PLACE or abs(y - foot[1]) > SAME_PLACE
    q.soles[leg] = on
    q.slipping[leg] = was_on and on and moved
    foot[0] = x
    foot[1] = y
    foot[2] = height if on else z
    q.measure(leg)
    q.rims[leg] = 0
    if on:
        q.rims[leg] = overhang(q.ground, q.machine.foot_radius, q.body[5], (x, y, height))


def overhang(ground: Ground, radius: float, yaw: float, sole: tuple[float, float, float]) -> int:
    """Directions of eight, bit 0 along body +x, in which the rim of a sole on the ground has none
    under it, as finely as the map tells: by the cells about the one it stands in.
    """
    x, y, height = sole
    reach = math.floor(radius / ground.cell + 1e-9) * ground.cell
    cell = ground.cell_at(x, y)
    if ground.final or reach == 0.0 or cell is None:
        return 0
    x, y = ground.centre(*cell)
    bits = 0
    for k in range(8):
        c, s = direction(yaw + k * EIGHTH)
        if not height - ground.height_at(x + reach * c, y + reach * s) <= OVERHANG:
            bits |= 1 << k
    return bits


def _stop_at_riser(q: Configuration, leg: int, x: float, y: float) -> tuple[XY, float]:
    """How far a foot on its way to (x, y) gets before ground too tall to ride up, and the ground
    there.
    """
    foot = q.feet[leg]
    height_at = q.ground.height_at
    dx, dy = x - foot[0], y - foot[1]
    free, stuck = 0.0, 1.0
    for _ in range(RISER_HALVINGS):
        middle = (free + stuck) / 2
        if height_at(foot[0] + dx * middle, foot[1] + dy * middle) - foot[2] > STEP_UP:
            stuck = middle
        else:
            free = middle
    _meet(q, leg, dx, dy)
    x, y = foot[0] + dx * free, foot[1] + dy * free
    return (x, y), height_at(x, y)


def _meet(q: Configuration, leg: int, dx: float, dy: float) -> None:
    """The whisker on the side a foot was going to says that something is there."""
    bearing = math.atan2(dy, dx) - q.body[5]
    q.whiskers[leg] |= 1 << round(bearing / EIGHTH) % 8
