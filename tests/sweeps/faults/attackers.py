"""Clients that ask for too much; each runs in a process of its own, against this computer only.

Run: python -m tests.sweeps.faults.attackers KIND PORT SECONDS. Prints how much it sent, and how
long each of its connections lived on after it was told its close code.
"""

from __future__ import annotations

import json
import os
import socket
import sys
import time
from collections.abc import Callable
from contextlib import suppress

import viser

KEY = "AAAAAAAAAAAAAAAAAAAAAA=="
PING = b'{"type":"ping","sent_ms":1}'
CLOSE = 0x88  # first byte of a close frame
CYCLE = 20.0  # s one connection may live
MOST = 2000  # new connections a second, of one attacker


class Attack:
    """Where to, until when, and what came of it."""

    def __init__(self, port: int, seconds: float) -> None:
        self.port = port
        self.end = time.monotonic() + seconds
        self.sent = 0
        self.gone: list[float] = []  # s from the close code to the end of the connection

    @property
    def goes_on(self) -> bool:
        return time.monotonic() < self.end

    def connect(self) -> socket.socket:
        made = socket.create_connection(("127.0.0.1", self.port), timeout=5.0)
        made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return made

    def open(self, path: str, protocol: str = "") -> socket.socket:
        """A WebSocket, its handshake answered or not."""
        made = self.connect()
        wanted = f"Sec-WebSocket-Protocol: {protocol}\r\n" if protocol else ""
        made.sendall(
            f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\nConnection: Upgrade\r\n"
            f"Upgrade: websocket\r\nOrigin: http://127.0.0.1:{self.port}\r\n"
            f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {KEY}\r\n{wanted}\r\n".encode()
        )
        return made


def masked(payload: bytes, opcode: int) -> bytes:
    """One frame of a client, of fewer than 126 bytes."""
    mask = os.urandom(4)
    body = bytes(byte ^ mask[k % 4] for k, byte in enumerate(payload))
    return bytes((0x80 | opcode, 0x80 | len(payload))) + mask + body


def flood_socket(attack: Attack, path: str, frame: bytes, protocol: str = "") -> None:
    """Frames as fast as they go, on one connection after the other."""
    many = frame * 50
    while attack.goes_on:
        with suppress(OSError), attack.open(path, protocol) as made:
            told = send_until_gone(attack, made, many)
            if told is not None:
                attack.gone.append(time.monotonic() - told)


def send_until_gone(attack: Attack, made: socket.socket, many: bytes) -> float | None:
    """When the close code came; None where none did. Goes on sending until nothing takes it."""
    made.settimeout(0.5)
    told: float | None = None
    said = Heard()
    ends = time.monotonic() + CYCLE
    while attack.goes_on and time.monotonic() < ends:
        try:
            made.send(many)
            attack.sent += 50
        except TimeoutError:
            pass
        except OSError:
            return told
        heard = read_now(made)
        if heard == b"":
            return told
        said.take(heard or b"")
        if told is None and said.closes:
            told = time.monotonic()
    return None


def read_now(made: socket.socket) -> bytes | None:
    """What has come; None where nothing has, b"" at the end."""
    try:
        return made.recv(65536, socket.MSG_DONTWAIT)
    except BlockingIOError:
        return None
    except OSError:
        return b""


class Heard:
    """What a server says on a WebSocket: the answer to the handshake, then frames."""

    def __init__(self) -> None:
        self.closes = False  # a close frame has come
        self._left = b""
        self._answered = False
        self._skip = 0  # bytes of a frame that are still to come

    def take(self, heard: bytes) -> None:
        """The next bytes."""
        self._left += heard
        if not self._answered:
            head, end, rest = self._left.partition(b"\r\n\r\n")
            self._answered = bool(end)
            self._left = rest if end else head
        while self._answered and self._left:
            passed = min(self._skip, len(self._left))
            self._skip -= passed
            self._left = self._left[passed:]
            if self._skip or not self._frame():
                return

    def _frame(self) -> bool:
        """Begin the next frame; False until its head is whole."""
        if len(self._left) < 2:
            return False
        more = {126: 2, 127: 8}.get(self._left[1], 0)
        head = 2 + more
        if len(self._left) < head:
            return False
        self.closes = self.closes or self._left[0] == CLOSE
        self._skip = int.from_bytes(self._left[2:head], "big") if more else self._left[1]
        self._left = self._left[head:]
        return True


def drive(attack: Attack) -> None:
    flood_socket(attack, "/drive", masked(PING, 1))


def view(attack: Attack) -> None:
    flood_socket(attack, "/view", masked(b"\x81" * 40, 2), f"viser-v{viser.__version__}")


def sockets(attack: Attack) -> None:
    """New WebSockets, each left as soon as it is asked for."""
    while attack.goes_on:
        with suppress(OSError), attack.open("/drive"):
            attack.sent += 1
        time.sleep(1 / MOST)


def http(attack: Attack) -> None:
    """Requests one behind the other, without waiting for answers."""
    request = f"GET /api/v1/console HTTP/1.1\r\nHost: 127.0.0.1:{attack.port}\r\n\r\n".encode()
    while attack.goes_on:
        with suppress(OSError), attack.connect() as made:
            made.settimeout(1.0)
            ends = time.monotonic() + CYCLE
            while attack.goes_on and time.monotonic() < ends:
                made.sendall(request * 10)
                attack.sent += 10
                while read_now(made):
                    pass


def bodies(attack: Attack) -> None:
    """Bodies in chunks of one byte."""
    head = (
        f"PUT /api/v1/console/command HTTP/1.1\r\nHost: 127.0.0.1:{attack.port}\r\n"
        "Content-Type: application/json\r\nTransfer-Encoding: chunked\r\n\r\n"
    ).encode()
    chunks = b"1\r\n \r\n" * 1000
    while attack.goes_on:
        with suppress(OSError), attack.connect() as made:
            made.settimeout(1.0)
            made.sendall(head)
            while attack.goes_on and read_now(made) is None:
                made.sendall(chunks)
                attack.sent += 1000


KINDS: dict[str, Callable[[Attack], None]] = {
    "sockets": sockets,
    "drive": drive,
    "view": view,
    "http": http,
    "bodies": bodies,
}


def main() -> None:
    kind, port, seconds = sys.argv[1:]
    attack = Attack(int(port), min(60.0, float(seconds)))
    KINDS[kind](attack)
    print(json.dumps({"sent": attack.sent, "gone": attack.gone}))


if __name__ == "__main__":
    main()
