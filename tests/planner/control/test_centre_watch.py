"""Where the centre of gravity truly is, by what the feet carry."""

import pytest

from tests.planner.control.plans import FEET, HEIGHT, TITAN
from walking_console.planner.control.centre_watch import FARTHEST, FASTEST, SLACK, CentreWatch
from walking_console.planner.control.execution import feet_absolute
from walking_console.planner.stability import GRAVITY
from walking_console.planner.statics import centre_of_gravity, planned_loads
from walking_console.planner.types import Sensing

WEIGHT = TITAN.mass * GRAVITY
FEET_B = tuple((x, y, -HEIGHT) for x, y, _ in FEET)


def reading(off=(0.0, 0.0), weight=1.0, body=(1.0, 2.0, HEIGHT, 0.0, 0.0, 0.0), soles=None):
    """What a machine senses whose centre of gravity is so far off and that weighs so much."""
    x, y, _ = centre_of_gravity(TITAN, FEET_B)
    on = soles or (True,) * 4
    shares = [1.0 if sole else 0.0 for sole in on]
    loads = planned_loads(weight * WEIGHT, (x + off[0], y + off[1]), FEET_B, shares).newtons
    return Sensing(0, body, FEET_B, on, (0,) * 4, (False,) * 4, loads=loads)


def learnt(*args, ticks=400, share=0.01, acceleration=(0.0, 0.0), **kwargs):
    watch = CentreWatch(TITAN, share)
    for _ in range(ticks):
        watch.learn(reading(*args, **kwargs), acceleration)
    return watch


def test_place_and_weight_of_a_machine_that_is_other_than_its_file_are_learnt():
    watch = learnt((0.02, -0.015), 1.2)
    assert watch.off == pytest.approx((0.02, -0.015), abs=FASTEST)
    assert watch.weight == pytest.approx(1.2)


def test_one_that_is_as_its_file_says_stays_as_it_is_to_the_last_digits():
    watch = learnt()
    assert watch.off == pytest.approx((0.0, 0.0), abs=1e-12)
    assert watch.weight == pytest.approx(1.0, abs=1e-12)


def test_the_place_is_in_axes_of_the_body_whichever_way_it_faces():
    watch = learnt((0.02, 0.01), body=(0.0, 0.0, HEIGHT, 0.0, 0.0, 1.3))
    assert watch.off == pytest.approx((0.02, 0.01), abs=FASTEST)


def test_what_a_body_that_speeds_up_shifts_is_not_taken_for_its_centre():
    ahead = 0.2
    _, _, z = centre_of_gravity(TITAN, FEET_B)
    watch = learnt((-ahead * (z + HEIGHT) / GRAVITY, 0.0), acceleration=(ahead, 0.0))
    assert watch.off == pytest.approx((0.0, 0.0), abs=1e-6)


def test_the_body_is_led_aside_no_faster_and_no_farther_than_it_may():
    assert learnt((0.02, 0.0), ticks=3).off[0] == pytest.approx(3 * FASTEST)
    assert learnt((0.08, 0.0)).off[0] == pytest.approx(FARTHEST, abs=FASTEST)


def test_a_centre_that_is_hardly_off_is_left_where_it_is():
    assert learnt((0.9 * SLACK, 0.0)).off == (0.0, 0.0)
    assert learnt((1.1 * SLACK, 0.0)).off[0] == pytest.approx(1.1 * SLACK, abs=FASTEST)


def test_two_feet_or_a_body_in_the_air_say_nothing():
    assert learnt((0.0, 0.0), soles=(True, False, True, False)).off == (0.0, 0.0)
    assert learnt((0.02, 0.0), 0.3).weight == 1.0
    assert learnt((0.02, 0.0), 1.2, share=0.0).off == (0.0, 0.0)


def test_a_corrected_reading_has_its_body_over_its_centre_and_its_feet_where_they_are():
    watch = learnt((0.02, -0.015))
    seen = reading(body=(1.0, 2.0, HEIGHT, 0.02, -0.03, 0.7))
    corrected = watch.corrected(seen)
    for foot, same in zip(feet_absolute(corrected), feet_absolute(seen), strict=True):
        assert foot == pytest.approx(same, abs=1e-12)
    (x, y, _), (fx, fy, _) = seen.feet_b[0], corrected.feet_b[0]
    assert (x - fx, y - fy) == pytest.approx(watch.off)
