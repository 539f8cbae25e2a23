"""The door: what every request and every WebSocket must show before a route sees it.

Host: loopback names and what was configured (against DNS rebinding). Origin: our own for everything
that changes something and for every WebSocket, which no browser guards by itself. Token, if there
is one. A body: at most ``BODY_MAX``, in time. Errors leave as problem+json.
"""

from __future__ import annotations

import asyncio
import hmac
import ipaddress
import json
import math
from collections.abc import Iterable, Sequence
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from typing import Any

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

BODY_MAX = 1024 * 1024  # bytes
BODY_TIME = 10.0  # s a body may take
LOOPBACK = ("localhost", "127.0.0.1", "::1")
SAFE_METHODS = ("GET", "HEAD", "OPTIONS")
COOKIE = "walking-console-token"
VALUE_SHOWN = 200  # characters of a refused value that are said back

SECURITY_HEADERS = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
}


def problem(
    status: int,
    detail: str,
    errors: Sequence[dict[str, Any]] = (),
    headers: dict[str, str] | None = None,
) -> Response:
    """A refusal as problem+json; the first of ``errors`` (field, value, limit, message) also stands
    at the top.
    """
    try:
        title = HTTPStatus(status).phrase
    except ValueError:
        title = "Error"
    body: dict[str, Any] = {
        "type": "about:blank",
        "title": title,
        "status": status,
        "detail": detail,
    }
    if errors:
        body |= {key: sayable(errors[0].get(key)) for key in ("field", "value", "limit")}
        body["errors"] = [
            {key: sayable(value) for key, value in error.items()} for error in errors[:20]
        ]
    return Response(json.dumps(body), status, headers, media_type="application/problem+json")


def sayable(value: Any) -> Any:
    """A value as JSON can carry it: small, finite, or said in words."""
    if value is None or isinstance(value, bool | int):
        return (
            value if not isinstance(value, int) or abs(value) < 2**63 else str(value)[:VALUE_SHOWN]
        )
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, str):
        return value[:VALUE_SHOWN].encode("utf-8", "replace").decode()
    if (
        isinstance(value, dict)
        and len(value) <= 8
        and all(isinstance(item, str | int | float) for item in value.values())
    ):
        return {str(key)[:40]: sayable(item) for key, item in value.items()}
    try:
        return repr(value)[:VALUE_SHOWN]
    except RecursionError:
        return "nested too deeply to show"


def host_name(host: str) -> str:
    """``name`` of ``name:port``, ``[v6]:port`` or ``name``, in lower case."""
    host = host.strip().lower()
    if host.startswith("["):
        return host[1 : host.find("]")] if "]" in host else ""
    return host.rsplit(":", 1)[0] if host.count(":") == 1 else host


def is_address(name: str) -> bool:
    """True for an IP address: a rebound name can never be one."""
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


class Door:
    """ASGI middleware; ``addresses`` also lets any IP address be the Host (for a console that
    listens beyond loopback).
    """

    def __init__(
        self,
        app: ASGIApp,
        hosts: Iterable[str] = (),
        token: str | None = None,
        addresses: bool = False,
    ) -> None:
        self._app = app
        self._hosts = frozenset((*LOOPBACK, *(host.lower() for host in hosts)))
        self._token, self._addresses = token, addresses

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        send = _with_security_headers(send)
        refusal = self._refusal(scope)
        if refusal is None and scope["type"] == "http":
            body = await _whole_body(scope, receive)
            if isinstance(body, Response):
                refusal = body
            else:
                receive = _replay(body, receive)
        await (refusal or self._app)(scope, receive, send)

    def _refusal(self, scope: Scope) -> Response | None:
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        name = host_name(host)
        if len(headers.getlist("host")) != 1 or not (
            name in self._hosts or (self._addresses and is_address(name))
        ):
            return problem(403, f"this console does not answer for Host {host[:100]!r}")
        if scope["type"] == "websocket" or scope["method"] not in SAFE_METHODS:
            why = _foreign(headers, host)
            if why:
                return problem(403, why)
        if self._token is not None and not self._shown(headers, scope):
            return problem(
                401,
                "a token is needed: open the printed address, or send 'Authorization: Bearer TOKEN'",
            )
        return None

    def _shown(self, headers: Headers, scope: Scope) -> bool:
        assert self._token is not None
        shown = headers.get("authorization", "").removeprefix("Bearer ")
        if not shown:
            try:
                cookie = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
            except CookieError:
                cookie = None
            shown = cookie.value if cookie else ""
        # the one page that takes the token itself
        if scope["type"] == "http" and scope["path"] == "/login":
            return True
        return hmac.compare_digest(shown.encode("utf-8", "replace"), self._token.encode())


def _foreign(headers: Headers, host: str) -> str:
    """Why a request comes from a foreign page, or '' when it is our own page's or no browser's."""
    origins = headers.getlist("origin")
    if origins:
        own = {f"{scheme}://{host.strip().lower()}" for scheme in ("http", "https")}
        return (
            ""
            if len(origins) == 1 and origins[0].lower() in own
            else f"Origin {origins[0][:100]!r} is not this console"
        )
    site = headers.get("sec-fetch-site", "none")
    return "" if site in ("same-origin", "none") else f"a {site[:20]} page may not do this"


async def _whole_body(scope: Scope, receive: Receive) -> bytes | Response:
    """The body, or the refusal of one that is too long or too slow."""
    too_long = problem(413, f"a body may have {BODY_MAX} bytes", headers={"connection": "close"})
    declared = Headers(scope=scope).get("content-length", "0")
    if not declared.isdigit() or int(declared[:18]) > BODY_MAX:
        return too_long
    body, more = b"", True
    try:
        async with asyncio.timeout(BODY_TIME):
            while more:
                message = await receive()
                if message["type"] == "http.disconnect":
                    return problem(400, "the body broke off")
                body, more = body + message.get("body", b""), message.get("more_body", False)
                if len(body) > BODY_MAX:
                    return too_long
    except TimeoutError:
        return problem(408, f"a body may take {BODY_TIME:g} s", headers={"connection": "close"})
    return body


def _replay(body: bytes, receive: Receive) -> Receive:
    """Hand the body on once, then what comes after it."""
    waiting: list[Message] = [{"type": "http.request", "body": body, "more_body": False}]

    async def replayed() -> Message:
        return waiting.pop() if waiting else await receive()

    return replayed


def _with_security_headers(send: Send) -> Send:
    async def guarded(message: Message) -> None:
        if message["type"] in ("http.response.start", "websocket.http.response.start"):
            headers = MutableHeaders(scope=message)
            for name, value in SECURITY_HEADERS.items():
                headers.setdefault(name, value)
            headers.setdefault(
                "content-security-policy", "default-src 'none'; frame-ancestors 'none'"
            )
        await send(message)

    return guarded
