"""Level C for a machine whose legs give."""

from dataclasses import replace

import pytest

from tests.planner.control.plans import swing_plan
from walking_console import load_machine
from walking_console.planner.config import PlannerConfig
from walking_console.planner.control.compliant_controller import CompliantController, RigidMotion
from walking_console.planner.control.foot_controller import ReflexState
from walking_console.planner.control.tracking import TrajectoryTracker
from walking_console.planner.motion.step_builder import holding_plan
from walking_console.planner.stability import GRAVITY
from walking_console.planner.statics import RAMP
from walking_console.planner.types import TICK, Phase, Sensing, Stance

TITAN = load_machine("titan3")
FEET = tuple((*leg.centre, 0.0) for leg in TITAN.legs)
FEET_B = tuple((x, y, -TITAN.height) for x, y, _ in FEET)
STANDING = TrajectoryTracker(holding_plan(Stance((0.0, 0.0, TITAN.height, 0.0), FEET)))
EVEN = TITAN.mass * GRAVITY / 4


def reading(feet=FEET_B, roll=0.0, pitch=0.0, loads=(EVEN,) * 4, **more) -> Sensing:
    on = (True,) * 4
    body = (9.0, 9.0, TITAN.height, roll, pitch, 0.0)  # wherever it takes itself to be
    return Sensing(0, body, feet, on, (0,) * 4, (False,) * 4, loads=loads, **more)


def told(sensing: Sensing):
    controller = CompliantController(TITAN, PlannerConfig())
    velocities, _ = controller.velocities(STANDING, 0.0, sensing, ReflexState.begin(4))
    return velocities, controller


def test_feet_in_their_places_stay_and_press_with_their_loads_wherever_the_body_is():
    velocities, controller = told(reading())
    assert velocities == [(0.0, 0.0, 0.0)] * 4
    assert controller.loads == pytest.approx([EVEN] * 4)


def test_a_few_percent_of_what_all_feet_are_off_is_closed_in_a_tick():
    velocities, _ = told(reading(tuple((x - 0.01, y, z) for x, y, z in FEET_B)))
    for vx, vy, vz in velocities:
        assert vx * TICK == pytest.approx(0.03 * 0.01) and vy == vz == pytest.approx(0.0)


def test_feet_that_stand_are_not_pulled_against_each_other():
    x, y, z = FEET_B[0]
    feet = ((x + 0.01, y + 0.01, z), *FEET_B[1:])
    velocities, _ = told(reading(feet))
    for one in range(4):
        for two in range(one):
            apart = [feet[one][k] - feet[two][k] for k in range(3)]
            moving = [velocities[one][k] - velocities[two][k] for k in range(3)]
            assert sum(a * v for a, v in zip(apart, moving, strict=True)) == pytest.approx(0.0)


def test_a_torso_that_leans_is_levelled_and_its_turning_is_damped():
    left_up, _ = told(reading(roll=0.02))
    # left feet are drawn up towards the body, right feet put out
    assert left_up[0][2] > 0.0 > left_up[3][2]
    turning, _ = told(reading(rates=(0.1, 0.0, 0.0)))
    assert turning[0][2] > 0.0 > turning[3][2]


def test_a_leg_that_carries_too_little_reaches_down_and_the_others_give_way():
    velocities, _ = told(reading(loads=(0.0, EVEN, EVEN, EVEN)))
    assert velocities[0][2] < 0.0 < velocities[1][2]
    assert sum(v[2] for v in velocities) == pytest.approx(0.0)


def test_legs_still_to_rise_give_way_to_those_that_hang_while_the_plan_waits_for_them():
    plan = swing_plan()
    at_once = TrajectoryTracker(replace(plan, swing=(0, 1), phases=(Phase.UP, *plan.phases[1:])))
    assert at_once.stretches[0].air == (0, 1)
    hanging = reading(loads=())._replace(soles=(True, True, False, False))
    controller = CompliantController(TITAN, PlannerConfig())
    velocities, _ = controller.velocities(at_once, 0.0, hanging, ReflexState.begin(4))
    assert velocities[2][2] < 0.0 < velocities[0][2]
    assert velocities[3][2] < 0.0 < velocities[1][2]


def test_the_end_of_a_plan_is_walked_in_the_tick_that_begins_the_next():
    controller = CompliantController(TITAN, PlannerConfig())
    on = TrajectoryTracker(holding_plan(Stance((0.001, 0.0, TITAN.height, 0.0), FEET)))
    controller.velocities(STANDING, 0.0, reading(), ReflexState.begin(4))
    controller.take_over(on, 0.0)
    velocities, _ = controller.velocities(on, 0.0, reading(), ReflexState.begin(4))
    assert all(vx == pytest.approx(-0.001 / TICK - 0.03 * 0.001 / TICK) for vx, _, _ in velocities)


def test_a_foot_that_slips_is_remembered_for_a_while():
    controller = CompliantController(TITAN, PlannerConfig())
    controller.believed(reading()._replace(slipping=(False, True, False, False)))
    assert controller.slips
    for _ in range(60):
        controller.believed(reading())
    assert not controller.slips


def test_a_rigid_motion_is_found_again_in_what_it_does():
    spots = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-1.0, -1.0, 0.0)]
    moves = [(0.1 - 0.2 * y, 0.3 + 0.2 * x, 0.5) for x, y, _ in spots]
    found = RigidMotion.nearest(spots, moves)
    assert [found.at(spot) for spot in spots] == [pytest.approx(move) for move in moves]


def test_it_says_which_legs_press_until_the_loads_of_the_plan_before_are_taken_over():
    aside = TrajectoryTracker(holding_plan(Stance((0.2, 0.1, TITAN.height, 0.0), FEET)))
    controller = CompliantController(TITAN, PlannerConfig())
    controller.velocities(STANDING, 0.0, reading(), ReflexState.begin(4))
    controller.take_over(aside, 1.0)
    assert controller.presses([0]) and not controller.presses([])
    ticks = 0
    while controller.presses([0]):
        controller.velocities(aside, 0.0, reading(), ReflexState.begin(4))
        ticks += 1
    assert ticks * TICK == pytest.approx(RAMP, abs=TICK)


def test_a_leg_is_idle_only_where_the_plan_has_it_carry_nothing():
    over_three = Stance((0.0, 0.0, TITAN.height, 0.0), FEET, lifted=(0,))
    controller = CompliantController(TITAN, PlannerConfig())
    assert controller.idle(0.0) == ()
    standing = TrajectoryTracker(holding_plan(over_three), (0,))
    for _ in range(20):
        controller.velocities(standing, 0.0, reading(), ReflexState.begin(4))
    assert 0 in controller.idle(0.0) and 1 not in controller.idle(0.0)
