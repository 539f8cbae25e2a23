"""Edits of the ground as fast as they are taken, while a hand drives over it."""

from __future__ import annotations

import http.client
import itertools
import json
import math
import threading
import time
from collections.abc import Iterator
from typing import Any

from tests.sweeps.faults.console import Console, Hand, Socket, ask, served
from tests.sweeps.faults.floods import LASTS
from tests.sweeps.faults.table import Fault, Outcome

LATEST_TICK = 0.04  # s
NEAR, FAR = 0.8, 2.5  # m from the machine: the ground that is changed
RADII = (0.05, 0.2)  # m, as of a thin and a wide brush
EDITORS = 2
ACTIONS: tuple[dict[str, Any], ...] = (
    {"action": "raise", "amount_m": 0.03},
    {"action": "dig"},
    {"action": "clear"},
    {"action": "raise", "amount_m": -0.03},
)


def brushed(x: float, y: float, first: int) -> Iterator[dict[str, Any]]:
    """One edit after the other, round about a place."""
    for number in itertools.count(first):
        angle, part = 2.4 * number, (number % 17) / 16
        away = NEAR + part * (FAR - NEAR)
        circle = {
            "x_m": x + away * math.cos(angle),
            "y_m": y + away * math.sin(angle),
            "radius_m": RADII[number % 2],
        }
        yield ACTIONS[number % len(ACTIONS)] | {"circle": circle}


class Editor(threading.Thread):
    """Asks for one edit after the other on a connection of its own, as the driver."""

    def __init__(self, console: Console, hand: Hand, first: int) -> None:
        super().__init__(daemon=True)
        self.port = console.port
        self.headers = {
            "content-type": "application/json",
            "x-lease": ask(console.url, "health")["holder"] or "",
        }
        x, y = hand.newest["body"][:2]
        self.edits = brushed(x, y, first)
        self.answers: dict[int, int] = {}  # how many, by status
        self.end = time.monotonic() + LASTS

    def run(self) -> None:
        made = http.client.HTTPConnection("127.0.0.1", self.port, timeout=10.0)
        while time.monotonic() < self.end:
            body = json.dumps(next(self.edits))
            made.request("PATCH", "/api/v1/console/terrain", body, self.headers)
            with made.getresponse() as answer:
                answer.read()
                self.answers[answer.status] = self.answers.get(answer.status, 0) + 1
        made.close()


def edited(count: int) -> Outcome:
    """A walk on ground that is changed all the while."""
    latest = 0.0
    taken = refused = 0
    for _ in range(count):
        with served() as console, Socket(console.url) as watcher, Hand(console.url) as hand:
            hand.say({"type": "take"})
            hand.walk()
            begun = time.monotonic()
            editors = [Editor(console, hand, 1000 * k) for k in range(EDITORS)]
            for editor in editors:
                editor.start()
            for editor in editors:
                editor.join()
            latest = max(latest, *(s.frame["late_s"] for s in watcher.seen if s.at > begun))
            taken += sum(editor.answers.get(200, 0) for editor in editors)
            refused += sum(sum(editor.answers.values()) for editor in editors)
    refused -= taken
    said = f"latest tick {1000 * latest:.0f} ms; {taken / (count * LASTS):.0f} edits a second"
    if refused:
        said += f", {refused} refused"
    return Outcome(said, latest <= LATEST_TICK and taken > 0)


FAULTS = (
    Fault(
        "edits",
        "ground edited at full rate, stick held",
        f"latest tick ≤ {1000 * LATEST_TICK:.0f} ms",
        edited,
        most=5,
    ),
)
