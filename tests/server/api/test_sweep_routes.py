"""Sweeps over HTTP: queued with the runs, followed, read, cancelled."""

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from walking_console.server.api.app import create_app
from walking_console.server.api.state import AppSettings, AppState
from walking_console.server.realtime_loop import RealtimeLoop

HERE = "http://127.0.0.1:8000"
SHORT = ["end={time=1.0}", "expect={}", "drive.0.speed=0.05,0.08"]
LONG = ["end={time=3600.0}", "expect={}"]


@pytest.fixture
def running(loop: RealtimeLoop, tmp_path: Path) -> Iterator[tuple[TestClient, AppState]]:
    app = create_app(loop, AppSettings(data=tmp_path))
    with TestClient(app, base_url=HERE) as client:
        yield client, app.state.console


def over(client: TestClient, state: AppState, sweep_id: str) -> dict[str, Any]:
    process = state.sweeps._jobs[sweep_id].process
    assert process is not None
    process.wait(120)
    found: dict[str, Any] = client.get(f"/api/v1/sweeps/{sweep_id}").json()
    return found


def test_a_sweep_is_begun_listed_followed_read_and_drawn(
    running: tuple[TestClient, AppState],
) -> None:
    pytest.importorskip("matplotlib")
    client, state = running
    answer = client.post(
        "/api/v1/sweeps", json={"name": "flat", "settings": SHORT, "seeds": "1:2", "keep": "none"}
    )
    assert answer.status_code == 202, answer.text
    sweep_id = answer.json()["id"]
    assert answer.headers["location"] == f"/api/v1/sweeps/{sweep_id}" and sweep_id == "flat-0001"
    found = over(client, state, sweep_id)
    assert found["state"] == "completed", found
    assert found["result"] == {"runs": 4, "passed": 4} and found["progress"]["done"] == 4
    assert [entry["id"] for entry in client.get("/api/v1/sweeps").json()] == [sweep_id]
    table = client.get(f"/api/v1/sweeps/{sweep_id}/table.csv").text
    rows = list(csv.DictReader(io.StringIO(table)))
    assert [(row["drive.0.speed"], row["seed"]) for row in rows] == [
        ("0.05", "1"), ("0.05", "2"), ("0.08", "1"), ("0.08", "2"),
    ]  # fmt: skip
    curve = client.get(f"/api/v1/sweeps/{sweep_id}/pass-rate.svg")
    assert curve.status_code == 200 and curve.text.lstrip().startswith("<?xml")
    assert "sandbox" in curve.headers["content-security-policy"]
    assert client.get(f"/api/v1/sweeps/{sweep_id}/rows.jsonl").status_code == 404


def test_an_inline_scenario_is_swept(running: tuple[TestClient, AppState]) -> None:
    client, state = running
    body = {"scenario": {"end": {"time": 1.0}}, "settings": ["terrain.kind=flat"], "seeds": "4"}
    sweep_id = client.post("/api/v1/sweeps", json=body).json()["id"]
    assert over(client, state, sweep_id)["result"] == {"runs": 1, "passed": 1}


def test_runs_and_sweeps_wait_in_one_queue_and_are_cancelled(
    running: tuple[TestClient, AppState],
) -> None:
    client, state = running
    run = {"name": "flat", "settings": LONG}
    runs = [client.post("/api/v1/runs", json=run).json()["id"] for _ in range(3)]
    sweep = client.post("/api/v1/sweeps", json={"name": "flat", "settings": LONG}).json()
    states = [client.get(f"/api/v1/runs/{name}").json() for name in runs]
    assert [entry["state"] for entry in states] == ["running", "running", "queued"]
    assert states[2]["before"] == 0 and (sweep["state"], sweep["before"]) == ("queued", 1)
    cancelled = client.delete(f"/api/v1/sweeps/{sweep['id']}").json()
    assert (cancelled["state"], cancelled["reason"]) == ("interrupted", "cancelled")
    assert client.delete(f"/api/v1/runs/{runs[2]}").json()["state"] == "interrupted"
    state.jobs.queue.stop()


@pytest.mark.parametrize(
    "body",
    [
        {"name": "rivr"},
        {"name": "flat", "settings": ["end.time=1.0,1e9"]},
        {"name": "flat", "settings": ["mode=paper", "mode=predictive"]},
        {"name": "flat", "settings": ["speeed=1,2"]},
        {"name": "flat", "settings": ['terrain={file="/etc/passwd"}']},
        {"name": "flat", "settings": ["robot=titan3,/etc/robot.toml"]},
        {"scenario": {}, "settings": ["drive=/etc/hand.csv"]},
        {"scenario": {"terrain": {"file": "/etc/passwd"}}},
        {"name": "flat", "seeds": "9:1"},
        {"name": "flat", "seeds": "1:200000"},
        {"name": "flat", "out": "/tmp"},
        {"name": "flat", "scenario": {}},
        {},
    ],
    ids=str,
)
def test_a_sweep_that_makes_no_sense_is_refused_before_it_begins(
    running: tuple[TestClient, AppState], body: dict[str, Any]
) -> None:
    client, state = running
    answer = client.post("/api/v1/sweeps", json=body)
    assert answer.status_code == 422, answer.text
    assert state.sweeps.ids() == []


@pytest.mark.parametrize("name", ["nothing-0001", "..", "%2e%2e", "A"])
def test_a_sweep_there_is_not_is_not_found(running: tuple[TestClient, AppState], name: str) -> None:
    client, _ = running
    assert client.get(f"/api/v1/sweeps/{name}").status_code in (404, 422)
