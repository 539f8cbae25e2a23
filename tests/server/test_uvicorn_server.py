"""uvicorn as the console needs it."""

import signal
from typing import Any

from walking_console.server import uvicorn_server
from walking_console.server.limits import SOCKET_FRAME_MAX
from walking_console.server.uvicorn_server import ConsoleServer, config_for


def test_no_frame_is_compressed_and_none_is_large() -> None:
    config = config_for(lambda: None)
    assert config.ws_per_message_deflate is False and config.ws_max_size == SOCKET_FRAME_MAX
    assert not config.proxy_headers and not config.server_header and not config.access_log


def test_a_signal_holds_first_and_a_second_one_forces_the_end(monkeypatch: Any) -> None:
    monkeypatch.setattr(uvicorn_server, "LAST_RESORT", 3600.0)
    held: list[bool] = []
    server = ConsoleServer(config_for(lambda: None), lambda: held.append(server.should_exit))
    server.handle_exit(signal.SIGTERM, None)
    assert held == [False] and server.should_exit and not server.force_exit
    server.handle_exit(signal.SIGTERM, None)
    assert server.force_exit
