"""Where a leg's foot is for its joints, which joints put it somewhere, how fast, how strongly.

Points are in body axes, m; joints are three floats, rad or m (``chains``). The three common kinds
are closed forms, exact to rounding (1e-12 m); any other chain is found by damped Newton steps from
fixed starts, the same every time, to 1e-10 m. Plain floats: this runs for every leg in every tick.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from ..geometry.transforms import Matrix, Point, direction
from .chains import ALONG, JOINTS, LEFT, UP, LegChain, Masses

Joints = tuple[float, float, float]
_Columns = tuple[Point, Point, Point]  # m/s of the tip per rad/s or m/s of each joint

# rad or m a joint may be beyond its limit: rounding. Wider, see plans that the drives cannot follow
SLACK = 1e-9
STRETCHED = 1e-12  # of the squared lengths; a leg straight to within rounding still reaches
ITERATIONS = 60  # of Newton's steps from one start; fewer, see the ends of a reach missed
SOLVED = 1e-10  # m
STEP_MAX = 0.4  # rad or m, of one Newton step; longer, see it jump from one branch to another
# starts of the search, as shares of each joint's range: the middle, then the eight quarters
STARTS = (0.5, 0.25, 0.75)
SINGULAR = 1e-12


def forward(chain: LegChain, joints: Joints) -> Point:
    """The foot tip, body axes, m."""
    return _in_body(chain, _FORWARD.get(chain.kind, _serial_foot)(chain, joints))


def inverse(chain: LegChain, foot: Point) -> Joints | None:
    """The joints that put the foot tip there, within their limits; None when none do.

    Of several solutions the first in a fixed order: facing the foot before facing away from it,
    the knee up (insect) or forward (mammal) before the other way.
    """
    if chain.kind == "slides":  # the one solution there is, asked for of every leg in every tick
        spot = _in_leg(chain, foot)
        return spot if within_limits(chain, spot) else None
    for joints in _SOLUTIONS.get(chain.kind, _serial_solutions)(chain, _in_leg(chain, foot)):
        if within_limits(chain, joints):
            return joints
    return None


def within_limits(chain: LegChain, joints: Joints) -> bool:
    """True when every joint is inside its range."""
    (a0, a1), (b0, b1), (c0, c1) = chain.limits
    a, b, c = joints
    return (
        a0 - SLACK <= a <= a1 + SLACK
        and b0 - SLACK <= b <= b1 + SLACK
        and c0 - SLACK <= c <= c1 + SLACK
    )


def link_ends(chain: LegChain, joints: Joints) -> tuple[Point, Point, Point, Point]:
    """Hip, second joint, third joint and foot tip, body axes, m: what is drawn."""
    spots, _ = _frames(chain, joints)
    a, b, c, d = (_in_body(chain, spot) for spot in spots)
    return a, b, c, d


def jacobian(chain: LegChain, joints: Joints) -> Matrix:
    """Foot velocity for each joint's speed: rows are body x, y, z, columns the joints."""
    c, s = chain.turn
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = _columns(chain, joints)
    return (
        (c * ax - s * ay, c * bx - s * by, c * cx - s * cy),
        (s * ax + c * ay, s * bx + c * by, s * cx + c * cy),
        (az, bz, cz),
    )


def joint_speeds(chain: LegChain, joints: Joints, velocity: Point) -> Joints | None:
    """Joint speeds, rad/s or m/s, that move the foot at a velocity (body axes, m/s).

    None in a singular posture: a straight leg cannot move along itself.
    """
    return solved(jacobian(chain, joints), velocity)


def joint_torques(chain: LegChain, joints: Joints, force: Point) -> Joints:
    """What the drives must give, N·m or N, for the foot to press with a force (body axes, N)."""
    fx, fy, fz = force
    (ax, bx, cx), (ay, by, cy), (az, bz, cz) = jacobian(chain, joints)
    return ax * fx + ay * fy + az * fz, bx * fx + by * fy + bz * fz, cx * fx + cy * fy + cz * fz


def leg_moment(chain: LegChain, masses: Masses, joints: Joints) -> Point:
    """Σ m·r of a leg's links, kg·m, body axes; they weigh where ``chains.Masses`` says."""
    x = y = z = 0.0
    ends = link_ends(chain, joints)
    for k, (joint, mass) in enumerate(zip(chain.joints, masses.links, strict=True)):
        near = ends[k]
        far = ends[k + 1]
        share = 1.0 if joint.slides else 0.5
        x += mass * (near[0] + share * (far[0] - near[0]))
        y += mass * (near[1] + share * (far[1] - near[1]))
        z += mass * (near[2] + share * (far[2] - near[2]))
    return x, y, z


def holding_torques(chain: LegChain, masses: Masses, joints: Joints, down: Point) -> Joints:
    """What the drives must give, N·m or N, to hold the leg's own links up against gravity.

    ``down`` is gravity in body axes, m/s². Links weigh where ``chains.Masses`` says.
    """
    spots, axes = _frames(chain, joints)
    c, s = chain.turn
    gravity = (c * down[0] + s * down[1], c * down[1] - s * down[0], down[2])
    held = [0.0, 0.0, 0.0]
    for k, (joint, mass) in enumerate(zip(chain.joints, masses.links, strict=True)):
        near = spots[k]
        far = spots[k + 1]
        weight = far if joint.slides else _moved(near, _apart(far, near), 0.5)
        for j in range(k + 1):
            slides = chain.joints[j].slides
            way = axes[j] if slides else _cross(axes[j], _apart(weight, spots[j]))
            held[j] -= mass * _dot(way, gravity)
    return held[0], held[1], held[2]


def speed_share(chain: LegChain, joints: Joints, velocity: Point) -> float:
    """The largest joint speed a foot velocity asks for, as a share of that joint's limit.

    Over 1 the motion must be timed slower by that factor; infinite in a singular posture.
    """
    speeds = joint_speeds(chain, joints, velocity)
    if speeds is None:
        return 0.0 if velocity == (0.0, 0.0, 0.0) else math.inf
    a, b, c = chain.joints
    return max(abs(speeds[0]) / a.speed, abs(speeds[1]) / b.speed, abs(speeds[2]) / c.speed)


def solved(matrix: Matrix, right: Point) -> Point | None:
    """x of matrix · x = right by Cramer's rule; None when the matrix is singular."""
    (a, b, c), (d, e, f), (g, h, i) = matrix
    p = e * i - f * h
    q = f * g - d * i
    r = d * h - e * g
    whole = a * p + b * q + c * r
    if abs(whole) < SINGULAR:
        return None
    x, y, z = right
    return (
        (p * x + (c * h - b * i) * y + (b * f - c * e) * z) / whole,
        (q * x + (a * i - c * g) * y + (c * d - a * f) * z) / whole,
        (r * x + (b * g - a * h) * y + (a * e - b * d) * z) / whole,
    )


# -- between body axes and the leg's own


def _in_body(chain: LegChain, spot: Point) -> Point:
    hx, hy, hz = chain.hip
    c, s = chain.turn
    x, y, z = spot
    return hx + c * x - s * y, hy + s * x + c * y, hz + z


def _in_leg(chain: LegChain, foot: Point) -> Point:
    c, s = chain.turn
    x = foot[0] - chain.hip[0]
    y = foot[1] - chain.hip[1]
    return c * x + s * y, c * y - s * x, foot[2] - chain.hip[2]


# -- the three kinds


def _slides_foot(chain: LegChain, joints: Joints) -> Point:
    return joints


def _slides_columns(chain: LegChain, joints: Joints) -> _Columns:
    return ALONG, LEFT, UP


def _insect_foot(chain: LegChain, joints: Joints) -> Point:
    l1, l2, l3 = chain.links
    yaw, hip, knee = joints
    c, s = direction(yaw)
    c2, s2 = direction(hip)
    c23, s23 = direction(hip + knee)
    out = l1 + l2 * c2 + l3 * c23
    return out * c, out * s, l2 * s2 + l3 * s23


def _insect_columns(chain: LegChain, joints: Joints) -> _Columns:
    l1, l2, l3 = chain.links
    yaw, hip, knee = joints
    c, s = direction(yaw)
    c2, s2 = direction(hip)
    c23, s23 = direction(hip + knee)
    out = l1 + l2 * c2 + l3 * c23
    up = l2 * s2 + l3 * s23
    return (
        (-out * s, out * c, 0.0),
        (-up * c, -up * s, out - l1),
        (-l3 * s23 * c, -l3 * s23 * s, l3 * c23),
    )


def _insect_solutions(chain: LegChain, spot: Point) -> Iterator[Joints]:
    l1, l2, l3 = chain.links
    x, y, z = spot
    out = math.hypot(x, y)
    ahead = math.atan2(y, x)
    for yaw, far in ((ahead, out - l1), (_wrapped(ahead + math.pi), -out - l1)):
        for hip, knee in _two_links(far, z, l2, l3, -1.0):
            yield yaw, hip, knee


def _mammal_foot(chain: LegChain, joints: Joints) -> Point:
    _, l2, l3 = chain.links
    roll, hip, knee = joints
    c, s = direction(roll)
    c2, s2 = direction(hip)
    c23, s23 = direction(hip + knee)
    aside = chain.joints[0].offset[1]
    down = l2 * c2 + l3 * c23
    return -l2 * s2 - l3 * s23, aside * c + down * s, aside * s - down * c


def _mammal_columns(chain: LegChain, joints: Joints) -> _Columns:
    _, l2, l3 = chain.links
    roll, hip, knee = joints
    c, s = direction(roll)
    c2, s2 = direction(hip)
    c23, s23 = direction(hip + knee)
    aside = chain.joints[0].offset[1]
    ahead = -l2 * s2 - l3 * s23
    down = l2 * c2 + l3 * c23
    return (
        (0.0, down * c - aside * s, aside * c + down * s),
        (-down, ahead * s, -ahead * c),
        (-l3 * c23, -l3 * s23 * s, l3 * s23 * c),
    )


def _mammal_solutions(chain: LegChain, spot: Point) -> Iterator[Joints]:
    _, l2, l3 = chain.links
    x, y, z = spot
    aside = chain.joints[0].offset[1]
    squared = y * y + z * z - aside * aside
    if squared < -STRETCHED:
        return
    for down in (math.sqrt(max(squared, 0.0)), -math.sqrt(max(squared, 0.0))):
        roll = _wrapped(math.atan2(z, y) - math.atan2(-down, aside))
        for hip, knee in _two_links(down, -x, l2, l3, 1.0):
            yield roll, hip, knee


def _two_links(
    along: float, across: float, upper: float, lower: float, bend: float
) -> Iterator[tuple[float, float]]:
    """Both ways two links reach (along, across): their angles, the second against the first.

    ``bend`` is the sign of the second angle that comes first.
    """
    far = along * along + across * across
    cosine = (far - upper * upper - lower * lower) / (2.0 * upper * lower)
    if not -1.0 - STRETCHED <= cosine <= 1.0 + STRETCHED:
        return
    turn = math.acos(max(-1.0, min(1.0, cosine)))
    for knee in (bend * turn, -bend * turn):
        c, s = direction(knee)
        yield _wrapped(math.atan2(across, along) - math.atan2(lower * s, upper + lower * c)), knee


def _wrapped(angle: float) -> float:
    return math.remainder(angle, 2.0 * math.pi)


_FORWARD: dict[str, Callable[[LegChain, Joints], Point]] = {
    "slides": _slides_foot,
    "insect": _insect_foot,
    "mammal": _mammal_foot,
}
_SOLUTIONS: dict[str, Callable[[LegChain, Point], Iterator[Joints]]] = {
    "insect": _insect_solutions,
    "mammal": _mammal_solutions,
}
_COLUMNS: dict[str, Callable[[LegChain, Joints], _Columns]] = {
    "slides": _slides_columns,
    "insect": _insect_columns,
    "mammal": _mammal_columns,
}


# -- any chain of three joints


def _serial_foot(chain: LegChain, joints: Joints) -> Point:
    return _frames(chain, joints)[0][-1]


def _frames(chain: LegChain, joints: Joints) -> tuple[list[Point], list[Point]]:
    """Hip, joints and tip, and each joint's axis, in the leg's own axes."""
    spots: list[Point] = [(0.0, 0.0, 0.0)]
    axes: list[Point] = []
    here = spots[0]
    turn: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    for joint, value in zip(chain.joints, joints, strict=True):
        axis = _times(turn, joint.axis)
        axes.append(axis)
        if joint.slides:
            here = _moved(here, axis, value)
        else:
            turn = _after(turn, _about(joint.axis, value))
        here = _moved(here, _times(turn, joint.offset), 1.0)
        spots.append(here)
    return spots, axes


def _columns(chain: LegChain, joints: Joints) -> _Columns:
    """Velocity of the tip per joint speed, in the leg's own axes."""
    return _COLUMNS.get(chain.kind, _serial_columns)(chain, joints)


def _serial_columns(chain: LegChain, joints: Joints) -> _Columns:
    spots, axes = _frames(chain, joints)
    tip = spots[-1]
    a, b, c = (
        axis if joint.slides else _cross(axis, _apart(tip, spot))
        for joint, axis, spot in zip(chain.joints, axes, spots, strict=False)
    )
    return a, b, c


def _serial_solutions(chain: LegChain, spot: Point) -> Iterator[Joints]:
    for start in _starts(chain):
        joints = _newton(chain, spot, start)
        if joints is not None:
            yield joints


def _starts(chain: LegChain) -> Iterator[Joints]:
    ranges = chain.limits
    middle, *others = STARTS
    shares = [(middle, middle, middle)]
    shares += [(a, b, c) for a in others for b in others for c in others]
    for share in shares:
        a, b, c = (
            low + part * (high - low) for (low, high), part in zip(ranges, share, strict=True)
        )
        yield a, b, c


def _newton(chain: LegChain, spot: Point, joints: Joints) -> Joints | None:
    """Damped least-squares steps towards a foot place, kept inside the limits."""
    damping = 1e-3
    error = _apart(spot, _serial_foot(chain, joints))
    for _ in range(ITERATIONS):
        if _size(error) < SOLVED:
            return joints
        step = _damped_step(_columns(chain, joints), error, damping)
        if step is None:
            damping = max(damping * 10.0, 1e-9)
            continue
        tried = _clamped(chain, joints, step)
        left = _apart(spot, _serial_foot(chain, tried))
        if _size(left) < _size(error):
            joints = tried
            error = left
            damping *= 0.1
        else:
            damping = max(damping * 10.0, 1e-9)
    return joints if _size(error) < SOLVED else None


def _damped_step(columns: _Columns, error: Point, damping: float) -> Point | None:
    """(JᵀJ + damping) step = Jᵀ error."""
    rows = [tuple(_dot(a, b) for b in columns) for a in columns]
    (a, b, c), (d, e, f), (g, h, i) = rows
    matrix = ((a + damping, b, c), (d, e + damping, f), (g, h, i + damping))
    x, y, z = (_dot(column, error) for column in columns)
    return solved(matrix, (x, y, z))


def _clamped(chain: LegChain, joints: Joints, step: Point) -> Joints:
    longest = max(abs(part) for part in step)
    scale = 1.0 if longest <= STEP_MAX else STEP_MAX / longest
    a, b, c = (
        min(max(joints[k] + scale * step[k], chain.limits[k][0]), chain.limits[k][1])
        for k in range(JOINTS)
    )
    return a, b, c


def _about(axis: Point, angle: float) -> Matrix:
    """Rotation about a unit axis (Rodrigues)."""
    c, s = direction(angle)
    x, y, z = axis
    v = 1.0 - c
    return (
        (c + x * x * v, x * y * v - z * s, x * z * v + y * s),
        (y * x * v + z * s, c + y * y * v, y * z * v - x * s),
        (z * x * v - y * s, z * y * v + x * s, c + z * z * v),
    )


def _times(m: Matrix, v: Point) -> Point:
    return _dot(m[0], v), _dot(m[1], v), _dot(m[2], v)


def _after(m: Matrix, n: Matrix) -> Matrix:
    """The product m · n."""
    a, b, c = zip(*n, strict=True)
    r, s, t = ((_dot(row, a), _dot(row, b), _dot(row, c)) for row in m)
    return r, s, t


def _dot(a: Point, b: Point) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Point, b: Point) -> Point:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _apart(a: Point, b: Point) -> Point:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _size(a: Point) -> float:
    return math.sqrt(_dot(a, a))


def _moved(a: Point, way: Point, far: float) -> Point:
    return a[0] + far * way[0], a[1] + far * way[1], a[2] + far * way[2]
