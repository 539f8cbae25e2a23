"""The app as a whole: every route behind the guard, every failure answered."""

from pathlib import Path

import pytest
from fastapi.routing import APIRoute
from fastapi.testclient import TestClient

from tests.server.problem_json import problem_of
from walking_console.server.api.app import create_app
from walking_console.server.api.state import AppSettings
from walking_console.server.realtime_loop import RealtimeLoop

HERE = "http://127.0.0.1:8000"
PROMISED = {
    "/api/v1/health", "/api/v1/robots", "/api/v1/terrains", "/api/v1/scenarios",
    "/api/v1/console", "/api/v1/console/ahead", "/api/v1/console/decision",
    "/api/v1/console/command", "/api/v1/console/posture", "/api/v1/console/attitude",
    "/api/v1/console/stop", "/api/v1/console/rearm", "/api/v1/console/reset",
    "/api/v1/console/pause", "/api/v1/console/resume", "/api/v1/console/advance",
    "/api/v1/console/rate", "/api/v1/console/scenario", "/api/v1/console/terrain",
    "/api/v1/runs", "/api/v1/runs/{run_id}", "/api/v1/runs/{run_id}/{name}",
}  # fmt: skip


def test_every_promised_route_is_there_with_a_sentence(client: TestClient) -> None:
    paths = client.get("/openapi.json").json()["paths"]
    assert PROMISED <= set(paths)
    assert all(route["description"] for path in paths.values() for route in path.values())


def test_two_apps_share_nothing(loop: RealtimeLoop, tmp_path: Path) -> None:
    one, two = (create_app(loop, AppSettings(data=tmp_path)) for _ in range(2))
    assert one.state.console is not two.state.console
    assert one.state.console.lease is not two.state.console.lease


def test_a_failure_is_answered_with_a_trace_that_the_log_has(
    loop: RealtimeLoop, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    app = create_app(loop, AppSettings(data=tmp_path))

    async def fails() -> None:
        raise ArithmeticError("divided by nothing")

    app.router.routes.insert(0, APIRoute("/fails", fails))
    with TestClient(app, base_url=HERE, raise_server_exceptions=False) as client:
        told = problem_of(client.get("/fails"), 500)
    trace = told["detail"].split()[-1]
    assert f"trace {trace}" in caplog.text and "divided by nothing" in caplog.text
    assert "divided" not in told["detail"], "what failed is for the log only"
