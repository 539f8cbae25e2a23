"""What every request and every WebSocket must show before a route sees it.

Host: loopback names and what was configured (against DNS rebinding). Origin: our own for everything
that changes something, for the interface and for every WebSocket, which no browser guards by
itself. Token, if there is one. A body: at most ``BODY_MAX``, in time. Errors leave as problem+json.
"""

from __future__ import annotations

import asyncio
import ipaddress
import logging
import math
import re
from collections.abc import Iterable
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from .json_shape import fault_of
from .lease_reasons import TEXTS, LeaseReason
from .limits import BODY_MAX, BODY_TIME, UPLOAD_TIME
from .problems import problem
from .tokens import WATCHES, Guesses, Role, Tokens
from .uploads import UPLOAD_MAX

API = "/api/"
UPLOADS = "/api/v1/uploads/"  # where files come in, which are larger and may take
FORM_HEAD = 4096  # bytes a form has around its file
LOOPBACK = ("localhost", "127.0.0.1", "::1")
SAFE_METHODS = ("GET", "HEAD", "OPTIONS")
COOKIE = "walking-console-token"
LOGIN = "/login"  # the one page that takes the token itself
STOP = "/api/v1/console/stop"  # anybody who has a token may, whatever else is refused

TOKEN_NEEDED = "a token is needed: open the printed address, or send 'Authorization: Bearer TOKEN'"
WATCHING = TEXTS[LeaseReason.WATCHES]

SECURITY_HEADERS = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "content-security-policy": "default-src 'none'; frame-ancestors 'none'",
}


log = logging.getLogger(__name__)


HOST = re.compile(r"(?:\[([0-9a-f:.%]+)\]|([^\[\]:]+?)\.?)(?::[0-9]{1,5})?")


def host_name(host: str) -> str:
    """``name`` of ``name:port``, ``[v6]:port`` or ``name``, in lower case; '' where it is none of
    them from its first letter to its last.
    """
    whole = HOST.fullmatch(host.strip().lower())
    return (whole[1] or whole[2]) if whole else ""


def is_address(name: str) -> bool:
    """True for an IP address: a rebound name can never be one."""
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


class RequestGuard:
    """ASGI middleware; ``addresses`` also lets any IP address be the Host (for a console that
    listens beyond loopback). ``authorities`` are NAME or NAME:PORT of proxies before the console:
    their pages are its own, also where the proxy writes another Host.
    """

    def __init__(
        self,
        app: ASGIApp,
        hosts: Iterable[str] = (),
        token: str | None = None,
        addresses: bool = False,
        authorities: Iterable[str] = (),
        viewer_token: str | None = None,
    ) -> None:
        self._app = app
        own = frozenset(name.lower() for name in authorities)
        self._hosts = frozenset((*LOOPBACK, *map(str.lower, hosts), *map(host_name, own)))
        self._authorities = own
        self._tokens = Tokens(token, viewer_token)
        self._guesses = Guesses()
        self._addresses = addresses

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
                refusal = _misshapen(scope, body)
                receive = _replay(body, receive)
        if refusal is not None:
            log.info("%.200r refused with %d", scope["path"], refusal.status_code)
        await (refusal or self._app)(scope, receive, send)

    def _refusal(self, scope: Scope) -> Response | None:
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if len(headers.getlist("host")) != 1 or not self._answers_for(host_name(host)):
            return problem(403, f"this console does not answer for Host {host[:100]!r}")
        if _is_guarded(scope, headers):
            why = _foreign(headers, {host.strip().lower(), *self._authorities})
            if why:
                return problem(403, why)
        return None if self._tokens.driver is None else self._token_refusal(scope, headers)

    def _token_refusal(self, scope: Scope, headers: Headers) -> Response | None:
        address = str((scope.get("client") or ("",))[0])
        wait = self._guesses.wait(address)
        if wait > 0.0 and _route(scope) != STOP:
            said = f"too many wrong tokens from {address}: wait {math.ceil(wait)} s"
            return problem(429, said, headers={"retry-after": str(math.ceil(wait))})
        shown = _shown(scope, headers)
        role = self._tokens.role_of(shown)
        if shown:
            self._guesses.note(address, role)
        if role is None:
            return problem(401, TOKEN_NEEDED)
        if role is Role.VIEWER:
            scope[WATCHES] = True
        return problem(403, WATCHING) if role is Role.VIEWER and _changes(scope) else None

    def _answers_for(self, name: str) -> bool:
        return name in self._hosts or (self._addresses and is_address(name))


def _is_guarded(scope: Scope, headers: Headers) -> bool:
    """Whether only our own pages may ask for it: what changes something, every socket, and the
    interface, whose answers may be dear, unless a person follows a link to it.
    """
    if scope["type"] == "websocket" or scope["method"] not in SAFE_METHODS:
        return True
    return _route(scope).startswith(API) and headers.get("sec-fetch-user") != "?1"


def _changes(scope: Scope) -> bool:
    """Whether a request changes anything, but for a stop; sockets see to it themselves."""
    if scope["type"] == "websocket" or scope["method"] in SAFE_METHODS:
        return False
    return _route(scope) != STOP


def _shown(scope: Scope, headers: Headers) -> str:
    """The token of a request; '' where it brings none."""
    if scope["type"] == "http" and _route(scope) == LOGIN:
        text: bytes = scope["query_string"]
        try:
            query = parse_qs(text.decode("latin-1"), max_num_fields=10)
        except ValueError:
            return ""  # too many
        return query.get("token", [""])[-1]
    return headers.get("authorization", "").removeprefix("Bearer ") or _from_cookie(headers)


def _route(scope: Scope) -> str:
    """The path below the prefix that a proxy gives the console."""
    return str(scope["path"]).removeprefix(scope.get("root_path", ""))


def _from_cookie(headers: Headers) -> str:
    try:
        cookie = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
    except CookieError:
        return ""
    return cookie.value if cookie else ""


def _foreign(headers: Headers, authorities: Iterable[str]) -> str:
    """Why a request comes from a foreign page, or '' when it is our own page's or no browser's."""
    origins = headers.getlist("origin")
    if origins:
        own = {f"{scheme}://{name}" for scheme in ("http", "https") for name in authorities}
        if len(origins) == 1 and origins[0].lower() in own:
            return ""
        return f"Origin {origins[0][:100]!r} is not this console"
    site = headers.get("sec-fetch-site", "none")
    return "" if site in ("same-origin", "none") else f"a {site[:20]} page may not do this"


async def _whole_body(scope: Scope, receive: Receive) -> bytes | Response:
    """The body, or the refusal of one that is too long or too slow."""
    limit, time = _limits(scope)
    declared = Headers(scope=scope).get("content-length", "0")
    if not declared.isdigit() or int(declared[:18]) > limit:
        return _too_long(limit)
    try:
        async with asyncio.timeout(time):
            return await _gathered(receive, limit)
    except TimeoutError:
        return problem(408, f"a body may take {time:g} s", headers={"connection": "close"})


def _misshapen(scope: Scope, body: bytes) -> Response | None:
    """The refusal of JSON that no reader should have to bear."""
    if body.lstrip()[:1] not in (b"{", b"[") or f"{_route(scope)}/".startswith(UPLOADS):
        return None
    fault = fault_of(body)
    return problem(422, fault) if fault else None


def _limits(scope: Scope) -> tuple[int, float]:
    """How many bytes a body may have, and how long it may take."""
    if scope["method"] in ("PUT", "POST") and f"{_route(scope)}/".startswith(UPLOADS):
        return UPLOAD_MAX + FORM_HEAD, UPLOAD_TIME
    return BODY_MAX, BODY_TIME


async def _gathered(receive: Receive, limit: int) -> bytes | Response:
    """Every part of the body, as long as it stays within its limit."""
    body = bytearray()
    while True:
        message = await receive()
        if message["type"] == "http.disconnect":
            return problem(400, "the body broke off")
        part: bytes = message.get("body", b"")
        body += part
        if len(body) > limit:
            return _too_long(limit)
        if not message.get("more_body", False):
            return bytes(body)


def _too_long(limit: int) -> Response:
    return problem(413, f"a body may have {limit} bytes", headers={"connection": "close"})


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
        await send(message)

    return guarded
