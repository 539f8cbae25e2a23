"""A replay or curve is drawn once, one at a time, and ends with the console."""

import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Thread

import pytest
from fastapi.testclient import TestClient

from walking_console.server import child_process
from walking_console.server.api.app import create_app
from walking_console.server.api.drawings import Drawings
from walking_console.server.api.state import AppSettings
from walking_console.server.limits import DRAWINGS_ASKED_MAX
from walking_console.server.realtime_loop import RealtimeLoop
from walking_console.server.run_jobs import RunJobs
from walking_console.server.sweep_jobs import SweepJobs

HERE = "http://127.0.0.1:8000"
SHORT = ["end={time=0.4}", "expect={}"]
SLEEPS = "import time; time.sleep(60)"  # a program


@pytest.fixture
def running(loop: RealtimeLoop, tmp_path: Path) -> Iterator[tuple[TestClient, RunJobs]]:
    app = create_app(loop, AppSettings(data=tmp_path))
    with TestClient(app, base_url=HERE) as client:
        yield client, app.state.console.jobs


def finished(client: TestClient, runs: RunJobs) -> str:
    """A run that is over, and can be drawn."""
    run_id: str = client.post("/api/v1/runs", json={"name": "flat", "settings": SHORT}).json()["id"]
    process = runs._jobs[run_id].process
    assert process is not None and process.wait(60) == 0
    return run_id


def test_a_replay_is_drawn_once_however_many_ask(
    running: tuple[TestClient, RunJobs], monkeypatch: pytest.MonkeyPatch
) -> None:
    client, runs = running
    run_id = finished(client, runs)
    begun: list[str] = []
    draw = RunJobs.draw

    def counted(self: RunJobs, run_id: str, limit: float) -> None:
        begun.append(run_id)
        draw(self, run_id, limit)

    monkeypatch.setattr(RunJobs, "draw", counted)
    with ThreadPoolExecutor(20) as many:
        asked = many.map(lambda _: client.get(f"/api/v1/runs/{run_id}/replay.html"), range(20))
        statuses = {answer.status_code for answer in asked}
    assert begun == [run_id]
    assert statuses <= {200, 429} and 200 in statuses


def test_a_replay_that_is_being_drawn_ends_with_the_console(
    running: tuple[TestClient, RunJobs], monkeypatch: pytest.MonkeyPatch
) -> None:
    client, runs = running
    run_id = finished(client, runs)
    monkeypatch.setattr(child_process, "COMMAND", (sys.executable, "-c", SLEEPS))
    drawing = Thread(target=runs.draw, args=(run_id, 60.0))
    drawing.start()
    while not runs.drawings._working:
        drawing.join(0.01)
    Drawings(runs).stop()
    drawing.join(10.0)
    assert not drawing.is_alive()
    assert runs.file(run_id, "replay.html") is None


def test_no_more_wait_than_may(
    running: tuple[TestClient, RunJobs], monkeypatch: pytest.MonkeyPatch
) -> None:
    client, runs = running
    run_id = finished(client, runs)
    monkeypatch.setattr(client.app.state.console.drawings, "_asked", DRAWINGS_ASKED_MAX)  # type: ignore[attr-defined]
    assert client.get(f"/api/v1/runs/{run_id}/replay.html").status_code == 429


def test_a_curve_of_a_sweep_is_drawn_once_however_many_ask(
    running: tuple[TestClient, RunJobs], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("matplotlib")
    client, _ = running
    sweeps = client.app.state.console.sweeps  # type: ignore[attr-defined]
    settings = [*SHORT, "drive.0.speed=0.05,0.08"]
    body = {"name": "flat", "settings": settings, "seeds": "1", "keep": "none"}
    sweep_id = client.post("/api/v1/sweeps", json=body).json()["id"]
    assert sweeps._jobs[sweep_id].process.wait(120) == 0
    begun: list[str] = []
    draw = SweepJobs.draw

    def counted(self: SweepJobs, sweep_id: str, limit: float) -> None:
        begun.append(sweep_id)
        draw(self, sweep_id, limit)

    monkeypatch.setattr(SweepJobs, "draw", counted)
    with ThreadPoolExecutor(20) as many:
        asked = many.map(
            lambda _: client.get(f"/api/v1/sweeps/{sweep_id}/pass-rate.svg"), range(20)
        )
        statuses = {answer.status_code for answer in asked}
    assert begun == [sweep_id]
    assert statuses <= {200, 429} and 200 in statuses
