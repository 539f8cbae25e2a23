"""A console below a path of a reverse proxy, such as ``/console/`` of a lab server.

The page speaks in relative addresses, so a proxy that takes the path off needs nothing here. Where
it passes whole paths on, ``--root-path`` or its ``X-Forwarded-Prefix`` says what to take off.
"""

from __future__ import annotations

import ipaddress

from starlette.datastructures import Headers
from starlette.responses import RedirectResponse
from starlette.types import ASGIApp, Receive, Scope, Send

from .listening import ROOT_PATH

PREFIX = "x-forwarded-prefix"


class PathPrefix:
    """ASGI middleware: routes see the path below the prefix, and ``root_path`` is the prefix."""

    def __init__(self, app: ASGIApp, root_path: str = "") -> None:
        self._app = app
        self._root_path = root_path

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        prefix = self._root_path or forwarded_prefix(scope)
        if prefix and scope["path"] == prefix and scope["type"] == "http":
            # relative addresses need the slash
            await RedirectResponse(prefix.rsplit("/", 1)[1] + "/", 307)(scope, receive, send)
            return
        await self._app(placed_under(scope, prefix) if prefix else scope, receive, send)


def placed_under(scope: Scope, prefix: str) -> Scope:
    """The scope as ASGI has it: the path begins with ``root_path``, whether the proxy has taken
    that off or not.
    """
    path = scope["path"]
    whole = path if path.startswith(f"{prefix}/") else prefix + path
    return {**scope, "path": whole, "root_path": prefix}


def forwarded_prefix(scope: Scope) -> str:
    """What a proxy on this computer says it is shown under; nobody else is believed."""
    given = Headers(scope=scope).get(PREFIX, "").rstrip("/")
    if not given or not _is_here(scope) or not ROOT_PATH.fullmatch(given):
        return ""
    return "" if ".." in given.split("/") else given


def _is_here(scope: Scope) -> bool:
    """Whether the peer is this computer."""
    try:
        return ipaddress.ip_address((scope.get("client") or ("",))[0]).is_loopback
    except ValueError:
        return False
