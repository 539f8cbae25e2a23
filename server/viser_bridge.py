"""The viser canvas on our own port: viser without a socket.

While ``ViserServer.__init__`` runs, the function that would open its socket is replaced by one that
only keeps the handler; that handler then runs on viser's own loop, once per WebSocket of ours, with
``ClientStream`` in place of the connection. All viser internals this leans on are in this file and
in ``viser_recording``, and their tests are the contract that a new viser must pass.

Stock viser lets any client open a public tunnel, set any attribute of a GUI handle and upload
without end: what comes up is read here first, and only the few message types a viewer needs go on.
"""

from __future__ import annotations

import asyncio
import gzip
import hashlib
import secrets
import threading
from collections.abc import Awaitable, Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any
from urllib.parse import parse_qsl, urlencode

import rich
import viser
import websockets.asyncio.server
from starlette.websockets import WebSocket, WebSocketDisconnect
from viser import _messages
from websockets.exceptions import ConnectionClosedOK

from .allowance import Allowance
from .limits import (
    CANVAS_BURST,
    CANVAS_FRAME_MAX,
    CANVAS_MESSAGES_PER_SECOND,
    CANVAS_SEND_TIME,
    CANVASES_MAX,
)
from .problems import problem
from .socket_end import close
from .tokens import WATCHES

SUBPROTOCOL = f"viser-v{viser.__version__}"
START_TIME = 20.0  # s
PASSED = (
    _messages.ViewerCameraMessage,
    _messages.ScenePointerMessage,
    _messages.SceneNodeClickMessage,
    _messages.GuiUpdateMessage,
)
OWN = (_messages.ViewerCameraMessage,)  # of one that only watches, beside its switches
# others can run foreign script
QUERY_KEYS = frozenset({"darkMode", "showStats", "fixedDpr", "hideViserLogo", "logCamera"})

ServeClient = Callable[[Any], Awaitable[None]]


class BridgeError(RuntimeError):
    """viser did not start, or is not the viser this bridge knows."""


class _NoSockets:
    sockets: tuple[()] = ()


class _Unopened:
    """What stands in for ``websockets.asyncio.server.serve``: keeps the handler, opens nothing."""

    server = _NoSockets()
    handler: ServeClient | None = None

    def __call__(self, handler: ServeClient, *_: Any, **__: Any) -> _Unopened:
        self.handler = handler
        return self

    async def __aenter__(self) -> _Unopened:
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        return None


_starting = threading.Lock()


@contextmanager
def _quiet_terminal() -> Iterator[None]:
    """viser prints its banner, and its farewell, even when asked not to."""
    terminal = rich.get_console()
    before = terminal.quiet
    terminal.quiet = True
    try:
        yield
    finally:
        terminal.quiet = before


@contextmanager
def _no_socket_opened() -> Iterator[_Unopened]:
    """While this lasts, nobody's ``websockets.asyncio.server.serve`` opens anything."""
    unopened = _Unopened()
    opened = websockets.asyncio.server.serve
    websockets.asyncio.server.serve = unopened  # type: ignore[misc, assignment]
    try:
        yield unopened
    finally:
        websockets.asyncio.server.serve = opened  # type: ignore[misc]


def viser_without_socket() -> tuple[viser.ViserServer, ServeClient]:
    """A viser server that listens nowhere, and the handler it would have served; raises
    ``BridgeError``.
    """
    made: list[viser.ViserServer] = []

    def make() -> None:
        made.append(viser.ViserServer(host="127.0.0.1", port=0, verbose=False))

    with _starting, _no_socket_opened() as unopened, _quiet_terminal():
        # in a thread: the constructor waits for ever when viser's own thread dies
        maker = threading.Thread(target=make, daemon=True)
        maker.start()
        maker.join(START_TIME)
    if not made or unopened.handler is None:
        raise BridgeError(
            f"viser {viser.__version__} did not start without a socket; "
            "this console knows viser 1.1.1"
        )
    return made[0], unopened.handler


class ClientStream:
    """One of our WebSockets as viser's handler sees it, on viser's loop: ``recv``, ``send``,
    ``close``, ``subprotocol``.
    """

    subprotocol = SUBPROTOCOL

    def __init__(self, socket: WebSocket, web_loop: asyncio.AbstractEventLoop) -> None:
        self._socket = socket
        self._web_loop = web_loop
        self._inbox: asyncio.Queue[bytes | None] = asyncio.Queue()
        self._closed = False

    async def recv(self) -> bytes:
        frame = None if self._closed else await self._inbox.get()
        if frame is None:
            self._closed = True
            raise ConnectionClosedOK(None, None)
        return frame

    async def send(self, data: bytes) -> None:
        """Waits until the client has room: what it has not got yet, viser replaces by what is
        newer.
        """
        if self._closed:
            raise ConnectionClosedOK(None, None)
        try:
            await asyncio.wrap_future(
                asyncio.run_coroutine_threadsafe(self._send(data), self._web_loop)
            )
        except (
            WebSocketDisconnect,
            RuntimeError,
            OSError,
            TimeoutError,
            asyncio.CancelledError,
        ) as error:
            self._closed = True
            if isinstance(error, asyncio.CancelledError):
                raise
            raise ConnectionClosedOK(None, None) from None

    async def _send(self, data: bytes) -> None:
        async with asyncio.timeout(CANVAS_SEND_TIME):
            await self._socket.send_bytes(data)

    async def close(self, code: int = 1000, reason: str = "") -> None:
        self._closed = True
        self._inbox.put_nowait(None)
        asyncio.run_coroutine_threadsafe(close(self._socket, code, reason), self._web_loop)

    def deliver(self, frame: bytes | None) -> None:
        """On viser's loop: the next frame from the client, None at its end."""
        self._inbox.put_nowait(frame)


def may_pass(frame: bytes, *, watches: bool = False) -> bool:
    """True for what a viewer may say: where its camera is, what it clicked, the value of a switch;
    of one that only watches the first and the last, which are its own.
    """
    if len(frame) > CANVAS_FRAME_MAX:
        return False
    try:
        message = _messages.Message.deserialize(frame)
    # anything at all can be wrong with a frame; none of it may reach viser's loop
    except Exception:
        return False
    if isinstance(message, _messages.GuiUpdateMessage):
        return (
            isinstance(message.updates, dict)
            and set(message.updates) == {"value"}
            and isinstance(message.uuid, str)
        )
    return type(message) in (OWN if watches else PASSED)


class ViserBridge:
    """viser's server for the scene, its page for a frame, and its stream for a WebSocket."""

    def __init__(self) -> None:
        self.server, self._handler = viser_without_socket()
        self._loop = self.server.get_event_loop()
        self._streams: set[ClientStream] = set()
        self.dropped = 0  # frames that were not let through
        self.nonce = secrets.token_urlsafe(16)
        self.page, self.nonced = embedded(client_page(), self.nonce)
        self.page_gzipped = gzip.compress(self.page, 6)
        self.etag = f'"{hashlib.sha256(self.page).hexdigest()[:32]}"'

    @property
    def watched(self) -> bool:
        """True while any canvas is open."""
        return bool(self._streams)

    @property
    def clients(self) -> int:
        return len(self._streams)

    def content_policy(self, host: str) -> str:
        """No eval, no foreign host, and where the pinned client allows it no script that is not its
        own.
        """
        script = f"'nonce-{self.nonce}'" if self.nonced else "'unsafe-inline'"
        return (
            "default-src 'none'; "
            f"script-src 'self' blob: 'wasm-unsafe-eval' {script}; "
            "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:; "
            f"connect-src 'self' ws://{host} wss://{host} data: blob:; worker-src 'self' blob:; "
            "base-uri 'none'; form-action 'none'; frame-ancestors 'self'"
        )

    async def carry(self, socket: WebSocket) -> None:
        """Carry one client's stream until either side ends it."""
        if SUBPROTOCOL not in socket.scope["subprotocols"]:
            await socket.send_denial_response(problem(400, f"the canvas speaks {SUBPROTOCOL}"))
            return
        if len(self._streams) >= CANVASES_MAX:
            await socket.send_denial_response(
                problem(503, f"{CANVASES_MAX} canvases are open already")
            )
            return
        stream = ClientStream(socket, asyncio.get_running_loop())
        self._streams.add(stream)
        try:
            await socket.accept(subprotocol=SUBPROTOCOL)
            await self._both_ways(socket, stream)
        finally:
            self._streams.discard(stream)

    async def _both_ways(self, socket: WebSocket, stream: ClientStream) -> None:
        handling: Future[None] = asyncio.run_coroutine_threadsafe(
            _run(self._handler, stream), self._loop
        )
        handled = asyncio.create_task(_finish(handling))
        reading = asyncio.create_task(self._read(socket, stream))
        try:
            await asyncio.wait({handled, reading}, return_when=asyncio.FIRST_COMPLETED)
            ended = reading.done() and not reading.cancelled() and reading.exception() is None
            code = reading.result() if ended else 1011
            await close(socket, code)
        finally:
            reading.cancel()
            self._say(stream, None)
            await asyncio.wait({handled}, timeout=1.0)
            handling.cancel()
            await asyncio.gather(handled, reading, return_exceptions=True)

    async def _read(self, socket: WebSocket, stream: ClientStream) -> int:
        """Pass on what may pass, until the client goes or asks too much; the answer is the close
        code.
        """
        begun = asyncio.get_running_loop().time()
        allowance = Allowance(CANVAS_BURST, CANVAS_MESSAGES_PER_SECOND, begun)
        watches = WATCHES in socket.scope
        while True:
            message = await socket.receive()
            if message["type"] == "websocket.disconnect":
                return 1000
            if not allowance.take(asyncio.get_running_loop().time()):
                return 1008
            frame = message.get("bytes")
            if frame is None:
                return 1003
            if may_pass(frame, watches=watches):
                self._say(stream, frame)
            else:
                self.dropped += 1

    def _say(self, stream: ClientStream, frame: bytes | None) -> None:
        try:
            self._loop.call_soon_threadsafe(stream.deliver, frame)
        except RuntimeError:
            pass  # viser has stopped

    def stop(self) -> None:
        """End viser's thread; waits at most a second or two."""
        with _quiet_terminal():
            self.server.stop()


async def _run(handler: ServeClient, stream: ClientStream) -> None:
    await handler(stream)


async def _finish(handling: Future[None]) -> int:
    """Wait for viser's side to end; the answer is the close code."""
    await asyncio.wrap_future(handling)
    return 1011


# the page in the frame

FORWARD_KEYS = """
(() => {
  // Keys belong to the page around this frame, whichever of the two has the focus; those that move
  // the focus stay here.
  const staying = /^(Tab|Enter|NumpadEnter|Shift|Control|Alt|Meta|F\\d|$)/;
  const framed = window.parent !== window;
  const fields = "input:not([type=checkbox]), textarea, select, [contenteditable=true]";
  const typing = (target) => target instanceof Element && target.matches(fields);
  // What is pressed here can no longer be seen to end.
  const handsOff = () => window.parent.dispatchEvent(new window.parent.Event("handsoff"));
  const pass = (event) => {
    const menu = /^(Control|Alt|Meta|ContextMenu|F\\d)/.test(event.code);
    if (framed && menu && event.type === "keydown") handsOff();
    // a key-up always goes on: whatever was pressed must be let go
    if (!framed || staying.test(event.code) || typing(event.target)) return;
    const combined = event.ctrlKey || event.metaKey || event.altKey;
    if (combined && event.type === "keydown") return;
    event.stopImmediatePropagation();
    const { code, key, repeat, shiftKey } = event;
    const pressed = { code, key, repeat, shiftKey, bubbles: true, cancelable: true };
    const twin = new window.parent.KeyboardEvent(event.type, pressed);
    if (!window.parent.document.dispatchEvent(twin)) event.preventDefault();
  };
  window.addEventListener("keydown", pass, true);
  window.addEventListener("keyup", pass, true);
  window.addEventListener("contextmenu", (event) => {
    if (framed && !event.defaultPrevented) handsOff();
  });
  document.documentElement.addEventListener("mouseleave", ({ clientX: x, clientY: y }) => {
    const inside = x > 0 && y > 0 && x < window.innerWidth && y < window.innerHeight;
    if (framed && !inside) handsOff();
  });
  // A key held while the frame loses the focus is let go: its key-up may never come.
  window.addEventListener("blur", (event) => {
    if (framed && event.isTrusted) window.parent.dispatchEvent(new window.parent.Event("blur"));
  });
  // viser reconnects only while it has the focus, which a frame seldom has: let being seen count.
  document.hasFocus = () => document.visibilityState === "visible";
  document.addEventListener("visibilitychange", () => {
    window.dispatchEvent(new Event(document.hasFocus() ? "focus" : "blur"));
  });
})();
"""

PACE_DRAWING = """
(() => {
  // Where drawing is slow the page around, which drives, gets as much time as it in between.
  const worth = 30; // ms of drawing from which on
  const most = 300; // ms
  const draw = window.requestAnimationFrame.bind(window);
  const forget = window.cancelAnimationFrame.bind(window);
  const costs = new WeakMap(); // ms, of what drew last
  let drawing = false;
  // Where a processor draws, nearly all of it happens after the commands were given, and the thread
  // waits for it before anything else runs: what is sent here comes when the picture is handed on.
  const handedOn = new MessageChannel();
  let drawn = []; // what drew, and when it began
  handedOn.port1.onmessage = () => {
    const now = performance.now();
    for (const [act, began] of drawn) costs.set(act, now - began);
    drawn = [];
  };
  const timed = (act) => (time) => {
    drawn.push([act, performance.now()]);
    if (drawn.length === 1) handedOn.port2.postMessage(null);
    drawing = true;
    try {
      act(time);
    } finally {
      drawing = false;
    }
  };
  window.requestAnimationFrame = (act) => {
    const cost = costs.get(act) ?? 0;
    if (cost < worth) return draw(timed(act));
    const rest = Math.min(cost, most);
    // what asks while it draws has as long to draw yet
    return -setTimeout(() => draw(timed(act)), drawing ? cost + rest : rest);
  };
  window.cancelAnimationFrame = (id) => (id < 0 ? clearTimeout(-id) : forget(id));
})();
"""

DRAW_PLAINLY = """
(() => {
  // Where fewer pixels are asked for, a processor draws them: smooth edges take it as long again.
  if (!new URLSearchParams(location.search).has("fixedDpr")) return;
  const get = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    return get.call(this, kind, { ...options, antialias: false });
  };
})();
"""

MAKE_NO_CODE = """
(() => {
  // Part of the client, by which nothing here is drawn, makes functions from text as it loads: a
  // text that makes one. The content policy refuses that: they do nothing instead of failing.
  window.Function = new Proxy(window.Function, { apply: () => () => () => undefined });
})();
"""

HIDE_PANEL = """
/* viser's own panels: the page around has its own, and on a phone this one would lie under the
   thumbs */
[data-floating-window], [data-dock-region], [data-dock-rail-root], .mantine-Paper-root,
.mantine-Notification-root {
  display: none !important;
}
"""

# where the client's loader makes the script element that it fills with the unpacked client
LOADER_MARK = 'e.type="module";'


def client_page() -> str:
    """viser's one-file client as installed."""
    return (Path(viser.__file__).parent / "client" / "build" / "index.html").read_text("utf-8")


def embedded(page: str, nonce: str) -> tuple[bytes, bool]:
    """The client with our script and style in its head, and whether every script in it carries the
    nonce.
    """
    script = FORWARD_KEYS + PACE_DRAWING + DRAW_PLAINLY + MAKE_NO_CODE
    ours = f'<script nonce="{nonce}">{script}</script><style>{HIDE_PANEL}</style>'
    nonced = (
        page.count(LOADER_MARK) == 1
        and page.count("<script data-p=") == 1
        and page.count("</script>") == 1
    )
    if nonced:
        page = page.replace(LOADER_MARK, f'{LOADER_MARK}e.nonce="{nonce}";')
        page = page.replace("<script data-p=", f'<script nonce="{nonce}" data-p=')
    at = page.index("<head>") + len("<head>")
    return (page[:at] + ours + page[at:]).encode(), nonced


def clean_query(query: str) -> str | None:
    """The query without the keys that could make viser's page run a foreign server's script; None
    when it is clean.
    """
    pairs = parse_qsl(query, keep_blank_values=True, max_num_fields=50)
    kept = [(key, value) for key, value in pairs if key in QUERY_KEYS]
    return None if len(kept) == len(pairs) else urlencode(kept)
