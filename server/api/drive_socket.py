"""``WS /drive``: commands in, snapshots out. One ``DriveSocket`` per page: one task hears, one
shows; a page whose link is slow misses snapshots, nobody else does.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import secrets
import time
from collections import deque
from collections.abc import AsyncIterator
from typing import NamedTuple

from fastapi import APIRouter, WebSocket
from starlette.types import Message
from starlette.websockets import WebSocketDisconnect

from walking_console.planner.types import TICK, Command
from walking_console.sim.runs.runner import product_version
from walking_console.sim.snapshot import Snapshot

from ..explanation_frames import ahead_frame, decision_frame
from ..frames import HelloFrame, LeaseFrame, PongFrame, RefusedFrame, as_text, style_frame
from ..limits import DRIVE_FRAME_MAX, DRIVE_SEND_TIME, DRIVERS_MAX
from ..problems import problem
from ..schemas import BadFrame, DriveFrame, PingFrame, read_frame
from ..sessions import DEAD_MAN, TooFast
from ..show_pace import ShowPace
from ..socket_end import GONE, close
from ..tokens import WATCHES
from .state import AppState, ConsoleState

EAGER_TIME = 0.2  # s after another command in which every snapshot is shown
REFUSALS_KEPT = 16
NOTHING_AHEAD = as_text({"type": "ahead"})

log = logging.getLogger(__name__)
router = APIRouter()


@router.websocket("/drive")
async def drive(socket: WebSocket, state: ConsoleState) -> None:
    """Carry one page until it goes."""
    if len(state.drivers) >= DRIVERS_MAX:
        await socket.send_denial_response(problem(503, f"{DRIVERS_MAX} sockets are open already"))
        return
    await DriveSocket(socket, state).carry()


class CloseWith(Exception):
    """The socket is to be closed with this code."""

    def __init__(self, code: int, reason: str) -> None:
        super().__init__(reason)
        self.code = code


def _title_of(socket: WebSocket) -> str:
    """What others read of a page: the kind of thing it runs on."""
    agent = socket.headers.get("user-agent", "")
    if "iPad" in agent or ("Android" in agent and "Mobile" not in agent):
        return "a tablet"
    return "a phone" if "Mobi" in agent else "another page"


class HeardPing(NamedTuple):
    """A ping and when it was heard."""

    frame: PingFrame
    heard: float  # s


class DriveSocket:
    """One page's socket: its session, what it was refused, and what it has been shown."""

    def __init__(self, socket: WebSocket, state: AppState) -> None:
        self._socket = socket
        self._state = state
        self._lease = state.lease
        self.name = secrets.token_hex(3)
        watches = WATCHES in socket.scope
        self._session = state.lease.open(self.name, _title_of(socket), watches=watches)
        self._refused: deque[RefusedFrame] = deque(maxlen=REFUSALS_KEPT)
        self._ping: HeardPing | None = None  # the newest, not yet answered
        self._revision = -1  # of the lease, as last said
        self._text = ""  # the snapshot last shown
        self._command = Command()  # the one it was made under
        self._eager_until = 0.0  # s, monotonic
        self._machine = state.loop.newest.machine  # the one whose style was sent
        self._pace = ShowPace(time.monotonic())
        self._ahead: object = None  # the foresight last shown
        self._decision: object = None  # the decision last shown

    async def carry(self) -> None:
        """Greet, then hear and show until the page goes."""
        self._state.drivers.add(self.name)
        try:
            await self._socket.accept()
            log.info("%s is here", self.name)
            await self._greet()
            async with self._showing():
                await self._hear()
        except (WebSocketDisconnect, RuntimeError):
            pass  # gone while something was being sent
        finally:
            self._lease.close(self._session)
            self._state.drivers.discard(self.name)
            self._state.wake()
            log.info("%s is gone", self.name)

    async def _greet(self) -> None:
        hello = HelloFrame(
            version=product_version(),
            lease_id=self.name,
            started=self._state.start_name,
            dead_man_s=DEAD_MAN,
            tick_s=TICK,
            watches=self._session.watches,
            style=style_frame(self._machine),
        )
        await self._socket.send_text(hello.model_dump_json())

    @contextlib.asynccontextmanager
    async def _showing(self) -> AsyncIterator[None]:
        """Show meanwhile; at the end the machine holds before anything that waits."""
        showing = asyncio.create_task(self._show())
        try:
            yield
        finally:
            self._lease.close(self._session)
            showing.cancel()
            await asyncio.gather(showing, return_exceptions=True)

    # up

    async def _hear(self) -> None:
        """Every frame, until the page goes, floods or sends what is no frame."""
        try:
            while True:
                message = await self._socket.receive()
                if message["type"] == "websocket.disconnect":
                    return
                self._handle(self._text_of(message))
        except CloseWith as end:
            log.warning("%s is closed with %d: %s", self.name, end.code, end)
            self._lease.close(self._session)
            await close(self._socket, end.code, str(end))

    def _text_of(self, message: Message) -> str:
        """One frame's text; raises ``CloseWith`` for what ends a socket."""
        try:
            self._lease.count(self._session)
        except TooFast as error:
            raise CloseWith(1008, str(error)) from None
        text: str | None = message.get("text")
        if text is None:
            raise CloseWith(1003, "text frames only")
        if len(text.encode("utf-8", "replace")) > DRIVE_FRAME_MAX:
            raise CloseWith(1009, f"a frame may have {DRIVE_FRAME_MAX} bytes")
        return text

    def _handle(self, text: str) -> None:
        """Do what a frame asks, or note why not."""
        revision = self._lease.revision
        refused = self._refusal_of(text)
        if refused is not None:
            self._refused.append(refused)
        asked = refused is not None or self._ping is not None
        if asked or self._lease.revision != revision:
            self._state.wake()

    def _refusal_of(self, text: str) -> RefusedFrame | None:
        try:
            frame = read_frame(text)
        except BadFrame as error:
            self._lease.refusals += 1
            return RefusedFrame(seq=error.seq, code="bad_frame", reason=str(error))
        if isinstance(frame, PingFrame | DriveFrame) and frame.echo_tick is not None:
            self._pace.note(self._state.loop.age_of(frame.echo_tick), time.monotonic())
        if isinstance(frame, PingFrame):
            self._ping = HeardPing(frame, time.monotonic())
            return None
        why = self._lease.handle(self._session, frame)
        if why is None:
            return None
        return RefusedFrame(seq=getattr(frame, "seq", None), code=why.reason, reason=why.text)

    # down

    async def _show(self) -> None:
        """Who drives, what was refused and the newest snapshot."""
        try:
            while True:
                await self._show_refusals()
                await self._show_lease()
                await self._show_snapshot()
                await self._answer_ping()
                await self._pause()
        except GONE:
            log.info("%s is too slow, or gone", self.name)
            self._lease.close(self._session)
            await close(self._socket, 1008, "too slow")

    async def _pause(self) -> None:
        """Until there is something to show. What a hand has done is shown at once, and so is what
        comes of it; the walk itself at the page's pace.
        """
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(1.0 / self._pace.rate):
                while not self._is_urgent():
                    await self._next_change()
        while self._up_to_date():
            await self._next_change()

    def _is_urgent(self) -> bool:
        if self._asked() or self._state.loop.newest.command != self._command:
            return True
        eager = time.monotonic() < self._eager_until and not self._pace.is_thinned
        return eager and not self._up_to_date()

    def _up_to_date(self) -> bool:
        return self._state.text() is self._text and not self._asked()

    def _asked(self) -> bool:
        """Whether there is something to say beside the walk."""
        is_new = self._revision != self._lease.revision
        return is_new or bool(self._refused) or self._ping is not None

    async def _next_change(self) -> None:
        assert self._state.changes is not None
        await self._state.changes.wait()

    async def _show_refusals(self) -> None:
        while self._refused:
            await self._send(self._refused.popleft().model_dump_json())

    async def _answer_ping(self) -> None:
        if self._ping is not None:
            ping, heard = self._ping
            self._ping = None
            kept = (time.monotonic() - heard) * 1000.0
            pong = PongFrame(sent_ms=ping.sent_ms, kept_ms=round(kept, 1))
            await self._send(pong.model_dump_json())

    async def _show_lease(self) -> None:
        holder = self._lease.holder  # asking may end a lease that has been silent
        if self._revision != self._lease.revision:
            self._revision = self._lease.revision
            held = self._lease.holds(self._session)
            title = self._lease.holder_title
            lease = LeaseFrame(
                held=held, holder=holder, holder_title=title, stopped=self._lease.stopped
            )
            await self._send(lease.model_dump_json())

    async def _show_snapshot(self) -> None:
        text = self._state.text()
        if text is not self._text:
            self._text = text
            newest = self._state.loop.newest
            if newest.command != self._command:
                self._command = newest.command
                self._eager_until = time.monotonic() + EAGER_TIME
            await self._show_style(newest)
            await self._send(text)
            await self._show_explanations(newest)

    async def _show_style(self, newest: Snapshot) -> None:
        """What another machine is drawn with, before it is shown."""
        if newest.machine != self._machine:
            self._machine = newest.machine
            await self._send(style_frame(self._machine).model_dump_json())

    async def _show_explanations(self, newest: Snapshot) -> None:
        """What is foreseen and why it was decided, when it is another than before."""
        if newest.ahead is not self._ahead:
            self._ahead = newest.ahead
            ahead = ahead_frame(newest)
            await self._send(NOTHING_AHEAD if ahead is None else ahead.model_dump_json())
        if newest.decision is not None and newest.decision is not self._decision:
            self._decision = newest.decision
            decision = decision_frame(newest)
            assert decision is not None
            await self._send(decision.model_dump_json())

    async def _send(self, text: str) -> None:
        async with asyncio.timeout(DRIVE_SEND_TIME):
            await self._socket.send_text(text)
