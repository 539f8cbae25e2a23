"""uvicorn as the console needs it: small buffers, an end in time, status 0 on a signal."""

from __future__ import annotations

import asyncio
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
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.http11 import Request

from .connections import Connections, most_connections
from .limits import (
    ACCEPTED_AT_ONCE,
    DRIVE_PING_EVERY,
    DRIVE_PING_TIME,
    FIRST_REQUEST_TIME,
    HEAD_MAX,
    IDLE_TIME,
    PING_EVERY,
    PING_TIME,
    QUEUED_MAX,
    SOCKET_FRAME_MAX,
    WRITE_BUFFER,
)
from .socket_end import ABORT

GRACE = 2  # s open requests get at the end
LAST_RESORT = 4.5  # s after the signal, whatever is open
TOO_MANY_SOCKETS = (
    b"HTTP/1.1 429 Too Many Requests\r\nRetry-After: 1\r\nContent-Length: 0\r\n"
    b"Connection: close\r\n\r\n"
)
END_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class SmallBuffers(WebSocketsSansIOProtocol):
    """uvicorn's WebSocket with a small write buffer: a slow client then holds its sender up instead
    of falling behind. One that answers no ping is cut.
    """

    def connection_made(self, transport: BaseTransport) -> None:
        cast(Transport, transport).set_write_buffer_limits(high=WRITE_BUFFER)
        super().connection_made(transport)

    def connection_lost(self, exc: Exception | None) -> None:
        _connections_of(self.config).close(self.transport)
        super().connection_lost(exc)

    def handle_connect(self, event: Request) -> None:
        super().handle_connect(event)
        if self.transport.is_closing():
            return
        extensions = cast(dict[str, Any], self.scope["extensions"])
        extensions[ABORT] = self.transport.abort
        if self.scope["path"].rstrip("/").endswith("/drive"):
            self.ping_interval = DRIVE_PING_EVERY
            self.ping_timeout = DRIVE_PING_TIME

    def keepalive_timeout(self) -> None:
        super().keepalive_timeout()
        self.transport.abort()  # a close would wait until the client reads


class TimedHttp(H11Protocol):
    """uvicorn's HTTP, for clients that ask: a connection without a whole request head for
    ``FIRST_REQUEST_TIME`` s is cut, and where there are too many, sooner.
    """

    _overdue: asyncio.TimerHandle | None = None

    def connection_made(self, transport: Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        if not _connections_of(self.config).open(transport):
            transport.abort()
            return
        self._overdue = self.loop.call_later(FIRST_REQUEST_TIME, transport.abort)

    def data_received(self, data: bytes) -> None:
        cycle = self.cycle
        super().data_received(data)
        if self.cycle is not cycle:
            self._has_asked()

    def handle_websocket_upgrade(self, event: Any) -> None:
        self._has_asked()
        if not _connections_of(self.config).may_open_socket(self.transport):
            self.transport.write(TOO_MANY_SOCKETS)
            self.transport.close()
            return
        super().handle_websocket_upgrade(event)

    def on_response_complete(self) -> None:
        _connections_of(self.config).idle(self.transport)
        super().on_response_complete()

    def connection_lost(self, exc: Exception | None) -> None:
        self._has_asked()
        _connections_of(self.config).close(self.transport)
        super().connection_lost(exc)

    def _has_asked(self) -> None:
        _connections_of(self.config).busy(self.transport)
        if self._overdue is not None:
            self._overdue.cancel()
            self._overdue = None


class ConsoleConfig(uvicorn.Config):
    """uvicorn's settings, and who is connected."""

    def __init__(self, *words: Any, **settings: Any) -> None:
        super().__init__(*words, **settings)
        self.connections = Connections(most_connections())


def _connections_of(config: uvicorn.Config) -> Connections:
    assert isinstance(config, ConsoleConfig)
    return config.connections


def config_for(app: Any) -> ConsoleConfig:
    """How the console is served: no compressed frames, no proxy headers, no access log."""
    return ConsoleConfig(
        app,
        loop="asyncio",
        http=TimedHttp,
        ws=SmallBuffers,
        ws_max_size=SOCKET_FRAME_MAX,
        ws_per_message_deflate=False,
        ws_ping_interval=PING_EVERY,
        ws_ping_timeout=PING_TIME,
        proxy_headers=False,
        server_header=False,
        access_log=False,
        log_config=None,  # what it says goes the way of all others
        log_level="warning",
        backlog=ACCEPTED_AT_ONCE,
        h11_max_incomplete_event_size=HEAD_MAX,
        timeout_keep_alive=IDLE_TIME,
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
        for listening in sockets or ():
            listening.listen(QUEUED_MAX)  # asyncio has set it to what it accepts at once
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
