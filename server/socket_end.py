"""The end of a WebSocket, whatever its client does: a close code, and soon after a cut."""

from __future__ import annotations

import asyncio
import contextlib
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from .limits import CUT_AFTER

ABORT = "walking_console.abort"  # in the scope's extensions: ends the connection as it is
GONE = (TimeoutError, WebSocketDisconnect, RuntimeError, OSError)


def cut(socket: WebSocket) -> None:
    """End the connection now; what is still to be sent is lost."""
    extensions: dict[str, Any] = socket.scope.get("extensions") or {}
    if ABORT in extensions:
        extensions[ABORT]()


async def close(socket: WebSocket, code: int, reason: str = "") -> None:
    """Say the code; a client that goes on sending or reads nothing is cut after ``CUT_AFTER`` s."""
    asyncio.get_running_loop().call_later(CUT_AFTER, cut, socket)
    with contextlib.suppress(*GONE):
        await asyncio.wait_for(socket.close(code, reason), CUT_AFTER)
