"""The trace tables say what the kinds of path declare."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import pytest

from tests.sim.scenario_words import TRACE_SPECS, refusal
from walking_console.planner.geometry.path_kinds import PATH_KINDS, Limits, sampled
from walking_console.sim.scenario_files import (
    scenario_from,
)


@pytest.mark.parametrize("spec", TRACE_SPECS, ids=str)
def test_no_trace_leaves_its_span(spec: dict[str, Any]) -> None:
    scenario = scenario_from(
        {"planner": "trace", "robot": "hexapod", "start": {"x": 1, "yaw_deg": 40}, "trace": spec}
    )
    assert scenario.trace is not None
    drawn = sampled(scenario.trace.path, 0.75, scenario.start_pose)
    x_min, x_max, y_min, y_max = scenario.span()
    assert x_min - 0.01 <= min(drawn.x) and max(drawn.x) <= x_max + 0.01
    assert y_min - 0.01 <= min(drawn.y) and max(drawn.y) <= y_max + 0.01
    assert x_max - x_min < 22.0


@pytest.mark.parametrize("kind", PATH_KINDS)
def test_a_trace_has_the_keys_defaults_and_limits_that_its_kind_declares(kind: str) -> None:
    given = {"kind": kind, **({"waypoints": [[0, 0], [1, 1]]} if kind == "waypoints" else {})}
    table = scenario_from({"planner": "trace", "trace": given}).trace
    assert table is not None
    path = table.path
    for parameter in fields(path):
        if parameter.name != "waypoints":
            assert getattr(table, parameter.name) == getattr(path, parameter.name)
        limits = parameter.metadata.get("limits")
        if isinstance(limits, Limits):
            beyond = {**given, parameter.name: limits.high + 1.0}
            assert f"trace.{parameter.name} should be less than or equal to" in refusal(
                {"planner": "trace", "trace": beyond}
            )
