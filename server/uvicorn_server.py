"""uvicorn as the console needs it: small buffers, an end in time, status 0 on a signal."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import threading
from asyncio.transports import BaseTransport, Transport
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any, cast

import uvicorn
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

WRITE_BUFFER = 32 * 1024  # bytes waiting for a slow client; more, and it sees the past
SOCKET_FRAME_MAX = 64 * 1024  # bytes of any WebSocket frame; /drive and the canvas allow less
PING_EVERY = 5.0  # s
PING_TIME = 10.0  # s; a canvas on a slow line answers behind the ground it is still being sent
GRACE = 2  # s open requests get at the end
LAST_RESORT = 4.5  # s after the signal, whatever is open
END_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class SmallBuffers(WebSocketsSansIOProtocol):
    """uvicorn's WebSocket with a small write buffer: a slow client then holds its sender up instead
    of falling behind.
    """

    def connection_made(self, transport: BaseTransport) -> None:
        cast(Transport, transport).set_write_buffer_limits(high=WRITE_BUFFER)
        super().connection_made(transport)


def config_for(app: Any) -> uvicorn.Config:
    """How the console is served: no compressed frames, no proxy headers, no access log."""
    return uvicorn.Config(
        app,
        loop="asyncio",
        http="h11",
        ws=SmallBuffers,
        ws_max_size=SOCKET_FRAME_MAX,
        ws_per_message_deflate=False,
        ws_ping_interval=PING_EVERY,
        ws_ping_timeout=PING_TIME,
        proxy_headers=False,
        server_header=False,
        access_log=False,
        log_level="warning",
        timeout_graceful_shutdown=GRACE,
    )


class ConsoleServer(uvicorn.Server):
    """uvicorn that says when it listens and ends with status 0 on a signal; ``on_end`` is called at
    once then.
    """

    def __init__(self, config: uvicorn.Config, on_end: Callable[[], None]) -> None:
        super().__init__(config)
        self._on_end = on_end
        self.listening = threading.Event()

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        self.listening.set()

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = {number: signal.signal(number, self.handle_exit) for number in END_SIGNALS}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Hold at once; then let go of everything, in time."""
        self._on_end()
        if not self.should_exit:
            last = threading.Timer(LAST_RESORT, os._exit, (0,))
            last.daemon = True
            last.start()
        self.force_exit = self.should_exit
        self.should_exit = True
