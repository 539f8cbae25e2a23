"""Scenarios and refusals in few words, for the tests of scenarios."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import strategies as st

from walking_console.planner.robot.model import load_machine
from walking_console.sim.scenario import Scenario, ScenarioError
from walking_console.sim.scenario_files import (
    load_scenario,
    scenario_from,
)

TITAN = load_machine("titan3")


CONTRACT = """
title = "Cross a river as wide as the stride"
robot = "titan3"
planner = "crab"
mode = "predictive"
sensing = "known"
unknown = "flat"
seed = 1

[gait]
duty_factor = 0.75

[terrain]
kind = "river"
width = 0.5

[start]
x = 0.0
y = 0.0
yaw_deg = 0.0

[[drive]]
t = 0.0
crab_angle_deg = 0.0
speed = 0.1
turn_rate_deg_s = 0.0

[end]
time = 120.0

[expect]
distance_min = 3.0
margin_min = -0.001
forbidden_steps_max = 0
emergent_max = 0
falls_max = 0
time_max = 90.0
"""


def refusal(data: Any = None, *changes: str, name: str = "flat") -> str:
    with pytest.raises(ScenarioError) as error:
        scenario_from(data) if data is not None else load_scenario(name, changes)
    assert "\n" not in str(error.value)
    return str(error.value)


def flat(*changes: str) -> Scenario:
    return load_scenario("flat", changes)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3)
    ),
    max_leaves=8,
)


ENTRY = st.tuples(
    st.floats(1, 50),
    st.floats(-180, 180),
    st.floats(0, 0.1),
    st.sampled_from([0.0, 0.0, 5.0, -20.0]),
)


TRACE_SPECS = [
    {"kind": "waypoints", "waypoints": [[0, 0, 0], [2, 1, 45], [1, 3], [4, 0, 0]]},
    {"kind": "line", "length": 20, "direction_deg": 30},
    {"kind": "line", "length": 20, "direction_deg": 30, "yaw": "tangent"},
    {"kind": "sideways"},
    {"kind": "circle", "angle_deg": -300},
    {"kind": "sine", "amplitude": -0.6},
    {"kind": "sine", "yaw": "tangent"},
    {"kind": "spiral"},
    {"kind": "spiral", "radius": 0.5, "radius_end": 2.0, "angle_deg": -700},
    {"kind": "turn"},
]
