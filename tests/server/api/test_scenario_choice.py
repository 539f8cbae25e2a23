"""The scenario a body names or holds is checked before anything changes."""

from typing import Any

import pytest
from fastapi.testclient import TestClient

from tests.server.problem_json import problem_of


@pytest.mark.parametrize(
    "trace",
    [
        {"kind": "waypoints", "waypoints": [[0.0, 0.0], [0.0, 0.0]]},
        {"kind": "circle", "angle_deg": 0.0},
        {"kind": "sine", "amplitude": 100.0, "length": 0.1, "distance": 1000.0},
        {"kind": "waypoints", "waypoints": [[-1000.0, 0.0], [1000.0, 0.0]] * 500},
    ],
)
def test_a_trace_that_cannot_be_drawn_is_refused_before_anything_changes(
    client: TestClient, trace: dict[str, Any]
) -> None:
    before = client.get("/api/v1/console").json()
    refusal = problem_of(
        client.put(
            "/api/v1/console/scenario", json={"scenario": {"planner": "trace", "trace": trace}}
        ),
        422,
    )
    assert refusal["detail"].startswith("trace: ")
    assert client.get("/api/v1/console").json()["scenario"] == before["scenario"]
