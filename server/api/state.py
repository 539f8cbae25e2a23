"""What the routes share: the real-time loop, who drives, the runs, the canvas."""

from __future__ import annotations

import asyncio
import secrets
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from fastapi import Depends
from starlette.requests import HTTPConnection

from walking_console.sim.snapshot import Snapshot

from ..control_lease import ControlLease
from ..disk_thread import DiskThread
from ..frames import as_text, snapshot_frame
from ..job_queue import JobQueue
from ..live_recording import LiveRecording
from ..realtime_loop import RealtimeLoop
from ..run_jobs import RunJobs
from ..serve_options import DATA
from ..sessions import SIT_AFTER
from ..stop_latch import StopLatch
from ..sweep_jobs import SweepJobs
from ..uploaded_file import ReadUpload, understood
from ..uploads import Uploads
from ..viser_bridge import ViserBridge
from .drawings import Drawings
from .kept_world import KeptWorld

STOPPED = "stopped"  # the file in the data folder that keeps a stop
WORLD = "world.json"  # the file there that keeps the world last loaded
SETTLE_TIME = 5.0  # s for another world to show


@dataclass(frozen=True)
class AppSettings:
    """What the app is made with."""

    data: Path = DATA
    hosts: tuple[str, ...] = ()
    # NAME or NAME:PORT of proxies before it: it answers for them and takes them as its own origin
    authorities: tuple[str, ...] = ()
    root_path: str = ""  # where a proxy shows it; '': at the root
    # any IP address may be the Host: for a console that listens beyond loopback
    addresses: bool = False
    token: str | None = None
    viewer_token: str | None = None  # lets its bearer watch and stop
    sit_after: float = SIT_AFTER  # s; 0: never
    # what reads a file somebody brings; a served console has a child with limits do it
    read_upload: ReadUpload = understood
    # page/ and vendor/
    web: Path = field(default_factory=lambda: Path(str(resources.files("walking_console.web"))))


class ChangeSignal:
    """Wakes everybody who waits, at once: a new snapshot, a new holder, a refusal to send."""

    def __init__(self) -> None:
        self._next: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    def notify(self) -> None:
        """Something has changed."""
        waited = self._next
        self._next = asyncio.get_running_loop().create_future()
        waited.set_result(None)

    async def wait(self) -> None:
        """Until the next change."""
        await asyncio.shield(self._next)


class ShownText(NamedTuple):
    """A snapshot as JSON, and what it was made of."""

    snapshot: Snapshot | None
    stopped: bool
    fault: str
    playing: bool
    text: str


class AppState:
    """One per app, made with it; routes get it as a dependency."""

    def __init__(
        self, loop: RealtimeLoop, settings: AppSettings, bridge: ViserBridge | None
    ) -> None:
        self.loop = loop
        self.settings = settings
        self.bridge = bridge
        disk = DiskThread()
        latch = StopLatch(settings.data / STOPPED, disk)
        self.lease = ControlLease(loop, settings.sit_after, latch)
        self.kept_world = KeptWorld(settings.data / WORLD, disk)
        self.jobs = RunJobs(settings.data, JobQueue())
        self.sweeps = SweepJobs(settings.data, self.jobs.queue)
        self.drawings = Drawings(self.jobs, self.sweeps)
        self.uploads = Uploads(settings.data, settings.read_upload)
        self.recording = LiveRecording()
        self.changes: ChangeSignal | None = None
        self.drivers: set[str] = set()  # names of the sockets on /drive
        self.started = time.monotonic()
        self.start_name = secrets.token_hex(4)  # of this start of the server
        self._shown = ShownText(None, False, "", False, "")

    @asynccontextmanager
    async def serving(self) -> AsyncIterator[None]:
        """While the app serves, every snapshot wakes the pages; the walking thread only leaves a
        note for the web loop.
        """
        web_loop = asyncio.get_running_loop()
        self.changes = changes = ChangeSignal()

        def tell() -> None:
            self.recording.note(self.loop.newest)
            try:
                web_loop.call_soon_threadsafe(changes.notify)
            except RuntimeError:
                pass  # the web loop has closed; the walk goes on until it is stopped

        self.loop.on_publish = tell
        try:
            yield
        finally:
            self.loop.on_publish = lambda: None
            self.lease.hold()
            await asyncio.to_thread(self.jobs.queue.stop)
            await asyncio.to_thread(self.drawings.stop)

    def wake(self) -> None:
        """Let every page look again."""
        if self.changes is not None:
            self.changes.notify()

    def frame(self) -> dict[str, Any]:
        """The newest snapshot as JSON."""
        loop = self.loop
        return snapshot_frame(
            loop.newest, stopped=self.lease.stopped, fault=loop.fault, playing=loop.playing
        )

    def text(self) -> str:
        """The newest snapshot as text; the same object for all pages until something changes."""
        now = (self.loop.newest, self.lease.stopped, self.loop.fault, self.loop.playing)
        if self._shown[:4] != now:
            self._shown = ShownText(*now, as_text(self.frame()))
        return self._shown.text

    async def until(self, done: Callable[[], object], limit: float) -> bool:
        """Wait, snapshot by snapshot, until ``done()``; False when it took longer than ``limit``
        s.
        """
        try:
            async with asyncio.timeout(limit):
                while not done():
                    await self._next_change()
        except TimeoutError:
            return False
        return True

    async def _next_change(self) -> None:
        if self.changes is None or not self.loop.running:
            # nobody else ticks: a test, or a console without its thread
            self.loop.tick()
        else:
            await self.changes.wait()

    async def until_another_world(self, before: Snapshot) -> None:
        """Wait until a snapshot of another world than ``before`` is out."""
        old = before.terrain.revision
        await self.until(
            lambda: self.loop.newest.terrain.revision != old or self.loop.fault, SETTLE_TIME
        )


async def state_of(connection: HTTPConnection) -> AppState:
    """The state of the app that a request or a socket came to."""
    state: AppState = connection.app.state.console
    return state


ConsoleState = Annotated[AppState, Depends(state_of)]
