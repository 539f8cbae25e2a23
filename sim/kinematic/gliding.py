"""The common walking tick: carrying legs do one and the same motion, so the body moves and their
feet do not.
"""

from __future__ import annotations

from collections.abc import Sequence

from walking_console.planner.geometry.transforms import direction

from .configuration import Configuration, FootMotion
from .rest_pose import plane_fit
from .support import STIFF, Support

SAME = 1e-10  # m a tick; foot motions this near each other are one motion of the body


def glide(q: Configuration, support: Support, motions: Sequence[FootMotion]) -> bool:
    """Carry the body on through a tick; False, and nothing done, when it is not that simple."""
    body = q.body
    tips = q.tips
    carrying = q.carrying
    first = motions[carrying[0]]
    dx, dy, dz = first
    for leg in carrying:
        motion = motions[leg]
        if motion is first:
            continue
        ax, ay, az = motion
        if not (-SAME < ax - dx < SAME and -SAME < ay - dy < SAME and -SAME < az - dz < SAME):
            return _glide_turning(q, support, motions)
    xx, xy, xz, yx, yy, yz, zx, zy, zz = q.rotation
    x = body[0] - (xx * dx + xy * dy + xz * dz)
    y = body[1] - (yx * dx + yy * dy + yz * dz)
    for nx, ny, offset in support.edges:
        if nx * x + ny * y < offset:
            return False
    contact = q.contact
    if contact.obstacles and contact.crowds(x, y) and q.bumps(x, y, body[5]):
        return False
    body[0] = x
    body[1] = y
    body[2] -= zx * dx + zy * dy + zz * dz
    for leg in carrying:
        tip = tips[leg]
        tip[0] += dx
        tip[1] += dy
        tip[2] += dz
    return True


def _glide_turning(q: Configuration, support: Support, motions: Sequence[FootMotion]) -> bool:
    """The same for a level body that turns: one rotation fits all carrying feet."""
    body = q.body
    tips = q.tips
    feet = q.feet
    carrying = q.carrying
    dz = motions[carrying[0]][2]
    if body[3] != 0.0 or body[4] != 0.0:
        return False
    if any(not -SAME < motions[leg][2] - dz < SAME for leg in carrying):
        return False
    reached = [(tips[leg][0] + motions[leg][0], tips[leg][1] + motions[leg][1]) for leg in carrying]
    x, y, yaw = plane_fit([feet[leg] for leg in carrying], reached, body[5])
    c, s = direction(yaw)
    for leg, (qx, qy) in zip(carrying, reached, strict=True):
        if abs(x + c * qx - s * qy - feet[leg][0]) > STIFF:
            return False
        if abs(y + s * qx + c * qy - feet[leg][1]) > STIFF:
            return False
    if any(nx * x + ny * y < offset for nx, ny, offset in support.edges):
        return False
    if q.contact.crowds(x, y) and q.bumps(x, y, yaw):
        return False
    body[0], body[1], body[5] = x, y, yaw
    body[2] -= dz
    q.rotation = (c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
    for leg in carrying:
        ax, ay = feet[leg][0] - x, feet[leg][1] - y
        tips[leg][:] = c * ax + s * ay, c * ay - s * ax, tips[leg][2] + dz
    return True
