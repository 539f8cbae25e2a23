"""A recorded walk played again by rigid bodies."""

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install mujoco-core")

from tests.sweeps.physics import recording_of
from walking_console.planner.statics import RAMP
from walking_console.sim.mujoco.reenact import Reenactment, shares_over
from walking_console.sim.mujoco.settings import Physics, ServoSettings
from walking_console.sim.runs.runner import run_scenario
from walking_console.sim.scenario_files import load_scenario


@pytest.fixture(scope="module")
def level_walk(tmp_path_factory):
    out = tmp_path_factory.mktemp("flat")
    run_scenario(load_scenario("flat", ["end={time=25.0}", "expect={}"]), out)
    return recording_of(out)[1]


def test_a_walk_on_level_ground_is_true_when_its_legs_press_with_their_loads(level_walk):
    verdict = Reenactment(level_walk, Physics(ServoSettings(sag=0.005)), press=True).play()
    assert verdict.true
    assert verdict.tilt < 0.5


def test_a_walk_on_a_slope_of_25_degrees_is_true_as_its_ground_is_the_same_for_all(tmp_path):
    settings = ["end={time=20.0}", "expect={}", 'gait.body="sway"']
    run_scenario(load_scenario("steep", settings), tmp_path)
    recording = recording_of(tmp_path)[1]
    verdict = Reenactment(recording, Physics(ServoSettings(sag=0.005)), press=True).play()
    assert verdict.true
    assert verdict.hang < 0.001 and verdict.tilt < 0.3


def test_without_them_soft_legs_let_it_lean_and_hang(level_walk):
    pressed = Reenactment(level_walk, Physics(ServoSettings(sag=0.005)), press=True).play(600)
    open_loop = Reenactment(level_walk, Physics(ServoSettings(sag=0.005)), press=False).play(600)
    assert open_loop.tilt > 4 * pressed.tilt
    assert open_loop.hang > 0.005


def test_shares_ramp_up_after_a_touch_down_and_down_before_a_lift_off():
    support = np.ones((100, 2), dtype=bool)
    support[40:60, 0] = False
    shares = shares_over(support)
    assert (shares[:, 1] == 1.0).all()
    assert (shares[40:60, 0] == 0.0).all()
    ramp = round(RAMP / 0.02)
    assert (np.diff(shares[40 - ramp : 41, 0]) < 0.0).all()
    assert (np.diff(shares[60 : 60 + ramp, 0]) > 0.0).all()
    assert shares[0, 0] == shares[99, 0] == 1.0
