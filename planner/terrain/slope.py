"""The slope of the ground under a walker: the plane through what is known of it, blocks and pits
left out.

Gradients are metres per metre along absolute x and y.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..geometry.transforms import XY, Pose, direction, left_fold_sum, placed
from ..robot.model import Machine
from ..types import Command, Point, Stance
from .map import TerrainMap

AHEAD = 0.43  # of the reach ahead of the body, the middle of the ground that counts as the slope
SAMPLES = 5  # of the ground, along and across
OUTLIER = 0.4  # of z* from the plane; farther is a block, a pole or a pit and no slope
ENOUGH = 8  # samples that make a slope; fewer: the feet alone

NO_SLOPE: XY = (0.0, 0.0)


def slope_under(stance: Stance, command: Command, terrain: TerrainMap, machine: Machine) -> XY:
    """Gradient of the plane through the ground under and ahead of the machine; level where the map
    is.

    Holes, blocks and what is unknown do not count.
    """
    if terrain.is_level:
        return NO_SLOPE
    x, y, _, yaw = stance.body
    ux, uy = direction(yaw + command.crab_angle)
    ahead = AHEAD * max(box[1] for box in machine.boxes) if command.speed > 0.0 else 0.0
    known = terrain.known
    points = [*stance.feet]
    for px, py in _samples(machine, (x + ahead * ux, y + ahead * uy, yaw)):
        flat = terrain.index(px, py)
        if flat >= 0 and (known is None or known.flat[flat]):
            points.append((px, py, terrain.height_at(px, py)))
    return plane_of(points, len(stance.feet), _even(machine))


def slope_at(machine: Machine, pose: Pose, height_at: Callable[[float, float], float]) -> XY:
    """Gradient of the plane through the ground a machine is to be set down on."""
    points = [(px, py, height_at(px, py)) for px, py in _samples(machine, pose)]
    return plane_of(points, 0, _even(machine))


def _samples(machine: Machine, pose: Pose) -> list[XY]:
    """Places evenly spread over the rectangle of all reaches."""
    half_x = max(box[1] for box in machine.boxes)
    half_y = max(box[3] for box in machine.boxes)
    shares = [2 * k / (SAMPLES - 1) - 1 for k in range(SAMPLES)]
    return [placed(pose, u * half_x, v * half_y) for u in shares for v in shares]


def _even(machine: Machine) -> float:
    low, high = machine.z_range
    return OUTLIER * (high - low)


def plane_of(points: Sequence[Point], feet: int, even: float) -> XY:
    """Gradient of the plane through points of the ground within ``even`` m of it; of the first
    ``feet`` alone where few are left.
    """
    solid = [point for point in points if point[2] == point[2]]
    plane = _plane(solid)
    if plane is not None:
        gx, gy, z, mx, my = plane
        near = [p for p in solid if abs(p[2] - z - gx * (p[0] - mx) - gy * (p[1] - my)) <= even]
        if len(near) < len(solid):
            plane = _plane(near) if len(near) >= ENOUGH else _plane(points[:feet])
    return NO_SLOPE if plane is None else (plane[0], plane[1])


def _plane(points: Sequence[Point]) -> tuple[float, float, float, float, float] | None:
    """Least squares: gradient along x and y, and the middle the plane goes through as z, x, y. None
    when the points do not span one.
    """
    n = len(points)
    if n < 3:
        return None
    mx, my, mz = (left_fold_sum(p[axis] for p in points) / n for axis in range(3))
    xx = xy = yy = xz = yz = 0.0
    for px, py, pz in points:
        dx = px - mx
        dy = py - my
        dz = pz - mz
        xx += dx * dx
        xy += dx * dy
        yy += dy * dy
        xz += dx * dz
        yz += dy * dz
    det = xx * yy - xy * xy
    if det < 1e-9:
        return None
    return (xz * yy - yz * xy) / det, (yz * xx - xz * xy) / det, mz, mx, my
