"""The ground of a run in its ``terrain.npz``, to the last bit: a run needs no other file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from walking_console.planner.types import Array
from walking_console.sim.perception import Perception
from walking_console.sim.terrain.generators import Obstacle
from walking_console.sim.terrain.ground import HEIGHT_MAX, Ground, GroundError

from .wide_record import Arrays, wide_arrays, wide_ground

OBSTACLE_NUMBERS = 5  # x, y, base, top, radius


def ground_arrays(begun_on: Ground, perception: Perception) -> Arrays:
    """What is kept of the ground, as it is at the end and as it is believed to be then, and
    whatever else it takes to have the ground a walk was ``begun_on`` again.

    ``obstacles`` (k, 5) are x, y, base, top, radius, and ``obstacle_corners`` (k, c, 2) the corners
    of those that have some.
    """
    if perception.wide is None or begun_on.whole is None:
        arrays = {
            **_height_arrays(begun_on, perception.ground.heights),
            "forbidden": perception.true_forbidden,
            "believed_heights": perception.belief.heights.astype(np.float32),
            "believed_forbidden": perception.belief.forbidden,
        }
    else:
        arrays = wide_arrays(begun_on.whole, perception, perception.wide)
    if begun_on.obstacles:
        arrays |= _obstacle_arrays(begun_on.obstacles)
    return arrays


def _height_arrays(begun_on: Ground, heights: Array) -> Arrays:
    """``heights`` at the end as float32 for readers, and how they were before the walk.

    ``start_heights`` (float64) is there only where ``heights`` does not say it exactly.
    """
    rounded = heights.astype(np.float32)
    arrays: Arrays = {
        "heights": rounded,
        "cell": np.array(begun_on.cell),
        "origin": np.array(begun_on.origin),
    }
    if not np.array_equal(rounded.astype(np.float64), begun_on.heights, equal_nan=True):
        arrays["start_heights"] = begun_on.heights
    return arrays


def _obstacle_arrays(obstacles: tuple[Obstacle, ...]) -> Arrays:
    numbers = [[o.x, o.y, o.base, o.top, o.radius] for o in obstacles]
    most = max(len(obstacle.corners) for obstacle in obstacles)
    corners = np.full((len(obstacles), most, 2), np.nan)
    for k, obstacle in enumerate(obstacles):
        for c, corner in enumerate(obstacle.corners):
            corners[k, c] = corner
    return {"obstacles": np.array(numbers), "obstacle_corners": corners}


def ground_from(arrays: Arrays, kind: str, final: bool) -> Ground:
    """The ground a walk was begun on; raises ``GroundError`` for arrays that are none."""
    heights = arrays.get("start_heights", arrays["heights"]).astype(np.float64)
    cell = float(arrays["cell"])
    origin = arrays["origin"]
    if heights.ndim != 2 or heights.shape != arrays["heights"].shape:
        raise GroundError(f"start_heights must have the shape of heights, got {heights.shape}")
    if np.isinf(heights).any() or np.nanmax(np.abs(heights), initial=0.0) > HEIGHT_MAX:
        raise GroundError(f"heights must be within {HEIGHT_MAX:g} m of 0, or NaN")
    if not cell > 0.0 or origin.shape != (2,) or not np.isfinite(origin).all():
        raise GroundError(f"cell must be positive and origin x and y, got {cell!r}, {origin!r:.60}")
    if "place" in arrays:
        return replace(wide_ground(arrays, heights, kind, final), obstacles=_obstacles(arrays))
    at = float(origin[0]), float(origin[1])
    return Ground(heights, cell, at, kind, final, _obstacles(arrays))


def _obstacles(arrays: Arrays) -> tuple[Obstacle, ...]:
    numbers = arrays.get("obstacles")
    if numbers is None:
        return ()
    corners = arrays.get("obstacle_corners")
    if numbers.ndim != 2 or numbers.shape[1] != OBSTACLE_NUMBERS or corners is None:
        raise GroundError(f"obstacles must be (k, {OBSTACLE_NUMBERS}) with corners of their own")
    if corners.ndim != 3 or corners.shape[::2] != (len(numbers), 2):
        raise GroundError(f"obstacle_corners must be ({len(numbers)}, c, 2), got {corners.shape}")
    found = []
    for row, points in zip(numbers.tolist(), corners.tolist(), strict=True):
        x, y, base, top, radius = row
        there = tuple((px, py) for px, py in points if px == px)
        found.append(Obstacle(x, y, base, top, radius, there))
    return tuple(found)
