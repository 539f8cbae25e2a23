"""Scripted runs over HTTP: begun in a process of their own, followed, read, cancelled."""

import json
import os
from collections.abc import Iterator
from pathlib import Path
from threading import Event
from typing import Any

import pytest
from fastapi.testclient import TestClient

from walking_console.server import child_process, job_queue, run_jobs
from walking_console.server.api.app import create_app
from walking_console.server.api.state import AppSettings
from walking_console.server.disk_reads import DiskReads
from walking_console.server.job_queue import AT_ONCE
from walking_console.server.realtime_loop import RealtimeLoop
from walking_console.server.run_jobs import RunJobs

HERE = "http://127.0.0.1:8000"


SHORT = ["end={time=2.0}", "expect={}"]


LONG = ["end={time=3600.0}", "drive=[]"]


@pytest.fixture
def running(loop: RealtimeLoop, tmp_path: Path) -> Iterator[tuple[TestClient, RunJobs]]:
    app = create_app(loop, AppSettings(data=tmp_path))
    with TestClient(app, base_url=HERE) as client:
        yield client, app.state.console.jobs


def over(client: TestClient, runs: RunJobs, run_id: str) -> dict[str, Any]:
    """The state after the child has ended."""
    process = runs._jobs[run_id].process
    assert process is not None
    process.wait(60)
    state: dict[str, Any] = client.get(f"/api/v1/runs/{run_id}").json()
    return state


def test_a_run_is_begun_listed_followed_and_read(running: tuple[TestClient, RunJobs]) -> None:
    client, runs = running
    answer = client.post(
        "/api/v1/runs", json={"name": "flat", "settings": SHORT, "seed": 3, "trace_decisions": True}
    )
    assert answer.status_code == 202
    run_id = answer.json()["id"]
    assert answer.headers["location"] == f"/api/v1/runs/{run_id}" and run_id == "flat-0001"
    state = over(client, runs, run_id)
    assert state["state"] == "completed", state
    assert state["result"]["ticks"] == 100 and len(state["result"]["state_hash"]) == 16
    assert [entry["id"] for entry in client.get("/api/v1/runs").json()] == [run_id]
    told_apart = {key: state["result"][key] for key in ("robot", "planner", "mode", "seed")}
    assert told_apart == {"robot": "titan3", "planner": "crab", "mode": "predictive", "seed": 3}
    summary = client.get(f"/api/v1/runs/{run_id}/run.json").json()
    assert summary["scenario"]["seed"] == 3
    for name in ("ticks.npz", "steps.jsonl", "terrain.npz"):
        assert client.get(f"/api/v1/runs/{run_id}/{name}").status_code == 200
    assert client.delete(f"/api/v1/runs/{run_id}").json()["state"] == "completed", (
        "what is over stays as it is"
    )


def test_an_inline_scenario_runs_and_a_second_run_gets_its_own_name(
    running: tuple[TestClient, RunJobs],
) -> None:
    client, runs = running
    inline = {"scenario": {"end": {"time": 1.0}}}
    ids = [client.post("/api/v1/runs", json=inline).json()["id"] for _ in range(2)]
    assert ids == ["inline-0001", "inline-0002"]
    assert [over(client, runs, run_id)["state"] for run_id in ids] == ["completed", "completed"]


def test_a_third_run_waits_for_its_turn_and_begins_when_another_ends(
    running: tuple[TestClient, RunJobs],
) -> None:
    client, runs = running
    ids = [
        client.post("/api/v1/runs", json={"name": "flat", "settings": LONG}).json()["id"]
        for _ in range(AT_ONCE)
    ]
    third = client.post("/api/v1/runs", json={"name": "flat", "settings": SHORT})
    assert third.status_code == 202 and third.json()["state"] == "queued"
    assert third.json()["before"] == 0
    assert client.get(f"/api/v1/runs/{ids[0]}/run.json").status_code == 404, "not before it is over"
    assert client.delete(f"/api/v1/runs/{ids[0]}").status_code == 202
    assert over(client, runs, ids[0])["state"] == "interrupted"
    waiting = runs._jobs[third.json()["id"]]
    while waiting.waiting:
        client.get("/api/v1/runs")
    assert over(client, runs, third.json()["id"])["state"] == "completed"
    client.delete(f"/api/v1/runs/{ids[1]}")
    assert over(client, runs, ids[1])["state"] == "interrupted"


def test_progress_of_a_run_that_is_over_is_that_of_its_end(
    running: tuple[TestClient, RunJobs],
) -> None:
    client, runs = running
    run_id = client.post("/api/v1/runs", json={"name": "flat", "settings": SHORT}).json()["id"]
    state = over(client, runs, run_id)
    assert state["progress"]["tick"] == state["result"]["ticks"] == 100
    assert state["progress"]["progress"] == 1.0
    assert state["progress"]["distance_m"] == state["result"]["distance"]


def test_so_many_wait_and_no_more_are_taken(
    running: tuple[TestClient, RunJobs], monkeypatch: pytest.MonkeyPatch
) -> None:
    client, runs = running
    monkeypatch.setattr(job_queue, "WAITING_MAX", 0)
    refused = client.post("/api/v1/runs", json={"name": "flat"})
    assert refused.status_code == 429 and runs.ids() == []
    assert refused.headers["content-type"] == "application/problem+json"


def test_a_run_that_fails_says_why(
    running: tuple[TestClient, RunJobs], monkeypatch: pytest.MonkeyPatch
) -> None:
    client, runs = running
    monkeypatch.setattr(child_process, "COMMAND", (*child_process.COMMAND, "no-such-command"))
    run_id = client.post("/api/v1/runs", json={"name": "flat"}).json()["id"]
    state = over(client, runs, run_id)
    assert state["state"] == "failed" and state["reason"]


@pytest.mark.parametrize(
    "body",
    [
        {"name": "rivr"},
        {"name": "flat", "settings": ["end.time=1e9"]},
        {"name": "flat", "settings": ["speeed=1"]},
        {"name": "flat", "settings": ["seed=nan"]},
        {"name": "flat", "settings": ['terrain={file="/etc/passwd"}']},
        {"name": "flat", "settings": ["robot=/etc/robot.toml"]},
        {"name": "flat", "settings": "seed=1"},
        {"name": "flat", "out": "/tmp"},
        {"scenario": {"drive": [{"t": -1.0}]}},
        {"scenario": {}, "settings": ["seed=1"]},
    ],
    ids=json.dumps,
)
def test_a_run_that_makes_no_sense_is_refused_before_it_begins(
    running: tuple[TestClient, RunJobs], body: dict[str, Any]
) -> None:
    client, runs = running
    answer = client.post("/api/v1/runs", json=body)
    assert answer.status_code == 422 and answer.json()["field"]
    assert runs.ids() == []


NAMES = ["nothing-0001", "..", "../x", "%2e%2e", "A", "a" * 65, "a.b", ".hidden", "a%00b", "-a"]


@pytest.mark.parametrize("name", NAMES)
def test_no_name_leads_out_of_the_data_folder(
    running: tuple[TestClient, RunJobs], name: str
) -> None:
    client, _ = running
    for path in (f"/api/v1/runs/{name}", f"/api/v1/runs/{name}/run.json"):
        assert client.get(path).status_code in (404, 422)
        assert client.delete(path).status_code in (404, 405, 422)


@pytest.mark.parametrize(
    "name",
    [
        "scenario.toml",
        "run.json.bak",
        "..%2frun.json",
        "errors.txt",
        "%2e%2e%2f%2e%2e%2fetc%2fpasswd",
    ],
)
def test_only_the_files_of_a_run_are_served(
    running: tuple[TestClient, RunJobs], tmp_path: Path, name: str
) -> None:
    client, _ = running
    (tmp_path / "runs" / "flat-0001").mkdir(parents=True)
    (tmp_path / "runs" / "flat-0001" / "scenario.toml").write_text("secret")
    assert client.get(f"/api/v1/runs/flat-0001/{name}").status_code == 404


def test_a_link_in_a_run_directory_is_not_followed(
    running: tuple[TestClient, RunJobs], tmp_path: Path
) -> None:
    client, _ = running
    (tmp_path / "secret").write_text("secret")
    (tmp_path / "runs" / "flat-0001").mkdir(parents=True)
    (tmp_path / "runs" / "flat-0001" / "steps.jsonl").symlink_to(tmp_path / "secret")
    assert client.get("/api/v1/runs/flat-0001/steps.jsonl").status_code == 404


def test_without_room_no_run_begins(
    running: tuple[TestClient, RunJobs], monkeypatch: pytest.MonkeyPatch
) -> None:
    client, _ = running
    monkeypatch.setattr(run_jobs, "SPACE_MIN", 1e18)
    assert client.post("/api/v1/runs", json={"name": "flat"}).status_code == 507


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes with names here")
def test_a_pipe_in_place_of_a_file_keeps_nobody_waiting(
    running: tuple[TestClient, RunJobs], tmp_path: Path
) -> None:
    client, _ = running
    for folder, names in (("runs", ["run.json"]), ("jobs", ["progress.jsonl", "errors.txt"])):
        (tmp_path / folder / "odd-0001").mkdir(parents=True)
        for name in names:
            os.mkfifo(tmp_path / folder / "odd-0001" / name)
    state = client.get("/api/v1/runs/odd-0001").json()
    assert state["state"] == "interrupted" and state["progress"] is None
    assert client.get("/api/v1/runs/odd-0001/run.json").status_code == 404
    assert client.post("/api/v1/console/stop").json() == {"stopped": True}


def test_a_disk_that_does_not_answer_is_said_and_a_stop_needs_none(
    running: tuple[TestClient, RunJobs], monkeypatch: pytest.MonkeyPatch
) -> None:
    client, runs = running
    died = Event()
    monkeypatch.setattr(runs, "disk", DiskReads(seconds=0.1))
    monkeypatch.setattr(runs, "ids", lambda: died.wait(20.0))
    for _ in range(8):
        assert client.get("/api/v1/runs").status_code == 503
    assert client.post("/api/v1/console/stop").json() == {"stopped": True}
    assert client.get("/").status_code == 200
    died.set()
