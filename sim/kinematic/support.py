"""The feet that carry: where they take the body, how it rests on them, when they give way and
slide.
"""

from __future__ import annotations

import math

from walking_console.planner.geometry.polygons import Polygon
from walking_console.planner.geometry.transforms import direction, left_fold_sum
from walking_console.planner.stability import GRAVITY, support_polygon
from walking_console.planner.types import TICK

from ..terrain.ground import Ground
from .configuration import SOLE_GAP, STEP_UP, XY, Configuration
from .rest_pose import (
    Rest,
    attitude,
    lean,
    nearest_inside,
    plane_fit,
    rest,
    rotation,
    turned,
)

# m; a body about to tip onto a foot that hangs no higher than this rests on it at once, without a
# fall
ROCK = 0.01
STIFF = 1e-9  # m; carrying feet pulled apart by less are not pulled
EXACT = 1e-12  # a lean or a height that changes by less does not change
# N/m sideways: an estimate; titan3's feet give 5 mm before they slip. Softer: see feet slip later
LEG_STIFFNESS = 32_000.0
ROUNDING = 1e-9  # m²; a body on the very edge of its polygon is not outside it
STEEP = 0.9  # of the friction: ground that pulls less holds without a look at the contact world
# times a body that tilts is laid on its feet in a tick: each leaves a hundredth of the error, or
# less
RESTS_MAX = 8

PolygonSide = tuple[float, float, float]  # nx, ny, offset: inside where n·(x, y) >= offset


class Support:
    """The carrying feet of a configuration, and what they do to the body.

    ``quiet``: nothing but walking happens; no push, no slide, nothing changed from outside.
    """

    def __init__(self, q: Configuration) -> None:
        self.q = q
        self.edges: list[PolygonSide] = []  # of the support polygon
        self.quiet = False
        self._places: list[XY] = []  # of the feet that carry
        self._polygon: Polygon = ()
        self._slope = (0.0, 0.0)  # mean, under the carrying feet
        # of each leg: the ground and the place whose slope was looked at last, and the slope
        self._slopes: list[tuple[Ground, float, float, XY] | None] = [None] * len(q.feet)
        self._pull = [[0.0, 0.0] for _ in q.feet]  # m each carrying leg is pulled aside
        self._weight = q.machine.mass * GRAVITY

    def take_stock(self, falling: bool = False) -> None:
        """After a change of support: which legs carry, the edges of their polygon, the slope under
        them.
        """
        q = self.q
        q.free = [leg for leg in range(len(q.feet)) if leg not in q.carrying]
        for leg in q.carrying:
            q.soles[leg] = True
            q.whiskers[leg] = 0
        polygon = self._polygon_now()
        self._slope = self._mean_slope()
        steep = math.hypot(*self._slope) > STEEP * q.machine.friction
        disturbed = q.push_ticks or steep or q.contact.sliding or falling
        self.quiet = len(polygon) > 2 and not disturbed

    def _polygon_now(self) -> Polygon:
        """The support polygon, which its edges go with; one object while the same places carry."""
        places = [(foot[0], foot[1]) for foot in map(self.q.feet.__getitem__, self.q.carrying)]
        if places != self._places:
            self._places = places
            self._polygon = polygon = support_polygon(places)
            self.edges = [
                (ay - by, bx - ax, (bx - ax) * ay - (by - ay) * ax - ROUNDING)
                for (ax, ay), (bx, by) in zip(polygon, (*polygon[1:], *polygon[:1]), strict=True)
            ]
        return self._polygon

    def _mean_slope(self) -> XY:
        q = self.q
        if q.ground.level is not None or not q.carrying:
            return 0.0, 0.0
        n = len(q.carrying)
        slopes = [self._slope_under(leg) for leg in q.carrying]
        along_x = left_fold_sum(slope[0] for slope in slopes) / n
        return along_x, left_fold_sum(slope[1] for slope in slopes) / n

    def _slope_under(self, leg: int) -> XY:
        """The slope under a foot: looked at once for each place it stands in."""
        ground = self.q.ground
        x, y, _ = self.q.feet[leg]
        kept = self._slopes[leg]
        if kept is None or kept[0] is not ground or kept[1] != x or kept[2] != y:
            slope = slope_at(ground, x, y, self.q.machine.foot_radius)
            kept = self._slopes[leg] = ground, x, y, slope
        return kept[3]

    # -- where the body goes

    def follow(self) -> None:
        """The body goes, in the ground plane, where its carrying legs take it: the best fit when
        they do not agree.
        """
        q = self.q
        if not q.carrying:
            return
        roll, pitch = q.body[3], q.body[4]
        xx, xy, xz, yx, yy, yz, _, _, _ = rotation(roll, pitch, 0.0)
        feet = [q.feet[leg] for leg in q.carrying]
        tips = [q.tips[leg] for leg in q.carrying]
        reached = [(xx * x + xy * y + xz * z, yx * x + yy * y + yz * z) for x, y, z in tips]
        x, y, yaw = plane_fit(feet, reached, q.body[5])
        q.turn_to(x, y, yaw, roll, pitch)

    def balances(self) -> bool:
        """True when the feet carry the load; before it is lost, the body rocks onto feet that touch
        or nearly do.
        """
        q = self.q
        x, y = q.load_point()
        if q.holds(x, y):
            return True
        near = {}
        for leg in q.free:
            foot = q.feet[leg]
            height = q.ground.height_at(foot[0], foot[1])
            if foot[2] - height <= ROCK:
                near[leg] = height
        if not near or not q.holds(x, y, near):
            return False
        for leg, height in near.items():
            q.feet[leg][2] = height
        q.carrying = sorted((*q.carrying, *near))
        q.free = [leg for leg in q.free if leg not in near]
        return True

    def rest(self) -> None:
        """Lay the body on its feet; feet that then hang by more than a sole gives are let go."""
        q = self.q
        laid: Rest | None = None
        polygon = self._polygon_now()
        if len(polygon) < 3:
            return
        places = [q.feet[leg] for leg in q.carrying]
        lengths = [q.tips[leg][2] for leg in q.carrying]
        for _ in range(RESTS_MAX):
            x, y, z, _, _, yaw = q.body
            feet = [(fx - x, fy - y, fz) for fx, fy, fz in places]
            now = Rest(z, *lean(q.rotation))
            px, py = nearest_inside(polygon, *q.load_point())
            laid = rest(feet, lengths, px - q.body[0], py - q.body[1], now)
            if laid is None:
                return
            if abs(laid.z - z) > EXACT:
                q.body[2] = laid.z
            if abs(laid.lean_x - now.lean_x) <= EXACT and abs(laid.lean_y - now.lean_y) <= EXACT:
                break
            level = abs(laid.lean_x) < EXACT and abs(laid.lean_y) < EXACT
            q.body[3:5] = (0.0, 0.0) if level else attitude(laid.lean_x, laid.lean_y, yaw)
            # a body that tilts goes sideways over its feet, and there lies a little higher or lower
            self.follow()
        assert laid is not None
        stretch = 1.0 / q.rotation[8]
        for leg, (ex, ey, height), length in zip(tuple(q.carrying), feet, lengths, strict=True):
            gap = laid.z - laid.lean_x * ex - laid.lean_y * ey - height + stretch * length
            if gap > SOLE_GAP:
                self.let_go(leg)

    def let_go(self, leg: int) -> None:
        """A foot that hangs: it is where the body has it, though not in the ground."""
        self.q.carrying.remove(leg)
        self._pull[leg][:] = 0.0, 0.0
        self.q.hang(leg)

    # -- feet that give way

    def give_way(self) -> None:
        """Feet that are pulled apart: a leg gives a little, then its foot slips by what is too
        much.
        """
        q = self.q
        machine = self.q.machine
        if not q.carrying:
            return
        grip = machine.friction * machine.mass * GRAVITY / len(q.carrying) / LEG_STIFFNESS
        for leg in tuple(q.carrying):
            foot = q.feet[leg]
            pull = self._pull[leg]
            x, y, _ = turned(q.rotation, *q.tips[leg])
            rx, ry = q.body[0] + x - foot[0], q.body[1] + y - foot[1]
            if abs(rx) <= STIFF and abs(ry) <= STIFF:
                continue
            pull[0] += rx
            pull[1] += ry
            pulled = math.hypot(pull[0], pull[1])
            if pulled > grip:
                over = 1.0 - grip / pulled
                ox, oy = pull[0] * over, pull[1] * over
                pull[0] -= ox
                pull[1] -= oy
                self._replant(leg, foot[0] + ox, foot[1] + oy)
        q.measure_sideways()

    def _replant(self, leg: int, x: float, y: float) -> bool:
        """Drag a carrying foot to (x, y) over the ground; False when a riser is in the way. Over an
        edge it loses its hold.
        """
        q = self.q
        foot = self.q.feet[leg]
        height = q.ground.height_at(x, y)
        if height - foot[2] > STEP_UP:
            return False
        q.slipping[leg] = True
        fell = not height >= foot[2] - SOLE_GAP
        foot[0] = x
        foot[1] = y
        if fell:
            self.let_go(leg)
        else:
            foot[2] = height
        return True

    def slide(self) -> None:
        """Push and slope against the friction of all feet: what is too much, moves the machine over
        the ground.
        """
        q = self.q
        fx, fy = self._ground_load()
        grip = STEEP * q.machine.friction * self._weight
        if not q.carrying or (math.hypot(fx, fy) <= grip and not q.contact.sliding):
            return
        slip = q.contact.slide(q.body, [q.feet[leg] for leg in q.carrying], fx, fy, TICK)
        if slip is None:
            return
        bx, by, _, roll, pitch, yaw = q.body
        c, s = direction(slip.turn)
        x, y = bx + slip.dx, by + slip.dy
        offsets = [(q.feet[leg][0] - bx, q.feet[leg][1] - by) for leg in q.carrying]
        q.turn_to(x, y, yaw + slip.turn, roll, pitch)
        for leg, (ex, ey) in zip(tuple(q.carrying), offsets, strict=True):
            if not self._replant(leg, x + c * ex - s * ey, y + s * ex + c * ey):
                q.contact.stop()
        q.measure_sideways()

    def _ground_load(self) -> XY:
        """Newtons in the ground plane: the push, and the weight on the mean slope under the
        carrying feet.
        """
        fx, fy = self.q.pushed
        if self._slope == (0.0, 0.0):
            return fx, fy
        return fx - self._weight * self._slope[0], fy - self._weight * self._slope[1]


def slope_at(ground: Ground, x: float, y: float, span: float) -> XY:
    """Slope of the ground along x and y: the lesser of before and behind, so that the riser of a
    step is not a slope.
    """
    cell = ground.cell_at(x, y)
    if cell is None:
        return 0.0, 0.0
    d = ground.cell * max(1, round(span / ground.cell))
    x, y = ground.centre(*cell)
    here = ground.height_at(x, y)
    along_x = _lesser(ground.height_at(x + d, y) - here, here - ground.height_at(x - d, y), d)
    return along_x, _lesser(ground.height_at(x, y + d) - here, here - ground.height_at(x, y - d), d)


def _lesser(rise_before: float, rise_behind: float, d: float) -> float:
    """The lesser of two slopes of one sign, 0 of two signs or of a hole."""
    before, behind = rise_before / d, rise_behind / d
    return min(before, behind, key=abs) if before * behind > 0.0 else 0.0
