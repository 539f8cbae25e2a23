"""Feet that carry: they give way, slide, and lie on slopes."""

from dataclasses import replace

import pytest

from tests.sim.kinematic.machines import STILL, TITAN, feet_of, one_leg, run, shaped, standing
from walking_console.sim.kinematic import support
from walking_console.sim.kinematic.support import slope_at


def test_the_slope_under_a_foot_is_that_of_the_cells_around_it_and_a_riser_is_no_slope():
    ramp = shaped(lambda x, y: 0.3 * x - 0.1 * y)
    assert slope_at(ramp, 0.45, 0.475, 0.03) == pytest.approx((0.3, -0.1))
    assert slope_at(ramp, 0.493, 0.461, 0.03) == pytest.approx((0.3, -0.1))
    step = shaped(lambda x, y: 0.2 if x > 0.5 else 0.0)
    assert slope_at(step, 0.48, 0.0, 0.03) == slope_at(step, 0.52, 0.0, 0.03) == (0.0, 0.0)
    assert slope_at(step, 50.0, 0.0, 0.03) == (0.0, 0.0)


def test_edges_and_slope_are_worked_out_anew_only_where_other_places_carry(monkeypatch):
    looked = []

    def look(ground, x, y, span):
        looked.append((x, y))
        return slope_at(ground, x, y, span)

    monkeypatch.setattr(support, "slope_at", look)
    plant = standing(ground=shaped(lambda x, y: 0.1 * x))
    feet = plant._support
    edges, first = feet.edges, len(looked)
    feet.take_stock()
    assert feet.edges is edges
    assert len(looked) == first == 4
    plant.q.feet[1][0] -= 0.05
    feet.take_stock()
    assert feet.edges is not edges
    assert len(looked) == 5


def test_the_edges_are_of_the_feet_that_carry_though_the_body_was_laid_on_them_before():
    plant = standing()
    feet = plant._support
    edges = feet.edges
    plant.q.feet[1][0] -= 0.05
    feet.rest()
    feet.take_stock()
    assert feet.edges != edges


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
