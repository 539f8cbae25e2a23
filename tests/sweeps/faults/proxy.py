"""A TCP proxy on loopback that makes a good link a bad one: it stalls, or is slow."""

from __future__ import annotations

import asyncio
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

PART = 1024  # bytes passed on at once
BUFFER = 8 * 1024  # bytes kept of what the other side has sent: as a small router has


class Proxy:
    """Passes on to a port of this computer in an event loop of its own."""

    def __init__(self, port: int, rate: float = 0.0) -> None:
        self.port = 0
        self.rate = rate  # bytes a second each way, of all connections together; 0: no limit
        self._to = port
        self._loop = asyncio.new_event_loop()
        self._open = asyncio.Event()
        self._ready = threading.Event()
        self._due = [0.0, 0.0]  # s, when the next part may pass, up and down
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        self._ready.wait(5.0)

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def stall(self, stalled: bool) -> None:
        """Pass nothing on, either way, or everything that has waited."""
        change = self._open.clear if stalled else self._open.set
        self._loop.call_soon_threadsafe(change)

    def end(self) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._open.set()
        listening = socket.create_server(("127.0.0.1", 0))
        self.port = listening.getsockname()[1]
        serving = asyncio.start_server(self._carry, sock=listening, limit=BUFFER)
        self._loop.run_until_complete(serving)
        self._ready.set()
        self._loop.run_forever()

    async def _carry(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with socket.socket() as plain:
            plain.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER)
            plain.setblocking(False)
            await self._loop.sock_connect(plain, ("127.0.0.1", self._to))
            there, back = await asyncio.open_connection(sock=plain, limit=BUFFER)
            both = (self._pump(reader, back, 0), self._pump(there, writer, 1))
            await asyncio.gather(*both, return_exceptions=True)

    async def _pump(
        self, source: asyncio.StreamReader, sink: asyncio.StreamWriter, way: int
    ) -> None:
        with suppress(OSError):
            while part := await source.read(PART):
                await self._open.wait()
                await self._pass_time(len(part), way)
                sink.write(part)
                await sink.drain()
        with suppress(OSError):
            sink.close()

    async def _pass_time(self, size: int, way: int) -> None:
        """What is sent takes its time, whichever connection sends it."""
        if self.rate:
            begins = max(self._loop.time(), self._due[way])
            self._due[way] = begins + size / self.rate
            await asyncio.sleep(self._due[way] - self._loop.time())


@contextmanager
def proxied(port: int, rate: float = 0.0) -> Iterator[Proxy]:
    """A proxy before this port, as long as it is needed."""
    proxy = Proxy(port, rate)
    try:
        yield proxy
    finally:
        proxy.end()
