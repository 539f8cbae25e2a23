"""``walking-console serve``: one process, one port, one line of output."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import ipaddress
import os
import re
import secrets
import signal
import socket
import sys
import threading
import webbrowser
from asyncio.transports import BaseTransport, Transport
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import cast

import uvicorn
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from walking_console.sim.scenario import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.snapshot import Snapshot
from walking_console.sim.world import prepare
from walking_console.web.scene.scene import Scene

from .api.app import Refusal, Settings, create_app, edit_under
from .control_lease import SIT_AFTER
from .realtime_loop import Drawing, WalkingClock, go_first
from .request_guard import LOOPBACK, is_address
from .schemas import painted
from .viser_bridge import Canvas, CanvasError

TOKEN_MIN = 32  # characters: 192 bits as secrets.token_urlsafe writes them
TOKEN = re.compile(rf"[A-Za-z0-9._~-]{{{TOKEN_MIN},256}}")
WRITE_BUFFER = 32 * 1024  # bytes waiting for a slow client; more, and it sees the past
NOTSENT = 16 * 1024  # bytes, the same in the kernel
NOTSENT_OPTION = getattr(socket, "TCP_NOTSENT_LOWAT", 25 if sys.platform == "linux" else None)
FRAME_MAX = 64 * 1024  # bytes of any WebSocket frame; /drive and the canvas allow less
# s; a canvas on a slow line answers behind the ground it is still being sent
PING_EVERY, PING_TIME = 5.0, 10.0
GRACE = 2  # s open requests get at the end
LAST_RESORT = 4.5  # s after the signal, whatever is open
BAD_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class ServeError(ValueError):
    """Why the console cannot be served; the message is one clear line."""


class SmallBuffers(WebSocketsSansIOProtocol):
    """uvicorn's WebSocket with a small write buffer: a slow client then holds its sender up instead
    of falling behind.
    """

    def connection_made(self, transport: BaseTransport) -> None:
        cast(Transport, transport).set_write_buffer_limits(high=WRITE_BUFFER)
        super().connection_made(transport)


class Server(uvicorn.Server):
    """uvicorn that says when it listens and ends with status 0 on a signal."""

    def __init__(self, config: uvicorn.Config, clock: WalkingClock) -> None:
        super().__init__(config)
        self._clock = clock
        self.listening = threading.Event()

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        self.listening.set()

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = {number: signal.signal(number, self.handle_exit) for number in BAD_SIGNALS}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Hold at once; then let go of everything, in time."""
        self._clock.hold_for_good()
        if not self.should_exit:
            last = threading.Timer(LAST_RESORT, os._exit, (0,))
            last.daemon = True
            last.start()
        self.force_exit = self.should_exit
        self.should_exit = True


def listen(host: str, port: int) -> socket.socket:
    """The listening socket; raises ``ServeError`` when the address cannot be had."""
    try:
        family, kind, _, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
    except (OSError, UnicodeError) as error:
        raise ServeError(f"cannot listen on {host!r}: {error}") from None
    # with protocol 0 asyncio would not set TCP_NODELAY: 44 ms stalls
    listening = socket.socket(family, kind, socket.IPPROTO_TCP)
    try:
        if os.name == "posix":
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if NOTSENT_OPTION is not None:
            with contextlib.suppress(OSError):
                listening.setsockopt(socket.IPPROTO_TCP, NOTSENT_OPTION, NOTSENT)
        listening.bind(address)
        listening.listen(128)
    except OSError as error:
        listening.close()
        if error.errno == errno.EADDRINUSE:
            raise ServeError(
                f"port {port} on {host} is in use; choose another with --port, or --port 0 for any free one"
            ) from None
        raise ServeError(f"cannot listen on {host} port {port}: {error.strerror}") from None
    listening.setblocking(False)
    return listening


def is_loopback(host: str) -> bool:
    """True when only this computer can connect."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def check_token(host: str, token: str | None) -> None:
    """Beyond loopback a token is needed, and a short one is none."""
    if token is not None and not TOKEN.fullmatch(token):
        example = secrets.token_urlsafe(32)
        raise ServeError(
            f"--token must have at least {TOKEN_MIN} characters of A-Z a-z 0-9 . _ ~ -, for example {example}"
        )
    if not is_loopback(host):
        if token is None:
            raise ServeError(
                f"--host {host} lets other computers in: that needs a --token of at least {TOKEN_MIN} characters"
            )
        print(
            f"walking-console: without TLS everybody on the way can read the token; put a TLS proxy in front of {host}",
            file=sys.stderr,
        )


def url_of(listening: socket.socket, host: str, token: str | None) -> str:
    """The one address to open."""
    port = listening.getsockname()[1]
    name = {"0.0.0.0": "127.0.0.1", "::": "[::1]", "": "127.0.0.1"}.get(
        host, f"[{host}]" if ":" in host else host
    )
    return f"http://{name}:{port}" + (f"/login?token={token}" if token else "")


def serve(
    *,
    host: str = "127.0.0.1",
    port: int = 8000,
    robot: str | None = None,
    scenario: str = "dem",
    open_page: bool = True,
    token: str | None = None,
    data: Path = Path("walking-console-data"),
    sit_after: float = SIT_AFTER,
) -> None:
    """Serve the console until a signal ends it; raises ``ServeError``, or what a bad scenario or
    robot raises.
    """
    check_token(host, token)
    world = prepare(load_scenario(scenario, [] if robot is None else [f"robot={_quoted(robot)}"]))
    # for the page's inspector; a tick takes no longer for it
    clock = WalkingClock(Simulation(world, explain=True))
    listening = listen(host, port)
    try:
        canvas = Canvas()
    except CanvasError as error:
        listening.close()
        raise ServeError(str(error)) from None
    drawing = Drawing(clock, _scene(canvas, clock), lambda: canvas.watched)
    own = () if host in LOOPBACK or is_address(host) else (host,)
    hosts = own if is_loopback(host) else (*own, socket.gethostname())
    app = create_app(
        clock, Settings(Path(data), hosts, not is_loopback(host), token, sit_after), canvas
    )
    config = uvicorn.Config(
        app,
        loop="asyncio",
        http="h11",
        ws=SmallBuffers,
        ws_max_size=FRAME_MAX,
        ws_per_message_deflate=False,
        ws_ping_interval=PING_EVERY,
        ws_ping_timeout=PING_TIME,
        proxy_headers=False,
        server_header=False,
        access_log=False,
        log_level="warning",
        timeout_graceful_shutdown=GRACE,
    )
    server = Server(config, clock)
    clock.start()
    drawing.start()
    threading.Thread(
        target=_announce, args=(server, url_of(listening, host, token), open_page), daemon=True
    ).start()
    go_first()
    canvas.server.get_event_loop().call_soon_threadsafe(go_first)
    try:
        asyncio.run(server.serve(sockets=[listening]))
    finally:
        clock.stop()
        drawing.stop()
        canvas.stop()


def _scene(canvas: Canvas, clock: WalkingClock) -> Callable[[Snapshot], None]:
    """The drawing of one scene; made here, so that only ``web`` knows how. A click with a brush
    leaves a request for the walk.
    """
    scene = Scene(canvas.server)

    def paint(brush: str, x: float, y: float, radius: float) -> None:
        with contextlib.suppress(Refusal):  # beside the map
            clock.request(edit_under(painted(brush, x, y, radius), clock.newest.terrain))

    scene.on_paint = paint
    return scene.draw


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _announce(server: Server, url: str, open_page: bool) -> None:
    server.listening.wait()
    print(url, flush=True)
    if open_page:
        with contextlib.suppress(webbrowser.Error):
            webbrowser.open(url)
