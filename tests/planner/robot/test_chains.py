"""What a leg is made of: the three kinds are chains of joints like any other."""

import random

import pytest

from walking_console.planner.robot.chains import (
    Drives,
    Masses,
    chain_of,
    insect_chain,
    mammal_chain,
    slides_chain,
)
from walking_console.planner.robot.kinematics import forward

DRIVES = Drives(((-1.0, 1.0), (-1.0, 1.0), (-1.0, 1.0)), (1.0, 1.0, 1.0), (1.0, 1.0, 1.0))
HIP = (0.2, 0.3, 0.1)


@pytest.mark.parametrize(
    "chain",
    [
        slides_chain(HIP, 0.5, DRIVES),
        insect_chain(HIP, 0.5, (0.1, 0.2, 0.3), DRIVES),
        mammal_chain(HIP, 0.5, (0.1, 0.2, 0.3), DRIVES),
    ],
    ids=["slides", "insect", "mammal"],
)
def test_the_formula_of_a_kind_is_that_of_its_chain_of_joints(chain):
    parts = [(joint.axis, joint.offset, joint.slides) for joint in chain.joints]
    general = chain_of("serial", chain.hip, chain.facing, parts, DRIVES)
    chance = random.Random(1)
    for _ in range(100):
        joints = tuple(chance.uniform(-1.0, 1.0) for _ in range(3))
        assert forward(chain, joints) == pytest.approx(forward(general, joints), abs=1e-12)


def test_a_foot_is_never_further_from_its_hip_than_the_chain_is_long():
    leg = insect_chain((0.0, 0.0, 0.0), 0.0, (0.1, 0.2, 0.3), DRIVES)
    assert leg.reach == pytest.approx(0.6)
    assert slides_chain((0.0, 0.0, 0.0), 0.0, DRIVES).reach == pytest.approx(3.0)


def test_a_leg_weighs_what_its_links_weigh():
    assert Masses(10.0, (0.1, 0.2, 0.3)).leg == pytest.approx(0.6)
