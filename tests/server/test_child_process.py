"""A child of the console runs this program and nothing that lies in the working directory."""

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from walking_console.server.api.app import create_app
from walking_console.server.api.state import AppSettings
from walking_console.server.child_process import COMMAND, SECRET, start_child
from walking_console.server.realtime_loop import RealtimeLoop

HERE = "http://127.0.0.1:8000"
TRAPS = ("walking_console.py", "server.py", "numpy.py", "json.py", "sitecustomize.py")


@pytest.fixture
def trapped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory full of modules that nobody must import."""
    sprung = tmp_path / "sprung"
    for name in TRAPS:
        (tmp_path / name).write_text(f"open({str(sprung)!r}, 'a').write({name!r})\n")
    monkeypatch.chdir(tmp_path)
    return sprung


@pytest.fixture
def client(loop: RealtimeLoop, trapped: Path) -> Iterator[TestClient]:
    with TestClient(create_app(loop, AppSettings(data=Path("data"))), base_url=HERE) as client:
        yield client


@pytest.mark.parametrize("path", [None, "", os.pathsep, ".", f"relative{os.pathsep}."])
def test_a_run_begun_over_http_imports_nothing_from_the_working_directory(
    client: TestClient, trapped: Path, monkeypatch: pytest.MonkeyPatch, path: str | None
) -> None:
    if path is not None:
        monkeypatch.setenv("PYTHONPATH", path)
    body = {"name": "flat", "settings": ["end={time=0.2}", "expect={}"]}
    run_id = client.post("/api/v1/runs", json=body).json()["id"]
    jobs = client.app.state.console.jobs  # type: ignore[attr-defined]
    jobs._jobs[run_id].process.wait(60)
    state = client.get(f"/api/v1/runs/{run_id}").json()
    assert state["state"] == "completed", state
    assert not trapped.exists(), trapped.read_text()
    assert (Path("data") / "runs" / run_id / "run.json").is_file()


def test_a_page_drawn_for_a_run_imports_nothing_from_the_working_directory(
    client: TestClient, trapped: Path
) -> None:
    body = {"name": "flat", "settings": ["end={time=0.2}", "expect={}"]}
    run_id = client.post("/api/v1/runs", json=body).json()["id"]
    client.app.state.console.jobs._jobs[run_id].process.wait(60)  # type: ignore[attr-defined]
    assert client.get(f"/api/v1/runs/{run_id}/replay.html").status_code == 200
    assert not trapped.exists()


def test_the_command_keeps_the_working_directory_off_the_module_path() -> None:
    assert COMMAND[:2] == (sys.executable, "-P")


def test_a_folder_named_in_full_stays_on_the_path_and_the_token_does_not_go_along(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((str(tmp_path), ".")))
    monkeypatch.setenv(SECRET, "k" * 40)
    monkeypatch.setattr(
        "walking_console.server.child_process.COMMAND",
        (sys.executable, "-c", "import os, sys; print(dict(os.environ), *sys.path, sep='\\n')"),
    )
    with (tmp_path / "said").open("wb") as said:
        assert start_child([], tmp_path, said).wait(30) == 0
    environment, *path = (tmp_path / "said").read_text().splitlines()
    assert "k" * 40 not in environment and "'PYTHONSAFEPATH': '1'" in environment
    assert str(tmp_path) in path and str(Path.cwd()) not in path
