"""A child of the console runs this program and nothing that lies in the working directory."""

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
from fastapi.testclient import TestClient

from walking_console.server.api.app import create_app
from walking_console.server.api.state import AppSettings
from walking_console.server.child_process import (
    COMMAND,
    PARENT,
    SECRETS,
    end_with_parent,
    start_child,
)
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
    for secret in SECRETS:
        monkeypatch.setenv(secret, "k" * 40)
    monkeypatch.setattr(
        "walking_console.server.child_process.COMMAND",
        (sys.executable, "-c", "import os, sys; print(dict(os.environ), *sys.path, sep='\\n')"),
    )
    with (tmp_path / "said").open("wb") as said:
        assert start_child([], tmp_path, said).wait(30) == 0
    environment, *path = (tmp_path / "said").read_text().splitlines()
    assert "k" * 40 not in environment and "'PYTHONSAFEPATH': '1'" in environment
    assert str(tmp_path) in path and str(Path.cwd()) not in path


KILLED_PARENT = """
import os, sys
from pathlib import Path
from walking_console.server import child_process
child_process.COMMAND = (sys.executable, "-c", sys.argv[1])
print(child_process.start_child([], Path(sys.argv[2])).pid, flush=True)
os.kill(os.getpid(), 9)
"""
CHILD = """
import time
from walking_console.server.child_process import end_with_parent
end_with_parent()
time.sleep(60)
"""


@pytest.mark.skipif(os.name != "posix", reason="only there is a lost parent seen")
def test_a_child_ends_when_the_console_that_began_it_is_killed(tmp_path: Path) -> None:
    words = [sys.executable, "-c", KILLED_PARENT, CHILD, str(tmp_path)]
    said = subprocess.run(words, capture_output=True, text=True, timeout=30).stdout
    child = psutil.Process(int(said))
    assert psutil.wait_procs([child], timeout=20.0)[1] == []


def test_a_program_that_nobody_began_watches_nobody(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(PARENT, raising=False)
    before = threading.active_count()
    end_with_parent()
    assert threading.active_count() == before
