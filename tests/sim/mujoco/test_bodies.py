"""Torso and legs as MuJoCo moves them."""

import math

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install mujoco-core")

from walking_console.planner.geometry.transforms import rotation
from walking_console.planner.robot.model import load_machine
from walking_console.sim.mujoco.bodies import Bodies, roll_pitch_yaw
from walking_console.sim.mujoco.model import standard_joints
from walking_console.sim.mujoco.settings import Physics
from walking_console.sim.terrain.ground import Ground

TITAN = load_machine("titan3")
LEVEL = Ground(np.zeros((80, 80)), 0.05, (-2.0, -2.0))
JOINTS = [standard_joints(TITAN, leg) for leg in range(4)]
FLAT = np.array([value for joints in JOINTS for value in joints])


def standing() -> Bodies:
    bodies = Bodies(TITAN, LEVEL, Physics())
    bodies.place((0.0, 0.0, TITAN.height, 0.0), JOINTS)
    return bodies


def test_it_is_put_where_it_is_wanted():
    bodies = standing()
    assert bodies.place_of_torso() == (0.0, 0.0, TITAN.height)
    assert np.allclose(bodies.joints(), JOINTS)
    assert roll_pitch_yaw(bodies.attitude(), 0.0) == pytest.approx((0.0, 0.0, 0.0))


def test_the_feet_carry_the_whole_weight_once_it_stands():
    bodies = standing()
    for _ in range(100):
        loads = bodies.run(FLAT, FLAT, np.zeros(12))
    assert sum(loads) == pytest.approx(80.0 * 9.81, rel=1e-3)
    assert not bodies.torso_touches
    assert bodies.side_contacts() == []


def test_a_state_is_gone_on_from_to_the_last_bit():
    one, other = standing(), standing()
    for _ in range(10):
        one.run(FLAT, FLAT, np.zeros(12))
    other.restore(one.state())
    for bodies in (one, other):
        for _ in range(10):
            bodies.run(FLAT, FLAT, np.zeros(12))
    assert np.array_equal(one.state(), other.state())


def test_other_relief_of_the_same_size_is_to_the_last_bit_what_a_model_of_its_own_makes_of_it():
    y, x = np.mgrid[0:80, 0:80] * 0.05
    before = Ground(0.03 * np.sin(3.0 * x) * np.cos(2.0 * y), 0.05, (-2.0, -2.0), relief=True)
    after = Ground(0.05 * np.cos(2.0 * x + y) - 0.02, 0.05, (-1.9, -2.2), relief=True)
    one, other = (Bodies(TITAN, ground, Physics()) for ground in (before, after))
    one.place((0.0, 0.0, TITAN.height + 0.05, 0.0), JOINTS)
    for _ in range(10):
        one.run(FLAT, FLAT, np.zeros(12))
    other.restore(one.state())
    model = one.built.model
    one.rebuild(after)
    assert one.built.model is model
    for name in ("hfield_data", "hfield_size", "geom_pos", "geom_size", "geom_rbound"):
        assert np.array_equal(getattr(model, name), getattr(other.built.model, name)), name
    for name in ("geom_aabb", "bvh_aabb"):
        assert np.array_equal(getattr(model, name), getattr(other.built.model, name)), name
    for bodies in (one, other):
        for _ in range(50):
            bodies.run(FLAT, FLAT, np.zeros(12))
    assert np.array_equal(one.state(), other.state())


def test_relief_of_another_size_is_another_model():
    bodies = standing()
    slope = np.add.outer(np.zeros(60), 0.001 * np.arange(80))
    for rows in (60, 50):
        bodies.rebuild(Ground(slope[:rows], 0.05, (-1.5, -2.0), relief=True))
        assert int(bodies.built.model.hfield_nrow[0]) == rows


def test_a_state_of_another_machine_is_refused():
    with pytest.raises(ValueError, match="a state of this machine has [0-9]+ numbers, got 3"):
        standing().restore(np.zeros(3))


def test_a_tick_must_be_whole_steps():
    with pytest.raises(ValueError, match="a tick of 0.02 s must be whole steps"):
        Bodies(TITAN, LEVEL, Physics(step=0.003, contact_time=0.01))


def test_a_push_ends_after_its_ticks():
    bodies = standing()
    bodies.push(100.0, 0.0, 2)
    for left in (1, 0, 0):
        bodies.run(FLAT, FLAT, np.zeros(12))
        assert bodies.push_ticks == left
    assert bodies.data.xfrc_applied.max() == 0.0


def test_angles_are_those_of_the_rotation_and_the_yaw_does_not_jump():
    turn = rotation(0.1, -0.2, 3.0)
    assert roll_pitch_yaw(turn, 3.0) == pytest.approx((0.1, -0.2, 3.0))
    assert roll_pitch_yaw(turn, 3.0 + 4 * math.pi)[2] == pytest.approx(3.0 + 4 * math.pi)
