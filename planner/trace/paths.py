"""Traces: the curve {ξ(s), η(s), β(s)} the body is to follow (K "motion trace"), sampled at equal
steps of s.

Every kind is drawn finely by a formula of its own parameter and then resampled by s, ds² = dξ² +
dη² + (ρ dβ)²; the chords between samples stay within a tenth of a millimetre of the curve for radii
over 0.2 m. A joystick's trace is the constant curvature from where the machine stands; it is drawn
again, longer, as the machine walks on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..geometry.paths import SampledPath, arc_of_command
from ..geometry.transforms import Pose, direction, directions
from ..robot.model import Machine
from ..types import Array

STEP = 0.01  # m of s between samples; coarser costs up to this much of every existence segment
FINE = 0.002  # m, the drawing step before resampling by s
JOYSTICK_AHEAD = 4.0  # m of s a joystick's trace reaches ahead of the machine
LENGTH_MAX = 2000.0  # m of s; a longer trace takes seconds to draw and to look along
KINDS = ("waypoints", "line", "circle", "sine", "spiral", "turn", "sideways")
YAWS = ("tangent", "fixed")
SPLINE_YAW_LENGTH = 0.5  # m/rad, only spreads the parameter of the spline through waypoints


class TraceError(ValueError):
    """A trace that cannot be drawn; says what was expected and what came."""


def resample(x: Array, y: Array, yaw: Array, yaw_length: float, step: float = STEP) -> SampledPath:
    """The polyline at equal steps of s; ``yaw`` continuous, not wrapped."""
    ds = np.sqrt(np.diff(x) ** 2 + np.diff(y) ** 2 + (yaw_length * np.diff(yaw)) ** 2)
    s = np.concatenate([[0.0], np.cumsum(ds)])
    if not s[-1] <= LENGTH_MAX:
        raise TraceError(f"a trace may be {LENGTH_MAX:g} m long, this one has {s[-1]:g} m")
    count = max(int(math.floor(s[-1] / step + 1e-6)), 1)
    at = np.arange(count + 1) * step
    along = [np.asarray(np.interp(at, s, values), dtype=np.float64) for values in (x, y, yaw)]
    return SampledPath(step, along[0], along[1], along[2])


def trace_from(
    spec: Mapping[str, Any], yaw_length: float, start: Pose = (0.0, 0.0, 0.0), step: float = STEP
) -> SampledPath:
    """A scenario's ``[trace]`` as a sampled course that begins at ``start``; raises ``TraceError``.

    ``kind`` and, with their defaults: line (length 5, direction_deg 0), sideways (length 3,
    direction_deg 90), circle (radius 1.5, angle_deg 360), sine (amplitude 0.6, wavelength scale
    ``length`` 1, ``distance`` 8 along x), spiral (radius 2, radius_end 0.8, angle_deg 540), turn
    (angle_deg 360), waypoints ([[x, y, yaw°], ...]). ``yaw`` is "tangent" or "fixed"; waypoints
    with "fixed" take their own yaws, splined. Positive angles are to the left.
    """
    kind = spec.get("kind")
    if kind not in _DRAW:
        raise TraceError(f"unknown trace kind {kind!r}; there are: {', '.join(KINDS)}")
    mode = spec.get("yaw", "fixed" if kind in ("line", "sine", "sideways") else "tangent")
    if mode not in YAWS:
        raise TraceError(f"unknown trace yaw {mode!r}; there are: {', '.join(YAWS)}")
    x, y, yaw = _DRAW[kind](spec, mode)
    x0, y0, yaw0 = start
    c, d = direction(yaw0)
    return resample(x0 + c * x - d * y, y0 + d * x + c * y, yaw + yaw0, yaw_length, step)


def step_for(machine: Machine) -> float:
    """Metres of s between samples for a machine of this size."""
    return min(STEP, machine.torso[0] / 100)


def trace_for(
    spec: Mapping[str, Any], machine: Machine, start: Pose = (0.0, 0.0, 0.0)
) -> SampledPath:
    """A scenario's ``[trace]`` for this machine, from its start pose on."""
    return trace_from(spec, machine.yaw_length, start, step_for(machine))


def joystick_trace(
    start: Pose,
    crab_angle: float,
    speed: float,
    turn_rate: float,
    yaw_length: float,
    ahead: float = JOYSTICK_AHEAD,
    step: float = STEP,
) -> SampledPath:
    """The trace of a held joystick: the course of constant curvature from ``start`` (gait-spec §10)."""
    arc, _ = arc_of_command(crab_angle, speed, turn_rate, yaw_length)
    s = np.arange(round(ahead / step) + 1) * step
    angle = arc.turn * s
    sine: Array = s * np.sinc(angle / math.pi)  # sin(angle)/turn, also at turn 0
    versine: Array = s * np.sin(angle / 2) * np.sinc(angle / (2 * math.pi))  # (1 - cos(angle))/turn
    dx = arc.ux * sine - arc.uy * versine
    dy = arc.ux * versine + arc.uy * sine
    x0, y0, yaw0 = start
    c, d = direction(yaw0)
    yaw: Array = np.asarray(yaw0 + angle, dtype=np.float64)
    return SampledPath(step, x0 + c * dx - d * dy, y0 + d * dx + c * dy, yaw)


# one drawing function a kind: spec, yaw mode -> x, y, yaw, finely, from (0, 0, 0) on


def _number(spec: Mapping[str, Any], key: str, default: float, low: float, high: float) -> float:
    value = spec.get(key)
    if value is None:
        return default
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise TraceError(f"trace {key} must be a number from {low:g} to {high:g}, got {value!r}")
    return float(value)


def _follow(x: Array, y: Array, mode: str) -> tuple[Array, Array, Array]:
    """Yaw along the tangent, turned so that the trace begins straight ahead, or fixed."""
    if mode == "fixed":
        return x, y, np.zeros_like(x)
    tangent = np.unwrap(np.arctan2(np.gradient(y), np.gradient(x)))
    c, d = direction(tangent[0])
    return c * x + d * y, c * y - d * x, tangent - tangent[0]


def _fine(length: float) -> Array:
    if not abs(length) <= LENGTH_MAX:
        raise TraceError(
            f"a trace may be {LENGTH_MAX:g} m long, this one would have {abs(length):g} m"
        )
    return np.linspace(0.0, length, max(int(abs(length) / FINE), 2) + 1)


def _line(
    spec: Mapping[str, Any], mode: str, default_length: float = 5.0, default_deg: float = 0.0
) -> tuple[Array, Array, Array]:
    u = _fine(_number(spec, "length", default_length, 0.1, 1000.0))
    heading = math.radians(_number(spec, "direction_deg", default_deg, -180.0, 180.0))
    ux, uy = direction(heading)
    return _follow(u * ux, u * uy, mode)


def _sideways(spec: Mapping[str, Any], mode: str) -> tuple[Array, Array, Array]:
    return _line(spec, "fixed", 3.0, 90.0)


def _circle(spec: Mapping[str, Any], mode: str) -> tuple[Array, Array, Array]:
    radius = _number(spec, "radius", 1.5, 0.05, 100.0)
    angle = math.radians(_number(spec, "angle_deg", 360.0, -36000.0, 36000.0))
    return _spun(radius, radius, angle, mode)


def _spiral(spec: Mapping[str, Any], mode: str) -> tuple[Array, Array, Array]:
    radius = _number(spec, "radius", 2.0, 0.05, 100.0)
    end = _number(spec, "radius_end", 0.8, 0.05, 100.0)
    return _spun(
        radius, end, math.radians(_number(spec, "angle_deg", 540.0, -36000.0, 36000.0)), mode
    )


def _spun(radius: float, end: float, angle: float, mode: str) -> tuple[Array, Array, Array]:
    """Heading turns by ``angle`` while the radius of curvature goes from ``radius`` to ``end``."""
    if angle == 0.0:
        raise TraceError("trace angle_deg must not be 0")
    heading = _fine(angle * max(radius, end)) / max(radius, end)
    bend = radius + (end - radius) * heading / angle
    ds = np.abs(np.diff(heading)) * (bend[1:] + bend[:-1]) / 2
    mid = (heading[1:] + heading[:-1]) / 2
    ux, uy = directions(mid)
    x = np.concatenate([[0.0], np.cumsum(ds * ux)])
    y = np.concatenate([[0.0], np.cumsum(ds * uy)])
    return x, y, heading if mode == "tangent" else np.zeros_like(x)


def _sine(spec: Mapping[str, Any], mode: str) -> tuple[Array, Array, Array]:
    """y = amplitude · sin(x / length): K's trace of varying curvature."""
    amplitude = _number(spec, "amplitude", 0.6, -100.0, 100.0)
    scale = _number(spec, "length", 1.0, 0.1, 100.0)
    x = _fine(_number(spec, "distance", 8.0, 0.1, 1000.0))
    return _follow(x, amplitude * np.sin(x / scale), mode)


def _turn(spec: Mapping[str, Any], mode: str) -> tuple[Array, Array, Array]:
    yaw = _fine(math.radians(_number(spec, "angle_deg", 360.0, -36000.0, 36000.0)))
    return np.zeros_like(yaw), np.zeros_like(yaw), yaw


def _waypoints(spec: Mapping[str, Any], mode: str) -> tuple[Array, Array, Array]:
    """A natural cubic spline through the points; x, y are relative to the start pose."""
    table = np.array(_waypoint_rows(spec.get("waypoints")))
    dx, dy, turn = np.diff(table, axis=0).T
    gaps = np.sqrt(dx**2 + dy**2 + (SPLINE_YAW_LENGTH * turn) ** 2)
    if float(gaps.min()) < 1e-6:
        raise TraceError("two successive waypoints are the same")
    knots = np.concatenate([[0.0], np.cumsum(gaps)])
    at = _fine(float(knots[-1]))
    x, y, yaw = (_spline(knots, table[:, column], at) for column in range(3))
    if mode == "fixed":
        return x, y, yaw
    return x, y, np.unwrap(np.arctan2(np.gradient(y), np.gradient(x)))


def _waypoint_rows(points: Any) -> list[tuple[float, float, float]]:
    """Waypoints as x, y in m and yaw in rad, checked."""
    if not isinstance(points, Sequence) or len(points) < 2:
        raise TraceError(f"waypoints must be at least two [x, y, yaw_deg], got {points!r:.80}")
    rows = []
    for k, row in enumerate(points, 1):
        has_form = isinstance(row, Sequence) and len(row) in (2, 3)
        if not has_form or not all(_is_number(v) for v in row):
            raise TraceError(f"waypoint {k} must be [x, y] or [x, y, yaw_deg], got {row!r:.80}")
        yaw = math.radians(row[2]) if len(row) == 3 else 0.0
        rows.append((float(row[0]), float(row[1]), yaw))
    return rows


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _spline(knots: Array, values: Array, at: Array) -> Array:
    """Natural cubic spline: second derivatives from one tridiagonal system."""
    n = len(knots)
    h = np.diff(knots)
    system = np.eye(n)
    right = np.zeros(n)
    for k in range(1, n - 1):
        system[k, k - 1 : k + 2] = [h[k - 1] / 6, (h[k - 1] + h[k]) / 3, h[k] / 6]
        right[k] = (values[k + 1] - values[k]) / h[k] - (values[k] - values[k - 1]) / h[k - 1]
    bend = np.linalg.solve(system, right)
    j = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, n - 2)
    a = (knots[j + 1] - at) / h[j]
    b = (at - knots[j]) / h[j]
    return np.asarray(
        a * values[j]
        + b * values[j + 1]
        + ((a**3 - a) * bend[j] + (b**3 - b) * bend[j + 1]) * h[j] ** 2 / 6
    )


_DRAW: dict[str, Callable[[Mapping[str, Any], str], tuple[Array, Array, Array]]] = {
    "waypoints": _waypoints,
    "line": _line,
    "circle": _circle,
    "sine": _sine,
    "spiral": _spiral,
    "turn": _turn,
    "sideways": _sideways,
}
