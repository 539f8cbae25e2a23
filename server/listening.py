"""Where the console listens, who can reach it there, and the address to open."""

from __future__ import annotations

import contextlib
import errno
import ipaddress
import logging
import os
import re
import secrets
import socket
import sys
from collections.abc import Iterable

from .limits import QUEUED_MAX

TOKEN_MIN = 32  # characters: 192 bits as secrets.token_urlsafe writes them
TOKEN = re.compile(rf"[A-Za-z0-9._~-]{{{TOKEN_MIN},256}}")
NOTSENT = 16 * 1024  # bytes waiting in the kernel for a slow client; more, and it sees the past
NOTSENT_OPTION = getattr(socket, "TCP_NOTSENT_LOWAT", 25 if sys.platform == "linux" else None)
HOST_NAME = re.compile(r"(?=.{1,253}(:|$))[A-Za-z0-9]([A-Za-z0-9._-]*[A-Za-z0-9])?(:[0-9]{1,5})?")
ROOT_PATH = re.compile(r"(/[A-Za-z0-9._~@%-]+)*")
SOMEWHERE = ("198.51.100.1", 9)  # nowhere: asks which of our addresses leads out, sends nothing
ANYWHERE = {"0.0.0.0": "127.0.0.1", "::": "[::1]", "": "127.0.0.1"}

log = logging.getLogger(__name__)


class ServeError(ValueError):
    """Why the console cannot be served; the message is one clear line."""


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
        _set_options(listening)
        listening.bind(address)
        listening.listen(QUEUED_MAX)
    except OSError as error:
        listening.close()
        raise _cannot_listen(host, port, error) from None
    listening.setblocking(False)
    return listening


def _set_options(listening: socket.socket) -> None:
    if os.name == "posix":
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    if NOTSENT_OPTION is not None:
        with contextlib.suppress(OSError):
            listening.setsockopt(socket.IPPROTO_TCP, NOTSENT_OPTION, NOTSENT)


def _cannot_listen(host: str, port: int, error: OSError) -> ServeError:
    if error.errno != errno.EADDRINUSE:
        return ServeError(f"cannot listen on {host} port {port}: {error.strerror}")
    return ServeError(
        f"port {port} on {host} is in use; choose another with --port, or --port 0 for any free one"
    )


def is_loopback(host: str) -> bool:
    """True when only this computer can connect."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def check_token(host: str, token: str | None) -> None:
    """Beyond loopback a token is needed, and a short one is none; raises ``ServeError``."""
    if token is not None and not TOKEN.fullmatch(token):
        raise ServeError(
            f"--token must have at least {TOKEN_MIN} characters of A-Z a-z 0-9 . _ ~ -, "
            f"for example {secrets.token_urlsafe(32)}"
        )
    if is_loopback(host):
        return
    if token is None:
        raise ServeError(
            f"--host {host} lets other computers in: "
            f"that needs a --token of at least {TOKEN_MIN} characters"
        )
    log.warning(
        "without TLS everybody on the way can read the token; put a TLS proxy in front of %s", host
    )


def check_viewer_token(token: str | None, viewer: str | None) -> None:
    """One for viewers is beside that of drivers, as long, and another; raises ``ServeError``."""
    if viewer is None:
        return
    if token is None or viewer == token or not TOKEN.fullmatch(viewer):
        raise ServeError(
            f"--viewer-token must have at least {TOKEN_MIN} characters of A-Z a-z 0-9 . _ ~ -, "
            "and needs a --token that is another"
        )


def check_names(allow_host: Iterable[str], root_path: str) -> None:
    """Names and a path that a proxy may bring; raises ``ServeError``."""
    for name in allow_host:
        if not HOST_NAME.fullmatch(name):
            raise ServeError(
                f"--allow-host wants a name such as labserver.example.edu, or NAME:PORT, "
                f"got {name!r:.200}"
            )
    if not ROOT_PATH.fullmatch(root_path) or ".." in root_path.split("/"):
        raise ServeError(f"--root-path wants a path such as /console, got {root_path!r:.200}")


def lan_address() -> str:
    """The address at which this computer's network knows it; raises ``ServeError``."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(SOMEWHERE)
            address = str(probe.getsockname()[0])
        except OSError:
            address = ""
    if not address or is_loopback(address):
        raise ServeError("--lan: this computer is in no network; name an address with --host")
    return address


def own_names(host_name: str) -> tuple[str, ...]:
    """What this computer is called in its network: its name, and that name under ``.local``."""
    return host_name, f"{host_name.split('.')[0]}.local"


def url_of(listening: socket.socket, host: str, token: str | None) -> str:
    """The one address to open."""
    port = listening.getsockname()[1]
    name = ANYWHERE.get(host, f"[{host}]" if ":" in host else host)
    return f"http://{name}:{port}" + (f"/login?token={token}" if token else "")
