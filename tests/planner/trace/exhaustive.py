"""An exhaustive search over small fields, to hold the planner against: no order, no heuristics, no
bit masks, no bound.

Same constraints as the planner on the trace itself: footholds at cell centres inside the reach
rectangle, the centre of gravity MARGIN inside the polygon, three feet down, feet two radii apart,
the body anywhere between the ends of the trace.
"""

from __future__ import annotations

import math
from collections import deque
from functools import cache

from walking_console.planner.geometry.paths import EDGE, SampledPath
from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import polygon_margin, support_polygon
from walking_console.planner.terrain.map import TerrainMap

MARGIN = 0.01
Feet = tuple[tuple[float, float] | None, ...]


def farthest_reachable(
    machine: Machine, terrain: TerrainMap, course: SampledPath, start: Feet
) -> int:
    """The farthest sample any sequence of lifting, placing and moving along the trace can bring the
    body to.
    """
    poses = [
        (float(x), float(y), float(yaw))
        for x, y, yaw in zip(course.x, course.y, course.yaw, strict=True)
    ]
    cells = [
        terrain.centre(row, column)
        for row in range(terrain.rows)
        for column in range(terrain.columns)
        if not terrain.forbidden[row, column]
    ]

    @cache
    def in_reach(leg: int, foot: tuple[float, float]) -> frozenset[int]:
        low_x, high_x, low_y, high_y = machine.legs[leg].box
        found = set()
        for k, (x, y, yaw) in enumerate(poses):
            c, d = math.cos(yaw), math.sin(yaw)
            bx, by = c * (foot[0] - x) + d * (foot[1] - y), c * (foot[1] - y) - d * (foot[0] - x)
            if low_x - EDGE <= bx <= high_x + EDGE and low_y - EDGE <= by <= high_y + EDGE:
                found.add(k)
        return frozenset(found)

    @cache
    def carries(feet: frozenset[tuple[float, float]]) -> frozenset[int]:
        polygon = support_polygon(feet)
        return frozenset(
            k for k, (x, y, _) in enumerate(poses) if polygon_margin(polygon, x, y) >= MARGIN - EDGE
        )

    @cache
    def valid(feet: Feet) -> frozenset[int]:
        standing = [(leg, foot) for leg, foot in enumerate(feet) if foot is not None]
        if len(standing) < 3:
            return frozenset()
        for a, (_, p) in enumerate(standing):
            if any(
                math.hypot(p[0] - q[0], p[1] - q[1]) < 2 * machine.foot_radius - EDGE
                for _, q in standing[:a]
            ):
                return frozenset()
        return carries(frozenset(foot for _, foot in standing)).intersection(
            *(in_reach(leg, foot) for leg, foot in standing)
        )

    usable = [
        [cell for cell in {*cells, *([start[leg]] if start[leg] else [])} if in_reach(leg, cell)]
        for leg in range(len(machine.legs))
    ]
    first = (start, _run(valid(start), 0))
    seen, queue, most = {first}, deque([first]), 0
    while queue:
        feet, run = queue.popleft()
        most = max(most, *run)
        for leg, foot in enumerate(feet):
            changes: list[tuple[float, float] | None] = (
                list(usable[leg]) if foot is None else [None]
            )
            for new in changes:
                after = (*feet[:leg], new, *feet[leg + 1 :])
                there = valid(after)
                rest = run & there
                while rest:
                    part = _run(there, next(iter(rest)))
                    rest = rest - part
                    if (after, part) not in seen:
                        seen.add((after, part))
                        queue.append((after, part))
    return most


def _run(samples: frozenset[int], k: int) -> frozenset[int]:
    """The unbroken run of samples around k; just k when it is not even among them."""
    low = high = k
    while low - 1 in samples:
        low -= 1
    while high + 1 in samples:
        high += 1
    return frozenset(range(low, high + 1))
