from collections.abc import Iterator

import pytest
import viser

from walking_console.server.viser_bridge import viser_without_socket


@pytest.fixture(scope="session")
def viser_server() -> Iterator[viser.ViserServer]:
    """A viser server that listens nowhere."""
    server, _ = viser_without_socket()
    yield server
    server.stop()


@pytest.fixture
def server(viser_server: viser.ViserServer) -> viser.ViserServer:
    """The same with an empty scene."""
    viser_server.scene.reset()
    return viser_server
