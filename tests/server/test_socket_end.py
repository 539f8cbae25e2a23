"""A socket ends, whatever its client does."""

import asyncio
from typing import Any, cast

from starlette.websockets import WebSocketDisconnect

from walking_console.server.limits import CUT_AFTER
from walking_console.server.socket_end import ABORT, close, cut


class Socket:
    """As much of a WebSocket as is asked for; ``stuck``: its client reads nothing."""

    def __init__(self, *, stuck: bool = False, gone: bool = False) -> None:
        self.stuck = stuck
        self.gone = gone
        self.codes: list[int] = []
        self.cuts = 0
        self.scope: dict[str, Any] = {"extensions": {ABORT: self._cut}}

    def _cut(self) -> None:
        self.cuts += 1

    async def close(self, code: int, reason: str) -> None:
        if self.gone:
            raise WebSocketDisconnect(1006)
        if self.stuck:
            await asyncio.sleep(60.0)
        self.codes.append(code)


def ended(socket: Socket) -> Socket:
    async def end() -> None:
        await close(cast(Any, socket), 1008, "too fast")
        await asyncio.sleep(2 * CUT_AFTER)

    asyncio.run(end())
    return socket


def test_the_code_is_said_and_then_the_connection_is_cut() -> None:
    socket = ended(Socket())
    assert socket.codes == [1008] and socket.cuts == 1


def test_a_client_that_reads_nothing_is_cut_all_the_same() -> None:
    socket = ended(Socket(stuck=True))
    assert socket.codes == [] and socket.cuts == 1


def test_one_that_is_gone_already_is_no_error() -> None:
    assert ended(Socket(gone=True)).codes == []


def test_where_nothing_can_be_cut_nothing_is() -> None:
    socket = Socket()
    socket.scope = {"extensions": None}
    cut(cast(Any, socket))
    assert socket.cuts == 0
