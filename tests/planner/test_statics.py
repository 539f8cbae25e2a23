"""Who carries what: loads by hand, continuous over lift-off, forces inside friction cones."""

import dataclasses
import math
import random

import pytest

from walking_console.planner.robot.chains import Masses
from walking_console.planner.robot.kinematics import forward, link_ends
from walking_console.planner.robot.model import load_machine
from walking_console.planner.stability import GRAVITY
from walking_console.planner.statics import (
    RAMP,
    centre_of_gravity,
    contact_forces,
    load_share,
    planned_loads,
    pushed_at,
)

UP = (0.0, 0.0, 1.0)
SQUARE = [(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)]
SQUARE_FEET = [(x, y, 0.0) for x, y in SQUARE]
ALL = [1.0] * 4


def test_three_feet_carry_what_their_levers_say():
    # at a third of the way from the base of the triangle each foot carries a third
    loads = planned_loads(900.0, (0.0, 1.0), [(-1, 0), (1, 0), (0, 3)], [1.0] * 3)
    assert loads.newtons == pytest.approx((300.0, 300.0, 300.0))
    # on the line from foot 1 to foot 3, half way, foot 2 carries nothing
    loads = planned_loads(900.0, (-0.5, 1.5), [(-1, 0), (1, 0), (0, 3)], [1.0] * 3)
    assert loads.newtons == pytest.approx((450.0, 0.0, 450.0), abs=1e-6)
    assert loads.balanced


def test_four_feet_under_the_middle_carry_a_quarter_each():
    assert planned_loads(800.0, (0.0, 0.0), SQUARE, ALL).newtons == pytest.approx((200.0,) * 4)


def test_four_feet_carry_a_plane_of_loads():
    # 0.1 m ahead of the middle: the front pair takes 0.6 of the weight
    loads = planned_loads(800.0, (0.1, 0.0), SQUARE, ALL)
    assert loads.newtons == pytest.approx((240.0, 160.0, 160.0, 240.0))


def test_a_foot_that_would_have_to_pull_carries_nothing():
    # near foot 1 the plane of loads would be negative at foot 3
    loads = planned_loads(800.0, (0.3, 0.3), SQUARE, ALL)
    assert loads.balanced
    assert loads.newtons[2] == 0.0
    assert min(loads.newtons) >= 0.0
    assert sum(loads.newtons) == pytest.approx(800.0)
    assert loads.newtons == pytest.approx((480.0, 160.0, 0.0, 160.0))


def test_loads_balance_weight_and_moments_wherever_the_feet_can_carry():
    chance = random.Random(1)
    for _ in range(500):
        feet = [(chance.uniform(-1, 1), chance.uniform(-1, 1)) for _ in range(chance.randint(3, 8))]
        parts = [chance.uniform(0.05, 1.0) for _ in feet]
        x, y = (
            sum(p * f[k] for p, f in zip(parts, feet, strict=False)) / sum(parts) for k in (0, 1)
        )
        shares = [chance.uniform(0.2, 1.0) for _ in feet]
        loads = planned_loads(500.0, (x, y), feet, shares)
        assert loads.balanced
        assert sum(loads.newtons) == pytest.approx(500.0)
        for k, centre in ((0, x), (1, y)):
            moment = sum(n * (f[k] - centre) for n, f in zip(loads.newtons, feet, strict=False))
            assert moment == pytest.approx(0.0, abs=1e-6)
        assert min(loads.newtons) >= 0.0


def test_of_all_loads_that_balance_those_with_the_least_squares_are_taken():
    chance = random.Random(2)
    feet = [(0.6, 0.4), (-0.5, 0.5), (-0.6, -0.4), (0.5, -0.5), (0.0, 0.6)]
    loads = planned_loads(1.0, (0.05, 0.02), feet, [1.0] * 5).newtons
    for _ in range(200):
        a, b, c, d = chance.sample(range(5), 4)
        # a change that keeps force and moments: the null space of four points
        change = null_of_four([feet[k] for k in (a, b, c, d)])
        for size in (1e-3, -1e-3):
            other = list(loads)
            for k, part in zip((a, b, c, d), change, strict=False):
                other[k] += size * part
            if min(other) >= 0.0:
                assert sum(f * f for f in other) >= sum(f * f for f in loads) - 1e-12


def null_of_four(points):
    def area(p, q, r):
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    a, b, c, d = points
    parts = area(b, c, d), -area(a, c, d), area(a, b, d), -area(a, b, c)
    size = max(abs(part) for part in parts) or 1.0
    return [part / size for part in parts]


def test_a_centre_of_gravity_outside_the_feet_is_said_and_carried_at_the_nearest_edge():
    loads = planned_loads(800.0, (0.7, 0.0), SQUARE, ALL)
    assert not loads.balanced
    assert loads.newtons == pytest.approx((400.0, 0.0, 0.0, 400.0))
    assert planned_loads(800.0, (0.1, 0.0), SQUARE[:2], [1.0, 1.0]).balanced is False
    assert planned_loads(800.0, (0.0, 0.0), SQUARE, [0.0] * 4).newtons == (0.0,) * 4


def test_loads_are_continuous_from_four_feet_to_three():
    def at(until):
        shares = [1.0, 1.0, 1.0, load_share(math.inf, until)]
        return planned_loads(800.0, (-0.1, 0.15), SQUARE, shares).newtons

    before = [at(0.3 - 0.001 * k) for k in range(301)]
    for a, b in zip(before, before[1:], strict=False):
        assert max(abs(p - q) for p, q in zip(a, b, strict=False)) < 5.0
    assert before[0] == pytest.approx(planned_loads(800.0, (-0.1, 0.15), SQUARE, ALL).newtons)
    assert before[-1][3] == 0.0
    three = planned_loads(800.0, (-0.1, 0.15), SQUARE, [1.0, 1.0, 1.0, 0.0]).newtons
    assert at(1e-4) == pytest.approx(three, abs=1e-2)


def test_a_leg_counts_half_in_the_middle_of_its_ramp():
    assert load_share(math.inf, RAMP / 2) == pytest.approx(0.5)
    assert load_share(0.0, 1.0) == 0.0
    assert load_share(1.0, 2.0) == 1.0


def test_the_centre_of_gravity_goes_with_the_feet_by_the_mass_of_their_legs():
    machine = load_machine("titan3")
    feet = [(*leg.centre, -0.85) for leg in machine.legs]
    x, y, z = centre_of_gravity(machine, feet)
    assert (x, y) == pytest.approx((0.0, 0.0), abs=1e-12)
    assert z == pytest.approx(-0.85 * 0.12)
    # one foot 0.25 m further ahead: 2.4 of 80 kg go with it
    feet[0] = (feet[0][0] + 0.25, *feet[0][1:])
    assert centre_of_gravity(machine, feet)[0] == pytest.approx(0.25 * 2.4 / 80.0)


def test_a_torso_whose_own_centre_is_off_the_middle_moves_the_centre_of_gravity():
    machine = dataclasses.replace(
        load_machine("titan3"), card_masses=Masses(70.4, (0.0, 0.0, 2.4), (0.02, -0.01, 0.1))
    )
    feet = [(*leg.centre, -0.85) for leg in machine.legs]
    x, y, _ = centre_of_gravity(machine, feet)
    assert (x, y) == pytest.approx((0.0176, -0.0088))


def test_a_jointed_leg_has_its_masses_in_the_middle_of_its_links():
    machine = load_machine("phantomx")
    bare = dataclasses.replace(machine, card_masses=Masses(2.0, (0.0, 0.0, 0.1)))
    chain = machine.chains[0]
    feet = [forward(c, (0.0, 0.5, -1.5)) for c in machine.chains]
    _, _, knee, tip = link_ends(chain, (0.0, 0.5, -1.5))
    z = 6 * 0.1 * (knee[2] + tip[2]) / 2 / 2.6
    assert centre_of_gravity(bare, feet)[2] == pytest.approx(z)


def test_on_level_feet_forces_are_upright_and_balance():
    feet = [(0.5, 0.5, -1.0), (-0.5, 0.5, -1.0), (0.0, -0.5, -1.0)]
    forces = contact_forces(900.0, (0.0, 0.1, 0.0), feet, [UP] * 3, 0.8)
    assert forces is not None
    assert [force[2] for force in forces] == pytest.approx([270.0, 270.0, 360.0])
    assert all(abs(force[0]) + abs(force[1]) < 1e-6 for force in forces)


def test_forces_hold_still_and_stay_in_their_cones_on_uneven_ground():
    chance = random.Random(4)
    held = 0
    for _ in range(40):
        feet = [
            (x + chance.uniform(-0.1, 0.1), y + chance.uniform(-0.1, 0.1), chance.uniform(-1, -0.7))
            for x, y in SQUARE
        ]
        normals = [tilted(chance.uniform(0, 0.4), chance.uniform(0, 6)) for _ in feet]
        forces = contact_forces(700.0, (0.05, 0.02, 0.0), feet, normals, 0.7)
        if forces is None:
            continue
        held += 1
        for axis, wanted in ((0, 0.0), (1, 0.0), (2, 700.0)):
            assert sum(force[axis] for force in forces) == pytest.approx(wanted, abs=1e-5)
        for force, normal in zip(forces, normals, strict=False):
            along = sum(f * n for f, n in zip(force, normal, strict=False))
            across = math.sqrt(max(sum(f * f for f in force) - along * along, 0.0))
            assert across <= 0.7 * along + 1e-6
        for k in range(3):
            a, b = (k + 1) % 3, (k + 2) % 3
            centre = (0.05, 0.02, 0.0)
            moment = sum(
                (p[a] - centre[a]) * f[b] - (p[b] - centre[b]) * f[a]
                for p, f in zip(feet, forces, strict=False)
            )
            assert moment == pytest.approx(0.0, abs=1e-4)
    assert held > 30


def test_ground_steeper_than_friction_holds_nothing():
    feet = [(0.5, 0.5, -1.0), (-0.5, 0.5, -1.0), (0.0, -0.5, -1.0)]
    assert contact_forces(900.0, (0.0, 0.1, 0.0), feet, [tilted(0.9, 0.0)] * 3, 0.5) is None
    assert contact_forces(900.0, (2.0, 0.1, 0.0), feet, [UP] * 3, 0.1) is None


def test_feet_braced_between_two_walls_hold_a_body_that_is_not_over_them():
    """Beyond the feet seen from above, and still held: what flat statics cannot know."""
    feet = [(0.0, 1.0, -0.2), (0.0, -1.0, -0.2), (0.1, 1.0, 0.2), (0.1, -1.0, 0.2)]
    walls = [(0.0, -1.0, 0.0), (0.0, 1.0, 0.0)] * 2
    assert contact_forces(100.0, (0.15, 0.0, 0.0), feet, walls, 1.0) is not None


def tilted(angle, bearing):
    return (
        math.sin(angle) * math.cos(bearing),
        math.sin(angle) * math.sin(bearing),
        math.cos(angle),
    )


def test_a_body_that_speeds_up_is_pushed_from_behind_itself():
    x, y = pushed_at((0.0, 0.0, 0.8), (0.5, 0.0), SQUARE_FEET, ALL)
    assert (x, y) == pytest.approx((-0.5 * 0.8 / GRAVITY, 0.0))
    ground = [(fx, fy, 0.3) for fx, fy, _ in SQUARE_FEET]
    assert pushed_at((0.0, 0.0, 1.1), (0.5, 0.0), ground, ALL) == pytest.approx((x, y))


def test_of_its_acceleration_counts_what_the_feet_that_carry_can_give():
    whole = pushed_at((0.0, 0.0, 0.8), (0.5, 0.0), SQUARE_FEET, ALL)[0]
    leaving = pushed_at((0.0, 0.0, 0.8), (0.5, 0.0), SQUARE_FEET, (1.0, 1.0, 1.0, 0.25))[0]
    assert leaving == pytest.approx(0.25 * whole)
    assert pushed_at((0.0, 0.0, 0.8), (50.0, 0.0), SQUARE_FEET, ALL) == (0.0, 0.0)
    assert pushed_at((0.1, 0.2, 0.8), (0.5, 0.0), SQUARE_FEET, (0.0,) * 4) == (0.1, 0.2)
