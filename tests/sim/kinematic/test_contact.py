"""The ground plane: what feet meet there, and when they slide on it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from walking_console.planner.robot.model import Machine, load_machine
from walking_console.planner.stability import GRAVITY
from walking_console.planner.types import TICK, Point, Stance
from walking_console.sim.kinematic.contact import WHISKER, ContactWorld
from walking_console.sim.kinematic.plant import KinematicPlant
from walking_console.sim.terrain.generators import Obstacle
from walking_console.sim.terrain.ground import Ground

TITAN = load_machine("titan3")
SLIPPERY = replace(TITAN, friction=0.3)
GRIP = SLIPPERY.friction * SLIPPERY.mass * GRAVITY
FEET = [(*leg.centre, 0.0) for leg in TITAN.legs]
POLE = Obstacle(1.0, 0.0, 0.0, 1.0, radius=0.1)
BLOCK = Obstacle(0.0, 2.0, 0.0, 0.3, corners=((-0.5, 1.5), (0.5, 1.5), (0.5, 2.5), (-0.5, 2.5)))


class TestSweeps:
    WORLD = ContactWorld((POLE, BLOCK), TITAN)

    def test_a_sweep_finds_where_it_meets_a_pole_and_which_way_its_surface_faces(self):
        touch = self.WORLD.sweep(0.0, 0.0, 2.0, 0.0, 0.5)
        assert touch is not None
        assert touch.share == pytest.approx(0.45)
        assert touch.normal == pytest.approx((-1.0, 0.0))

    def test_it_meets_a_block_square_on_whatever_its_own_direction(self):
        touch = self.WORLD.sweep(-0.4, 1.0, 0.4, 2.0, 0.1)
        assert touch is not None
        assert touch.share == pytest.approx(0.5)
        assert touch.normal == pytest.approx((0.0, -1.0))

    def test_it_passes_over_what_is_lower(self):
        assert self.WORLD.sweep(0.0, 1.0, 0.0, 3.0, 0.31) is None
        assert self.WORLD.sweep(0.0, 1.0, 0.0, 3.0, 0.29) is not None

    def test_of_two_things_in_a_row_it_meets_the_first_that_is_tall_enough(self):
        low, tall = replace(POLE, x=1.0, top=0.2), replace(POLE, x=2.0)
        touch = ContactWorld((tall, low), TITAN).sweep(0.0, 0.0, 4.0, 0.0, 0.5)
        assert touch is not None
        assert touch.share == pytest.approx(1.9 / 4.0)

    def test_only_squares_near_an_obstacle_are_near(self):
        assert self.WORLD.near(0.85, 0.0)
        assert not self.WORLD.near(0.3, 0.3)
        assert self.WORLD.crowds(0.0, 0.0)
        assert not self.WORLD.crowds(-3.0, 0.0)
        assert not ContactWorld((), TITAN).near(0.0, 0.0)


class TestWhiskers:
    WORLD = ContactWorld((POLE,), TITAN)
    REACH = TITAN.foot_radius + WHISKER

    @pytest.mark.parametrize("direction", range(8))
    def test_each_of_eight_directions_has_its_bit(self, direction):
        bearing = direction * math.pi / 4
        far = POLE.radius + self.REACH - 0.002
        x, y = POLE.x - far * math.cos(bearing), POLE.y - far * math.sin(bearing)
        assert self.WORLD.feel(x, y, 0.0, 0.0) == 1 << direction

    def test_they_turn_with_the_body(self):
        x = POLE.x - POLE.radius - self.REACH + 0.002
        # the pole is ahead, the body faces left of it
        assert self.WORLD.feel(x, 0.0, 0.0, math.pi / 2) == 1 << 6

    def test_they_do_not_feel_what_the_foot_stands_above(self):
        assert ContactWorld((replace(POLE, top=0.2),), TITAN).feel(0.85, 0.0, 0.2, 0.0) == 0

    def test_out_of_reach_they_feel_nothing(self):
        assert self.WORLD.feel(POLE.x - POLE.radius - self.REACH - 0.002, 0.0, 0.0, 0.0) == 0


class TestFriction:
    """One pivot at the centre of support and one gear joint: Coulomb's limit to 0.2 %."""

    @staticmethod
    def least_force(ux: float, uy: float, body: tuple[float, float] = (0.0, 0.0)) -> float:
        """What it takes to make the machine slide, as a share of μ m g."""
        low, high = 0.0, 2.0
        for _ in range(20):
            share = (low + high) / 2
            world, held = ContactWorld((), SLIPPERY), True
            for _ in range(3):
                pushed = world.slide(
                    (*body, 0.85, 0.0, 0.0, 0.0), FEET, share * GRIP * ux, share * GRIP * uy, TICK
                )
                held = held and pushed is None
            low, high = (share, high) if held else (low, share)
        return low

    @pytest.mark.parametrize("degrees", [0, 30, 45, 90, 135, 200])
    def test_it_slips_at_the_coulomb_limit_in_every_direction(self, degrees):
        assert self.least_force(
            math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        ) == pytest.approx(1.0, abs=0.002)

    def test_a_body_off_the_centre_of_support_slips_no_sooner(self):
        assert self.least_force(1.0, 0.0, (0.1, 0.2)) == pytest.approx(1.0, abs=0.002)

    def test_far_off_it_the_feet_turn_first(self):
        arm = sum(math.hypot(x, y) for x, y, _ in FEET) / 4
        assert self.least_force(1.0, 0.0, (0.0, 0.9)) == pytest.approx(arm / 0.9, abs=0.002)

    def test_a_slide_gathers_speed_as_newton_says_and_friction_ends_it(self):
        world, x, excess = ContactWorld((), SLIPPERY), 0.0, 0.5
        for tick in range(40):
            feet = [(fx + x, fy, fz) for fx, fy, fz in FEET]
            slip = world.slide(
                (x, 0.0, 0.85, 0.0, 0.0, 0.0),
                feet,
                (1 + excess) * GRIP if tick < 10 else 0.0,
                0.0,
                TICK,
            )
            if slip is None:
                break
            x += slip.dx
            if tick == 9:
                assert x == pytest.approx(0.5 * excess * 0.3 * GRAVITY * 0.2**2, rel=0.05)
        assert tick == 15  # 0.2 s at +0.5 μg, 0.1 s at -μg
        assert not world.sliding

    def test_a_slide_ends_at_a_block(self):
        wall = Obstacle(
            1.5, 0.0, 0.0, 2.0, corners=((1.0, -2.0), (2.0, -2.0), (2.0, 2.0), (1.0, 2.0))
        )
        world, x = ContactWorld((wall,), SLIPPERY), 0.0
        for _ in range(150):
            feet = [(fx + x, fy, fz) for fx, fy, fz in FEET]
            slip = world.slide((x, 0.0, 0.85, 0.0, 0.0, 0.0), feet, 1.5 * GRIP, 0.0, TICK)
            x += slip.dx if slip else 0.0
        assert x + 0.55 == pytest.approx(1.0, abs=0.02)  # the torso's front edge at the wall

    def test_two_slides_among_poles_are_the_same_to_the_last_bit(self):
        rng = np.random.default_rng(9)
        poles = [
            Obstacle(*(float(v) for v in rng.uniform(-3, 3, 2)), 0.0, 1.5, radius=0.05)
            for _ in range(60)
        ]
        poles = [pole for pole in poles if math.hypot(pole.x, pole.y) > 0.8]

        def slide() -> list[tuple[float, ...]]:
            world, pose, path = ContactWorld(poles, SLIPPERY), [0.0, 0.0, 0.0], []
            for tick in range(100):
                c, s = math.cos(pose[2]), math.sin(pose[2])
                feet = [(pose[0] + c * x - s * y, pose[1] + s * x + c * y, z) for x, y, z in FEET]
                body = (pose[0], pose[1], 0.85, 0.0, 0.0, pose[2])
                slip = world.slide(
                    body,
                    feet,
                    2 * GRIP * math.cos(tick / 20),
                    1.5 * GRIP * math.sin(tick / 9),
                    TICK,
                )
                if slip is not None:
                    pose = [a + b for a, b in zip(pose, slip, strict=True)]
                path.append(tuple(pose))
            return path

        assert slide() == slide()


class TestTheMachineAmongPoles:
    @staticmethod
    def plant(pole: Obstacle, up: int | None = None, machine: Machine = TITAN) -> KinematicPlant:
        heights = np.zeros((200, 200))
        feet = tuple((x, y, 0.1 if leg == up else 0.0) for leg, (x, y, _) in enumerate(FEET))
        body = (0.0, 0.0, machine.height, 0.0) if up is None else (-0.1, -0.1, machine.height, 0.0)
        ground = Ground(heights, 0.05, (-5.0, -5.0), obstacles=(pole,))
        return KinematicPlant(
            machine, ground, Stance(body, feet, lifted=() if up is None else (up,))
        )

    def test_the_torso_stops_at_a_pole_and_the_feet_stay(self):
        plant = self.plant(Obstacle(0.7, 0.0, 0.0, 1.5, radius=0.05))
        stood = [tuple(foot) for foot in plant.feet]
        walk(plant, [(-0.1, 0.0, 0.0)] * 4, 100)
        assert plant.body[0] == pytest.approx(0.1, abs=0.003)
        assert [tuple(foot) for foot in plant.feet] == stood
        walk(plant, [(0.1, 0.0, 0.0)] * 4, 50)
        assert plant.body[0] == pytest.approx(0.0, abs=0.003)  # it is not glued to it

    def test_it_passes_over_a_low_one(self):
        plant = self.plant(Obstacle(0.7, 0.0, 0.0, 0.3, radius=0.05))
        walk(plant, [(-0.1, 0.0, 0.0)] * 4, 100)
        assert plant.body[0] == pytest.approx(0.2)

    def test_a_swing_foot_stops_at_a_pole_its_whiskers_having_felt_it_first(self):
        plant = self.plant(Obstacle(0.65, 0.475, 0.0, 0.5, radius=0.05), up=0)
        felt_at = None
        for _ in range(30):
            plant.move([(0.5, 0.0, 0.0), *[(0.0, 0.0, 0.0)] * 3])
            if plant.whiskers[0] and felt_at is None:
                felt_at = plant.feet[0][0]
                assert plant.sense().whiskers[0] & 1
        assert felt_at == pytest.approx(0.6 - WHISKER - TITAN.foot_radius, abs=0.011)
        assert plant.feet[0][0] == pytest.approx(0.6, abs=0.001)
        assert plant.feet[0][0] <= 0.6

    def test_the_foot_goes_over_it_once_it_is_lifted_higher(self):
        plant = self.plant(Obstacle(0.55, 0.475, 0.0, 0.2, radius=0.05), up=0)
        walk(plant, [(0.0, 0.0, 0.5), *[(0.0, 0.0, 0.0)] * 3], 11)
        walk(plant, [(0.5, 0.0, 0.0), *[(0.0, 0.0, 0.0)] * 3], 20)
        assert plant.feet[0][0] == pytest.approx(0.65)

    def test_a_leg_stops_at_a_pole_its_foot_has_not_met(self):
        # between hip and foot, further on
        plant = self.plant(Obstacle(0.52, 0.36, 0.0, 1.5, radius=0.02), up=0)
        walk(plant, [(0.5, 0.0, 0.0), *[(0.0, 0.0, 0.0)] * 3], 20)
        assert 0.5 < plant.feet[0][0] < 0.65
        assert plant.whiskers[0] & 1


def walk(plant: KinematicPlant, velocities: list[Point], ticks: int) -> None:
    for _ in range(ticks):
        plant.move(velocities)
