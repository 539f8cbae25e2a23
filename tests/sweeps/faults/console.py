"""A console in a process of its own, somebody who watches it, and a hand that drives it."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

DEAD_MAN = 0.5  # s
TICK = 0.02  # s
REPEAT = 0.04  # s between frames of a held stick, as of the page
GIVE_UP = 12.0  # s
Frame = dict[str, Any]


@dataclass
class Console:
    """One that is served: its process, address, data folder and log."""

    process: subprocess.Popen[str]
    url: str
    data: Path
    log: Path

    @property
    def port(self) -> int:
        return int(self.url.rsplit(":", 1)[1])


@contextmanager
def served(*more: str, data: Path | None = None, before: tuple[str, ...] = ()) -> Iterator[Console]:
    """A console with a data folder of its own, ended at the end."""
    with tempfile.TemporaryDirectory() as folder:
        kept = data or Path(folder, "data")
        log = Path(folder, "log")
        words = [*before, sys.executable, "-m", "walking_console", "--no-open", "--port", "0"]
        asked = [*words, "--scenario", "flat", "--data", str(kept), *more]
        with (
            log.open("wb") as errors,
            subprocess.Popen(
                asked, stdout=subprocess.PIPE, stderr=errors, encoding="utf-8", cwd=folder
            ) as process,
        ):
            try:
                assert process.stdout is not None
                yield Console(process, process.stdout.readline().strip(), kept, log)
            finally:
                if process.poll() is None:
                    process.kill()


def ask(url: str, path: str, body: Frame | None = None, method: str = "GET") -> Frame:
    """One request over a connection of its own; raises ``OSError`` for a refusal."""
    words = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(
        f"{url}/api/v1/{path}", words, {"content-type": "application/json"}, method=method
    )
    with urllib.request.urlopen(request, timeout=GIVE_UP) as answer:
        found: Frame = json.load(answer)
        return found


def begin_anew(url: str) -> None:
    """Back to the start, whoever drives just now."""
    for _ in range(20):
        holder = ask(url, "health")["holder"] or ""
        headers = {"x-lease": holder}
        address = f"{url}/api/v1/console/reset"
        request = urllib.request.Request(address, headers=headers, method="POST")
        with suppress(urllib.error.HTTPError):
            urllib.request.urlopen(request, timeout=GIVE_UP).close()
            return
        time.sleep(0.1)
    raise AssertionError("the machine was not reset")


@dataclass
class Seen:
    """A snapshot and when it came."""

    at: float  # s, monotonic
    frame: Frame

    @property
    def rests(self) -> bool:
        """Nothing is asked of the machine."""
        return self.frame["speed_m_s"] == 0.0 and self.frame["turn_rate_rad_s"] == 0.0


class Socket:
    """A WebSocket on /drive whose frames are heard in a thread."""

    def __init__(self, url: str) -> None:
        self.url = url
        self.seen: list[Seen] = []
        self.pongs: list[float] = []  # s there and back
        self.refused: list[Frame] = []
        self.lease: Frame = {}
        self._changed = threading.Condition()
        address = url.replace("http", "ws", 1) + "/drive"
        self.socket: ClientConnection = connect(
            address,
            origin=url,
            compression=None,
            close_timeout=0.2,  # type: ignore[arg-type]
        )
        self._thread = threading.Thread(target=self._hear, daemon=True)
        self._thread.start()
        self.until(lambda: bool(self.seen))

    def __enter__(self) -> Socket:
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()

    def _hear(self) -> None:
        with suppress(ConnectionClosed, OSError):
            for text in self.socket:
                self._take(json.loads(text), time.monotonic())

    def _take(self, frame: Frame, at: float) -> None:
        with self._changed:
            if frame["type"] == "snapshot":
                self.seen.append(Seen(at, frame))
            elif frame["type"] == "pong":
                self.pongs.append(at - frame["sent_ms"] / 1000.0)
            elif frame["type"] == "refused":
                self.refused.append(frame)
            elif frame["type"] == "lease":
                self.lease = frame
            self._changed.notify_all()

    @property
    def newest(self) -> Frame:
        return self.seen[-1].frame

    def until(self, holds: Callable[[], bool], limit: float = GIVE_UP) -> bool:
        """Wait until something holds of what was heard."""
        with self._changed:
            return self._changed.wait_for(holds, limit)

    def seconds_to(self, holds: Callable[[Seen], bool], begun: float) -> float | None:
        """From ``begun`` to the first snapshot after it of which this holds; None: it never
        came.
        """

        def found() -> Seen | None:
            later = (one for one in reversed(self.seen) if one.at >= begun)
            good = [one for one in later if holds(one)]
            return good[-1] if good else None

        self.until(lambda: found() is not None)
        seen = found()
        return None if seen is None else seen.at - begun

    def rest_after(self, begun: float) -> float | None:
        """Seconds until nothing was asked of the machine any more."""
        return self.seconds_to(lambda seen: seen.rests, begun)

    def stays_at_rest(self, seconds: float) -> bool:
        """Whether nothing was asked of the machine meanwhile."""
        begun = time.monotonic()
        time.sleep(seconds)
        return all(seen.rests for seen in self.seen if seen.at > begun)

    def say(self, frame: Frame) -> None:
        with suppress(ConnectionClosed, OSError):
            self.socket.send(json.dumps(frame))

    def ping(self) -> None:
        self.say({"type": "ping", "sent_ms": time.monotonic() * 1000.0})


@dataclass
class Asked:
    """What a hand asks for."""

    speed: float = 0.0
    angle: float = 0.0
    moves_from: float = field(default_factory=time.monotonic)


class Hand(Socket):
    """A driver like the page: repeats what is held, pings, tells the newest tick it has seen."""

    def __init__(self, url: str) -> None:
        super().__init__(url)
        self.asked = Asked()
        self._sequence = 0
        self._ending = threading.Event()
        self._repeating = threading.Thread(target=self._repeat, daemon=True)
        self._repeating.start()

    def __exit__(self, *end: object) -> None:
        self._ending.set()
        super().__exit__(*end)

    def hold(self, speed: float, angle: float = 0.0) -> None:
        """The stick, from now on."""
        self.asked = Asked(speed, angle)
        self.drive()

    def walk(self) -> None:
        """Stick at rest, then ahead, until it walks."""
        self.hold(0.0)
        time.sleep(2 * REPEAT)
        self.hold(0.1)
        self.until(lambda: self.newest["walked_m_s"] > 0.0)

    def drive(self) -> None:
        self._sequence += 1
        self.say(
            {
                "seq": self._sequence,
                "echo_tick": self.newest["tick"],
                "crab_angle_rad": self.asked.angle,
                "speed_m_s": self.asked.speed,
                "turn_rate_rad_s": 0.0,
            }
        )

    def _repeat(self) -> None:
        beats = 0
        while not self._ending.wait(REPEAT):
            self.drive()
            beats += 1
            if beats % 3 == 0:
                self.ping()

    def stop_and_release(self, by_rest: bool) -> float | None:
        """Seconds from a stop to the first picture that says it; then everything is released."""
        begun = time.monotonic()
        if by_rest:
            ask(self.url, "console/stop", method="POST")
        else:
            self.say({"type": "stop"})
        taken = self.seconds_to(lambda seen: bool(seen.frame["stopped"]) and seen.rests, begun)
        self.hold(0.0)
        time.sleep(0.1)
        self.say({"type": "take"})
        self.drive()
        self.say({"type": "rearm"})
        self.until(lambda: not self.newest["stopped"])
        return taken


def refused(url: str, path: str, body: Frame | None = None, method: str = "POST") -> int:
    """The status of a request that is to be refused; 0 where it was not."""
    try:
        ask(url, path, body, method)
    except urllib.error.HTTPError as error:
        return error.code
    return 0
