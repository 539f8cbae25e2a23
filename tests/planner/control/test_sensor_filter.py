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
