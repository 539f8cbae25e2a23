"""What a touch teaches the map."""

import math

import numpy as np
import pytest

from tests.planner.control.plans import FEET, HEIGHT, flat, now, state_with, swing_plan
from walking_console.planner.control.encounter import ContactEvent, Encounter, FootState
from walking_console.planner.control.feelers import Touch
from walking_console.planner.control.touch_lessons import TouchLessons
from walking_console.planner.control.touch_memory import cells_near

GROUND = flat()
HOME = FEET[0]


def lessons():
    state = state_with()
    state.run.play(swing_plan())
    return TouchLessons(state.run)


def at(dx, height):
    """Foot 0 so far ahead of where it stood, and so high."""
    feet = ((HOME[0] + dx, HOME[1], height), *FEET[1:])
    return now(terrain=GROUND, feet=feet, soles=(False, True, True, True))


def against_a_wall(dx):
    """The leg is drawn as high as it can be, and something is still felt ahead."""
    told = lessons()
    tick = at(dx, 0.4)
    met = Encounter(FootState.CLIMB, 0, (HOME[0] + 0.3, HOME[1], 0.0), felt=0.0)
    told.learn(Touch(ContactEvent.TOP, 0, None), met, tick)
    return told.take()


def test_what_a_leg_cannot_be_drawn_over_stands_higher_than_the_leg_reaches():
    felt = against_a_wall(0.25)
    ceiling = HEIGHT + 0.4 - HEIGHT  # the foot is as high as the leg draws it
    assert felt.heights and min(felt.heights.values()) > ceiling
    xs = [GROUND.centre(*cell)[0] for cell in felt.heights]
    assert min(xs) > HOME[0] + 0.25 - GROUND.cell
    ys = [GROUND.centre(*cell)[1] for cell in felt.heights]
    assert max(ys) - min(ys) == pytest.approx(0.9, abs=2 * GROUND.cell)


def test_the_foot_may_go_back_to_where_it_stood_however_near_the_wall_is():
    felt = against_a_wall(0.0)
    at_home = cells_near(HOME, 0.03, GROUND)
    assert at_home and not at_home & felt.prohibited and not at_home & set(felt.heights)
    assert felt.prohibited


@pytest.mark.parametrize(
    ("state", "dug"), [(None, False), (FootState.PLACE, False), (FootState.DESCEND, True)]
)
def test_there_is_a_hole_where_a_foot_has_gone_as_far_down_as_its_leg_reaches(state, dug):
    met = None if state is None else Encounter(state, 0, HOME)
    told = lessons()
    told.learn(Touch(ContactEvent.NO_GROUND, 0, None), met, at(0.1, -0.2))
    felt = told.take()
    assert bool(felt.prohibited) is dug
    assert all(math.isnan(height) for height in felt.heights.values())


def test_a_foothold_that_gave_way_marks_what_lies_within_ten_centimetres_of_it():
    told = lessons()
    told.gave_way(HOME, GROUND)
    felt = told.take()
    ways = [math.dist(GROUND.centre(*cell), HOME[:2]) for cell in felt.prohibited]
    assert max(ways) <= 0.1 and len(ways) == np.sum(
        [math.dist(GROUND.centre(r, c), HOME[:2]) <= 0.1 for r in range(160) for c in range(160)]
    )
    assert not felt.heights and not told.take()


def test_what_a_foot_went_down_beside_is_as_tall_as_it_was_first_felt_and_its_foot_is_prohibited():
    told = lessons()
    tick = at(0.1, -0.1)
    tick.sensing = tick.sensing._replace(whiskers=(0b10000011, 0, 0, 0))
    told.learn(Touch(ContactEvent.EDGE, 0, None, 0.05), None, tick)
    felt = told.take()
    x = HOME[0] + 0.1
    places = [GROUND.centre(*cell)[0] for cell in felt.heights]
    assert places and min(places) > x + 0.03 and set(felt.heights.values()) == {0.05}
    strip = [GROUND.centre(*cell) for cell in felt.prohibited]
    # as far as it may stand, and a sole beyond
    assert max(a for a, _ in strip) == pytest.approx(x + 0.0866, abs=GROUND.cell)
    assert all(abs(a - x) < 0.0866 + GROUND.cell for a, _ in strip)
    assert max(b for _, b in strip) - min(b for _, b in strip) == pytest.approx(0.3, abs=0.05)
