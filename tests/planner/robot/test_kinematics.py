"""A leg's joints and its foot: one answers the other, for every kind of chain."""

import math
import random

import pytest

from walking_console.planner.robot.chains import (
    Drives,
    LegChain,
    Masses,
    chain_of,
    insect_chain,
    mammal_chain,
    slides_chain,
)
from walking_console.planner.robot.kinematics import (
    forward,
    holding_torques,
    inverse,
    jacobian,
    joint_speeds,
    joint_torques,
    leg_moment,
    link_ends,
    speed_share,
    within_limits,
)

FAST = (5.0, 5.0, 5.0)
STRONG = (100.0, 100.0, 100.0)
HIP = (0.3, -0.2, 0.05)


def turning(*limits: tuple[float, float]) -> Drives:
    return Drives((limits[0], limits[1], limits[2]), FAST, STRONG)


SLIDES = slides_chain(HIP, 0.4, turning((-0.3, 0.3), (-0.2, 0.4), (-1.0, -0.4)))
INSECT = insect_chain(
    HIP, -0.7, (0.054, 0.066, 0.133), turning((-1.3, 1.3), (-1.2, 1.8), (-2.9, -0.05))
)
MAMMAL = mammal_chain(HIP, 0.2, (0.08, 0.35, 0.32), turning((-0.9, 0.9), (-1.4, 1.4), (0.05, 2.6)))
# yaw, a pitch about a slanting axis, and a telescope: no closed form here
SERIAL = chain_of(
    "serial",
    HIP,
    0.3,
    [
        ((0.0, 0.0, 1.0), (0.06, 0.02, 0.0), False),
        ((0.0, -0.8, 0.6), (0.30, 0.0, -0.1), False),
        ((0.6, 0.0, -0.8), (0.0, 0.0, -0.1), True),
    ],
    turning((-1.0, 1.0), (-0.8, 0.8), (0.0, 0.4)),
)
CHAINS = pytest.mark.parametrize(
    "chain", [SLIDES, INSECT, MAMMAL, SERIAL], ids=["slides", "insect", "mammal", "serial"]
)


def some_joints(chain: LegChain, chance: random.Random) -> tuple[float, float, float]:
    a, b, c = (chance.uniform(low, high) for low, high in chain.limits)
    return a, b, c


@CHAINS
def test_the_joints_found_for_a_reachable_foot_put_it_there_to_a_nanometre(chain):
    chance = random.Random(1)
    for _ in range(500):
        foot = forward(chain, some_joints(chain, chance))
        joints = inverse(chain, foot)
        assert joints is not None
        assert math.dist(forward(chain, joints), foot) < 1e-9
        assert within_limits(chain, joints)


@CHAINS
def test_no_joints_are_found_beyond_the_reach(chain):
    x, y, z = chain.hip
    assert inverse(chain, (x + 2.0 * chain.reach, y, z)) is None


@CHAINS
def test_the_joints_found_are_the_same_every_time(chain):
    foot = forward(chain, some_joints(chain, random.Random(2)))
    assert inverse(chain, foot) == inverse(chain, foot)


@CHAINS
def test_the_jacobian_is_what_small_joint_motions_do(chain):
    chance = random.Random(3)
    for _ in range(50):
        joints = some_joints(chain, chance)
        rows = jacobian(chain, joints)
        for k in range(3):
            ahead, behind = list(joints), list(joints)
            ahead[k] += 1e-6
            behind[k] -= 1e-6
            a, b = forward(chain, tuple(ahead)), forward(chain, tuple(behind))
            for axis in range(3):
                assert rows[axis][k] == pytest.approx((a[axis] - b[axis]) / 2e-6, abs=1e-8)


@CHAINS
def test_a_drawn_leg_runs_from_its_hip_to_its_foot(chain):
    joints = some_joints(chain, random.Random(4))
    ends = link_ends(chain, joints)
    assert ends[0] == pytest.approx(chain.hip)
    assert ends[3] == pytest.approx(forward(chain, joints), abs=1e-12)


@CHAINS
def test_joint_speeds_move_the_foot_as_asked(chain):
    joints, wanted = some_joints(chain, random.Random(5)), (0.1, -0.2, 0.3)
    speeds = joint_speeds(chain, joints, wanted)
    assert speeds is not None
    rows = jacobian(chain, joints)
    got = [sum(row[k] * speeds[k] for k in range(3)) for row in rows]
    assert got == pytest.approx(wanted)


@CHAINS
def test_power_at_the_joints_is_power_at_the_foot(chain):
    joints, force, velocity = (
        some_joints(chain, random.Random(6)),
        (3.0, -5.0, -200.0),
        (0.1, 0.2, -0.1),
    )
    torques, speeds = joint_torques(chain, joints, force), joint_speeds(chain, joints, velocity)
    assert sum(t * s for t, s in zip(torques, speeds, strict=True)) == pytest.approx(
        sum(f * v for f, v in zip(force, velocity, strict=True))
    )


@CHAINS
def test_holding_torques_are_the_slope_of_the_legs_energy(chain):
    masses, down = Masses(10.0, (0.4, 0.7, 0.2)), (0.5, -0.3, -9.7)
    joints = some_joints(chain, random.Random(12))

    def energy(at):
        return -sum(m * d for m, d in zip(leg_moment(chain, masses, at), down, strict=True))

    for k, torque in enumerate(holding_torques(chain, masses, joints, down)):
        ahead, behind = list(joints), list(joints)
        ahead[k] += 1e-6
        behind[k] -= 1e-6
        slope = (energy(tuple(ahead)) - energy(tuple(behind))) / 2e-6
        assert torque == pytest.approx(slope, abs=1e-6)


def test_a_limit_of_a_joint_is_a_limit_of_the_foot():
    low = slides_chain((0.0, 0.0, 0.0), 0.0, turning((-0.1, 0.1), (-0.1, 0.1), (-0.5, -0.4)))
    assert inverse(low, (0.1, 0.0, -0.45)) == (0.1, 0.0, -0.45)
    assert inverse(low, (0.101, 0.0, -0.45)) is None


def test_an_insect_leg_by_hand():
    leg = insect_chain((0.0, 0.0, 0.0), 0.0, (1.0, 2.0, 3.0), turning((-3, 3), (-3, 3), (-3, 3)))
    assert forward(leg, (0.0, 0.0, 0.0)) == (6.0, 0.0, 0.0)
    assert forward(leg, (math.pi / 2, 0.0, 0.0)) == pytest.approx((0.0, 6.0, 0.0))
    # the femur straight out, the tibia straight down
    assert forward(leg, (0.0, 0.0, -math.pi / 2)) == pytest.approx((3.0, 0.0, -3.0))
    assert inverse(leg, (3.0, 0.0, -3.0))[2] < 0.0  # the knee is up


def test_a_mammal_leg_by_hand():
    left = mammal_chain((0.0, 1.0, 0.0), 0.0, (0.5, 2.0, 3.0), turning((-3, 3), (-3, 3), (-3, 3)))
    right = mammal_chain((0.0, -1.0, 0.0), 0.0, (0.5, 2.0, 3.0), turning((-3, 3), (-3, 3), (-3, 3)))
    assert forward(left, (0.0, 0.0, 0.0)) == (0.0, 1.5, -5.0)
    assert forward(right, (0.0, 0.0, 0.0)) == (0.0, -1.5, -5.0)
    # a pitch of a quarter turn swings the leg straight back
    assert forward(left, (0.0, math.pi / 2, 0.0)) == pytest.approx((-5.0, 1.5, 0.0))


def test_a_straight_leg_has_no_joint_speeds_along_itself():
    leg = insect_chain((0.0, 0.0, 0.0), 0.0, (1.0, 2.0, 3.0), turning((-3, 3), (-3, 3), (-3, 3)))
    assert joint_speeds(leg, (0.0, 0.0, 0.0), (0.1, 0.0, 0.0)) is None
    assert speed_share(leg, (0.0, 0.0, 0.0), (0.1, 0.0, 0.0)) == math.inf


def test_the_share_of_a_speed_limit_says_how_much_slower_a_motion_must_be():
    slow = slides_chain((0.0, 0.0, 0.0), 0.0, turning((-1, 1), (-1, 1), (-1, 1)))
    assert speed_share(slow, (0.0, 0.0, 0.0), (10.0, 0.0, -2.5)) == pytest.approx(2.0)
