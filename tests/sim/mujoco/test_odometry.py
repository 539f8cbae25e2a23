"""Where the legs say that the body is."""

import math

import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install mujoco-core")

from walking_console.planner.geometry.transforms import point_seen
from walking_console.sim.mujoco.odometry import SLIP, LegOdometry

FEET = [(0.4, 0.4, 0.0), (-0.4, 0.4, 0.0), (-0.4, -0.4, 0.0), (0.4, -0.4, 0.0)]
ALL = [True] * 4


def seen_from(pose, feet=FEET):
    return [point_seen(pose, foot) for foot in feet]


def begun(pose=(0.0, 0.0, 0.8, 0.0)) -> LegOdometry:
    odometry = LegOdometry(pose, 4)
    odometry.update(seen_from(pose), ALL, 0.0, 0.0)
    return odometry


def pose_of(odometry):
    return odometry.x, odometry.y, odometry.z, odometry.yaw


def test_feet_that_stay_tell_where_the_body_has_gone():
    odometry = begun()
    for k in range(1, 50):
        pose = (0.004 * k, 0.002 * k, 0.8 - 0.001 * k, 0.01 * k)
        odometry.update(seen_from(pose), ALL, 0.0, 0.0)
        assert pose_of(odometry) == pytest.approx(pose, abs=1e-9)


def test_a_foot_in_the_air_says_nothing_and_is_taken_up_where_it_comes_down():
    odometry = begun()
    pose = (0.05, 0.0, 0.8, 0.0)
    moved = [(0.9, 0.1, 0.3), *FEET[1:]]
    odometry.update(seen_from(pose, moved), [False, True, True, True], 0.0, 0.0)
    assert pose_of(odometry) == pytest.approx(pose, abs=1e-9)
    odometry.update(seen_from(pose, moved), ALL, 0.0, 0.0)
    assert odometry.anchors[0] == pytest.approx(moved[0], abs=1e-9)


def test_feet_that_bounce_for_a_tick_stand_where_they_stood():
    odometry = begun()
    poses = [(0.002 * k, -0.001 * k, 0.8 + 0.001 * k, 0.003 * k) for k in range(4)]
    for pose in poses[1:3]:
        odometry.update(seen_from(pose), [False, False, False, True], 0.0, 0.0)
    odometry.update(seen_from(poses[3]), ALL, 0.0, 0.0)
    assert pose_of(odometry) == pytest.approx(poses[3], abs=1e-9)
    lifted = [(0.9, 0.1, 0.3), *FEET[1:]]
    odometry.update(seen_from(poses[3], lifted), [False, True, True, True], 0.0, 0.0)
    assert odometry.anchors[0] is None


def test_one_foot_that_slips_is_named_and_the_others_are_believed():
    odometry = begun()
    slipped = [(0.4 + 4 * SLIP, 0.4, 0.0), *FEET[1:]]
    odometry.update(seen_from((0.0, 0.0, 0.8, 0.0), slipped), ALL, 0.0, 0.0)
    assert odometry.slipping == [True, False, False, False]
    assert pose_of(odometry) == pytest.approx((0.0, 0.0, 0.8, 0.0), abs=1e-9)


def test_feet_that_slip_together_carry_the_estimate_off():
    odometry = begun()
    for k in range(1, 11):
        gone = [(x + 0.01 * k, y, z) for x, y, z in FEET]
        odometry.update(seen_from((0.0, 0.0, 0.8, 0.0), gone), ALL, 0.0, 0.0)
    assert odometry.x == pytest.approx(-0.1, abs=1e-9)
    assert not any(odometry.slipping)


def test_a_tilted_body_is_where_its_level_feet_say():
    odometry = begun()
    roll = 0.1
    c, s = math.cos(roll), math.sin(roll)
    feet = [(x, c * y + s * (z - 0.8), -s * y + c * (z - 0.8)) for x, y, z in FEET]
    odometry.update(feet, ALL, roll, 0.0)
    assert pose_of(odometry) == pytest.approx((0.0, 0.0, 0.8, 0.0), abs=1e-9)


def test_it_goes_on_from_its_state():
    odometry, other = begun(), begun((1.0, 2.0, 0.5, 1.0))
    other.restore(odometry.state())
    assert other.state() == odometry.state()
