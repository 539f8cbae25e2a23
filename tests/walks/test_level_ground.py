"""Walks along a line on level ground: H §4.3 and fig. 6, at every crab angle, the body straight
as printed, and swayed into its supports.
"""

import math

import pytest

from walking_console.planner.motion.quarter_turns import quarter_turns
from walking_console.planner.robot.model import load_machine

from .telling import assert_always_true, walked

CANONICAL = (3, 4, 2, 1)  # order of swing from the standard posture, H §4.3
PRINTED = 'gait.body="straight"'
SWAYED = 'gait.body="sway"'


@pytest.mark.parametrize("degrees", range(-165, 181, 15))
def test_the_standard_gait_holds_at_every_crab_angle(tmp_path, degrees):
    drive = f"drive=[{{t=0.0, crab_angle_deg={degrees}, speed=0.08}}]"
    walk = walked(tmp_path, "flat", PRINTED, drive, "end={time=40.0}", "expect={}")
    assert walk.summary["result"] == "completed"
    assert_always_true(walk)
    n = quarter_turns(load_machine("titan3"), math.radians(degrees))
    expected = [(leg - 1 + n) % 4 + 1 for leg in CANONICAL]
    assert walk.legs == [expected[k % 4] for k in range(len(walk.legs))]
    assert len(walk.legs) >= 12
    for step in walk.steps:
        assert step["planned_margin_min"] == pytest.approx(step["s0"], abs=1e-3)
    assert walk.summary["distance"] == pytest.approx(0.08 * 40.0, rel=0.02)


# of the commanded 0.08 m/s, over 40 s from the start: what is left where the body may speed up by
# no more than its margin allows and has far to go into its supports (docs/physics.md)
SHARES = {0: 1.0, 30: 1.0, 45: 1.0, 75: 0.95, 90: 0.93, 135: 1.0, 180: 1.0, -90: 0.93}


@pytest.mark.parametrize("degrees", SHARES)
def test_a_swaying_body_takes_the_same_steps_in_the_time_its_margin_needs(tmp_path, degrees):
    drive = f"drive=[{{t=0.0, crab_angle_deg={degrees}, speed=0.08}}]"
    walk = walked(tmp_path, "flat", SWAYED, drive, "end={time=40.0}", "expect={}")
    assert_always_true(walk)
    n = quarter_turns(load_machine("titan3"), math.radians(degrees))
    expected = [(leg - 1 + n) % 4 + 1 for leg in CANONICAL]
    assert walk.legs == [expected[k % 4] for k in range(len(walk.legs))]
    share = walk.summary["distance"] / (0.08 * 40.0)
    assert share == pytest.approx(SHARES[degrees], abs=0.01)


def test_two_runs_of_one_scenario_have_one_state_hash_and_another_seed_of_noise_has_not(tmp_path):
    noisy = ("noise={position=0.001}", "end={time=10.0}", "expect={}")
    first, again = (
        walked(tmp_path / name, "flat", *noisy).summary["state_hash"]
        for name in _made(tmp_path, "a", "b")
    )
    other = walked(*_made_path(tmp_path, "c"), "flat", *noisy, "seed=2").summary["state_hash"]
    assert first == again != other


def _made(folder, *names):
    for name in names:
        (folder / name).mkdir()
    return names


def _made_path(folder, name):
    (folder / name).mkdir()
    return (folder / name,)


# gait-spec check value, κ = 1.25; a swaying body would have to speed up more than it may
@pytest.mark.parametrize(("body", "speed"), [("straight", 0.108), ("sway", 0.092)])
def test_a_command_above_v_max_is_walked_at_v_max(tmp_path, body, speed):
    drive = "drive=[{t=0.0, speed=0.5}]"
    walk = walked(tmp_path, "flat", f'gait.body="{body}"', drive, "end={time=20.0}", "expect={}")
    assert_always_true(walk)
    assert walk.summary["mean_speed"] == pytest.approx(speed, abs=0.002)
    assert walk.steps[4]["speed"] == pytest.approx(walk.steps[4]["speed_max"])


@pytest.mark.parametrize(
    ("body", "speed"),
    [("straight", 0.02), ("straight", 0.05), ("straight", 0.1), ("sway", 0.02), ("sway", 0.08)],
)
def test_the_walk_keeps_the_commanded_speed(tmp_path, body, speed):
    drive = f"drive=[{{t=0.0, speed={speed}}}]"
    walk = walked(tmp_path, "flat", f'gait.body="{body}"', drive, "end={time=30.0}", "expect={}")
    assert walk.summary["mean_speed"] == pytest.approx(speed, rel=0.02)
