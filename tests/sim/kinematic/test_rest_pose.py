"""How a stiff body lies on its feet."""

import math

import numpy as np
import pytest

from tests.sim.kinematic.machines import one_leg, run, standing
from walking_console.sim.kinematic.rest_pose import (
    Rest,
    angles,
    attitude,
    lean,
    plane_fit,
    rest,
    rotation,
    turned,
    unturned,
)


class TestRestPose:
    def test_one_leg_longer_rests_the_body_on_its_diagonal_and_lets_a_neighbour_hang(self):
        plant = run(standing(x=0.05, y=-0.05), one_leg(0, (0.0, 0.0, -0.2)), 10)
        assert plant.body[3] == pytest.approx(0.04 / 0.95, rel=0.02)
        assert plant.soles == [True, False, True, True]
        assert plant.feet[1][2] == pytest.approx(0.04, rel=0.02)

    def test_the_fourth_leg_of_an_even_stance_is_on_though_statically_it_need_not_be(self):
        plant = run(standing(), one_leg(0, (0.0, 0.0, 0.02)), 1)  # 0.4 mm up: a sole gives more
        assert plant.soles == [True] * 4

    def test_no_foot_is_below_the_ground_and_three_are_on_it_however_long_the_legs(self):
        rng = np.random.default_rng(5)
        for _ in range(500):
            feet = [
                (*rng.uniform(-0.6, 0.6, 2), rng.uniform(-0.1, 0.1))
                for _ in range(int(rng.integers(4, 9)))
            ]
            lengths = [float(v) for v in rng.uniform(-1.0, -0.8, len(feet))]
            laid = rest(feet, lengths, 0.0, 0.0, Rest(0.9, 0.0, 0.0))
            if laid is None or math.hypot(laid.lean_x, laid.lean_y) > 1.0:  # does not stand; lies
                continue
            roll, pitch = attitude(laid.lean_x, laid.lean_y, 0.7)
            r = rotation(roll, pitch, 0.7)
            assert lean(r) == pytest.approx((laid.lean_x, laid.lean_y))
            gaps = []
            for (x, y, ground), length in zip(feet, lengths, strict=True):
                # the foot is above (x, y): its place across the body is free, its length is not
                # of the way from the body to (x, y, ·) along the body's axis
                up = r[2] * x + r[5] * y
                gaps.append(laid.z + (length - up) / r[8] - ground)
            assert min(gaps) >= -1e-9
            assert sorted(gaps)[2] < 1e-9

    def test_three_feet_that_do_not_surround_the_point_do_not_carry_it(self):
        assert (
            rest(
                [(0.1, 0.1, 0.0), (0.5, 0.1, 0.0), (0.1, 0.5, 0.0)],
                [-0.9] * 3,
                0.0,
                0.0,
                Rest(0.9, 0.0, 0.0),
            )
            is None
        )

    def test_of_two_equal_ways_to_rest_it_stays_with_the_one_it_has(self):
        feet = [(0.5, 0.5, 0.1), (-0.5, 0.5, 0.0), (-0.5, -0.5, 0.1), (0.5, -0.5, 0.0)]
        for tilt in (-0.1, 0.1):  # the body lies on the high diagonal and may rock to either side
            laid = rest(feet, [-0.9] * 4, 0.0, 0.0, Rest(1.0, tilt, -tilt))
            assert laid is not None
            assert laid.lean_x * tilt > 0.0

    def test_rotations_and_their_angles_agree(self):
        rng = np.random.default_rng(6)
        for roll, pitch, yaw in rng.uniform(-1.4, 1.4, (100, 3)):
            r = rotation(roll, pitch, yaw)
            assert angles(r) == pytest.approx((roll, pitch, yaw))
            assert unturned(r, *turned(r, 0.1, 0.2, 0.3)) == pytest.approx((0.1, 0.2, 0.3))
        assert turned(rotation(0.0, 0.1, 0.0), 1.0, 0.0, 0.0)[2] < 0  # pitch: nose down positive
        assert turned(rotation(0.1, 0.0, 0.0), 0.0, 1.0, 0.0)[2] > 0  # roll: left side up positive

    def test_the_fit_finds_the_turn_even_across_the_back(self):
        reached = [(1.0, 0.2), (-0.5, 0.7), (-0.3, -0.9)]
        for yaw in (0.0, 1.0, 3.1, -3.1, 12.0):
            c, s = math.cos(yaw), math.sin(yaw)
            feet = [(2 + c * x - s * y, 3 + s * x + c * y) for x, y in reached]
            assert plane_fit(feet, reached, yaw + 0.1) == pytest.approx((2.0, 3.0, yaw))
