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


@pytest.mark.parametrize("robot", ["hexapod", "phantomx"])
@pytest.mark.parametrize("name", ["flat", "fig6c", "rough", "holes", "gap"])
def test_a_robot_with_six_legs_is_walked_by_a_planner_that_walks_six(
    client: TestClient, robot: str, name: str
) -> None:
    answer = client.put("/api/v1/console/scenario", json={"name": name, "robot": robot})
    assert answer.status_code == 200, answer.json()
    shown = answer.json()
    assert (shown["robot"], shown["planner"]) == (robot, "trace") and not shown["given_trace"]


def test_a_given_trace_is_left_out_for_a_free_stick(client: TestClient) -> None:
    def given(**more: Any) -> bool:
        body = {"name": "k-sideways", **more}
        return bool(client.put("/api/v1/console/scenario", json=body).json()["given_trace"])

    assert given() and not given(free_stick=True)
