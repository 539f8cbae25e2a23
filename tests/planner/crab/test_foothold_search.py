"""The landing domain D_u, the search start I_u and the search for J_u."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.planner.crab.crab_walks import TITAN, Blocked, command, gait, holes, random_stance, walk
from walking_console.planner.crab.foothold_search import (
    domain_of,
    landings,
    nearest_in,
    phase_point,
    stroke_in,
)
from walking_console.planner.crab.gait import (
    Posture,
    nominal_gait,
    posture_of,
    standard_stance,
)
from walking_console.planner.crab.leg_selection import shift_of
from walking_console.planner.crab.steps import Shift
from walking_console.planner.geometry.paths import line_exit
from walking_console.planner.initial_stance import Placement
from walking_console.planner.motion.leg_order import IS_FRONT, IS_LEFT, PREDECESSOR
from walking_console.planner.terrain.cells import foothold_map

REACH = TITAN.reach
# folded already: canonical legs are the body's
RNG_ANGLES = [math.radians(d) for d in (-40, -16, 0, 12, 28, 44)]


def cases(count=200, seed=1):
    """Random standing postures with a leg that can swing: standard walk, posture, shift."""
    rng, found = np.random.default_rng(seed), 0
    while found < count:
        angle, settings = (
            RNG_ANGLES[int(rng.integers(len(RNG_ANGLES)))],
            gait(rng.uniform(0.75, 0.9)),
        )
        nominal = nominal_gait(TITAN, settings, angle)
        posture = posture_of(nominal, random_stance(rng))
        shift = shift_of(posture, int(rng.integers(4)))
        if isinstance(shift, Shift):
            found += 1
            yield rng, nominal, posture, shift


def reaching(nominal, feet, way):
    """A posture in which every leg may stay for so much of the body's way."""
    posture = Posture(nominal, 0.0, 0.0, 1.0, 0.0, feet, -1)
    posture.__dict__["exits"] = (way,) * 4
    return posture


def test_method_1_is_the_hyperbola_of_17():
    """Printed: (y - x tan α)(x - x_f + dx_u) = (y_f - x_f tan α) dx_u is the locus of D_X(P) =
    g_u(P), for leg 3 by its x reach.
    """
    x, y = 0.0, 0.0
    for angle in RNG_ANGLES:
        nominal, t = nominal_gait(TITAN, gait(), angle), math.tan(angle)
        feet = ((0.55, 0.41), (-0.4, 0.5), (-0.3, -0.5), (0.5, -0.4))
        domain = domain_of(reaching(nominal, feet, 9.0), 2, 0.1, True)
        (fx, fy), dx = feet[0], REACH.x0 + REACH.x_span
        for x in np.linspace(-0.65, -0.25, 9):
            y = x * t + (fy - fx * t) * dx / (x - fx + dx) if abs(x - fx + dx) > 1e-9 else math.nan
            if math.isfinite(y):
                assert domain.crossing(x, y) == pytest.approx((x + dx) / math.cos(angle), abs=1e-9)


@pytest.mark.parametrize(("leg", "angle"), [(1, 0.3), (1, 0.6), (2, -0.3), (2, -0.6)])
def test_errata_18_the_side_of_the_origin_is_the_wrong_one_for_leg_2_ahead_left_and_leg_3_right(
    leg, angle
):
    """Printed: the tolerable points are on the origin's side of (18). By D_X(P) ≤ g_u(P), with the
    y reach alone, they are on the other for leg 2, α > 0 and for leg 3, α < 0.
    """
    nominal, t = nominal_gait(TITAN, gait(), angle), math.tan(angle)
    rng, found = np.random.default_rng(leg), 0
    dy = -REACH.y0 if leg == 1 else REACH.y0
    for _ in range(400):
        feet = random_feet(rng)
        fx, fy = feet[3] if leg == 1 else feet[0]
        domain = domain_of(reaching(nominal, feet, 9.0), leg, 0.0, False)
        x, y = feet[leg]
        _, _, low, high = nominal.boxes[leg]
        way = line_exit(x, y, (-9.0, 9.0, low, high), nominal.path.ux, nominal.path.uy)
        crossing = domain.crossing(x, y)
        if crossing < 0.0:
            continue
        found += 1
        side = (y - x * t) * (y - fy + dy) > (fy - fx * t) * dy
        side_of_origin = (fy - fx * t) * dy < 0.0
        assert (crossing <= way) is not (side is side_of_origin)
    assert found > 100


def random_feet(rng):
    """A foot anywhere in each leg's reach."""
    return tuple((rng.uniform(*leg.x), rng.uniform(*leg.y)) for leg in TITAN.legs)


def test_the_crossing_distance_is_where_the_course_meets_the_line():
    for _, nominal, posture, shift in cases(100):
        domain = domain_of(posture, shift.leg, shift.g, True)
        px, py = nominal.centres[shift.leg]
        s = domain.crossing(px, py)
        if abs(s) < 5.0:
            fx = domain.f_along * domain.ux - domain.f_across * domain.uy
            fy = domain.f_along * domain.uy + domain.f_across * domain.ux
            x, y = s * domain.ux, s * domain.uy
            assert (px - fx) * (y - fy) - (py - fy) * (x - fx) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("angle", RNG_ANGLES)
@pytest.mark.parametrize("u", range(4))
def test_the_search_start_is_that_of_table_2(u, angle):
    """Printed Δx, Δy between I_u and u*, the one with the smaller return, are our one sentence
    about leaving the reach later.
    """
    beta, rng = 0.8, np.random.default_rng(u)
    nominal = nominal_gait(TITAN, gait(beta), angle)
    stroke, c, s, r = nominal.stride, math.cos(angle), math.sin(angle), REACH
    # side is -sgn(u - 2.5) for u = 2, 3
    sign, side = math.copysign(1.0, angle), 1.0 if IS_LEFT[u] else -1.0
    if IS_FRONT[u]:
        delta_x = 2 * r.x0 + 1.5 * r.x_span + (1 / beta - 1.5) * stroke * c
        delta_y = sign * r.y_span / 2 + (1 / beta - 1.5) * stroke * s
    else:
        delta_x = -2 * r.x0 - r.x_span / 2 - (1 - beta) / (2 * beta) * stroke * c
        delta_y = (
            side * (2 * r.y0 + r.y_span)
            + sign * r.y_span / 2
            - (1 - beta) / (2 * beta) * stroke * s
        )
    for _ in range(20):
        posture = posture_of(nominal, random_stance(rng))
        x_before, y_before = posture.feet[PREDECESSOR[u]]
        cx, cy = nominal.centres[u]
        ahead = [(x_before + delta_x - cx) / c]
        if abs(s) > 1e-9:
            ahead.append((y_before + delta_y - cy) / s)
        assert phase_point(posture, u) == pytest.approx(min(ahead), abs=1e-9)


def test_the_stroke_line_in_the_domain_is_what_the_predicates_say():
    for rng, nominal, posture, shift in cases(300):
        for convergent in (True, False):
            domain = domain_of(posture, shift.leg, shift.g, convergent)
            low, high = stroke_in(nominal, domain)
            cx, cy = nominal.centres[shift.leg]
            for t in rng.uniform(-0.4, 0.6, 20):
                if min(abs(t - low), abs(t - high)) > 1e-6:
                    inside = domain.holds(cx + t * domain.ux, cy + t * domain.uy)
                    spread = (domain.ux * cy - domain.uy * cx - domain.f_across) * (
                        1 if domain.left else -1
                    )
                    if spread > 0.0 or not domain.hind:
                        assert inside == (low <= t <= high)


def test_every_foothold_offered_is_in_the_domain_on_a_free_cell_and_none_is_offered_twice():
    for seed, (_, _, posture, shift) in enumerate(cases(120)):
        ground, terrain = foothold_map(holes(0.5, seed, 4.0)), holes(0.5, seed, 4.0)
        domain = domain_of(posture, shift.leg, shift.g, True)
        seen = set()
        for start, landing in landings(posture, domain, ground):
            assert terrain.allows(landing.ax, landing.ay)
            assert domain.holds(landing.x, landing.y)
            assert posture.absolute(landing.x, landing.y) == pytest.approx(
                (landing.ax, landing.ay), abs=1e-9
            )
            cell = terrain.cell_at(landing.ax, landing.ay)
            at_start = (landing.x, landing.y) == start
            assert at_start or (landing.ax, landing.ay) == pytest.approx(
                terrain.centre(*cell), abs=1e-12
            )
            assert (cell, at_start) not in seen
            seen.add((cell, at_start))


def test_every_free_cell_of_the_domain_is_offered():
    for seed, (_, _, posture, shift) in enumerate(cases(60, seed=7)):
        terrain = holes(0.6, seed, 4.0)
        domain = domain_of(posture, shift.leg, shift.g, False)
        offered = {
            terrain.cell_at(landing.ax, landing.ay)
            for start, landing in landings(posture, domain, foothold_map(terrain))
            if (landing.x, landing.y) != start
        }
        free = set()
        for row in range(terrain.rows):
            for column in range(terrain.columns):
                x, y = terrain.centre(row, column)
                if not terrain.forbidden[row, column] and domain.holds(*posture.canonical(x, y)):
                    free.add((row, column))
        if offered or not free:
            assert offered == free


def test_the_search_goes_sideways_first_then_row_by_row_from_the_stroke_line():
    nominal = nominal_gait(TITAN, gait(), 0.0)
    terrain = holes(0.0, span=4.0)
    posture = posture_of(
        nominal, standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), terrain.height_at))
    )
    shift = shift_of(posture, 2)
    domain = domain_of(posture, 2, shift.g, True)
    found = landings(posture, domain, foothold_map(terrain))
    start, *cells = [terrain.cell_at(landing.ax, landing.ay) for _, landing in found]
    columns = [column for _, column in cells]
    assert columns == sorted(columns, reverse=True), (
        "the standard foothold is the most forward one: rows follow behind it"
    )
    assert columns[0] in (start[1], start[1] - 1)
    for column in set(columns):
        sideways = [abs(row - start[0]) for row, c in cells if c == column]
        assert sideways == sorted(sideways), "a row is not searched outward from the stroke line"


def test_on_open_ground_the_foot_lands_on_the_search_start_exactly():
    for degrees in (0, 28, 100, -160):
        for plan in walk(command(degrees), 12):
            assert plan.landing[:2] == plan.search_start[:2]


def test_beside_a_forbidden_search_start_the_foot_lands_on_a_cell_centre():
    ground = holes(0.5, seed=4)
    plans = [plan for plan in walk(command(12), 30, ground) if not isinstance(plan, Blocked)]
    moved = [plan for plan in plans if plan.landing[:2] != plan.search_start[:2]]
    assert len(moved) > 5
    for plan in moved:
        centre = ground.centre(*ground.cell_at(*plan.landing[:2]))
        assert plan.landing[:2] == pytest.approx(centre, abs=1e-12)


def test_the_nearest_point_of_the_domain_is_in_it_and_no_cell_is_nearer():
    grid = holes(0.0, span=4.0)
    for rng, nominal, posture, shift in cases(150, seed=3):
        domain = domain_of(posture, shift.leg, shift.g, True)
        x, y = rng.uniform(-1, 1, 2)
        nearest = nearest_in(domain, x, y)
        fx, fy = posture.feet[(3, 3, 0, 0)[shift.leg]]
        opposite = (nominal.path.ux * fy - nominal.path.uy * fx) * (1 if domain.left else -1) < 0
        if nearest is None or not opposite:
            continue
        away = math.hypot(nearest[0] - x, nearest[1] - y)
        for _, landing in landings(posture, domain, foothold_map(grid)):
            assert math.hypot(landing.x - x, landing.y - y) >= away - 1e-6


def test_a_domain_may_be_empty():
    nominal = nominal_gait(TITAN, gait(), 0.0)
    posture = posture_of(nominal, random_stance(np.random.default_rng(0)))
    stuck = reaching(nominal, posture.feet, 0.0)
    domain = replace(domain_of(stuck, 2, 0.0, False), limit=-5.0)
    assert nearest_in(domain, 0.0, 0.0) is None
    assert list(landings(stuck, domain, foothold_map(holes()))) == []


def test_own_exit_is_what_method_1_compares_with():
    for _, nominal, posture, shift in cases(50, seed=9):
        domain = domain_of(posture, shift.leg, shift.g, True)
        for _, landing in landings(posture, domain, foothold_map(holes(span=4.0))):
            if domain.hind:
                own = line_exit(
                    landing.x, landing.y, nominal.boxes[shift.leg], nominal.path.ux, nominal.path.uy
                )
                assert (
                    shift.g - 1e-6
                    <= domain.crossing(landing.x, landing.y)
                    <= min(domain.limit, own) + 1e-6
                )
