"""Every way a request can fail is answered with problem+json."""

import pytest
from fastapi.testclient import TestClient

from tests.server.problem_json import problem_of

COMMAND = {"crab_angle_rad": 0.0, "speed_m_s": 0.08, "turn_rate_rad_s": 0.0, "ttl_s": 0.5}


def test_a_refusal_says_the_value_and_the_limit(client: TestClient) -> None:
    problem = problem_of(client.put("/api/v1/console/command", json={**COMMAND, "ttl_s": 7.5}), 422)
    assert (problem["value"], problem["limit"]) == (7.5, {"le": 1.0})


@pytest.mark.parametrize("text", ["{", "", "\x00", "[" * 100_000, '{"a":' * 50_000, "nonsense"])
def test_what_is_no_json_is_refused(client: TestClient, text: str) -> None:
    response = client.put(
        "/api/v1/console/command", content=text, headers={"content-type": "application/json"}
    )
    assert response.status_code in (400, 422)
    problem_of(response, response.status_code)


NOWHERE = [
    "/nothing",
    "/api/v1/nothing",
    "/server/cli.py",
    "/scene/scene.py",
    "/../server/cli.py",
    "/%2e%2e/scene/scene.py",
    "/vendor/..%2fscene%2fscene.py",
    "/vendor/..%2fpage%2findex.html",
]


@pytest.mark.parametrize("path", NOWHERE)
def test_what_there_is_not_is_404(client: TestClient, path: str) -> None:
    problem_of(client.get(path), 404)


def test_a_wrong_method_is_405(client: TestClient) -> None:
    problem_of(client.delete("/api/v1/console/stop"), 405)


def test_what_is_no_json_is_said_of_the_body_and_not_of_a_field_called_0(
    client: TestClient,
) -> None:
    answer = client.put(
        "/api/v1/console/scenario", content="nope", headers={"content-type": "application/json"}
    )
    problem = problem_of(answer, 422)
    assert problem["field"] == "body" and "no JSON" in problem["detail"]


def test_an_unknown_robot_is_said_of_the_robot_with_those_there_are(client: TestClient) -> None:
    body = {"name": "flat", "robot": "nobody"}
    problem = problem_of(client.put("/api/v1/console/scenario", json=body), 422)
    assert (problem["field"], problem["value"]) == ("robot", "nobody")
    assert "hexapod" in problem["detail"] and "path" not in problem["detail"]
