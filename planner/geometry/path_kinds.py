"""The kinds of path a body can be given: parameters with limits and defaults, shape and extent,
one class a kind.

A path is {x(s), y(s), yaw(s)} (K "motion trace": ξ, η, β). Every kind is drawn finely by a formula
of its own parameter, from (0, 0, 0) on, and then sampled at equal steps of s, ds² = dx² + dy² +
(ρ dyaw)²; the chords between samples stay within a tenth of a millimetre of the curve for radii
over 0.2 m. Positive angles are to the left. This table is the only one: scenarios take names,
limits and defaults from it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, field, fields
from typing import Any, ClassVar

import numpy as np

from ..types import Array
from .paths import SampledPath
from .transforms import XY, Pose, direction, directions, turned_back

STEP = 0.01  # m of s between samples; coarser costs up to this much of every existence segment
FINE = 0.002  # m, the drawing step before sampling by s
LENGTH_MAX = 2000.0  # m of s; a longer path takes seconds to draw and to look along
SPLINE_YAW_LENGTH = 0.5  # m/rad, only spreads the parameter of the spline through waypoints
APART = 1e-6  # m; two waypoints nearer than this are the same
YAWS = ("tangent", "fixed")

Drawn = tuple[Array, Array, Array]  # x m, y m, yaw rad, finely


class TraceError(ValueError):
    """A path that cannot be drawn; says what was expected and what came."""


@dataclass(frozen=True)
class Limits:
    """What numbers a parameter takes; ``above`` excludes ``low`` itself."""

    low: float
    high: float
    above: bool = False

    def admit(self, value: object) -> bool:
        """True for a number within; a boolean is none."""
        if isinstance(value, bool) or not isinstance(value, int | float):
            return False
        return self.low <= value <= self.high and not (self.above and value == self.low)


@dataclass(frozen=True)
class Rows:
    """Limits of a list of points: how many there may be, and how many numbers in each."""

    count: tuple[int, int]
    numbers: tuple[int, int]
    each: Limits


def _number(default: float, low: float, high: float, *, above: bool = False) -> Any:
    return field(default=default, metadata={"limits": Limits(low, high, above)})


def _points(count: tuple[int, int], numbers: tuple[int, int], each: Limits) -> Any:
    return field(metadata={"limits": Rows(count, numbers, each)})


@dataclass(frozen=True, kw_only=True)
class GivenPath:
    """What every kind has. ``yaw``: the body looks along the path, or keeps its yaw.

    Raises ``TraceError`` for a parameter outside its limits.
    """

    kind: ClassVar[str]

    yaw: str = "tangent"  # tangent | fixed
    speed: float = _number(0.1, 0.0, 10.0, above=True)  # m/s along the path

    def __post_init__(self) -> None:
        if self.yaw not in YAWS:
            raise TraceError(f"unknown trace yaw {self.yaw!r}; there are: {', '.join(YAWS)}")
        for parameter in fields(self):
            limits = parameter.metadata.get("limits")
            value = getattr(self, parameter.name)
            if isinstance(limits, Limits) and not limits.admit(value):
                raise TraceError(
                    f"trace {parameter.name} must be a number from {limits.low:g} to "
                    f"{limits.high:g}, got {value!r}"
                )

    def draw(self) -> Drawn:
        """The path from (0, 0, 0) on, a point at least every 2 mm."""
        raise NotImplementedError

    def outline(self) -> list[XY]:
        """Points, in axes of the start pose, whose hull the path does not leave."""
        return [(0.0, 0.0)]


@dataclass(frozen=True, kw_only=True)
class WaypointPath(GivenPath):
    """A smooth curve through given poses: a natural cubic spline."""

    kind = "waypoints"

    # x m, y m, yaw deg
    waypoints: Sequence[Sequence[float]] = _points((2, 1000), (2, 3), Limits(-1000.0, 1000.0))

    def draw(self) -> Drawn:
        table = _table(self.waypoints)
        gaps = _lengths(table[:, 0], table[:, 1], table[:, 2], SPLINE_YAW_LENGTH)
        if float(gaps.min()) < APART:
            raise TraceError("two successive waypoints are the same")
        knots = np.concatenate([[0.0], np.cumsum(gaps)])
        at = _fine(float(knots[-1]))
        x, y, yaw = (_spline(knots, table[:, column], at) for column in range(3))
        if self.yaw == "fixed":
            return x, y, yaw
        return x, y, np.unwrap(np.arctan2(np.gradient(y), np.gradient(x)))

    def outline(self) -> list[XY]:
        xs = [0.0, *(point[0] for point in self.waypoints)]
        ys = [0.0, *(point[1] for point in self.waypoints)]
        # a spline swings out beyond its points
        swing = max(max(xs) - min(xs), max(ys) - min(ys)) / 4
        x_ends = min(xs) - swing, max(xs) + swing
        y_ends = min(ys) - swing, max(ys) + swing
        return [(x, y) for x in x_ends for y in y_ends]


@dataclass(frozen=True, kw_only=True)
class LinePath(GivenPath):
    """Straight on, or in another direction without turning."""

    kind = "line"

    yaw: str = "fixed"
    length: float = _number(5.0, 0.1, 1000.0)  # m
    direction_deg: float = _number(0.0, -180.0, 180.0)

    def draw(self) -> Drawn:
        u = _fine(self.length)
        c, s = direction(math.radians(self.direction_deg))
        return _follow(u * c, u * s, self.yaw)

    def outline(self) -> list[XY]:
        c, s = direction(0.0 if self.yaw == "tangent" else math.radians(self.direction_deg))
        return [(0.0, 0.0), (self.length * c, self.length * s)]


@dataclass(frozen=True, kw_only=True)
class SidewaysPath(LinePath):
    """Straight to one side; the body keeps its yaw."""

    kind = "sideways"

    length: float = _number(3.0, 0.1, 1000.0)  # m
    direction_deg: float = _number(90.0, -180.0, 180.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "yaw", "fixed")


@dataclass(frozen=True, kw_only=True)
class CirclePath(GivenPath):
    """Round a circle."""

    kind = "circle"

    radius: float = _number(1.5, 0.05, 100.0)  # m
    angle_deg: float = _number(360.0, -3600.0, 3600.0)

    def draw(self) -> Drawn:
        return _spun(self.radius, self.radius, self.angle_deg, self.yaw)

    def outline(self) -> list[XY]:
        return _square(2 * self.radius)


@dataclass(frozen=True, kw_only=True)
class SinePath(GivenPath):
    """y = amplitude * sin(x / length): K's path of varying curvature."""

    kind = "sine"

    yaw: str = "fixed"
    amplitude: float = _number(0.6, -100.0, 100.0)  # m
    length: float = _number(1.0, 0.1, 100.0)  # m
    distance: float = _number(8.0, 0.1, 1000.0)  # m along x

    def draw(self) -> Drawn:
        x = _fine(self.distance)
        return _follow(x, self.amplitude * np.sin(x / self.length), self.yaw)

    def outline(self) -> list[XY]:
        # along the tangent it begins straight ahead
        turn = math.atan(self.amplitude / self.length) if self.yaw == "tangent" else 0.0
        corners = [(x, y) for x in (0.0, self.distance) for y in (-self.amplitude, self.amplitude)]
        return [turned_back(x, y, turn) for x, y in corners]


@dataclass(frozen=True, kw_only=True)
class SpiralPath(GivenPath):
    """A curve whose radius goes evenly from one value to another."""

    kind = "spiral"

    radius: float = _number(2.0, 0.05, 100.0)  # m, at the start
    radius_end: float = _number(0.8, 0.05, 100.0)  # m
    angle_deg: float = _number(540.0, -3600.0, 3600.0)

    def draw(self) -> Drawn:
        return _spun(self.radius, self.radius_end, self.angle_deg, self.yaw)

    def outline(self) -> list[XY]:
        # it stays inside its widest circle of curvature
        return _square(2 * max(self.radius, self.radius_end))


@dataclass(frozen=True, kw_only=True)
class TurnPath(GivenPath):
    """On the spot."""

    kind = "turn"

    angle_deg: float = _number(360.0, -3600.0, 3600.0)

    def draw(self) -> Drawn:
        yaw = _fine(math.radians(self.angle_deg))
        return np.zeros_like(yaw), np.zeros_like(yaw), yaw


PATH_KINDS: dict[str, type[GivenPath]] = {
    kind.kind: kind
    for kind in (
        WaypointPath,
        LinePath,
        CirclePath,
        SinePath,
        SpiralPath,
        TurnPath,
        SidewaysPath,
    )
}


def path_from(spec: Mapping[str, Any]) -> GivenPath:
    """A scenario's ``[trace]`` table as a path; raises ``TraceError`` that says what there is."""
    given = {key: value for key, value in spec.items() if key != "kind" and value is not None}
    kind = PATH_KINDS.get(str(spec.get("kind")))
    if kind is None:
        known = ", ".join(PATH_KINDS)
        raise TraceError(f"unknown trace kind {spec.get('kind')!r}; there are: {known}")
    parameters = {parameter.name: parameter for parameter in fields(kind)}
    unknown = next((key for key in given if key not in parameters), None)
    if unknown is not None:
        raise TraceError(f"unknown key {unknown!r:.80}; there are: {', '.join(parameters)}")
    missing = next((name for name, p in parameters.items() if _missing(p, given)), None)
    if missing is not None:
        raise TraceError(f"trace {missing} is missing")
    return kind(**given)


def _missing(parameter: Field[Any], given: Mapping[str, Any]) -> bool:
    return parameter.default is MISSING and parameter.name not in given


def sampled(path: GivenPath, yaw_length: float, start: Pose, step: float = STEP) -> SampledPath:
    """A path at equal ``step`` metres of s, begun at a pose. Raises ``TraceError``."""
    x, y, yaw = path.draw()
    x0, y0, yaw0 = start
    c, s = direction(yaw0)
    return resampled(x0 + c * x - s * y, y0 + s * x + c * y, yaw + yaw0, yaw_length, step)


def resampled(x: Array, y: Array, yaw: Array, yaw_length: float, step: float = STEP) -> SampledPath:
    """The polyline at equal steps of s; ``yaw`` continuous, not wrapped. Raises ``TraceError``."""
    s = np.concatenate([[0.0], np.cumsum(_lengths(x, y, yaw, yaw_length))])
    if not s[-1] <= LENGTH_MAX:
        raise TraceError(f"a trace may be {LENGTH_MAX:g} m long, this one has {s[-1]:g} m")
    count = max(int(math.floor(s[-1] / step + 1e-6)), 1)
    at = np.arange(count + 1) * step
    along = [np.asarray(np.interp(at, s, values), dtype=np.float64) for values in (x, y, yaw)]
    return SampledPath(step, along[0], along[1], along[2])


# -- drawing


def _lengths(x: Array, y: Array, yaw: Array, yaw_length: float) -> Array:
    """ds of every stretch between points."""
    squares = np.diff(x) ** 2 + np.diff(y) ** 2 + (yaw_length * np.diff(yaw)) ** 2
    return np.asarray(np.sqrt(squares))


def _fine(length: float) -> Array:
    """0 to ``length`` in steps of at most 2 mm."""
    if not abs(length) <= LENGTH_MAX:
        raise TraceError(
            f"a trace may be {LENGTH_MAX:g} m long, this one would have {abs(length):g} m"
        )
    return np.linspace(0.0, length, max(int(abs(length) / FINE), 2) + 1)


def _follow(x: Array, y: Array, yaw: str) -> Drawn:
    """Yaw along the tangent, turned so that the path begins straight ahead, or fixed."""
    if yaw == "fixed":
        return x, y, np.zeros_like(x)
    tangent = np.unwrap(np.arctan2(np.gradient(y), np.gradient(x)))
    c, s = direction(tangent[0])
    return c * x + s * y, c * y - s * x, tangent - tangent[0]


def _spun(radius: float, end: float, angle_deg: float, yaw: str) -> Drawn:
    """Heading turns by the angle while the radius of curvature goes from ``radius`` to ``end``."""
    if angle_deg == 0.0:
        raise TraceError("trace angle_deg must not be 0")
    angle = math.radians(angle_deg)
    heading = _fine(angle * max(radius, end)) / max(radius, end)
    bend = radius + (end - radius) * heading / angle
    ds = np.abs(np.diff(heading)) * (bend[1:] + bend[:-1]) / 2
    mid = (heading[1:] + heading[:-1]) / 2
    c, s = directions(mid)
    x = np.concatenate([[0.0], np.cumsum(ds * c)])
    y = np.concatenate([[0.0], np.cumsum(ds * s)])
    return x, y, heading if yaw == "tangent" else np.zeros_like(x)


def _square(reach: float) -> list[XY]:
    return [(x, y) for x in (-reach, reach) for y in (-reach, reach)]


def _table(points: Any) -> Array:
    """Waypoints as rows of x m, y m, yaw rad."""
    if not isinstance(points, Sequence) or len(points) < 2:
        raise TraceError(f"waypoints must be at least two [x, y, yaw_deg], got {points!r:.80}")
    rows = []
    for k, row in enumerate(points, 1):
        if not _is_waypoint(row):
            raise TraceError(f"waypoint {k} must be [x, y] or [x, y, yaw_deg], got {row!r:.80}")
        yaw = math.radians(row[2]) if len(row) == 3 else 0.0
        rows.append((float(row[0]), float(row[1]), yaw))
    return np.array(rows)


def _is_waypoint(row: Any) -> bool:
    if not isinstance(row, Sequence) or len(row) not in (2, 3):
        return False
    return all(Limits(-math.inf, math.inf).admit(v) and math.isfinite(v) for v in row)


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
