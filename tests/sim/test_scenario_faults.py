"""How refusals of scenarios read."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.sim.scenario_words import JSON, refusal
from walking_console.sim.scenario import Scenario, ScenarioError
from walking_console.sim.scenario_files import (
    load_scenario,
    scenario_from,
)


def test_unknown_names_are_answered_with_the_known_ones() -> None:
    with pytest.raises(ScenarioError, match="unknown scenario 'rivr'; there are: .*flat.*river"):
        load_scenario("rivr")
    assert "unknown terrain kind 'rivr'; there are: flat, slope" in refusal(
        {"terrain": {"kind": "rivr"}}
    )
    assert "unknown key 'sped' in drive.0; there are: t, crab_angle_deg, speed" in refusal(
        {"drive": [{"sped": 1.0}]}
    )
    assert "unknown key 'wide' in terrain; there are: kind" in refusal(
        {"terrain": {"kind": "river", "wide": 1}}
    )
    assert "unknown key 'x' in expect; there are: distance_min" in refusal({"expect": {"x": 1}})
    assert "unknown key 'x' in noise; there are: position" in refusal({"noise": {"x": 1}})
    assert "unknown key 'x' in trace; there are: " in refusal(
        {"planner": "trace", "trace": {"kind": "sine", "x": 1}}
    )
    assert "unknown trace kind 'cirle'; there are: waypoints, line, " in refusal(
        {"planner": "trace", "trace": {"kind": "cirle"}}
    )
    assert "unknown key 'tile'; there are: name, title" in refusal({"tile": "x"})
    assert "'crab' or 'trace', got 'goat'" in refusal({"planner": "goat"})


@pytest.mark.parametrize(
    ("data", "says"),
    [
        ({"seed": 1.0}, "seed should be"),
        ({"seed": -1}, "seed should be"),
        ({"seed": True}, "seed should be"),
        ({"title": 3}, "title should be"),
        ({"drive": 3}, "drive should be"),
        ({"drive": [3]}, "drive.0 should be"),
        ({"terrain": 3}, "terrain should be"),
        ({"terrain": {}}, "terrain needs a kind"),
        ({"end": {"time": 3601}}, "end.time should be less"),
        ({"end": {"time": 0}}, "end.time should be greater"),
        ({"drive": [{"t": 1}, {"t": 1}]}, "drive.1.t must be later than drive.0.t = 1, got 1"),
        ({"drive": [{"t": 5000}]}, "drive.0.t should be less"),
        ({"gait": {"duty_factor": 0.6}}, "at least 0.75"),
        ({"trace": {"kind": "sine"}}, 'needs planner = "trace"'),
        ({"planner": "trace", "trace": {"kind": "sine"}, "drive": [{}]}, "either"),
        ({"planner": "trace", "trace": {"kind": "waypoints"}}, "trace.waypoints is missing"),
        (
            {"planner": "trace", "trace": {"kind": "waypoints", "waypoints": [[0, 0, 0], [1]]}},
            "trace.waypoints.1",
        ),
        ({"terrain": {"kind": "poles", "area": [1, 0, 0, 1]}}, "area must be"),
    ],
)
def test_every_refusal_names_the_place(data: dict[str, Any], says: str) -> None:
    assert says in refusal(data)


@given(st.dictionaries(st.sampled_from(list(Scenario.model_fields)), JSON, max_size=4))
@settings(max_examples=200, deadline=None)
def test_any_data_is_a_scenario_or_refused_in_one_line(data: dict[str, Any]) -> None:
    try:
        scenario_from(data)
    except ScenarioError as error:
        assert "\n" not in str(error)
