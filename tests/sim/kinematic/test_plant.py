"""The kinematic plant: servo speeds in, what happens out."""

import math
import timeit

import pytest

from tests.sim.kinematic.machines import (
    HEXAPOD,
    STILL,
    TITAN,
    all_legs,
    flat,
    made,
    one_leg,
    run,
    shaped,
    standing,
    wild,
)
from walking_console.planner.types import Stance
from walking_console.sim.kinematic.plant import KinematicPlant


class TestWalking:
    def test_the_body_goes_where_its_carrying_legs_take_it(self):
        plant = run(standing(), all_legs(-0.1, 0.05, -0.02), 50)
        assert plant.body == pytest.approx([0.1, -0.05, TITAN.height + 0.02, 0.0, 0.0, 0.0])

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

    def test_ground_that_goes_away_under_a_foot_leaves_it_hanging_and_the_body_standing(self):
        plant = standing(x=-0.1, y=-0.1)
        plant.replace_ground(shaped(lambda x, y: math.nan if x > 0.2 and y > 0.2 else 0.0))
        run(plant, STILL, 5)
        assert plant.soles == [False, True, True, True]
        assert plant.state == "standing"

    def test_ground_that_goes_away_in_the_tick_a_foot_comes_down_leaves_it_hanging(self):
        plant = run(standing(up={0: 0.01}, x=-0.1, y=-0.1), one_leg(0, (0.0, 0.0, -0.5)), 1)
        assert plant.soles[0] and plant.carrying == (1, 2, 3)
        plant.replace_ground(shaped(lambda x, y: -0.2 if x > 0.2 and y > 0.2 else 0.0))
        run(plant, STILL, 5)
        assert plant.soles == [False, True, True, True]
        assert plant.feet[0][2] == pytest.approx(0.0)

    def test_a_foot_let_go_while_pulled_towards_a_riser_stays_before_it(self):
        plant = standing(x=-0.1, y=-0.1)
        place = list(plant.feet[0])
        plant.replace_ground(shaped(lambda x, y: 0.11 if x > 0.5 and y > 0.2 else 0.0))
        plant.q.tips[0][0] += 0.1
        assert plant.q.hang(0)
        assert plant.feet[0] == pytest.approx(place)
        assert plant.q.tips[0] == pytest.approx([place[0] + 0.1, place[1] + 0.1, -TITAN.height])

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


@pytest.mark.parametrize(
    "kind", ["flat", "slope", "rough", "stairs", "holes", "poles", "stepping_stones", "dem"]
)
def test_a_thousand_random_ticks_are_the_same_twice_and_never_leave_the_physical(kind):
    ground = made(kind)
    first, second = (wild(ground, seed) for seed in (8, 8))
    assert first == second


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
