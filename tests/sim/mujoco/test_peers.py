"""The quadruped that our walks are timed against, and the time of a footstep."""

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install mujoco-core")

from tests.sweeps.peers import Peer, footsteps, peer_factor
from walking_console.sim.terrain.ground import Ground

LEVEL = Ground(np.zeros((120, 120)), 0.05, (-3.0, -3.0))


def test_the_peer_trots_over_level_ground_and_does_not_fall():
    peer = Peer(LEVEL, 0.0, 0.0, 0.0)
    assert peer_factor(peer, 4.0) > 0.0
    assert (peer.tick, peer.falls) == (200, 0)
    assert np.ptp(peer.data.qpos[7:19]) > 0.5


def test_a_peer_whose_ground_is_gone_is_set_on_its_feet_again():
    heights = LEVEL.heights.copy()
    heights[:, 62:] = np.nan
    peer = Peer(Ground(heights, 0.05, (-3.0, -3.0)), 0.0, 0.0, 0.0)
    peer_factor(peer, 4.0)
    assert peer.falls > 0
    assert peer.data.xmat[1, 8] > 0.7


def test_of_the_time_of_a_footstep_planning_is_a_part():
    found = footsteps("flat", 8.0)
    assert found.count > 2
    assert 0.0 < found.planning < found.ticks
