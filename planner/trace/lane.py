"""The body's poses along a window of a trace, and beside it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..geometry.paths import SampledPath
from ..geometry.transforms import directions
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import Array, Gait, Stance

JOIN = 0.3  # body lengths over which a body beside its trace comes back to it
# body lengths the body may leave the trace sideways, only where on it there is no way: 0.10 m for a
# body of 1.6 m
ASIDE = 1 / 16
ASIDE_TURNING = 0.04  # m at most while turning on the spot
# rows of the wide search, in parts of ASIDE; the trace itself first
ROWS = (0.0, 0.5, -0.5, 1.0, -1.0)
LOOKS = 7  # places along and across the body whose ground its height is the mean of


class Lane(NamedTuple):
    """The body's poses over the window: row r is the trace moved sideways by offset r; row 0 is the
    trace itself. Absolute frame, m and rad.
    """

    x: Array  # (rows, count)
    y: Array
    yaw: Array  # (count,), the same in every row
    z: Array  # (count,), height of the centre of gravity


class TraceWindow(NamedTuple):
    """The part of a trace that is looked along, as sample numbers of the trace."""

    first: int
    last: int
    now: int  # where the body is


def lane_along(
    trace: SampledPath,
    window: TraceWindow,
    stance: Stance,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    aside: float,
) -> Lane:
    """The body's poses: through where it is now, back to the trace over JOIN, and beside it up to
    ``aside`` m in every row.
    """
    part = slice(window.first, window.last + 1)
    x = trace.x[part].copy()
    y = trace.y[part].copy()
    yaw = trace.yaw[part].copy()
    across_x, across_y, moving = across(x, y, yaw)
    away = np.abs(np.arange(window.first, window.last + 1) - window.now) * trace.step
    fade = np.clip(1.0 - away / (JOIN * machine.torso[0]), 0.0, 1.0)
    off_x, off_y, off_yaw, turns = _off_trace(trace, window.now, stance)
    x = x + fade * off_x
    y = y + fade * off_y
    yaw = yaw + fade * off_yaw + turns
    z = body_heights(x, y, terrain, machine, gait)
    z = z + fade * (stance.body[2] - z[window.now - window.first])
    if aside == 0.0:
        return Lane(x[None, :], y[None, :], yaw, z)
    width = aside if moving else min(aside, ASIDE_TURNING)
    beside = fade * (off_x * across_x + off_y * across_y)
    rows = [
        np.clip(beside + share * width, -width, width) - beside if share else np.zeros_like(x)
        for share in ROWS
    ]
    xs = np.stack([x + row * across_x for row in rows])
    ys = np.stack([y + row * across_y for row in rows])
    return Lane(xs, ys, yaw, z)


def across(x: Array, y: Array, yaw: Array) -> tuple[Array, Array, bool]:
    """The unit vectors to the left of a way, the body's own left where it does not move; and
    whether it mostly does.
    """
    if len(x) > 1:
        tx = np.gradient(x)
        ty = np.gradient(y)
    else:
        tx = np.zeros_like(x)
        ty = np.zeros_like(y)
    size = np.hypot(tx, ty)
    moving = size > 1e-6
    safe = np.where(moving, size, 1.0)
    c, s = directions(yaw)
    across_x = np.where(moving, -ty / safe, -s)
    across_y = np.where(moving, tx / safe, c)
    return across_x, across_y, bool(moving.mean() > 0.5)


def _off_trace(trace: SampledPath, now: int, stance: Stance) -> tuple[float, float, float, float]:
    """How far the body is from its sample: along x and y, in yaw, and whole turns between the
    trace's count and the body's.
    """
    x, y, _, yaw = stance.body
    off_yaw = math.remainder(yaw - trace.yaw[now], 2 * math.pi)
    turns = yaw - off_yaw - trace.yaw[now]
    return x - trace.x[now], y - trace.y[now], off_yaw, turns


def body_heights(x: Array, y: Array, terrain: TerrainMap, machine: Machine, gait: Gait) -> Array:
    """Height of the centre of gravity at places x, y (n,): H above the mean of the ground under the
    body, m; over holes as between the ground beside them.
    """
    if terrain.is_level:
        return np.full(len(x), terrain.highest + gait.height)
    length = machine.torso[0]
    grid = np.linspace(-length / 2, length / 2, LOOKS)
    table = np.array([terrain.heights_at(x + gx, y + gy) for gx in grid for gy in grid])
    solid = np.isfinite(table)
    count = solid.sum(axis=0)
    total = np.where(solid, table, 0.0).sum(axis=0)
    mean = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    known = np.isfinite(mean)
    if not known.any():
        return np.full(len(x), gait.height)
    mean = np.interp(np.arange(len(x)), np.nonzero(known)[0], mean[known])
    return np.asarray(mean + gait.height)
