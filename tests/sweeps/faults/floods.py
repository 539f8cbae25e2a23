"""Floods of four clients, and connections that say nothing or hear nothing."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field

from tests.sweeps.faults.attackers import KINDS, Attack
from tests.sweeps.faults.console import Console, Hand, Socket, ask, served
from tests.sweeps.faults.table import Fault, Outcome, share

CLIENTS = 4
LASTS = 12.0  # s
STOPS_EVERY = 1.0  # s
LATEST_TICK, ROUND_TRIP, STOP, GONE = 0.02, 0.15, 0.1, 0.5  # s
SILENT = 1100
DESCRIPTORS = 1024
STUCK = 32
LOG_MAX = 1_000_000  # bytes
OPEN_WITHIN = 5.0  # s


@contextmanager
def attacked(kind: str, port: int) -> Iterator[list[subprocess.Popen[str]]]:
    """Four attackers, from now on."""
    words = [sys.executable, "-m", "tests.sweeps.faults.attackers", kind, str(port), str(LASTS)]
    many = [subprocess.Popen(words, stdout=subprocess.PIPE, text=True) for _ in range(CLIENTS)]
    try:
        yield many
    finally:
        for one in many:
            if one.poll() is None:
                one.kill()


@dataclass
class Borne:
    """What a victim met with."""

    latest: float = 0.0  # s, tick
    trips: list[float] = field(default_factory=list)  # s
    stops: list[float] = field(default_factory=list)  # s
    lost: int = 0  # stops that never came


def bear(console: Console, hand: Hand, watcher: Socket) -> Borne:
    """Drive and stop while the flood lasts."""
    borne = Borne()
    begun = time.monotonic()
    hand.pongs.clear()
    while time.monotonic() < begun + LASTS - 1.0:
        hand.walk()
        time.sleep(STOPS_EVERY)
        taken = hand.stop_and_release(by_rest=len(borne.stops) % 2 == 1)
        borne.lost += taken is None
        borne.stops.append(taken if taken is not None else LASTS)
    borne.latest = max(seen.frame["late_s"] for seen in watcher.seen if seen.at > begun)
    borne.trips = hand.pongs[:]
    return borne


def flood(kind: str) -> Callable[[int], Outcome]:
    """Floods of one kind, each ``LASTS`` s long."""

    def trials(count: int) -> Outcome:
        all_borne: list[Borne] = []
        gone: list[float] = []
        for _ in range(count):
            with served() as console, Socket(console.url) as watcher, Hand(console.url) as hand:
                hand.say({"type": "take"})
                with attacked(kind, console.port) as attackers:
                    time.sleep(1.5)  # until they have begun
                    all_borne.append(bear(console, hand, watcher))
                    for one in attackers:
                        gone += json.loads(one.communicate(timeout=30)[0])["gone"]
        return judged(all_borne, gone)

    return trials


def judged(all_borne: list[Borne], gone: list[float]) -> Outcome:
    latest = max(borne.latest for borne in all_borne)
    trip = share([trip for borne in all_borne for trip in borne.trips], 0.99)
    stops = [stop for borne in all_borne for stop in borne.stops]
    said = [
        f"latest tick {1000 * latest:.0f} ms",
        f"round trip p99 {1000 * trip:.0f} ms",
        f"stop worst {1000 * max(stops):.0f} ms of {len(stops)}",
    ]
    held = latest <= LATEST_TICK and trip <= ROUND_TRIP and max(stops) <= STOP
    if gone:
        said.append(f"gone {1000 * max(gone):.0f} ms after the close code at most, of {len(gone)}")
        held = held and max(gone) <= GONE
    return Outcome("; ".join(said), held)


def silent(count: int) -> Outcome:
    """More silent connections than descriptors, half of them with half a request."""
    stops: list[float] = []
    before = ("sh", "-c", f'ulimit -n {DESCRIPTORS} && exec "$0" "$@"')
    raise_own_descriptors()
    with served(before=before) as console, Socket(console.url) as watcher, ExitStack() as stack:
        begun = time.monotonic()
        threading.Thread(target=connect_silently, args=(console.port, stack), daemon=True).start()
        for _ in range(count):
            at = time.monotonic()
            with suppress(OSError):
                ask(console.url, "console/stop", method="POST")
                stops.append(time.monotonic() - at)
            time.sleep(0.3)
        lasted = time.monotonic() - begun
        log = console.log.stat().st_size
        latest = max(seen.frame["late_s"] for seen in watcher.seen if seen.at > begun)
    worst = max(stops, default=float("inf"))
    said = (
        f"{len(stops)} of {count} stops; worst {1000 * worst:.0f} ms; "
        f"log {log / 1000:.0f} kB in {lasted:.0f} s; latest tick {1000 * latest:.0f} ms"
    )
    return Outcome(said, len(stops) == count and worst <= STOP and log <= LOG_MAX)


def raise_own_descriptors() -> None:
    import resource

    most = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(most, 4096), most))


def connect_silently(port: int, stack: ExitStack) -> None:
    """Over and over, as fast as it is taken, until the test is over."""
    for number in range(SILENT):
        with suppress(OSError):
            made = stack.enter_context(socket.create_connection(("127.0.0.1", port)))
            if number % 2:
                made.sendall(b"PUT /api/v1/console/command HTTP/1.1\r\nHost: 127.0.0.1\r\nConte")


def stuck(count: int) -> Outcome:
    """All places of drivers taken by sockets that never read: when is one open for the next?"""
    taken: list[float] = []
    for _ in range(count):
        with served() as console, ExitStack() as stack:
            attack = Attack(console.port, 60.0)
            for _ in range(STUCK):
                made = stack.enter_context(attack.open("/drive"))
                made.recv(12)
            begun = time.monotonic()
            while time.monotonic() < begun + 30.0:
                with suppress(Exception), Socket(console.url):
                    break
                time.sleep(0.1)
            taken.append(time.monotonic() - begun)
    said = f"open after {max(taken):.1f} s at most, of {count}"
    return Outcome(said, max(taken) <= OPEN_WITHIN)


FLOODED = (
    f"latest tick ≤ {1000 * LATEST_TICK:.0f} ms, round trip p99 ≤ {1000 * ROUND_TRIP:.0f} ms, "
    f"stop ≤ {1000 * STOP:.0f} ms, connection gone ≤ {GONE} s after its close code"
)
NAMES = {
    "sockets": "new sockets",
    "drive": "frames on /drive",
    "view": "frames on /view",
    "http": "requests",
    "bodies": "bodies in chunks of one byte",
}
FAULTS = (
    *(
        Fault(f"flood-{kind}", f"four clients flood: {NAMES[kind]}", FLOODED, flood(kind), most=5)
        for kind in KINDS
    ),
    Fault(
        "silent",
        f"{SILENT} silent connections at {DESCRIPTORS} descriptors",
        f"stop ≤ {1000 * STOP:.0f} ms, log ≤ 1 MB",
        silent,
    ),
    Fault(
        "stuck",
        f"{STUCK} sockets on /drive that never read",
        f"open for the next within {OPEN_WITHIN:.0f} s",
        stuck,
        most=5,
    ),
)
