"""A small world for every test: flat ground, a clock whose beats and whose time the test makes, the
app in process.
"""

from collections.abc import Iterator
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from tests.server.stopwatch import Watch
from walking_console.server.api.app import Settings, create_app
from walking_console.server.realtime_loop import WalkingClock
from walking_console.sim.scenario import load_scenario
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
def clock(flat: World, watch: Watch) -> WalkingClock:
    """Not started: each ``beat`` is the test's."""
    return WalkingClock(Simulation(flat), watch)


@pytest.fixture
def client(clock: WalkingClock, tmp_path: Path) -> Iterator[TestClient]:
    with TestClient(create_app(clock, Settings(data=tmp_path)), base_url=HERE) as client:
        yield client
