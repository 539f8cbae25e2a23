"""Level B4 (H §7): how fast the body may go while the leg returns, and the knots of the step.

All velocities are of the foot against the body, which is what the servos drive. ``course`` is the
way of the body per metre walked on the ground plane (x, y in body axes, z the climb),
``displacement`` (D) that of the foot on the ground. The body goes along a line or an arc
(``BodyWay``); a line is an arc of turn 0. On a line the largest speed has a closed form, on an arc
it is bisected for from the same condition.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

from ..geometry.paths import ArcPath
from ..geometry.transforms import XY, Body, point_placed, point_seen
from ..robot.model import Machine
from ..types import TICK, Gait, Phase, Point
from .step_builder import FootKnot
from .swing import (
    STRETCHES,
    Profile,
    SwingCorners,
    between,
    peak_of,
    stairs,
    swing_speeds,
)

BACK_MIN = TICK  # s, one tick of Level C: no return phase is shorter
WAIT_SHARE = 0.2  # of V_z at which a waiting body changes height
# of V_z left to the body's own climb; more leaves too little to lift the foot against it
CLIMB_SHARE = 0.5
KNOT_TURN = 0.02  # rad of yaw between knots; more: see the swing foot leave its line
ROUNDING = 0.995  # of every speed limit on an arc: straight lines between knots in axes that turn
HALVINGS = 30  # of the range of speeds on an arc


Span = tuple[float, float]  # where something begins, and how long it is


class Timing(NamedTuple):
    """The clock of one step: speeds in m/s along the course on the ground plane, durations in s."""

    speed: float  # v_G while the leg swings (0 when the body waits)
    speed_max: float  # the same without the command
    support_speed: float  # v_G while all four stand
    support: float  # t_spt
    up: float  # t_up
    back: float  # t_rtn
    down: float  # t_dwn


# Duration of the lift and of the descent, speed limits V_c/κ -> the largest speed of the body at
# which the swing leg keeps them in its return.
ReturnLimit = Callable[[float, float, Point], float]


class SwingDemand(NamedTuple):
    """What a step asks of its clock, lengths in m, vectors in body axes."""

    displacement: Point  # D: of the foot on the ground, and between the tops of lift and descent
    courses: tuple[XY, ...]  # of standing feet, per metre; all the same on a line
    climb: float  # the body's own change of height in the step
    g0: float
    g: float
    rise: float  # the foot's vertical strokes
    drop: float
    # how far the body may go on during each before the foot is out of mechanical reach
    room: tuple[float, float]
    return_limit: ReturnLimit | None = None  # of a step on an arc; None: (28), on a line

    @property
    def slope(self) -> float:
        """The body's climb per metre of its way; 0 for one that waits."""
        return self.climb / self.g if self.g > 0.0 else 0.0


class BodyWay:
    """The body's way through one step: along the path, its height in proportion.

    ``share`` is that of the whole way, 0 to 1; a body that waits spends it changing height.
    """

    def __init__(
        self, body: Body, frame: tuple[float, float], path: ArcPath, g: float, height: float
    ) -> None:
        """From ``body`` so far along ``path``, which lies in axes whose cosine and sine in the
        absolute frame are ``frame``; the body ends at ``height``.
        """
        self.body = body
        self.path = path
        self.g = g
        self.c, self.s = frame
        dx, dy, turn = path.pose(g)
        x, y, z, yaw = body
        self.end: Body = (
            x + self.c * dx - self.s * dy,
            y + self.s * dx + self.c * dy,
            height,
            yaw + turn,
        )
        self.dx = self.end[0] - x
        self.dy = self.end[1] - y
        self.dz = height - z

    def at(self, share: float) -> Body:
        """The body after a share of its way."""
        x, y, z, yaw = self.body
        if self.path.turn == 0.0:
            return x + share * self.dx, y + share * self.dy, z + share * self.dz, yaw
        dx, dy, turn = self.path.pose(share * self.g)
        return (
            x + self.c * dx - self.s * dy,
            y + self.s * dx + self.c * dy,
            z + share * self.dz,
            yaw + turn,
        )

    def stretch(
        self, phase: Phase, time: Span, share: Span, a: Point, b: Point, profile: Profile
    ) -> list[FootKnot]:
        """The knots of one stretch of a swing, from a to b, after its beginning: ``time`` and
        ``share`` of the way are where it begins and how long it is.

        The foot rises and falls vertically in the absolute frame; its return is a straight line in
        body axes, which turn on an arc.
        """
        if self.path.turn != 0.0:
            return self._bent_stretch(phase, time, share, a, b, profile)
        if phase is Phase.RETURN:
            return self._straight_return(time, share, a, b, profile)
        x, y, z, yaw = self.body
        dx = self.dx
        dy = self.dy
        dz = self.dz
        (t, duration) = time
        (begin, way) = share
        ax, ay, az = a
        rise = b[2] - az
        rows: list[FootKnot] = []
        for tau, eased in profile:
            w = begin + tau * way
            rows.append(
                (
                    t + tau * duration,
                    x + w * dx,
                    y + w * dy,
                    z + w * dz,
                    yaw,
                    ax,
                    ay,
                    az + eased * rise,
                )
            )
        return rows

    def _straight_return(
        self, time: Span, share: Span, a: Point, b: Point, profile: Profile
    ) -> list[FootKnot]:
        """The return along a line: the body carries the foot along, and it goes the rest by
        itself.
        """
        x, y, z, yaw = self.body
        dx = self.dx
        dy = self.dy
        dz = self.dz
        (t, duration) = time
        (begin, way) = share
        cx = way * dx
        cy = way * dy
        cz = way * dz
        ax, ay, az = a
        rx = b[0] - ax - cx
        ry = b[1] - ay - cy
        rz = b[2] - az - cz
        rows: list[FootKnot] = []
        for tau, eased in profile:
            w = begin + tau * way
            rows.append(
                (
                    t + tau * duration,
                    x + w * dx,
                    y + w * dy,
                    z + w * dz,
                    yaw,
                    ax + tau * cx + eased * rx,
                    ay + tau * cy + eased * ry,
                    az + tau * cz + eased * rz,
                )
            )
        return rows

    def _bent_stretch(
        self, phase: Phase, time: Span, share: Span, a: Point, b: Point, profile: Profile
    ) -> list[FootKnot]:
        (t, duration) = time
        (begin, way) = share
        from_b = point_seen(self.at(begin), a)
        to_b = point_seen(self.at(begin + way), b)
        rows: list[FootKnot] = []
        for tau, eased in stairs(profile, self.pieces(way)):
            body = self.at(begin + tau * way)
            if phase is Phase.RETURN:
                foot = point_placed(body, between(from_b, to_b, eased))
            else:
                foot = a[0], a[1], a[2] + eased * (b[2] - a[2])
            rows.append((t + tau * duration, *body, *foot))
        return rows

    def pieces(self, way: float) -> int:
        """Into how many straight lines a share of the way is cut."""
        return max(1, math.ceil(abs(self.path.turn) * way * self.g / KNOT_TURN))


def axis_limit(displacement: float, n: float, limit: float, g: float, vertical: float) -> float:
    """The largest v with D/t_rtn - v·n <= V on one axis and everywhere below it, t_rtn = g/v - τ:
    (24) with its root repaired.

    From D·v - (n·v + V)(g - v·τ) <= 0. With V = V_x, n = 1: A = τ/V, B = τ + (D - g)/V, C = -g/V,
    all times V.
    """
    # a·v² + b·v - c <= 0
    a = n * vertical
    b = displacement - n * g + limit * vertical
    c = limit * g
    inside = b * b + 4.0 * a * c
    if inside < 0.0:
        return math.inf
    below = b + math.sqrt(inside)
    return 2.0 * c / below if below > 1e-15 else math.inf


def speed_limit(displacement: Point, n: Point, limits: Point, g: float, vertical: float) -> float:
    """v_max of H §7 (28) without the command: the largest v with |D_c/t_rtn - v·n_c| <= V_c on
    every axis c.
    """
    v = g / vertical if vertical > 0.0 else math.inf
    for d, m, limit in zip(displacement, n, limits, strict=True):
        if m == 0.0:
            slower = axis_limit(abs(d), m, limit, g, vertical)  # of the two ways, the longer
        else:
            ahead = axis_limit(d, m, limit, g, vertical)
            back = axis_limit(-d, -m, limit, g, vertical)
            slower = ahead if ahead < back else back
        if slower < v:
            v = slower
    return v


def speed_standing(n: Point, limits: Point) -> float:
    """The largest v at which standing legs keep their limits, using at most half of V_z for
    climbing.
    """
    fastest = math.inf
    for m, limit, part in zip(n, limits, (1.0, 1.0, CLIMB_SHARE), strict=True):
        if abs(m) > 1e-12:
            at_most = limit * part / abs(m)
            if at_most < fastest:
                fastest = at_most
    return fastest


def return_limit_on(way: BodyWay, g0: float, swing: SwingCorners) -> ReturnLimit:
    """(28) along a path of any kind: the foot returns on a straight line in body axes, from where
    the lift leaves it to where the descent begins; bisected for.
    """
    g_u = way.g - g0
    rounding = ROUNDING if way.path.turn != 0.0 else 1.0

    def limit_of(up: float, down: float, limits: Point) -> float:
        def keeps(v: float) -> bool:
            begin = point_seen(way.at(min((g0 + v * up) / way.g, 1.0)), swing.top)
            end = point_seen(way.at(max((way.g - v * down) / way.g, g0 / way.g)), swing.over)
            back = max(abs(e - b) / limit for b, e, limit in zip(begin, end, limits, strict=True))
            return v * (up + back / rounding + down) <= g_u

        low = 0.0
        high = g_u / (up + BACK_MIN + down)
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            low, high = (middle, high) if keeps(middle) else (low, middle)
        return low

    return limit_of


def timing(
    machine: Machine,
    gait: Gait,
    demand: SwingDemand,
    command: float,
    cruise: Callable[[], float],
) -> Timing:
    """Durations and speeds of a step at a commanded speed, m/s; 0: as fast as it can.

    ``cruise`` gives v_max of the nominal step: the four-leg phase goes on at it when the swing is
    slower.
    """
    limits = swing_speeds(machine, gait)
    g_u = demand.g - demand.g0
    slope = demand.slope
    standing = math.inf
    for nx, ny in demand.courses:
        standing = min(standing, speed_standing((nx, ny, slope), limits))
    lifting = machine.speed[2], peak_of(gait)
    v, v_max, up, down = _swing_speed(lifting, demand, limits, slope, (command, standing))
    if g_u > 0.0:
        back = g_u / v - (up + down)  # H §7 (29)
    else:
        back = _waiting(demand, limits)
    support_speed = v
    if not 0.0 < command <= v:
        at_most = min(cruise(), standing)
        support_speed = max(v, min(command, at_most) if command > 0.0 else at_most)
    return Timing(v, v_max, support_speed, demand.g0 / support_speed, up, back, down)  # H §7 (32)


def _swing_speed(
    lifting: tuple[float, float],
    demand: SwingDemand,
    limits: Point,
    slope: float,
    at_most: tuple[float, float],
) -> tuple[float, float, float, float]:
    """v_G and v_max while the leg swings (0 for a body that waits), t_up and t_dwn; ``lifting`` is
    V_z and κ, ``at_most`` the commanded speed and that at which standing legs keep their limits.
    """
    command, standing = at_most
    lifting_speed, kappa = lifting
    g_u = demand.g - demand.g0
    onward = (*demand.courses[0], slope)
    sinking = _sinking(demand, limits)
    v = v_max = 0.0
    # the body's own climb slows the lift, and the slower lift the climb: the second pass is
    # feasible
    for _ in range(2):
        lift = limits[2] if sinking == 0.0 else (lifting_speed - sinking) / kappa
        up = demand.rise / lift
        down = demand.drop / lift
        if g_u <= 0.0:
            break
        v_max = min(
            speed_limit(demand.displacement, onward, limits, g_u, up + down)
            if demand.return_limit is None
            else demand.return_limit(up, down, limits),
            standing,
            demand.room[0] / up,
            demand.room[1] / down,
            g_u / (up + down + BACK_MIN),
        )
        v = min(v_max, command) if command > 0.0 else v_max
        sinking = abs(v_max * slope)
        if lifting_speed - sinking == lifting_speed:
            break  # another pass would find the same
    return v, v_max, up, down


def _sinking(demand: SwingDemand, limits: Point) -> float:
    """|v_Gz| of a body that waits and changes its height, m/s."""
    return 0.0 if demand.g > 0.0 or demand.climb == 0.0 else WAIT_SHARE * limits[2]


def _waiting(demand: SwingDemand, limits: Point) -> float:
    """t_rtn while the body waits (13b): by the leg's own limits, s."""
    sinking = _sinking(demand, limits)
    dx, dy, dz = demand.displacement
    back = max(BACK_MIN, abs(dx) / limits[0], abs(dy) / limits[1], abs(dz) / (limits[2] - sinking))
    return max(back, abs(demand.climb) / sinking) if sinking > 0.0 else back


def knots(
    clock: Timing, profile: Profile, way: BodyWay, g0: float, swing: SwingCorners
) -> tuple[list[FootKnot], list[Phase]]:
    """The step as knots and the phase of every stretch between them.

    Up and down are vertical in the absolute frame; the return is eased against the body, so that
    the servo's own speed is what is bounded.
    """
    out: list[FootKnot] = [(0.0, *way.body, *swing.stand)]
    phases: list[Phase] = []
    t = clock.support
    share = g0 / way.g if way.g > 0.0 else 0.0
    if t > 0.0:
        pieces = way.pieces(share)
        for k in range(1, pieces + 1):
            out.append((t * k / pieces, *way.at(share * k / pieces), *swing.stand))
            phases.append(Phase.SUPPORT)
    rate = (1.0 - share) / (clock.up + clock.back + clock.down)  # of the body's way, per second
    durations = clock.up, clock.back, clock.down
    for phase, duration, a, b in zip(STRETCHES, durations, swing, swing[1:], strict=False):
        if duration <= 0.0:
            continue
        gone = rate * duration
        rows = way.stretch(phase, (t, duration), (share, gone), a, b, profile)
        t += duration
        share += gone
        rows[-1] = (t, *rows[-1][1:5], *b)
        out += rows
        phases += [phase] * len(rows)
    out[-1] = (t, *way.end, *swing.aim)
    return out, phases


@lru_cache(maxsize=512)
def cruise_limit(
    machine: Machine, gait: Gait, duty_factor: float, stride: float, courses: tuple[XY, ...]
) -> float:
    """v_max of a nominal front step on level ground, m/s, where the body goes past standing feet by
    the slowest of these ``courses`` per metre of its way.
    """
    g = (1.0 - duty_factor) / duty_factor * stride
    limits = swing_speeds(machine, gait)
    way = stride + g
    lifting = (gait.lift_up + gait.lift_down) / limits[2]
    return min(
        speed_limit((way * nx, way * ny, 0.0), (nx, ny, 0.0), limits, g, lifting)
        for nx, ny in courses
    )
