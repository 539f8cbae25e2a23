"""A small world for every test: flat ground, a loop whose ticks and whose time the test makes, the
app in process.
"""

from collections.abc import Iterator
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from tests.server.command_line import SHORT, called
from tests.server.stopwatch import Watch
from walking_console.server.api.app import create_app
from walking_console.server.api.state import AppSettings
from walking_console.server.realtime_loop import RealtimeLoop
from walking_console.server.viser_bridge import ViserBridge
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import World, prepare

HERE = "http://127.0.0.1:8000"


@pytest.fixture(scope="session")
def flat() -> World:
    return prepare(load_scenario("flat"))


@pytest.fixture
def watch() -> Watch:
    return Watch()


@pytest.fixture
def loop(flat: World, watch: Watch) -> RealtimeLoop:
    """Not started: each ``tick`` is the test's."""
    return RealtimeLoop(Simulation(flat), watch)


@pytest.fixture
def client(loop: RealtimeLoop, tmp_path: Path) -> Iterator[TestClient]:
    with TestClient(create_app(loop, AppSettings(data=tmp_path)), base_url=HERE) as client:
        yield client


@pytest.fixture(scope="module")
def bridge() -> Iterator[ViserBridge]:
    made = ViserBridge()
    yield made
    made.stop()


@pytest.fixture
def viewing(loop: RealtimeLoop, bridge: ViserBridge, tmp_path: Path) -> Iterator[TestClient]:
    app = create_app(loop, AppSettings(data=tmp_path), bridge)
    with TestClient(app, base_url=HERE, follow_redirects=False) as client:
        yield client


@pytest.fixture(scope="session")
def run_directory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("runs") / "flat"
    result = called("run", "flat", "--out", out, *SHORT)
    assert result.exit_code == 0, result.output
    return out
