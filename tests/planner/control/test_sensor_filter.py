"""What is believed of sensors that scatter."""

import numpy as np
import pytest

from walking_console.planner.control.sensor_filter import SensorFilter
from walking_console.planner.types import TICK, Sensing

FEET = ((0.5, 0.4, -0.8), (-0.5, 0.4, -0.8), (-0.5, -0.4, -0.8), (0.5, -0.4, -0.8))


def reading(feet=FEET, roll=0.0, pitch=0.0, **more) -> Sensing:
    on = (True,) * 4
    return Sensing(0, (0.0, 0.0, 0.8, roll, pitch, 0.0), feet, on, (0,) * 4, (False,) * 4, **more)


def test_the_first_reading_is_believed_whole():
    assert SensorFilter(0.1).believed(reading(roll=0.2)) == reading(roll=0.2)


def test_feet_are_expected_where_they_are_told_to_go():
    sensors = SensorFilter(0.1)
    sensors.believed(reading())
    sensors.expect([(0.5, 0.0, -0.2)] * 4)
    moved = tuple((x + 0.5 * TICK, y, z - 0.2 * TICK) for x, y, z in FEET)
    assert np.allclose(sensors.believed(reading(moved)).feet_b, moved)


@pytest.mark.parametrize("late", [1, 3])
def test_a_reading_that_is_late_is_weighed_against_what_was_expected_then(late):
    sensors = SensorFilter(0.1, late)
    speed, rate, ahead = 0.5, 0.2, 0.1
    for tick in range(60):
        then = max(tick - late, 0) * TICK
        feet = tuple((x + speed * then, y, z) for x, y, z in FEET)
        told = reading(feet, roll=rate * then, rates=(rate, 0.0, 0.0))
        told = told._replace(body=(ahead * then, *told.body[1:]))
        seen = sensors.believed(told)
        sensors.expect([(speed, 0.0, 0.0)] * 4, (ahead * TICK, 0.0, 0.0, 0.0))
    now = tick * TICK
    assert seen.feet_b[0][0] == pytest.approx(FEET[0][0] + speed * now)
    assert seen.body[0] == pytest.approx(ahead * now)


def test_scatter_that_is_late_is_believed_by_its_share():
    sensors = SensorFilter(0.1, 1)
    for _ in range(3):
        sensors.believed(reading())
        sensors.expect([(0.0, 0.0, 0.0)] * 4)
    seen = sensors.believed(reading(tuple((x + 0.01, y, z) for x, y, z in FEET)))
    assert seen.feet_b[0][0] == pytest.approx(FEET[0][0] + 0.001)
    sensors.expect([(0.0, 0.0, 0.0)] * 4)
    seen = sensors.believed(reading(tuple((x + 0.01, y, z) for x, y, z in FEET)))
    assert seen.feet_b[0][0] == pytest.approx(FEET[0][0] + 0.0019)


def test_scatter_is_believed_by_its_share():
    sensors = SensorFilter(0.1)
    sensors.believed(reading())
    seen = sensors.believed(reading(roll=0.1, pitch=-0.2))
    assert seen.body[3:5] == pytest.approx((0.01, -0.02))


def test_turning_that_is_felt_is_believed_at_once():
    sensors = SensorFilter(0.1)
    sensors.believed(reading())
    seen = sensors.believed(reading(roll=0.01, rates=(0.5, 0.0, 0.0)))
    assert seen.body[3] == pytest.approx(0.01)
