"""How a stiff body lies on its feet: turning it, fitting it to feet that stay where they are,
resting it on them.

Attitude is roll about x, then pitch about y, then yaw about z, right-handed; rotations are nine
floats, row by row, from body axes to absolute ones. Plain floats: the plant calls these only when
something else than a common walking tick happens.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

from walking_console.planner.geometry import transforms
from walking_console.planner.geometry.transforms import direction, turned_back

Rotation = tuple[float, float, float, float, float, float, float, float, float]

FLAT = 1e-9  # m²; three feet that span less are in one line
SAME_YAW = 1e-13  # rad; a body that turns by less does not turn
ON_EDGE = 1e-9  # of a facet; a point this little outside it is on it
LYING = 2.0  # one over the cosine of a lean that is no standing any more
TIE = 1e-12  # m; two ways to rest that differ by less are the same height


def rotation(roll: float, pitch: float, yaw: float) -> Rotation:
    """Body axes to absolute axes."""
    along_x, along_y, along_z = transforms.rotation(roll, pitch, yaw)
    return (*along_x, *along_y, *along_z)


def angles(r: Rotation) -> tuple[float, float, float]:
    """Roll, pitch, yaw of a rotation."""
    return math.atan2(r[7], r[8]), math.asin(max(-1.0, min(1.0, -r[6]))), math.atan2(r[3], r[0])


def turned(r: Rotation, x: float, y: float, z: float) -> tuple[float, float, float]:
    """From body axes to absolute axes."""
    return (
        r[0] * x + r[1] * y + r[2] * z,
        r[3] * x + r[4] * y + r[5] * z,
        r[6] * x + r[7] * y + r[8] * z,
    )


def unturned(r: Rotation, x: float, y: float, z: float) -> tuple[float, float, float]:
    """From absolute axes to body axes."""
    return (
        r[0] * x + r[3] * y + r[6] * z,
        r[1] * x + r[4] * y + r[7] * z,
        r[2] * x + r[5] * y + r[8] * z,
    )


def about(axis: Sequence[float], angle: float) -> Rotation:
    """Rotation by ``angle`` about a unit vector (Rodrigues)."""
    x, y, z = axis
    c, s = direction(angle)
    v = 1.0 - c
    return (
        c + x * x * v, x * y * v - z * s, x * z * v + y * s,
        y * x * v + z * s, c + y * y * v, y * z * v - x * s,
        z * x * v - y * s, z * y * v + x * s, c + z * z * v,
    )  # fmt: skip


def after(a: Rotation, b: Rotation) -> Rotation:
    """First b, then a."""
    along_x = _row_times(a[0], a[1], a[2], b)
    along_y = _row_times(a[3], a[4], a[5], b)
    return (*along_x, *along_y, *_row_times(a[6], a[7], a[8], b))


def _row_times(x: float, y: float, z: float, r: Rotation) -> tuple[float, float, float]:
    return (
        x * r[0] + y * r[3] + z * r[6],
        x * r[1] + y * r[4] + z * r[7],
        x * r[2] + y * r[5] + z * r[8],
    )


def plane_fit(
    feet: Sequence[Sequence[float]], reached: Sequence[Sequence[float]], heading: float
) -> tuple[float, float, float]:
    """x, y, yaw of the body that lays ``reached`` (horizontal, in the body's heading) on ``feet``
    (absolute), least squares.

    The yaw is the one nearest to ``heading``: it does not jump at ±π.
    """
    fx, fy = centroid(feet)
    qx, qy = centroid(reached)
    across = along = 0.0
    for f, q in zip(feet, reached, strict=True):
        ax, ay = q[0] - qx, q[1] - qy
        bx, by = f[0] - fx, f[1] - fy
        across += ax * by - ay * bx
        along += ax * bx + ay * by
    c, s = direction(heading)
    change = math.atan2(c * across - s * along, c * along + s * across)
    yaw = heading + change if abs(change) > SAME_YAW else heading
    c, s = direction(yaw)
    return fx - (c * qx - s * qy), fy - (s * qx + c * qy), yaw


def centroid(points: Sequence[Sequence[float]]) -> tuple[float, float]:
    """x, y of the middle of points, added up in their order."""
    x = y = 0.0
    for point in points:
        x += point[0]
        y += point[1]
    return x / len(points), y / len(points)


class Rest(NamedTuple):
    """A body at rest on its feet: its height, and how far its upward axis leans along absolute x
    and y for each metre up.
    """

    z: float
    lean_x: float
    lean_y: float


def rest(
    feet: Sequence[Sequence[float]], lengths: Sequence[float], x: float, y: float, now: Rest
) -> Rest | None:
    """The body on the upper hull of its feet: the lowest it can be at (0, 0) with no foot below the
    ground.

    ``feet`` are x, y from the centre of gravity and the ground under them; ``lengths`` the feet's z
    in body axes; (x, y) the point that has to be carried, the centre of gravity or the nearest one
    inside. None when no three feet carry it. Among ways to rest that are equally high (more than
    three feet in one plane, or the point above a diagonal) the one nearest to ``now`` is taken.
    """
    stretch = math.sqrt(1.0 + now.lean_x**2 + now.lean_y**2)
    found: Rest | None = None
    for _ in range(100):  # three in practice; a leaning body takes more
        points = [
            (f[0], f[1], f[2] - stretch * length) for f, length in zip(feet, lengths, strict=True)
        ]
        found = _upper_facet(points, x, y, now)
        if found is None:
            return None
        before = stretch
        stretch = math.sqrt(1.0 + found.lean_x**2 + found.lean_y**2)
        if abs(stretch - before) < 1e-14 or stretch > LYING:
            break
    return found


def _upper_facet(
    points: Sequence[tuple[float, float, float]], x: float, y: float, now: Rest
) -> Rest | None:
    """The plane of the facet above (x, y) of the points' upper hull, as its height at (0, 0) and
    its lean.
    """
    best: Rest | None = None
    top = change = 0.0
    for (ax, ay, az), (bx, by, bz), (cx, cy, cz) in combinations(points, 3):
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if abs(area) < FLAT:
            continue
        v = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area
        w = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area
        if v < -ON_EDGE or w < -ON_EDGE or v + w > 1.0 + ON_EDGE:
            continue
        slope_x = ((bz - az) * (cy - ay) - (cz - az) * (by - ay)) / area
        slope_y = ((bx - ax) * (cz - az) - (cx - ax) * (bz - az)) / area
        height = az + v * (bz - az) + w * (cz - az)
        turn = abs(slope_x + now.lean_x) + abs(slope_y + now.lean_y)
        if best is None or height > top + TIE or (height > top - TIE and turn < change):
            best = Rest(az - slope_x * ax - slope_y * ay, -slope_x, -slope_y)
            top = height
            change = turn
    return best


def attitude(lean_x: float, lean_y: float, yaw: float) -> tuple[float, float]:
    """Roll and pitch of a body of this yaw whose upward axis leans like this."""
    length = math.sqrt(1.0 + lean_x * lean_x + lean_y * lean_y)
    ahead, left = turned_back(lean_x, lean_y, yaw)
    return -math.asin(left / length), math.atan2(ahead / length, 1.0 / length)


def lean(r: Rotation) -> tuple[float, float]:
    """How a rotation's upward axis leans, along absolute x and y for each metre up."""
    return r[2] / r[8], r[5] / r[8]


def nearest_inside(
    polygon: Sequence[tuple[float, float]], x: float, y: float
) -> tuple[float, float]:
    """(x, y) itself when it is inside a counter-clockwise polygon, else the nearest point of the
    edge it is furthest beyond.
    """
    worst = 0.0
    found = x, y
    for (ax, ay), (bx, by) in zip(polygon, (*polygon[1:], *polygon[:1]), strict=True):
        ex, ey = bx - ax, by - ay
        length = math.hypot(ex, ey)
        beyond = (ey * (x - ax) - ex * (y - ay)) / length
        if beyond > worst:
            share = max(0.0, min(1.0, ((x - ax) * ex + (y - ay) * ey) / (length * length)))
            worst = beyond
            found = ax + share * ex, ay + share * ey
    return found
