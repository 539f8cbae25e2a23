"""What a step along a trace expects after it is what its prediction says."""

import pytest

from walking_console import Simulation, load_scenario
from walking_console.planner.stability import support_polygon
from walking_console.planner.trace.expected_supports import AHEAD, expected_supports


def running_steps(ticks):
    """The steps of the shipped curve as they begin: planner, stance and plan."""
    simulation = Simulation(load_scenario("k-curve"))
    simulation.drive(speed=0.15)
    begun = 0
    for _ in range(ticks):
        simulation.step()
        if simulation.walk.steps_begun != begun and simulation.walk.steps:
            begun = simulation.walk.steps_begun
            yield simulation.planner.walk, simulation.walk.stance, simulation.walk.plan


def carrying(move):
    """The feet that stay on the ground while the legs of a move are in the air."""
    feet = enumerate(move.before)
    return [foot for leg, foot in feet if foot is not None and leg not in move.legs]


def test_the_feet_that_are_to_carry_are_those_of_the_prediction():
    seen = 0
    for walk, stance, plan in running_steps(600):
        expected = expected_supports(walk.prediction, stance, plan)
        assert len(expected) <= AHEAD
        moves = walk.prediction.moves
        for support in expected:
            polygons = [
                support_polygon(
                    f for leg, f in enumerate(m.before) if f is not None and leg not in m.legs
                )
                for m in moves
            ]
            assert support.polygon in polygons
            assert 0.0 <= support.lift < support.land
            seen += 1
    assert seen >= 10


def test_supports_follow_one_another_in_time():
    for walk, stance, plan in running_steps(300):
        supports = expected_supports(walk.prediction, stance, plan)
        for before, after in zip(supports, supports[1:], strict=False):
            assert after.lift >= before.land


def test_without_a_prediction_nothing_is_expected():
    _, stance, plan = next(running_steps(50))
    assert expected_supports(None, stance, plan) == ()
    with pytest.raises(StopIteration):
        next(running_steps(0))
