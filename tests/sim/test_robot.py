"""The simulated machine: servo speeds in, what happens out."""

import math
import timeit
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from pydantic import TypeAdapter

from walking_console.planner.robot.model import Machine, load_machine
from walking_console.planner.types import TICK, Point, Stance
from walking_console.sim.kinematic.configuration import SOLE_GAP
from walking_console.sim.kinematic.plant import KinematicPlant
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
from walking_console.sim.kinematic.support import slope_at
from walking_console.sim.kinematic.swing_feet import STEP_UP
from walking_console.sim.sensor_noise import SensorNoise
from walking_console.sim.terrain.generators import AnyTerrain
from walking_console.sim.terrain.ground import Ground, make_ground

TITAN = load_machine("titan3")
HEXAPOD = load_machine("hexapod")
STILL: list[Point] = [(0.0, 0.0, 0.0)] * 4
CELL = 0.05


def flat(machine: Machine = TITAN, level: float = 0.0) -> Ground:
    return Ground(np.full((200, 200), level), CELL, (-5.0, -5.0))


def shaped(height: Callable[[float, float], float]) -> Ground:
    centres = (np.arange(200) + 0.5) * CELL - 5.0
    return Ground(np.array([[height(x, y) for x in centres] for y in centres]), CELL, (-5.0, -5.0))


def made(kind: str, **parameters: object) -> Ground:
    terrain = TypeAdapter(AnyTerrain).validate_python({"kind": kind, **parameters})
    return make_ground(
        terrain, TITAN, (0.0, 0.0, 0.0), 1, 4.0, None, [leg.centre for leg in TITAN.legs]
    )


def standing(
    machine: Machine = TITAN,
    ground: Ground | None = None,
    x: float = 0.0,
    y: float = 0.0,
    up: dict[int, float] | None = None,
) -> KinematicPlant:
    """On the middles of its reach, body moved to (x, y); ``up`` are feet in the air with their
    height.
    """
    ground, up = ground or flat(), up or {}
    feet = []
    for leg, (fx, fy) in enumerate(leg.centre for leg in machine.legs):
        height = ground.height_at(fx, fy)
        feet.append((fx, fy, (0.0 if math.isnan(height) else height) + up.get(leg, 0.0)))
    return KinematicPlant(
        machine, ground, Stance((x, y, machine.height, 0.0), tuple(feet), lifted=tuple(up))
    )


def all_legs(vx: float, vy: float = 0.0, vz: float = 0.0) -> list[Point]:
    return [(vx, vy, vz)] * 4


def one_leg(leg: int, velocity: Point) -> list[Point]:
    return [velocity if i == leg else (0.0, 0.0, 0.0) for i in range(4)]


def feet_of(plant: KinematicPlant) -> list[tuple[float, ...]]:
    return [tuple(foot) for foot in plant.feet]


def run(plant: KinematicPlant, velocities: Sequence[Point], ticks: int) -> KinematicPlant:
    for _ in range(ticks):
        plant.move(velocities)
    return plant


class TestWalking:
    def test_the_body_goes_where_its_carrying_legs_take_it(self):
        plant = run(standing(), all_legs(-0.1, 0.05, -0.02), 50)
        assert plant.body == pytest.approx([0.1, -0.05, TITAN.height + 0.02, 0.0, 0.0, 0.0])

    def test_carrying_feet_stay_where_they_are_to_the_last_bit(self):
        plant, rng = standing(), np.random.default_rng(1)
        stood = feet_of(plant)
        for _ in range(2000):
            x, y, z = (plant.body[0], plant.body[1], plant.body[2] - TITAN.height)
            vx, vy, vz = (float(v) for v in rng.normal(0, 0.2, 3) + 3.0 * np.array([x, y, z]))
            plant.move(all_legs(vx, vy, vz))
        assert feet_of(plant) == stood
        assert plant.soles == [True] * 4
        assert not any(plant.q.slipping)

    def test_a_turn_leaves_them_there_too(self):
        plant = standing()
        stood = feet_of(plant)
        for k in range(200):
            c, s = math.cos(0.002), math.sin(0.002) * (1 if k < 100 else -1)
            plant.move(
                [
                    ((c * x + s * y - x) / TICK, (c * y - s * x - y) / TICK, 0.0)
                    for x, y, _ in plant.sense().feet_b
                ]
            )
            if k == 99:
                assert plant.body[5] == pytest.approx(0.2)
        assert feet_of(plant) == stood
        assert plant.body == pytest.approx([0.0, 0.0, TITAN.height, 0.0, 0.0, 0.0], abs=1e-9)

    def test_the_monitors_say_where_the_feet_are(self):
        plant, rng = standing(ground=made("rough")), np.random.default_rng(2)
        for _ in range(400):
            plant.move([tuple(v) for v in rng.normal(0, 0.1, (4, 3)).tolist()])
            sensing = plant.sense()
            r = rotation(*sensing.body[3:])
            for foot, foot_b, sole in zip(plant.feet, sensing.feet_b, sensing.soles, strict=True):
                where = [b + t for b, t in zip(sensing.body, turned(r, *foot_b), strict=False)]
                assert where == pytest.approx(foot, abs=2 * SOLE_GAP if sole else 1e-9)

    def test_a_leg_is_lifted_carried_over_and_set_down(self):
        plant = standing(x=-0.1, y=-0.1)
        plant.move(one_leg(0, (0.0, 0.0, 0.5)))
        assert plant.soles == [False, True, True, True]
        assert plant.feet[0][2] == pytest.approx(0.01)
        run(plant, one_leg(0, (0.5, 0.0, 0.0)), 10)
        assert plant.feet[0] == pytest.approx([0.55, 0.475, 0.01])
        plant.move(one_leg(0, (0.0, 0.0, -0.8)))
        assert plant.feet[0] == pytest.approx([0.55, 0.475, 0.0])
        assert plant.soles == [True] * 4
        assert plant.body == pytest.approx([-0.1, -0.1, TITAN.height, 0, 0, 0])
        plant.move(STILL)
        assert plant.carrying == (0, 1, 2, 3)

    def test_a_foot_lifted_slowly_still_leaves_the_ground(self):
        plant = run(standing(x=-0.1, y=-0.1), one_leg(0, (0.0, 0.0, 0.01)), 10)
        assert plant.feet[0][2] == pytest.approx(0.002)
        assert not plant.soles[0]

    def test_no_foot_moves_faster_than_its_limit_nor_beyond_its_mechanical_reach(self):
        plant, rng = standing(up={0: 0.2}, x=-0.1, y=-0.1), np.random.default_rng(3)
        (dx, dy, dz), leg = TITAN.overreach, TITAN.legs[0]
        before = plant.sense().feet_b[0]
        for _ in range(500):
            plant.move(one_leg(0, tuple(float(v) for v in rng.normal(0, 3, 3))))
            now = plant.sense().feet_b[0]
            assert all(
                abs(a - b) <= limit * TICK + 1e-12
                for a, b, limit in zip(now, before, TITAN.speed, strict=True)
            )
            for value, (low, high), slack in zip(
                now, (leg.x, leg.y, leg.z), (dx, dy, dz), strict=True
            ):
                assert low - slack - 1e-9 <= value <= high + slack + 1e-9
            before = now

    def test_a_velocity_that_is_no_number_moves_nothing(self):
        plant = run(standing(), [(math.nan, math.inf, -math.inf)] * 4, 1)
        assert plant.body[0] == 0.0
        assert all(math.isfinite(value) for value in plant.body)

    def test_six_legs_stand_and_walk(self):
        plant = standing(HEXAPOD)
        for _ in range(25):
            plant.move([(-0.1, 0.0, 0.0)] * 6)
        assert plant.body[:3] == pytest.approx([0.05, 0.0, HEXAPOD.height])
        run_up = [(0.0, 0.0, 0.5) if leg % 2 else (0.0, 0.0, 0.0) for leg in range(6)]
        plant.move(run_up)
        assert plant.carrying == (0, 2, 4)
        assert plant.state == "standing"

    def test_a_stance_for_another_machine_is_refused(self):
        with pytest.raises(ValueError, match="6 feet, got 4"):
            KinematicPlant(HEXAPOD, flat(), Stance((0, 0, 0.5, 0), ((0, 0, 0),) * 4))


class TestGround:
    def test_a_foot_stops_on_the_ground_of_its_cell(self):
        plant = standing(ground=made("rough"), up={0: 0.05}, x=-0.1, y=-0.1)
        run(plant, one_leg(0, (0.0, 0.0, -0.7)), 10)
        assert plant.feet[0][2] == plant.q.ground.height_at(*plant.feet[0][:2])
        assert plant.soles[0]

    def test_coming_down_moves_nothing_but_pressing_on_lifts_the_body(self):
        plant = run(standing(up={0: 0.015}, x=-0.1, y=-0.1), one_leg(0, (0.0, 0.0, -0.5)), 2)
        assert plant.feet[0][2] == 0.0
        assert plant.body == pytest.approx([-0.1, -0.1, TITAN.height, 0, 0, 0])
        run(plant, one_leg(0, (0.0, 0.0, -0.5)), 2)
        assert plant.body[2] > TITAN.height + 0.005

    def test_a_foot_that_has_come_down_carries_when_another_is_lifted_in_the_next_tick(self):
        plant = run(standing(up={0: 0.01}, x=-0.15, y=0.0), one_leg(0, (0.0, 0.0, -0.5)), 1)
        run(plant, one_leg(3, (0.0, 0.0, 0.5)), 5)
        assert plant.carrying == (0, 1, 2)
        assert plant.body == pytest.approx([-0.15, 0.0, TITAN.height, 0, 0, 0])

    def test_a_foot_scraping_over_the_ground_carries_nothing_and_drags_nobody(self):
        plant = standing(up={0: 0.005}, x=-0.1, y=-0.1)
        run(plant, one_leg(0, (0.5, 0.0, -0.3)), 10)
        assert plant.soles[0]
        assert plant.q.slipping[0]
        assert plant.carrying == (1, 2, 3)
        assert plant.body == pytest.approx([-0.1, -0.1, TITAN.height, 0, 0, 0])

    def test_a_riser_stops_a_foot_on_its_way_and_its_whiskers_say_where(self):
        plant = standing(
            ground=shaped(lambda x, y: 0.2 if x > 0.55 else 0.0), up={0: 0.1}, x=-0.1, y=-0.1
        )
        run(plant, one_leg(0, (0.5, 0.0, 0.0)), 20)
        assert 0.549 < plant.feet[0][0] <= 0.55
        assert plant.whiskers[0] == 1  # ahead
        assert plant.feet[0][2] == pytest.approx(0.1)
        run(plant, one_leg(0, (0.0, 0.0, 0.8)), 8)
        run(plant, one_leg(0, (0.5, 0.0, 0.0)), 4)
        assert plant.feet[0][0] == pytest.approx(0.59, abs=0.002)  # over it
        assert plant.whiskers[0] == 0

    def test_a_low_riser_is_ridden_over(self):
        plant = standing(
            ground=shaped(lambda x, y: 0.008 if x > 0.55 else 0.0), up={0: 0.002}, x=-0.1, y=-0.1
        )
        run(plant, one_leg(0, (0.5, 0.0, 0.0)), 15)
        assert plant.feet[0][:] == pytest.approx([0.60, 0.475, 0.008])
        assert STEP_UP > 0.008

    def test_a_foot_over_a_hole_finds_no_ground(self):
        plant = standing(
            ground=shaped(lambda x, y: math.nan if x > 0.2 and y > 0.2 else 0.0), x=-0.1, y=-0.1
        )
        assert plant.soles == [False, True, True, True]
        run(plant, one_leg(0, (0.0, 0.0, -0.8)), 30)
        assert not plant.soles[0]
        assert plant.feet[0][2] == pytest.approx(
            TITAN.legs[0].z[0] - TITAN.overreach[2] + TITAN.height
        )

    def test_ground_that_goes_away_under_a_foot_leaves_it_hanging_and_the_body_standing(self):
        plant = standing(x=-0.1, y=-0.1)
        plant.replace_ground(shaped(lambda x, y: math.nan if x > 0.2 and y > 0.2 else 0.0))
        run(plant, STILL, 5)
        assert plant.soles == [False, True, True, True]
        assert plant.state == "standing"

    def test_ground_that_goes_away_under_a_needed_foot_makes_it_tip(self):
        plant = standing(x=0.1, y=0.1)
        plant.replace_ground(shaped(lambda x, y: math.nan if x > 0.2 and y > 0.2 else 0.0))
        run(plant, STILL, 2)
        assert plant.state == "tipping"

    def test_ground_that_rises_under_a_foot_tilts_the_body(self):
        plant = standing(x=0.1, y=0.1)
        plant.replace_ground(shaped(lambda x, y: 0.05 if x > 0.2 and y > 0.2 else 0.0))
        run(plant, STILL, 2)
        assert plant.feet[0][2] == 0.05
        # left side up, over the right feet
        assert plant.body[3] == pytest.approx(math.atan2(0.05, 0.95), rel=0.02)
        assert plant.soles == [True, False, True, True]

    def test_a_dug_hole_under_all_feet_is_a_long_fall(self):
        plant = standing()
        plant.replace_ground(shaped(lambda x, y: math.nan))
        run(plant, STILL, 100)
        assert plant.state == "fallen"

    def test_the_slope_under_a_foot_is_that_of_the_cells_around_it_and_a_riser_is_no_slope(self):
        ramp = shaped(lambda x, y: 0.3 * x - 0.1 * y)
        assert slope_at(ramp, 0.45, 0.475, 0.03) == pytest.approx((0.3, -0.1))
        step = shaped(lambda x, y: 0.2 if x > 0.5 else 0.0)
        assert slope_at(step, 0.48, 0.0, 0.03) == slope_at(step, 0.52, 0.0, 0.03) == (0.0, 0.0)
        assert slope_at(step, 50.0, 0.0, 0.03) == (0.0, 0.0)


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


class TestFeetThatFight:
    def test_a_leg_pulled_aside_a_little_gives_and_its_foot_stays(self):
        plant = standing()
        stood = feet_of(plant)
        run(plant, one_leg(0, (0.1, 0.0, 0.0)), 1)
        assert feet_of(plant) == stood
        assert not any(plant.q.slipping)

    def test_pulled_further_a_foot_slips_and_says_so(self):
        plant = run(standing(), one_leg(0, (0.5, 0.0, 0.0)), 3)
        assert plant.feet[0][0] > 0.45
        assert plant.sense().slipping[0]
        assert plant.state == "standing"


class TestTipping:
    EDGE = math.hypot(*TITAN.legs[0].centre)  # the diagonal of feet 1 and 3 passes under the origin
    OUT = (TITAN.legs[0].centre[1] / EDGE, TITAN.legs[0].centre[0] / EDGE)

    def beyond(self, distance: float, up: float = 0.2) -> KinematicPlant:
        return standing(x=distance * self.OUT[0], y=distance * self.OUT[1], up={0: up})

    def test_five_millimetres_outside_the_polygon_it_stands(self):
        assert run(self.beyond(0.0049), STILL, 200).state == "standing"

    def test_further_out_it_tips(self):
        plant = run(self.beyond(0.0051), STILL, 1)
        assert plant.state == "tipping"

    def test_it_falls_like_a_pendulum_slowly_at_first(self):
        plant = self.beyond(0.02)
        # nothing to catch it
        plant.replace_ground(shaped(lambda x, y: math.nan if x > 0.2 and y > 0.2 else 0.0))
        leans, ticks = [], 0
        while plant.state != "fallen" and ticks < 200:
            plant.move(STILL)
            leans.append(math.hypot(plant.body[3], plant.body[4]))
            ticks += 1
        assert 25 < ticks < 100
        assert all(b >= a for a, b in zip(leans, leans[1:], strict=False))
        arm = math.hypot(TITAN.height, 0.02)
        rate = math.sqrt(9.81 * TITAN.height / (arm**2 + (0.6**2 + 0.25**2) / 12))
        t = 20 * TICK
        assert leans[20] == pytest.approx(0.02 / TITAN.height * (math.cosh(rate * t) - 1), rel=0.1)
        assert feet_of(plant)[1][2] == feet_of(plant)[3][2] == 0.0  # the edge it fell over

    def test_a_fallen_machine_stays_where_it_lies(self):
        plant = self.beyond(0.1)
        plant.replace_ground(shaped(lambda x, y: math.nan if x > 0.2 and y > 0.2 else 0.0))
        run(plant, STILL, 200)
        assert plant.state == "fallen"
        lies = list(plant.body)
        assert run(plant, all_legs(0.5), 10).body == lies

    def test_a_foot_that_comes_down_in_time_catches_it(self):
        plant = self.beyond(0.02, up=0.1)
        run(plant, STILL, 5)
        assert plant.state == "tipping"
        run(plant, one_leg(0, (0.0, 0.0, -0.8)), 7)
        assert plant.state == "standing"
        assert 0 in plant.carrying

    def test_one_that_comes_too_late_does_not(self):
        plant = self.beyond(0.02, up=0.6)
        states = []
        for _ in range(200):
            plant.move(STILL)
            states.append(plant.state)
        assert states[-1] == "fallen"

    def test_a_hard_push_tips_it_and_a_light_one_does_not(self):
        plant = standing()
        plant.push(300.0, 0.0, 10)
        run(plant, STILL, 30)
        assert plant.state == "standing"
        assert plant.body[:2] == [0.0, 0.0]
        plant.push(0.0, 800.0, 60)
        run(plant, STILL, 60)
        assert plant.state == "fallen"

    def test_after_a_short_push_it_falls_back_on_its_feet(self):
        plant = standing()
        plant.push(0.0, 700.0, 5)
        states = []
        for _ in range(100):
            plant.move(STILL)
            states.append(plant.state)
        assert "tipping" in states
        assert states[-1] == "standing"
        assert plant.body[3:5] == pytest.approx([0.0, 0.0], abs=2e-3)

    def test_a_push_that_is_no_number_is_refused(self):
        with pytest.raises(ValueError, match="finite newtons"):
            standing().push(math.nan, 0.0, 1)


class TestSliding:
    def test_on_a_slope_steeper_than_friction_it_slides_down_and_on_a_lesser_one_its_feet_stay(
        self,
    ):
        slope = shaped(lambda x, y: 0.2 * x)
        holds, slides = (standing(replace(TITAN, friction=mu), slope) for mu in (0.21, 0.15))
        stood = feet_of(holds)
        run(holds, STILL, 20)
        assert feet_of(holds) == stood
        moved = [foot[0] for foot in slides.feet]
        run(slides, STILL, 20)
        assert any(slides.sense().slipping)
        assert all(now[0] < before for now, before in zip(slides.feet, moved, strict=True))

    def test_a_push_beyond_friction_slides_machine_and_feet_as_one_and_stops_when_it_ends(self):
        plant = standing(replace(TITAN, friction=0.3))
        stood = [foot[0] for foot in plant.feet]
        plant.push(300.0, 0.0, 10)
        run(plant, STILL, 10)
        assert all(plant.sense().slipping)
        run(plant, STILL, 50)
        assert not any(plant.sense().slipping)
        gone = plant.body[0]
        assert 0.01 < gone < 0.1
        assert [foot[0] - x for foot, x in zip(plant.feet, stood, strict=True)] == pytest.approx(
            [gone] * 4
        )


class TestSensors:
    def test_noise_is_seeded_and_does_not_touch_the_machine(self):
        plants = [
            KinematicPlant(
                TITAN,
                flat(),
                standing_stance(),
                noise=SensorNoise(0.002, 0.01),
                rng=np.random.default_rng(7),
            )
            for _ in range(2)
        ]
        readings = [
            [(run(plant, all_legs(-0.05), 1).sense()) for _ in range(20)] for plant in plants
        ]
        assert readings[0] == readings[1]
        assert plants[0].body[3] == 0.0
        spread = np.std([reading.feet_b[0][1] for reading in readings[0]])
        assert 0.001 < spread < 0.004

    def test_noise_without_a_generator_is_refused(self):
        with pytest.raises(ValueError, match="seeded generator"):
            KinematicPlant(TITAN, flat(), standing_stance(), noise=SensorNoise(0.001))


def standing_stance() -> Stance:
    return Stance((0.0, 0.0, TITAN.height, 0.0), tuple((*leg.centre, 0.0) for leg in TITAN.legs))


@pytest.mark.parametrize(
    "kind", ["flat", "slope", "rough", "stairs", "holes", "poles", "stepping_stones", "dem"]
)
def test_a_thousand_random_ticks_are_the_same_twice_and_never_leave_the_physical(kind):
    ground = made(kind)
    first, second = (wild(ground, seed) for seed in (8, 8))
    assert first == second


def wild(ground: Ground, seed: int) -> list[object]:
    """Random velocities and pushes; what holds at every tick, checked; what happened."""
    rng, plant, happened = np.random.default_rng(seed), standing(ground=ground), []
    velocities = np.zeros((4, 3))
    for tick in range(1000):
        if tick % 7 == 0:
            velocities = rng.normal(0, 0.2, (4, 3)) * (rng.random((4, 1)) < 0.5) + rng.normal(
                0, 0.1, (1, 3)
            )
        if rng.random() < 0.01:
            plant.push(*(float(f) for f in rng.normal(0, 200, 2)), int(rng.integers(1, 20)))
        plant.move([tuple(v) for v in velocities.tolist()])
        sensing = plant.sense()
        assert all(math.isfinite(v) for v in plant.body)
        if plant.state == "fallen":
            break
        for foot in plant.feet:
            assert not foot[2] < ground.height_at(foot[0], foot[1]) - 1e-9, (
                "a foot is below the ground"
            )
        happened.append((tuple(plant.body), feet_of(plant), sensing, plant.state))
    return happened


def test_a_walking_tick_takes_no_time_worth_mentioning():
    plant = standing(up={0: 0.1}, x=-0.1, y=-0.1)
    back, forth = ([(v, 0.0, 0.0)] * 4 for v in (0.001, -0.001))

    def two_ticks() -> None:
        plant.move(back)
        plant.sense()
        plant.move(forth)
        plant.sense()

    # 20 µs on a quiet machine
    assert min(timeit.repeat(two_ticks, number=200, repeat=5)) / 400 < 80e-6
