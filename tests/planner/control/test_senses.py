"""What a machine whose legs give believes of a reading."""

from tests.planner.control.plans import FEET, HEIGHT, TITAN
from walking_console.planner.control.senses import SLIP_TICKS, Senses
from walking_console.planner.control.sensor_filter import SensorFilter
from walking_console.planner.stability import GRAVITY
from walking_console.planner.types import Sensing

FEET_B = tuple((x, y, -HEIGHT) for x, y, _ in FEET)
WEIGHT = TITAN.mass * GRAVITY


def reading(slipping=(False,) * 4, x=0.0, loads=(WEIGHT / 4,) * 4) -> Sensing:
    feet = tuple((fx + x, fy, fz) for fx, fy, fz in FEET_B)
    body = (0.0, 0.0, HEIGHT, 0.0, 0.0, 0.0)
    return Sensing(0, body, feet, (True,) * 4, (0,) * 4, slipping, loads=loads)


def test_a_slip_is_remembered_for_so_many_ticks():
    senses = Senses(TITAN, 0.0)
    senses.believed(reading((False, True, False, False)))
    ticks = 0
    while senses.slips:
        senses.believed(reading())
        ticks += 1
    assert ticks == SLIP_TICKS


def test_readings_are_believed_as_they_are_unless_they_scatter():
    senses = Senses(TITAN, 0.0)
    senses.believed(reading())
    assert senses.believed(reading(x=0.01)) == reading(x=0.01)
    senses.filter = SensorFilter(0.1)
    senses.believed(reading())
    assert abs(senses.believed(reading(x=0.01)).feet_b[0][0] - FEET_B[0][0] - 0.001) < 1e-12


def test_a_centre_that_is_off_is_learnt_and_corrected():
    senses = Senses(TITAN, 0.01)
    left = (0.28 * WEIGHT, 0.28 * WEIGHT, 0.22 * WEIGHT, 0.22 * WEIGHT)
    for _ in range(200):
        seen = senses.believed(reading(loads=left))
    assert senses.centre.off[1] > 0.01
    assert seen.body[1] == senses.centre.off[1]


def test_what_speeds_up_by_plan_is_expected_of_the_loads():
    still, speeding = Senses(TITAN, 0.01), Senses(TITAN, 0.01)
    for _ in range(50):
        for senses, ahead in ((still, 0.0), (speeding, 0.2)):
            senses.believed(reading())
            senses.expect([(0.0, 0.0, 0.0)] * 4, (ahead, 0.0))
    assert speeding.centre.off[0] > still.centre.off[0] + 0.005
