"""How long a hand waits: from a stick that is pushed to the picture of a machine that moves,
through a server of its own on loopback.

Time on the clock, unlike every other figure of ``bench``: most of it is waiting for the next tick.
"""

from __future__ import annotations

import json
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from typing import Any

from websockets.sync.client import connect
from websockets.sync.connection import Connection

from walking_console.planner.types import TICK

from .child_process import start_child

PRESSES = 100
SPEED = 0.1  # m/s
RESTS = 0.3  # s before a press
# s by which each press falls later in a tick than the one before, so that all of a tick is tried
LATER = 0.37 * TICK
PATIENCE = 10.0  # s
ENDS_WITHIN = 5.0  # s
SERVE = ("--no-open", "--host", "127.0.0.1", "--port", "0", "--scenario", "flat", "--data")

Frame = dict[str, Any]


def figures() -> dict[str, Frame]:
    """Figures for ``bench``: name → {value, unit, target}."""
    waits = sorted(stick_to_motion(PRESSES))
    last = waits[int(0.99 * (len(waits) - 1))]
    return {
        "stick to motion seen, median": _figure(median(waits), "<= 14"),
        "stick to motion seen, p99": _figure(last, "<= 26"),
    }


def _figure(seconds: float, target: str) -> Frame:
    return {"value": round(1e3 * seconds, 2), "unit": "ms on the clock", "target": target}


def stick_to_motion(presses: int) -> list[float]:
    """s from each push of the stick, let go between, to the first picture of a body that has moved.
    Raises ``TimeoutError`` for a server that does not answer.
    """
    with served() as url:
        address = url.replace("http", "ws", 1) + "/drive"
        with connect(address, origin=url, compression=None) as socket:  # type: ignore[arg-type]
            hand = _Hand(socket)
            return [hand.press(LATER * number % TICK) for number in range(presses)]


@contextmanager
def served() -> Iterator[str]:
    """The address of a console on level ground, in a process and data folder of its own."""
    with (
        tempfile.TemporaryDirectory() as folder,
        start_child([*SERVE, folder], Path(folder), subprocess.PIPE, in_background=False) as child,
    ):
        try:
            assert child.stdout is not None
            yield child.stdout.readline().decode().strip()
        finally:
            child.terminate()
            try:
                child.wait(ENDS_WITHIN)
            except subprocess.TimeoutExpired:
                child.kill()


class _Hand:
    """One that drives by a socket, and sees what comes back."""

    def __init__(self, socket: Connection) -> None:
        self._socket = socket
        self._sequence = 0
        self._seen = self._picture()

    def press(self, after: float) -> float:
        """Rest, and so many seconds after a picture push; s until the body has moved."""
        self._rest()
        time.sleep(after)
        stood = self._seen["body"]
        began = time.monotonic()
        self._say(SPEED)
        while self._picture()["body"] == stood:
            pass
        return time.monotonic() - began

    def _rest(self) -> None:
        until = time.monotonic() + RESTS
        while time.monotonic() < until or self._seen["walked_m_s"] > 0.0:
            self._say(0.0)
            self._picture()

    def _say(self, speed: float) -> None:
        self._sequence += 1
        frame = {
            "type": "drive",
            "seq": self._sequence,
            "echo_tick": self._seen["tick"],
            "crab_angle_rad": 0.0,
            "speed_m_s": speed,
            "turn_rate_rad_s": 0.0,
        }
        self._socket.send(json.dumps(frame))

    def _picture(self) -> Frame:
        """The next snapshot."""
        while True:
            frame: Frame = json.loads(self._socket.recv(PATIENCE))
            if frame["type"] == "snapshot":
                self._seen = frame
                return frame
