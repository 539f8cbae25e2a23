"""Falling over, and being caught in time."""

import math

import pytest

from tests.sim.kinematic.machines import (
    STILL,
    TITAN,
    all_legs,
    feet_of,
    one_leg,
    run,
    shaped,
    standing,
)
from walking_console.planner.types import TICK
from walking_console.sim.kinematic.plant import KinematicPlant


def test_a_dug_hole_under_all_feet_is_a_long_fall():
    plant = standing()
    plant.replace_ground(shaped(lambda x, y: math.nan))
    run(plant, STILL, 100)
    assert plant.state == "fallen"


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
